"""Cuts: steps end right before places where a force reverses or jumps; the next lead over them.

Stages on both sides of such a place throw the polynomial of a step off, and what they leave in it
has the same sign each time.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .arithmetic import larger
from .crossing import SMALL

if TYPE_CHECKING:
    from .search import Search

#: A step that was cut leads over such a place where this part of it is behind.
BEHIND = 0.3
#: Places within the first part of a trial that is not kept must be such along its first rates, too:
#: values fall there to the second part of the first one, or to the third of that at its end.
EARLY = 0.1
FALLEN_PART = 0.3
THERE = 1e-3
#: How often a step is cut for such places.
MOST_PLACE_CUTS = 8


def leads_over(end: float, search: Search) -> bool:
    """Whether a step to an end is made to lead over a place."""
    return end == search.place_cut and search.place < end


def cut_beside(place: float, near: float, search: Search) -> float:
    """Time [s] at which a step is cut for a place: before it, or behind it if that is too near."""
    span = place - search.start
    return place - larger(near, SMALL * span) if span > 2.0 * near else place + near


def cut_for_place(end: float, seen: float, search: Search) -> float:
    """Time [s] at which a step is cut for places; after many cuts the time seen, which is noted."""
    search.place_cuts += 1
    if search.place_cuts > MOST_PLACE_CUTS:
        search.is_unresolved = True
        return seen
    search.crosses = np.zeros(len(search.state.sides), dtype=bool)
    search.place_cut = end
    return end
