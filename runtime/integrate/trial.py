"""Trial: a step that is tried, and its stages by an explicit Runge-Kutta method."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from .arithmetic import larger, rounding_of_sum, smaller
from .branches import ON_BRANCH
from .dense_output import combine
from .pivot_monitor import branch_ratio
from .projection import check_digits, last_ratio, project
from .settings import Status

if TYPE_CHECKING:
    from .arithmetic import Array
    from .methods import RungeKuttaMethod
    from .scene_tables import Work
    from .search import Search
    from .settings import Settings
    from .state import State

#: Largest constraint correction that may be left at a stage inside of a step, in units of the
#: tolerance.
STAGE_RESIDUAL = 1e-3
#: How often a step is made again at most for each of three reasons: samples do not resolve a part
#: that varies with the state, a stage lies beyond a switch that the polynomial does not meet, or
#: samples are few for how a part varies.
MOST_SHORTER = 8
#: Reject a step if a stage with zero weight at its end has accelerations more than this many times
#: those of the other stages, and the speeds at its end over its length.
THROWN_OFF = 10.0
#: Earliest part of a step at which a stage gives the third point of a parabola through the branch
#: ratios at its ends: branch ratios go with the square of the distance from a place where branches
#: meet.
INNER_STAGE_PART = 0.25
#: Number of stages from which on a method has many: they lie twice as densely in a step.
MANY_STAGES = 12


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
    is_fixed, has_switching : bool
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
    has_switching: bool
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
