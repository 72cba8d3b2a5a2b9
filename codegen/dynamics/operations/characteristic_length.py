"""Characteristic length of a scene: corrections are compared to it, torques weighed by it."""

from __future__ import annotations

import math
from itertools import chain
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.operations.mechanics import lengths_of
from kousoku.model.records.own_kind import ORIGINS

if TYPE_CHECKING:
    from kousoku.model.mechanics.multibody import ForceElement, Instance, RelativeCoordinate, System

LEAST_LENGTH = 2.0**-18
"""The least length, as a part of the distance from the origin: doubles know a position to 6e-11 of
it, which is less than corrections settle at, and than residuals of constraints may be."""

ROUNDING_OF_PLACES = 2.0**-20
"""A smaller part of the largest radius of gyration is no length: positions that differ by it do so
by rounding, as cos(pi/2) does from zero."""

POINTS = {"s_i_b", "s_j_b", *ORIGINS}
"""Constants that are a point of a body, or of the ground."""


def is_ground_point(source: Instance | RelativeCoordinate | ForceElement, name: str) -> bool:
    """Whether a constant is a point in frame O."""
    return name in POINTS and (source.i if "_i" in name else source.j) < 0


def characteristic_length(system: System) -> float:
    """Length, a scalar [m], of a system that is the same wherever it stands, unless very far off.

    ℓ = max |s′_k| over the axes k of the body frames, of joints from the centre of mass of a body,
    and the extent along an axis of frame O of points of the ground; where that is none, but for
    rounding, that of :func:`extent`.
    """
    sources: tuple[Instance | RelativeCoordinate, ...] = (*system.constraints, *system.coordinates)
    lengths, ground = [0.0], []
    for source in sources:
        bodies = {"i": source.i, "j": source.j}
        for end, numbers in lengths_of(source):
            if bodies.get(end, 0) < 0:
                ground.append([float(x) for x in numbers])
            else:
                lengths += map(abs, numbers)
    lengths += (max(along) - min(along) for along in zip(*ground, strict=True))
    points = (*chain.from_iterable(ground), *chain.from_iterable(x.r for x in system.bodies))
    length = max(lengths)
    if not length > ROUNDING_OF_PLACES * gyration(system):
        length = extent(system)
    return max(length, LEAST_LENGTH * max(map(abs, points), default=0.0))


def gyration(system: System) -> float:
    """Largest radius of gyration √(I/m), a scalar [m], of the bodies; 0 where none has a mass."""
    bodies = ((float(max(body.inertia)), float(body.mass)) for body in system.bodies)
    return max((math.sqrt(moment / mass) for moment, mass in bodies if mass > 0.0), default=0.0)


def extent(system: System) -> float:
    """Extent, a scalar [m], of a system whose joints have no length.

    The largest distance, along an axis of frame O, between centres of mass and points of the ground
    at the start, or along one of a body frame of a force from a centre of mass; where that is none,
    but for rounding, the largest radius of :func:`gyration`. It is 1 where a point stands alone:
    nothing in the scene tells metres from other units then.
    """
    points = [tuple(map(float, body.r)) for body in system.bodies]
    lengths = [0.0]
    sources: tuple[Instance | RelativeCoordinate | ForceElement, ...]
    sources = (*system.constraints, *system.coordinates, *system.forces)
    for source in sources:
        for name, numbers in source.constants:
            if is_ground_point(source, name):
                points.append(tuple(map(float, numbers)))
            elif name in POINTS:
                lengths += (abs(float(x)) for x in numbers)
    lengths += (max(along) - min(along) for along in zip(*points, strict=True))
    length, radius = max(lengths), gyration(system)
    return (length if length > ROUNDING_OF_PLACES * radius else radius) or 1.0
