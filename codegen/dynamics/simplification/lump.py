"""Bodies that fixed joints connect become one body, and those fixed to the ground become ground.

They do not move against each other, so the rows of the joint and the columns of one body are left
out; the position of a body follows from its carrier. Such a joint has no reactions, so no bodies
are lumped where reactions are wanted.
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
        The system that is solved.
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
        c.joint
        for c in system.constraints
        if c.i != c.j and leader.get(c.i, c.i) == leader.get(c.j, c.j)
    )
    return LumpedSystem(_in_plane(system, groups) or _joined(system, groups), tuple(joints))


def _in_plane(system: System, groups: Sequence[Sequence[int]]) -> System | None:
    """System with one body for each group, if joints then hold all in a plane.

    Parts at different heights have products of inertia with the normal. Where joints hold bodies in
    the plane these do not count, and without them the principal axes stay in the plane.
    """
    # asked before the plane of the scene is found, which is that of joined bodies
    for plane in Plane if can_permute(system) else ():
        normal = plane.normal
        if all(x == 0 for body in system.bodies for k, x in enumerate(body.p[1:]) if k != normal):
            together = _joined(system, groups, normal)
            if is_planar(permuted(together, plane.value), must_be_held=True):
                return together
    return None


def _joined(system: System, groups: Sequence[Sequence[int]], normal: int | None = None) -> System:
    """System with one body for each group; a group that begins with the ground becomes ground."""
    bodies, placements = _placed(system, groups, normal)
    forces = [f for f in system.forces if placements[f.i].carrier != placements[f.j].carrier]
    carried = tuple(
        Carried(
            body.name,
            placements[k].carrier,
            body.is_point,
            placements[k].point(body.origin_b),
            placements[k].frame(body.axes_b),
        )
        for k, body in enumerate(system.bodies)
    )
    return replace(
        system,
        bodies=tuple(bodies),
        constraints=tuple(
            _instance(instance, placements)
            for instance in system.constraints
            if len({placements[body].carrier for body in instance.bodies}) > 1
        ),
        held=(),
        held_rates=(),
        forces=tuple(facets_of(f).seen_from(placements[f.i], placements[f.j]) for f in forces),
        coordinates=tuple(_coordinate(c, placements) for c in system.coordinates),
        carried=carried,
        static_potential=static_potential(system, placements),
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
            parts = [system.bodies[member] for member in members]
            composite, of_members = joined(parts, len(bodies), normal)
            placements |= zip(members, of_members, strict=True)
            bodies.append(composite)
        elif k not in carried:
            placements[k] = Placement(len(bodies))
            bodies.append(body)
    return bodies, placements


def _instance(instance: Instance, placements: Mapping[int, Placement]) -> Instance:
    """Constraint between the carriers of its bodies."""
    i, j = placements[instance.i], placements[instance.j]
    constants = seen_from_carriers(instance.constants, i, j)
    kind = base_of(instance.kind)
    return replace(
        instance,
        kind=variant(kind, dict(constants)["a_i_b"]) if kind != instance.kind else kind,
        i=i.carrier,
        j=j.carrier,
        constants=constants,
        others=tuple(placements[body].carrier for body in instance.others),
    )


def _coordinate(
    coordinate: RelativeCoordinate, placements: Mapping[int, Placement]
) -> RelativeCoordinate:
    i, j = placements[coordinate.i], placements[coordinate.j]
    constants = seen_from_carriers(coordinate.constants, i, j)
    return replace(coordinate, i=i.carrier, j=j.carrier, constants=constants)
