"""Distances: steps end where one along which a force acts comes down to zero, or nearly.

There the force turns round in a time that is none, or as good as none: stages on both sides may
tell no error of it, and a step may leap over two such places. On a smooth way a step that meets the
tolerance has no distance that is much smaller inside of it than at its ends: only where one may be
it is looked for in the polynomial. The step is made again, to end right before that place, and the
next one, to end as far behind.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from .arithmetic import larger, smaller
from .crossing import FINEST, ONWARD, SMALLEST, read_of
from .cuts import BEHIND, EARLY, SUNK, THERE, cut_beside, is_leap
from .dense_output import interpolate

if TYPE_CHECKING:
    from .arithmetic import Array
    from .crossing import Look
    from .scene_tables import Workspace

#: Distances that have sunk beside the largest at the ends and in the middle of a step, as cubics
#: over its halves tell, are looked at; those that do so to this part in the polynomial turn a force
#: within the step, and those in formulas to this one: bounds tell how these vary, but for what
#: places are known to.
TURNING = 0.0625
TOLD_TURNING = 1e-2
#: Rates of squares are told by their difference over this part of a step, 2⁻²⁰.
DIFFERENCE = 9.5367431640625e-7
#: The node in the middle of a step: each lies twice as far from its start as the one before it, the
#: first at that difference.
DOUBLED = 20
#: Parts of a step where squares are asked for: at its ends, in its middle, and beside these.
NODES = (0.0, DIFFERENCE, 0.5, 0.5 + DIFFERENCE, 1.0 - DIFFERENCE, 1.0)
#: A force turns within so many times the time in which a distance gets larger by as much as it is.
AROUND = 8.0
#: A step of so many times no way leads over such a place, and has no other.
LEAP = 4.0
#: Where the golden section divides an interval, and how often it does.
GOLDEN = 0.3819660112501051
MOST_SECTIONS = 80


def distances_of(time: float, y: Array, w: Workspace) -> Array:
    """Squares of distances of y at a time."""
    read_of(time, y, w)
    w.run("distance")
    return np.concatenate((w.lengths, w.distances))


def distances_at(time: float, look: Look) -> Array:
    """Squares of distances at a time."""
    interpolate(look.m, (time - look.start) / look.h, look.state, look.work.scratch)
    return distances_of(time, look.work.scratch, look.work.w)


def dip_between(first: float, slope: float, last: float, rise: float) -> float:
    """Least value inside of a cubic of these values and slopes at 0 and 1, infinite if none is."""
    way = last - first
    bend, twist = 3.0 * way - 2.0 * slope - rise, slope + rise - 2.0 * way
    inner = bend * bend - 3.0 * twist * slope
    root = bend + math.sqrt(larger(inner, 0.0))
    if inner < 0.0 or root == 0.0:
        return math.inf
    place = -slope / root
    if not 0.0 <= place <= 1.0:
        return math.inf
    return first + place * (slope + place * (bend + place * twist))


def largest_of(nodes: Array) -> float:
    """Largest square of a distance at the ends and in the middle of a step."""
    return larger(larger(float(nodes[0]), float(nodes[5])), float(nodes[2]))


def sinks_in(half: int, nodes: Array) -> bool:
    """Whether the square of a distance may sink in the first or second half of a step."""
    first, beside, middle, behind, before, last = nodes.tolist()
    slope = (behind - middle) * (0.5 / DIFFERENCE)
    if half == 0:
        least = smaller(
            first, dip_between(first, (beside - first) * (0.5 / DIFFERENCE), middle, slope)
        )
    else:
        least = smaller(
            last, dip_between(middle, slope, last, (last - before) * (0.5 / DIFFERENCE))
        )
    return least < SUNK * SUNK * largest_of(nodes)


def may_turn(h: float, y: Array, f: Array, look: Look) -> bool:
    """Whether a distance may sink in a step of length h from the state to y, with derivative f.

    A cubic polynomial tells what is in it.
    """
    state, nodes = look.state, []
    for part in NODES:
        rest, along = 1.0 - part, part * part * (3.0 - 2.0 * part)
        curve = h * part * rest
        there = (1.0 - along) * state.y + along * y + curve * (rest * state.f - part * f)
        nodes.append(distances_of(state.time + part * h, there, look.work.w))
    return any(sinks_in(half, own) for own in np.array(nodes).T for half in range(2))


def node_of(number: int) -> float:
    """Part of a step at a node of those among which a distance is looked for.

    They lie the closer the nearer they are to its ends: a step that was cut begins right before a
    place.
    """
    if number == 0:
        return 0.0
    if number <= DOUBLED:
        return math.ldexp(DIFFERENCE, number - 1)
    return 1.0 - node_of(2 * DOUBLED - number)


def nearest_time(k: int, first: float, last: float, look: Look) -> float:
    """Time between two in a step at which a distance is least, by golden sections."""
    a, b = first + GOLDEN * (last - first), last - GOLDEN * (last - first)
    there, beyond = float(distances_at(a, look)[k]), float(distances_at(b, look)[k])
    for _ in range(MOST_SECTIONS):
        if not first < a < b < last:
            break
        if there < beyond:
            last, b, beyond = b, a, there
            a = first + GOLDEN * (last - first)
            there = float(distances_at(a, look)[k])
        else:
            first, a, there = a, b, beyond
            b = last - GOLDEN * (last - first)
            beyond = float(distances_at(b, look)[k])
    return a if there < beyond else b


def no_way(look: Look) -> float:
    """Time of a step that is no way: bounds tell nothing of what is in it, and rounding little."""
    tiny = ONWARD * SMALLEST * larger(abs(look.start), abs(look.start + look.h))
    return larger(FINEST * look.h, 2.0 * tiny)


def cut_end(k: int, time: float, nodes: Array, end: float, look: Look) -> float:
    """Time at which a step to an end must end by a distance that is least at a time.

    Before the place, or behind it if that is no way; infinite where it need not.
    """
    tiny = ONWARD * SMALLEST * larger(abs(look.start), abs(end))
    before, far = float(nodes[0]), largest_of(nodes)
    way, least = time - look.start, float(distances_at(time, look)[k])
    nothing = no_way(look)
    part = TURNING if k < look.work.scene.size("lengths") else TOLD_TURNING
    if not (far > 0.0 and least < part * part * far and end - time > tiny):
        return math.inf
    if not way > tiny and not look.h * math.sqrt(larger(before / far, 0.0)) < 0.5 * nothing:
        return math.inf  # it starts behind the place
    if is_leap(end, look) and end - time > BEHIND * look.h:
        return math.inf  # it is made to lead over the place, and does
    farthest = 0.0 if before == far else 0.5 if float(nodes[2]) == far else 1.0
    from_there = abs(way - farthest * look.h)
    turn = AROUND * from_there * math.sqrt(larger(least / (far - least), 0.0))
    return cut_beside(time, larger(nothing, turn), look)


def turning_end(k: int, nodes: Array, end: float, look: Look) -> tuple[float, float]:
    """Time at which a step to an end must end by the first such place of a distance, and that."""
    time, before, there = look.start, math.inf, float(nodes[0])
    earlier = time
    for number in range(2 * DOUBLED):
        following = look.start + node_of(number + 1) * look.h
        beyond = float(distances_at(following, look)[k])
        if there <= before and there < beyond:
            place = nearest_time(k, earlier, following, look)
            found = cut_end(k, place, nodes, end, look)
            if found < math.inf:
                return found, place
        earlier, time, before, there = time, following, there, beyond
    return math.inf, math.inf


def is_on_the_way(k: int, place: float, before: float, look: Look) -> bool:
    """Whether a distance sinks to an early place of a trial that is not kept at its first rates.

    Stages that meet a force which the others pass by throw its polynomial off: it then has places
    that are none, also right at its start, and again wherever the trial is made again.
    """
    state, way, early = look.state, place - look.start, EARLY * look.h
    if look.is_kept or not way < early:
        return True
    there, beyond = (
        float(distances_of(look.start + part, state.y + part * state.f, look.work.w)[k])
        for part in (way, early)
    )
    return there <= larger(SUNK * SUNK * before, THERE * THERE * beyond)


def turned_end(end: float, look: Look) -> float:
    """Time at which a step to an end must end by all distances, infinite where it need not."""
    found = place = math.inf
    nodes = np.array([distances_at(look.start + part * look.h, look) for part in NODES])
    for k, own in enumerate(nodes.T):
        if sinks_in(0, own) or sinks_in(1, own):
            cut, nearest = turning_end(k, own, end, look)
            if cut < found and is_on_the_way(k, nearest, float(own[0]), look):
                found, place = cut, nearest
    if found < end:
        look.place = place
        look.is_over = found - look.start < LEAP * no_way(look)
    return found
