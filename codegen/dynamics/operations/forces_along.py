"""Forces along coordinates: f = Jᵀτ, where J is the Jacobian of the coordinate u.

A spring against it has τ = −k (u − u⁰) − c u̇ and the energy ½ k (u − u⁰)²; with a law of its own
τ is a formula of u − u⁰, u̇ and time, and has no energy.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.operations.forces import ELONGATION
from kousoku.codegen.dynamics.operations.formulas import formula_node
from kousoku.codegen.dynamics.recording.matrix import Matrix

if TYPE_CHECKING:
    from kousoku.codegen.dynamics.recording.traces import Trace


@dataclass(frozen=True, slots=True)
class Push:
    """M⁻¹f of a force along a coordinate, and its power.

    Blocks: J and the diagonal of M⁻¹ of body i, those of body j, the rate u̇, τ.
    """

    title: str = "force along a coordinate"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Return what it adds to the acceleration of each coordinate of i and j; τ u̇."""
        left, weights_i, right, weights_j, rate, tau = blocks
        return left.scaled(weights_i).T @ tau, right.scaled(weights_j).T @ tau, rate @ tau


@dataclass(frozen=True, slots=True)
class Resist:
    """M⁻¹f of a spring and damper against a coordinate, and the power of the damper.

    Blocks: J and the diagonal of M⁻¹ of body i, those of body j, the value u and the rate u̇,
    stiffness, damping and free value; of a law of its own its unit and the free value, then value
    and unit of each name that it may depend on beside u − u⁰ and u̇.

    Parameters
    ----------
    law : str
        τ as a formula, with the opposite sign; empty where linear.
    names : tuple of str
        What it may depend on beside u − u⁰ and u̇.
    works : bool
        Whether the power is wanted.
    """

    law: str
    names: tuple[str, ...]
    works: bool
    title: str = "spring against a coordinate"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Return what it adds to the acceleration of each coordinate of i and j; its power."""
        left, weights_i, right, weights_j, value, rate, *given = blocks
        if self.law:
            unit, free, *rest = given
            one = Matrix(trace.graph, ((trace.graph.const(1),),), 1)
            own = [value - free, one, rate, one, *rest]
            node = formula_node(trace, self.law, (*ELONGATION, *self.names), own)
            moment = damped = unit @ Matrix(trace.graph, ((node,),), 1)
        else:
            stiffness, damping, free = given
            damped = damping @ rate
            moment = stiffness @ (value - free) + damped
        added = (-(left.scaled(weights_i).T @ moment), -(right.scaled(weights_j).T @ moment))
        return (*added, -(damped @ rate)) if self.works else added


@dataclass(frozen=True, slots=True)
class Held:
    """Energy of a spring against a coordinate. Blocks: u, stiffness, damping, free value."""

    title: str = "energy of a spring against a coordinate"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Return (0, ½ k (u − u⁰)²)."""
        value, stiffness, _, free = blocks
        graph = trace.graph
        (energy,) = (stiffness @ (value - free) @ (value - free)).flat
        half = graph.div(energy, graph.const(2))
        return (Matrix(graph, ((graph.const(0),), (half,)), 1),)
