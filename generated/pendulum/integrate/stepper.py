"""The stepper: an explicit Runge-Kutta step, its error, and how long the next one is."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from .arithmetic import larger, mean_square, rounding_of_sum, smaller
from .branches import BRANCH_LOST, ON_BRANCH, follow_branch, note_branch
from .crossing import (
    COARSE,
    FINEST,
    LOOSEST_AT_SWITCH,
    ONWARD,
    SMALLEST,
    STRETCH_TO_END,
    Search,
    are_narrow_resolved,
    begin_search,
    crossing_end,
    cut_at,
    end_before_pole,
    is_at_pole,
    note_crossings,
    note_unresolved,
    polished_cut,
    resolved_end,
    stage_beyond,
    why_stopped,
)
from .dense_output import combine
from .pivot_monitor import (
    VAGUE_PIVOT_RATIO,
    WEAK_PIVOT_RATIO,
    branch_ratio,
    note_largest_pivot,
    note_pivot_ratio,
    usual_ratio,
)
from .projection import (
    check_digits,
    displacement_of,
    last_ratio,
    project,
    ratio_at,
    take_normal_part,
)
from .row_switch import check_misses, forget_trials, note_misses
from .settings import NOTHING_MOVES, Status
from .switching import sampling_in

if TYPE_CHECKING:
    from collections.abc import Sequence

    from .arithmetic import Array
    from .methods import RungeKuttaMethod
    from .scene_tables import SceneTables, Work
    from .settings import Settings
    from .state import State

#: Largest constraint correction that may be left at a stage inside of a step, in units of the
#: tolerance.
STAGE_RESIDUAL = 1e-3
#: How often a step is shortened at most because rows are nearly dependent at one of its stages;
#: then the length with the largest pivot ratio is taken.
MOST_AVOIDED = 8
#: Factor by which such a step is shortened each time, so that its stages lie elsewhere.
AVOIDING_STEP_PART = 0.9
#: How often a step is made again at most for each of three reasons: samples do not resolve a part
#: that varies with the state, a stage lies beyond a switch that the polynomial does not meet, or
#: samples are few for how a part varies.
MOST_SHORTER = 8
#: Reject a step if a stage with zero weight at its end has accelerations more than this many times
#: those of the other stages, and the speeds at its end over its length.
THROWN_OFF = 10.0
#: A rejected step is cut for a crossing no earlier than at this part of its length: what its
#: polynomial shows before that is not believed. A step of fixed length is treated alike if its
#: relative error is larger than this number.
LEAST_PART = 0.02
#: Largest number of re-locations of an event that cuts a step.
MOST_POLISHED = 3
#: Largest constraint correction of a step with drivers, in lengths of the scene or radians: no
#: error tells how far drivers led.
MOST_DRIVEN_CORRECTION = 1e-3
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
#: Earliest part of a step at which a stage gives the third point of a parabola through the branch
#: ratios at its ends: branch ratios go with the square of the distance from a place where branches
#: meet.
INNER_STAGE_PART = 0.25
#: Check a step for other branches if its smallest branch ratio, by this parabola or at a stage, is
#: below this part of the larger ratio at its ends.
FALLEN_RATIO_PART = 0.1
#: Check a step for other branches, too, if a stage has a branch ratio below this part of the
#: smaller ratio at its ends.
DIPPED_RATIO_PART = 0.75
#: Check a step for other branches, too, if a branch ratio at its ends is below this part of the
#: largest so far and the step is long in the sense of FAR_WAY_PART.
SMALL_RATIO_PART = 1e-3
#: A step is long if bodies move in it by more than this part of the distance to the place where
#: branches meet, taken as the root of the larger branch ratio at its ends over the largest so far.
FAR_WAY_PART = 0.5
#: Longest motion of bodies in a step that is checked for other branches, in lengths of the scene or
#: radians: how branch ratios vary is not known over longer ones.
LONGEST_NEAR_BRANCHES = 0.75
#: Tolerance above which the motion in every step is limited, so that no stages pass by a place
#: where branches meet. Where drivers determine the motion it is so at every tolerance.
LOOSE_TOLERANCE = 1e-3
#: Longest motion of bodies in a step that is limited for this reason, in lengths of the scene or
#: radians.
LONGEST_IF_LOOSE = 1.2
#: Number of stages from which on a method has many: they lie twice as densely in a step.
MANY_STAGES = 12
#: Longest motion of bodies, instead of LONGEST_IF_LOOSE, where drivers determine it and the method
#: has many stages. Two bodies turn towards each other by twice as much, which is less than half a
#: turn: no step passes two places where branches meet.
LONGEST_OF_MANY_STAGES = 1.5
#: These limits do not apply where the smallest branch ratio in a step exceeds this part of the
#: largest: no place where branches meet is passed by if ratios are as level as that.
LEVEL_RATIO_PART = 0.999
#: Factor of the estimated error where the two results that an estimate compares are off alike. They
#: are from a place on where a force goes with t^p: the error is 64 times the estimate for p = 0.1,
#: 37 times for a square root and 11 times for p = 1.5. Over steep rises of forces the error of one
#: step in 200 is more than 100 times the estimate without this factor.
BLIND_ERROR = 40.0
#: The same factor for methods with many stages, where the error is 7, 5 and 3 times the estimate
#: for these p.
BLIND_ERROR_OF_MANY_STAGES = 5.0
#: The root of the branch ratio may have changed its sign between two stages if a line through the
#: roots at one of them and at the stage beyond it leads to less than this part of the root at the
#: other one.
SIGN_CHANGE_PART = 0.2
#: Safety factor of a step length that follows from a longest motion of bodies.
LIMITED_STEP_PART = 0.98
#: Motion of bodies in a step, in lengths of the scene or radians, below which it is not shortened
#: any more to find its branch.
SHORTEST_BRANCH_WAY = 1e-4
#: Safety factor of the step-size control h SAFETY error^(-0.8 / k) error_before^(0.2 / k) with the
#: order k, see docs/dynamics.md. It is the PI controller of Gustafsson, ACM Trans. Math. Softw. 17
#: (1991), with k_P = 0.2 / k and k_I + k_P = 0.8 / k.
SAFETY = 0.8
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
#: Smallest ratio of a step length to the one before.
LEAST_STEP_FACTOR = 0.2
#: Error, in units of the tolerance, of a trial that cannot be kept and whose error tells nothing:
#: the next one is much shorter.
REFUSED_ERROR = 1e3
#: Weight of the estimate e_2 of order 3 beside e of order 5 in the error of DOP853, e^2 / sqrt(e^2
#: + 0.01 e_2^2): it goes with h^8 as the error does. The same book, II.10.
WORSE_ESTIMATE_PART = 0.01
#: Scale of velocity errors, beside the velocities: the running maximum speed, clamped to between
#: NOTHING_MOVES over the longest step so far and this number over the step, in lengths of the scene
#: or radians. Below the lower bound speeds are rounding; it is no larger in a short step, as the
#: rates of what does move are not.
USUAL_STEP_MOTION = 0.05
#: Motion of bodies in the Euler step that precedes the first step, in lengths of the scene or
#: radians: it tells how derivatives change. Also the factor of the tolerance from which the length
#: of the first step follows. The same book, II.4.
FIRST_STEP_MOTION = 0.01
#: Length of this Euler step where nothing moves yet, relative to the whole time.
FIRST_STEP_SPAN_PART = 1e-6
#: Largest ratio of the first step to this Euler step.
MOST_FIRST_FACTOR = 100.0


@dataclass(slots=True)
class Trial:
    """A step that is tried.

    Parameters
    ----------
    h, end : float [s]
        Its length, and the time of its end.
    is_last : bool
        Whether it ends at the latest time that the step may reach.
    drift, error : float
        Correction of its end onto the constraints, in lengths of the scene or radians, negative
        where a stage is impossible; error in units of the tolerance.
    error_if_blind : float
        Error to be taken where estimates may be blind: the worse estimate times its factor.
    moved : float [J]
        Energy that has moved up to its end, where rows are checked or there are works.
    least_ratio, most_ratio, last_ratio : float
        Smallest and largest pivot ratio of its stages, and pivot ratio of its end.
    end_ratio, top_ratio : float
        Branch ratio at its end, see ``pivot_monitor.py``, and largest one of its stages.
    inner_ratio, inner : float
        Branch ratio of a stage inside, and its part of the step; 0 where there is none yet.
    dip_ratio, dip : float
        Smallest branch ratio of the stages inside, and its part of the step.
    parts, roots : list of float
        Parts of the step in order, with that of a stage of the step before, which is negative, and
        roots of the branch ratio there.
    branch : int
        Verdict on whether it may end on another branch, see ``branches.py``.
    longest : float [s]
        Length at which its ratios tell of other branches, where it is longer, else 0.
    is_good, is_whole : bool
        Whether all stages up to its end exist, and whether it may be kept if its error is small.
    is_vague : bool
        Whether its length is fixed and its relative error is larger than ``LEAST_PART``.
    """

    h: float
    end: float
    is_last: bool
    drift: float = 0.0
    error: float = 0.0
    error_if_blind: float = 0.0
    moved: float = 0.0
    least_ratio: float = 1.0
    most_ratio: float = 0.0
    last_ratio: float = 1.0
    end_ratio: float = 1.0
    top_ratio: float = 0.0
    inner_ratio: float = 0.0
    inner: float = 0.0
    dip_ratio: float = math.inf
    dip: float = 0.0
    parts: list[float] = field(default_factory=list)
    roots: list[float] = field(default_factory=list)
    branch: int = ON_BRANCH
    longest: float = 0.0
    is_good: bool = False
    is_whole: bool = False
    is_vague: bool = False


@dataclass(slots=True)
class Attempts:
    """The attempts to make a step.

    Parameters
    ----------
    m, s : RungeKuttaMethod, Settings
        How it is made.
    search : Search
        For what crosses in the last one.
    asked, end, limit : float [s]
        Next time to be written; latest end of the step, now and before it was cut.
    is_fixed, has_switches : bool
        Whether its length is asked for; whether formulas of the state switch, or tell events.
    best : float
        Largest pivot ratio of a trial with nearly dependent rows, each taken at its worst stage.
    best_h : float [s]
        Length of this trial.
    avoided : int
        Number of trials with nearly dependent rows.
    is_beyond : bool
        Whether the step is to go beyond its latest end, where rows are nearly dependent.
    is_rejected : bool
        Whether a trial had too large an error.
    is_guessed : bool
        Whether a trial was cut short for anything but a distance or a jump.
    shorter : int
        How often samples of parts that vary with the state were looked at to shorten a trial.
    thrown : int
        How often a trial was shortened for a stage beyond a switch that its polynomial misses.
    coarse : int
        How often samples were few for how a part varies in a trial.
    polished : int
        How often an event was located again.
    status : Status
        ``GOOD``, or why there is no step.
    """

    m: RungeKuttaMethod
    s: Settings
    search: Search
    asked: float
    end: float
    limit: float
    is_fixed: bool
    has_switches: bool
    best: float = -1.0
    best_h: float = 0.0
    avoided: int = 0
    is_beyond: bool = False
    is_rejected: bool = False
    is_guessed: bool = False
    shorter: int = 0
    thrown: int = 0
    coarse: int = 0
    polished: int = 0
    status: Status = Status.GOOD


def is_kept(trial: Trial) -> bool:
    """Whether a trial meets the tolerance."""
    return trial.error <= 1.0


def add_to_start(start: Array, y: Array, low: Array | None) -> None:
    """Add the start (ny,) of a step to an increment y (ny,), a small sum, rounded once.

    The remainder of that rounding goes to low (ny,) if it is not None.
    """
    total = start + y
    if low is not None:
        low[:] = rounding_of_sum(start, y, total)
    y[:] = total


def fastest(end: Array, state: State, work: Work) -> float:
    """Largest speed so far and at the end (ny,) of a step, in lengths and radians [1/s]."""
    size_of, nq = work.w.size_of, work.scene.nq
    return larger(larger(state.fastest, size_of(state.y[nq:])), size_of(end[nq:]))


def usual_rate(h: float, end: Array, state: State, work: Work) -> float:
    """Rate that rates of a step are compared with, in lengths of the scene and radians [1/s].

    It is that of the motion up to the end (ny,) of a step of h [s], the same in all units of time.
    """
    speed = fastest(end, state, work)
    return smaller(USUAL_STEP_MOTION / h, larger(NOTHING_MOVES / larger(state.stride, h), speed))


def note_motion(h: float, end: Array, state: State, work: Work) -> None:
    """Note what later steps are compared with, at the end (ny,) of one of h [s]."""
    state.fastest = fastest(end, state, work)
    state.stride = larger(state.stride, h)


def note_extent(end: Array, work: Work, state: State) -> None:
    """Note the ranges of coordinates, also of those that rows show, at the end (ny,) of a step."""
    scene, w = work.scene, work.w
    reached = np.concatenate((end[: scene.nq], w.coordinates[:: scene.per_shown]))
    state.lowest[:] = np.where(reached < state.lowest, reached, state.lowest)
    state.highest[:] = np.where(reached > state.highest, reached, state.highest)


def usual_energy(rate: float, scene: SceneTables) -> float:
    """Energy [J] of all bodies where they move at such a rate [1/s]."""
    return scene.mass * (scene.length * rate) * (scene.length * rate) / 2.0


def energy_of_works(h: float, end: Array, moved: float, state: State, work: Work) -> float:
    """Energy [J] that errors of works are compared with, where so much [J] has moved in h [s].

    It is that of all bodies at the usual rate up to the end (ny,), or the energy that has moved if
    that is less: where one body is fast, heavy ones may stand. It is no less than that of all
    bodies at a rate that counts as rest.
    """
    usual = usual_energy(usual_rate(h, end, state, work), work.scene)
    least = usual_energy(NOTHING_MOVES / larger(state.stride, h), work.scene)
    return smaller(usual, larger(least, moved))


def energy_balance(q: Array, work: Work, state: State) -> float:
    """Change of energy [J] since the start that no work explains; works are in q (nq,)."""
    balance = work.w.energies[0] + work.w.energies[1] - state.energy
    for done in q[work.scene.nq - work.scene.works : work.scene.nq]:
        balance -= done
    return float(balance)


def energy_moved(q: Array, work: Work, state: State) -> float:
    """Kinetic energy, change of potential energy since the start, and all works [J].

    Works are in q (nq,). That of every step counts, whatever rows are written.
    """
    kinetic, potential = work.w.energies
    moved = kinetic + abs(potential - state.potential)
    for done in q[work.scene.nq - work.scene.works : work.scene.nq]:
        moved += abs(done)
    return float(moved)


def note_moved(s: Settings, moved: float, state: State) -> None:
    """Note the energy that has moved at the end of a step that is kept."""
    state.moved = larger(state.moved, moved)
    if s.checks:
        state.energy_moved = larger(state.energy_moved, moved)


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


def stage(
    m: RungeKuttaMethod,
    n: int,
    h: float,
    tolerance: float,
    y: Array,
    low: Array | None,
    work: Work,
    state: State,
) -> float:
    """Make the n-th stage of a step of h [s]: y (ny,) on the manifold, or near enough to it.

    Its derivative goes to row n of ``work.k``, what rounding leaves over of y to low (ny,). Returns
    the first correction [-], relative to a length of the scene, negative where that is impossible.
    """
    combine(n, m.a[n], state.low, h, work.k, y)
    add_to_start(state.y, y, low)
    return project(state.time + m.c[n] * h, tolerance, y, low, work.k[n], work, state)


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


def note_root(part: float, root: float, trial: Trial) -> None:
    """Note the root of the branch ratio at a part of a step, in order."""
    n = len(trial.parts)
    while n > 0 and trial.parts[n - 1] >= part:
        n -= 1
    if n < len(trial.parts) and trial.parts[n] == part:
        trial.roots[n] = root
        return
    trial.parts.insert(n, part)
    trial.roots.insert(n, root)


def note_stage_ratios(part: float, trial: Trial, work: Work, state: State) -> None:
    """Note the pivot ratio and the branch ratio of a stage at a part of a step."""
    trial.last_ratio = last_ratio(work, state)
    trial.least_ratio = smaller(trial.least_ratio, trial.last_ratio)
    trial.most_ratio = larger(trial.most_ratio, trial.last_ratio)
    is_driven = work.scene.is_driven
    trial.end_ratio = branch_ratio(work, state) if is_driven else trial.last_ratio
    if not work.scene.has_refinement:
        return
    trial.top_ratio = larger(trial.top_ratio, trial.end_ratio)
    if not is_driven:
        note_root(part, math.sqrt(trial.end_ratio), trial)
    if trial.inner == 0.0 and part >= INNER_STAGE_PART:
        trial.inner_ratio, trial.inner = trial.end_ratio, part
    if part < 1.0 and trial.end_ratio < trial.dip_ratio:
        trial.dip_ratio, trial.dip = trial.end_ratio, part


def make_stages(
    m: RungeKuttaMethod, tolerance: float, trial: Trial, work: Work, state: State
) -> None:
    """Make the stages from which the end of the step is made, as far as they are possible."""
    if work.scene.has_refinement and not work.scene.is_driven:
        note_root(0.0, math.sqrt(state.position_ratio), trial)
        if state.stage_before > 0.0:
            note_root(-state.stage_before / trial.h, state.root_before, trial)
    for n in range(1, m.stages + 1):
        low = None if n < m.stages else work.low
        allowed = STAGE_RESIDUAL * tolerance if low is None else 0.0
        trial.drift = stage(m, n, trial.h, allowed, work.y, low, work, state)
        if trial.drift >= 0.0 and low is not None:
            check_digits(work.k[n], work, state)
        note_stage_ratios(m.c[n], trial, work, state)
        if trial.drift < 0.0:
            return


def make_dense_stages(m: RungeKuttaMethod, trial: Trial, work: Work, state: State) -> bool:
    """Make the stages that only the interpolating polynomial wants; return whether they are."""
    for n in range(m.stages + 1, m.all):
        if stage(m, n, trial.h, 0.0, work.scratch, None, work, state) < 0.0:
            trial.least_ratio = 0.0
            return False
        trial.least_ratio = smaller(trial.least_ratio, last_ratio(work, state))
    return True


def is_thrown_off(m: RungeKuttaMethod, trial: Trial, work: Work) -> bool:
    """Whether stages with zero weight at its end meet a force that the others of a trial miss.

    The force makes its polynomial useless, and its error does not tell of it: it is too long.
    """
    nq, size_of, weights = work.scene.nq, work.w.size_of, (*m.a[m.stages], 1.0)
    counted, uncounted = size_of(work.y[nq:]) / trial.h, 0.0
    for n in range(m.all):
        size = size_of(work.k[n][nq:])
        if n <= m.stages and weights[n] != 0.0:
            counted = larger(counted, size)
        else:
            uncounted = larger(uncounted, size)
    return uncounted > THROWN_OFF * counted


def least_of_parabola(trial: Trial, state: State) -> float:
    """Minimum of a parabola through branch ratios of a step, and of those at its stages."""
    first, last, x = state.position_ratio, trial.end_ratio, trial.inner
    quadratic = ((trial.inner_ratio - first) / x - (last - first)) / (x - 1.0)
    slope = last - first - quadratic
    is_inside = slope < 0.0 < 2.0 * quadratic + slope
    least = first - slope * slope / (4.0 * quadratic) if is_inside else last
    return smaller(least, smaller(trial.dip_ratio, last))


def falls_to(part: float, trial: Trial, state: State, work: Work) -> bool:
    """Whether the smallest branch ratio of a step is below a part of the larger one at its ends."""
    ends = larger(state.position_ratio, trial.end_ratio)
    return least_of_parabola(trial, state) < part * smaller(ends, usual_ratio(work, state))


def meeting_part(first: float, last: float) -> float:
    """Part of a step at which branches seem to meet, from roots of branch ratios at its ends.

    These roots go with the distance from the place where branches meet.
    """
    return first / (first + last) if first + last > 0.0 else 0.5


def dipping_part(first: float, last: float, trial: Trial) -> float:
    """Part at which branches seem to meet, before or behind a stage with a small branch ratio."""
    dip, x = math.sqrt(trial.dip_ratio), trial.dip
    if meeting_part(first, last) > x:
        return x + (1.0 - x) * dip / (dip + last)
    return x * first / (first + dip)


def sign_change(trial: Trial) -> tuple[float, float]:
    """Part of a step at which roots of branch ratios change their sign, and their slope there.

    These roots go with the distance from a place where branches meet, but are known without a sign:
    lines through two of them tell the sign of the next. The slope is 0 if none changes its sign.
    """
    x, r = trial.parts, trial.roots
    part, slope, least = 0.0, 0.0, math.inf
    for k in range(len(x) - 1):
        width, total = x[k + 1] - x[k], r[k] + r[k + 1]
        if not x[k + 1] > 0.0 or not total < least:
            continue
        ahead, back = math.inf, math.inf
        if k > 0:
            ahead = r[k] + width * (r[k] - r[k - 1]) / (x[k] - x[k - 1])
        if k + 2 < len(x):
            back = r[k + 1] - width * (r[k + 2] - r[k + 1]) / (x[k + 2] - x[k + 1])
        if ahead < SIGN_CHANGE_PART * r[k + 1] or back < SIGN_CHANGE_PART * r[k]:
            part, slope, least = x[k] + width * meeting_part(r[k], r[k + 1]), total / width, total
    return part, slope


def longest_way(tried: Attempts, trial: Trial, work: Work, state: State) -> float:
    """Longest motion of a step whose stages show branches, in lengths and rad, or infinite."""
    is_loose = work.scene.is_driven or tried.s.tolerance > LOOSE_TOLERANCE
    if not work.scene.has_refinement or not is_loose or tried.is_fixed:
        return math.inf
    top = larger(state.position_ratio, trial.top_ratio)
    if smaller(trial.dip_ratio, trial.end_ratio) > LEVEL_RATIO_PART * top:
        return math.inf
    is_dense = work.scene.is_driven and tried.m.stages >= MANY_STAGES
    return LONGEST_OF_MANY_STAGES if is_dense else LONGEST_IF_LOOSE


def is_short(longest: float, trial: Trial, state: State, work: Work) -> bool:
    """Whether bodies move in a step by no more than the longest way: else it is made again."""
    travel = work.w.way_of(trial.h, state.y, work.y) if longest < math.inf else 0.0
    if not travel > longest:
        return True
    if work.scene.is_driven:  # free bodies pass places where branches meet by momentum
        trial.longest = LIMITED_STEP_PART * trial.h * (longest / travel)
    return False


def branch_of(tried: Attempts, trial: Trial, work: Work, state: State) -> int:
    """Whether a step may end on another branch: BRANCH_LOST, ON_BRANCH or BIFURCATION."""
    if not work.scene.has_refinement:
        return ON_BRANCH
    first, last, most = state.position_ratio, trial.end_ratio, usual_ratio(work, state)
    if not is_short(longest_way(tried, trial, work, state), trial, state, work):
        return BRANCH_LOST
    is_dip = trial.dip_ratio < DIPPED_RATIO_PART * smaller(first, last)
    part, slope = sign_change(trial)
    is_falling = is_dip or slope > 0.0 or falls_to(FALLEN_RATIO_PART, trial, state, work)
    if not is_falling and not smaller(first, last) < SMALL_RATIO_PART * most:
        return ON_BRANCH
    far = 0.0 if is_falling else FAR_WAY_PART * math.sqrt(larger(first, last) / most)
    if not is_falling and not work.w.way_of(trial.h, state.y, work.y) > far:
        return ON_BRANCH
    if not tried.is_fixed and not is_short(LONGEST_NEAR_BRANCHES, trial, state, work):
        return BRANCH_LOST
    before, after, f = math.sqrt(first), math.sqrt(last), work.k[tried.m.stages]
    if not slope > 0.0:
        part = dipping_part(before, after, trial) if is_dip else meeting_part(before, after)
        slope = before + after
    return follow_branch(trial.h, work.y, f, part, slope, work, state)


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
    is_wanted = tried.has_switches or tried.asked < trial.end
    if trial.is_good and is_kept(trial) and is_wanted:
        # rows that are asked for make stages, too, and no step shorter
        is_searched = tried.has_switches and not tried.is_fixed
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


def crossing_in(tried: Attempts, trial: Trial, work: Work, state: State) -> float:
    """Time [s] at which a trial must end by what crosses; poles and distances want all stages."""
    m, s, search = tried.m, tried.s, tried.search
    has_stages = tried.has_switches and is_kept(trial)
    # one that leads beyond its end stays as it is
    reversal, reverses, n_breaks = math.inf, False, work.scene.n_breaks
    if work.scene.n_distances > 0 and not tried.is_beyond:
        from .cuts import cut_for_place  # other scenes do not have these
        from .distances import may_reverse, reversal_end

        reverses = may_reverse(trial.h, work.y, work.k[m.stages], search)
        if not reverses and not work.scene.has_functions:
            return trial.end
        if reverses and is_kept(trial) and not has_stages:
            has_stages = make_dense_stages(m, trial, work, state)
    begin_search(s, m, trial.h, work.y, work.k[m.stages], search, has_stages=has_stages)
    search.least_part = 0.0 if is_kept(trial) and not trial.is_vague else LEAST_PART
    search.is_kept = is_kept(trial)
    if n_breaks > 0:
        from .breaks import break_end, broken_in
        from .cuts import leads_over

        is_leading = leads_over(trial.end, search)
    if reverses:
        reversal = reversal_end(trial.end, search)
    is_bare = tried.is_beyond or not work.scene.has_functions
    seen = trial.end if is_bare else crossing_end(trial.end, search)
    if search.pole and not has_stages and make_dense_stages(m, trial, work, state):
        begin_search(s, m, trial.h, work.y, work.k[m.stages], search, has_stages=True)
        seen = crossing_end(trial.end, search)
    if search.pole:
        return end_before_pole(search)
    if search.undefined:
        return seen
    broken = seen
    if n_breaks > 0 and not is_bare:
        broken = break_end(trial.end, seen, search, is_leading=is_leading)
    if reversal < broken:
        broken = cut_for_place(reversal, seen, search)
    elif broken < seen:
        broken = broken_in(broken, search)
    return broken


def resolved_in(until: float, tried: Attempts, trial: Trial, work: Work, state: State) -> float:
    """Time [s] at which a trial must end so that samples up to a time resolve parts of formulas.

    If samples are few, the trial gets the error of blind estimates. In a step that ended beside the
    middle of a steep rise, with stages on both sides, the estimate was a hundredth of a tolerance
    and the error 500.
    """
    search, to = tried.search, trial.end
    if not work.scene.has_narrow or not is_kept(trial):
        return trial.end
    if search.is_over and until <= search.place_cut:
        return trial.end
    search.is_coarse = False
    if tried.shorter < MOST_SHORTER:
        tried.shorter += 1
        # for less the next trial has no digits
        tiny = SMALLEST * larger(abs(state.time), abs(tried.end))
        end = larger(resolved_end(until, search), state.time + ONWARD * tiny)
        to = end if end < until else trial.end
    else:
        is_resolved = are_narrow_resolved(state.time, until, search)
        is_resolved = is_resolved or is_at_pole(state.time, until, search, in_between=True)
        search.is_unresolved = search.is_unresolved or not is_resolved
    if search.is_coarse and until == trial.end == to and not tried.is_fixed:
        trial.error = error_where_coarse(tried, trial)
    return to


def met_in(until: float, tried: Attempts, trial: Trial) -> float:
    """Time [s] at which a trial must end so that its polynomial meets what its stages do.

    If it has been shortened for that too often, a switch that a stage of the dense output alone
    meets is noted as unresolved: of those that other stages meet the error tells.
    """
    search, is_cut = tried.search, trial.end == tried.search.cut  # at a cut rounding decides
    if not tried.has_switches or not is_kept(trial) or tried.is_beyond or is_cut:
        return trial.end
    first = 1 if tried.thrown < MOST_SHORTER else search.m.stages + 1
    beyond = stage_beyond(first, until, search)
    if not beyond < until:
        return trial.end
    if tried.thrown < MOST_SHORTER:
        tried.thrown += 1
        return beyond
    search.is_unresolved = True
    return trial.end


def is_at_event(tried: Attempts, trial: Trial, state: State) -> bool:
    """Whether a trial that was cut for an event ends there: else the cut is there."""
    search, end = tried.search, trial.end
    if len(state.counts) == 0 or not is_kept(trial) or end != search.cut:
        return True
    if tried.polished >= MOST_POLISHED:
        return True
    tried.polished += 1
    root = smaller(polished_cut(search), tried.limit)
    if not abs(root - end) > 4.0 * SMALLEST * abs(end):
        return True
    tried.end = search.cut = root
    state.step_size = larger(state.step_size, root - state.time)
    return False


def length_by_error(m: RungeKuttaMethod, trial: Trial) -> float:
    """Length [s] of the next trial, where one does not meet the tolerance or find its branch."""
    factor = LEAST_STEP_FACTOR
    if trial.longest > 0.0:
        return trial.longest
    if math.isfinite(trial.error):
        factor = larger(factor, SAFETY * trial.error ** (-1.0 / m.order))
    return factor * trial.h


def end_at(to: float, tried: Attempts, trial: Trial, state: State) -> None:
    """Have a step end at a time when it is tried again; one that is cut can be longer still."""
    span = to - state.time
    tried.is_guessed = tried.is_guessed or to != tried.search.place_cut
    if tried.is_fixed:
        tried.end, tried.is_beyond = to, False
    state.rejected += 1
    size = state.step_size if is_kept(trial) else length_by_error(tried.m, trial)
    state.step_size = larger(size, span) if to == tried.search.cut else span


def ends_well(tried: Attempts, trial: Trial, work: Work, state: State) -> bool:
    """Whether a trial ends where it may by what is seen in it: else it is to end there."""
    search = tried.search
    if (
        not work.scene.is_searched
        or not trial.is_whole
        or not (is_kept(trial) or not tried.is_guessed)
    ):
        return True
    seen = crossing_in(tried, trial, work, state)
    tried.status = why_stopped(seen, search)
    if tried.status != Status.GOOD:
        return False
    until = smaller(seen, trial.end)  # what follows a cut is seen later
    narrow = resolved_in(until, tried, trial, work, state)
    to = smaller(narrow, met_in(until, tried, trial))
    if seen <= to and seen < trial.end:
        to = tried.end = cut_at(seen, search)
    elif not is_at_event(tried, trial, state):
        return False
    if not (to < trial.end and (is_kept(trial) or to == search.cut)):
        return True
    end_at(to, tried, trial, state)
    return False


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
    is_fixed, has_switches = s.fixed_step > 0.0, len(state.sides) > work.scene.n_poles
    search = Search(state, work, state.time, has_error=has_switches and not is_fixed)
    tried = Attempts(m, s, search, asked, end, end, is_fixed, has_switches)
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
