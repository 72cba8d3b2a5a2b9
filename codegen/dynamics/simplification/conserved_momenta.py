"""Momenta that a system conserves: of which bodies, along which directions, about which axes.

A *part* is a set of bodies that joints and forces connect, the ground left out: forces of joints,
springs and drivers inside it cancel. There remain gravity, constant forces, and the reactions of
the ground through the joints and forces at it, see
:mod:`~kousoku.codegen.dynamics.simplification.ground_reactions`. Linear momentum is constant along
directions in which none of them acts, angular momentum about an axis about which none has a moment:
an axis through the centre of mass, or through a point of the ground.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.disjoint_sets import DisjointSets
from kousoku.codegen.dynamics.elements.force_facets import facets_of
from kousoku.codegen.dynamics.recording.program import ConservedMomenta
from kousoku.codegen.dynamics.simplification.ground_reactions import (
    AXES,
    Axes,
    free_of_force,
    free_of_moment,
    ground_reactions_of,
)
from kousoku.model.mechanics.multibody import GROUND_INDEX

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from kousoku.codegen.dynamics.elements.constraints import GroundReaction
    from kousoku.codegen.dynamics.elements.facets import Applied
    from kousoku.model.mechanics.multibody import System
    from kousoku.model.records.orientation import Vector

#: The normal of a plane may point either way.
DOWN = (0.0, 0.0, -1.0)


def conserved_momenta(system: System, *, is_planar: bool) -> tuple[ConservedMomenta, ...]:
    """Momenta that the parts of a system conserve; parts that conserve none are not listed.

    Along directions n (3,) [-] of frame O: p·n = const. where no force acts, p = Σ m v [kg m/s],
    L·n = const. where no moment does, L = Σ (r − o) × m v + A I′ω′ [kg m²/s].

    Parameters
    ----------
    system : System
        The scene.
    is_planar : bool
        Whether its bodies move in planes parallel to the xy-plane: momenta that are constant for
        that reason do not count.
    """
    reactions: dict[int, list[GroundReaction]] = {}
    for body, reaction in ground_reactions_of(system):
        reactions.setdefault(body, []).append(reaction)
    applied: dict[int, list[Applied]] = {}
    for force in system.forces:
        for body in {force.i, force.j} - {GROUND_INDEX}:
            applied.setdefault(body, []).append(facets_of(force).applied())
    momenta = []
    for bodies in _parts(system):
        if any(system.bodies[body].mass <= 0 for body in bodies):
            continue
        ground = [x for body in bodies for x in reactions.get(body, ())]
        acting = [x for body in bodies for x in applied.get(body, ())]
        linear, axes = _free_directions(system, ground, acting)
        angular = axes.directions
        if axes.about is None and len(bodies) == 1 and system.bodies[bodies[0]].is_point:
            angular = ()
        if is_planar:
            linear = tuple(n for n in linear if not n[2])
            angular = tuple(n for n in angular if n in (AXES[2], DOWN))
        if linear or angular:
            about = axes.about if angular else None
            momenta.append(ConservedMomenta(bodies, linear, angular, about))
    return tuple(momenta)


def _free_directions(
    system: System, reactions: Sequence[GroundReaction], applied: Sequence[Applied]
) -> tuple[tuple[Vector, ...], Axes]:
    """Directions along which no force acts on a part, and about which no moment does."""
    laws = zip(AXES, system.gravity_law, strict=True)
    gravity = [system.gravity, *(axis for axis, law in laws if law)]
    forces = [vector for force in applied for vector in force.forces or ()]
    torques = [vector for force in applied for vector in force.torques or ()]
    if any(force.forces is None for force in applied):
        return (), Axes()
    linear = free_of_force(reactions, [*gravity, *forces])
    if any(force.torques is None for force in applied):
        return linear, Axes()
    return linear, free_of_moment(reactions, forces, gravity, torques)


def _parts(system: System) -> Iterator[tuple[int, ...]]:
    """Bodies of each part: those that joints and forces connect, the ground left out."""
    groups: list[tuple[int, ...]] = [c.bodies for c in system.constraints]
    groups += [(f.i, f.j) for f in system.forces]
    connected = DisjointSets(range(len(system.bodies)))
    for group in groups:
        first, *others = (body for body in group if body != GROUND_INDEX)
        for other in others:
            connected.join(first, other)
    yield from (tuple(part) for part in connected.sets())
