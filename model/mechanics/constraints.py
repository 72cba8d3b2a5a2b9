"""Kinds of constraints, of which joints are composed, and of coordinates, which measure them.

What they mean in a program and in the checks beside it stands in
:mod:`kousoku.codegen.dynamics.elements.constraints`; their equations in :mod:`kousoku.symbolic`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from kousoku.model.mechanics.parallel_rows import ROWS

if TYPE_CHECKING:
    from collections.abc import Mapping

    from kousoku.model.numbers.precise import High, Triple

COMBINATION = "linear_combination"
"""The kind of an instance that combines coordinates."""

AXES_I, AXES_J = ("a_i_b", "b_i_b"), ("a_j_b",)


def is_point(name: str) -> bool:
    """Whether an input of a kernel is a point of a body, ``s_i_b`` or ``s_j_b``."""
    return name.startswith("s_")


def is_axis(name: str) -> bool:
    """Whether an input of a kernel is an axis of a body, such as ``a_i_b``."""
    return name.startswith(("a_", "b_"))


@dataclass(frozen=True, slots=True)
class ConstraintKind:
    """Kind of constraint: its properties beside its equations.

    Parameters
    ----------
    rows : int
        Count of equations.
    unit : {"m", "rad", ""}
        The unit of its residual, or of the coordinate; an instance says it where it is empty. That
        of cosines and sines is "rad", too, as they are angles to first order.
    inputs : tuple of str
        Vectors and points that are fixed in the bodies, in the order of the kernel's arguments.
    has_variants : bool
        Whether there are three packages, by the axis of body i whose rows are kept: ``p1_z``.
    has_length : bool
        Whether its kernels take a ``length`` after these inputs.
    """

    rows: int
    unit: str
    inputs: tuple[str, ...]
    has_variants: bool = False
    has_length: bool = False

    def needs_orientation(self, body: int) -> bool:
        """Whether it needs the orientation of body i (0) or j (1), which a point lacks."""
        return not self.inputs or any(name in (AXES_I, AXES_J)[body] for name in self.inputs)


class CoordinateKind(ConstraintKind, ABC):
    """A kind whose residual is a coordinate.

    Attributes
    ----------
    counts_turns : bool
        Whether it is an angle, which kernels know up to whole turns only.
    is_distance : bool
        Whether it is the distance of two points, which has no direction at zero.
    """

    counts_turns: ClassVar[bool] = False
    is_distance: ClassVar[bool] = False

    @abstractmethod
    def value(self, axes: Mapping[str, Triple], ends: tuple[Triple, Triple] | None) -> High:
        """Value u of the coordinate, a scalar in rad or in the unit of the ends.

        Parameters
        ----------
        axes : mapping of str to (3,) [-]
            Its axes a = A a′ by the names of the inputs, of norm one, frame O.
        ends : ((3,), (3,)), optional
            Its points r + A s′ on body i and on body j, frame O; d of lecture 8.2, (8.8), is
            between them.
        """


class AngleKind(CoordinateKind):
    """Angle from a_i to a_j about a_i × b_i [rad], within half a turn; frame O."""

    counts_turns = True

    def value(self, axes: Mapping[str, Triple], ends: tuple[Triple, Triple] | None) -> High:
        """Angle atan2(b_i · a_j, a_i · a_j) [rad] of axes (3,) [-], frame O."""
        from kousoku.model.numbers import precise

        sine = precise.cleaned(precise.dot(axes["b_i_b"], axes["a_j_b"]), 1)
        return precise.atan2(sine, precise.dot(axes["a_i_b"], axes["a_j_b"]))


class CosineKind(CoordinateKind):
    """Cosine of the angle between two axes [-], frame O; lecture 8.2, (8.9)."""

    def value(self, axes: Mapping[str, Triple], ends: tuple[Triple, Triple] | None) -> High:
        """Product a_i · a_j [-] of axes (3,) [-], frame O."""
        from kousoku.model.numbers import precise

        return precise.cleaned(precise.dot(axes["a_i_b"], axes["a_j_b"]), 1)


class LengthKind(CoordinateKind):
    """Distance of two points, |d| of lecture 8.2, (8.8), frame O."""

    is_distance = True

    def value(self, axes: Mapping[str, Triple], ends: tuple[Triple, Triple] | None) -> High:
        """Length |d| [unit of the ends] between points (3,), frame O."""
        from kousoku.model.numbers import precise

        assert ends is not None
        return precise.length(precise.subtract(ends[1], ends[0]))


class DisplacementKind(CoordinateKind):
    """Displacement along an axis of body i, a_i · d, frame O; lecture 8.2, (8.12)."""

    def value(self, axes: Mapping[str, Triple], ends: tuple[Triple, Triple] | None) -> High:
        """Product a_i · d [unit of the ends] of an axis (3,) [-] and points (3,), frame O."""
        from kousoku.model.numbers import precise

        assert ends is not None
        start, end = ends
        size = precise.length(start) + precise.length(end)
        return precise.cleaned(precise.dot(axes["a_i_b"], precise.subtract(end, start)), size)


_ENDS = ("s_i_b", "s_j_b")
_COSINE = CosineKind(1, "rad", ("a_i_b", "a_j_b"))
_DISPLACEMENT = DisplacementKind(1, "m", ("a_i_b", *_ENDS))

CONSTRAINTS: dict[str, ConstraintKind] = {
    "point": ConstraintKind(3, "m", _ENDS),
    "distance": ConstraintKind(1, "m", _ENDS, has_length=True),
    "n1": _COSINE,
    "n2": _DISPLACEMENT,
    "p1": ConstraintKind(2, "rad", ("a_i_b", "a_j_b"), has_variants=True),
    "p2": ConstraintKind(2, "m", ("a_i_b", *_ENDS), has_variants=True),
    COMBINATION: ConstraintKind(1, "", ()),
}
"""Kinds that joints are composed of; lecture 8.2: n1 (8.9), n2 (8.12), p1 (8.14), p2 (8.16)."""

COORDINATES: dict[str, CoordinateKind] = {
    "angle": AngleKind(1, "rad", ("a_i_b", "b_i_b", "a_j_b")),
    "length": LengthKind(1, "m", _ENDS),
    "n1": _COSINE,
    "n2": _DISPLACEMENT,
}
"""Kinds whose residual is a coordinate."""


def base_and_axis(package: str) -> tuple[str, str]:
    """Kind of a package and the axis that its rows are chosen by: ``p1`` and ``z`` of ``p1_z``.

    The axis is empty where the kind has no variants, and of one's own.
    """
    name, _, axis = package.partition("_")
    return (name, axis) if axis in ROWS and name in CONSTRAINTS else (package, "")


def base_of(package: str) -> str:
    """Kind of a package: ``p1`` of ``p1_z``."""
    return base_and_axis(package)[0]


def kind_of(package: str) -> ConstraintKind:
    """Kind of the constraint or coordinate of a package."""
    base = base_of(package)
    return CONSTRAINTS[base] if base in CONSTRAINTS else COORDINATES[base]


def is_known(package: str) -> bool:
    """Whether a package is one of these kinds, and none of one's own."""
    return base_of(package) in CONSTRAINTS or package in COORDINATES


def components_of(package: str) -> tuple[int, ...]:
    """Component of a vector that each row of a package is; none where its rows are no vector."""
    base, axis = base_and_axis(package)
    if base not in CONSTRAINTS:
        return ()
    if CONSTRAINTS[base].has_variants:
        return ROWS.get(axis, ())
    return (0, 1, 2) if CONSTRAINTS[base].rows == 3 else ()


def is_length(package: str) -> bool:
    """Whether the residual of a package is a length; a combination does not say so."""
    return is_known(package) and kind_of(package).unit == "m"
