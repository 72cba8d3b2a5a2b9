"""Momentum that a system keeps: where, along which directions, and how it is computed.

A *part* is a set of bodies that joints and forces connect, the ground left out. Where nothing
connects a part with the ground, what joints, springs and drivers do in it cancels. Gravity and
constant forces keep the linear momentum across them, and gravity the whole angular momentum about
the centre of mass, since it acts there.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.design import number
from kousoku.codegen.dynamics.disjoint import DisjointSets
from kousoku.codegen.dynamics.matrix import Matrix
from kousoku.codegen.dynamics.program import Kept
from kousoku.codegen.dynamics.sums import summed
from kousoku.model import precise
from kousoku.model.mechanism import GROUND_INDEX

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from kousoku.codegen.dynamics.bodies import BodyBlocks
    from kousoku.codegen.dynamics.recorder import Block, Recorder
    from kousoku.codegen.dynamics.traces import Trace
    from kousoku.model.mechanism import ForceElement, System, Vector

AXES: tuple[Vector, Vector, Vector] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
#: Vectors whose angle is smaller count as parallel [rad].
PARALLEL = 1e-9


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
    gravity = [system.gravity] + [
        axis for axis, law in zip(AXES, system.gravity_law, strict=True) if law
    ]
    loads_of: dict[int, list[ForceElement]] = {}
    for force in filter(_is_load, system.forces):
        loads_of.setdefault(force.j, []).append(force)
    found = []
    for bodies in _parts(system):
        if any(system.bodies[body].mass <= 0 for body in bodies):
            continue
        loads = [one for body in bodies for one in loads_of.get(body, ())]
        forces = [vector for one in loads for vector in _vectors(one, "force")]
        torques = [vector for one in loads for vector in _vectors(one, "torque")]
        turning = any(one.kind == "force_b" for one in loads)
        linear = () if turning else _across([*gravity, *forces])
        can_turn = any(not system.bodies[body].is_point for body in bodies) or len(bodies) > 1
        pushed = any(one.kind.startswith("force") for one in loads)
        turned = any(one.kind == "torque_b" for one in loads)
        angular = () if pushed or turned or not can_turn else _across(torques)
        if is_planar:
            linear = tuple(one for one in linear if not one[2])
            angular = tuple(one for one in angular if one == AXES[2])
        if linear or angular:
            found.append(Kept(bodies, linear, angular))
    return tuple(found)


def _is_load(force: ForceElement) -> bool:
    return force.coordinate < 0 and force.kind.partition("_")[0] in {"force", "torque"}


def _vectors(force: ForceElement, kind: str) -> list[Vector]:
    """Return what a force or torque in frame O is the sum of."""
    if force.kind != kind:
        return []
    return [(x, y, z) for name, (x, y, z) in force.constants if name != "s_j_b"]


def _parts(system: System) -> Iterator[tuple[int, ...]]:
    """Yield the bodies of each part that nothing connects with the ground."""
    groups: list[tuple[int, ...]] = [one.bodies for one in system.constraints]
    groups += [(one.i, one.j) for one in system.forces if not _is_load(one)]
    connected = DisjointSets(range(GROUND_INDEX, len(system.bodies)))
    for first, *rest in groups:
        for other in rest:
            connected.join(first, other)
    yield from (tuple(part) for part in connected.sets() if GROUND_INDEX not in part)


def _across(vectors: Sequence[Vector]) -> tuple[Vector, ...]:
    """Return unit vectors perpendicular to all of some vectors and to each other."""
    span: list[precise.Triple] = []
    for vector in vectors:
        rest = precise.triple(vector)
        size = precise.length(rest)
        for one in span:
            rest = precise.without(rest, one)
        if size and precise.length(rest) > PARALLEL * size:
            span.append(precise.unit(rest))
    if not span:
        return AXES
    if len(span) == 1:
        first = precise.across(span[0])
        return tuple(_rounded(one) for one in (first, precise.cross(span[0], first)))
    return (_rounded(precise.cross(*span)),) if len(span) == 2 else ()


def _rounded(vector: precise.Triple) -> Vector:
    x, y, z = precise.rounded(vector)
    return x, y, z


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
    """Momenta along directions. Blocks: the sum of all shares, 1/mass, then the directions.

    Parameters
    ----------
    linear : int
        How many directions are of the linear momentum; the others are of the angular one.
    """

    linear: int
    title: str = "momenta of a part"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Return p·n, then L·n with L = Σ(ρ × m u + A I ω′) − (Σ m ρ) × (Σ m u)/Σ m."""
        total, inverse, *directions = blocks
        momentum, first, second, spin = (total.select(range(k, k + 3)) for k in (0, 3, 6, 9))
        angular = spin - first.cross(second) @ inverse
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
        recorder.call(
            Along(len(one.linear)),
            *(summed(recorder, shares), recorder.constant((1 / mass,)), *directions),
            into=(target.part(at, one.count),),
        )
        at += one.count
