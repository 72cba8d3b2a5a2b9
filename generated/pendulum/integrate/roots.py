"""Roots: times at which functions of the state cross zero in a step.

Where bounds between two nodes show that a function crosses once, its time is bisected.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from .arithmetic import larger, smaller
from .search import (
    SMALLEST,
    Search,
    TimeNode,
    half_width,
    is_flat,
    is_still_short,
    largest,
    middle,
    node_with_noise,
    noise_at,
    noise_of,
    side_at,
)
from .settings import ACTIONS

if TYPE_CHECKING:
    from .arithmetic import Array
    from .search import Flags

#: A function is near to zero at a node where it is less than this many times its noise; the noise
#: at other nodes tells nothing of how near it comes to zero between them.
BANDS = 2.0


def stays_positive(a: Array, b: Array, falls: Array, rises: Array, h: float) -> Flags:
    """Whether functions (n,) of values a and b at the ends of h [s] are positive in between.

    None is less than lines from both ends as steep as it falls and rises (n,) at most, per second.
    """
    are_positive: Flags = a * rises - b * falls + falls * rises * h > 0.0
    return are_positive


def band_at(node: TimeNode, search: Search) -> Array:
    """Half widths (functions,) at a node, by the noise of events that a step starts short of."""
    band = half_width(node)
    if search.is_short.any():
        known = half_width(node_with_noise(search.noise, node.time, search))
        n = len(search.is_short)
        band[:n] = np.where(search.is_short, known[:n], band[:n])
    return band


def is_isolated(sides: Array, a: TimeNode, b: TimeNode, bounds: Array, search: Search) -> Flags:
    """Whether functions cross between two nodes as often as their sides tell: root isolation.

    Sides (functions,) are those before, bounds (4, functions) those of
    :func:`.search.bound_functions`.
    """
    n, is_down = len(sides), sides < 0.0
    low, high, slowest, fastest = bounds[:, :n]
    sign, least = np.where(is_down, -1.0, 1.0), np.where(is_down, -high, low)
    falls, rises = np.where(is_down, -fastest, slowest), np.where(is_down, -slowest, fastest)
    band_a, band_b = band_at(a, search)[:n], band_at(b, search)[:n]
    first, last = sign * middle(a)[:n], sign * middle(b)[:n]
    near_a = np.where((sides == 0.0) | (first < BANDS * band_a), band_a, 0.0)
    near_b = np.where((sides == 0.0) | (last < BANDS * band_b), band_b, 0.0)
    within = largest(near_a, near_b)
    is_clear = (least > -within) | (falls >= 0.0) | (rises <= 0.0)
    is_positive = stays_positive(first + within, last + within, falls, rises, b.time - a.time)
    stays = is_clear | np.where(sides == 0.0, high < within, is_positive)
    crosses = (sides != 0.0) & (side_at(b)[:n] == -sides)
    crosses &= ~is_still_short(sides, b.time, search)
    are_isolated: Flags = np.where(crosses, rises <= 0.0, stays | search.is_at_zero)
    return are_isolated


def time_of(k: int, a: TimeNode, b: TimeNode, search: Search) -> float:
    """Time [s] between two nodes at which a crossing function first does so.

    An event is zero at this time, or leaves zero where it has been there for a while; any other
    function is beyond zero, so that all that follows is on the other side.
    """
    side, first, last = -float(side_at(b)[k]), a.time, b.time
    is_event, noise = k < len(search.work.scene.events), noise_of(k, search).copy()
    is_pole = k >= len(search.state.sides) - search.work.scene.n_poles
    if not (is_event or is_pole):  # rates may be in a window that is narrower
        noise[:, 1] = noise_at(last, b.read, search)[:, 1]
    # by the polynomial it is beyond zero, by less than that
    if side_at(node_with_noise(noise, last, search))[k] != -side:
        noise = search.rounding
    while last - first > SMALLEST * larger(abs(first), abs(last)):
        time = 0.5 * (first + last)
        if not first < time < last:
            break
        node = node_with_noise(noise, time, search)
        is_beyond = side_at(node)[k] == -side
        if is_event:
            is_beyond = side * middle(node)[k] <= 0.0 and not is_flat(node, search.work.w)[k]
        if is_beyond:
            last = time
        else:
            first = time
    return last


def first_time(a: TimeNode, b: TimeNode, search: Search) -> float:
    """Time [s] of the first crossing; only functions that cross there stay marked.

    What is behind the end of the run does not count, however near it is.
    """
    events = search.work.scene.events
    times = {int(k): time_of(int(k), a, b, search) for k in np.flatnonzero(search.crosses)}
    first = min(times.values())
    together = first + search.slack
    for k, time in times.items():
        if k < len(events) and ACTIONS[events[k, 1]] == "stop" and time <= first + search.slack:
            together = first + 4.0 * SMALLEST * abs(first)
    for k, time in times.items():
        search.crosses[k] = time <= together
    return first


def is_short_of(k: int, a: TimeNode, search: Search) -> bool:
    """Whether a step begins where a function that has crossed is on the side that it left.

    A step may end so, within its errors. Formulas are then those of the side that was left, and the
    error estimate of a method can be blind to its first stage.
    """
    if a.time != search.start:
        return False
    return bool(
        side_at(node_with_noise(search.rounding, a.time, search))[k] != search.state.sides[k]
    )


def first_departure(a: TimeNode, b: TimeNode, search: Search) -> float:
    """First time [s] at which a function that was near to zero, but no event, is on a side.

    Values of formulas at zero, where they may jump, tell nothing of what follows; values near to
    zero on the side that is taken do.
    """
    first, sides, now, before = math.inf, search.state.sides, side_at(b), middle(a)
    for k in range(len(search.work.scene.events), len(sides) - search.work.scene.n_poles):
        if now[k] == 0.0 or now[k] * before[k] > 0.0:
            continue
        if sides[k] == 0.0 or (sides[k] == now[k] and is_short_of(k, a, search)):
            first = smaller(first, time_of(k, a, b, search))
    return first
