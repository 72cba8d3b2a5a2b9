"""Bodies that joints hold rigidly become one body, and those held to the ground become ground.

What a fixed joint holds does not move against each other, so its rows and the columns of one body
are left out; where a body is follows from what carries it. Such a joint has no reactions, so
nothing is merged where reactions are wanted.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.elements.forces import facets_of
from kousoku.codegen.dynamics.simplification.composite import (
    Seat,
    joined,
    on_ground,
    seen_from_carriers,
)
from kousoku.codegen.dynamics.simplification.outline import NORMAL
from kousoku.codegen.dynamics.simplification.planar import is_planar
from kousoku.codegen.dynamics.simplification.resting_energy import resting_energy
from kousoku.codegen.dynamics.simplification.rigid_groups import grouped
from kousoku.codegen.dynamics.simplification.turned import can_turn, turned
from kousoku.model.mechanism import GROUND_INDEX, Carried
from kousoku.model.rows import variant

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping, Sequence

    from kousoku.model.mechanism import Coordinate, Instance, MovingBody, System


@dataclass(frozen=True, slots=True)
class Merged:
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


def merged(system: System, wanted: Collection[str] = ()) -> Merged:
    """Return an assembled system with bodies that are joined rigidly as one.

    Parameters
    ----------
    system : System
        At positions and velocities that fit.
    wanted : collection of str
        Outputs; with ``reactions`` nothing is merged.
    """
    groups = () if "reactions" in wanted else grouped(system)
    if not groups:
        return Merged(system)
    leader = {body: group[0] for group in groups for body in group}
    joints = dict.fromkeys(
        one.joint
        for one in system.constraints
        if one.i != one.j and leader.get(one.i, one.i) == leader.get(one.j, one.j)
    )
    return Merged(_in_plane(system, groups) or _joined(system, groups), tuple(joints))


def _in_plane(system: System, groups: Sequence[Sequence[int]]) -> System | None:
    """Return the system with one body for each group, if joints then hold all in a plane.

    Parts at different heights have products of inertia. In a plane that they are held in these do
    not count, and without them the principal axes stay in the plane.
    """
    for shift in (0, 1, 2) if can_turn(system) else ():
        normal = (NORMAL + shift) % 3
        if all(x == 0 for body in system.bodies for k, x in enumerate(body.p[1:]) if k != normal):
            found = _joined(system, groups, normal)
            if is_planar(turned(found, shift), must_be_held=True):
                return found
    return None


def _joined(system: System, groups: Sequence[Sequence[int]], normal: int | None = None) -> System:
    """Return the system with one body for each group, the ground for one that begins with it."""
    bodies, seats = _seated(system, groups, normal)
    moving = [one for one in system.forces if seats[one.i].carrier != seats[one.j].carrier]
    carried = tuple(
        Carried(
            one.name,
            seats[k].carrier,
            one.is_point,
            seats[k].point(one.origin_b),
            seats[k].frame(one.axes_b),
        )
        for k, one in enumerate(system.bodies)
    )
    return replace(
        system,
        bodies=tuple(bodies),
        constraints=tuple(
            _instance(one, seats)
            for one in system.constraints
            if len({seats[body].carrier for body in one.bodies}) > 1
        ),
        held=(),
        held_rates=(),
        forces=tuple(facets_of(one).seen_from(seats[one.i], seats[one.j]) for one in moving),
        coordinates=tuple(_coordinate(one, seats) for one in system.coordinates),
        carried=carried,
        resting=resting_energy(system, seats),
    )


def _seated(
    system: System, groups: Sequence[Sequence[int]], normal: int | None
) -> tuple[list[MovingBody], dict[int, Seat]]:
    """Return the bodies that move, and the seat of each body of the scene and of the ground."""
    seats = {GROUND_INDEX: Seat(GROUND_INDEX)}
    members_of = {group[0]: group for group in groups}
    carried = {body for group in groups for body in group[1:]}
    for k in members_of.get(GROUND_INDEX, (GROUND_INDEX,))[1:]:
        seats[k] = on_ground(system.bodies[k], GROUND_INDEX)
    bodies: list[MovingBody] = []
    for k, body in enumerate(system.bodies):
        if k in members_of:
            members = members_of[k]
            own = [system.bodies[member] for member in members]
            together, places = joined(own, len(bodies), normal)
            seats |= zip(members, places, strict=True)
            bodies.append(together)
        elif k not in carried:
            seats[k] = Seat(len(bodies))
            bodies.append(body)
    return bodies, seats


def _instance(one: Instance, seats: Mapping[int, Seat]) -> Instance:
    """Return a constraint between the bodies that carry its own."""
    constants = seen_from_carriers(one.constants, seats[one.i], seats[one.j])
    kind, _, axis = one.kind.partition("_")
    return replace(
        one,
        kind=variant(kind, dict(constants)["a_i_b"]) if axis and kind in {"p1", "p2"} else one.kind,
        i=seats[one.i].carrier,
        j=seats[one.j].carrier,
        constants=constants,
        others=tuple(seats[body].carrier for body in one.others),
    )


def _coordinate(one: Coordinate, seats: Mapping[int, Seat]) -> Coordinate:
    i, j = seats[one.i], seats[one.j]
    constants = seen_from_carriers(one.constants, i, j)
    return replace(one, i=i.carrier, j=j.carrier, constants=constants)
