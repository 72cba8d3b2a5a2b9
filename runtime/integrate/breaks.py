"""Breaks: steps end where a function of the state crosses zero at which a force jumps.

Trials that end beyond it are too long by their error, until so little of one is behind the jump
that it is kept: each time that leaves an error of one sign, which is no smaller than the tolerance.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from .arithmetic import larger
from .crossing import (
    ONWARD,
    SMALL,
    SMALLEST,
    look_closely,
    middle,
    read_at,
    read_of,
    see_at,
    side_at,
)
from .cuts import BEHIND, EARLY, MOST_TURNED, SUNK, THERE, cut_beside, turned_in
from .dense_output import combine

if TYPE_CHECKING:
    from .crossing import Look

#: A step that leaps over a jump begins at this part of the longest step before it, in units of the
#: tolerance: what its stages on both sides leave is that much less than may be.
NEAR = 1e-6


def find_breaks(look: Look) -> None:
    """Find when functions first cross in the polynomial of a step at which a force jumps."""
    before = look.work.scene.breaks.start
    for n in np.flatnonzero(look.breaks < math.inf).tolist():
        side, first, last = -look.state.sides[before + n], look.start, look.breaks[n]
        while last - first > SMALLEST * larger(abs(first), abs(last)):
            time = 0.5 * (first + last)
            if not first < time < last:
                break
            if side_at(look_closely(look.rounding, time, look))[before + n] == side:
                last = time
            else:
                first = time
        look.breaks[n] = last


def size_ahead(k: int, way: float, look: Look) -> float:
    """Size of a function so far ahead of the start of a step at its first rates."""
    state, w, time = look.state, look.work.w, look.start + way
    read = read_of(time, state.y + way * state.f, w)
    return abs(float(middle(see_at(read, np.zeros_like(read), time, w))[k]))


def is_ahead(k: int, place: float, look: Look) -> bool:
    """Whether a function comes to zero at an early place of a vague trial at its first rates, too.

    Stages behind jumps throw its polynomial off: it may have places there that are none.
    """
    way, early = place - look.start, EARLY * look.h
    if look.least_part == 0.0 or not way < early:
        return True
    before, there, beyond = (size_ahead(k, part, look) for part in (0.0, way, early))
    return there <= larger(SUNK * before, THERE * beyond)


def is_pushed_back(k: int, place: float, look: Look) -> bool:
    """Whether a function that crosses zero at a place would be thrown back, and stay there.

    So it is where dry friction holds a body: what acts at a stage that is beyond tells it.
    """
    state, work, m, soon = look.state, look.work, look.m, SMALL * larger(look.state.stride, look.h)
    exact, side = np.zeros_like(look.noise), float(state.sides[k])
    for n in range(1, m.stages + 1):
        time = look.start + m.c[n] * look.h
        combine(n, m.a[n], state.y, look.h, work.k, work.scratch)
        own = read_of(time, work.scratch, work.w)
        if side_at(see_at(own, look.rounding, time, work.w))[k] != -side:
            continue
        following = read_of(time + soon, work.scratch + soon * work.k[n], work.w)
        read = read_at(place, look)
        there = float(middle(see_at(read, exact, place, work.w))[k])
        read[:, 0] += soon * read[:, 1]
        read[:, 1] += following[:, 1] - own[:, 1]
        return side * (float(middle(see_at(read, exact, place + soon, work.w))[k]) - there) > 0.0
    return False


def first_break(look: Look) -> int:
    """First jump in a step, as a number of those, their count where there is none."""
    found = int(np.argmin(look.breaks))
    return found if look.breaks[found] < math.inf else len(look.breaks)


def break_end(end: float, seen: float, look: Look, *, leaps: bool) -> float:
    """Time at which a step to an end, or to what is seen in it, must end by the first jump.

    That is the end where it leaps over the jump, as it is made to, and what is seen where no jump
    is, or an event is nearer. A leap that is too wide for its error is made narrower.
    """
    find_breaks(look)
    first = first_break(look)
    if first == len(look.breaks):
        return seen
    k, place = look.work.scene.breaks.start + first, look.breaks[first]
    is_over = leaps and end - place > BEHIND * look.h
    if is_over and look.is_kept:
        return seen if look.crosses[: len(look.work.scene.events)].any() else end
    if look.turned >= MOST_TURNED or not is_ahead(k, place, look) or is_pushed_back(k, place, look):
        return seen
    near = 2.0 * ONWARD * SMALLEST * larger(abs(look.start), abs(end))
    if not is_over:
        part = look.slack / look.h
        near = larger(NEAR * part * larger(look.state.stride, look.h), near)
    found = cut_beside(place, near, look)
    return found if found < seen else seen


def broken_in(found: float, look: Look) -> float:
    """Time at which a step is cut for jumps: those over which it leaps cross there."""
    look.place = look.breaks[first_break(look)]
    look.is_over = look.place < found
    turned_in(found, found, look)
    look.crosses[look.work.scene.breaks] = look.breaks < found
    return found
