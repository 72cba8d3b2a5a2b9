"""The same system near the origin of frame O, where doubles tell its positions best."""

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
"""So many sizes of a system from the origin it stays where it is: that costs three digits."""


def brought_near(system: System, size: float) -> tuple[System, Vector]:
    """System moved as a whole to the origin, and by which vector (3,) [m] it is to be moved back.

    It moves along the axes of frame O on which all of its positions keep all of their digits, the
    ground's points too: what is spread from the origin to far away stays.

    Parameters
    ----------
    system : System
        Its numbers are those of a scene, without parameters.
    size : float [m]
        The size of it.
    """
    grid = 2.0 ** math.ceil(math.log2(MOST_SIZES_FROM_ORIGIN * size))
    sources: tuple[Instance | RelativeCoordinate, ...] = (
        *system.constraints,
        *system.held,
        *system.coordinates,
    )
    places: list[tuple[float, ...]] = [body.r for body in system.bodies]
    places += chain.from_iterable(map(_ground_points, sources))
    middle = [median(x) for x in zip(*(body.r for body in system.bodies), strict=True)]
    wanted = [grid * round(x / grid) for x in middle]
    x, y, z = (
        by if all((a - by) + by == a for a in along) else 0.0
        for by, along in zip(wanted, zip(*places, strict=True), strict=True)
    )
    by = (x, y, z)
    return (seen_from(system, by) if any(by) else system), by


def seen_from(system: System, origin: Vector) -> System:
    """System with the origin of frame O in another place of it [m]: bodies and ground points."""
    return replace(
        system,
        bodies=tuple(replace(body, r=_less(body.r, origin)) for body in system.bodies),
        constraints=tuple(_moved(one, origin) for one in system.constraints),
        held=tuple(_moved(one, origin) for one in system.held),
        coordinates=tuple(_moved(one, origin) for one in system.coordinates),
    )


def _ground_points(source: Instance | RelativeCoordinate) -> Iterator[tuple[float, ...]]:
    yield from (x for name, x in source.constants if is_ground_point(source, name))


def _moved(source: Source, by: Vector) -> Source:
    constants = tuple(
        (name, _less(x, by) if is_ground_point(source, name) else x) for name, x in source.constants
    )
    return replace(source, constants=constants)


def _less(a: Sequence[float], b: Vector) -> Vector:
    x, y, z = (p - q for p, q in zip(a, b, strict=True))
    return x, y, z
