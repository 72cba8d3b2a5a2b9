"""Breaks: steps end where a function of the state crosses zero at which a force jumps.

Trials that end beyond it are too long by their error, until so little of one is behind the jump
that it is kept: each time that leaves an error of one sign, which is no smaller than the tolerance.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from .arithmetic import larger
from .crossing import ONWARD, SMALL
from .cuts import BEHIND, EARLY, FALLEN_PART, MOST_PLACE_CUTS, THERE, cut_beside, cut_for_place
from .dense_output import combine
from .search import SMALLEST, evaluate_node, middle, node_with_noise, read_at, read_of, side_at

if TYPE_CHECKING:
    from .search import Search

#: A step that leads over a jump begins at this part of the longest step before it, in units of the
#: tolerance: errors of its stages on both sides are that much below the tolerance.
NEAR = 1e-6


def find_breaks(search: Search) -> None:
    """Find when functions first cross in the polynomial of a step at which a force jumps."""
    before = search.work.scene.breaks.start
    for n in np.flatnonzero(search.breaks < math.inf).tolist():
        side, first, last = -search.state.sides[before + n], search.start, search.breaks[n]
        while last - first > SMALLEST * larger(abs(first), abs(last)):
            time = 0.5 * (first + last)
            if not first < time < last:
                break
            if side_at(node_with_noise(search.rounding, time, search))[before + n] == side:
                last = time
            else:
                first = time
        search.breaks[n] = last


def size_ahead(k: int, span: float, search: Search) -> float:
    """Size of a function at a span [s] ahead of the start of a step at its first rates."""
    state, w, time = search.state, search.work.w, search.start + span
    read = read_of(time, state.y + span * state.f, w)
    return abs(float(middle(evaluate_node(read, np.zeros_like(read), time, w))[k]))


def is_ahead(k: int, place: float, search: Search) -> bool:
    """Whether a function comes to zero at an early place of a vague trial at its first rates, too.

    Stages behind jumps throw its polynomial off: it may have places there that are none.
    """
    to_place, early = place - search.start, EARLY * search.h
    if search.least_part == 0.0 or not to_place < early:
        return True
    before, there, beyond = (size_ahead(k, span, search) for span in (0.0, to_place, early))
    return there <= larger(FALLEN_PART * before, THERE * beyond)


def is_pushed_back(k: int, place: float, search: Search) -> bool:
    """Whether a function that crosses zero at a place would be thrown back, and stay there.

    So it is where dry friction holds a body: what acts at a stage that is beyond tells it.
    """
    state, work, m, soon = (
        search.state,
        search.work,
        search.m,
        SMALL * larger(search.state.stride, search.h),
    )
    exact, side = np.zeros_like(search.noise), float(state.sides[k])
    for n in range(1, m.stages + 1):
        time = search.start + m.c[n] * search.h
        combine(n, m.a[n], state.y, search.h, work.k, work.scratch)
        at_stage = read_of(time, work.scratch, work.w)
        if side_at(evaluate_node(at_stage, search.rounding, time, work.w))[k] != -side:
            continue
        behind_stage = read_of(time + soon, work.scratch + soon * work.k[n], work.w)
        read = read_at(place, search)
        value = float(middle(evaluate_node(read, exact, place, work.w))[k])
        read[:, 0] += soon * read[:, 1]
        read[:, 1] += behind_stage[:, 1] - at_stage[:, 1]
        return (
            side * (float(middle(evaluate_node(read, exact, place + soon, work.w))[k]) - value)
            > 0.0
        )
    return False


def first_break(search: Search) -> int:
    """Index of the first jump in a step, the count of jumps where there is none."""
    first = int(np.argmin(search.breaks))
    return first if search.breaks[first] < math.inf else len(search.breaks)


def break_end(end: float, seen: float, search: Search, *, is_leading: bool) -> float:
    """Time [s] at which a step to an end, or to a crossing in it, must end by the first jump.

    It is the end where the step is made to lead over the jump, and does, and the time that is seen
    where no jump is, or an event is nearer. One that is too wide for its error is made narrower.
    """
    find_breaks(search)
    first = first_break(search)
    if first == len(search.breaks):
        return seen
    k, place = search.work.scene.breaks.start + first, search.breaks[first]
    is_over = is_leading and end - place > BEHIND * search.h
    if is_over and search.is_kept:
        return seen if search.crosses[: len(search.work.scene.events)].any() else end
    if (
        search.place_cuts >= MOST_PLACE_CUTS
        or not is_ahead(k, place, search)
        or is_pushed_back(k, place, search)
    ):
        return seen
    near = 2.0 * ONWARD * SMALLEST * larger(abs(search.start), abs(end))
    if not is_over:
        part = search.slack / search.h
        near = larger(NEAR * part * larger(search.state.stride, search.h), near)
    cut = cut_beside(place, near, search)
    return cut if cut < seen else seen


def broken_in(cut: float, search: Search) -> float:
    """Time [s] at which a step is cut for jumps: those over which it leads cross there."""
    search.place = search.breaks[first_break(search)]
    search.is_over = search.place < cut
    cut_for_place(cut, cut, search)
    search.crosses[search.work.scene.breaks] = search.breaks < cut
    return cut
