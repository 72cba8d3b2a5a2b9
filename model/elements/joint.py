"""A kind of joint: its keys in a scene, the constraints in it, and its free coordinates.

A joint has a frame in each of its two bodies: an axis, a direction across it, and a third that is
perpendicular to both. Its parts say which constraint relates which of them.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from kousoku.model.mechanics.constraints import COMBINATION, CONSTRAINTS

if TYPE_CHECKING:
    from collections.abc import Mapping

    from kousoku.model.elements.inputs import ElementInput
    from kousoku.model.lowering.coordinates import CoordinateList
    from kousoku.model.mechanics.frames import BodyFrame
    from kousoku.model.mechanics.measures import PreciseMeasure
    from kousoku.model.mechanics.multibody import Instance
    from kousoku.model.records.spatial import Joint

ANGLE, SECOND_ANGLE = "angle", "second_angle"
DISPLACEMENT, SECOND_DISPLACEMENT = "displacement", "second_displacement"
"""Relative coordinates that a joint can leave free, each one number."""

ANGLES, DISPLACEMENTS = (ANGLE, SECOND_ANGLE), (DISPLACEMENT, SECOND_DISPLACEMENT)
"""The angles [rad] among them, and the displacements [m]."""


@dataclass(frozen=True, slots=True)
class JointPart:
    """One constraint of a joint: its kind, and the vectors of the joint frames that it relates.

    Parameters
    ----------
    kind : str
        One of :data:`~kousoku.model.mechanics.constraints.CONSTRAINTS`.
    i, j : {"axis", "across", "third"}
        Which vectors of the joint frames are a_i and a_j, where the kind has them.
    """

    kind: str
    i: str = "axis"
    j: str = "axis"


@dataclass(frozen=True, slots=True)
class JointKind:
    """One line of the table of joints.

    Parameters
    ----------
    title : str
        What the joint allows, in one line.
    parts : tuple of JointPart
        What it is composed of, in the order of its rows.
    axes : int
        Axes that a scene gives: none, 1 that is the same in both bodies, or 2.
    has_point : bool
        Whether a scene gives a point.
    aliases : tuple of str
        Other names that are accepted.
    free_coordinates : tuple of str
        What it leaves free that is one number: its ``angle``, the ``second_angle`` of a universal
        joint, its ``displacement``, the ``second_displacement`` of a planar joint.
    keys : tuple of str
        Numbers of :class:`~kousoku.model.records.spatial.Joint` that a scene gives and that no
        other joint has.
    inputs : mapping of str to ElementInput
        Keys that it alone has; a scene has their values in ``joint.inputs``.
    """

    title: str
    parts: tuple[JointPart, ...]
    axes: int
    has_point: bool = True
    aliases: tuple[str, ...] = ()
    free_coordinates: tuple[str, ...] = ()
    keys: tuple[str, ...] = ()
    inputs: Mapping[str, ElementInput] = field(default_factory=dict)

    @property
    def all_keys(self) -> tuple[str, ...]:
        """Its keys in a scene, beside its type."""
        points = self.point_keys if self.has_point else ()
        axes = ("axes", "axis", "second_axis")[: 1 + self.axes] if self.axes else ()
        zero = ("zero",) * self.has_zero
        return ("bodies", *points, *axes, *zero, *self.own_keys)

    @property
    def point_keys(self) -> tuple[str, ...]:
        """Keys of its point, of a joint that has one."""
        return "points", "at"

    @property
    def own_keys(self) -> tuple[str, ...]:
        """Keys of its numbers."""
        return (*self.keys, *self.inputs)

    def check_numbers(self, joint: Joint, key: str) -> None:
        """Refuse missing numbers, and numbers that it cannot have.

        Raises
        ------
        SceneError
            With the dotted key of what is wrong.
        """

    def combination(self, name: str, joint: Joint, coordinates: CoordinateList) -> Instance:
        """Row C = Σ c u + c₀ = 0 (1,) [m, rad or -] of a joint that combines coordinates u.

        Raises
        ------
        SceneError
            The joint is singular as it is written.
        """
        raise NotImplementedError(f"no row of coordinates of {joint.type}")

    def measure(self, joint: Joint, sort: str, ends: tuple[BodyFrame, BodyFrame]) -> PreciseMeasure:
        """Measure that it leaves free: an angle [rad] or a displacement [m].

        The angle atan2(b_i·a_j, a_i·a_j) is that of the zero direction of body j, counted from the
        zero direction of body i counter-clockwise about the axis of body i. The displacement a_i·d,
        lecture 8.2, (8.12), is that of the point of j, from the point of i along the axis of i; in
        a plane it is along the zero direction of i, and the second one along axis × zero direction.
        The vectors (3,) are fixed in the body frames.
        """
        from kousoku.model.mechanics.frames import joint_points, joint_vectors
        from kousoku.model.mechanics.measures import PreciseMeasure

        i, j = joint_vectors(ends, joint)
        if sort == ANGLE:
            vectors = (("a_i_b", i["across"]), ("b_i_b", i["third"]), ("a_j_b", j["across"]))
            return PreciseMeasure("angle", ends, vectors)
        along = i["axis"]
        if self.counts_along_zero:
            along = i["across"] if sort == DISPLACEMENT else i["third"]
        return PreciseMeasure("n2", ends, (("a_i_b", along),), joint_points(joint, ends))

    @property
    def rows(self) -> int:
        """Count of equations, the freedoms that the joint takes away."""
        return sum(CONSTRAINTS[part.kind].rows for part in self.parts)

    def needs_orientation(self, body: int) -> bool:
        """Whether it needs the orientation of body i (0) or j (1), which a point lacks."""
        return any(CONSTRAINTS[part.kind].needs_orientation(body) for part in self.parts)

    @property
    def keeps_zero(self) -> bool:
        """Whether the zero directions across its axis stay parallel, or stay so but for a bend."""
        return self.has_zero and ANGLE not in self.free_coordinates

    @property
    def counts_along_zero(self) -> bool:
        """Whether its displacements are across its axis: along the zero direction and beside it."""
        return SECOND_DISPLACEMENT in self.free_coordinates

    @property
    def has_zero(self) -> bool:
        """Whether zero directions across its axis matter: it has an angle, or keeps one fixed."""
        across = any("across" in (part.i, part.j) for part in self.parts)
        return (
            across or ANGLE in self.free_coordinates or (self.axes == 2 and COMBINED in self.parts)
        )


POINT, PARALLEL, ON_LINE, ON_PLANE = (
    JointPart("point"),
    JointPart("p1"),
    JointPart("p2"),
    JointPart("n2"),
)
COMBINED = JointPart(COMBINATION)
NO_TURN = JointPart("n1", "across", "third")
