"""Deriving from Python: a kind by its name, or a constraint of one's own, up to its kernels."""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:
    from kousoku.runtime import Library
    from kousoku.runtime.choice import Target
    from kousoku.symbolic.derivation import Derivation
    from kousoku.symbolic.vectors import Body, Number, Vector

__all__ = ["body", "derive", "kernels", "number"]


def derive(
    name: str,
    *,
    C: Number | Vector | list[Any] | tuple[Any, ...] | None = None,
    title: str = "",
    source: str = "",
) -> Derivation:
    """Derive a kind that kousoku has, or the constraint C = 0 between bodies i and j.

    Parameters
    ----------
    name : str
        A kind by any of its names (``p2``, ``p2_x``, ``INLINE``); of a kind with variants the last.
        With `C`, a name of your own.
    C : Number, Vector, or a sequence of them, optional
        An expression in the vectors of ``body("i")``, ``body("j")`` and in numbers; of several the
        rows stand one below the other. A length in m, or without unit.
    title, source : str
        With `C`, what it is in one line, and where it stands; for the generated files.

    Returns
    -------
    Derivation
        Its steps, and C, C_q, ν, γ, reaction and its derivative on both levels.

    Raises
    ------
    DerivationError
        No kind has this name, or of one's own it is none or taken, or C cannot be derived; the
        message says what is wrong.

    Examples
    --------
    >>> from kousoku.deriving import body, derive, number
    >>> i, j = body("i"), body("j")
    >>> derive("slant", C=i.axis().dot(j.axis()) - number("cos_theta")).C_q.shape
    (1, 12)
    """
    if C is None:
        from kousoku.symbolic import derive as derive_kind

        return derive_kind(name)
    from kousoku.symbolic.check import require_own_name
    from kousoku.symbolic.constraint import derive_constraint
    from kousoku.symbolic.vectors import constraint_of

    require_own_name(name)

    constraint = constraint_of(name, C, title=title, source=source)
    for row, value in enumerate(constraint.components):
        _require_varies(name, row, value.free_symbols)
    derivation = derive_constraint(constraint)
    for row, derivatives in enumerate(derivation.C_q.tolist()):
        _require_varies(name, row, any(derivatives))
    return derivation


def _require_varies(name: str, row: int, varying: object) -> None:
    """Refuse a row of a constraint of one's own in which nothing varies."""
    from kousoku.model.errors import DerivationError

    if not varying:
        raise DerivationError(
            f"{name}: row {row} of C constrains nothing: its row of C_q is zero wherever the"
            " bodies are; wanted vectors of body('i') or body('j') that vary against each"
            " other, or against the ground"
        )


def body(name: Literal["i", "j"]) -> Body:
    """Body i or j, whose vectors a constraint of one's own is stated in.

    ``body.r``, ``body.A``, ``body.a_b`` and ``body.s_b`` are the lecture's r, A, a′ and s′.
    ``body.axis("b")`` is A b′ and ``body.point("t")`` is r + A t′, of axes and points of any name.
    """
    from kousoku.symbolic.vectors import body as body_of

    return body_of(name)


def number(name: str, unit: Literal["-", "rad", "m"] = "-", meaning: str = "") -> Number:
    """Given number, constant in time, for a constraint of one's own.

    Parameters
    ----------
    name : str
        What the input of the kernels is called, e.g. ``cos_theta``.
    unit : {"-", "rad", "m"}
        Its unit.
    meaning : str
        What it is, in a few words, for the generated files.
    """
    from kousoku.symbolic.vectors import number as number_named

    return number_named(name, unit, meaning)


def kernels(
    derivation: Derivation | str | PathLike[str],
    folder: str | PathLike[str] | None = None,
    *,
    target: Target = "auto",
) -> Library:
    """Kernels of a derivation: proved, frozen, emitted with references, and loaded.

    Parameters
    ----------
    derivation : Derivation, str or path
        What :func:`derive` gives; a name stands for the kernels that come with kousoku, any other
        path for a folder that was written before.
    folder : path, optional
        Where they are written: C, NumPy and 50-digit references. When left out they are kept in the
        user's cache, each content in a folder of its own.
    target : {"auto", "c", "numpy"}
        What computes.

    Returns
    -------
    Library
        ``library.constraint(...)`` calls a kernel; ``library.folder`` is where they lie;
        ``kousoku.runtime.verify(library)`` compares them with their references.

    Raises
    ------
    DerivationError
        The proof fails, or a name is taken; the message says which.
    FreezeError
        An expression cannot be emitted.
    """
    from kousoku.codegen.generate import generate, package_of, write_tree
    from kousoku.model.errors import DerivationError
    from kousoku.model.files.cache import cache_folder
    from kousoku.model.files.manifest import MANIFEST_FILE, Manifest
    from kousoku.runtime import load

    if isinstance(derivation, PathLike):
        return load(Path(derivation), target=target)
    if isinstance(derivation, str):
        import kousoku.generated.kinds as committed

        try:
            folder = Path(committed.__path__[0]) / package_of(derivation)
        except DerivationError:
            folder = Path(derivation)
            if not folder.is_dir():
                raise
        return load(folder, target=target)
    from kousoku.runtime.messages import shown
    from kousoku.symbolic.derivation import Derivation

    if not isinstance(derivation, Derivation):
        raise DerivationError(
            f"{shown(derivation)} is no derivation; wanted what derive returned, the name of a"
            " kind, or the path of a folder that kernels wrote"
        )
    tree = generate(derivation)
    if folder is None:
        digest = Manifest.from_json(tree[MANIFEST_FILE]).digest
        folder = cache_folder() / "kernels" / digest[:32] / derivation.name
    path = Path(folder)
    write_tree(path, tree)
    return load(path, target=target)
