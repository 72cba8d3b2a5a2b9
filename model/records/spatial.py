"""Bodies, joints, coordinates and drivers of a spatial mechanism as a scene describes them."""

# Annotations are evaluated: msgspec reads the types of a scene file from them.
from collections.abc import Mapping
from typing import Any, ClassVar, Literal

import msgspec

from kousoku.model.records.design import Design, DesignVector, NumberOrAngle, Turns
from kousoku.model.records.orientation import Orientation, Vector
from kousoku.model.records.solids import Box, Cylinder, Inertia, MassPoint, Rod, Sphere

Free = Literal["angle", "second_angle", "displacement", "second_displacement"]
Held = Literal["x", "y", "z", "orientation", "velocity", "angular_velocity"]
Direction = Literal["both", "rising", "falling"]
Action = Literal["record", "count", "stop"]

Value = float | str
"""A number, or the text of a formula."""

Components = tuple[Value, Value, Value]
"""A vector whose components may be formulas."""

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
    angular_velocity: Turns | None = None
    angular_velocity_b: Turns | None = None
    hold: tuple[Held, ...] = ()
    point: bool = False
    mass: Design | None = None
    center: DesignVector | None = None
    inertia: Inertia | None = None
    mass_points: tuple[MassPoint, ...] = ()
    boxes: tuple[Box, ...] = ()
    rods: tuple[Rod, ...] = ()
    cylinders: tuple[Cylinder, ...] = ()
    spheres: tuple[Sphere, ...] = ()


SOLIDS = ("mass_points", "boxes", "rods", "cylinders", "spheres")
"""Keys of a body that list its solids and mass points."""


