"""Arguments that a caller gives: refused in one line where they are not what is wanted.

Refused with kousoku's ``SolveError``; where that is not installed with ``ValueError``.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from functools import cache
from importlib import import_module
from numbers import Integral, Real
from typing import TYPE_CHECKING, cast

import numpy as np

from ..messages import refusal, shown, unknown

if TYPE_CHECKING:
    from collections.abc import Sequence

    from .arithmetic import Array

#: Times that a motion may have; more rows fit into no memory.
MOST_SAMPLES = 10**9
#: Tolerances are from this one on, and below 1; memory.h has it, too.
LEAST_TOLERANCE = 1e-15


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
            text = f"{scene}: {unknown('option', name, (*also, *options))}"
            raise refusal(text, alone=TypeError)


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
            is_good = _is_double(cast(float, value))
            wanted = wanted if is_good else "a number in the range of doubles"
        if not is_good or (least is not None and cast(int, value) < least):
            raise refusal(f"{scene}: {name.replace('_', ' ')} {shown(value)}; wanted {wanted}")


def numbers_of(scene: str, name: str, given: object) -> Array:
    """Numbers as an array of the shape in which they are given, in their unit.

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
        raise refusal(f"{scene}: {name} {shown(given)}; wanted a row of numbers") from None


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
    needed, available = 8 * rows * (size + 1), _memory()
    if needed > available:
        raise refusal(
            f"{scene}: no room for {rows} rows of {size} numbers: they take {needed / 1e9:.3g} GB,"
            f" the machine has {available / 1e9:.3g} GB; ask for fewer times"
        )


@cache
def _memory() -> float:
    """Bytes of memory of the machine; infinity where the system does not tell."""
    try:
        return float(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    except (AttributeError, OSError, ValueError):  # as on Windows
        return float("inf")


def times_of(scene: str, end: object, times: object, samples: object, size: int = 0) -> Array:
    """Times (n,) [s] of a motion: those that are given, or samples from 0 to an end.

    Raises
    ------
    SolveError
        Both are given, or neither; or they are not possible, or have no room in rows of a size.
    """
    if (end is None) == (times is None):
        raise refusal(f"{scene}: give either end or times")
    if times is None:
        require_numbers(scene, end=end)
        require_numbers(scene, is_whole=True, samples=samples)
        last, count = cast(float, end), cast(int, samples)
        if not 0.0 < last < np.inf:
            raise refusal(f"{scene}: end {shown(end)}; wanted one above 0, in seconds")
        if not 2 <= count <= MOST_SAMPLES:
            raise refusal(f"{scene}: samples {shown(samples)}; wanted 2 to {MOST_SAMPLES}")
        require_room(scene, count, size)
        return np.linspace(0.0, float(last), count)
    chosen = numbers_of(scene, "times", times)
    is_good = chosen.ndim == 1 and chosen.size and bool(np.isfinite(chosen).all())
    if not is_good or chosen[0] < 0.0 or bool((np.diff(chosen) < 0.0).any()):
        raise refusal(f"{scene}: times must ascend from 0 or later, one row of numbers")
    return chosen


def misfit(name: str, given: Array, size: int, of: str) -> str:
    """Message on what is wrong with an array of so many numbers; empty if they fit.

    Parameters
    ----------
    name : str
        What it is called.
    given : array
        The array.
    size : int
        How many there must be.
    of : str
        What they are.
    """
    if given.shape != (size,):
        return f"{name} has the shape {given.shape}; wanted {size} numbers: {of}"
    for k in np.flatnonzero(~np.isfinite(given)):
        return f"{name}[{k}] is {given[k]}; wanted a finite number"
    return ""


def misfit_of_bodies(name: str, given: Array, size: int) -> str:
    """Message on what is wrong with q or v of bodies as written, see :func:`misfit`."""
    of = "r (3), Euler parameters (4)" if name[0] == "q" else "velocity (3), omega_b (3)"
    return misfit(name, given, size, f"of each body {of}; a point has the first three alone")


def require_callable(scene: str, progress: object) -> None:
    """Refuse what cannot be called with the time reached and the last time.

    Raises
    ------
    SolveError
        It is something else.
    """
    if progress is not None and not callable(progress):
        raise refusal(f"{scene}: progress {shown(progress)}; wanted a function of two times")


def require_shape(scene: str, name: str, given: Array, wanted: Array) -> None:
    """Refuse an array that has too many or too few numbers.

    Raises
    ------
    SolveError
        The message says which shape is wanted.
    """
    if given.shape != wanted.shape:
        raise refusal(f"{scene}: {name} has the shape {given.shape}, wanted {wanted.shape}")


def values_of(
    scene: str, known: Mapping[str, float], given: Mapping[str, float | str] | None
) -> dict[str, float]:
    """Parameters of the scene, those that are given with their new values."""
    values = {**known}
    if given is None:
        return values
    if not isinstance(given, Mapping):
        raise refusal(f"{scene}: parameters {shown(given)}; wanted a mapping of names to numbers")
    problems = [unknown("parameter", name, [*known]) for name in given if name not in known]
    for name, value in given.items():
        if name not in known:
            continue
        try:
            values[name] = number_in(value)
        except (TypeError, ValueError, OverflowError):
            wanted = "a finite number, or an angle such as '30 deg'"
            problems.append(f"parameter {name} is {shown(value)}, wanted {wanted}")
    if problems:
        raise refusal(f"{scene}: {'; '.join(problems)}")
    return values


def number_in(value: object, *, is_length: bool = False) -> float:
    """Finite number; angles may be told by texts, see :mod:`kousoku.model.angles`.

    Raises
    ------
    TypeError, ValueError, OverflowError
        It is none.
    """
    if isinstance(value, str) and not is_length:
        try:
            angles = import_module("kousoku.model.angles")
        except ModuleNotFoundError:  # a copy lies here
            angles = import_module(".angles", __package__)
        value = angles.number_of(value)
    if isinstance(value, str | bool | np.bool_):
        raise TypeError
    number = float(cast("Real", value))
    if not math.isfinite(number):
        raise ValueError
    return number


def require_steps(
    scene: str, tolerance: float, step: float | None, largest_step: float, most_steps: int
) -> None:
    """Refuse steps that cannot be made so."""
    require_numbers(scene, tolerance=tolerance, largest_step=largest_step)
    require_numbers(scene, is_whole=True, most_steps=most_steps)
    if step is not None:
        require_numbers(scene, step=step)
        if not 0.0 < step < math.inf:
            raise refusal(f"{scene}: step {step!r}; wanted seconds, above 0")
        if step > largest_step > 0.0:
            raise refusal(
                f"{scene}: step {step!r} with largest_step {largest_step!r}; wanted one of them, or"
                " steps that are no longer"
            )
    if not LEAST_TOLERANCE <= tolerance < 1.0:
        wanted = f"one from {LEAST_TOLERANCE:g}, below 1"
        raise refusal(f"{scene}: tolerance {shown(tolerance)}; wanted {wanted}")
    for name, value in (("largest_step", largest_step), ("most_steps", most_steps)):
        if not value > 0.0:
            raise refusal(f"{scene}: {name} {shown(value)}; wanted one above 0")


def _is_double(value: float) -> bool:
    try:
        float(value)
    except OverflowError:
        return False
    return True
