"""Branches in a step: whether pivot ratios tell that it led past a singular configuration.

Beyond one a step may have gone on to another branch of the constraints.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from .arithmetic import larger, smaller
from .branches import BRANCH_LOST, ON_BRANCH, follow_branch
from .pivot_monitor import usual_ratio
from .trial import MANY_STAGES, Attempts, Trial

if TYPE_CHECKING:
    from .scene_tables import Work
    from .state import State

#: Check a step for other branches if its smallest branch ratio, by a parabola through those
#: at its ends and at a stage inside, or at a stage, is below this part of the larger ratio at its
#: ends.
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
#: Longest motion of bodies, instead of LONGEST_IF_LOOSE, where drivers determine it and the method
#: has many stages. Two bodies turn towards each other by twice as much, which is less than half a
#: turn: no step passes two places where branches meet.
LONGEST_OF_MANY_STAGES = 1.5
#: These limits do not apply where the smallest branch ratio in a step exceeds this part of the
#: largest: no place where branches meet is passed by if ratios are as level as that.
LEVEL_RATIO_PART = 0.999
#: The root of the branch ratio may have changed its sign between two stages if a line through the
#: roots at one of them and at the stage beyond it leads to less than this part of the root at the
#: other one.
SIGN_CHANGE_PART = 0.2
#: Safety factor of a step length that follows from a longest motion of bodies.
LIMITED_STEP_PART = 0.98


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