class Joint(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A joint between two bodies, or a coupling of what other joints leave free.

    Its point is given as `points` or as `at`, its axis as `axes` or as `axis`. What is given once,
    in frame O, belongs to the position and orientation of the bodies as they are written.

    Parameters
    ----------
    type : str
        What the joint allows: one of the joints, or another name of it.
    bodies : (str, str), optional
        Body i and body j; ``ground`` is the fixed body. Every joint but a coupling has them.
    points : ((3,), (3,)) [unit of the scene], optional
        The point of the joint in the frame of body i and in that of body j.
    at : (3,) [unit of the scene], optional
        The point of the joint in frame O, the same of both bodies.
    axes : ((3,), (3,)), optional
        The axis of the joint in the frame of body i and in that of body j, of any length but
        zero. Of a universal joint the two arms of the cross, which stay perpendicular; of a
        constant velocity joint the two shafts, both pointing the same way through the joint.
    axis : (3,), optional
        The axis of the joint in frame O, the same of both bodies; of a joint with two axes the one
        that is fixed in body i.
    second_axis : (3,), optional
        With `axis`, the one that is fixed in body j, of a joint with two axes.
    zero : ((3,), (3,)), optional
        A direction across the axis in the frame of body i and one in that of body j: where they
        are parallel the angle of the joint is zero, and a joint without an angle keeps them
        parallel. When left out, parallel directions at the orientations as they are written.
    length : float [unit of the scene], optional
        Distance of the two points of a rod; that of their positions when left out.
    pitch : float [unit of the scene], optional
        Advance of a screw in one turn; negative for a left-handed thread.
    joints : (str, str), optional
        Of a gear the two joints whose angles it couples; of a rack and pinion the joint of the
        pinion, which has an angle, and that of the rack, which has a displacement.
    ratio : float, optional
        Of a gear, turns of the second joint by a turn of the first.
    radius : float [unit of the scene], optional
        Of a rack and pinion, displacement of the rack by the angle of the pinion.
    coordinates : tuple of str, optional
        Of a linear coupling, names of coordinates of the scene.
    factors : tuple of float, optional
        Of a linear coupling, what each is multiplied by; the sum stays what it is.
    inputs : mapping of str to object, optional
        What its type alone has, as a kind of one's own its inputs, by name; in a file they are keys
        of the joint.
    """

    FLAT: ClassVar = "inputs"

    type: str
    bodies: tuple[str, str] | None = None
    points: tuple[DesignVector, DesignVector] | None = None
    at: DesignVector | None = None
    axes: tuple[DesignVector, DesignVector] | None = None
    axis: DesignVector | None = None
    second_axis: DesignVector | None = None
    zero: tuple[DesignVector, DesignVector] | None = None
    length: Design | None = None
    pitch: Design | None = None
    joints: tuple[str, str] | None = None
    ratio: Design | None = None
    radius: Design | None = None
    coordinates: tuple[str, ...] | None = None
    factors: tuple[Design, ...] | None = None
    inputs: Mapping[str, Any] | None = None

    @property
    def ends(self) -> tuple[str, str]:
        """The two bodies, of a joint that is no coupling."""
        assert self.bodies is not None
        return self.bodies

    def input(self, name: str) -> Any:
        """Value of a key that its type alone has, None where it is left out."""
        return (self.inputs or {}).get(name)

    def vector(self, name: str) -> tuple[float, float, float]:
        """Input (3,) of a kind of one's own that is a vector, in the unit of its key."""
        value = self.input(name)
        assert isinstance(value, tuple)
        return value


class Coordinate(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A number that says where bodies are, and that has a name.

    It is what a joint leaves free, or the distance of two points, or the place of a point along a
    direction.

    Parameters
    ----------
    joint : str, optional
        The joint whose angle or displacement it is.
    of : {"angle", "second_angle", "displacement", "second_displacement"}, optional
        Which of them, where the joint leaves more than one free.
    bodies : (str, str), optional
        The two bodies between whose points it is the distance.
    points : ((3,), (3,)) [unit of the scene], optional
        With `bodies`, the point in the frame of each.
    body : str, optional
        The body of whose point it is the place.
    point : (3,) [unit of the scene], optional
        With `body`, the point in its frame; its origin when left out.
    along : (3,), optional
        With `body`, the direction in frame O, of any length but zero.
    near : float [rad or unit of the scene], optional
        Of an angle, a value within half a turn of the one at the start: it says which turn this is.
        With `hold`, the value that is held.
    hold : bool
        Whether assembly keeps it: exactly as it is written, or at `near`.
    """

    joint: str | None = None
    of: Free | None = None
    bodies: tuple[str, str] | None = None
    points: tuple[DesignVector, DesignVector] | None = None
    body: str | None = None
    point: DesignVector | None = None
    along: DesignVector | None = None
    near: NumberOrAngle | None = None
    hold: bool = False


class Driver(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A coordinate or a point as a function of time.

    Formulas depend on the time ``t`` and on the parameters of the scene. Their first and second
    derivatives are taken exactly.

    Parameters
    ----------
    coordinate : str, optional
        The coordinate that is driven.
    joint : str, optional
        The joint whose angle or displacement is driven, instead.
    of : {"angle", "second_angle", "displacement", "second_displacement"}, optional
        Which of them, where the joint leaves more than one free.
    value : float or str, optional
        Its value as a formula, in rad or the unit of the scene.
    body : str, optional
        The body whose point is driven, instead.
    point : (3,) [unit of the scene], optional
        With `body`, the point in its frame; its origin when left out.
    path : (3,) float or str, optional
        With `body`, the position of the point in frame O, three formulas in the unit of the scene.
    inputs : mapping of str to object, optional
        What its sort alone has, by name; in a file they are keys of the driver.
    """

    FLAT: ClassVar = "inputs"

    coordinate: str | None = None
    joint: str | None = None
    of: Free | None = None
    value: Value | None = None
    body: str | None = None
    point: DesignVector | None = None
    path: Components | None = None
    inputs: Mapping[str, Any] | None = None

    def input(self, name: str) -> Any:
        """Value of a key that its sort alone has, None where it is left out."""
        return (self.inputs or {}).get(name)


class Event(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A formula of the motion that passes zero, and what a run does then.

    The formula depends on the time ``t``, on the parameters and coordinates of the scene, and on
    rates of coordinates with ``_dot`` behind the name: unit of the scene, rad, seconds.

    Parameters
    ----------
    when : str
        The formula; the event is where it passes zero.
    direction : {"both", "rising", "falling"}
        Which way it passes zero.
    action : {"record", "count", "stop"}
        Whether the state there is recorded, or only how often that happens, or the run ends there.
    """

    EXAMPLE: ClassVar = '{ when = "x - 1", direction = "rising", action = "stop" }'

    when: str
    direction: Direction = "both"
    action: Action = "record"
