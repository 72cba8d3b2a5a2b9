"""A length of a scene: corrections are compared to it, and torques are weighed by it."""

from __future__ import annotations

from itertools import chain
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.operations.mechanics import lengths_of
from kousoku.model.own_kind import ORIGINS

if TYPE_CHECKING:
    from kousoku.model.mechanism import Coordinate, Instance, System

LEAST = 2.0**-18
"""The least length, as a part of the distance from the origin: doubles know a position to 6e-11 of
it, which is less than what corrections settle at, and what is left of constraints may be."""


def is_ground_point(source: Instance | Coordinate, name: str) -> bool:
    """Whether a constant is a point in frame O."""
    is_point = name in {"s_i_b", "s_j_b", *ORIGINS}
    return is_point and (source.i if "_i" in name else source.j) < 0


def characteristic_length(system: System) -> float:
    """Length of a system that is the same wherever it stands, unless very far off [m].

    The largest distance, along an axis, of a joint from the centre of mass of a body, or between
    two points of the ground; 1 where none is.
    """
    sources: tuple[Instance | Coordinate, ...] = (*system.constraints, *system.coordinates)
    lengths, ground = [0.0], []
    for source in sources:
        bodies = {"i": source.i, "j": source.j}
        for end, numbers in lengths_of(source):
            if bodies.get(end, 0) < 0:
                ground.append([float(x) for x in numbers])
            else:
                lengths += map(abs, numbers)
    lengths += (max(along) - min(along) for along in zip(*ground, strict=True))
    places = (*chain.from_iterable(ground), *chain.from_iterable(one.r for one in system.bodies))
    return max(max(lengths) or 1.0, LEAST * max(map(abs, places), default=0.0))
