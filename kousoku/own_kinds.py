"""Kinds of one's own for scenes: derivations, kernels or their folders as types of joints."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

from kousoku.model.errors import DerivationError
from kousoku.runtime.messages import shown

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from os import PathLike

    from kousoku.model.operations.kernel import Package
    from kousoku.model.records.own_kind import OwnKind
    from kousoku.runtime.library import Library
    from kousoku.symbolic.derivation import Derivation

    Kind = Derivation | Library | str | PathLike[str]

#: Derivations whose frozen kernels are remembered.
REMEMBERED = 32


def own_kinds(kinds: Sequence[Kind] | None) -> Mapping[str, OwnKind]:
    """Kinds of one's own by their names, which are types of joints.

    Parameters
    ----------
    kinds : sequence of Derivation, Library or path
        What :func:`kousoku.derive` or :func:`kousoku.kernels` gave, or a folder that it wrote.

    Raises
    ------
    DerivationError
        One is no constraint between two bodies, or its proof fails, or two have one name.
    LoadError
        A folder holds no kernels, or is damaged.
    """
    if kinds is None:
        return {}
    if not isinstance(kinds, list | tuple):
        raise DerivationError(f"kinds: {shown(kinds)} is no list; wanted one, such as kinds=[mine]")
    from kousoku.codegen.dynamics.own_kinds import own_kind_of

    by_name: dict[str, OwnKind] = {}
    for source in kinds:
        package = _package(source)
        kind = own_kind_of(package)
        if by_name.setdefault(package.name, kind) != kind:
            raise DerivationError(
                f"kinds: two kinds are called {package.name}; wanted a name of its own for each"
            )
    return by_name


def _package(kind: object) -> Package:
    """Frozen kernels of a kind."""
    from os import PathLike

    from kousoku.runtime.library import Library, load
    from kousoku.symbolic.derivation import Derivation

    if isinstance(kind, Derivation):
        return _frozen(kind)
    if isinstance(kind, str | PathLike):
        kind = load(Path(kind), target="numpy")
    if not isinstance(kind, Library):
        raise DerivationError(
            f"kinds: {shown(kind)} is no kind; wanted what kousoku.derive or kousoku.kernels gave,"
            " or the folder of kernels"
        )
    return _of_library(kind)


def _of_library(library: Library) -> Package:
    """Package that the files of a library are made of."""
    from kousoku.codegen.kernel_json import GRAPH_FILE, parse

    if GRAPH_FILE not in library.files:
        raise DerivationError(
            f"kinds: the kernels of {library.manifest.package} have no {GRAPH_FILE}, which joints"
            " are made of; derive it again"
        )
    return parse(library.files[GRAPH_FILE].decode())


@lru_cache(maxsize=REMEMBERED)
def _frozen(derivation: Derivation) -> Package:
    from kousoku.codegen.derived import frozen_package
    from kousoku.codegen.generate import require_proved

    require_proved(derivation)
    return frozen_package(derivation, "")
