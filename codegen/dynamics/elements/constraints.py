"""Facets of kinds of constraints and coordinates, beside the equations of their kernels.

Each kind is defined again, by geometry: between moving bodies for the equations of each body,
between bodies at rest for the gap of a joint, and by the reactions of the ground through it.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING, ClassVar

from kousoku.codegen.dynamics.operations.heights import FLAT, heights_of_ends, is_level
from kousoku.codegen.dynamics.operations.jets import Jet, atan2, cross, dot, sqrt
from kousoku.model.mechanics.constraints import base_of, is_point
from kousoku.model.numbers import precise
from kousoku.model.numbers.digits import CONTEXT

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from kousoku.codegen.dynamics.checking.newton_euler import BodyMotion
    from kousoku.codegen.dynamics.operations.jets import JetVector
    from kousoku.model.mechanics.multibody import RelativeCoordinate, System
    from kousoku.model.numbers.precise import Triple
    from kousoku.model.numbers.real import Real
    from kousoku.model.operations.arithmetic import FormulaArithmetic

    Digits = FormulaArithmetic[Real]
    #: Its inputs by name.
    Inputs = Mapping[str, Sequence[Real]]


@dataclass(frozen=True, slots=True)
class GroundReaction:
    """Force of the ground through one row, or one force: −C_qᵀλ of the row C.

    Parameters
    ----------
    push : (3,), optional
        Its forces are along this direction of frame O, wherever they act.
    through : (3,) [m], optional
        Its forces are of any direction, through this point of the ground.
    line : ((3,), (3,)), optional
        Its forces are across a direction, through a point of the line along it: direction, and a
        point of the line.
    about : (3,), optional
        Its moments are across this direction.
    any_moment : bool
        Whether its moments are of any direction.
    """

    push: Triple | None = None
    through: Triple | None = None
    line: tuple[Triple, Triple] | None = None
    about: Triple | None = None
    any_moment: bool = False


ANYTHING = GroundReaction(through=precise.ZERO, any_moment=True)
"""Any force and any moment."""


@dataclass(frozen=True, slots=True)
class BodiesAtRest:
    """Axes and points of a constraint between two bodies at rest: a = A a′, d of (8.8).

    Parameters
    ----------
    axes : ((3,), (3,)) [-]
        a of body i and of body j in frame O; zero where it has none.
    d : (3,) [m]
        From the point of body i to that of body j, frame O; lecture 8.2, (8.8).
    length : number [m], optional
        Its given length.
    """

    axes: tuple[Triple, Triple]
    d: Triple
    length: Real | None


class RelativeMotion(Enum):
    """A motion of two bodies against each other, by an axis of a joint between them."""

    SLIDE = "a displacement along the axis"
    SHIFT = "a displacement across it"
    SPIN = "a turn about it"
    TILT = "a turn across it"


class ConstraintFacets(ABC):
    """A kind of constraint C = 0 or of coordinate u, by its definition: lecture 8.2, (8.8)–(8.16).

    Axes a = A a′ (3,) [-] and the vector d (3,) [m] between the points are in frame O.

    Attributes
    ----------
    holds : frozenset of RelativeMotion
        Motions that it prevents, whatever the position; none where that depends on the position.
    measures : RelativeMotion, optional
        Motion that changes it, of a coordinate that a joint may have for its own.
    """

    holds: ClassVar[frozenset[RelativeMotion]] = frozenset()
    measures: ClassVar[RelativeMotion | None] = None

    @abstractmethod
    def residuals(
        self, i: BodyMotion, j: BodyMotion, inputs: Inputs, digits: Digits
    ) -> Sequence[Jet]:
        """Residuals (m,), zero where it holds, or the value of the coordinate, of moving bodies.

        Parameters
        ----------
        i, j : BodyMotion
            Courses of the bodies.
        inputs : mapping of str to sequence of number
            Its inputs: axes (3,) and points (3,) [m] in the principal frames, a length [m].
        digits : FormulaArithmetic
            Arithmetic of the numbers.
        """

    def gap(self, bodies: BodiesAtRest) -> tuple[Real, int]:
        """Gap, a scalar, that is left until it holds, and 0 for metres or 1 for radians."""
        raise NotImplementedError(f"{type(self).__name__} is no constraint")

    @abstractmethod
    def ground_reaction(self, axis: Triple | None, point: Triple | None) -> GroundReaction:
        """Reaction of the ground through it, whatever the position.

        Parameters
        ----------
        axis : (3,) [-], optional
            Of the ground, or one of the body that stays parallel to one of the ground, frame O.
        point : (3,) [m], optional
            Of the ground, frame O.
        """

    def leaves_plane(self, system: System, u: RelativeCoordinate, normal: int) -> bool | None:
        """Whether a force along a coordinate of the kind leads out of a coordinate plane.

        A coordinate whose axes are in the plane, and whose points are level with the centres of
        mass, does not; an angle does not either. None where it leads out of it, but motions in the
        plane do not change the coordinate, because it is across the plane.

        Parameters
        ----------
        system : System
            A scene that moves in the plane.
        u : RelativeCoordinate
            The coordinate.
        normal : int
            The axis that the plane is across.
        """
        raise NotImplementedError(f"{type(self).__name__} is no coordinate")

    def direction(self, inputs: Mapping[str, Sequence[float]]) -> Triple | None:
        """Direction (3,) [-] along or about which it grows, in body i; None unless for good."""
        return None


class OfPoints(ConstraintFacets):
    """Kinds of two points and no axis."""

    def ground_reaction(self, axis: Triple | None, point: Triple | None) -> GroundReaction:
        """Forces through the point of the ground."""
        return GroundReaction(through=point)


class PointFacets(OfPoints):
    """Two points coincide: d = 0 (3,) [m], lecture 8.2, (8.8)."""

    holds = frozenset({RelativeMotion.SLIDE, RelativeMotion.SHIFT})

    def residuals(
        self, i: BodyMotion, j: BodyMotion, inputs: Inputs, digits: Digits
    ) -> Sequence[Jet]:
        """Vector d = r_j + A_j s′_j − r_i − A_i s′_i (3,) [m]."""
        return _across(i, j, inputs)

    def gap(self, bodies: BodiesAtRest) -> tuple[Real, int]:
        """Length |d| [m]."""
        return precise.length(bodies.d), 0


class LengthFacets(OfPoints):
    """The distance of two points, |d| (1,) [m]."""

    def residuals(
        self, i: BodyMotion, j: BodyMotion, inputs: Inputs, digits: Digits
    ) -> Sequence[Jet]:
        """Length |d| [m]."""
        d = _across(i, j, inputs)
        return (sqrt(dot(d, d), digits),)

    def leaves_plane(self, system: System, u: RelativeCoordinate, normal: int) -> bool | None:
        """Whether its points are not level."""
        return not _is_level(system, u, normal)


class DistanceFacets(LengthFacets):
    """Two points at a given distance: |d| = l (1,) [m]."""

    def residuals(
        self, i: BodyMotion, j: BodyMotion, inputs: Inputs, digits: Digits
    ) -> Sequence[Jet]:
        """Residual |d| − l [m]."""
        (distance,), (length,) = super().residuals(i, j, inputs, digits), inputs["length"]
        return (distance - Jet(length),)

    def gap(self, bodies: BodiesAtRest) -> tuple[Real, int]:
        """Gap ||d| − l| [m]."""
        return abs(precise.length(bodies.d) - bodies.length), 0


class OfAxes(ConstraintFacets):
    """Kinds of two axes and no point."""

    def ground_reaction(self, axis: Triple | None, point: Triple | None) -> GroundReaction:
        """Moments across the axis of the ground."""
        return GroundReaction(about=axis)


class PerpendicularFacets(OfAxes):
    """n1: two axes are perpendicular, a_i·a_j = 0 (1,) [-], (8.9), or the cosine between them.

    Across an axis that another kind keeps parallel, as in joints, it holds the turn about that.
    """

    holds = frozenset({RelativeMotion.SPIN})

    def residuals(
        self, i: BodyMotion, j: BodyMotion, inputs: Inputs, digits: Digits
    ) -> Sequence[Jet]:
        """Product a_i · a_j (1,) [-]."""
        return (dot(i.vector(inputs["a_i_b"]), j.vector(inputs["a_j_b"])),)

    def gap(self, bodies: BodiesAtRest) -> tuple[Real, int]:
        """Difference of the angle between them from a right one [rad]."""
        sine, cosine = _angle(bodies)
        return CONTEXT.atan2(cosine, sine), 1

    def leaves_plane(self, system: System, u: RelativeCoordinate, normal: int) -> bool | None:
        """Whether its axes are neither both in the plane nor both across it."""
        heights = _heights(u, normal)
        is_across = [height >= 1.0 - FLAT for height in heights]
        if max(heights) <= FLAT or all(is_across):
            return False
        is_fixed = all(x <= FLAT or x >= 1.0 - FLAT for x in heights)
        return None if is_fixed else True


class ParallelFacets(OfAxes):
    """p1: two axes are parallel, ã_i a_j = 0, (8.14); all three rows (3,) [-] of it."""

    holds = frozenset({RelativeMotion.TILT})

    def residuals(
        self, i: BodyMotion, j: BodyMotion, inputs: Inputs, digits: Digits
    ) -> Sequence[Jet]:
        """Product a_i × a_j (3,) [-]."""
        return cross(i.vector(inputs["a_i_b"]), j.vector(inputs["a_j_b"]))

    def gap(self, bodies: BodiesAtRest) -> tuple[Real, int]:
        """Angle between their lines [rad]."""
        return CONTEXT.atan2(*_angle(bodies)), 1


class AngleFacets(ConstraintFacets):
    """The angle from a_i to a_j, counted about a_i × b_i (1,) [rad]; without its turns."""

    measures = RelativeMotion.SPIN

    def residuals(
        self, i: BodyMotion, j: BodyMotion, inputs: Inputs, digits: Digits
    ) -> Sequence[Jet]:
        """Angle atan2(b_i · a_j, a_i · a_j) (1,) [rad]."""
        a_j = j.vector(inputs["a_j_b"])
        sine, cosine = (dot(i.vector(inputs[name]), a_j) for name in ("b_i_b", "a_i_b"))
        return (atan2(sine, cosine, digits),)

    def ground_reaction(self, axis: Triple | None, point: Triple | None) -> GroundReaction:
        """Moments of any direction."""
        return GroundReaction(any_moment=True)

    def leaves_plane(self, system: System, u: RelativeCoordinate, normal: int) -> bool | None:
        """Whether an axis is not in the plane."""
        return max(_heights(u, normal)) > FLAT

    def direction(self, inputs: Mapping[str, Sequence[float]]) -> Triple | None:
        """Axis a′_i × b′_i (3,) [-]."""
        return precise.cross(precise.triple(inputs["a_i_b"]), precise.triple(inputs["b_i_b"]))


class InPlaneFacets(ConstraintFacets):
    """n2: d is perpendicular to an axis of body i, a_i·d = 0 (1,) [m], (8.12), or that product."""

    measures = RelativeMotion.SLIDE

    def residuals(
        self, i: BodyMotion, j: BodyMotion, inputs: Inputs, digits: Digits
    ) -> Sequence[Jet]:
        """Product a_i · d (1,) [m]."""
        return (dot(i.vector(inputs["a_i_b"]), _across(i, j, inputs)),)

    def gap(self, bodies: BodiesAtRest) -> tuple[Real, int]:
        """Gap |a_i · d| [m]."""
        return abs(precise.dot(bodies.axes[0], bodies.d)), 0

    def ground_reaction(self, axis: Triple | None, point: Triple | None) -> GroundReaction:
        """Forces along the axis, wherever they act; where it turns, through the point."""
        if axis is None:
            return GroundReaction(through=point)
        return GroundReaction(push=precise.unit(axis))

    def leaves_plane(self, system: System, u: RelativeCoordinate, normal: int) -> bool | None:
        """Whether its axis is not in the plane, or its points are not level."""
        (height,) = _heights(u, normal)
        if height <= FLAT:
            return not _is_level(system, u, normal)
        return None if height >= 1.0 - FLAT else True

    def direction(self, inputs: Mapping[str, Sequence[float]]) -> Triple | None:
        """Axis a′_i (3,) [-]."""
        return precise.triple(inputs["a_i_b"])


class OnLineFacets(ConstraintFacets):
    """p2: d is parallel to an axis of body i, ã_i d = 0, (8.16); all three rows (3,) [m] of it."""

    holds = frozenset({RelativeMotion.SHIFT})

    def residuals(
        self, i: BodyMotion, j: BodyMotion, inputs: Inputs, digits: Digits
    ) -> Sequence[Jet]:
        """Product a_i × d (3,) [m]."""
        return cross(i.vector(inputs["a_i_b"]), _across(i, j, inputs))

    def gap(self, bodies: BodiesAtRest) -> tuple[Real, int]:
        """Gap |a_i × d| [m]."""
        return precise.length(precise.cross(bodies.axes[0], bodies.d)), 0

    def ground_reaction(self, axis: Triple | None, point: Triple | None) -> GroundReaction:
        """Forces across the axis, through its line; where it turns, through the point."""
        if axis is None or point is None:
            return GroundReaction(through=point)
        return GroundReaction(line=(precise.unit(axis), point))


def _across(i: BodyMotion, j: BodyMotion, inputs: Inputs) -> JetVector:
    """Vector d, from the point of body i to that of body j [m]."""
    start, end = i.point(inputs["s_i_b"]), j.point(inputs["s_j_b"])
    return end[0] - start[0], end[1] - start[1], end[2] - start[2]


def _heights(u: RelativeCoordinate, normal: int) -> list[float]:
    """Parts of the axes of a coordinate across the plane; 0 is in the plane and 1 across it."""
    return [abs(axis[normal]) for name, axis in u.constants if not is_point(name)]


def _is_level(system: System, u: RelativeCoordinate, normal: int) -> bool:
    """Whether the points of a coordinate are level with the centres of mass and each other."""
    return is_level(heights_of_ends(system, u, normal), [values for _, values in u.constants])


def _angle(bodies: BodiesAtRest) -> tuple[Real, Real]:
    """Sine and cosine of the angle between the lines of two axes."""
    axis, other = bodies.axes
    return precise.length(precise.cross(axis, other)), abs(precise.dot(axis, other))


CONSTRAINT_FACETS: dict[str, ConstraintFacets] = {
    "point": PointFacets(),
    "distance": DistanceFacets(),
    "n1": PerpendicularFacets(),
    "n2": InPlaneFacets(),
    "p1": ParallelFacets(),
    "p2": OnLineFacets(),
    "angle": AngleFacets(),
    "length": LengthFacets(),
}
"""Facets by names of kinds; a combination has those of its coordinates."""


def facets_of_kind(package: str) -> ConstraintFacets:
    """Facets of a package, such as ``p1_z``."""
    return CONSTRAINT_FACETS[base_of(package)]


def held_by(package: str) -> frozenset[RelativeMotion]:
    """Motions that a package prevents, whatever the position; one's own may depend on it."""
    base = base_of(package)
    return CONSTRAINT_FACETS[base].holds if base in CONSTRAINT_FACETS else frozenset()
