"""Every joint as a composition of the lecture's kinds: the one table that code and documents share.

A joint has a frame in each of its two bodies: an axis, a direction across it, and a third that is
perpendicular to both. A row of the table says which kind keeps which of them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

ANGLE, SECOND_ANGLE = "angle", "second_angle"
DISPLACEMENT, SECOND_DISPLACEMENT = "displacement", "second_displacement"
"""What a joint can leave free that is one number."""

ANGLES, DISPLACEMENTS = (ANGLE, SECOND_ANGLE), (DISPLACEMENT, SECOND_DISPLACEMENT)
"""Those of them that are in rad, and those that are lengths."""

ROWS_OF = {
    "point": 3,
    "distance": 1,
    "n1": 1,
    "n2": 1,
    "p1": 2,
    "p2": 2,
    "linear_combination": 1,
}
"""Equations of each kind that joints are made of."""


@dataclass(frozen=True, slots=True)
class JointPart:
    """One kind in a joint.

    Parameters
    ----------
    kind : str
        ``point``, ``distance``, ``n1``, ``n2``, ``p1``, ``p2``, or ``linear_combination`` of
        coordinates.
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
    leaves : tuple of str
        What it leaves free that is one number: its ``angle``, the ``second_angle`` of a universal
        joint, its ``displacement``, the ``second_displacement`` of a planar joint.
    keys : tuple of str
        Numbers that a scene gives and that no other joint has.
    """

    title: str
    parts: tuple[JointPart, ...]
    axes: int
    has_point: bool = True
    aliases: tuple[str, ...] = ()
    leaves: tuple[str, ...] = ()
    keys: tuple[str, ...] = ()

    @property
    def rows(self) -> int:
        """Count of equations, the freedoms that the joint takes away."""
        return sum(ROWS_OF[part.kind] for part in self.parts)

    def turns(self, body: int) -> bool:
        """Whether it needs the orientation of body i (0) or j (1), which a point lacks."""
        both, first = ("n1", "p1", "linear_combination"), ("n2", "p2")
        return any(part.kind in (both if body else both + first) for part in self.parts)

    @property
    def keeps_zero(self) -> bool:
        """Whether directions across its axis stay parallel, or stay so but for a bend."""
        return self.has_zero and ANGLE not in self.leaves

    @property
    def counts_along_zero(self) -> bool:
        """Whether its displacements are across its axis: along the zero direction and beside it."""
        return SECOND_DISPLACEMENT in self.leaves

    @property
    def has_zero(self) -> bool:
        """Whether directions across its axis count: it has an angle, or keeps one."""
        across = any("across" in (part.i, part.j) for part in self.parts)
        return across or ANGLE in self.leaves or (self.axes == 2 and _COMBINED in self.parts)


@dataclass(frozen=True, slots=True)
class Coupling:
    """A linear combination of what other joints leave free: it has no bodies of its own.

    Parameters
    ----------
    title : str
        What it couples, in one line.
    keys : tuple of str
        What a scene gives.
    couples : tuple of str
        What the two joints of it must leave free, where it names joints.
    aliases : tuple of str
        Other names that are accepted.
    """

    title: str
    keys: tuple[str, ...]
    couples: tuple[str, ...] = ()
    aliases: tuple[str, ...] = ()

    @property
    def rows(self) -> int:
        """Count of equations."""
        return 1


_POINT, _PARALLEL, _ON_LINE, _ON_PLANE = (
    JointPart("point"),
    JointPart("p1"),
    JointPart("p2"),
    JointPart("n2"),
)
_COMBINED = JointPart("linear_combination")
_NO_TURN = JointPart("n1", "across", "third")

JOINTS: dict[str, JointKind] = {
    "fixed": JointKind(
        "no relative motion", (_POINT, _PARALLEL, _NO_TURN), 0, aliases=("weld", "rigid")
    ),
    "revolute": JointKind(
        "a turn about an axis",
        (_POINT, _PARALLEL),
        1,
        aliases=("hinge", "pin"),
        leaves=(ANGLE,),
    ),
    "prismatic": JointKind(
        "a displacement along an axis",
        (_PARALLEL, _ON_LINE, _NO_TURN),
        1,
        aliases=("slider", "translational"),
        leaves=(DISPLACEMENT,),
    ),
    "cylindrical": JointKind(
        "a turn about an axis and a displacement along it",
        (_PARALLEL, _ON_LINE),
        1,
        leaves=(ANGLE, DISPLACEMENT),
    ),
    "spherical": JointKind("all turns about a point", (_POINT,), 0, aliases=("ball",)),
    "universal": JointKind(
        "turns about the two arms of a cross",
        (_POINT, JointPart("n1")),
        2,
        aliases=("hooke", "cardan", "Hooke", "Cardan"),  # names of people
        leaves=(ANGLE, SECOND_ANGLE),
    ),
    "planar": JointKind(
        "displacements in a plane and a turn about its normal",
        (_PARALLEL, _ON_PLANE),
        1,
        leaves=(ANGLE, *DISPLACEMENTS),
    ),
    "rod": JointKind(
        "all that keeps the distance of two points",
        (JointPart("distance"),),
        0,
        aliases=("distance", "spherical_spherical"),
    ),
    "point_on_line": JointKind(
        "all turns, and a displacement of the point of j on the line through the point of i",
        (_ON_LINE,),
        1,
        aliases=("inline",),
        leaves=(DISPLACEMENT,),
    ),
    "point_on_plane": JointKind(
        "all turns, and displacements of the point of j in the plane through the point of i",
        (_ON_PLANE,),
        1,
        aliases=("inplane",),
    ),
    "parallel_axes": JointKind(
        "all displacements, and a turn about two axes that stay parallel",
        (_PARALLEL,),
        1,
        has_point=False,
        aliases=("parallel",),
        leaves=(ANGLE,),
    ),
    "perpendicular_axes": JointKind(
        "all that keeps two axes perpendicular",
        (JointPart("n1"),),
        2,
        has_point=False,
        aliases=("perpendicular",),
    ),
    "screw": JointKind(
        "a turn about an axis and, with it, a displacement along it",
        (_PARALLEL, _ON_LINE, _COMBINED),
        1,
        aliases=("helical",),
        leaves=(ANGLE, DISPLACEMENT),
        keys=("pitch",),
    ),
    "constant_velocity": JointKind(
        "the bend of two shafts that turn equally fast",
        (_POINT, _COMBINED),
        2,
        aliases=("cv", "homokinetic", "rzeppa", "convel"),
    ),
}
"""All joints between two bodies by name."""

COUPLINGS: dict[str, Coupling] = {
    "gear": Coupling(
        "the angles of two joints, in a ratio",
        ("joints", "ratio"),
        (ANGLE, ANGLE),
        aliases=("gears",),
    ),
    "rack_and_pinion": Coupling(
        "the angle of one joint and the displacement of another",
        ("joints", "radius"),
        (ANGLE, DISPLACEMENT),
        aliases=("rack", "rackpin"),
    ),
    "linear": Coupling(
        "the sum of coordinates, each multiplied by a factor",
        ("coordinates", "factors"),
        aliases=("coupler",),
    ),
}
"""All couplings by name."""

NAMES: dict[str, str] = {
    name: joint
    for table in (JOINTS, COUPLINGS)
    for joint, entry in table.items()
    for name in (joint, *entry.aliases)
}
"""The joint or coupling that each accepted name stands for."""


def keys_of(kind: str) -> tuple[str, ...]:
    """Keys of a joint or a coupling by its name or alias, none where there is none."""
    name = NAMES.get(kind, "")
    if name in COUPLINGS:
        return ("type", *COUPLINGS[name].keys)
    if name not in JOINTS:
        return ()
    entry = JOINTS[name]
    points = ("points",) if name == "rod" else ("points", "at")
    axes = ("axes", "axis", "second_axis")[: 1 + entry.axes] if entry.axes else ()
    zero = ("zero",) * entry.has_zero
    length = ("length",) * (name == "rod")
    own = (*points * entry.has_point, *axes, *zero, *length, *entry.keys)
    return ("type", "bodies", *own)


def leaves_of(kind: str) -> tuple[str, ...]:
    """Coordinate that a joint leaves free and that is one number, by its name or alias.

    Of a kind of one's own nobody has said that.
    """
    name = NAMES.get(kind)
    return JOINTS[name].leaves if name in JOINTS else ()


def listed(names: Sequence[str], last: str = "and") -> str:
    """Names as a list in words: ``a``, ``a and b``, ``a, b and c``."""
    *most, end = names
    return f"{', '.join(most)} {last} {end}" if most else end


def sort_of(kind: str, of: str | None) -> str:
    """Coordinate of a joint that is meant: the one that is named, or the only one.

    Parameters
    ----------
    kind : str
        Name or alias of a joint that leaves one free.
    of : str, optional
        ``angle``, ``second_angle``, ``displacement`` or ``second_displacement``.
    """
    return of or leaves_of(kind)[0]
