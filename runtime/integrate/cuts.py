"""Cuts: steps end right before places where a force turns round or jumps; the next lead over them.

Stages on both sides of such a place throw the polynomial of a step off, and what they leave in it
has the same sign each time.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .arithmetic import larger
from .crossing import SMALL

if TYPE_CHECKING:
    from .crossing import Look

#: A step that was cut leads over such a place where this part of it is behind.
BEHIND = 0.3
#: Places within this part of a trial that is not kept must lie where its first rates lead: what is
#: zero there has sunk to this part of what it was, or is that part of the one to which they lead.
EARLY = 0.1
SUNK = 0.3
THERE = 1e-3
#: How often a step is cut for such places.
MOST_TURNED = 8


def is_leap(end: float, look: Look) -> bool:
    """Whether a step to an end is made to lead over a place."""
    return end == look.turning and look.place < end


def cut_beside(place: float, near: float, look: Look) -> float:
    """Time at which a step is cut for a place: before it, or behind it if that is no way."""
    way = place - look.start
    return place - larger(near, SMALL * way) if way > 2.0 * near else place + near


def turned_in(turned: float, seen: float, look: Look) -> float:
    """Time at which a step is cut for places; what was seen, which is noted, after many cuts."""
    look.turned += 1
    if look.turned > MOST_TURNED:
        look.is_untold = True
        return seen
    look.crosses = np.zeros(len(look.state.sides), dtype=bool)
    look.turning = turned
    return turned
