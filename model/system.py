"""Turn a spatial scene into a system: principal frames, SI units, instances of kinds.

What a number of the scene becomes is computed in 50 digits and rounded once.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING

from kousoku.model import precise
from kousoku.model.errors import SceneError
from kousoku.model.joints import JOINTS, NAMES
from kousoku.model.mass import mass_properties
from kousoku.model.mechanism import GROUND_INDEX, Instance, MovingBody, System
from kousoku.model.precise import IDENTITY, ZERO, High, Quadruple, Triple
from kousoku.model.quaternions import quaternion
from kousoku.model.rows import variant
from kousoku.model.spatial import GROUND

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from kousoku.model.joints import Part
    from kousoku.model.mass import MassProperties
    from kousoku.model.mechanism import Vector
    from kousoku.model.scene import Scene
    from kousoku.model.spatial import Body, Joint

METRES = {
    "m": Fraction(1),
    "dm": Fraction(1, 10),
    "cm": Fraction(1, 100),
    "mm": Fraction(1, 1000),
    "um": Fraction(1, 10**6),
    "km": Fraction(1000),
    "in": Fraction(254, 10**4),
    "ft": Fraction(3048, 10**4),
}
"""Length of each unit of a scene."""


def system_of(scene: Scene) -> System:
    """Return the system of a spatial scene, at the positions and velocities that the scene gives.

    Raises
    ------
    SceneError
        The scene is planar, prescribes a motion, or gives no distance to a rod.
    """
    if not scene.is_spatial:
        raise SceneError("is missing; wanted a scene of bodies and joints", key="bodies")
    for name in scene.inputs:
        raise SceneError(
            "prescribes a motion, which dynamics does not honour yet; leave the input out",
            key=f"inputs.{name}",
        )
    unit = precise.number(METRES[scene.unit])
    frames = {GROUND: _Frame(GROUND_INDEX, ZERO, IDENTITY, ZERO, IDENTITY, is_point=False)}
    bodies = []
    for index, (name, body) in enumerate(scene.bodies.items()):
        properties = mass_properties(body)
        frame = frames[name] = _Frame(
            index,
            precise.triple(body.position),
            quaternion(body.orientation),
            properties.center,
            properties.axes,
            body.point,
        )
        bodies.append(_moving(name, body, frame, properties, unit))
    constraints = (
        instance
        for name, joint in scene.joints.items()
        for instance in _instances(name, joint, frames, unit)
    )
    return System(
        name=scene.name,
        unit=float(unit),
        bodies=tuple(bodies),
        constraints=tuple(constraints),
        gravity=_vector(precise.scale(unit, precise.triple(scene.gravity))),
    )


@dataclass(frozen=True, slots=True)
class _Frame:
    """A body frame as the scene gives it, and the principal frame in it.

    Parameters
    ----------
    index : int
        The body.
    position : (3,) [unit of the scene]
        Origin of the body frame, frame O.
    p : (4,)
        Euler parameters of the body frame, of any length.
    center : (3,) [unit of the scene]
        Centre of mass in the body frame.
    axes : (4,)
        Euler parameters that take components in the body frame to the principal frame.
    is_point : bool
        Whether the body is a point, which has no point but its own.
    """

    index: int
    position: Triple
    p: Quadruple
    center: Triple
    axes: Quadruple
    is_point: bool

    def principal(self, a: Triple) -> Triple:
        """Return the components in the principal frame of a vector of the body frame."""
        return precise.rotate(self.axes, a)

    def from_ground(self, a: Triple) -> Triple:
        """Return the components in the principal frame of a vector of frame O."""
        return self.principal(precise.rotate_back(self.p, a))

    def to_ground(self, a: Triple) -> Triple:
        """Return the components in frame O of a vector of the principal frame."""
        return precise.rotate(self.p, precise.rotate_back(self.axes, a))

    def point(self, s: Triple, unit: High) -> Vector:
        """Return a point of the body frame, seen from the centre of mass in the principal frame."""
        size = precise.length(s) + precise.length(self.center)
        arm = self.principal(precise.subtract(s, self.center))
        return _vector(precise.scale(unit, arm), unit * size)


def _moving(
    name: str, body: Body, frame: _Frame, properties: MassProperties, unit: High
) -> MovingBody:
    arm = precise.rotate(frame.p, frame.center)
    if body.angular_velocity_b is not None:
        spin = precise.triple(body.angular_velocity_b)
        omega = precise.rotate(frame.p, spin)
    else:
        omega = precise.triple(body.angular_velocity or (0.0, 0.0, 0.0))
        spin = precise.rotate_back(frame.p, omega)
    velocity = precise.add(precise.triple(body.velocity), precise.cross(omega, arm))
    moments = _vector(precise.scale(unit * unit, properties.moments))
    return MovingBody(
        name=name,
        mass=float(properties.mass),
        inertia=(max(0.0, moments[0]), max(0.0, moments[1]), max(0.0, moments[2])),
        is_point=body.point,
        r=_vector(precise.scale(unit, precise.add(frame.position, arm))),
        p=_quaternion(precise.compose(frame.p, precise.conjugate(frame.axes))),
        v=_vector(precise.scale(unit, velocity)),
        omega_b=_vector(frame.principal(spin)),
        origin_b=frame.point(ZERO, unit),
        axes_b=_quaternion(frame.axes),
    )


def _instances(
    name: str, joint: Joint, frames: Mapping[str, _Frame], unit: High
) -> Iterator[Instance]:
    """Yield what a joint is composed of, in the order of the table of joints."""
    kind = JOINTS[NAMES[joint.type]]
    ends = frames[joint.bodies[0]], frames[joint.bodies[1]]
    points = _points(joint, ends) if kind.has_point else ()
    vectors = _vectors(joint, ends) if any(kind.turns(k) for k in (0, 1)) else ({}, {})
    for part in kind.parts:
        constants = dict(_constants(part, ends, points, vectors, unit))
        package = part.kind
        if package in ("p1", "p2"):
            package = variant(package, constants["a_i_b"])
        if package == "distance":
            constants["length"] = (_length(name, joint, ends, points, unit),)
        yield Instance(name, package, ends[0].index, ends[1].index, tuple(constants.items()))


def _constants(
    part: Part,
    ends: tuple[_Frame, _Frame],
    points: Sequence[Triple],
    vectors: tuple[dict[str, Triple], dict[str, Triple]],
    unit: High,
) -> Iterator[tuple[str, tuple[float, ...]]]:
    """Yield the inputs of a kernel that are fixed, in the order of its arguments."""
    for k, body in enumerate("ij"):
        if part.kind in ("n1", "p1") or (k == 0 and part.kind in ("n2", "p2")):
            vector = vectors[k][part.j if k else part.i]
            yield f"a_{body}_b", precise.rounded(vector)
        if part.kind not in ("n1", "p1"):
            yield f"s_{body}_b", ends[k].point(points[k], unit)


def _points(joint: Joint, ends: tuple[_Frame, _Frame]) -> tuple[Triple, ...]:
    """Return the point of a joint in the two body frames; of a point body it is the body itself."""
    if joint.points is not None:
        return tuple(map(precise.triple, joint.points))
    assert joint.at is not None
    at = precise.triple(joint.at)
    return tuple(
        ZERO if end.is_point else precise.rotate_back(end.p, precise.subtract(at, end.position))
        for end in ends
    )


def _vectors(
    joint: Joint, ends: tuple[_Frame, _Frame]
) -> tuple[dict[str, Triple], dict[str, Triple]]:
    """Return axis, across and third of the two joint frames, each in its principal frame.

    The frame of body j is that of body i at the positions of the scene, turned as little as makes
    its axis the one that is given: this is the turn that prismatic and fixed joints keep.
    """
    first, second = ends
    if joint.axes is not None:
        axis_i, axis_j = (
            end.principal(precise.triple(axis)) for end, axis in zip(ends, joint.axes, strict=True)
        )
    elif joint.axis is not None:
        axis_i = first.from_ground(precise.triple(joint.axis))
        axis_j = second.from_ground(precise.triple(joint.second_axis or joint.axis))
    else:
        axis_i = precise.triple((0.0, 0.0, 1.0))
        axis_j = second.from_ground(first.to_ground(axis_i))
    axis_i, axis_j = precise.unit(axis_i), precise.unit(axis_j)
    across_i = precise.across(axis_i)
    seen = precise.without(second.from_ground(first.to_ground(across_i)), axis_j)
    across_j = (
        precise.across(axis_j) if precise.length(seen) < precise.NOISE else precise.unit(seen)
    )
    return _frame_of(axis_i, across_i), _frame_of(axis_j, across_j)


def _frame_of(axis: Triple, across: Triple) -> dict[str, Triple]:
    return {"axis": axis, "across": across, "third": precise.cross(axis, across)}


def _length(
    name: str, joint: Joint, ends: tuple[_Frame, _Frame], points: Sequence[Triple], unit: High
) -> float:
    """Return the length of a rod, the distance of its points where the scene gives none."""
    if joint.length is not None:
        return float(unit * precise.number(joint.length))
    start, end = (
        precise.add(frame.position, precise.rotate(frame.p, point))
        for frame, point in zip(ends, points, strict=True)
    )
    length = precise.length(precise.subtract(end, start))
    if not length:
        raise SceneError("is missing, and its two points coincide", key=f"joints.{name}.length")
    return float(unit * length)


def _vector(values: Triple, size: High = 0) -> Vector:
    x, y, z = precise.rounded(values, size)
    return x, y, z


def _quaternion(p: Quadruple) -> tuple[float, float, float, float]:
    size = precise.length(p)
    w, x, y, z = precise.rounded([component / size for component in p])
    return w, x, y, z
