"""Conserved momenta of the parts of a system, as operations: a run watches them.

:mod:`~kousoku.codegen.dynamics.simplification.conserved_momenta` finds which they are.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.operations.sums import summed
from kousoku.codegen.dynamics.recording.design import number
from kousoku.codegen.dynamics.recording.matrix import Matrix

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from kousoku.codegen.dynamics.recording.program import ConservedMomenta
    from kousoku.codegen.dynamics.recording.recorder import Recorder, SlotMatrix
    from kousoku.codegen.dynamics.recording.traces import Trace
    from kousoku.codegen.dynamics.simplification.body_blocks import BodyBlocks
    from kousoku.model.mechanics.multibody import System


@dataclass(frozen=True, slots=True)
class BodyMomentum:
    """Share of a body in the momenta of its part, in frame O.

    Blocks: r (3,) [m], A (3, 3), v (3,) [m/s] and ω′ (3,) [rad/s] in the principal frame, mass [kg]
    and moments (3,) [kg m²]; then r and v of the first body of the part, to which positions
    and velocities are relative, so that few digits cancel.
    """

    title: str = "momentum"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Momenta m v, m ρ, m u, and ρ × m u + A I ω′ (12,), with ρ and u from the first body."""
        r, orientation, v, omega, mass, moments, origin, drift = blocks
        momentum, arm = v @ mass, r - origin
        first, second = arm @ mass, (v - drift) @ mass
        mul = trace.graph.mul
        spin_b = Matrix.of(trace.graph, map(mul, moments.flat, omega.flat))
        spin = arm.cross(second) + orientation @ spin_b
        rows = (*momentum.rows, *first.rows, *second.rows, *spin.rows)
        return (Matrix(trace.graph, rows, 1),)


@dataclass(frozen=True, slots=True)
class PartMomenta:
    """Momenta [kg m/s] and [kg m²/s] along directions of frame O.

    Blocks: the sum (12,) of the shares of bodies, 1/mass, r (3,) and v (3,) of the first body of
    the part, the point (3,) [m] of the ground, then the directions (3,).

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
        """Momenta p·n, then L·n, with ρ and u from the first body in S = Σ(ρ × m u + A I ω′).

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
            (direction.T @ (momentum if k < self.linear else angular)).rows[0]
            for k, direction in enumerate(directions)
        ]
        return (Matrix(trace.graph, tuple(rows), 1),)


def record_momenta(
    recorder: Recorder,
    system: System,
    conserved: Sequence[ConservedMomenta],
    body: Callable[[int], BodyBlocks],
) -> None:
    """Record the segment ``momentum``, which writes the region ``momenta`` part by part.

    p·n (k,) [kg m/s] with p = Σ m v, then L·n [kg m²/s] with L = Σ (r − o) × m v + A I′ω′, frame O.

    Parameters
    ----------
    recorder : Recorder
        The program.
    system : System
        The scene.
    conserved : sequence of ConservedMomenta
        Momenta that its parts conserve: one part at least.
    body : callable
        Returns the blocks of a body by its index.
    """
    target = recorder.region("momenta", sum(part.count for part in conserved))
    recorder.begin("momentum")
    first = 0
    for part in conserved:
        origin = body(part.bodies[0])
        shares: list[SlotMatrix] = []
        for index in part.bodies:
            blocks, moving = body(index), system.bodies[index]
            numbers = [recorder.constant((moving.mass,)), recorder.constant(moving.inertia)]
            state = (blocks.r, blocks.orientation, blocks.v_r, blocks.omega_b, *numbers)
            shares += recorder.call(BodyMomentum(), *state, origin.r, origin.v_r)
        mass = sum(number(system.bodies[index].mass) for index in part.bodies)
        directions = [recorder.constant(vector) for vector in (*part.linear, *part.angular)]
        reference = (origin.r, origin.v_r, recorder.constant(part.about or (0.0, 0.0, 0.0)))
        recorder.call(
            PartMomenta(len(part.linear), part.about is None),
            *(summed(recorder, shares), recorder.constant((1 / mass,)), *reference, *directions),
            into=(target.part(first, part.count),),
        )
        first += part.count
