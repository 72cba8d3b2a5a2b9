"""The bodies and joints of a spatial mechanism as a scene describes them."""

# Annotations are evaluated: msgspec reads the types of a scene file from them.
from typing import Literal

import msgspec

from kousoku.model.orientation import Orientation
from kousoku.model.solids import Box, Cylinder, Inertia, MassPoint, Rod, Sphere

Vector = tuple[float, float, float]
Held = Literal["x", "y", "z", "orientation", "velocity", "angular_velocity"]

GROUND = "ground"
"""The name of the fixed body, whose frame is frame O; every scene has it."""


class Body(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A rigid body, or a point; its mass may be left out where only kinematics is asked.

    What the body is made of is summed: `mass` with `center` and `inertia`, `mass_points`, `boxes`,
    `rods`, `cylinders` and `spheres`.

    Parameters
    ----------
    position : (3,) [unit of the scene]
        Origin of the body frame in frame O, near the first position of the mechanism.
    orientation : Orientation, optional
        Orientation of the body frame in frame O, near the first position; that of frame O when left
        out.
    velocity : (3,) [unit of the scene per s]
        Velocity of the origin of the body frame at the start, in frame O.
    angular_velocity : (3,) [rad/s], optional
        Angular velocity at the start, in frame O.
    angular_velocity_b : (3,) [rad/s], optional
        The same in the body frame, instead.
    hold : tuple of str
        What assembly may not change: ``x``, ``y``, ``z`` of the origin of the body frame,
        ``orientation``, ``velocity``, ``angular_velocity``.
    point : bool
        Whether the body is a point: three coordinates, no orientation, and all of its mass there.
    mass : float [kg], optional
        Mass, with `center` and `inertia`.
    center : (3,) [unit of the scene], optional
        Centre of this mass in the body frame; its origin when left out.
    inertia : Inertia, optional
        Inertia tensor of this mass.
    mass_points : tuple of MassPoint
        Point masses.
    boxes : tuple of Box
        Uniform boxes.
    rods : tuple of Rod
        Uniform rods without thickness.
    cylinders : tuple of Cylinder
        Uniform solid cylinders.
    spheres : tuple of Sphere
        Uniform solid spheres.
    """

    position: Vector
    orientation: Orientation | None = None
    velocity: Vector = (0.0, 0.0, 0.0)
    angular_velocity: Vector | None = None
    angular_velocity_b: Vector | None = None
    hold: tuple[Held, ...] = ()
    point: bool = False
    mass: float | None = None
    center: Vector | None = None
    inertia: Inertia | None = None
    mass_points: tuple[MassPoint, ...] = ()
    boxes: tuple[Box, ...] = ()
    rods: tuple[Rod, ...] = ()
    cylinders: tuple[Cylinder, ...] = ()
    spheres: tuple[Sphere, ...] = ()


SOLIDS = ("mass_points", "boxes", "rods", "cylinders", "spheres")
"""The keys of a body that list what it is made of."""


class Joint(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A joint between two bodies.

    Its point is given as `points` or as `at`, its axis as `axes` or as `axis`. What is given once,
    in frame O, belongs to the position and orientation of the bodies as they are written.

    Parameters
    ----------
    type : str
        What the joint allows: a name or an alias of :data:`kousoku.model.joints.JOINTS`.
    bodies : (str, str)
        Body i and body j; ``ground`` is the fixed body.
    points : ((3,), (3,)) [unit of the scene], optional
        The point of the joint in the frame of body i and in that of body j.
    at : (3,) [unit of the scene], optional
        The point of the joint in frame O, the same of both bodies.
    axes : ((3,), (3,)), optional
        The axis of the joint in the frame of body i and in that of body j, of any length but
        zero. Of a universal joint the two arms of the cross, which stay perpendicular.
    axis : (3,), optional
        The axis of the joint in frame O, the same of both bodies; of a joint with two axes the one
        that is fixed in body i.
    second_axis : (3,), optional
        With `axis`, the one that is fixed in body j, of a joint with two axes.
    length : float [unit of the scene], optional
        Distance of the two points of a rod; that of their positions when left out.
    """

    type: str
    bodies: tuple[str, str]
    points: tuple[Vector, Vector] | None = None
    at: Vector | None = None
    axes: tuple[Vector, Vector] | None = None
    axis: Vector | None = None
    second_axis: Vector | None = None
    length: float | None = None
