"""Distances: steps end where one along which a force acts comes down to zero, or nearly.

There the force reverses in a time that is none, or as good as none: stages on both sides may tell
no error of it, and a step may pass two such places. On a smooth way a step that meets the tolerance
has no distance that is much smaller inside of it than at its ends: only where one may be it is
looked for in the polynomial. The step is made again, to end right before that place, and the next
one, to end as far behind.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from .arithmetic import larger, smaller
from .crossing import ONWARD
from .cuts import BEHIND, EARLY, FALLEN_PART, THERE, cut_beside, leads_over
from .dense_output import interpolate
from .search import SMALLEST, read_of
from .variation import FINEST

if TYPE_CHECKING:
    from .arithmetic import Array
    from .scene_tables import Workspace
    from .search import Search

#: A distance is looked at where cubics over the halves of a step fall far below its largest value
#: at ends and middle. It reverses a force within the step where it falls to the first part in the
#: polynomial, one in formulas to the second: bounds tell how these vary, but for errors of places.
REVERSAL_PART = 0.0625
BOUNDED_REVERSAL_PART = 1e-2
#: Rates of squares are their differences over this part of a step, 2⁻²⁰.
DIFFERENCE = 9.5367431640625e-7
#: The node in the middle of a step: each lies twice as far from its start as the one before it, the
#: first at that difference.
DOUBLED = 20
#: Parts of a step where squares are asked for: at its ends, in its middle, and beside these.
NODES = (0.0, DIFFERENCE, 0.5, 0.5 + DIFFERENCE, 1.0 - DIFFERENCE, 1.0)
#: A force reverses within so many times the time in which a distance grows by as much as it is.
AROUND = 8.0
#: A step of so many times no way leads over such a place, and has no other.
OVER_PLACE = 4.0
#: Where the golden section divides an interval, and how often it does.
GOLDEN = 0.3819660112501051
MOST_SECTIONS = 80


def distances_of(time: float, y: Array, w: Workspace) -> Array:
    """Squares of distances (distances,) [m²] of y (ny,) at a time [s]."""
    read_of(time, y, w)
    w.run("distance")
    return np.concatenate((w.lengths, w.distances))


def distances_at(time: float, search: Search) -> Array:
    """Squares of distances (distances,) [m²] at a time [s] of the step."""
    interpolate(search.m, (time - search.start) / search.h, search.state, search.work.scratch)
    return distances_of(time, search.work.scratch, search.work.w)


def dip_between(first: float, slope: float, last: float, rise: float) -> float:
    """Minimum inside of a cubic of these values and slopes at 0 and 1, infinite if it has none."""
    change = last - first
    quadratic, cubic = 3.0 * change - 2.0 * slope - rise, slope + rise - 2.0 * change
    inner = quadratic * quadratic - 3.0 * cubic * slope
    root = quadratic + math.sqrt(larger(inner, 0.0))
    if inner < 0.0 or root == 0.0:
        return math.inf
    part = -slope / root
    if not 0.0 <= part <= 1.0:
        return math.inf
    return first + part * (slope + part * (quadratic + part * cubic))


def largest_of(nodes: Array) -> float:
    """Largest square [m²] of a distance at both ends and in the middle of a step.

    Nodes (6,) [m²] are its squares at :data:`NODES`.
    """
    return larger(larger(float(nodes[0]), float(nodes[5])), float(nodes[2]))


def falls_in(half: int, nodes: Array) -> bool:
    """Whether the square of a distance may fall in the first or second half of a step.

    Nodes (6,) [m²] are its squares at :data:`NODES`.
    """
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
    return least < FALLEN_PART * FALLEN_PART * largest_of(nodes)


def may_reverse(h: float, y: Array, f: Array, search: Search) -> bool:
    """Whether a distance may fall in a step of h [s] from the state to y (ny,), f = ẏ (ny,) there.

    By squares of distances along the cubic polynomial between both.
    """
    state, nodes = search.state, []
    for part in NODES:
        rest, along = 1.0 - part, part * part * (3.0 - 2.0 * part)
        curve = h * part * rest
        there = (1.0 - along) * state.y + along * y + curve * (rest * state.f - part * f)
        nodes.append(distances_of(state.time + part * h, there, search.work.w))
    return any(falls_in(half, squares) for squares in np.array(nodes).T for half in range(2))


def node_of(number: int) -> float:
    """Part of a step at a node of the search for minima of a distance.

    They lie the closer the nearer they are to its ends: a step that was cut begins right before a
    place.
    """
    if number == 0:
        return 0.0
    if number <= DOUBLED:
        return math.ldexp(DIFFERENCE, number - 1)
    return 1.0 - node_of(2 * DOUBLED - number)


def nearest_time(k: int, first: float, last: float, search: Search) -> float:
    """Time [s] between two in a step at which a distance is least, by golden sections."""
    a, b = first + GOLDEN * (last - first), last - GOLDEN * (last - first)
    there, beyond = float(distances_at(a, search)[k]), float(distances_at(b, search)[k])
    for _ in range(MOST_SECTIONS):
        if not first < a < b < last:
            break
        if there < beyond:
            last, b, beyond = b, a, there
            a = first + GOLDEN * (last - first)
            there = float(distances_at(a, search)[k])
        else:
            first, a, there = a, b, beyond
            b = last - GOLDEN * (last - first)
            beyond = float(distances_at(b, search)[k])
    return a if there < beyond else b


def no_way(search: Search) -> float:
    """Length [s] of a step that counts as none: bounds tell nothing of it, and rounding little."""
    tiny = ONWARD * SMALLEST * larger(abs(search.start), abs(search.start + search.h))
    return larger(FINEST * search.h, 2.0 * tiny)


def cut_end(k: int, time: float, nodes: Array, end: float, search: Search) -> float:
    """Time [s] at which a step to an end must end by a distance that is least at a time.

    Before the place, or behind it if that is no way; infinite where it need not. Nodes (6,) [m²]
    are the squares of the distance at :data:`NODES`.
    """
    tiny = ONWARD * SMALLEST * larger(abs(search.start), abs(end))
    before, far = float(nodes[0]), largest_of(nodes)
    span, least = time - search.start, float(distances_at(time, search)[k])
    negligible = no_way(search)
    part = REVERSAL_PART if k < search.work.scene.size("lengths") else BOUNDED_REVERSAL_PART
    if not (far > 0.0 and least < part * part * far and end - time > tiny):
        return math.inf
    if not span > tiny and not search.h * math.sqrt(larger(before / far, 0.0)) < 0.5 * negligible:
        return math.inf  # it starts behind the place
    if leads_over(end, search) and end - time > BEHIND * search.h:
        return math.inf  # it is made to lead over the place, and does
    farthest = 0.0 if before == far else 0.5 if float(nodes[2]) == far else 1.0
    from_there = abs(span - farthest * search.h)
    near = AROUND * from_there * math.sqrt(larger(least / (far - least), 0.0))
    return cut_beside(time, larger(negligible, near), search)


def first_reversal(k: int, nodes: Array, end: float, search: Search) -> tuple[float, float]:
    """Time [s] at which a step must end by the first reversal of a distance, and its place [s].

    Nodes (6,) [m²] are its squares at :data:`NODES`.
    """
    time, before, there = search.start, math.inf, float(nodes[0])
    earlier = time
    for number in range(2 * DOUBLED):
        following = search.start + node_of(number + 1) * search.h
        beyond = float(distances_at(following, search)[k])
        if there <= before and there < beyond:
            place = nearest_time(k, earlier, following, search)
            cut = cut_end(k, place, nodes, end, search)
            if cut < math.inf:
                return cut, place
        earlier, time, before, there = time, following, there, beyond
    return math.inf, math.inf


def is_on_the_way(k: int, place: float, before: float, search: Search) -> bool:
    """Whether a distance falls to an early place of a trial that is not kept at its first rates.

    Stages that meet a force which the others pass by throw its polynomial off: it then has places
    that are none, also right at its start, and again wherever the trial is made again.
    """
    state, to_place, early = search.state, place - search.start, EARLY * search.h
    if search.is_kept or not to_place < early:
        return True
    there, beyond = (
        float(distances_of(search.start + span, state.y + span * state.f, search.work.w)[k])
        for span in (to_place, early)
    )
    return there <= larger(FALLEN_PART * FALLEN_PART * before, THERE * THERE * beyond)


def reversal_end(end: float, search: Search) -> float:
    """Time [s] at which a step to an end must end by all distances, infinite where it need not."""
    first_cut = place = math.inf
    nodes = np.array([distances_at(search.start + part * search.h, search) for part in NODES])
    for k, squares in enumerate(nodes.T):
        if falls_in(0, squares) or falls_in(1, squares):
            cut, nearest = first_reversal(k, squares, end, search)
            if cut < first_cut and is_on_the_way(k, nearest, float(squares[0]), search):
                first_cut, place = cut, nearest
    if first_cut < end:
        search.place = place
        search.is_over = first_cut - search.start < OVER_PLACE * no_way(search)
    return first_cut
