"""Dense output: the polynomial that tells the state at times inside of a step."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from .arithmetic import Array
    from .methods import RungeKuttaMethod
    from .scene_tables import SceneTables, Work
    from .state import State


def combine(n: int, row: Sequence[float], low: Array | None, h: float, k: Array, y: Array) -> None:
    """Set y (ny,) = low + h sum of row[m] k[m] (ny,), m < n, without low if it is None; h [s]."""
    y[:] = 0.0 if low is None else low
    for m in range(n):
        factor = h * row[m]
        if factor != 0.0:
            y += factor * k[m]


def hermite_cubic(h: float, y: Array, f_before: Array, f: Array, state: State) -> None:
    """Make the cubic polynomial that leads from the state before to y (ny,) in a step of h [s].

    It meets the derivatives f_before and f (ny,), per second, at its ends.
    """
    change = y - state.y_before
    state.dense[0] = change
    state.dense[1] = h * f_before - change
    state.dense[2] = 2.0 * change - h * (f_before + f)


def add_dense_rows(m: RungeKuttaMethod, h: float, state: State, work: Work) -> None:
    """Make the rows that the stages of a step add to the cubic polynomial."""
    for n, row in enumerate(m.dense):
        combine(m.all, row, None, h, work.k, state.dense[3 + n])


def has_driven_works(m: RungeKuttaMethod, scene: SceneTables) -> bool:
    """Whether works at times inside of a step are summed from powers at its stages."""
    return scene.is_driven and scene.works > 0 and len(m.works) > 0


def add_driven_rows(m: RungeKuttaMethod, state: State, work: Work) -> None:
    """Make the rows that powers at stages add to the polynomial of works."""
    h = state.time - state.time_before
    works = slice(work.scene.nq - work.scene.works, work.scene.nq)
    for n, row in enumerate(m.works):
        state.dense[3 + n, works] = 0.0
        for k, x in enumerate(row):
            state.dense[3 + n, works] += h * x * work.k[k, works]


def add_driven_works(x: float, scene: SceneTables, state: State, y: Array) -> None:
    """Add the last two of these rows to works in y (ny,) [J], at the part x of the step."""
    works, rest = slice(scene.nq - scene.works, scene.nq), 1.0 - x
    factor = x * (x * rest) * (x * rest)
    y[works] += factor * (state.dense[4, works] + rest * state.dense[5, works])


def prepare_dense(m: RungeKuttaMethod, work: Work, state: State) -> None:
    """Make the interpolating polynomial of the last step, all stages of which are there."""
    h = state.time - state.time_before
    hermite_cubic(h, state.y, work.k[0], work.k[m.stages], state)
    add_dense_rows(m, h, state, work)


def interpolate(m: RungeKuttaMethod, x: float, state: State, y: Array) -> None:
    """Set y (ny,) to the interpolating polynomial at the part x of the step, from 0 to 1."""
    y[:] = 0.0
    for n in reversed(range(3 + len(m.dense))):
        y += state.dense[n]
        y *= x if n % 2 == 0 else 1.0 - x
    y += state.y_before


def differentiate(m: RungeKuttaMethod, x: float, h: float, state: State) -> Array:
    """Derivative (ny,) of the interpolating polynomial at the part x of a step of length h [s]."""
    y, rate = np.zeros_like(state.y), np.zeros_like(state.y)
    for n in reversed(range(3 + len(m.dense))):
        factor = x if n % 2 == 0 else 1.0 - x
        y += state.dense[n]
        rate = rate * factor + (1.0 if n % 2 == 0 else -1.0) * y
        y *= factor
    return rate / h
