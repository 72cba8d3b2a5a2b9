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
from .crossing import FINEST, ONWARD, SMALL, SMALLEST, read_of
from .dense_output import interpolate

if TYPE_CHECKING:
    from .arithmetic import Array
    from .crossing import Look
    from .scene_tables import Workspace

#: Distances that sink to this part of the larger one at the ends, as a parabola tells, are looked
#: at; those that do so to this part in the polynomial turn a force within the step, and those in
#: formulas to this one: bounds tell how these vary, but for what places are known to.
SUNK = 0.3
TURNING = 0.0625
TOLD_TURNING = 1e-2
#: A force turns within so many times the time in which a distance gets larger by as much as it is.
AROUND = 8.0
#: A step that was cut leads over such a place where this part of it is behind.
BEHIND = 0.3
#: A step of so many times no way leads over such a place, and has no other.
LEAP = 4.0
#: How often a step is cut for distances.
MOST_TURNED = 8
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


def sinks_between(first: float, middle: float, last: float) -> bool:
    """Whether the square of a distance may sink between three times, as a parabola through it."""
    slope, bend = 0.5 * (last - first), 0.5 * (first + last) - middle
    least = smaller(first, last)
    if bend > 0.0 and abs(slope) < 2.0 * bend:
        least = middle - slope * slope / (4.0 * bend)
    return least < SUNK * SUNK * larger(first, last)


def may_turn(h: float, y: Array, f: Array, look: Look) -> bool:
    """Whether a distance may sink in a step of length h from the state to y, with derivative f.

    A cubic polynomial tells what is in the middle.
    """
    state, w = look.state, look.work.w
    middle = 0.5 * (state.y + y) + 0.125 * h * (state.f - f)
    first = distances_of(state.time, state.y, w)
    there = distances_of(state.time + 0.5 * h, middle, w)
    last = distances_of(state.time + h, y, w)
    return any(map(sinks_between, first.tolist(), there.tolist(), last.tolist()))


def nearest_time(k: int, look: Look) -> float:
    """Time in a step at which a distance is least, by golden sections."""
    first, last = look.start, look.start + look.h
    a, b = first + GOLDEN * look.h, last - GOLDEN * look.h
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


def turning_end(k: int, before: float, after: float, end: float, look: Look) -> float:
    """Time at which a step to an end must end by a distance, of these squares at its ends.

    Before the place, or behind it if that is no way; infinite where it need not.
    """
    time = nearest_time(k, look)
    tiny = ONWARD * SMALLEST * larger(abs(look.start), abs(end))
    way, least, far = time - look.start, float(distances_at(time, look)[k]), larger(before, after)
    nothing = no_way(look)
    part = TURNING if k < look.work.scene.size("lengths") else TOLD_TURNING
    if not (far > 0.0 and least < part * part * far and end - time > tiny):
        return math.inf
    if not way > tiny and not look.h * math.sqrt(larger(before / far, 0.0)) < 0.5 * nothing:
        return math.inf  # it starts behind the place
    if end == look.turning and end - time > BEHIND * look.h:
        return math.inf  # it leads over the place
    from_there = way if before > after else end - time
    turn = AROUND * from_there * math.sqrt(larger(least / (far - least), 0.0))
    near = larger(nothing, turn)
    if way > 2.0 * near:
        return time - larger(near, SMALL * way)
    return time + near


def turned_in(turned: float, seen: float, look: Look) -> float:
    """Time at which a step is cut for distances; what was seen, which is noted, after many cuts."""
    look.turned += 1
    if look.turned > MOST_TURNED:
        look.is_untold = True
        return seen
    look.crosses = np.zeros(len(look.state.sides), dtype=bool)
    look.turning = turned
    return turned


def turned_end(end: float, look: Look) -> float:
    """Time at which a step to an end must end by all distances, infinite where it need not."""
    found = math.inf
    times = (look.start, look.start + 0.5 * look.h, look.start + look.h)
    first, middle, last = (distances_at(time, look).tolist() for time in times)
    for k, (before, there, after) in enumerate(zip(first, middle, last, strict=True)):
        if sinks_between(before, there, after):
            found = smaller(found, turning_end(k, before, after, end, look))
    if found < end:
        look.is_over = found - look.start < LEAP * no_way(look)
    return found
