"""What kinds of constraints and coordinates mean, beside the equations that their kernels have.

Each kind is defined again, by geometry: of moving bodies for the equations of each body, at rest
for how far a joint is open, and by what the ground can do through it.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.operations.jets import Jet, atan2, cross, dot, sqrt
from kousoku.model import precise
from kousoku.model.digits import CONTEXT
from kousoku.model.elements.constraints import base_of

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from kousoku.codegen.dynamics.checking.newton_euler import Course
    from kousoku.codegen.dynamics.operations.jets import Vector
    from kousoku.model.arithmetic import FormulaArithmetic
    from kousoku.model.precise import Triple
    from kousoku.model.real import Real

    Digits = FormulaArithmetic[Real]
    #: Its inputs by name.
    Own = Mapping[str, Sequence[Real]]


@dataclass(frozen=True, slots=True)
class Contact:
    """What the ground does through one row, or one force.

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
    turns : bool
        Whether its moments are of any direction.
    """

    push: Triple | None = None
    through: Triple | None = None
    line: tuple[Triple, Triple] | None = None
    about: Triple | None = None
    turns: bool = False


ANYTHING = Contact(through=precise.ZERO, turns=True)
"""Any force and any moment."""


@dataclass(frozen=True, slots=True)
class Seen:
    """Two bodies at rest, as a constraint between them sees them.

    Parameters
    ----------
    axes : ((3,), (3,))
        a of body i and of body j in frame O; zero where it has none.
    d : (3,) [m]
        From the point of body i to that of body j, frame O.
    length : number [m], optional
        Its given length.
    """

    axes: tuple[Triple, Triple]
    d: Triple
    length: Real | None


class ConstraintFacets(ABC):
    """A kind of constraint or coordinate."""

    @abstractmethod
    def residuals(self, i: Course, j: Course, own: Own, digits: Digits) -> Sequence[Jet]:
        """Residuals, zero where it holds, or the value that it measures, from moving bodies.

        Parameters
        ----------
        i, j : Course
            The bodies on their way.
        own : mapping of str to sequence of number
            Its inputs.
        digits : FormulaArithmetic
            What numbers are computed with.
        """

    def gap(self, seen: Seen) -> tuple[Real, int]:
        """Gap that is left until it holds, and 0 for metres or 1 for radians."""
        raise NotImplementedError(f"{type(self).__name__} is no constraint")

    @abstractmethod
    def contact(self, axis: Triple | None, point: Triple | None) -> Contact:
        """Contact with the ground through it, whatever the position.

        Parameters
        ----------
        axis : (3,), optional
            Of the ground, or one of the body that stays parallel to one of the ground.
        point : (3,) [m], optional
            Of the ground.
        """


class OfPoints(ConstraintFacets):
    """Kinds of two points and no axis."""

    def contact(self, axis: Triple | None, point: Triple | None) -> Contact:
        """Forces through the point of the ground."""
        return Contact(through=point)


class Point(OfPoints):
    """Two points coincide."""

    def residuals(self, i: Course, j: Course, own: Own, digits: Digits) -> Sequence[Jet]:
        """Vector d [m]."""
        return _across(i, j, own)

    def gap(self, seen: Seen) -> tuple[Real, int]:
        """Length |d| [m]."""
        return precise.length(seen.d), 0


class Length(OfPoints):
    """The distance of two points."""

    def residuals(self, i: Course, j: Course, own: Own, digits: Digits) -> Sequence[Jet]:
        """Length |d| [m]."""
        d = _across(i, j, own)
        return (sqrt(dot(d, d), digits),)


class Distance(Length):
    """Two points at a given distance."""

    def residuals(self, i: Course, j: Course, own: Own, digits: Digits) -> Sequence[Jet]:
        """Residual |d| − l [m]."""
        (distance,), (length,) = super().residuals(i, j, own, digits), own["length"]
        return (distance - Jet(length),)

    def gap(self, seen: Seen) -> tuple[Real, int]:
        """Gap ||d| − l| [m]."""
        return abs(precise.length(seen.d) - seen.length), 0


class OfAxes(ConstraintFacets):
    """Kinds of two axes and no point."""

    def contact(self, axis: Triple | None, point: Triple | None) -> Contact:
        """Moments across the axis of the ground."""
        return Contact(about=axis)


class Perpendicular(OfAxes):
    """n1: two axes are perpendicular, or the cosine between them."""

    def residuals(self, i: Course, j: Course, own: Own, digits: Digits) -> Sequence[Jet]:
        """Product a_i · a_j."""
        return (dot(i.vector(own["a_i_b"]), j.vector(own["a_j_b"])),)

    def gap(self, seen: Seen) -> tuple[Real, int]:
        """Difference of the angle between them from a right one [rad]."""
        sine, cosine = _angle(seen)
        return CONTEXT.atan2(cosine, sine), 1


class Parallel(OfAxes):
    """p1: two axes are parallel."""

    def residuals(self, i: Course, j: Course, own: Own, digits: Digits) -> Sequence[Jet]:
        """Product a_i × a_j."""
        return cross(i.vector(own["a_i_b"]), j.vector(own["a_j_b"]))

    def gap(self, seen: Seen) -> tuple[Real, int]:
        """Angle between their lines."""
        return CONTEXT.atan2(*_angle(seen)), 1


class Angle(ConstraintFacets):
    """The angle from a_i to a_j, counted about a_i × b_i; without its turns."""

    def residuals(self, i: Course, j: Course, own: Own, digits: Digits) -> Sequence[Jet]:
        """Angle."""
        a_j = j.vector(own["a_j_b"])
        sine, cosine = (dot(i.vector(own[name]), a_j) for name in ("b_i_b", "a_i_b"))
        return (atan2(sine, cosine, digits),)

    def contact(self, axis: Triple | None, point: Triple | None) -> Contact:
        """Moments of any direction."""
        return Contact(turns=True)


class InPlane(ConstraintFacets):
    """n2: d is perpendicular to an axis of body i, or its component along that."""

    def residuals(self, i: Course, j: Course, own: Own, digits: Digits) -> Sequence[Jet]:
        """Product a_i · d [m]."""
        return (dot(i.vector(own["a_i_b"]), _across(i, j, own)),)

    def gap(self, seen: Seen) -> tuple[Real, int]:
        """Gap |a_i · d| [m]."""
        return abs(precise.dot(seen.axes[0], seen.d)), 0

    def contact(self, axis: Triple | None, point: Triple | None) -> Contact:
        """Forces along the axis, wherever they act; where it turns, through the point."""
        return Contact(through=point) if axis is None else Contact(push=precise.unit(axis))


class OnLine(ConstraintFacets):
    """p2: d is parallel to an axis of body i."""

    def residuals(self, i: Course, j: Course, own: Own, digits: Digits) -> Sequence[Jet]:
        """Product a_i × d [m]."""
        return cross(i.vector(own["a_i_b"]), _across(i, j, own))

    def gap(self, seen: Seen) -> tuple[Real, int]:
        """Gap |a_i × d| [m]."""
        return precise.length(precise.cross(seen.axes[0], seen.d)), 0

    def contact(self, axis: Triple | None, point: Triple | None) -> Contact:
        """Forces across the axis, through its line; where it turns, through the point."""
        if axis is None or point is None:
            return Contact(through=point)
        return Contact(line=(precise.unit(axis), point))


def _across(i: Course, j: Course, own: Own) -> Vector:
    """Vector d, from the point of body i to that of body j [m]."""
    start, end = i.point(own["s_i_b"]), j.point(own["s_j_b"])
    return end[0] - start[0], end[1] - start[1], end[2] - start[2]


def _angle(seen: Seen) -> tuple[Real, Real]:
    """Sine and cosine of the angle between the lines of two axes."""
    axis, other = seen.axes
    return precise.length(precise.cross(axis, other)), abs(precise.dot(axis, other))


FACETS: dict[str, ConstraintFacets] = {
    "point": Point(),
    "distance": Distance(),
    "n1": Perpendicular(),
    "n2": InPlane(),
    "p1": Parallel(),
    "p2": OnLine(),
    "angle": Angle(),
    "length": Length(),
}
"""By the names of the kinds; a combination is what its coordinates are."""


def facets_of_kind(package: str) -> ConstraintFacets:
    """Facets of a package, such as ``p1_z``."""
    return FACETS[base_of(package)]
