"""The kinds of constraints and coordinates: what joints are made of, and what of them is measured.

What they mean in a program and in the checks beside it stands in
:mod:`kousoku.codegen.dynamics.elements.constraints`; their equations in :mod:`kousoku.symbolic`.
"""

from __future__ import annotations

from dataclasses import dataclass

COMBINATION = "linear_combination"
"""The kind of an instance that combines coordinates."""

AXES_I, AXES_J = ("a_i_b", "b_i_b"), ("a_j_b",)


@dataclass(frozen=True, slots=True)
class ConstraintKind:
    """What is known of a kind beside its equations.

    Parameters
    ----------
    rows : int
        Count of equations.
    unit : {"m", "rad", ""}
        The unit of its residual, or of the coordinate; an instance says it where it is empty.
    inputs : tuple of str
        Vectors and points that are fixed in the bodies, in the order of the kernel's arguments.
    has_variants : bool
        Whether there are three packages, by the axis of body i whose rows are kept: ``p1_z``.
    """

    rows: int
    unit: str
    inputs: tuple[str, ...]
    has_variants: bool = False

    def turns(self, body: int) -> bool:
        """Whether it needs the orientation of body i (0) or j (1), which a point lacks."""
        return not self.inputs or any(name in (AXES_I, AXES_J)[body] for name in self.inputs)


_ENDS = ("s_i_b", "s_j_b")

CONSTRAINTS: dict[str, ConstraintKind] = {
    "point": ConstraintKind(3, "m", _ENDS),
    "distance": ConstraintKind(1, "m", _ENDS),
    "n1": ConstraintKind(1, "rad", ("a_i_b", "a_j_b")),
    "n2": ConstraintKind(1, "m", ("a_i_b", *_ENDS)),
    "p1": ConstraintKind(2, "rad", ("a_i_b", "a_j_b"), has_variants=True),
    "p2": ConstraintKind(2, "m", ("a_i_b", *_ENDS), has_variants=True),
    COMBINATION: ConstraintKind(1, "", ()),
}
"""Those that joints are made of."""

COORDINATES: dict[str, ConstraintKind] = {
    "angle": ConstraintKind(1, "rad", ("a_i_b", "b_i_b", "a_j_b")),
    "length": ConstraintKind(1, "m", _ENDS),
    **{name: CONSTRAINTS[name] for name in ("n1", "n2")},
}
"""Those whose residual is a coordinate."""


def base_of(package: str) -> str:
    """Kind of a package: ``p1`` of ``p1_z``."""
    name, _, axis = package.partition("_")
    return name if len(axis) == 1 and name in CONSTRAINTS else package


def kind_of(package: str) -> ConstraintKind:
    """Constraint of a package of one of these kinds."""
    base = base_of(package)
    return CONSTRAINTS[base] if base in CONSTRAINTS else COORDINATES[base]


def is_known(package: str) -> bool:
    """Whether a package is one of these kinds, and none of one's own."""
    return base_of(package) in CONSTRAINTS or package in COORDINATES


def is_length(package: str) -> bool:
    """Whether the residual of a package is a length; a combination does not say so."""
    return is_known(package) and kind_of(package).unit == "m"
