"""Kinematics: a motion that drivers determine, position by position."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from .arithmetic import larger, smaller
from .crossing import (
    FINEST,
    SMALLEST,
    Look,
    cut_at,
    end_before_pole,
    look_into,
    note_crossings,
    note_unresolved,
    seen_end,
    told_end,
    why_stopped,
)
from .dense_output import hermite_cubic
from .methods import METHODS
from .pivot_monitor import (
    WEAK,
    note_branch_point,
    note_largest_pivot,
    note_pivot_ratio,
    pivot_ratio,
)
from .projection import project, ratio_at
from .row_switch import forget_trials
from .settings import Status
from .stepper import energy_moved, note_motion, usual_energy, usual_rate

if TYPE_CHECKING:
    import numpy.typing as npt

    from .scene import Work
    from .settings import Settings
    from .state import State

    Array = npt.NDArray[np.float64]

#: What a prediction may miss: a part of the way of a step, and what always may.
FAITHFUL = 0.02
NEGLIGIBLE = 1e-6
#: The part of the way of a step that velocities may not explain: a driver jumps.
UNEXPLAINED = 1e-3
#: Pivot ratios that are smaller than this part of the largest may grow or shrink by so much in each
#: half of a step: beside a singular configuration there is another branch. No check is made of
#: halves in which bodies move less than this, in lengths and radians.
SMALL_PIVOT = 0.5
MOST_GROWTH = 2.0
FINEST_WAY = 1e-4
#: How far behind a position where rows are nearly dependent a step is tried, in its length.
FURTHEST = 8.0
#: The largest turn of a step: angles count their turns [rad].
COUNTABLE = 1.0
#: What Simpson's rule leaves of works, in tolerances, where no other rule need be tried, and in how
#: many steps it is tried even so.
SURE = 1e-3
TRIALS = 64.0
#: What it left counts from step to step by this part: at a turning point of the rate it is small.
FADING = 0.5
#: A node of Lobatto's rule of five, a part of a step: (1 - sqrt(3/7)) / 2.
LOBATTO = 0.17267316464601143


class Position(NamedTuple):
    """A position and velocity y, and its derivative f."""

    y: Array
    f: Array


def predict_and_correct(
    t: float, h: float, start: Position, to: Position, work: Work, state: State
) -> float:
    """Go on by h as position, velocity and acceleration predict it, and meet the constraints.

    Gives the derivative, and returns the first correction, negative where that is impossible.
    """
    scene, w = work.scene, work.w
    v, v_dot = start.y[scene.nq :], start.f[scene.nq :]
    w.q[:] = start.y[: scene.nq]
    w.dq[:] = h * (v + 0.5 * h * v_dot)
    to.y[scene.nq :] = v + h * v_dot
    w.displace(None)
    to.y[: scene.nq] = w.q
    first = project(t, 0.0, to.y, None, to.f, work, state)
    if scene.fits:  # no prediction tells how far drivers turn
        counted = slice(*scene.counted)
        if not bool(np.all(np.abs(to.y[counted] - start.y[counted]) < COUNTABLE)):
            return -1.0
    return first


def is_smooth(h: float, drift: float, start: Position, to: Position, work: Work) -> bool:
    """Return whether a step went on smoothly.

    The prediction met the constraints, and the accelerations explain the change of the velocities;
    on another branch they do not.
    """
    if drift < 0.0:
        return False
    nq, size_of = work.scene.nq, work.w.size_of
    way = h * larger(size_of(start.y[nq:]), size_of(to.y[nq:]))
    change = h * (to.y[nq:] - start.y[nq:] - 0.5 * h * (start.f[nq:] + to.f[nq:]))
    return larger(drift, size_of(change)) <= larger(NEGLIGIBLE, FAITHFUL * way)


def is_explained(h: float, start: Position, half: Position, last: Position, work: Work) -> bool:
    """Return whether velocities explain where bodies are after two halves of length h.

    No prediction tells that of bodies that are put onto what drives them, and where a driver jumps
    its rates do not.
    """
    scene, size_of = work.scene, work.w.size_of
    nq = scene.nq
    rates = start.f[:nq] + 4.0 * half.f[:nq] + last.f[:nq]
    left = last.y[:nq] - start.y[:nq] - h / 3.0 * rates
    fastest = larger(larger(size_of(start.y[nq:]), size_of(half.y[nq:])), size_of(last.y[nq:]))
    miss = float(np.max(np.abs(left) / scene.floors))
    return miss <= larger(NEGLIGIBLE, UNEXPLAINED * 2.0 * h * fastest)


def may_leap(
    h: float, before: float, after: float, last: Position, state: State, work: Work
) -> bool:
    """Return whether half a step of length h may leap over a singular configuration.

    There is another branch behind it. The ratio of pivots goes with the square of the distance from
    it, which changes at a steady rate: no half passes zero where it and those beside it change the
    ratio by a small factor. What is too short to be halved is noted: no branch is known there.
    """
    low, high = smaller(before, after), larger(before, after)
    is_near = low < SMALL_PIVOT * state.largest_pivot_ratio and high > MOST_GROWTH * low
    is_long = h * work.w.size_of(last.y[work.scene.nq :]) > FINEST_WAY
    if is_near and not is_long:
        state.has_branch_point = 1.0
    return is_near and is_long


def middle_of(work: Work) -> Position:
    """Return where the position in the middle of a step is kept."""
    return Position(work.k[0], work.k[1])


def end_of(work: Work) -> Position:
    """Return where the position at the end of a step is kept."""
    return Position(work.k[2], work.k[3])


def reach(end: float, state: State, work: Work, *, in_halves: bool) -> float:
    """Go on to the end in two halves, or in one leap; return the first correction, or -1.

    It is -1 if that was not smooth. The halves are summed by Simpson's rule to the work.
    """
    start, half, last = Position(state.y, state.f), middle_of(work), end_of(work)
    h = 0.5 * (end - state.time) if in_halves else end - state.time
    first, middle, before = 0.0, 0.0, start
    forget_trials(work)
    state.has_branch_point = 0.0 if in_halves else 1.0  # a leap is one over such a place
    if in_halves:
        first = predict_and_correct(state.time + h, h, start, half, work, state)
        if not is_smooth(h, first, start, half, work):
            return -1.0
        middle = pivot_ratio(work, state)
        if middle < WEAK * state.largest_pivot_ratio:
            return -1.0
        if may_leap(h, state.position_ratio, middle, half, state, work):
            return -1.0
        before = half
    second = predict_and_correct(end, h, before, last, work, state)
    if not is_smooth(h, second, before, last, work):
        return -1.0
    if in_halves and may_leap(h, middle, pivot_ratio(work, state), last, state, work):
        return -1.0
    if work.scene.fits and in_halves and not is_explained(h, start, half, last, work):
        return -1.0
    done = slice(work.scene.nq - work.scene.works, work.scene.nq)
    if in_halves:
        rates = start.f[done] + 4.0 * half.f[done] + last.f[done]
        last.y[done] = start.y[done] + h / 3.0 * rates
    else:
        last.y[done] = start.y[done] + h / 2.0 * (start.f[done] + last.f[done])
    return larger(first, second)


def derivative_at(x: float, end: float, state: State, work: Work) -> Array | None:
    """Return the powers at a part x of the way of a step; None where they cannot be had."""
    h, start, to = end - state.time, Position(state.y, state.f), Position(work.k[4], work.k[5])
    before, gone = (start, 0.0) if x < 0.5 else (middle_of(work), 0.5)
    way = (x - gone) * h
    drift = predict_and_correct(state.time + x * h, way, before, to, work, state)
    if not is_smooth(way, drift, before, to, work):
        return None
    if pivot_ratio(work, state) < WEAK * state.largest_pivot_ratio:
        return None
    return to.f[work.scene.nq - work.scene.works : work.scene.nq].copy()


def least_size_of_works(h: float, state: State, work: Work) -> float:
    """Return what errors of works are compared with in a step of length h, beside the works [J]."""
    work.w.run("energy")
    rate = usual_rate(h, end_of(work).y, state, work)
    return usual_energy(rate, work.scene) + float(work.w.energies[0])


def sum_works(s: Settings, end: float, state: State, work: Work) -> tuple[float, bool]:
    """Sum the works of a step by a better rule than Simpson's, unless that is good enough.

    What Simpson's rule leaves is about the square of what trapezoids leave, each compared with what
    they sum. Where this is not far below the tolerance two more positions tell it, and works are
    summed by Lobatto's rule. So it is tried in every so many steps anyway: where periodic powers
    are the same at both ends and in the middle, they are not at its nodes. What Simpson's rule has
    left since the last trial goes to the ledger.

    Returns
    -------
    error : float
        In units of the tolerance.
    is_told : bool
        Whether two more positions told it.
    """
    scene, h = work.scene, end - state.time
    if scene.works == 0:
        return 0.0, True
    done = slice(scene.nq - scene.works, scene.nq)
    rate, half, f = state.f[done], middle_of(work).f[done], end_of(work).f[done]
    before, after = np.abs(state.y[done]), np.abs(end_of(work).y[done])
    sizes = least_size_of_works(h, state, work) + np.maximum(before, after)
    left = (2.0 * half - rate - f) / 6.0
    way = np.abs(rate) + 2.0 * np.abs(half) + np.abs(f)
    relative = left / np.where(way > 0.0, way, 1.0)
    most = larger(float(np.max(0.5 * h * left * relative / sizes)), 0.0)
    error = state.simpson = larger(most / s.tolerance, FADING * state.simpson)
    if error < SURE and math.fmod(state.steps, TRIALS) != 0.0:
        return error, False
    one, other = (derivative_at(x, end, state, work) for x in (LOBATTO, 1.0 - LOBATTO))
    work.w.place(end, end_of(work).y)  # its geometry again
    ratio_at(end_of(work).y[: scene.nq], work, state)
    if one is None or other is None:
        return error, False
    ends = 0.5 * (rate + f)
    more = 49.0 / 90.0 * h * (0.5 * (one + other) - half - 3.0 / 7.0 * (ends - half))
    if error < SURE:
        state.work_error += float(np.max(np.abs(more))) / h * state.untold
        state.untold = 0.0
    coarse = h * (ends - half) / 3.0
    root = np.sqrt(more * more + coarse * coarse)
    error_of = more * more / np.where(root > 0.0, root, 1.0)
    end_of(work).y[done] += more
    return float(np.max(error_of / sizes)) / s.tolerance, True


def accept_position(end: float, asked: float, state: State, work: Work) -> None:
    """Keep a position, at or behind the time that is asked for."""
    h, last, f_before = end - state.time, end_of(work), state.f.copy()
    state.time_before = state.time if end > asked else end
    state.time = end
    state.steps += 1
    note_motion(h, last.y, state, work)
    state.y_before[:] = state.y
    state.y[:] = last.y
    state.f[:] = last.f
    if end > asked:
        state.dense[:] = 0.0
        hermite_cubic(h, state.y, f_before, state.f, state)


def watched_end(s: Settings, end: float, part: float, look: Look) -> float:
    """Return where a position to an end must be, so that forces between are told, and events.

    One that leaps over a place stays where it is.
    """
    last = end_of(look.work)
    look_into(s, METHODS[0], end - look.state.time, last.y, last.f, look, has_stages=False)
    seen = seen_end(end, look)
    is_cut = seen < end and part <= 1.0
    told = told_end(seen if is_cut else end, look) if look.work.scene.has_narrow else end
    if look.pole:
        return cut_at(end_before_pole(look), look)
    if part > 1.0:
        look.is_untold = look.is_untold or told < end
        return end
    return cut_at(seen, look) if seen <= told and seen < end else smaller(told, seen)


def driven_step(s: Settings, asked: float, state: State, work: Work) -> Status:
    """Find the next position of a motion that drivers determine, at most at the time asked for.

    Steps are halved until they are smooth. Where rows are nearly dependent at the end, it is put
    elsewhere: before that position as long as possible, then behind it, also behind the time that
    is asked for.
    """
    part, longest = 1.0, s.largest_step
    has_energies = "energies" in work.scene.parts
    look = Look(state, work, state.time)
    if state.step_size > 0.0:
        longest = smaller(state.step_size, longest)
    while True:
        is_last = state.time + 1.0000001 * longest >= asked
        whole = asked - state.time if is_last else longest
        end = asked if is_last and part == 1.0 else state.time + part * whole
        if not end - state.time > SMALLEST * larger(abs(state.time), abs(asked)):
            return Status.STEP_TOO_SMALL
        drift = reach(end, state, work, in_halves=part <= 1.0)
        is_good, error, is_told, moved = drift >= 0.0, 0.0, False, 0.0
        ratio = pivot_ratio(work, state)
        if is_good and part <= 1.0 and (has_energies or s.checks):  # these tell the work
            error, is_told = sum_works(s, end, state, work)
            if work.scene.works > 0 and s.checks:
                moved = energy_moved(end_of(work).y, work, state)
        order = 7.0 if is_told else 5.0
        factor = 2.0 if error == 0.0 else smaller(2.0, larger(0.2, 0.9 * error ** (-1.0 / order)))
        is_weak = ratio < WEAK * state.largest_pivot_ratio
        if is_weak and part < FURTHEST:
            state.avoided += 1
            part = 1.25 if part == 0.5 else part - 0.25 if part <= 1.0 else 1.25 * part
        elif not is_good or not error <= 1.0:
            state.rejected += 1
            longest, part = (factor if is_good and math.isfinite(error) else 0.5) * whole, 1.0
        else:
            seen = watched_end(s, end, part, look) if work.scene.sees else end
            why = why_stopped(seen, look)
            if why != Status.GOOD:
                return why
            if not seen < end:
                break
            asked = seen if seen == look.cut else asked
            longest, part = larger(seen, state.time + FINEST * whole) - state.time, 1.0
    if work.scene.sees:
        note_crossings(end, look)
        if look.is_untold:
            note_unresolved(state.time, state)
    note_pivot_ratio(ratio, end, state)
    note_branch_point(end, state, is_there=state.has_branch_point > 0.0)
    state.position_ratio = ratio
    state.largest_pivot_ratio = (
        ratio / WEAK if is_weak else larger(state.largest_pivot_ratio, ratio)
    )
    note_largest_pivot(work, state)
    state.drift = larger(state.drift, drift)
    state.energy_moved = larger(state.energy_moved, moved)
    state.untold += 0.0 if is_told else end - state.time
    state.step_size = larger(state.step_size, factor * longest) if is_last else factor * longest
    accept_position(end, asked, state, work)
    return Status.GOOD
