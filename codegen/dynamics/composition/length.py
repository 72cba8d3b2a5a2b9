"""A length of a scene: corrections are compared to it, and torques are weighed by it."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from kousoku.model.mechanism import System


def characteristic_length(system: System) -> float:
    """Return the largest distance of a joint from the origin of a frame [m]; 1 where none is."""
    constants = [pair for instance in system.constraints for pair in instance.constants]
    constants += [pair for coordinate in system.coordinates for pair in coordinate.constants]
    lengths = [
        max(abs(x) for x in numbers)
        for name, numbers in constants
        if name.startswith("s_") or name == "length"
    ]
    return max(lengths, default=0.0) or 1.0
