"""End of a step: where a trial must end, for crossings, for narrow forces, for events."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from .arithmetic import larger, smaller
from .crossing import ONWARD, crossing_end, polished_cut, stage_beyond, why_stopped
from .poles import end_before_pole
from .search import SMALLEST, begin_search, cut_at
from .settings import Status
from .step_error import LEAST_PART, error_where_coarse, length_by_error
from .trial import MOST_SHORTER, Attempts, Trial, is_kept, make_dense_stages
from .variation import are_narrow_resolved, is_at_pole, resolved_end

if TYPE_CHECKING:
    from .scene_tables import Work
    from .state import State

#: Largest number of re-locations of an event that cuts a step.
MOST_POLISHED = 3


def crossing_in(tried: Attempts, trial: Trial, work: Work, state: State) -> float:
    """Time [s] at which a trial must end by what crosses; poles and distances want all stages."""
    m, s, search = tried.m, tried.s, tried.search
    has_stages = tried.has_switching and is_kept(trial)
    reversal, reverses, n_breaks = math.inf, False, work.scene.n_breaks
    # one that leads beyond its end stays as it is
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
    if not tried.has_switching or not is_kept(trial) or tried.is_beyond or is_cut:
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
