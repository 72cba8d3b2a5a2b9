"""Continuation of parameters: from the start of the scene to that with the parameters of a run."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from .arithmetic import larger, mean_square, smaller
from .pivot_monitor import WEAK_PIVOT_RATIO, pivot_ratio
from .projection import project, take_normal_part
from .row_switch import ALL_OF_THEM
from .rows import are_closed
from .settings import CLEARLY
from .state import SINGLE

if TYPE_CHECKING:
    from .arithmetic import Array
    from .scene_tables import Work, Workspace
    from .state import State

#: The largest correction with which parameters are changed at the start.
LARGEST_CORRECTION = 0.02
#: The smallest part of the way from the parameters of the scene to those of the run.
SHORTEST_PARAMETER_STEP = 1e-9
#: The least square of Euler parameters that are all there, and the cosine of half a jump.
ALL_OF_IT = 0.999999
JUMP = 0.5
#: Positions that are looked at to see whether joints come open, how far bodies move from one to the
#: next, in lengths of the scene or radians, and how often that is tried, each time half as far; a
#: direction that is smaller than this is none.
MOST_CLOSURE_CHECKS = 24
STEP_ASIDE = 0.25
MOST_HALVINGS = 5
SMALLEST_DIRECTION = 1e-6
#: At a pivot ratio this much smaller than the largest on the way a singular configuration is near.
NEAR_SINGULAR = 0.25


def is_possible(w: Workspace) -> bool:
    """Whether the numbers of the design in the workspace are possible."""
    positive = w.design[w.scene.positive]
    return bool((positive > 0.0).all() and np.isfinite(w.design).all())


def axes_jump(before: Array, after: Array) -> bool:
    """Whether the principal axes of a body become others, as beside equal moments.

    Its Euler parameters (4,) [-] at the start, (2,) in a plane, are then far from those before,
    |p·p₀| < 1/2; all that are not zero vary.
    """
    sizes = [0.0, 0.0, 0.0]
    for a, b in zip(before.tolist(), after.tolist(), strict=True):
        sizes = [sizes[0] + a * a, sizes[1] + b * b, sizes[2] + a * b]
    return sizes[0] > ALL_OF_IT and sizes[1] > ALL_OF_IT and abs(sizes[2]) < JUMP


def turned_by(p: Array, q: Array) -> Array:
    """Product p ∘ q (4,) of Euler parameters (4,) [-], scalar first; of a turn in a plane (2,)."""
    if len(p) == 2:
        return np.array([p[0] * q[0] - p[1] * q[1], p[0] * q[1] + p[1] * q[0]])
    return np.array(
        [
            p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
            p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
            p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1],
            p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0],
        ]
    )


def follow_design(y: Array, w: Workspace) -> None:
    """Compute the numbers of the design anew, and move a state as they move the start.

    y (ny,) becomes y + y₀′ − y₀ where the start y₀ becomes y₀′, in SI units; Euler parameters p of
    a body whose principal axes become others become p ∘ p₀* ∘ p₀′.
    """
    slots, sources = w.scene.starts.T
    before, after = np.zeros((2, len(y)))
    before[slots] = w.design[sources]
    w.run("setup")
    after[slots] = w.design[sources]
    for first, _, count in w.scene.orientations.tolist():
        turn = slice(first, first + count)
        if axes_jump(before[turn], after[turn]):
            back = before[turn] * np.where(np.arange(count) > 0, -1.0, 1.0)
            y[turn] = turned_by(turned_by(y[turn], back), after[turn])
            slots = slots[(slots < first) | (slots >= first + count)]
    y[slots] -= before[slots]
    y[slots] += after[slots]


def set_parameters(target: Array, part: float, w: Workspace) -> None:
    """Set parameters at a part [-] of the way from those of the scene, p, to the target (n,).

    p + part · (target − p), each in its unit.
    """
    values = w.scene.parameters
    w.parameters[:] = values + part * (target - values) if part < 1.0 else target


def continue_parameters(state: State, work: Work) -> bool:
    """Bring positions to where bodies fit and drivers begin with the parameters of the run.

    That may be far from where bodies are with those of the scene, so these are changed by small
    steps. Velocities stay as they are given, however many steps it takes: they are projected once,
    at the end of the way. Returns whether the parameters can be reached.
    """
    w, y, t, target = work.w, work.k[0], state.time, state.parameters
    v = state.y[work.scene.nq :].copy()
    y[:] = state.y
    if 0.0 <= project(t, 0.0, y, None, None, work, state) <= LARGEST_CORRECTION:
        return True
    set_parameters(target, 0.0, w)
    follow_design(state.y, w)
    if project(t, 0.0, state.y, None, None, work, state) < 0.0:
        return False
    reached, step = 0.0, 1.0
    while reached < 1.0:
        following = smaller(reached + step, 1.0)
        y[:] = state.y
        set_parameters(target, reached, w)
        w.run("setup")
        set_parameters(target, following, w)
        follow_design(y, w)
        if 0.0 <= project(t, 0.0, y, None, None, work, state) <= LARGEST_CORRECTION:
            state.y[:] = y
            reached, step = following, 2.0 * step
        else:
            step = 0.5 * step
            if step < SHORTEST_PARAMETER_STEP:
                return False
    state.y[work.scene.nq :] = v
    return True


def step_along(u: Array, y: Array, work: Work, state: State) -> bool:
    """Move positions along a displacement and back onto the rows; return whether it can be.

    They go a quarter of u (nv,) [m, rad], which is one length of the scene or one radian large, or
    less. y (ny,) has q, then v, in SI units.
    """
    w, nq, moved, part = work.w, work.scene.nq, work.y, STEP_ASIDE
    for _ in range(MOST_HALVINGS):
        w.place(state.time, y)
        w.dq[:] = part * u
        w.displace(None)
        moved[:nq] = w.q
        moved[nq:] = y[nq:]
        if 0.0 <= project(state.time, 0.0, moved, None, None, work, state) <= LARGEST_CORRECTION:
            y[:] = moved
            return True
        part *= 0.5
    return False


def stay_closed_along(state: State, work: Work) -> bool:
    """Whether rows that are left out depend on others where bodies may move.

    Rows may miss the closure tolerance where the run starts, and per unit of motion, which is the
    root of the sum of squares over all bodies, there and along the way. What that adds up to ends a
    run only where it is clearly more. Near a singular configuration one freedom more is nearly
    open, and what rows miss along it tells nothing. What is too much takes the place of residuals.
    """
    w, y, scene = work.w, work.k[0], work.scene
    y[:] = state.y
    if project(state.time, 0.0, y, None, None, work, state) < 0.0:
        return True
    x = 0.6180339887498949 * np.arange(1.0, scene.nv + 1.0)
    u = (x - np.floor(x) - 0.5) * scene.lengths  # no special direction
    usual = 0.0
    for attempt in range(MOST_CLOSURE_CHECKS):
        ratio = pivot_ratio(work, state)
        is_regular = ratio >= NEAR_SINGULAR * usual
        usual = larger(usual, ratio)
        w.run("check")
        if is_regular and not are_closed(w.all_C, CLEARLY if attempt else 1.0, scene):
            return False
        take_normal_part(1.0, y[scene.nq :], work, u)
        size = w.size_of(u)
        if ratio < WEAK_PIVOT_RATIO or not size > SMALLEST_DIRECTION:
            return True
        u /= size
        w.v[:] = 0.0
        w.run("check")
        at_rest = w.C_dot.copy()
        w.v[:] = u
        w.run("check")
        w.all_C[:] = (w.C_dot - at_rest) / math.sqrt(mean_square(u / scene.lengths, 1))
        if is_regular and not are_closed(w.all_C, 1.0, scene):
            return False
        if not step_along(u, y, work, state):
            return True
    return True


def stay_closed(state: State, work: Work) -> bool:
    """Whether rows that are left out depend on others with the parameters of the run, too.

    They do with those of the scene. All rows are looked at, as many as are independent, whichever
    are kept: so a file with these parameters is looked at. The state stays as it is.
    """
    counts = state.numbers[:SINGLE].copy()
    state.largest_pivot_ratio = ALL_OF_THEM
    is_good = stay_closed_along(state, work)
    state.numbers[:SINGLE] = counts
    return is_good
