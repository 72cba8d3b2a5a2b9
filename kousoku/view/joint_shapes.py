"""Pictures of joints: two bodies, a point, axes, the freedoms that are left; and their signs.

A joint of the table is drawn where its point is the origin. Lengths are those of the picture.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from kousoku.model.records.orientation import Vector

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
class JointPicture:
    """A joint as it is drawn, alone and in a mechanism.

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
    sign : tuple
        What stands for it in a mechanism, where the rods that meet in it are 0.3 thick: mostly the
        middle of its own picture. What is body i's stands in the joint frame of body i, along its
        axis, the rest in that of body j.
    slides : bool
        Whether bodies move along its axis, which then is drawn as a guide.
    has_pedestal : bool
        Whether a pedestal stands under it on the ground.
    is_rod : bool
        Whether a rod is drawn from its point on body i to that on body j.
    """

    solids: tuple[Solid, ...]
    freedoms: tuple[JointFreedom, ...]
    axes: tuple[tuple[Vector, Vector], ...] = ()
    points: tuple[Vector, ...] = (ORIGIN,)
    sign: tuple[Solid, ...] = ()
    slides: bool = False
    has_pedestal: bool = True
    is_rod: bool = False


def _turns(
    at: Vector = ORIGIN, x: float = 1.0, y: float = -1.0, z: float = 1.0
) -> tuple[JointFreedom, ...]:
    """Turns about the axes through a point, drawn at distances x, y, z from it."""
    centers = ((at[0] + x, at[1], at[2]), (at[0], at[1] + y, at[2]), (at[0], at[1], at[2] + z))
    return tuple(
        JointFreedom("turn", axis, center, 0.28)
        for axis, center in zip((X, Y, Z), centers, strict=True)
    )


def _ridge(x: float) -> CylinderShape:
    """Ridge of a thread along x."""
    return CylinderShape("i", (x, 0.0, 0.0), (x + 0.08, 0.0, 0.0), 0.24)


_PLATE = BoxShape("i", (-1.5, -1.0, -0.2), (1.5, 1.0, 0.0))
_SMALL_PLATE = BoxShape("i", (-0.9, -0.9, -0.12), (0.9, 0.9, 0.0))
_ON_PLATE = BoxShape("j", (-0.45, -0.35, 0.0), (0.45, 0.35, 0.45))
_SLIDER = BoxShape("j", (-0.5, -0.4, -0.4), (0.5, 0.4, 0.4))
_SLEEVE = CylinderShape("j", (-0.5, 0.0, 0.0), (0.5, 0.0, 0.0), 0.4)
_BALL = Ball("j", ORIGIN, 0.36)
_NUT = BoxShape("j", (-0.4, -0.4, -0.4), (0.4, 0.4, 0.4))
_CUP = (CylinderShape("i", (-0.5, 0.0, 0.0), (0.05, 0.0, 0.0), 0.5), Ball("-", ORIGIN, 0.36))
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
_SHIFTS = tuple(JointFreedom("shift", axis, _MIDDLE, 0.75) for axis in (X, Y, Z))

JOINT_PICTURES: dict[str, JointPicture] = {
    "fixed": JointPicture(
        (
            BoxShape("i", (-1.5, -0.35, -0.35), (0.0, 0.35, 0.35)),
            BoxShape("j", (0.0, -0.25, -0.25), (1.4, 0.25, 0.25)),
        ),
        (),
        sign=(BoxShape("i", (-0.3, -0.3, -0.3), (0.3, 0.3, 0.3)),),
    ),
    "revolute": JointPicture(
        (
            BoxShape("i", (-1.6, -0.25, -0.3), (0.3, 0.25, 0.0)),
            BoxShape("j", (-0.3, -0.25, 0.0), (1.6, 0.25, 0.3)),
            CylinderShape("i", (0.0, 0.0, 0.3), (0.0, 0.0, 0.42), 0.12),
        ),
        (JointFreedom("turn", Z, (0.0, 0.0, 0.75), 0.5),),
        ((ORIGIN, Z),),
        sign=(CylinderShape("i", (0.0, 0.0, -0.5), (0.0, 0.0, 0.5), 0.36),),
    ),
    "prismatic": JointPicture(
        (
            BoxShape("i", (-1.7, -0.17, -0.17), (-0.5, 0.17, 0.17)),
            _SLIDER,
            BoxShape("i", (0.5, -0.17, -0.17), (1.7, 0.17, 0.17)),
        ),
        (JointFreedom("shift", X, (0.0, 0.0, 0.75), 0.8),),
        ((ORIGIN, X),),
        sign=(_SLIDER,),
        slides=True,
    ),
    "cylindrical": JointPicture(
        (
            CylinderShape("i", (-1.7, 0.0, 0.0), (-0.5, 0.0, 0.0), 0.15),
            _SLEEVE,
            CylinderShape("i", (0.5, 0.0, 0.0), (1.7, 0.0, 0.0), 0.15),
        ),
        (
            JointFreedom("shift", X, (0.0, 0.0, 0.75), 0.8),
            JointFreedom("turn", X, (1.15, 0.0, 0.0), 0.5),
        ),
        ((ORIGIN, X),),
        sign=(_SLEEVE,),
        slides=True,
    ),
    "spherical": JointPicture(
        (
            BoxShape("i", (-0.35, -0.35, -1.3), (0.35, 0.35, -0.2)),
            _BALL,
            CylinderShape("j", (0.25, 0.0, 0.25), (1.0, 0.0, 1.15), 0.14),
        ),
        _turns(z=0.85),
        sign=(_BALL,),
    ),
    "universal": JointPicture(
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
        sign=(
            CylinderShape("i", (0.0, 0.6, 0.0), (0.0, -0.6, 0.0), 0.24),
            CylinderShape("j", (0.0, 0.0, -0.6), (0.0, 0.0, 0.6), 0.24),
        ),
    ),
    "planar": JointPicture(
        (_PLATE, _ON_PLATE),
        (*_IN_PLATE, JointFreedom("turn", Z, (0.0, 0.0, 0.75), 0.45)),
        ((ORIGIN, Z),),
        sign=(_SMALL_PLATE, _ON_PLATE),
        has_pedestal=False,
    ),
    "rod": JointPicture(
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
        sign=(Ball("i", ORIGIN, 0.3), Ball("j", ORIGIN, 0.3)),
        is_rod=True,
    ),
    "point_on_line": JointPicture(
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
        sign=(_BALL,),
        slides=True,
    ),
    "point_on_plane": JointPicture(
        (
            _PLATE,
            CylinderShape("j", ORIGIN, (0.0, 0.0, 0.5), 0.07),
            BoxShape("j", (-0.35, -0.3, 0.45), (0.35, 0.3, 0.95)),
        ),
        (*_IN_PLATE, *_turns(x=1.9, y=-1.4, z=1.25)),
        ((ORIGIN, Z),),
        sign=(_SMALL_PLATE, _BALL),
        has_pedestal=False,
    ),
    "parallel_axes": JointPicture(
        _APART,
        (*_SHIFTS, JointFreedom("turn", Z, (1.0, 0.0, 1.05), 0.35)),
        (((-1.2, 0.0, 0.0), Z), (_MIDDLE, Z)),
        (),
        has_pedestal=False,
    ),
    "perpendicular_axes": JointPicture(
        _APART,
        (
            *_SHIFTS,
            JointFreedom("turn", Z, (1.0, 0.0, 1.05), 0.35),
            JointFreedom("turn", X, (2.0, 0.0, 0.1), 0.35),
        ),
        (((-1.2, 0.0, 0.0), Z), (_MIDDLE, X)),
        (),
        has_pedestal=False,
    ),
    "screw": JointPicture(
        (
            CylinderShape("i", (-1.7, 0.0, 0.0), (-0.4, 0.0, 0.0), 0.17),
            *(_ridge(-1.5 + 0.2 * k) for k in range(6)),
            _NUT,
            CylinderShape("i", (0.4, 0.0, 0.0), (1.7, 0.0, 0.0), 0.17),
            *(_ridge(0.5 + 0.2 * k) for k in range(6)),
        ),
        (JointFreedom("screw", X, (0.0, 0.0, 0.0), 0.72, 0.45),),
        ((ORIGIN, X),),
        sign=(
            _NUT,
            CylinderShape("j", (-0.62, 0.0, 0.0), (-0.4, 0.0, 0.0), 0.3),
            CylinderShape("j", (0.4, 0.0, 0.0), (0.62, 0.0, 0.0), 0.3),
        ),
        slides=True,
    ),
    "constant_velocity": JointPicture(
        (
            CylinderShape("i", (-1.8, 0.0, 0.0), (-0.5, 0.0, 0.0), 0.15),
            *_CUP,
            CylinderShape("j", (0.3, 0.0, 0.0), (1.8, 0.0, 0.0), 0.15),
        ),
        (
            JointFreedom("turn", Y, (0.0, -0.95, 0.0), 0.35),
            JointFreedom("turn", Z, (0.0, 0.0, 0.95), 0.4),
        ),
        ((ORIGIN, X),),
        sign=_CUP,
    ),
}
"""The picture of each joint, by its name in :data:`kousoku.model.elements.joints.JOINTS`."""
