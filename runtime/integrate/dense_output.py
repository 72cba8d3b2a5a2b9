"""Dense output: the polynomial that tells the state at times inside of a step."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    import numpy.typing as npt

    from .methods import Method
    from .scene import Work
    from .state import State

    Array = npt.NDArray[np.float64]


def combine(n: int, row: Sequence[float], low: Array | None, h: float, k: Array, y: Array) -> None:
    """Set y = low + h sum of row[m] k[m], m < n, without low if it is None."""
    y[:] = 0.0 if low is None else low
    for m in range(n):
        factor = h * row[m]
        if factor != 0.0:
            y += factor * k[m]


def hermite_cubic(h: float, y: Array, f_before: Array, f: Array, state: State) -> None:
    """Make the cubic polynomial that leads from the state before to y in a step of length h.

    It meets the derivative f at both ends.
    """
    change = y - state.y_before
    state.dense[0] = change
    state.dense[1] = h * f_before - change
    state.dense[2] = 2.0 * change - h * (f_before + f)


def add_dense_rows(m: Method, h: float, state: State, work: Work) -> None:
    """Make what the stages of a step add to that."""
    for n, row in enumerate(m.dense):
        combine(m.all, row, None, h, work.k, state.dense[3 + n])


def prepare_dense(m: Method, work: Work, state: State) -> None:
    """Make the interpolating polynomial of the last step, all stages of which are there."""
    h = state.time - state.time_before
    hermite_cubic(h, state.y, work.k[0], work.k[m.stages], state)
    add_dense_rows(m, h, state, work)


def interpolate(m: Method, x: float, state: State, y: Array) -> None:
    """Set y to the interpolating polynomial at the part x of the step."""
    y[:] = 0.0
    for n in reversed(range(3 + len(m.dense))):
        y += state.dense[n]
        y *= x if n % 2 == 0 else 1.0 - x
    y += state.y_before


def differentiate(m: Method, x: float, h: float, state: State) -> Array:
    """Return the derivative of the interpolating polynomial of a step of length h."""
    y, rate = np.zeros_like(state.y), np.zeros_like(state.y)
    for n in reversed(range(3 + len(m.dense))):
        factor = x if n % 2 == 0 else 1.0 - x
        y += state.dense[n]
        rate = rate * factor + (1.0 if n % 2 == 0 else -1.0) * y
        y *= factor
    return rate / h
