"""Branches: whether a step stays on its branch of the motion where another one meets it, or nearly.

Roots of branch ratios go with the distance from a place where branches meet. Where they do meet,
the way leads straight on: it is smooth and satisfies the rows, as near to the place as one looks.
Where they miss each other by little, a smooth way from one to the other violates the rows, the more
the nearer to the place: the branch itself bends sharply there, and ends elsewhere.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from .arithmetic import larger, smaller
from .pivot_monitor import branch_ratio
from .projection import correct_position, project_position, ratio_at
from .row_switch import FALL_BACK, forget_trials
from .scene_tables import WAY

if TYPE_CHECKING:
    from .arithmetic import Array
    from .scene_tables import Work
    from .state import State

#: Largest correction of places of a smooth way onto the rows, in lengths of the scene or radians.
OFF_WAY = 1e-9
#: Largest gap between branches that is rounding: the correction times the distance from the place
#: where branches meet at which it is found.
NO_GAP = 1e-14
#: First distance from the place where branches meet at which a gap is looked for, relative to the
#: step.
FIRST_DISTANCE = 0.03
#: Factor of this distance from each approach to the next.
DISTANCE_FACTOR = 0.1
#: Distance at which no gap is looked for any more where drivers determine the motion, in lengths of
#: the scene or radians.
NEAREST_DISTANCE = 1e-5
#: Largest number of approaches; a step that is undecided then may end on another branch.
MOST_APPROACHES = 12
#: Largest correction onto the rows, relative to the distance from the singularity, where the
#: singularity lies outside the step.
FAR_ERROR_PART = 1e-2
#: Largest ratio of the roots of branch ratios at the ends of a driven step, where the singularity
#: lies outside the step: drivers that turn back hide one inside.
LARGEST_ROOT_RATIO = 2.0
#: Verdicts on a step: it may end on another branch, it stays on its own, or goes straight on where
#: another one meets it, or comes nearer than rounding tells.
BRANCH_LOST, ON_BRANCH, BIFURCATION = 0, 1, 2


def evaluate_path(x: list[float], c: list[Array], part: float) -> Array:
    """Coordinates (nq,) at a part of a step [-] by Newton's polynomial through those at parts x.

    q = c₀ + (s − x₀) (c₁ + (s − x₁) (c₂ + …)) with the part s and n coefficients c (nq,), in the
    units of the coordinates.
    """
    q = c[-1]
    for node, coefficient in zip(x[-2::-1], c[-2::-1], strict=True):
        q = q * (part - node) + coefficient
    return q


def begin_path(
    h: float, y_before: Array, f_before: Array, y: Array, f: Array, nq: int
) -> tuple[list[float], list[Array]]:
    """Cubic polynomial through both ends of a step of length h [s], from f_before to f (ny,)."""
    step, first = y[:nq] - y_before[:nq], h * f_before[:nq]
    bend = step - first
    return [0.0, 0.0, 1.0, 1.0], [y_before[:nq].copy(), first, bend, h * f[:nq] - step - bend]


def correct_path(
    x: list[float], c: list[Array], t: float, part: float, work: Work, state: State
) -> tuple[float, float]:
    """Bring a place of the way at a part of a step onto the constraints, if it is off.

    The way leads through it then.

    Parameters
    ----------
    x, c : list of float [-], list of (nq,) array
        As of :func:`evaluate_path`; they grow by one where the way is bent.
    t : float [s]
        Time there.
    part : float [-]
        The part of the step.

    Returns
    -------
    correction : float [-]
        How far off it was, in lengths of the scene and radians, negative where it cannot be
        brought.
    ratio : float [-]
        The branch ratio there.
    """
    w, q = work.w, evaluate_path(x, c, part)
    w.t[0] = t
    ratio_at(q, work, state)
    ratio = branch_ratio(work, state)
    correct_position(work)
    state.factorisations += 1
    state.corrections += 1
    correction = w.size_of(w.dq)
    if correction <= OFF_WAY:
        return correction, ratio
    w.displace(None)
    if len(c) == WAY or not project_position(OFF_WAY * OFF_WAY, work, None, state) >= 0.0:
        return -1.0, 0.0
    ratio = branch_ratio(work, state)
    product = 1.0
    for node in x:
        product *= part - node
    c.append((w.q - q) / product)
    x.append(part)
    return correction, ratio


def follow_branch(
    h: float, y: Array, f: Array, part: float, slope: float, work: Work, state: State
) -> int:
    """Verdict on a step of length h [s] to y (ny,) and f = ẏ (ny,), one of those above.

    Branches meet, or nearly, at about this part of it; the slope [-] is that of roots of branch
    ratios there.
    """
    forget_trials(work)
    x, c = begin_path(h, state.y, state.f, y, f, work.scene.nq)
    travel = work.w.way_of(h, state.y, y)
    before = math.sqrt(abs(state.position_ratio))
    low, high = smaller(before, slope - before), larger(before, slope - before)
    is_even = high <= LARGEST_ROOT_RATIO * low or not work.scene.is_driven
    distance = FIRST_DISTANCE
    farthest, nearest = 0.0, math.inf
    for _ in range(MOST_APPROACHES):
        roots, worst = [], 0.0
        for side in (-distance, distance):
            node = part + side
            correction, ratio = correct_path(x, c, state.time + node * h, node, work, state)
            if not correction >= 0.0:
                return BRANCH_LOST
            takes_over = work.row_switch is not None and work.row_switch.is_active
            if takes_over and ratio > FALL_BACK * state.largest_pivot_ratio:
                return ON_BRANCH  # rows that were left out hold it
            roots.append(math.sqrt(ratio))
            worst = larger(worst, correction)
            farthest = larger(farthest, correction)
            nearest = smaller(nearest, roots[-1])
        total, change = roots[0] + roots[1], roots[1] - roots[0]
        expected = 2.0 * distance * slope
        is_between = total > 0.0 and abs(total - expected) <= abs(abs(change) - expected)
        numerator, denominator = (change, total) if is_between else (total, change)
        part -= float(np.divide(distance * numerator, denominator))
        is_inside = 0.0 < part < 1.0
        if not is_between and is_inside:
            continue  # the place is farther away
        is_on = worst <= larger(OFF_WAY, NO_GAP / (distance * travel))
        if is_on and not is_between:
            return ON_BRANCH if is_even and farthest <= FAR_ERROR_PART * nearest else BRANCH_LOST
        # momentum leads free bodies across gaps that numbers of a scene are rounded to
        if is_on and (not work.scene.is_driven or distance * travel <= NEAREST_DISTANCE):
            return BIFURCATION
        if is_between:
            slope = total / (2.0 * distance)
        if not is_inside:
            part = 1.0 if part > 0.5 else 0.0
        distance *= DISTANCE_FACTOR
    return BRANCH_LOST


def note_branch(time: float, verdict: int, state: State) -> None:
    """Note the verdict on a step to a time [s]: that it may have leapt, or that branches meet."""
    if verdict == BRANCH_LOST:
        if state.branch_points == 0.0:
            state.branch_point_time = time
        state.branch_points += 1
    elif verdict == BIFURCATION:
        if state.meetings == 0.0:
            state.meeting_time = time
        state.meetings += 1
