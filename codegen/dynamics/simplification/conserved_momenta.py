"""Momenta that a system conserves: of which bodies, along which directions, about which axes.

A *part* is a set of bodies that joints and forces connect, the ground left out: what joints,
springs and drivers do in it cancels. What is left is gravity, constant forces, and what the ground
can do through the joints and forces at it, see
:mod:`~kousoku.codegen.dynamics.simplification.contacts`. Linear momentum is constant along
directions in which none of them acts, angular momentum about an axis about which none has a moment:
an axis through the centre of mass, or through a point of the ground.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.recording.disjoint import DisjointSets
from kousoku.codegen.dynamics.recording.program import Kept
from kousoku.codegen.dynamics.simplification.contacts import (
    AXES,
    Axes,
    contacts_of,
    free_of_force,
    free_of_moment,
)
from kousoku.model.mechanism import GROUND_INDEX

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from kousoku.codegen.dynamics.simplification.contacts import Contact
    from kousoku.model.mechanism import ForceElement, System, Vector

#: The axis of a plane may be given either way.
DOWN = (0.0, 0.0, -1.0)


def conserved_momenta(system: System, *, is_planar: bool) -> tuple[Kept, ...]:
    """Momenta that the parts of a system conserve; parts that conserve none are not listed.

    Parameters
    ----------
    system : System
        The scene.
    is_planar : bool
        Whether its bodies move in planes parallel to the xy-plane: what is constant for that reason
        does not count.
    """
    contacts: dict[int, list[Contact]] = {}
    for body, contact in contacts_of(system):
        contacts.setdefault(body, []).append(contact)
    loads: dict[int, list[ForceElement]] = {}
    for force in filter(_is_load, system.forces):
        loads.setdefault(force.j, []).append(force)
    found = []
    for bodies in _parts(system):
        if any(system.bodies[body].mass <= 0 for body in bodies):
            continue
        of_ground = [one for body in bodies for one in contacts.get(body, ())]
        acting = [one for body in bodies for one in loads.get(body, ())]
        linear, axes = _free(system, of_ground, acting)
        angular = axes.directions
        if axes.about is None and len(bodies) == 1 and system.bodies[bodies[0]].is_point:
            angular = ()
        if is_planar:
            linear = tuple(one for one in linear if not one[2])
            angular = tuple(one for one in angular if one in (AXES[2], DOWN))
        if linear or angular:
            found.append(Kept(bodies, linear, angular, axes.about if angular else None))
    return tuple(found)


def _free(
    system: System, contacts: Sequence[Contact], loads: Sequence[ForceElement]
) -> tuple[tuple[Vector, ...], Axes]:
    """Directions along which no force acts on a part, and about which no moment does."""
    laws = zip(AXES, system.gravity_law, strict=True)
    gravity = [system.gravity, *(axis for axis, law in laws if law)]
    forces = [vector for one in loads for vector in _vectors(one, "force")]
    torques = [vector for one in loads for vector in _vectors(one, "torque")]
    kinds = {one.kind for one in loads}
    linear = () if "force_b" in kinds else free_of_force(contacts, [*gravity, *forces])
    if kinds & {"force_b", "torque_b"}:
        return linear, Axes()
    return linear, free_of_moment(contacts, forces, gravity, torques)


def _is_load(force: ForceElement) -> bool:
    return force.coordinate < 0 and force.kind.partition("_")[0] in {"force", "torque"}


def _vectors(force: ForceElement, kind: str) -> list[Vector]:
    """Vectors that a force or torque in frame O is the sum of."""
    if force.kind != kind:
        return []
    return [(x, y, z) for name, (x, y, z) in force.constants if name != "s_j_b"]


def _parts(system: System) -> Iterator[tuple[int, ...]]:
    """Bodies of each part: those that joints and forces connect, the ground left out."""
    groups: list[tuple[int, ...]] = [one.bodies for one in system.constraints]
    groups += [(one.i, one.j) for one in system.forces if not _is_load(one)]
    connected = DisjointSets(range(len(system.bodies)))
    for group in groups:
        first, *rest = (body for body in group if body != GROUND_INDEX)
        for other in rest:
            connected.join(first, other)
    yield from (tuple(part) for part in connected.sets())
