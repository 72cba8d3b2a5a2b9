"""Continuation of parameters: a start that the scene gives becomes that with those of a run."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .projection import project
from .scene import smaller

if TYPE_CHECKING:
    import numpy.typing as npt

    from .scene import Work, Workspace
    from .state import State

    Array = npt.NDArray[np.float64]

#: The largest correction with which parameters are changed at the start.
CLOSE = 0.02
#: The smallest part of the way from the parameters of the scene to those of the run.
SHORTEST = 1e-9


def is_possible(w: Workspace) -> bool:
    """Return whether the numbers of the design in the workspace are possible."""
    positive = w.design[w.scene.positive]
    return bool((positive > 0.0).all() and np.isfinite(w.design).all())


def follow_design(y: Array, w: Workspace) -> None:
    """Compute the numbers of the design anew, and move a state as they move the start."""
    place, at = w.scene.starts.T
    y[place] -= w.design[at]
    w.run("setup")
    y[place] += w.design[at]


def set_parameters(given: Array, part: float, w: Workspace) -> None:
    """Turn the parameters of the scene into those that are given by a part of the way."""
    values = w.scene.parameters
    w.parameters[:] = values + part * (given - values) if part < 1.0 else given


def continue_parameters(state: State, work: Work) -> bool:
    """Bring positions to where bodies fit and drivers begin with the parameters of the run.

    That may be far from where it is with those of the scene, so these become the others by small
    steps. Returns whether they can.
    """
    w, y, t, given = work.w, work.k[0], state.time, state.parameters
    y[:] = state.y
    if 0.0 <= project(t, 0.0, y, None, None, work, state) <= CLOSE:
        return True
    set_parameters(given, 0.0, w)
    follow_design(state.y, w)
    if project(t, 0.0, state.y, None, None, work, state) < 0.0:
        return False
    reached, part = 0.0, 1.0
    while reached < 1.0:
        following = smaller(reached + part, 1.0)
        y[:] = state.y
        set_parameters(given, reached, w)
        w.run("setup")
        set_parameters(given, following, w)
        follow_design(y, w)
        if 0.0 <= project(t, 0.0, y, None, None, work, state) <= CLOSE:
            state.y[:] = y
            reached, part = following, 2.0 * part
        else:
            part = 0.5 * part
            if part < SHORTEST:
                return False
    return True
