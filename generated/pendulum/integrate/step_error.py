"""Error of a step, in units of the tolerance, and the step length that it asks for."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from .arithmetic import larger, mean_square, smaller
from .dense_output import combine
from .motion_scales import energy_moved, energy_of_works, usual_rate
from .pivot_monitor import note_largest_pivot
from .projection import displacement_of, take_normal_part
from .row_switch import check_misses
from .search import LOOSEST_AT_SWITCH
from .switching import sampling_in
from .trial import MANY_STAGES, MOST_SHORTER, Attempts, Trial, add_to_start, is_kept
from .variation import COARSE, FINEST

if TYPE_CHECKING:
    from collections.abc import Sequence

    from .methods import RungeKuttaMethod
    from .scene_tables import Work
    from .state import State

#: A rejected step is cut for a crossing no earlier than at this part of its length: what its
#: polynomial shows before that is not believed. A step of fixed length is treated alike if its
#: relative error is larger than this number.
LEAST_PART = 0.02
#: Part of the constraint-normal error that is discounted. All of it is with drivers, which are
#: exact, and near a singularity, where it is rounding.
FORGIVEN_NORMAL_PART = 0.5
#: Pivot ratio, relative to the largest so far, below which a step counts as near a singularity: its
#: constraint-normal error and its drift are rounding there.
CLEAR_PIVOT_RATIO = 1e-3
#: Largest drift of a step off the constraints, in tolerances: half of what the verdict on a run
#: trusts. Estimates can be blind where bodies turn by some radians in a step, the drift is not.
MOST_DRIFT = 50.0
#: Smallest tolerance that this limit of the drift is computed with.
LEAST_DRIFT = 1e-11
#: Weight of the worse of the two estimates of DOP853 where the better one may be blind. Steps from
#: a switch to the next begin and end at the same phases of a periodic force, so that their errors
#: have one sign and add up. For a half-wave of a sine in one step of DOP853 the better estimate is
#: 4 times too small; the weighted worse one is 10 times too large. Over a steep rise of a force
#: both have been blind.
WORSE_ERROR_PART = 4e-3
#: Factor of the estimated error where the two results that an estimate compares are off alike. They
#: are from a place on where a force goes with t^p: the error is 64 times the estimate for p = 0.1,
#: 37 times for a square root and 11 times for p = 1.5. Over steep rises of forces the error of one
#: step in 200 is more than 100 times the estimate without this factor.
BLIND_ERROR = 40.0
#: The same factor for methods with many stages, where the error is 7, 5 and 3 times the estimate
#: for these p.
BLIND_ERROR_OF_MANY_STAGES = 5.0
#: Safety factor of the step-size control h SAFETY error^(-0.8 / k) error_before^(0.2 / k) with the
#: order k, see docs/dynamics.md. It is the PI controller of Gustafsson, ACM Trans. Math. Softw. 17
#: (1991), with k_P = 0.2 / k and k_I + k_P = 0.8 / k.
SAFETY = 0.8
#: Smallest ratio of a step length to the one before.
LEAST_STEP_FACTOR = 0.2
#: Weight of the estimate e_2 of order 3 beside e of order 5 in the error of DOP853, e^2 / sqrt(e^2
#: + 0.01 e_2^2): it goes with h^8 as the error does. Hairer, Nørsett, Wanner, II.10.
WORSE_ESTIMATE_PART = 0.01


def estimate(
    m: RungeKuttaMethod,
    row: Sequence[float],
    trial: Trial,
    state: State,
    work: Work,
    tolerance: float,
) -> float:
    """Root mean square of one estimate of the error, in units of the tolerance.

    A row (stages + 1,) [-] of the method has the weights of derivatives at stages.
    """
    scene, now, end, error = work.scene, state.y, work.y, work.scratch
    nq, nv = scene.nq, scene.nv
    rate = usual_rate(trial.h, end, state, work)
    combine(m.stages + 1, row, None, trial.h, work.k, error)
    errors = np.empty((2, nv))
    displacement_of(scene, end, error, errors[0])
    errors[1] = error[nq:]
    is_clear = (
        not scene.has_drivers and trial.least_ratio >= CLEAR_PIVOT_RATIO * state.largest_pivot_ratio
    )
    for u in errors:
        take_normal_part(FORGIVEN_NORMAL_PART if is_clear else 1.0, end[nq:], work, u)
    errors[0] /= scene.lengths
    errors[1] /= rate * scene.lengths + np.maximum(np.abs(now[nq:]), np.abs(end[nq:]))
    works = slice(nq - scene.works, nq)  # work is compared with the energy that moves
    moved = m.work_scale * larger(state.moved, trial.moved)
    least = energy_of_works(trial.h, end, moved, state, work) + work.w.energies[0]
    size = least + np.maximum(np.abs(now[works]), np.abs(end[works]))
    all_errors = np.concatenate((errors.ravel(), error[works] / size))
    return math.sqrt(mean_square(all_errors, 2 * nv)) / tolerance


def tells_drift(trial: Trial, state: State, work: Work) -> bool:
    """Whether the drift of a step off the constraints is due to its error.

    It is not where drivers or rows that take over cause it, or near a singularity, by rounding.
    """
    if work.scene.has_drivers or work.row_switch is not None:
        return False
    return trial.least_ratio >= CLEAR_PIVOT_RATIO * state.largest_pivot_ratio


def local_error(
    m: RungeKuttaMethod,
    trial: Trial,
    state: State,
    work: Work,
    tolerance: float,
) -> tuple[float, float]:
    """Error of a step, in units of the tolerance, and if the better of two estimates is blind."""
    e = estimate(m, m.errors[0], trial, state, work, tolerance)
    if len(m.errors) == 1 or e * e == 0.0:
        return e, e
    e2 = estimate(m, m.errors[1], trial, state, work, tolerance)
    best = e * e / math.sqrt(e * e + WORSE_ESTIMATE_PART * e2 * e2)
    return best, larger(best, WORSE_ERROR_PART * e2)


def norm_error(m: RungeKuttaMethod, h: float, state: State, work: Work) -> float:
    """Distance of Euler parameters from norm one after a step, before they are brought back.

    Where steps are fixed no other error tells that bodies turn too far in one.
    """
    y, error = work.scratch, 0.0
    combine(m.stages, m.a[m.stages], state.low, h, work.k, y)
    add_to_start(state.y, y, None)
    for index, _, count in work.scene.orientations:
        square = 0.0
        for x in y[index : index + count].tolist():
            square += x * x
        error = larger(error, abs(math.sqrt(square) - 1.0))
    return error


def is_near_power(tried: Attempts, trial: Trial, work: Work, state: State) -> bool:
    """Whether a trial is beside a fractional power of what is zero.

    A force has no two derivatives there, and estimates of errors from there on are too small.
    """
    is_beside = state.time - state.switched < trial.h or trial.end == tried.search.cut
    return work.scene.has_fractional_powers and is_beside


def error_where_coarse(tried: Attempts, trial: Trial) -> float:
    """Error of a trial in which samples are few for how a part varies: as if estimates were blind.

    Beside an infinite force, and where rounding decides, samples are few in every step, however
    short. So this is done a limited number of times, and not in a step that is a tiny part of the
    time.
    """
    tried.coarse += 1
    tiny = FINEST * larger(abs(trial.end), abs(tried.limit))
    if not (tried.coarse <= MOST_SHORTER and trial.h > tiny):
        return trial.error
    return larger(trial.error, trial.error_if_blind)


def find_error(tried: Attempts, trial: Trial, work: Work, state: State) -> None:
    """Find the error of a trial whose end is in the workspace, and the energy that has moved."""
    m, s = tried.m, tried.s
    if tried.is_fixed:
        trial.drift = larger(trial.drift, norm_error(m, trial.h, state, work))
    if work.scene.works > 0 or s.checks:
        work.w.run("energy")
        trial.moved = energy_moved(work.y, work, state)
    if tried.is_fixed:
        is_seen = work.scene.has_functions
        trial.is_vague = is_seen and not local_error(m, trial, state, work, LEAST_PART)[0] <= 1.0
    else:
        is_behind = state.time == state.switched
        has_kinks = work.scene.has_functions and work.scene.n_breaks == 0
        is_locked = trial.is_last and is_behind
        is_locked = is_locked and tried.end in {state.limit, tried.search.cut}
        is_close = is_locked or (is_behind and has_kinks)
        tolerance = smaller(s.tolerance, LOOSEST_AT_SWITCH) if is_close else s.tolerance
        blind = BLIND_ERROR_OF_MANY_STAGES if m.stages >= MANY_STAGES else BLIND_ERROR
        best, worse = local_error(m, trial, state, work, tolerance)
        trial.error = worse if is_locked else best
        trial.error *= blind if is_near_power(tried, trial, work, state) else 1.0
        trial.error_if_blind = blind * worse
        # of what varies with the state the polynomial is asked, later
        is_asked = work.scene.has_features and is_kept(trial) and trial.error_if_blind > 1.0
        if is_asked and sampling_in(s.tolerance, state.time, trial.end, work.w) == COARSE:
            trial.error = error_where_coarse(tried, trial)
        if tells_drift(trial, state, work):
            largest_drift = MOST_DRIFT * larger(s.tolerance, LEAST_DRIFT)
            trial.error = larger(trial.drift / largest_drift, trial.error)
    if is_kept(trial):
        note_largest_pivot(work, state)
        work.w.run("coordinate")
        check_misses(s, work)


def length_by_error(m: RungeKuttaMethod, trial: Trial) -> float:
    """Length [s] of the next trial, where one does not meet the tolerance or find its branch."""
    factor = LEAST_STEP_FACTOR
    if trial.longest > 0.0:
        return trial.longest
    if math.isfinite(trial.error):
        factor = larger(factor, SAFETY * trial.error ** (-1.0 / m.order))
    return factor * trial.h
