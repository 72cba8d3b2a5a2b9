"""Momentum that a system keeps: where, along which directions, and how it is computed.

A *part* is a set of bodies that joints and forces connect, the ground left out: what joints,
springs and drivers do in it cancels. What is left is gravity, constant forces, and what the ground
can do through the joints and forces at it, see
:mod:`~kousoku.codegen.dynamics.composition.contacts`. Linear momentum is constant along directions
in which none of them acts, angular momentum about an axis about which none has a moment: an axis
through the centre of mass, or through a point of the ground.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.composition.contacts import (
    AXES,
    Axes,
    contacts_of,
    free_of_force,
    free_of_moment,
)
from kousoku.codegen.dynamics.elements.forces import facets_of
from kousoku.codegen.dynamics.operations.sums import summed
from kousoku.codegen.dynamics.recording.design import number
from kousoku.codegen.dynamics.recording.disjoint import DisjointSets
from kousoku.codegen.dynamics.recording.matrix import Matrix
from kousoku.codegen.dynamics.recording.program import Kept
from kousoku.model.mechanism import GROUND_INDEX

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from kousoku.codegen.dynamics.composition.bodies import BodyBlocks
    from kousoku.codegen.dynamics.composition.contacts import Contact
    from kousoku.codegen.dynamics.elements.facets import Applied
    from kousoku.codegen.dynamics.recording.recorder import Block, Recorder
    from kousoku.codegen.dynamics.recording.traces import Trace
    from kousoku.model.mechanism import System, Vector

#: The axis of a plane may be given either way.
DOWN = (0.0, 0.0, -1.0)


def kept_of(system: System, *, is_planar: bool) -> tuple[Kept, ...]:
    """Return what the parts of a system keep; parts that keep nothing are not listed.

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
    applied: dict[int, list[Applied]] = {}
    for force in system.forces:
        for body in {force.i, force.j} - {GROUND_INDEX}:
            applied.setdefault(body, []).append(facets_of(force).applied())
    found = []
    for bodies in _parts(system):
        if any(system.bodies[body].mass <= 0 for body in bodies):
            continue
        of_ground = [one for body in bodies for one in contacts.get(body, ())]
        acting = [one for body in bodies for one in applied.get(body, ())]
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
    system: System, contacts: Sequence[Contact], applied: Sequence[Applied]
) -> tuple[tuple[Vector, ...], Axes]:
    """Return directions along which no force acts on a part, and about which no moment does."""
    laws = zip(AXES, system.gravity_law, strict=True)
    gravity = [system.gravity, *(axis for axis, law in laws if law)]
    forces = [vector for one in applied for vector in one.forces or ()]
    torques = [vector for one in applied for vector in one.torques or ()]
    if any(one.forces is None for one in applied):
        return (), Axes()
    linear = free_of_force(contacts, [*gravity, *forces])
    if any(one.torques is None for one in applied):
        return linear, Axes()
    return linear, free_of_moment(contacts, forces, gravity, torques)


def _parts(system: System) -> Iterator[tuple[int, ...]]:
    """Yield the bodies of each part: those that joints and forces connect, the ground left out."""
    groups: list[tuple[int, ...]] = [one.bodies for one in system.constraints]
    groups += [(one.i, one.j) for one in system.forces]
    connected = DisjointSets(range(len(system.bodies)))
    for group in groups:
        first, *rest = (body for body in group if body != GROUND_INDEX)
        for other in rest:
            connected.join(first, other)
    yield from (tuple(part) for part in connected.sets())


@dataclass(frozen=True, slots=True)
class Share:
    """What a body has of the momenta of its part.

    Blocks: r, A, v and ω′, mass and moments; then r and v of the first body of the part, from where
    places and velocities are counted, so that few digits cancel.
    """

    title: str = "momentum"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Return m v, m ρ, m u, and ρ × m u + A I ω′ (12,), with ρ and u from the first body."""
        r, orientation, v, omega, mass, moments, origin, drift = blocks
        momentum, arm = v @ mass, r - origin
        first, second = arm @ mass, (v - drift) @ mass
        mul = trace.graph.mul
        own = Matrix(
            trace.graph,
            tuple((mul(a, b),) for a, b in zip(moments.flat, omega.flat, strict=True)),
            1,
        )
        spin = arm.cross(second) + orientation @ own
        rows = (*momentum.rows, *first.rows, *second.rows, *spin.rows)
        return (Matrix(trace.graph, rows, 1),)


@dataclass(frozen=True, slots=True)
class Along:
    """Momenta along directions.

    Blocks: the sum of all shares, 1/mass, r and v of the first body of the part, the point of the
    ground, then the directions.

    Parameters
    ----------
    linear : int
        How many directions are of the linear momentum; the others are of the angular one.
    is_central : bool
        Whether angular momentum is about the centre of mass, else it is about the point.
    """

    linear: int
    is_central: bool
    title: str = "momenta of a part"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Return p·n, then L·n, with ρ and u from the first body in S = Σ(ρ × m u + A I ω′).

        About the centre of mass L = S − (Σ m ρ) × (Σ m u)/Σ m; about a point o of the ground
        L = S + (Σ m ρ) × v + (r − o) × p, with r and v of the first body.
        """
        total, inverse, r, v, point, *directions = blocks
        momentum, first, second, spin = (total.select(range(k, k + 3)) for k in (0, 3, 6, 9))
        if self.is_central:
            angular = spin - first.cross(second) @ inverse
        else:
            angular = spin + first.cross(v) + (r - point).cross(momentum)
        rows = [
            (one.T @ (momentum if k < self.linear else angular)).rows[0]
            for k, one in enumerate(directions)
        ]
        return (Matrix(trace.graph, tuple(rows), 1),)


def record_momenta(
    recorder: Recorder,
    system: System,
    kept: Sequence[Kept],
    body: Callable[[int], BodyBlocks],
) -> None:
    """Record the segment ``momentum``, which writes the region ``momenta`` part by part.

    Parameters
    ----------
    recorder : Recorder
        The program.
    system : System
        The scene.
    kept : sequence of Kept
        What its parts keep: there is one at least.
    body : callable
        Returns the blocks of a body by its index.
    """
    target = recorder.region("momenta", sum(one.count for one in kept))
    recorder.begin("momentum")
    at = 0
    for one in kept:
        origin = body(one.bodies[0])
        shares: list[Block] = []
        for index in one.bodies:
            blocks, moving = body(index), system.bodies[index]
            numbers = [recorder.constant((moving.mass,)), recorder.constant(moving.inertia)]
            own = (blocks.r, blocks.orientation, blocks.v_r, blocks.omega_b, *numbers)
            shares += recorder.call(Share(), *own, origin.r, origin.v_r)
        mass = sum(number(system.bodies[index].mass) for index in one.bodies)
        directions = [recorder.constant(vector) for vector in (*one.linear, *one.angular)]
        known = (origin.r, origin.v_r, recorder.constant(one.about or (0.0, 0.0, 0.0)))
        recorder.call(
            Along(len(one.linear), one.about is None),
            *(summed(recorder, shares), recorder.constant((1 / mass,)), *known, *directions),
            into=(target.part(at, one.count),),
        )
        at += one.count
