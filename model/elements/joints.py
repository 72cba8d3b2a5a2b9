"""Every joint and coupling: the one table that code and documents share.

A joint is an entry of :data:`JOINTS`. One that has rows, numbers or angles as no other has them is
a class of its own in :mod:`kousoku.model.elements`; so is each coupling.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.model.elements.constant_velocity import ConstantVelocity
from kousoku.model.elements.gear import Gear
from kousoku.model.elements.joint import (
    ANGLE,
    COMBINED,
    DISPLACEMENT,
    DISPLACEMENTS,
    NO_TURN,
    ON_LINE,
    ON_PLANE,
    PARALLEL,
    POINT,
    SECOND_ANGLE,
    JointKind,
    JointPart,
)
from kousoku.model.elements.linear_coupling import LinearCoupling
from kousoku.model.elements.rack_and_pinion import RackAndPinion
from kousoku.model.elements.rod import RodJoint
from kousoku.model.elements.screw import Screw
from kousoku.model.elements.universal import Universal

if TYPE_CHECKING:
    from collections.abc import Mapping

    from kousoku.model.elements.coupling import Coupling
    from kousoku.model.elements.inputs import ElementInput

JOINTS: dict[str, JointKind] = {
    "fixed": JointKind(
        "no relative motion", (POINT, PARALLEL, NO_TURN), 0, aliases=("weld", "rigid")
    ),
    "revolute": JointKind(
        "a turn about an axis",
        (POINT, PARALLEL),
        1,
        aliases=("hinge", "pin"),
        free_coordinates=(ANGLE,),
    ),
    "prismatic": JointKind(
        "a displacement along an axis",
        (PARALLEL, ON_LINE, NO_TURN),
        1,
        aliases=("slider", "translational"),
        free_coordinates=(DISPLACEMENT,),
    ),
    "cylindrical": JointKind(
        "a turn about an axis and a displacement along it",
        (PARALLEL, ON_LINE),
        1,
        free_coordinates=(ANGLE, DISPLACEMENT),
    ),
    "spherical": JointKind("all turns about a point", (POINT,), 0, aliases=("ball",)),
    "universal": Universal(
        "turns about the two arms of a cross",
        (POINT, JointPart("n1")),
        2,
        aliases=("hooke", "cardan", "Hooke", "Cardan"),  # names of people
        free_coordinates=(ANGLE, SECOND_ANGLE),
    ),
    "planar": JointKind(
        "displacements in a plane and a turn about its normal",
        (PARALLEL, ON_PLANE),
        1,
        free_coordinates=(ANGLE, *DISPLACEMENTS),
    ),
    "rod": RodJoint(
        "all that keeps the distance of two points",
        (JointPart("distance"),),
        0,
        aliases=("distance", "spherical_spherical"),
    ),
    "point_on_line": JointKind(
        "all turns, and a displacement of the point of j on the line through the point of i",
        (ON_LINE,),
        1,
        aliases=("inline",),
        free_coordinates=(DISPLACEMENT,),
    ),
    "point_on_plane": JointKind(
        "all turns, and displacements of the point of j in the plane through the point of i",
        (ON_PLANE,),
        1,
        aliases=("inplane",),
    ),
    "parallel_axes": JointKind(
        "all displacements, and a turn about two axes that stay parallel",
        (PARALLEL,),
        1,
        has_point=False,
        aliases=("parallel",),
        free_coordinates=(ANGLE,),
    ),
    "perpendicular_axes": JointKind(
        "all that keeps two axes perpendicular",
        (JointPart("n1"),),
        2,
        has_point=False,
        aliases=("perpendicular",),
    ),
    "screw": Screw(
        "a turn about an axis and, with it, a displacement along it",
        (PARALLEL, ON_LINE, COMBINED),
        1,
        aliases=("helical",),
        free_coordinates=(ANGLE, DISPLACEMENT),
        keys=("pitch",),
    ),
    "constant_velocity": ConstantVelocity(
        "the bend of two shafts that turn equally fast",
        (POINT, COMBINED),
        2,
        aliases=("cv", "homokinetic", "rzeppa", "convel"),
    ),
}
"""All joints between two bodies by name."""

COUPLINGS: dict[str, Coupling] = {
    "gear": Gear(),
    "rack_and_pinion": RackAndPinion(),
    "linear": LinearCoupling(),
}
"""All couplings by name."""

NAMES: dict[str, str] = {
    name: joint
    for table in (JOINTS, COUPLINGS)
    for joint, entry in table.items()
    for name in (joint, *entry.aliases)
}
"""Name of the joint or coupling by each accepted name, its own or an alias."""


def keys_of(kind: str) -> tuple[str, ...]:
    """Keys of a joint or a coupling by its name or alias, none where there is none."""
    name = NAMES.get(kind, "")
    entry = COUPLINGS.get(name) or JOINTS.get(name)
    return ("type", *entry.all_keys) if entry is not None else ()


def inputs_of(kind: str) -> Mapping[str, ElementInput]:
    """Keys that a joint or a coupling alone has, by its name or alias."""
    name = NAMES.get(kind, "")
    entry = COUPLINGS.get(name) or JOINTS.get(name)
    return entry.inputs if entry is not None else {}


def free_coordinates_of(kind: str) -> tuple[str, ...]:
    """Relative coordinates that a joint leaves free, each one number, by its name or alias.

    None are known of a kind of one's own.
    """
    name = NAMES.get(kind)
    return JOINTS[name].free_coordinates if name in JOINTS else ()


def sort_of(kind: str, of: str | None) -> str:
    """Free coordinate of a joint: the one that is named, or the only one.

    Parameters
    ----------
    kind : str
        Name or alias of a joint that leaves one free.
    of : str, optional
        ``angle``, ``second_angle``, ``displacement`` or ``second_displacement``.
    """
    return of or free_coordinates_of(kind)[0]
