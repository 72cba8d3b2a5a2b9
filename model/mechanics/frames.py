"""Body frames and joint frames of a scene in 50 digits, and rounded."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from kousoku.model.mechanics.multibody import GROUND_INDEX
from kousoku.model.numbers import precise
from kousoku.model.numbers.precise import IDENTITY, ZERO, High, Quadruple, Triple
from kousoku.model.numbers.traced import NOISE, Traced
from kousoku.model.numbers.varying import Varying

if TYPE_CHECKING:
    from kousoku.model.records.orientation import Quaternion, Vector
    from kousoku.model.records.spatial import Joint


@dataclass(frozen=True, slots=True)
class BodyFrame:
    """A body frame as the scene gives it, and the principal frame in it.

    Parameters
    ----------
    index : int
        The body.
    position : (3,) [unit of the scene]
        Origin of the body frame, frame O.
    p : (4,) [-]
        Euler parameters of the body frame in frame O, scalar first, of any norm.
    center : (3,) [unit of the scene]
        Centre of mass in the body frame.
    axes : (4,) [-]
        Euler parameters of any norm: components in the body frame to the principal frame.
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
        """Components (3,) in the principal frame, in the unit of a (3,) in the body frame."""
        return precise.rotate(self.axes, a)

    def from_ground(self, a: Triple) -> Triple:
        """Components (3,) in the principal frame, in the unit of a (3,) in frame O."""
        return self.principal(precise.rotate_back(self.p, a))

    def to_ground(self, a: Triple) -> Triple:
        """Components (3,) in frame O, in the unit of a (3,) in the principal frame."""
        return precise.rotate(self.p, precise.rotate_back(self.axes, a))

    def place(self, s: Triple) -> Triple:
        """Place r + A s′ (3,) of a point s′ (3,), body frame, in frame O; lecture 7.1, (4.3).

        r is the position of the body frame; all are lengths [unit of the scene].
        """
        return precise.add(self.position, precise.rotate(self.p, s))

    def point(self, s: Triple, unit: High) -> Vector:
        """Point (3,) [m] from the centre of mass, in the principal frame.

        Parameters
        ----------
        s : (3,) [unit of the scene]
            The point in the body frame.
        unit : number [m]
            The unit of the scene.
        """
        size = precise.length(s) + precise.length(self.center)
        arm = self.principal(precise.subtract(s, self.center))
        return to_vector(precise.scale(unit, arm), unit * size)


OPPOSITE = 1e-6
"""Axes point against each other where 1 + cos of the angle between them is below this."""

GROUND_FRAME = BodyFrame(GROUND_INDEX, ZERO, IDENTITY, ZERO, IDENTITY, is_point=False)
"""Frame O."""

DIRECTIONS = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
"""Its axes by their letters."""


def joint_points(joint: Joint, ends: tuple[BodyFrame, BodyFrame]) -> tuple[Triple, Triple]:
    """Points (3,) [unit of the scene] of a joint, in its two body frames.

    s′ = Aᵀ (at − r), lecture 7.1, (4.3), of a joint at one place of frame O; of a point body it is
    the body itself.
    """
    if joint.points is not None:
        return precise.triple(joint.points[0]), precise.triple(joint.points[1])
    assert joint.at is not None
    at = precise.triple(joint.at)
    first, second = (
        ZERO if end.is_point else precise.rotate_back(end.p, precise.subtract(at, end.position))
        for end in ends
    )
    return first, second


def joint_vectors(
    ends: tuple[BodyFrame, BodyFrame], joint: Joint | None = None
) -> tuple[dict[str, Triple], dict[str, Triple]]:
    """Axis, across and third (3,) [-] of the two joint frames, each in its principal frame.

    Where the joint says by ``zero`` which directions are across the axes, these are taken. Else the
    frame of body j is that of body i at the positions of the scene, turned as little as makes its
    axis that of the joint: this is the turn that prismatic and fixed joints keep. Without a
    joint, or where it gives no axis, the axis is the third principal axis of body i.
    """
    axis_i, axis_j = joint_axes(ends, joint)
    if joint is not None and joint.zero is not None:
        across_i, across_j = (
            precise.unit(precise.without(end.principal(precise.triple(zero)), axis))
            for end, zero, axis in zip(ends, joint.zero, (axis_i, axis_j), strict=True)
        )
    else:
        across_i = precise.across(axis_i)
        across_j = _across(ends, axis_i, across_i, axis_j)
    return _frame_of(axis_i, across_i), _frame_of(axis_j, across_j)


def joint_axes(ends: tuple[BodyFrame, BodyFrame], joint: Joint | None) -> tuple[Triple, Triple]:
    """Axes (3,) [-] of a joint, of norm one, in the principal frames of its two bodies."""
    first, second = ends
    if joint is not None and joint.axes is not None:
        axis_i, axis_j = (
            end.principal(precise.triple(axis)) for end, axis in zip(ends, joint.axes, strict=True)
        )
    elif joint is not None and joint.axis is not None:
        axis_i = first.from_ground(precise.triple(joint.axis))
        axis_j = second.from_ground(precise.triple(joint.second_axis or joint.axis))
    else:
        axis_i = precise.triple((0.0, 0.0, 1.0))
        axis_j = second.from_ground(first.to_ground(axis_i))
    return precise.unit(axis_i), precise.unit(axis_j)


def _across(
    ends: tuple[BodyFrame, BodyFrame], axis_i: Triple, across_i: Triple, axis_j: Triple
) -> Triple:
    """Direction across the axis of j that the one of i is turned into.

    The turn is the one about the normal of both axes that takes the axis of i to that of j. Axes
    that point against each other have no normal but that of their rounding: then it is the half
    turn about the direction itself.
    """
    first, second = ends
    seen, axis = (second.from_ground(first.to_ground(vector)) for vector in (across_i, axis_i))
    along = precise.dot(seen, axis_j)
    cosine = precise.dot(axis, axis_j)
    is_level = not isinstance(along, Traced) and abs(along) <= NOISE
    if is_level or 1 + cosine < OPPOSITE:
        turned = precise.without(seen, axis_j)
    else:
        middle = precise.scale(along / (1 + cosine), precise.add(axis, axis_j))
        turned = precise.without(precise.subtract(seen, middle), axis_j)
    return precise.across(axis_j) if precise.length(turned) < NOISE else precise.unit(turned)


def _frame_of(axis: Triple, across: Triple) -> dict[str, Triple]:
    return {"axis": axis, "across": across, "third": precise.cross(axis, across)}


def to_vector(values: Triple, size: High = 0) -> Vector:
    """Vector (3,) in its unit, rounded to doubles.

    See :func:`kousoku.model.numbers.precise.rounded`; ``size`` is in that unit, too.
    """
    x, y, z = precise.rounded(values, size)
    return x, y, z


def not_negative(moments: Vector) -> Vector:
    """Principal moments (3,), in their unit, in which rounding left none below zero."""
    x, y, z = (x if isinstance(x, Varying) else max(0.0, x) for x in moments)
    return x, y, z


def to_quaternion(p: Quadruple) -> Quaternion:
    """Euler parameters p/|p| (4,) [-] of norm one, rounded to doubles."""
    size = precise.length(p)
    w, x, y, z = precise.rounded([component / size for component in p])
    return w, x, y, z
