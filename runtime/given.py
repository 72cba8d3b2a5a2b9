"""What a caller gives: refused in one line where it is not what is wanted."""

from __future__ import annotations

import os
from numbers import Integral, Real
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from kousoku.model.errors import LoadError, SolveError
from kousoku.runtime.integrate.result import shown, unknown

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    import numpy.typing as npt

    Array = npt.NDArray[np.float64]

__all__ = ["shown", "unknown"]

#: Times that a motion may have; more rows fit into no memory.
MOST_ROWS = 10**9


def require_options(
    scene: str, given: Mapping[str, object], options: Sequence[str], *also: str
) -> None:
    """Refuse options that there are not.

    Parameters
    ----------
    scene : str
        What moves.
    given : mapping of str to object
        The options.
    options : sequence of str
        Those that there are.
    *also : str
        What else the call takes.

    Raises
    ------
    SolveError
        The message says which name is nearest.
    """
    for name in given:
        if name not in options:
            raise SolveError(f"{scene}: {unknown('option', name, (*also, *options))}")


def folder_of(given: object) -> Path:
    """Return the absolute path of a folder.

    Raises
    ------
    LoadError
        What is given is no path.
    """
    if not isinstance(given, str | os.PathLike):
        raise LoadError(f"{shown(given)} is no folder; wanted the path of one")
    if "\0" in str(given):
        raise LoadError(f"{shown(given)} is not the name of a folder: it has a null character")
    return Path(given).absolute()


def require_numbers(
    scene: str, *, is_whole: bool = False, least: int | None = None, **given: object
) -> None:
    """Refuse what is no number, no whole one, or too large for a double.

    Parameters
    ----------
    scene : str
        What moves.
    is_whole : bool
        Whether they are counts.
    least : int, optional
        The smallest that is possible.
    **given
        The numbers by their names.

    Raises
    ------
    SolveError
        An option is something else, such as a text.
    """
    wanted = "a whole number" if is_whole else "a number"
    if least is not None:
        wanted += f", {least} or more"
    for name, value in given.items():
        is_number = isinstance(value, Integral if is_whole else Real)
        is_good = is_number and not isinstance(value, bool)
        if is_good and not is_whole:
            is_good = _is_double(value)
            wanted = wanted if is_good else "a number in the range of doubles"
        if not is_good or (least is not None and cast(int, value) < least):
            raise SolveError(f"{scene}: {name.replace('_', ' ')} {shown(value)}; wanted {wanted}")


def numbers_of(scene: str, name: str, given: object) -> Array:
    """Return numbers as an array.

    Raises
    ------
    SolveError
        They are something else, such as complex numbers.
    """
    try:
        array = np.asarray(given)
        if array.dtype.kind not in "iufO":
            raise TypeError
        return np.ascontiguousarray(array, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise SolveError(f"{scene}: {name} {shown(given)}; wanted a row of numbers") from None


def require_room(scene: str, rows: int, size: int) -> None:
    """Refuse more rows than the memory of the machine holds.

    Most systems promise memory that they do not have, and kill whoever uses it.

    Parameters
    ----------
    scene : str
        What moves.
    rows, size : int
        How many rows, and numbers in each.

    Raises
    ------
    SolveError
        There is no room for them.
    """
    wanted, there = 8 * rows * (size + 1), _memory()
    if wanted > there:
        raise SolveError(
            f"{scene}: no room for {rows} rows of {size} numbers: they take {wanted / 1e9:.3g} GB,"
            f" the machine has {there / 1e9:.3g} GB; ask for fewer times"
        )


def _memory() -> float:
    """Return the bytes of memory of the machine; infinity where the system does not tell."""
    try:
        return float(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    except (AttributeError, OSError, ValueError):  # as on Windows
        return float("inf")


def times_of(scene: str, end: object, times: object, samples: object, size: int = 0) -> Array:
    """Return the times of a motion: those that are given, or samples from 0 to an end.

    Raises
    ------
    SolveError
        Both are given, or neither; or they are not possible, or have no room in rows of a size.
    """
    if (end is None) == (times is None):
        raise SolveError(f"{scene}: give either end or times")
    if times is None:
        require_numbers(scene, end=end)
        require_numbers(scene, is_whole=True, samples=samples)
        last, count = cast(float, end), cast(int, samples)
        if not (0.0 < last < np.inf and 2 <= count <= MOST_ROWS):
            raise SolveError(
                f"{scene}: end {shown(end)} with {shown(samples)} samples; wanted an end"
                f" above 0 and 2 to {MOST_ROWS} samples"
            )
        require_room(scene, count, size)
        return np.linspace(0.0, float(last), count)
    chosen = numbers_of(scene, "times", times)
    is_good = chosen.ndim == 1 and chosen.size and bool(np.isfinite(chosen).all())
    if not is_good or chosen[0] < 0.0 or bool((np.diff(chosen) < 0.0).any()):
        raise SolveError(f"{scene}: times must ascend from 0 or later, one row of numbers")
    return chosen


def require_shape(scene: str, name: str, given: Array, wanted: Array) -> None:
    """Refuse an array that has too many or too few numbers.

    Raises
    ------
    SolveError
        The message says which shape is wanted.
    """
    if given.shape != wanted.shape:
        raise SolveError(f"{scene}: {name} has the shape {given.shape}, wanted {wanted.shape}")


def require_callable(scene: str, progress: object) -> None:
    """Refuse what cannot be called with the time reached and the last time.

    Raises
    ------
    SolveError
        It is something else.
    """
    if progress is not None and not callable(progress):
        raise SolveError(f"{scene}: progress {shown(progress)}; wanted a function of two times")


def _is_double(value: Any) -> bool:
    try:
        float(value)
    except OverflowError:
        return False
    return True
