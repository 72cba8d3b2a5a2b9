"""Crossing: steps end where events are and where formulas of the state have a kink or a jump.

This is event location: a step that was tried is searched before it is kept. A function crosses when
it is beyond zero on the other side. Then the step is made again, to end there.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from .arithmetic import larger, smaller
from .dense_output import combine
from .poles import FURTHER, NO_WAY, ROUNDINGS, domain_end, find_pole, has_value, node_beside
from .roots import first_departure, first_time, is_isolated
from .search import (
    CELLS,
    MOST_NODES,
    SMALLEST,
    Search,
    TimeNode,
    bound_functions,
    evaluate_node,
    is_flat,
    is_still_short,
    largest,
    middle,
    node_at,
    node_with_noise,
    noise_at,
    noise_of,
    read_at,
    read_of,
    side_at,
    smallest,
)
from .settings import ACTIONS, Status

if TYPE_CHECKING:
    from .arithmetic import Array
    from .search import Flags

#: A step, or an interval of one, that comes within 1e-7 of its length to the last time ends there:
#: no sliver is left.
STRETCH_TO_END = 1.0000001
#: Shortest step to a cut, and shortest first trial of a step, in smallest steps.
ONWARD = 8.0
#: Largest distance of an event that is located again from the cut, relative to the step. Also the
#: part of the way by which a step ends before a place.
SMALL = 1e-3
#: A function passes zero if it is at least this many times as large at FURTHER times the distance;
#: one that jumps there, or is infinite, is not.
LARGER_THERE = 1.1
#: A step ends where a function that was near to zero takes a side, if that is within this part of
#: the step.
SOON = 0.1
#: Time of a look back at an event that is back at zero, in units of the time since it passed zero:
#: one that has gone evenly through a narrow window was outside of it then.
EARLIER = 1.5
#: Times of a second look back and of one ahead, in the same unit: such an event was in the window
#: then, and will be outside again.
HALF = 0.5
#: A stage from which the end of a step is made is searched for a contact if its accelerations
#: change speeds by more than this part in the step: for less the error tells enough.
PUSHED = 0.1
#: Parts of a step at which events are asked, beside its ends, whether they are zero all along: no
#: wave has its zeros there, as these are irrational.
EARLY_PART = 0.29289321881345254
MIDDLE_PART = 0.5773502691896258
LATE_PART = 0.816496580927726
#: Number of parts of a step in which bounds of such events are compared.
COMPARED = 16
#: Where bounds of an event are less than this many times those elsewhere it is flat there.
FLAT = 1e-6


def stage_beyond(first: int, seen: float, search: Search) -> float:
    """Time [s] of a stage, from a first one on, beyond a switch that its polynomial does not meet.

    Such a stage is in a contact that the step leads over: the force there makes the polynomial
    useless. If there is none, it is the time up to which the step is seen. A stage from
    which the end of the step is made counts only if it changes speeds, as the error tells of most;
    and no such stage counts beyond a jump, which throws back what passes it a little.
    """
    m, state, work, scene = search.m, search.state, search.work, search.work.scene
    size_of, n_switching = work.w.size_of, len(state.sides) - scene.n_poles
    slow = PUSHED * size_of(state.y[scene.nq :])
    for k in range(first, m.all):
        time = search.start + m.c[k] * search.h
        if not time < seen:
            continue
        if k <= m.stages and search.h * size_of(work.k[k][scene.nq :]) <= slow:
            continue
        combine(k, m.a[k], state.y, search.h, work.k, work.scratch)
        node = evaluate_node(read_of(time, work.scratch, work.w), search.noise, time, work.w)
        last = n_switching if k > m.stages else n_switching - scene.n_breaks
        switching = slice(len(scene.events), last)
        sides = state.sides[switching]
        if np.any((sides != 0.0) & (side_at(node)[switching] == -sides)):
            return time
    return seen


def note_sides(a: TimeNode, search: Search) -> None:
    """Note on which side functions are where a step starts, which the noise had left open.

    Rates are known to rounding where they pass by, places to the noise. Events, which are looked
    for until they are exact, and poles stay.
    """
    noise, sides = search.noise.copy(), search.state.sides
    noise[:, 1] = noise_at(a.time, a.read, search)[:, 1]
    events, n = len(search.work.scene.events), len(sides) - search.work.scene.n_poles
    now = side_at(evaluate_node(a.read, noise, a.time, search.work.w))[events:n]
    sides[events:n] = np.where(now == -sides[events:n], now, sides[events:n])


def note_kept(end: float, search: Search) -> None:
    """Note which events are no further from zero than the noise all along a step.

    Energies that are kept are: rounding tells their side, they do not cross. Not so an event that
    is flat in a part of the step only, as max(0, 1 - abs(x))*x: it may cross in another part.
    """
    n, start = len(search.state.sides), search.start
    search.is_at_zero = np.arange(n) < len(search.work.scene.events)
    for part in (0.0, 1.0, EARLY_PART, MIDDLE_PART, LATE_PART):
        if not search.is_at_zero.any():
            return
        node = node_with_noise(search.noise, start + part * (end - start), search)
        search.is_at_zero &= side_at(node)[:n] == 0.0
    if search.is_at_zero.any():
        search.is_at_zero &= ~is_flat_in_part(end, search)


def is_flat_in_part(end: float, search: Search) -> Flags:
    """Whether bounds of functions are much closer to zero in a part of a step than in another."""
    n, start = len(search.state.sides), search.start
    least, most = np.full(n, math.inf), np.zeros(n)
    a = node_at(start, search)
    for k in range(1, COMPARED + 1):
        time = end if k == COMPARED else start + k / COMPARED * (end - start)
        b = node_at(time, search)
        low, high = np.abs(bound_functions(a, b, search)[:2, :n])
        size = largest(low, high)
        least, most, a = smallest(least, size), largest(most, size), b
    flat: Flags = least < FLAT * most
    return flat


def note_short(a: TimeNode, end: float, search: Search) -> None:
    """Note which events a step starts short of."""
    sides = search.state.sides
    if end != search.cut:  # of a cut it is known
        note_kept(end, search)
    is_event = np.arange(len(sides)) < len(search.work.scene.events)
    is_beyond = is_event & (sides != 0.0) & (side_at(a)[: len(sides)] == -sides)
    search.is_short = is_beyond | search.is_at_zero


def are_crossed(sides: Array, b: TimeNode, search: Search) -> Flags:
    """Whether functions that were on sides (functions,) are beyond zero at a node."""
    crosses: Flags = (sides != 0.0) & (side_at(b)[: len(sides)] == -sides)
    return crosses & ~is_still_short(sides, b.time, search)


def crossing_end(end: float, search: Search) -> float:
    """Time [s] at which a step must end: of its first crossing, or as far as it was searched."""
    sides = search.state.sides
    n, start = len(sides), search.start
    is_pole = np.arange(n) >= n - search.work.scene.n_poles
    passed = np.zeros(n, dtype=bool)
    search.pole = 0
    tiny = SMALLEST * larger(abs(start), abs(end))
    nearest = start + larger(ONWARD * tiny, search.least_part * search.h)
    soon = start + larger(ONWARD * tiny, search.slack)
    widest = search.h / CELLS
    width, a = widest, node_at(start, search)
    domain_end(a, a, search)
    if search.undefined:
        return end
    note_sides(a, search)
    note_short(a, end, search)
    for _ in range(MOST_NODES):
        if not a.time < end:
            break
        b = node_at(a.time + width if a.time + STRETCH_TO_END * width < end else end, search)
        # else the polynomial may be thrown off
        sides[:] = np.where(search.is_kept & (sides == 0.0), side_at(a)[:n], sides)
        now = np.where(passed, -sides, sides)
        search.crosses = are_crossed(now, b, search)
        passes = search.crosses & is_pole
        search.crosses &= ~is_pole
        valued, is_lost = domain_end(a, b, search), np.zeros(n, dtype=bool)
        if search.undefined:
            first = first_time(a, b, search) if search.crosses.any() else math.inf
            if first <= valued + search.slack:
                search.undefined = 0
                return smaller(larger(first, nearest), end)
            if search.is_kept and valued <= soon:
                return end
            search.undefined = 0
            # at the end, where it was cut for that, or by rounding
            if not end - valued <= (SMALL * search.h if end == search.cut else ONWARD * tiny):
                search.crosses[:] = False
                return smaller(larger(valued, nearest), end)
            is_lost = ~has_value(b)[:n]  # it ends where that has no value
        bounds = bound_functions(a, b, search)
        is_known = bool((is_lost | is_isolated(now, a, b, bounds, search)).all())
        departure = larger(first_departure(a, b, search), start + ONWARD * tiny)
        if departure - start < SOON * (end - start):
            search.crosses[:] = False
            return departure
        if not is_known and b.time - a.time > tiny:
            width = 0.5 * (b.time - a.time)
            continue
        if passes.any() and search.is_kept:
            find_pole(passes, a, b, search)
            if search.pole:
                return end
        passed ^= passes
        if search.crosses.any():
            search.breaks = np.where(search.crosses[search.work.scene.breaks], b.time, math.inf)
            return smaller(larger(first_time(a, b, search), nearest), end)
        a, width = b, smaller(2.0 * width, widest)
    search.is_unresolved = a.time < end and not a.time > nearest
    return a.time if nearest < a.time < end else end


def why_stopped(seen: float, search: Search) -> Status:
    """Reason why a run leads no further, where a step would end there; GOOD where it does."""
    state = search.state
    if search.undefined:
        state.event = float(search.undefined)
        return Status.NO_VALUE
    if search.pole and not seen > state.time:
        state.pole = float(search.pole)
        return Status.INFINITE
    return Status.GOOD


def gap_across(
    k: int, side: float, time: float, far: float, search: Search, *, is_beyond: bool
) -> float:
    """Difference of a function from one side of a time to the other, so far away.

    Both values are in the polynomial, or beyond it. The difference is 0 where they are not surely
    on different sides of zero, and negative where the function goes to the opposite side.
    """
    if is_beyond:
        read = read_at(time, search)
        a = node_beside(-far, time, read, search.rounding, search)
        b = node_beside(far, time, read, search.rounding, search)
    else:
        a = node_with_noise(search.rounding, time - far, search)
        b = node_with_noise(search.rounding, time + far, search)
    if side_at(a)[k] != -side or side_at(b)[k] != side:
        return -1.0 if side_at(a)[k] == side and side_at(b)[k] == -side else 0.0
    return float(b.least[k] - a.most[k] if side > 0.0 else a.least[k] - b.most[k])


def passes_zero(k: int, side: float, end: float, search: Search) -> bool:
    """Whether an event that gets on a side of zero in a step to an end is zero there.

    Else it jumps, or goes through infinity: right beside the place it is then as large as further
    away, or larger. Where rounding hides the difference it counts as zero. Distances may exceed a
    short step, beyond which its polynomial tells nothing: values and rates at its end are then
    continued. If the event goes to the opposite side, rounding brought it back over a jump that was
    passed.
    """
    if search.work.scene.events[k, 2] == 0:
        return True
    first, last = search.start, end
    if side_at(node_with_noise(search.rounding, end, search))[k] != side:
        last = end + SMALL * search.h
    while last - first > SMALLEST * larger(abs(first), abs(last)):
        time = 0.5 * (first + last)
        if not first < time < last:
            break
        if side_at(node_with_noise(search.rounding, time, search))[k] == side:
            last = time
        else:
            first = time
    far = ROUNDINGS * SMALLEST * larger(abs(last), search.h)
    while far < larger(search.h, search.state.stride) / FURTHER:
        is_beyond = not far < search.h / FURTHER
        gap = gap_across(k, side, last, far, search, is_beyond=is_beyond)
        if gap != 0.0:
            further = gap_across(k, side, last, FURTHER * far, search, is_beyond=is_beyond)
            return gap > 0.0 and further >= LARGER_THERE * gap
        far *= FURTHER
    return True


def polished_cut(search: Search) -> float:
    """Time [s] of an event that a step was cut for, by the step that ends near it."""
    reach, cut = SMALL * search.h, search.cut
    sides = search.state.sides
    candidates = np.flatnonzero(search.was_crossing[: len(search.work.scene.events)]).tolist()
    event = next((k for k in candidates if passes_zero(k, -sides[k], cut, search)), None)
    if event is None:
        return cut

    def value(time: float) -> float:
        return float(middle(node_with_noise(noise_of(event, search), time, search))[event])

    previous, current = cut - reach, cut
    a, b = value(previous), value(current)
    for _ in range(4):
        if a == b:
            break
        time = current - b / ((b - a) / (current - previous))
        if not abs(time - cut) <= reach or time == current:
            break
        a, previous, current = b, current, time
        b = value(current)
    return current


def is_thrown_back(k: int, end: float, search: Search) -> bool:
    """Whether an event that passed zero is back there, where a jump of a force threw it back.

    Dry friction that holds a body at rest does that all the time. It is so if nothing has moved
    since the event passed zero by more than its noise, unless the event goes evenly through a
    narrow window: then it was on the side that it leaves half of this time ago, and is on the
    other one before and soon. An event that was held once is not asked again.
    """
    state, elapsed, read = search.state, end - search.state.crossed[k], read_at(end, search)
    speeds, known = np.column_stack((read[:, 1], search.second_mean)), search.noise[:, 0]
    is_there = len(read) > 0 and elapsed <= NO_WAY * state.stride
    if is_there:
        bounds = np.column_stack((known, known * state.fastest))
        is_there = bool((np.abs(speeds) * elapsed <= bounds).all())
    if not is_there:
        state.held[k] = 0.0
    elif state.held[k] == 0.0:
        offsets = (-EARLIER * elapsed, -HALF * elapsed, HALF * elapsed)
        nodes = (node_beside(offset, end, read, search.rounding, search) for offset in offsets)
        before, between, behind = (side_at(node)[k] * state.sides[k] for node in nodes)
        state.held[k] = float(not (before < 0.0 and between > 0.0 and behind < 0.0))
    return bool(state.held[k] > 0.0)


def note_crossings(end: float, search: Search) -> None:
    """Note crossings of a step that is kept; of one that was cut, also zeros at its end."""
    state, events = search.state, search.work.scene.events
    sides, now = state.sides.copy(), side_at(node_at(end, search))
    known = node_with_noise(search.noise, end, search)
    flat = is_flat(known, search.work.w)
    is_near = (now == 0.0) | (side_at(known) == 0.0)
    is_near[: len(events)] &= ~flat[: len(events)]  # it may go on to either side
    is_back = (now[: len(sides)] == -sides) & ~is_still_short(sides, end, search)
    for k, side in enumerate(sides.tolist()):
        is_there = is_near[k] and end == search.cut and search.was_crossing[k]
        if side == 0.0 or not (is_back[k] or is_there):
            continue
        is_same = k < len(events) and is_thrown_back(k, end, search)
        state.sides[k] = -side
        if k >= len(events):
            continue
        state.crossed[k] = end
        if is_same or events[k, 0] not in {0, -side} or not passes_zero(k, -side, end, search):
            continue
        state.counts[k] += 1.0
        if ACTIONS[events[k, 1]] != "count":
            state.fired[k] = 1.0
