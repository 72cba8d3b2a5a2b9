"""The same system near the origin of frame O, where doubles resolve its positions best."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import chain
from statistics import median
from typing import TYPE_CHECKING, TypeVar

from kousoku.codegen.dynamics.operations.characteristic_length import is_ground_point

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from kousoku.model.mechanics.multibody import Instance, RelativeCoordinate, System
    from kousoku.model.records.orientation import Vector

    Source = TypeVar("Source", Instance, RelativeCoordinate)

MOST_SIZES_FROM_ORIGIN = 1024.0
"""Distance from the origin, in sizes of a system, up to which it stays: that costs three digits."""


def brought_near(system: System, size: float) -> tuple[System, Vector]:
    """System moved as a whole to the origin, and the vector (3,) [m] that moves it back.

    It moves along the axes of frame O on which all of its positions keep all of their digits, the
    ground's points too: a system that extends from the origin to far away stays.

    Parameters
    ----------
    system : System
        A scene in numbers, without parameters.
    size : float [m]
        The size of the system.
    """
    grid = 2.0 ** math.ceil(math.log2(MOST_SIZES_FROM_ORIGIN * size))
    sources: tuple[Instance | RelativeCoordinate, ...] = (
        *system.constraints,
        *system.held,
        *system.coordinates,
    )
    points: list[tuple[float, ...]] = [body.r for body in system.bodies]
    points += chain.from_iterable(map(_ground_points, sources))
    middle = [median(x) for x in zip(*(body.r for body in system.bodies), strict=True)]
    rounded = [grid * round(x / grid) for x in middle]
    x, y, z = (
        offset if all((a - offset) + offset == a for a in along) else 0.0
        for offset, along in zip(rounded, zip(*points, strict=True), strict=True)
    )
    offset = (x, y, z)
    return (seen_from(system, offset) if any(offset) else system), offset


def seen_from(system: System, origin: Vector) -> System:
    """System seen from another origin [m] of frame O: its bodies and points of the ground."""
    return replace(
        system,
        bodies=tuple(replace(body, r=_difference(body.r, origin)) for body in system.bodies),
        constraints=tuple(_moved(c, origin) for c in system.constraints),
        held=tuple(_moved(c, origin) for c in system.held),
        coordinates=tuple(_moved(c, origin) for c in system.coordinates),
    )


def _ground_points(source: Instance | RelativeCoordinate) -> Iterator[tuple[float, ...]]:
    yield from (x for name, x in source.constants if is_ground_point(source, name))


def _moved(source: Source, origin: Vector) -> Source:
    constants = tuple(
        (name, _difference(x, origin) if is_ground_point(source, name) else x)
        for name, x in source.constants
    )
    return replace(source, constants=constants)


def _difference(a: Sequence[float], b: Vector) -> Vector:
    x, y, z = (p - q for p, q in zip(a, b, strict=True))
    return x, y, z
