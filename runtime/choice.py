"""Choice of the target that computes: C where it can be had, else NumPy after saying why."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, TypeVar

from kousoku.model.errors import CacheError, NoCompilerError, TargetError
from kousoku.runtime.messages import shown

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.runtime.sources import Sources

Target = Literal["auto", "c", "numpy"]
ChosenTarget = Literal["c", "numpy"]
Loaded = TypeVar("Loaded")


def choose(
    target: Target,
    sources: Sources,
    in_c: tuple[str, Callable[[], Loaded]],
    in_numpy: tuple[str, Callable[[Exception | None], Loaded]],
) -> Loaded:
    """Load a folder with the target that is asked for, or that can be had.

    Parameters
    ----------
    target : {"auto", "c", "numpy"}
        ``"auto"`` takes C where a compiler can be had, and else NumPy.
    sources : Sources
        The files of the folder.
    in_c : (str, callable)
        The source in C, and what loads it.
    in_numpy : (str, callable)
        The source in Python, and what loads it: it gets the reason if C was tried first, and says
        so in one line on the logger ``kousoku``.

    Raises
    ------
    TargetError
        There is no such target, or the folder was generated without this target.
    CompilerError
        The compiler refuses the source; with ``target="c"`` also if there is none.
    CacheError
        With ``target="c"``: neither the cache nor a temporary folder can be written.
    """
    if target not in ("auto", "c", "numpy"):
        raise TargetError(f"target: got {shown(target)}, wanted 'auto', 'c' or 'numpy'")
    c_source, numpy_source, files = in_c[0], in_numpy[0], sources.files
    if target == "numpy" or (target == "auto" and c_source not in files):
        if numpy_source not in files:
            raise TargetError(
                f"{sources.folder} was generated without NumPy: {numpy_source} is not listed"
            )
        return in_numpy[1](None)
    if c_source not in files:
        raise TargetError(f"{sources.folder} was generated without C: {c_source} is not listed")
    try:
        return in_c[1]()
    except (NoCompilerError, CacheError) as error:
        if target == "c" or numpy_source not in files:
            raise
        return in_numpy[1](error)
