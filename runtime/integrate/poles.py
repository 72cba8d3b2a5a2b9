"""Poles: where formulas have no value, and where forces are infinite.

An event without a value, and a step that leads over a pole of a force, end the run before it.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from .arithmetic import larger
from .roots import first_time, time_of
from .search import (
    SMALLEST,
    Search,
    TimeNode,
    evaluate_node,
    middle,
    node_with_noise,
    read_at,
    read_of,
    side_at,
)

if TYPE_CHECKING:
    from .arithmetic import Array
    from .scene_tables import Work
    from .search import Flags
    from .state import State

#: Ratio of two distances from a crossing at which a function is compared.
FURTHER = 8.0
#: Smallest of these distances, in roundings of the time.
ROUNDINGS = 64.0
#: A part of a force is infinite at a place if it grows by more than this factor each time one comes
#: FURTHER times nearer: 1/x grows by FURTHER.
STEEP = 7.0
#: Two such growth factors in succession differ by at most this ratio where a part is infinite.
EVENLY = 1.5
#: A step that leads over a pole of a force is made again, over this part of the way to the pole.
CLOSER = 0.9
#: A run ends where the way to a pole is at most this part of its longest step. An event that is
#: back at zero within this part of it may have been thrown back.
NO_WAY = 1e-6


def has_value(node: TimeNode) -> Flags:
    """Whether each function (functions,) has a value at a node."""
    have_values: Flags = ~(np.isnan(node.least) | np.isnan(node.most))
    return have_values


def first_without_value(state: State, work: Work) -> int:
    """First event without a finite value at the state, from 1; 0 where all have one."""
    w, count = work.w, len(work.scene.events)
    if count == 0:
        return 0
    read = read_of(state.time, state.y, w)
    node = evaluate_node(read, np.zeros_like(read), state.time, w)
    is_finite = (np.isfinite(node.least) & np.isfinite(node.most))[:count]
    return 0 if is_finite.all() else int(np.argmin(is_finite)) + 1


def is_undefined(k: int, time: float, search: Search) -> bool:
    """Whether a function has no value at a time, nor right behind it.

    One that is 0/0 there alone has one behind it.
    """
    exact, onward = np.zeros_like(search.noise), ROUNDINGS * SMALLEST * larger(abs(time), search.h)
    if has_value(node_with_noise(exact, time, search))[k]:
        return False
    return not has_value(node_with_noise(exact, time + onward, search))[k]


def domain_end(a: TimeNode, b: TimeNode, search: Search) -> float:
    """Last time [s] between two nodes at which all events have a value.

    Events without a value at the second node count; the first that has none behind that time is
    noted. Infinite where there is none.
    """
    end, exact = math.inf, np.zeros_like(search.noise)
    search.undefined = 0
    for k in np.flatnonzero(~has_value(b)[: len(search.work.scene.events)]).tolist():
        if not is_undefined(k, b.time, search):
            continue
        first, last = a.time, b.time
        while last - first > SMALLEST * larger(abs(first), abs(last)):
            time = 0.5 * (first + last)
            if not first < time < last:
                break
            if has_value(node_with_noise(exact, time, search))[k]:
                first = time
            else:
                last = time
        if first < end:
            end, search.undefined = first, 1 + k
    return end


def find_pole(passes: Flags, a: TimeNode, b: TimeNode, search: Search) -> None:
    """Find the first pole of a force between two nodes, if nothing crosses before it.

    Functions (functions,) pass zero there, where forces may be infinite.
    """
    crossed, first = search.crosses.copy(), math.inf
    if crossed.any():
        first = first_time(a, b, search)
        search.crosses = crossed
    for k in np.flatnonzero(passes).tolist():
        side = side_at(b)[k]
        time = a.time if side_at(a)[k] == side else time_of(k, a, b, search)
        if time <= first and is_infinite(k, float(side), time, search):
            first = search.pole_time = time
            search.pole = 1 + k - len(passes) + search.work.scene.n_poles


def node_beside(offset: float, time: float, read: Array, noise: Array, search: Search) -> TimeNode:
    """Node at an offset [s] from a time [s] where formulas read (n, 2) and go on evenly."""
    beside = read.copy()
    beside[:, 0] += offset * read[:, 1]
    beside[:, 1] += offset * search.second_mean
    return evaluate_node(beside, noise, time + offset, search.work.w)


def sizes_beside(offset: float, time: float, read: Array, search: Search) -> Array:
    """Sizes of parts of forces that may be infinite, at an offset [s] from a time [s].

    Formulas read values and rates (n, 2) at the time.
    """
    node = node_beside(offset, time, read, np.zeros_like(read), search)
    return np.abs(middle(node)[len(node.least) - len(search.work.w.infinite) // 4 :])


def is_infinite(k: int, side: float, time: float, search: Search) -> bool:
    """Whether a force is infinite where a function gets on a side of zero at a time.

    No motion leads through such a place: the force grows as 1/x or faster on a side. A force that
    is 0/0 there, or jumps, does not grow, and one that grows less, as 1/sqrt(x), has a finite
    integral.
    """
    read, far = read_at(time, search), ROUNDINGS * SMALLEST * larger(abs(time), search.h)
    while (
        side_at(node_beside(-far, time, read, search.rounding, search))[k] != -side
        or side_at(node_beside(far, time, read, search.rounding, search))[k] != side
    ):
        far *= FURTHER
        if not far < search.state.stride:
            return True  # rounding hides that
    is_pole = np.zeros(len(search.work.w.infinite) // 4, dtype=bool)
    for offset in (-far, far):
        near = sizes_beside(FURTHER * FURTHER * offset, time, read, search)
        there = sizes_beside(FURTHER * FURTHER * FURTHER * offset, time, read, search)
        away = sizes_beside(FURTHER * FURTHER * FURTHER * FURTHER * offset, time, read, search)
        grows = (near > STEEP * there) & (there > STEEP * away)
        product, square = near * away, there * there
        grows &= (product <= EVENLY * square) & (square <= EVENLY * product)
        is_pole |= grows | np.isinf(near)
    return bool(is_pole.any())


def end_before_pole(search: Search) -> float:
    """End [s] of a step before a pole that is found in it: its start if that is near."""
    span = search.pole_time - search.start
    return search.start + CLOSER * span if span > NO_WAY * search.state.stride else search.start
