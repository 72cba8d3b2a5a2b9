"""Continuation of parameters: a start that the scene gives becomes that with those of a run."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .pivot_monitor import WEAK, pivot_ratio
from .projection import project, take_normal_part
from .rows import are_closed
from .scene import smaller
from .state import SINGLE

if TYPE_CHECKING:
    import numpy.typing as npt

    from .scene import Work, Workspace
    from .state import State

    Array = npt.NDArray[np.float64]

#: The largest correction with which parameters are changed at the start.
CLOSE = 0.02
#: The smallest part of the way from the parameters of the scene to those of the run.
SHORTEST = 1e-9
#: How far bodies are moved to see whether joints come open, and the shortest way, relative to a
#: length of the scene; a direction that is smaller than this is none.
ASIDE = 0.05
LEAST_ASIDE = 1e-3
NO_WAY = 1e-6


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
    steps. Velocities stay as they are given, however many steps it takes: they are projected once,
    at the end of the way. Returns whether the parameters can be reached.
    """
    w, y, t, given = work.w, work.k[0], state.time, state.parameters
    v = state.y[work.scene.nq :].copy()
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
    state.y[work.scene.nq :] = v
    return True


def stay_closed(state: State, work: Work) -> bool:
    """Return whether rows that are left out depend on others with the parameters of the run, too.

    They do with those of the scene. They are looked at where the run starts, which is in the
    workspace, and beside it, where all others let bodies move. The state stays as it is.
    """
    w, y, scene = work.w, work.k[0], work.scene
    w.run("check")
    if not are_closed(work, 1.0):
        return False
    x = 0.6180339887498949 * np.arange(1.0, scene.nv + 1.0)
    u = (x - np.floor(x) - 0.5) * scene.lengths  # no special direction
    take_normal_part(1.0, state.y[scene.nq :], work, u)
    size = w.size_of(u)
    if pivot_ratio(work, state) < WEAK or not size > NO_WAY:
        return True
    counts, way, is_good = state.numbers[:SINGLE].copy(), ASIDE, True
    while way > LEAST_ASIDE:
        w.place(state.time, state.y)
        w.dq[:] = way / size * u
        w.displace(None)
        y[: scene.nq] = w.q
        y[scene.nq :] = state.y[scene.nq :]
        if 0.0 <= project(state.time, 0.0, y, None, None, work, state) <= CLOSE:
            w.run("check")
            is_good = are_closed(work, 1.0)
            break
        way *= 0.5
    state.numbers[:SINGLE] = counts
    return is_good
