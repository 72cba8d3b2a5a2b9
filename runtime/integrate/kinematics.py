"""Kinematics: a motion that drivers determine, position by position."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from .arithmetic import larger, smaller
from .branch_watch import LEVEL_RATIO_PART, meeting_part
from .branches import BRANCH_LOST, ON_BRANCH, follow_branch, note_branch
from .crossing import ONWARD, STRETCH_TO_END, crossing_end, note_crossings, why_stopped
from .dense_output import hermite_cubic
from .methods import METHODS
from .motion_scales import energy_balance, energy_moved, energy_of_works, note_motion, note_moved
from .pivot_monitor import (
    BRANCH_ROUNDING,
    WEAK_PIVOT_RATIO,
    blur_of,
    branch_ratio,
    note_largest_pivot,
    note_pivot_ratio,
    pivot_ratio,
    scale_by_distance,
)
from .poles import end_before_pole
from .projection import project, ratio_at
from .row_switch import check_misses, forget_trials, note_misses
from .search import SMALLEST, Search, begin_search, cut_at, note_unresolved, read_at, read_of
from .settings import Status
from .step_error import LEAST_STEP_FACTOR
from .variation import FINEST, resolved_end

if TYPE_CHECKING:
    from collections.abc import Sequence

    from .arithmetic import Array
    from .scene_tables import SceneTables, Work
    from .settings import Settings
    from .state import State

#: Largest error of a prediction, relative to the motion of the step.
PREDICTION_ERROR_PART = 0.02
#: Error of a prediction that is always negligible, in lengths of the scene or radians.
NEGLIGIBLE_PREDICTION_ERROR = 1e-9
#: Largest part of the motion of a step that velocities may leave unexplained.
UNEXPLAINED_MOTION_PART = 1e-3
#: Unexplained motion up to which no driver has jumped, in lengths of the scene or radians.
SMALLEST_JUMP = 1e-6
#: Largest ratio of the branch ratios at the ends of half a step: if they differ by more, another
#: branch may lie behind a singular configuration in between.
MOST_GROWTH = 2.0
#: Longest motion of bodies in half a step, in lengths of the scene or radians, over which branch
#: ratios show a singular configuration: the angle between two bodies turns by twice as much, and
#: the root of the ratio goes with its sine.
LONGEST_WAY = 0.6
#: Motion of bodies in half a step, in lengths of the scene or radians, up to which it is not
#: shortened any more to find a singular configuration.
FINEST_WAY = 1e-6
#: Error of rates in the middle of a step, in units of what the cubic polynomial is off there.
SLOPE_OF_ERROR = 8.0
#: Power of the excess of an error of sixth order by which a step is made shorter.
SIXTH = -1.0 / 6.0
#: Safety factor of the length of a step that is just smooth enough, or that just sums works to the
#: tolerance.
NEXT_STEP_SAFETY = 0.9
#: Largest ratio of a step length to the one before.
MOST_NEXT_FACTOR = 2.0
#: Factor of a step length where nothing tells how short it must be.
HALVED = 0.5
#: Power of the step length with which errors of works by Lobatto's rule of five nodes go.
LOBATTO_ORDER = 9.0
#: Power of the step length with which errors of works by Simpson's rule go.
SIMPSON_ORDER = 5.0
#: Distance, in step lengths, up to which an end is tried behind a position where rows are nearly
#: dependent.
FURTHEST_TRIAL = 8.0
#: Factor of the smallest pivot ratio that positions inside of a step may have, once a leap over
#: such a position has been given up as branches do not meet there.
DEEP_RATIO_PART = 1e-3
#: The largest turn of a step: angles count their turns [rad].
MOST_TURN = 1.0
#: Error of works by Simpson's rule, in tolerances, below which no better rule need be tried.
SURE_WORK_ERROR = 1e-3
#: Number of steps after which a better rule is tried even so.
RULE_TRIAL_STEPS = 64.0
#: Rounding of energies, relative to them.
ENERGY_ROUNDING = 1e-13
#: Part of the error of a rule that still counts in the next step: at a turning point of the rate
#: the error is small by chance.
ERROR_DECAY = 0.5
#: A node of Lobatto's rule of five, a part of a step: (1 - sqrt(3/7)) / 2.
LOBATTO_NODE = 0.17267316464601143
#: Error of Lobatto's rule, relative to the cube of its correction over the square of Simpson's:
#: twice that of a sine.
EVEN_ERROR_PART = 0.2
#: Place s of its inner nodes from the middle, in half steps: odd powers of time are looked at
#: there, as even ones may correct nothing by chance.
ODD_PLACE = 0.6546536707079772
#: Square of s - s^3, by which a cubic polynomial is off a straight line at this place.
ODD_PART = 0.14
#: Weight of the error that odd powers of time tell.
ODD_ERROR_PART = 4e-4
#: Parts of a step up to which positions are found in turn, and the slot of each.
LEAP = ((1.0, 1),)
HALVES = ((0.5, 0), (1.0, 1))
NODES = ((LOBATTO_NODE, 2), (0.5, 0), (1.0 - LOBATTO_NODE, 3), (1.0, 1))


class Position(NamedTuple):
    """A position and velocity y, and its derivative f."""

    y: Array
    f: Array


class WorkEstimate(NamedTuple):
    """Estimate of the works of a step and of their error.

    Parameters
    ----------
    error, simpson : float
        Of them, and of Simpson's rule if more positions estimated it, in units of the tolerance.
    is_estimated : bool
        Whether more positions than ends and middle estimated it.
    balance, moved : float [J]
        At its end the energy that no work explains, and that which has moved.
    """

    error: float = 0.0
    simpson: float = 0.0
    is_estimated: bool = False
    balance: float = 0.0
    moved: float = 0.0


def predict_and_correct(
    t: float, h: float, start: Position, to: Position, work: Work, state: State
) -> float:
    """Go on by h [s] as position, velocity and acceleration predict it, and meet the constraints.

    dq = h (v + ½ h v̇) and v + h v̇, to the time t [s]. Gives the derivative, and returns the first
    correction [-], lengths relative to that of the scene, negative where that is impossible.
    """
    scene, w = work.scene, work.w
    v, v_dot = start.y[scene.nq :], start.f[scene.nq :]
    w.q[:] = start.y[: scene.nq]
    w.dq[:] = h * (v + 0.5 * h * v_dot)
    to.y[scene.nq :] = v + h * v_dot
    w.displace(None)
    to.y[: scene.nq] = w.q
    return project(t, 0.0, to.y, None, to.f, work, state)


def roughness(
    h: float, drift: float, start: Position, to: Position, work: Work, state: State
) -> float:
    """Roughness [-] of a step of length h [s], at most one where it is smooth.

    It compares the correction of the prediction, and the change of the velocities that the
    accelerations do not explain, h |v₁ − v₀ − ½ h (v̇₀ + v̇₁)|, with what is allowed; on another
    branch both are large. It goes with the square of h. Where no position was found it is infinite.
    """
    if drift < 0.0:
        return math.inf
    scene, size_of = work.scene, work.w.size_of
    nq = scene.nq
    travel = work.w.way_of(h, start.y, to.y)
    change = h * (to.y[nq:] - start.y[nq:] - 0.5 * h * (start.f[nq:] + to.f[nq:]))
    allowed = larger(
        larger(NEGLIGIBLE_PREDICTION_ERROR, blur_of(work, state)), PREDICTION_ERROR_PART * travel
    )
    rough = larger(drift, size_of(change)) / allowed
    if scene.has_joint_coordinates:  # no prediction tells how far drivers turn
        counted = slice(*scene.unwrapped_angles)
        turn = float(np.max(np.abs(to.y[counted] - start.y[counted]), initial=0.0)) / MOST_TURN
        rough = larger(rough, turn * turn)
    return rough


def is_explained(h: float, start: Position, half: Position, last: Position, work: Work) -> bool:
    """Whether velocities explain where bodies are after two halves of length h [s].

    |q₁ − q₀ − ⅓ h (q̇₀ + 4 q̇ₘ + q̇₁)|, m in the middle, is small then. It is large where a driver
    jumps; the prediction of bodies that are put onto what drives them does not tell of a jump.
    """
    scene, size_of = work.scene, work.w.size_of
    nq = scene.nq
    rates = start.f[:nq] + 4.0 * half.f[:nq] + last.f[:nq]
    unexplained = last.y[:nq] - start.y[:nq] - h / 3.0 * rates
    fastest = larger(larger(size_of(start.y[nq:]), size_of(half.y[nq:])), size_of(last.y[nq:]))
    miss = float(np.max(np.abs(unexplained) / scene.floors))
    return miss <= larger(SMALLEST_JUMP, UNEXPLAINED_MOTION_PART * 2.0 * h * fastest)


def signed_ratio(work: Work, state: State) -> float:
    """Branch ratio, negative where all rows are solved for: these have another ratio."""
    ratio = branch_ratio(work, state)
    return -ratio if work.row_switch is not None and work.row_switch.is_active else ratio


def may_leap(
    h: float, before: float, after: float, last: Position, state: State, work: Work
) -> bool:
    """Whether half a step of length h may leap over a singular configuration.

    Another branch lies behind it. The branch ratio goes with the square of the distance from it,
    which changes at a steady rate: no half passes zero if the ratio changes by a small factor in
    it and in those beside it. A half that is too short to be halved is noted, and looked at later.
    """
    low, high = smaller(abs(before), abs(after)), larger(abs(before), abs(after))
    is_near = high > MOST_GROWTH * low and (before < 0.0) == (after < 0.0)
    travel = h * work.w.size_of(last.y[work.scene.nq :])
    if is_near and not travel > FINEST_WAY:
        state.is_near = 1.0
    is_long = travel > LONGEST_WAY and low < LEVEL_RATIO_PART * high and work.scene.has_refinement
    return is_long or (is_near and travel > FINEST_WAY)


def position_at(slot: int, work: Work) -> Position:
    """Room of a position of a step: 0 of its middle, 1 of its end, 2 and 3 of two between."""
    return Position(work.k[2 * slot], work.k[2 * slot + 1])


def reach(
    end: float, parts: Sequence[tuple[float, int]], weak: float, state: State, work: Work
) -> tuple[float, float]:
    """Go on to the end in parts, or in one leap.

    Powers at the ends and in the middle are summed by Simpson's rule to the works.

    Parameters
    ----------
    end : float [s]
        The time there.
    parts : sequence of (float, int)
        Up to which part of the step each goes, and where its position is kept.
    weak : float
        No position inside has a pivot ratio smaller than that, where the largest is 1.

    Returns
    -------
    drift : float
        The first correction, or -1 if that was not smooth.
    rough : float
        The largest :func:`roughness` of the parts, as far as it went.
    """
    start, half, last = Position(state.y, state.f), position_at(0, work), position_at(1, work)
    h, is_leap = end - state.time, len(parts) == 1
    passed, before, ratio = 0.0, start, state.position_ratio
    drift, rough = 0.0, 0.0
    forget_trials(work)
    state.is_near = 1.0 if is_leap else 0.0  # a leap goes over such a place
    for x, slot in parts:
        span, to = (x - passed) * h, position_at(slot, work)
        time = end if x == 1.0 else state.time + x * h
        first = predict_and_correct(time, span, before, to, work, state)
        rough = larger(roughness(span, first, before, to, work, state), rough)
        if not rough <= 1.0:
            return -1.0, rough
        if x < 1.0 and pivot_ratio(work, state) < weak * state.largest_pivot_ratio:
            return -1.0, rough
        ratio_there = signed_ratio(work, state)
        if not is_leap and may_leap(span, ratio, ratio_there, to, state, work):
            return -1.0, rough
        passed, before, ratio, drift = x, to, ratio_there, larger(first, drift)
    if (
        work.scene.has_joint_coordinates
        and not is_leap
        and not is_explained(0.5 * h, start, half, last, work)
    ):
        return -1.0, rough
    works = slice(work.scene.nq - work.scene.works, work.scene.nq)
    if is_leap:
        last.y[works] = start.y[works] + h / 2.0 * (start.f[works] + last.f[works])
    else:
        rates = start.f[works] + 4.0 * half.f[works] + last.f[works]
        last.y[works] = start.y[works] + h / 6.0 * rates
    return drift, rough


def branch_at(end: float, state: State, work: Work) -> int:
    """Whether a step may lead onto another branch: BRANCH_LOST, ON_BRANCH or BIFURCATION."""
    if not (state.is_near > 0.0 and work.scene.has_refinement):
        return ON_BRANCH
    last = position_at(1, work)
    first, after = math.sqrt(abs(state.position_ratio)), math.sqrt(branch_ratio(work, state))
    part, h = meeting_part(first, after), end - state.time
    branch = follow_branch(h, last.y, last.f, part, first + after, work, state)
    work.w.place(end, last.y)  # its geometry again
    ratio_at(last.y[: work.scene.nq], work, state)
    return branch


def find_between(end: float, weak: float, state: State, work: Work) -> bool:
    """Find positions at the other nodes of Lobatto's rule, in a step in halves to ``end`` [s].

    Returns whether they are found.
    """
    h = end - state.time
    start, half = Position(state.y, state.f), position_at(0, work)
    for x, slot, before, passed in (
        (LOBATTO_NODE, 2, start, 0.0),
        (1.0 - LOBATTO_NODE, 3, half, 0.5),
    ):
        span, to = (x - passed) * h, position_at(slot, work)
        drift = predict_and_correct(state.time + x * h, span, before, to, work, state)
        if not roughness(span, drift, before, to, work, state) <= 1.0:
            return False
        if pivot_ratio(work, state) < weak * state.largest_pivot_ratio:
            return False
    return True


def least_size_of_works(h: float, state: State, work: Work) -> float:
    """Size that errors of works are compared with in a step of length h, beside the works [J]."""
    work.w.run("energy")
    return moving_energy(h, state, work)


def moving_energy(h: float, state: State, work: Work) -> float:
    """Energy [J] that errors of works are compared with; that at the end is in the workspace."""
    end = position_at(1, work).y
    moved = larger(state.moved, energy_moved(end, work, state))
    return energy_of_works(h, end, moved, state, work) + float(work.w.energies[0])


def unbalanced(s: Settings, h: float, state: State, work: Work) -> float:
    """Change of energy in a step of length h that no work explains, in tolerances.

    The energy of positions is exact: it tells what no rule says of its own error, as where powers
    are narrow beside the nodes. Steps over the finest way are not asked: energies differ by what
    rates are rounded to, of which a shorter step has as much.
    """
    scene, w, end = work.scene, work.w, position_at(1, work).y
    if w.way_of(h, state.y, end) <= FINEST_WAY:
        return 0.0
    works = slice(scene.nq - scene.works, scene.nq)
    unexplained = abs(energy_balance(end, work, state) - state.balance)
    largest_work = float(np.max(np.maximum(np.abs(state.y[works]), np.abs(end[works]))))
    size = moving_energy(h, state, work) + largest_work
    energy_rounding = ENERGY_ROUNDING * larger(abs(w.energies[1]), abs(state.energy))
    # velocities are known to as much of the way to another branch as positions are
    blur, rounding = blur_of(work, state), scale_by_distance(state.y, scene) * BRANCH_ROUNDING
    return unexplained / ((s.tolerance + blur * blur / rounding) * size + energy_rounding)


def sum_works(
    s: Settings, end: float, weak: float, state: State, work: Work, *, has_nodes: bool
) -> tuple[float, float, bool]:
    """Sum the works of a step by a better rule than Simpson's, unless that is good enough.

    The relative error of Simpson's rule is about the square of that of the trapezoidal rule. Unless
    it is far below the tolerance, two more positions estimate it, and works are summed by Lobatto's
    rule. This rule is also tried once in ``RULE_TRIAL_STEPS`` steps: periodic powers that are the
    same at both ends and in the middle differ at its nodes. The error of Simpson's rule since the
    last trial goes to the ledger.

    Returns
    -------
    error, simpson : float
        In units of the tolerance, and that of Simpson's rule if it is estimated.
    is_estimated : bool
        Whether two more positions estimated it.
    """
    scene, h = work.scene, end - state.time
    if scene.works == 0:
        return 0.0, 0.0, True
    works = slice(scene.nq - scene.works, scene.nq)
    rate, half, f = state.f[works], position_at(0, work).f[works], position_at(1, work).f[works]
    before, after = np.abs(state.y[works]), np.abs(position_at(1, work).y[works])
    sizes = least_size_of_works(h, state, work) + np.maximum(before, after)
    difference = (2.0 * half - rate - f) / 6.0
    scale = np.abs(rate) + 2.0 * np.abs(half) + np.abs(f)
    relative = difference / np.where(scale > 0.0, scale, 1.0)
    simpson_error = larger(float(np.max(0.5 * h * difference * relative / sizes)), 0.0)
    error = state.simpson = larger(simpson_error / s.tolerance, ERROR_DECAY * state.simpson)
    if not has_nodes:
        if error < SURE_WORK_ERROR and math.fmod(state.steps, RULE_TRIAL_STEPS) != 0.0:
            return error, 0.0, False
        has_nodes = find_between(end, weak, state, work)
        work.w.place(end, position_at(1, work).y)  # its geometry again
        ratio_at(position_at(1, work).y[: scene.nq], work, state)
        if not has_nodes:
            return error, 0.0, False
    early, late = (position_at(slot, work).f[works] for slot in (2, 3))
    ends = 0.5 * (rate + f)
    fine = 49.0 / 90.0 * h * (0.5 * (early + late) - half - 3.0 / 7.0 * (ends - half))
    if error < SURE_WORK_ERROR:
        untold = smaller(state.untold, RULE_TRIAL_STEPS * h)
        state.work_error += float(np.max(np.abs(fine))) / h * untold
        state.untold = 0.0
    coarse = h * (ends - half) / 3.0
    square = fine * fine + coarse * coarse
    even_left = EVEN_ERROR_PART * np.abs(fine) * (fine * fine / np.where(square > 0.0, square, 1.0))
    slope = 0.5 * (f - rate)
    odd = 0.5 * (late - early) - ODD_PLACE * slope
    square = odd * odd + slope * slope * ODD_PART
    odd_left = ODD_ERROR_PART * h * np.abs(odd) * (odd * odd / np.where(square > 0.0, square, 1.0))
    position_at(1, work).y[works] += fine
    simpson = float(np.max(np.abs(fine) / sizes)) / s.tolerance
    state.simpson = larger(simpson, state.simpson)
    estimated = larger(float(np.max(even_left / sizes)), float(np.max(odd_left / sizes)))
    return larger(estimated / s.tolerance, ERROR_DECAY * state.error), simpson, True


def estimate_works(
    s: Settings,
    end: float,
    weak: float,
    state: State,
    work: Work,
    parts: Sequence[tuple[float, int]],
) -> WorkEstimate:
    """Sum the works of a step better unless it leaps, and estimate their error, by energy, too."""
    scene, last = work.scene, position_at(1, work)
    error, simpson, is_estimated = 0.0, 0.0, False
    check_misses(s, work)
    if parts is not LEAP:
        error, simpson, is_estimated = sum_works(
            s, end, weak, state, work, has_nodes=parts is NODES
        )
    elif scene.works > 0:
        work.w.run("energy")
    if scene.works == 0:
        return WorkEstimate(error, simpson, is_estimated)
    error = larger(unbalanced(s, end - state.time, state, work), error)
    moved = energy_moved(last.y, work, state)
    return WorkEstimate(error, simpson, is_estimated, energy_balance(last.y, work, state), moved)


def accept_position(s: Settings, end: float, asked: float, state: State, work: Work) -> None:
    """Keep a position, at or behind the time that is asked for."""
    h, last, f_before = end - state.time, position_at(1, work), state.f.copy()
    state.time_before = state.time if end > asked else end
    state.time = end
    state.steps += 1
    note_misses(s, work, state)
    note_motion(h, last.y, state, work)
    state.y_before[:] = state.y
    state.y[:] = last.y
    state.f[:] = last.f
    if end > asked:
        state.dense[:] = 0.0
        hermite_cubic(h, state.y, f_before, state.f, state)


def note_ratios(ratio: float, end: float, state: State, work: Work, *, is_deep: bool) -> None:
    """Note the pivot ratio and the branch ratio of a position that is kept.

    Where the pivot ratio is weak, later ones are weak only below it, or further below if deep.
    """
    note_pivot_ratio(ratio, end, state)
    if ratio < WEAK_PIVOT_RATIO * state.largest_pivot_ratio:
        state.largest_pivot_ratio = ratio / WEAK_PIVOT_RATIO * (DEEP_RATIO_PART if is_deep else 1.0)
    state.largest_pivot_ratio = larger(state.largest_pivot_ratio, ratio)
    note_largest_pivot(work, state)
    state.position_ratio = signed_ratio(work, state)
    state.usual_ratio = larger(state.usual_ratio, state.position_ratio)


def add_middle_rows(h: float, y: Array, f: Array, state: State) -> None:
    """Make the rows by which the polynomial meets y and f = ẏ (ny,) in the middle of h [s], too."""
    change, first, second = state.dense[:3]
    off = y - state.y_before - (0.5 * change + 0.25 * first + 0.125 * second)
    slope = h * f - change - 0.25 * second
    state.dense[3] = 16.0 * off - 8.0 * slope
    state.dense[4] = 16.0 * slope


def exact_end(end: float, search: Search) -> float:
    """Time [s] up to which a step may be so long that its polynomial tells of all events.

    It will meet the position in the middle, too. The error that is left, of sixth order, goes with
    the square of what the cubic polynomial is off there, relative to the motion.
    """
    state, work, h = search.state, search.work, search.h
    half, time = position_at(0, work), search.start + 0.5 * h
    is_short = work.w.way_of(h, state.y, position_at(1, work).y) <= FINEST_WAY
    if len(state.counts) == 0 or is_short:
        return end
    cubic = read_at(time, search)
    off = np.abs(read_of(time, half.y, work.w) - cubic)
    values = off[:, 0] + h * off[:, 1]
    rates = SLOPE_OF_ERROR * off[:, 1]
    fastest = np.maximum(np.abs(cubic[:, 1]), h * search.second_bound)
    excess = 0.0
    for left, moved, noise in (
        (values, h * fastest, search.noise[:, 0]),
        (rates, h * search.second_bound, search.noise[:, 1]),
    ):
        part = np.where(left < moved, left / np.where(moved > 0.0, moved, 1.0), 1.0)
        excess = larger(float(np.max(left * part / noise, initial=0.0)), excess)
    if not excess > 1.0:
        return end
    return search.start + h * larger(LEAST_STEP_FACTOR, NEXT_STEP_SAFETY * excess**SIXTH)


def watched_end(s: Settings, end: float, part: float, search: Search) -> float:
    """Time [s] at which a position to an end must be, to resolve forces between, and events.

    One that leaps over a place stays where it is.
    """
    half, last = position_at(0, search.work), position_at(1, search.work)
    begin_search(s, METHODS[-1], end - search.state.time, last.y, last.f, search, has_stages=False)
    exact = exact_end(end, search) if part <= 1.0 else end
    if exact < end:
        return exact
    if part <= 1.0:
        add_middle_rows(search.h, half.y, half.f, search.state)
    seen = crossing_end(end, search)
    is_cut = seen < end and part <= 1.0
    resolved = (
        resolved_end(seen if is_cut else end, search) if search.work.scene.has_narrow else end
    )
    if search.pole:
        return cut_at(end_before_pole(search), search)
    if part > 1.0:
        search.is_unresolved = search.is_unresolved or resolved < end
        return end
    return cut_at(seen, search) if seen <= resolved and seen < end else smaller(resolved, seen)


def following(error: float, rough: float, *, is_good: bool, is_estimated: bool) -> float:
    """Factor [-] from a step's length to the next one's, or to that which is tried in its place."""
    by_shape = NEXT_STEP_SAFETY / math.sqrt(rough) if rough > 0.0 else MOST_NEXT_FACTOR
    if not is_good:
        return larger(LEAST_STEP_FACTOR, by_shape) if 1.0 < rough < math.inf else HALVED
    if not math.isfinite(error):
        return HALVED
    by_work, order = MOST_NEXT_FACTOR, LOBATTO_ORDER if is_estimated else SIMPSON_ORDER
    if error > 0.0:
        by_work = NEXT_STEP_SAFETY * error ** (-1.0 / order)
    return larger(LEAST_STEP_FACTOR, smaller(MOST_NEXT_FACTOR, smaller(by_shape, by_work)))


def note_works(s: Settings, works: WorkEstimate, error: float, h: float, state: State) -> None:
    """Note the works of a step of length h [s] that is kept, with the error that counts."""
    note_moved(s, works.moved, state)
    state.untold += 0.0 if works.is_estimated else h
    state.error = error if works.is_estimated else 0.0
    state.balance = works.balance


def is_blind(works: WorkEstimate, scene: SceneTables, state: State) -> bool:
    """Whether nothing tells that works are good, as a force varies beyond polynomials.

    Both rules may be off alike between their nodes, and at the tail of a hill what the better one
    adds says little: Simpson's must be good, too.
    """
    is_sure = works.is_estimated or state.simpson >= SURE_WORK_ERROR
    return scene.works > 0 and scene.has_narrow and (works.simpson > 1.0 or not is_sure)


def factor_where_blind(rough: float, works: WorkEstimate, state: State) -> float:
    """Factor [-] to the step that is tried in place of a blind one: 1 to estimate it first."""
    state.rejected += 1
    if works.is_estimated:
        return following(works.simpson, rough, is_good=True, is_estimated=False)
    state.simpson = SURE_WORK_ERROR  # asks for more positions
    return 1.0


def first_length(s: Settings, asked: float, state: State) -> float:
    """Length [s] of the first trial of a step; the last one is tiny up to a cut near the start."""
    if not state.step_size > 0.0:
        return s.largest_step
    least = ONWARD * SMALLEST * larger(abs(state.time), abs(asked))
    return smaller(larger(state.step_size, least), s.largest_step)


def driven_step(s: Settings, asked: float, state: State, work: Work) -> Status:
    """Find the next position of a motion that drivers determine, at most at the time asked for.

    Steps are made shorter until they are smooth and sum works to the tolerance. Where rows are
    nearly dependent at the end, it is put elsewhere: before that position as long as possible, then
    behind it, also behind the time that is asked for.
    """
    part, is_deep, search = 1.0, False, Search(state, work, state.time)
    longest = first_length(s, asked, state)
    tells_works = "energies" in work.scene.parts or bool(s.checks)  # in rows, or the ledger
    while True:
        is_last = state.time + STRETCH_TO_END * longest >= asked
        length = asked - state.time if is_last else longest
        end = asked if is_last and part == 1.0 else state.time + part * length
        if not end - state.time > SMALLEST * larger(abs(state.time), abs(asked)):
            return Status.STEP_TOO_SMALL
        has_nodes = tells_works and state.simpson >= SURE_WORK_ERROR
        parts = LEAP if part > 1.0 else NODES if has_nodes else HALVES
        weak = WEAK_PIVOT_RATIO * (DEEP_RATIO_PART if is_deep else 1.0)
        drift, rough = reach(end, parts, weak, state, work)
        is_good, ratio = drift >= 0.0, pivot_ratio(work, state)
        works = (
            estimate_works(s, end, weak, state, work, parts)
            if is_good and tells_works
            else WorkEstimate()
        )
        error = works.error if part <= 1.0 else 0.0  # leaps sum no works well
        factor = following(error, rough, is_good=is_good, is_estimated=works.is_estimated)
        is_avoided = (
            part < FURTHEST_TRIAL
            and not is_deep
            and ratio < WEAK_PIVOT_RATIO * state.largest_pivot_ratio
        )
        is_fit = is_good and error <= 1.0 and not is_avoided
        branch = branch_at(end, state, work) if is_fit else ON_BRANCH
        # onto another branch, or over what one can go through, as works want
        is_leap = part > 1.0 and (
            branch == BRANCH_LOST or (branch == ON_BRANCH and works.error > 1.0)
        )
        if is_avoided:
            state.avoided += 1
            part = 1.25 if part == 0.5 else part - 0.25 if part <= 1.0 else 1.25 * part
        elif not is_fit or is_leap:
            state.rejected += 1
            longest = (1.0 if is_leap else factor if part <= 1.0 else 0.5) * length
            part, is_deep = 1.0, is_deep or is_leap
        else:
            seen = watched_end(s, end, part, search) if work.scene.has_functions else end
            why = why_stopped(seen, search)
            if why != Status.GOOD:
                return why
            if seen < end:
                asked = seen if seen == search.cut else asked
                longest = larger(seen, state.time + FINEST * length) - state.time
            elif part > 1.0 or not tells_works or not is_blind(works, work.scene, state):
                break
            else:
                longest = length * factor_where_blind(rough, works, state)
            part = 1.0
    if work.scene.has_functions:
        note_crossings(end, search)
        if search.is_unresolved:
            note_unresolved(state.time, state)
    note_branch(end, branch, state)
    note_ratios(ratio, end, state, work, is_deep=is_deep)
    state.drift = larger(state.drift, drift)
    note_works(s, works, error, end - state.time, state)
    state.step_size = larger(state.step_size if is_last else 0.0, factor * length)
    accept_position(s, end, asked, state, work)
    return Status.GOOD
