"""What the pictures of joints show: two bodies, a point, axes, and the freedoms that are left.

A joint of the table is drawn where its point is the origin. Lengths are those of the picture.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Vector = tuple[float, float, float]
Owner = Literal["i", "j", "-"]

X, Y, Z, ORIGIN = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class BoxShape:
    """A box along the axes between two of its corners; ``owner`` is its body."""

    owner: Owner
    low: Vector
    high: Vector


@dataclass(frozen=True, slots=True)
class CylinderShape:
    """A cylinder between the middles of its faces."""

    owner: Owner
    start: Vector
    end: Vector
    radius: float


@dataclass(frozen=True, slots=True)
class Ball:
    """A ball."""

    owner: Owner
    at: Vector
    radius: float


Solid = BoxShape | CylinderShape | Ball


@dataclass(frozen=True, slots=True)
class JointFreedom:
    """A motion of body j that the joint allows while body i rests.

    Parameters
    ----------
    kind : {"shift", "turn", "screw"}
        Along a direction, about it, or both at once.
    direction : (3,)
        Of norm one.
    at : (3,)
        Where the arrow stands; a turn is about the line through it.
    size : float
        Half the length of the arrow, or the radius of the arc.
    pitch : float
        Of a screw, the displacement in one turn.
    """

    kind: Literal["shift", "turn", "screw"]
    direction: Vector
    at: Vector = ORIGIN
    size: float = 0.6
    pitch: float = 0.0


@dataclass(frozen=True, slots=True)
class Shape:
    """The picture of a joint.

    Parameters
    ----------
    solids : tuple
        From back to front.
    freedoms : tuple of JointFreedom
        As many as 6 less the rows of the joint.
    axes : tuple of (point, direction)
        Axis of body i, and that of body j where it is another one.
    points : tuple of (3,)
        Point of body i, and that of body j where it is another one.
    """

    solids: tuple[Solid, ...]
    freedoms: tuple[JointFreedom, ...]
    axes: tuple[tuple[Vector, Vector], ...] = ()
    points: tuple[Vector, ...] = (ORIGIN,)


def _turns(
    at: Vector = ORIGIN, x: float = 1.0, y: float = -1.0, z: float = 1.0
) -> tuple[JointFreedom, ...]:
    """Turns about the axes through a point, drawn at distances x, y, z from it."""
    places = ((at[0] + x, at[1], at[2]), (at[0], at[1] + y, at[2]), (at[0], at[1], at[2] + z))
    return tuple(
        JointFreedom("turn", axis, place, 0.28)
        for axis, place in zip((X, Y, Z), places, strict=True)
    )


def _shifts(at: Vector) -> tuple[JointFreedom, ...]:
    return tuple(JointFreedom("shift", axis, at, 0.75) for axis in (X, Y, Z))


def _ridge(x: float) -> CylinderShape:
    """Ridge of a thread along x."""
    return CylinderShape("i", (x, 0.0, 0.0), (x + 0.08, 0.0, 0.0), 0.24)


_PLATE = BoxShape("i", (-1.5, -1.0, -0.2), (1.5, 1.0, 0.0))
_IN_PLATE = (
    JointFreedom("shift", X, (0.0, -0.8, 0.0), 0.7),
    JointFreedom("shift", Y, (1.1, 0.0, 0.0), 0.7),
)
_START, _END = (-1.5, 0.0, -0.2), (0.6, 0.0, 0.2)
_LENGTH = (2.1**2 + 0.4**2) ** 0.5
_ACROSS = (-0.4 / _LENGTH, 0.0, 2.1 / _LENGTH)
_APART = (
    BoxShape("i", (-1.6, -0.3, -0.4), (-0.8, 0.3, 0.4)),
    BoxShape("j", (0.6, -0.3, -0.3), (1.4, 0.3, 0.5)),
)
_MIDDLE = (1.0, 0.0, 0.1)

SHAPES: dict[str, Shape] = {
    "fixed": Shape(
        (
            BoxShape("i", (-1.5, -0.35, -0.35), (0.0, 0.35, 0.35)),
            BoxShape("j", (0.0, -0.25, -0.25), (1.4, 0.25, 0.25)),
        ),
        (),
    ),
    "revolute": Shape(
        (
            BoxShape("i", (-1.6, -0.25, -0.3), (0.3, 0.25, 0.0)),
            BoxShape("j", (-0.3, -0.25, 0.0), (1.6, 0.25, 0.3)),
            CylinderShape("i", (0.0, 0.0, 0.3), (0.0, 0.0, 0.42), 0.12),
        ),
        (JointFreedom("turn", Z, (0.0, 0.0, 0.75), 0.5),),
        ((ORIGIN, Z),),
    ),
    "prismatic": Shape(
        (
            BoxShape("i", (-1.7, -0.17, -0.17), (-0.5, 0.17, 0.17)),
            BoxShape("j", (-0.5, -0.4, -0.4), (0.5, 0.4, 0.4)),
            BoxShape("i", (0.5, -0.17, -0.17), (1.7, 0.17, 0.17)),
        ),
        (JointFreedom("shift", X, (0.0, 0.0, 0.75), 0.8),),
        ((ORIGIN, X),),
    ),
    "cylindrical": Shape(
        (
            CylinderShape("i", (-1.7, 0.0, 0.0), (-0.5, 0.0, 0.0), 0.15),
            CylinderShape("j", (-0.5, 0.0, 0.0), (0.5, 0.0, 0.0), 0.4),
            CylinderShape("i", (0.5, 0.0, 0.0), (1.7, 0.0, 0.0), 0.15),
        ),
        (
            JointFreedom("shift", X, (0.0, 0.0, 0.75), 0.8),
            JointFreedom("turn", X, (1.15, 0.0, 0.0), 0.5),
        ),
        ((ORIGIN, X),),
    ),
    "spherical": Shape(
        (
            BoxShape("i", (-0.35, -0.35, -1.3), (0.35, 0.35, -0.2)),
            Ball("j", ORIGIN, 0.36),
            CylinderShape("j", (0.25, 0.0, 0.25), (1.0, 0.0, 1.15), 0.14),
        ),
        _turns(z=0.85),
    ),
    "universal": Shape(
        (
            CylinderShape("i", (-1.8, 0.0, 0.0), (-0.7, 0.0, 0.0), 0.15),
            BoxShape("i", (-0.75, -0.5, -0.14), (-0.6, 0.5, 0.14)),
            BoxShape("i", (-0.6, 0.38, -0.14), (0.15, 0.5, 0.14)),
            BoxShape("j", (-0.15, -0.14, -0.5), (0.6, 0.14, -0.38)),
            CylinderShape("-", (0.0, 0.4, 0.0), (0.0, -0.4, 0.0), 0.09),
            CylinderShape("-", (0.0, 0.0, -0.38), (0.0, 0.0, 0.4), 0.09),
            BoxShape("j", (0.6, -0.14, -0.5), (0.75, 0.14, 0.5)),
            BoxShape("j", (-0.15, -0.14, 0.38), (0.6, 0.14, 0.5)),
            CylinderShape("j", (0.75, 0.0, 0.0), (1.8, 0.0, 0.0), 0.15),
            BoxShape("i", (-0.6, -0.5, -0.14), (0.15, -0.38, 0.14)),
        ),
        (
            JointFreedom("turn", Y, (0.0, -0.95, 0.0), 0.35),
            JointFreedom("turn", Z, (0.0, 0.0, 0.85), 0.4),
        ),
        ((ORIGIN, Y), (ORIGIN, Z)),
    ),
    "planar": Shape(
        (_PLATE, BoxShape("j", (-0.45, -0.35, 0.0), (0.45, 0.35, 0.45))),
        (*_IN_PLATE, JointFreedom("turn", Z, (0.0, 0.0, 0.75), 0.45)),
        ((ORIGIN, Z),),
    ),
    "rod": Shape(
        (
            BoxShape("i", (-1.9, -0.35, -0.9), (-1.2, 0.35, -0.2)),
            CylinderShape("-", _START, _END, 0.05),
            BoxShape("j", (0.6, -0.3, -0.05), (1.3, 0.3, 0.55)),
        ),
        (
            JointFreedom("shift", Y, _END, 0.7),
            JointFreedom("shift", _ACROSS, _END, 0.7),
            *_turns(_END, 1.05, -1.0, 0.95),
        ),
        points=(_START, _END),
    ),
    "point_on_line": Shape(
        (
            BoxShape("i", (-1.9, -0.25, -0.7), (-1.6, 0.25, 0.25)),
            CylinderShape("i", (-1.6, 0.0, 0.0), (1.6, 0.0, 0.0), 0.05),
            BoxShape("i", (1.6, -0.25, -0.7), (1.9, 0.25, 0.25)),
            CylinderShape("j", ORIGIN, (0.0, 0.0, 0.5), 0.07),
            Ball("j", ORIGIN, 0.13),
            BoxShape("j", (-0.35, -0.3, 0.45), (0.35, 0.3, 0.95)),
        ),
        (JointFreedom("shift", X, (0.5, 0.0, -0.72), 0.7), *_turns(x=0.95, z=1.25)),
        ((ORIGIN, X),),
    ),
    "point_on_plane": Shape(
        (
            _PLATE,
            CylinderShape("j", ORIGIN, (0.0, 0.0, 0.5), 0.07),
            BoxShape("j", (-0.35, -0.3, 0.45), (0.35, 0.3, 0.95)),
        ),
        (*_IN_PLATE, *_turns(x=1.9, y=-1.4, z=1.25)),
        ((ORIGIN, Z),),
    ),
    "parallel_axes": Shape(
        _APART,
        (*_shifts(_MIDDLE), JointFreedom("turn", Z, (1.0, 0.0, 1.05), 0.35)),
        (((-1.2, 0.0, 0.0), Z), (_MIDDLE, Z)),
        (),
    ),
    "perpendicular_axes": Shape(
        _APART,
        (
            *_shifts(_MIDDLE),
            JointFreedom("turn", Z, (1.0, 0.0, 1.05), 0.35),
            JointFreedom("turn", X, (2.0, 0.0, 0.1), 0.35),
        ),
        (((-1.2, 0.0, 0.0), Z), (_MIDDLE, X)),
        (),
    ),
    "screw": Shape(
        (
            CylinderShape("i", (-1.7, 0.0, 0.0), (-0.4, 0.0, 0.0), 0.17),
            *(_ridge(-1.5 + 0.2 * k) for k in range(6)),
            BoxShape("j", (-0.4, -0.4, -0.4), (0.4, 0.4, 0.4)),
            CylinderShape("i", (0.4, 0.0, 0.0), (1.7, 0.0, 0.0), 0.17),
            *(_ridge(0.5 + 0.2 * k) for k in range(6)),
        ),
        (JointFreedom("screw", X, (0.0, 0.0, 0.0), 0.72, 0.45),),
        ((ORIGIN, X),),
    ),
    "constant_velocity": Shape(
        (
            CylinderShape("i", (-1.8, 0.0, 0.0), (-0.5, 0.0, 0.0), 0.15),
            CylinderShape("i", (-0.5, 0.0, 0.0), (0.05, 0.0, 0.0), 0.5),
            Ball("-", ORIGIN, 0.36),
            CylinderShape("j", (0.3, 0.0, 0.0), (1.8, 0.0, 0.0), 0.15),
        ),
        (
            JointFreedom("turn", Y, (0.0, -0.95, 0.0), 0.35),
            JointFreedom("turn", Z, (0.0, 0.0, 0.95), 0.4),
        ),
        ((ORIGIN, X),),
    ),
}
"""The picture of each joint, by its name in :data:`kousoku.model.joints.JOINTS`."""


def _of(joint: str, *places: int) -> tuple[Solid, ...]:
    """Solids that a joint is drawn with, those that are wanted."""
    return tuple(SHAPES[joint].solids[place] for place in places)


SIGNS: dict[str, tuple[Solid, ...]] = {
    "fixed": (BoxShape("i", (-0.3, -0.3, -0.3), (0.3, 0.3, 0.3)),),
    "revolute": (CylinderShape("i", (0.0, 0.0, -0.5), (0.0, 0.0, 0.5), 0.36),),
    "prismatic": _of("prismatic", 1),
    "cylindrical": _of("cylindrical", 1),
    "spherical": _of("spherical", 1),
    "universal": (
        CylinderShape("i", (0.0, 0.6, 0.0), (0.0, -0.6, 0.0), 0.24),
        CylinderShape("j", (0.0, 0.0, -0.6), (0.0, 0.0, 0.6), 0.24),
    ),
    "planar": (BoxShape("i", (-0.9, -0.9, -0.12), (0.9, 0.9, 0.0)), *_of("planar", 1)),
    "rod": (Ball("i", ORIGIN, 0.3), Ball("j", ORIGIN, 0.3)),
    "point_on_line": (Ball("j", ORIGIN, 0.36),),
    "point_on_plane": (
        BoxShape("i", (-0.9, -0.9, -0.12), (0.9, 0.9, 0.0)),
        Ball("j", ORIGIN, 0.36),
    ),
    "parallel_axes": (),
    "perpendicular_axes": (),
    "screw": (
        *_of("screw", 7),
        CylinderShape("j", (-0.62, 0.0, 0.0), (-0.4, 0.0, 0.0), 0.3),
        CylinderShape("j", (0.4, 0.0, 0.0), (0.62, 0.0, 0.0), 0.3),
    ),
    "constant_velocity": _of("constant_velocity", 1, 2),
}
"""What stands for each joint in the picture of a mechanism: the middle of its own picture.

Lengths are those of :data:`SHAPES`, where the rods that meet in a joint are 0.3 thick. What is body
i's stands in the joint frame of body i, along its axis, the rest in that of body j.
"""
