"""Keys of the records of a scene, typed: what the calls of the builder take.

Written by ``python -m kousoku.model.reading.typed_keys`` from the records themselves.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal, Required, TypedDict

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    Value = float | str
    Numbers = Sequence[float] | NDArray[Any]
    Values = Sequence[Value] | NDArray[Any]
    Rows = Sequence[Numbers] | NDArray[Any]
    Points = Sequence[Values] | NDArray[Any]


class OrientationKeys(TypedDict, total=False):
    """Keys of :class:`kousoku.model.records.orientation.Orientation`."""

    quaternion: Numbers | None
    order: Literal["wxyz", "xyzw"] | None
    rotation_vector: Values | None
    axis: Numbers | None
    angle: Value | None
    angles: Values | None
    sequence: (
        Literal["xyz", "xzy", "yxz", "yzx", "zxy", "zyx", "xyx", "xzx", "yxy", "yzy", "zxz", "zyz"]
        | None
    )
    about: Literal["body", "fixed"] | None
    matrix: Rows | None


class InertiaKeys(TypedDict, total=False):
    """Keys of :class:`kousoku.model.records.solids.Inertia`."""

    xx: Required[Value]
    yy: Required[Value]
    zz: Required[Value]
    xy: Value
    yz: Value
    zx: Value
    about: Values | None


class MassPointKeys(TypedDict, total=False):
    """Keys of :class:`kousoku.model.records.solids.MassPoint`."""

    mass: Required[Value]
    at: Required[Values]


class BoxKeys(TypedDict, total=False):
    """Keys of :class:`kousoku.model.records.solids.Box`."""

    mass: Required[Value]
    size: Required[Values]
    at: Values
    orientation: OrientationKeys | None


class RodKeys(TypedDict, total=False):
    """Keys of :class:`kousoku.model.records.solids.Rod`."""

    mass: Required[Value]
    ends: Required[Points]


class CylinderKeys(TypedDict, total=False):
    """Keys of :class:`kousoku.model.records.solids.Cylinder`."""

    mass: Required[Value]
    radius: Required[Value]
    ends: Required[Points]


class SphereKeys(TypedDict, total=False):
    """Keys of :class:`kousoku.model.records.solids.Sphere`."""

    mass: Required[Value]
    radius: Required[Value]
    at: Values


class BodyKeys(TypedDict, total=False):
    """Keys of :class:`kousoku.model.records.spatial.Body`."""

    position: Required[Numbers]
    orientation: OrientationKeys | None
    velocity: Numbers
    angular_velocity: Values | None
    angular_velocity_b: Values | None
    hold: Sequence[Literal["x", "y", "z", "orientation", "velocity", "angular_velocity"]]
    point: bool
    mass: Value | None
    center: Values | None
    inertia: InertiaKeys | None
    mass_points: Sequence[MassPointKeys]
    boxes: Sequence[BoxKeys]
    rods: Sequence[RodKeys]
    cylinders: Sequence[CylinderKeys]
    spheres: Sequence[SphereKeys]


class JointKeys(TypedDict, total=False):
    """Keys of :class:`kousoku.model.records.spatial.Joint`."""

    type: Required[str]
    bodies: Sequence[str] | None
    points: Points | None
    at: Values | None
    axes: Points | None
    axis: Values | None
    second_axis: Values | None
    zero: Points | None
    length: Value | None
    pitch: Value | None
    joints: Sequence[str] | None
    ratio: Value | None
    radius: Value | None
    coordinates: Sequence[str] | None
    factors: Values | None


class CoordinateKeys(TypedDict, total=False):
    """Keys of :class:`kousoku.model.records.spatial.Coordinate`."""

    joint: str | None
    of: Literal["angle", "second_angle", "displacement", "second_displacement"] | None
    bodies: Sequence[str] | None
    points: Points | None
    body: str | None
    point: Values | None
    along: Values | None
    near: Value | None
    hold: bool


class DriverKeys(TypedDict, total=False):
    """Keys of :class:`kousoku.model.records.spatial.Driver`."""

    coordinate: str | None
    joint: str | None
    of: Literal["angle", "second_angle", "displacement", "second_displacement"] | None
    value: Value | None
    body: str | None
    point: Values | None
    path: Values | None


class ForceKeys(TypedDict, total=False):
    """Keys of :class:`kousoku.model.records.loads.Force`."""

    type: Required[str]
    body: str | None
    point: Values | None
    force: Value | Values | None
    force_b: Values | None
    torque: Values | None
    torque_b: Values | None
    bodies: Sequence[str] | None
    points: Points | None
    at: Values | None
    axes: Points | None
    joint: str | None
    coordinate: str | None
    of: Literal["angle", "second_angle", "displacement", "second_displacement"] | None
    stiffness: Value | Values | None
    damping: Value | Values | None
    tension: str | None
    moment: str | None
    free_length: Value | None
    free_angle: Value | None


class EventKeys(TypedDict, total=False):
    """Keys of :class:`kousoku.model.records.spatial.Event`."""

    when: Required[str]
    direction: Literal["both", "rising", "falling"]
    action: Literal["record", "count", "stop"]


class MethodKeys(TypedDict, total=False):
    """Keys of :class:`kousoku.model.records.planar.Method`."""

    scheme: Literal["newton", "paper"]
    residual: float | None
    iterations: int
