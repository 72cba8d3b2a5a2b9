"""The elements of a spatial mechanism as a scene describes them: bodies and joints."""

# Annotations are evaluated: msgspec reads the types of a scene file from them.
from typing import Literal

import msgspec

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]

GROUND = "ground"
"""The name of the fixed body, whose frame is frame O; every scene has it."""

JointType = Literal["revolute", "prismatic", "cylindrical", "spherical", "universal", "fixed"]

JOINTS_WITH_AXES = ("revolute", "prismatic", "cylindrical", "universal")
"""Joints that need an axis in both bodies."""


class Orientation(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Orientation of a body frame relative to frame O.

    Parameters
    ----------
    quaternion : (4,)
        Euler parameters of A, which takes components in the body to components in frame O;
        normalised when the scene is assembled.
    order : {"wxyz", "xyzw"}
        Where the scalar part stands: first (w x y z) or last (x y z w).
    """

    quaternion: Quaternion
    order: Literal["wxyz", "xyzw"]


class Inertia(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Inertia tensor about the centre of mass, in the axes of the body frame.

    Parameters
    ----------
    xx, yy, zz : float [kg unit²]
        Moments of inertia.
    xy, yz, zx : float [kg unit²]
        Elements of the tensor off the diagonal: xy = −∫ x y dm.
    """

    xx: float
    yy: float
    zz: float
    xy: float = 0.0
    yz: float = 0.0
    zx: float = 0.0


class MassPoint(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A point mass that is fixed in a body.

    Parameters
    ----------
    mass : float [kg]
        Its mass.
    at : (3,) [unit of the scene]
        Its position in the body frame.
    """

    mass: float
    at: Vector


class Body(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A rigid body; its mass properties may be left out where only kinematics is asked.

    Parameters
    ----------
    position : (3,) [unit of the scene]
        Origin of the body frame in frame O, near the first position of the mechanism.
    orientation : Orientation, optional
        Orientation of the body frame, near the first position; that of frame O when left out.
    mass : float [kg], optional
        Mass, with `center` and `inertia`.
    center : (3,) [unit of the scene], optional
        Centre of mass in the body frame; its origin when left out.
    inertia : Inertia, optional
        Inertia tensor about the centre of mass.
    mass_points : tuple of MassPoint
        Instead of `mass`, `center` and `inertia`: the points that the mass is made of.
    """

    position: Vector
    orientation: Orientation | None = None
    mass: float | None = None
    center: Vector | None = None
    inertia: Inertia | None = None
    mass_points: tuple[MassPoint, ...] = ()


class Joint(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A joint between two bodies.

    Parameters
    ----------
    type : str
        What the joint allows, e.g. ``revolute``.
    bodies : (str, str)
        Body i and body j; ``ground`` is the fixed body.
    points : ((3,), (3,)) [unit of the scene]
        The point of the joint in the frame of body i and in that of body j.
    axes : ((3,), (3,)), optional
        The axis of the joint in the frame of body i and in that of body j, of any length but
        zero. For a universal joint the two arms of the cross, which stay perpendicular. Spherical
        and fixed joints have none.
    """

    type: JointType
    bodies: tuple[str, str]
    points: tuple[Vector, Vector]
    axes: tuple[Vector, Vector] | None = None
