"""The stepper: an explicit Runge-Kutta step is tried until it is kept."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from .arithmetic import larger, smaller
from .branch_watch import LIMITED_STEP_PART, branch_of, longest_way
from .branches import BRANCH_LOST, note_branch
from .crossing import ONWARD, STRETCH_TO_END, note_crossings
from .motion_scales import note_extent, note_motion, note_moved
from .pivot_monitor import VAGUE_PIVOT_RATIO, WEAK_PIVOT_RATIO, note_pivot_ratio
from .projection import project, ratio_at
from .row_switch import forget_trials, note_misses
from .search import SMALLEST, Search, note_unresolved
from .settings import NOTHING_MOVES, Status
from .step_end import ends_well
from .step_error import LEAST_STEP_FACTOR, SAFETY, find_error, length_by_error
from .trial import Attempts, Trial, is_kept, is_thrown_off, make_dense_stages, make_stages

if TYPE_CHECKING:
    from .methods import RungeKuttaMethod
    from .scene_tables import Work
    from .settings import Settings
    from .state import State

#: How often a step is shortened at most because rows are nearly dependent at one of its stages;
#: then the length with the largest pivot ratio is taken.
MOST_AVOIDED = 8
#: Factor by which such a step is shortened each time, so that its stages lie elsewhere.
AVOIDING_STEP_PART = 0.9
#: Largest constraint correction of a step with drivers, in lengths of the scene or radians: no
#: error tells how far drivers led.
MOST_DRIVEN_CORRECTION = 1e-3
#: Motion of bodies in a step, in lengths of the scene or radians, below which it is not shortened
#: any more to find its branch.
SHORTEST_BRANCH_WAY = 1e-4
#: Exponent of the error of a step, times -k: (k_I + k_P) k.
ERROR_EXPONENT = 0.8
#: Exponent of the error of the step before, times k: k_P k. It damps steps whose lengths swing
#: about a bound of stability.
EARLIER_ERROR_EXPONENT = 0.2
#: Lower bound of the error of the step before, in units of the tolerance: one that is zero by
#: chance would make the next step short.
LEAST_EARLIER_ERROR = 1e-4
#: Largest ratio of a step length to the one before, 1 after a rejected step: error estimates are
#: local and tell nothing further on. See Hairer, Nørsett, Wanner, Solving Ordinary Differential
#: Equations I, II.4.
MOST_STEP_FACTOR = 10.0
#: Error, in units of the tolerance, of a trial that cannot be kept and whose error tells nothing:
#: the next one is much shorter.
REFUSED_ERROR = 1e3
#: Motion of bodies in the Euler step that precedes the first step, in lengths of the scene or
#: radians: it tells how derivatives change. Also the factor of the tolerance from which the length
#: of the first step follows. The same book, II.4.
FIRST_STEP_MOTION = 0.01
#: Length of this Euler step where nothing moves yet, relative to the whole time.
FIRST_STEP_SPAN_PART = 1e-6
#: Largest ratio of the first step to this Euler step.
MOST_FIRST_FACTOR = 100.0


def accept(tried: Attempts, trial: Trial, work: Work, state: State) -> None:
    """Keep a step, and say how long the next one is: a proportional and integral controller."""
    h, error, exponent, factor = trial.h, trial.error, 1.0 / tried.m.order, MOST_STEP_FACTOR
    if error != 0.0:
        before = larger(state.error, LEAST_EARLIER_ERROR)
        factor = SAFETY * error ** (-ERROR_EXPONENT * exponent)
        factor *= before ** (EARLIER_ERROR_EXPONENT * exponent)
    largest_factor = 1.0 if tried.is_rejected else MOST_STEP_FACTOR
    following = h * smaller(largest_factor, larger(LEAST_STEP_FACTOR, factor))
    limit, speed = longest_way(tried, trial, work, state), work.w.size_of(work.y[work.scene.nq :])
    if work.scene.is_driven and limit < math.inf and speed > 0.0:  # what is longer is made in vain
        following = smaller(following, LIMITED_STEP_PART * limit / speed)
    # over a jump its error tells nothing of what is behind: that is tried before a run stops
    least = ONWARD * SMALLEST * larger(abs(trial.end), abs(tried.limit))
    following = larger(following, least)
    if not trial.is_last or following < state.step_size:
        state.step_size = following
    state.error = larger(error, LEAST_EARLIER_ERROR)
    state.drift = larger(state.drift, trial.drift)
    note_moved(tried.s, trial.moved, state)
    state.largest_pivot_ratio = larger(state.largest_pivot_ratio, trial.last_ratio)
    note_pivot_ratio(trial.least_ratio, state.time + 0.5 * h, state)
    state.time_before = state.time
    state.time = trial.end
    state.steps += 1
    note_branch(state.time, trial.branch, state)
    if trial.parts:
        state.stage_before, state.root_before = h * (1.0 - trial.parts[-2]), trial.roots[-2]
    state.position_ratio = trial.end_ratio
    state.usual_ratio = larger(state.usual_ratio, trial.end_ratio)
    note_motion(h, work.y, state, work)
    note_extent(work.y, work, state)
    note_misses(tried.s, work, state)
    state.y_before[:] = state.y
    state.y[:] = work.y
    state.low[:] = work.low
    state.f[:] = work.k[tried.m.stages]


def next_trial(tried: Attempts, state: State) -> Trial:
    """Next trial, no longer than to where the step ends at most."""
    h = smaller(state.step_size, tried.s.largest_step)
    if tried.is_fixed and tried.avoided == 0:
        h = tried.s.fixed_step
    is_last = not tried.is_beyond and state.time + STRETCH_TO_END * h >= tried.end
    if is_last:
        h = tried.end - state.time
    if not h > SMALLEST * larger(abs(state.time), abs(tried.end)):
        tried.status = Status.STEP_TOO_SMALL
    return Trial(h, tried.end if is_last else state.time + h, is_last)


def is_weak(ratio: float, tried: Attempts, state: State) -> bool:
    """Whether rows are nearly dependent at a pivot ratio."""
    return (
        ratio
        < (VAGUE_PIVOT_RATIO if tried.is_fixed else WEAK_PIVOT_RATIO) * state.largest_pivot_ratio
    )


def is_made(tried: Attempts, trial: Trial, work: Work, state: State) -> bool:
    """Make the stages of a trial; return False where they lead nowhere, or to no place to stop."""
    forget_trials(work)
    make_stages(tried.m, tried.s.tolerance, trial, work, state)
    trial.is_good = trial.drift >= 0.0
    if work.scene.has_drivers and not tried.is_fixed and trial.drift > MOST_DRIVEN_CORRECTION:
        trial.is_good = False  # no error tells how far drivers led
    if tried.is_fixed and not trial.is_good:
        ratio = smaller(trial.least_ratio, ratio_at(work.y[: work.scene.nq], work, state))
        if not is_weak(ratio, tried, state):  # Newton has gone far away
            tried.status = Status.NOT_PROJECTED
            return False
        trial.least_ratio = 0.0
    # the end is to lie inside of a longer step then
    if trial.is_last and is_weak(trial.least_ratio, tried, state):
        tried.is_beyond = True
        state.avoided += 1
        return False
    return True


def is_clear(tried: Attempts, trial: Trial, state: State) -> bool:
    """Whether rows are independent at the stages of a trial: else the next has others."""
    if not (trial.is_good or tried.is_fixed) or not is_weak(trial.least_ratio, tried, state):
        return True
    if trial.least_ratio > 0.0 and is_weak(trial.most_ratio, tried, state):
        # it is so everywhere: shorter steps stay there
        state.largest_pivot_ratio = trial.least_ratio / (
            VAGUE_PIVOT_RATIO if tried.is_fixed else WEAK_PIVOT_RATIO
        )
    elif tried.avoided <= MOST_AVOIDED:
        if trial.least_ratio > tried.best:
            tried.best, tried.best_h = trial.least_ratio, trial.h
        state.step_size = (
            AVOIDING_STEP_PART * trial.h if tried.avoided < MOST_AVOIDED else tried.best_h
        )
        tried.avoided += 1
        state.avoided += 1
        return False
    trial.is_whole = trial.least_ratio > 0.0
    return True


def is_tried(tried: Attempts, trial: Trial, work: Work, state: State) -> bool:
    """Make a trial and its error, not what crosses in it; return False where it tells nothing."""
    if not is_made(tried, trial, work, state):
        return False
    if trial.is_good:
        find_error(tried, trial, work, state)
    trial.is_whole = trial.is_good
    is_wanted = tried.has_switching or tried.asked < trial.end
    if trial.is_good and is_kept(trial) and is_wanted:
        # rows that are asked for make stages, too, and no step shorter
        is_searched = tried.has_switching and not tried.is_fixed
        trial.is_whole = make_dense_stages(tried.m, trial, work, state) and not (
            is_searched and is_thrown_off(tried.m, trial, work)
        )
    if not is_clear(tried, trial, state):
        return False
    if tried.is_fixed and not trial.is_whole:
        tried.status = Status.NOT_PROJECTED
        return False
    if trial.is_whole and is_kept(trial):
        trial.branch = branch_of(tried, trial, work, state)
        if trial.branch == BRANCH_LOST and not tried.is_fixed:
            trial.is_whole = not work.w.way_of(trial.h, state.y, work.y) > SHORTEST_BRANCH_WAY
    if not trial.is_whole:
        trial.error = REFUSED_ERROR
    return True


def keep(tried: Attempts, trial: Trial, work: Work, state: State) -> None:
    """Keep a trial, and note its crossings, and whether it leaves parts unresolved."""
    search, before = tried.search, state.step_size
    accept(tried, trial, work, state)
    if not work.scene.is_searched:
        return
    if work.scene.has_functions:
        note_crossings(trial.end, search)
    if search.is_unresolved:
        note_unresolved(state.time_before, state)
    if state.time == search.cut:
        state.step_size = larger(state.step_size, before)
        state.switched = state.time


def step(
    m: RungeKuttaMethod, s: Settings, asked: float, end: float, state: State, work: Work
) -> Status:
    """Make one step; return Status.GOOD, or why there is none.

    It goes to the end at most, unless rows are nearly dependent there. The error decides how long
    it is, unless a length is asked for. If the next time to be written lies inside of it, it has
    the stages that its polynomial wants.
    """
    is_fixed, has_switching = s.fixed_step > 0.0, len(state.sides) > work.scene.n_poles
    search = Search(state, work, state.time, has_error=has_switching and not is_fixed)
    tried = Attempts(m, s, search, asked, end, end, is_fixed, has_switching)
    work.k[0] = state.f
    while True:
        trial = next_trial(tried, state)
        is_judged = tried.status == Status.GOOD and is_tried(tried, trial, work, state)
        if is_judged and ends_well(tried, trial, work, state):
            if is_kept(trial):
                keep(tried, trial, work, state)
                return Status.GOOD
            tried.is_rejected = True
            state.rejected += 1
            state.step_size = length_by_error(m, trial)
        if tried.status != Status.GOOD:
            return tried.status


def first_step(m: RungeKuttaMethod, s: Settings, end: float, state: State, work: Work) -> Status:
    """Choose a first step for which an Euler step changes the derivative little."""
    f, y, nq, size_of = work.k[0], work.k[1], work.scene.nq, work.w.size_of
    forget_trials(work)
    span = end - state.time
    speed = size_of(state.y[nq:])
    if speed * span > NOTHING_MOVES:  # rates of what moves already are known
        state.stride = smaller(FIRST_STEP_MOTION / speed, span)
    rate = larger(speed, math.sqrt(size_of(state.f[nq:])))
    h = smaller(FIRST_STEP_MOTION / rate if rate > 0.0 else FIRST_STEP_SPAN_PART * span, span)
    y[:] = state.y + h * state.f
    if project(state.time + h, 0.0, y, None, f, work, state) < 0.0:
        return Status.STEP_TOO_SMALL
    # powers of numbers without a unit: in other units of time bits are the same
    jerk, unit = size_of((f - state.f)[nq:]) / h, larger(rate, 1.0 / span)
    rate = larger(rate, unit * (jerk / unit / unit / unit) ** (1.0 / 3.0))
    by_order = (FIRST_STEP_MOTION * s.tolerance) ** (1.0 / m.order) / rate if rate > 0.0 else span
    state.step_size = smaller(smaller(MOST_FIRST_FACTOR * h, by_order), span)
    return Status.GOOD
