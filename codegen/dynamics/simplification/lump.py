"""Bodies that joints hold rigidly become one body, and those held to the ground become ground.

What a fixed joint holds does not move against each other, so its rows and the columns of one body
are left out; where a body is follows from what carries it. Such a joint has no reactions, so
no bodies are lumped where reactions are wanted.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.elements.force_facets import facets_of
from kousoku.codegen.dynamics.operations.placement import Placement, seen_from_carriers
from kousoku.codegen.dynamics.simplification.axis_permutation import Plane, can_permute, permuted
from kousoku.codegen.dynamics.simplification.composite import joined, on_ground
from kousoku.codegen.dynamics.simplification.planarity import is_planar
from kousoku.codegen.dynamics.simplification.rigid_groups import grouped
from kousoku.codegen.dynamics.simplification.static_potential import static_potential
from kousoku.model.mechanics.constraints import base_of
from kousoku.model.mechanics.multibody import GROUND_INDEX, Carried
from kousoku.model.mechanics.parallel_rows import variant

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping, Sequence

    from kousoku.model.mechanics.multibody import Instance, MovingBody, RelativeCoordinate, System


@dataclass(frozen=True, slots=True)
class LumpedSystem:
    """A system whose bodies all move against each other.

    Parameters
    ----------
    system : System
        What is solved.
    joints : tuple of str
        The fixed joints that are left out.
    """

    system: System
    joints: tuple[str, ...] = ()


def lump(system: System, wanted: Collection[str] = ()) -> LumpedSystem:
    """Assembled system with bodies that are joined rigidly as one.

    Parameters
    ----------
    system : System
        At positions and velocities that fit.
    wanted : collection of str
        Outputs; with ``reactions`` no bodies are lumped.
    """
    groups = () if "reactions" in wanted else grouped(system)
    if not groups:
        return LumpedSystem(system)
    leader = {body: group[0] for group in groups for body in group}
    joints = dict.fromkeys(
        one.joint
        for one in system.constraints
        if one.i != one.j and leader.get(one.i, one.i) == leader.get(one.j, one.j)
    )
    return LumpedSystem(_in_plane(system, groups) or _joined(system, groups), tuple(joints))


def _in_plane(system: System, groups: Sequence[Sequence[int]]) -> System | None:
    """System with one body for each group, if joints then hold all in a plane.

    Parts at different heights have products of inertia. In a plane that they are held in these do
    not count, and without them the principal axes stay in the plane.
    """
    # asked before the plane of the scene is found, as that is of bodies that are joined already
    for plane in Plane if can_permute(system) else ():
        normal = plane.normal
        if all(x == 0 for body in system.bodies for k, x in enumerate(body.p[1:]) if k != normal):
            found = _joined(system, groups, normal)
            if is_planar(permuted(found, plane.value), must_be_held=True):
                return found
    return None


def _joined(system: System, groups: Sequence[Sequence[int]], normal: int | None = None) -> System:
    """System with one body for each group, the ground for one that begins with it."""
    bodies, placements = _placed(system, groups, normal)
    moving = [
        one for one in system.forces if placements[one.i].carrier != placements[one.j].carrier
    ]
    carried = tuple(
        Carried(
            one.name,
            placements[k].carrier,
            one.is_point,
            placements[k].point(one.origin_b),
            placements[k].frame(one.axes_b),
        )
        for k, one in enumerate(system.bodies)
    )
    return replace(
        system,
        bodies=tuple(bodies),
        constraints=tuple(
            _instance(one, placements)
            for one in system.constraints
            if len({placements[body].carrier for body in one.bodies}) > 1
        ),
        held=(),
        held_rates=(),
        forces=tuple(
            facets_of(one).seen_from(placements[one.i], placements[one.j]) for one in moving
        ),
        coordinates=tuple(_coordinate(one, placements) for one in system.coordinates),
        carried=carried,
        resting=static_potential(system, placements),
    )


def _placed(
    system: System, groups: Sequence[Sequence[int]], normal: int | None
) -> tuple[list[MovingBody], dict[int, Placement]]:
    """Bodies that move, and the placement of each body of the scene and of the ground."""
    placements = {GROUND_INDEX: Placement(GROUND_INDEX)}
    members_of = {group[0]: group for group in groups}
    carried = {body for group in groups for body in group[1:]}
    for k in members_of.get(GROUND_INDEX, (GROUND_INDEX,))[1:]:
        placements[k] = on_ground(system.bodies[k])
    bodies: list[MovingBody] = []
    for k, body in enumerate(system.bodies):
        if k in members_of:
            members = members_of[k]
            own = [system.bodies[member] for member in members]
            together, places = joined(own, len(bodies), normal)
            placements |= zip(members, places, strict=True)
            bodies.append(together)
        elif k not in carried:
            placements[k] = Placement(len(bodies))
            bodies.append(body)
    return bodies, placements


def _instance(one: Instance, placements: Mapping[int, Placement]) -> Instance:
    """Constraint between the bodies that carry its own."""
    constants = seen_from_carriers(one.constants, placements[one.i], placements[one.j])
    kind = base_of(one.kind)
    return replace(
        one,
        kind=variant(kind, dict(constants)["a_i_b"]) if kind != one.kind else kind,
        i=placements[one.i].carrier,
        j=placements[one.j].carrier,
        constants=constants,
        others=tuple(placements[body].carrier for body in one.others),
    )


def _coordinate(one: RelativeCoordinate, placements: Mapping[int, Placement]) -> RelativeCoordinate:
    i, j = placements[one.i], placements[one.j]
    constants = seen_from_carriers(one.constants, i, j)
    return replace(one, i=i.carrier, j=j.carrier, constants=constants)
