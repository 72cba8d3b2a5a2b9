"""A spring against a coordinate u: τ = −k (u − u⁰) − c u̇, with the energy ½ k (u − u⁰)².

With a law of its own τ is minus a formula of u − u⁰, u̇ and time, and has no energy.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.elements.along import OnCoordinate
from kousoku.codegen.dynamics.elements.constraints import facets_of_kind
from kousoku.codegen.dynamics.operations.applied_forces import ELONGATION, column_of
from kousoku.codegen.dynamics.operations.formulas import formula_node
from kousoku.codegen.dynamics.operations.heights import FLAT, at_start
from kousoku.codegen.dynamics.operations.jets import Jet
from kousoku.model.elements.coordinate_spring import CoordinateSpring

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from kousoku.codegen.dynamics.checking.newton_euler import (
        AppliedForces,
        BodyMotion,
        NewtonEulerEquations,
    )
    from kousoku.codegen.dynamics.composition.record_forces import ForceRecorder
    from kousoku.codegen.dynamics.recording.matrix import Matrix
    from kousoku.codegen.dynamics.recording.recorder import SlotMatrix
    from kousoku.codegen.dynamics.recording.traces import Trace
    from kousoku.model.mechanics.multibody import System
    from kousoku.model.numbers.real import Real


@dataclass(frozen=True, slots=True)
class CoordinateSpringEffect:
    """M⁻¹f of a spring and damper against a coordinate, and the power of the damper.

    f = Jᵀτ, τ = −k (u − u⁰) − c u̇ [N or N m]. Blocks: J (1, c), columns δr in frame O and δθ′ in
    the principal frame, and the diagonal of M⁻¹ (1, c) of body i, those of body j, the value u [m
    or rad] and the rate u̇, stiffness k, damping c and free value u⁰; of a law of its own its unit
    and the free value, then value and unit of each name that it may depend on beside u − u⁰ and u̇.

    Parameters
    ----------
    law : str
        −τ as a formula; empty where linear.
    names : tuple of str
        Names that it depends on beside u − u⁰ and u̇.
    works : bool
        Whether the power is wanted.
    """

    law: str
    names: tuple[str, ...]
    works: bool
    title: str = "spring against a coordinate"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Accelerations M⁻¹Jᵀτ (c, 1) of the coordinates of i and j; its power (1, 1) [W]."""
        left, inverse_mass_i, right, inverse_mass_j, value, rate, *constants = blocks
        if self.law:
            unit, free, *others = constants
            unity = column_of(trace, trace.graph.const(1))
            arguments = [value - free, unity, rate, unity, *others]
            node = formula_node(trace, self.law, (*ELONGATION, *self.names), arguments)
            moment = damped = unit @ column_of(trace, node)
        else:
            stiffness, damping, free = constants
            damped = damping @ rate
            moment = stiffness @ (value - free) + damped
        effect = (
            -(left.scaled(inverse_mass_i).T @ moment),
            -(right.scaled(inverse_mass_j).T @ moment),
        )
        return (*effect, -(damped @ rate)) if self.works else effect


@dataclass(frozen=True, slots=True)
class CoordinateSpringEnergy:
    """Energy of a spring against a coordinate. Blocks: u, stiffness, damping, free value."""

    title: str = "energy of a spring against a coordinate"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Energies (0, ½ k (u − u⁰)²) (2,) [J]."""
        value, stiffness, _, free = blocks
        graph = trace.graph
        (energy,) = (stiffness @ (value - free) @ (value - free)).flat
        return (column_of(trace, graph.const(0), graph.div(energy, graph.const(2))),)


class CoordinateSpringFacets(OnCoordinate[CoordinateSpring]):
    """A spring and damper against a coordinate: τ = −k (u − u⁰) − c u̇."""

    def effect(self, tasks: ForceRecorder) -> tuple[SlotMatrix, ...]:
        """M⁻¹Jᵀτ of both bodies, and the power without potential energy, recorded."""
        constants = tasks.constants(self.force)
        ends = self.jacobians(tasks)
        rate = self.rate(tasks)
        names, arguments = tasks.law(self.force)
        operation = CoordinateSpringEffect(self.force.law, names, self.force.is_nonconservative)
        value = tasks.coordinates.value(self.force.coordinate)
        return tasks.recorder.call(operation, *ends, value, rate, *constants, *arguments)

    def energy(self, tasks: ForceRecorder) -> SlotMatrix:
        """Energy (0, ½ k (u − u⁰)²) (2,) [J], recorded."""
        constants = tasks.constants(self.force)
        value = tasks.coordinates.value(self.force.coordinate)
        return tasks.recorder.call(CoordinateSpringEnergy(), value, *constants)[0]

    def elongation(
        self, tasks: ForceRecorder
    ) -> tuple[SlotMatrix, SlotMatrix, SlotMatrix, SlotMatrix]:
        """Value u and rate u̇, recorded; u⁰ and 1, since both are in rad or m: (1,) each."""
        _, free = tasks.constants(self.force)
        value = tasks.coordinates.value(self.force.coordinate)
        return value, self.rate(tasks), free, tasks.recorder.constant((1,))

    def leaves_plane(self, system: System, normal: int) -> bool:
        """Whether it leads out of the plane.

        Across the plane, motions in the plane do not change a coordinate: a spring that has no
        force at the start then has none for good.
        """
        coordinate, force = system.coordinates[self.force.coordinate], self.force
        leaves = facets_of_kind(coordinate.kind).leaves_plane(system, coordinate, normal)
        if leaves is not None:
            return leaves
        if force.law or force.formulas:
            return True
        (free,) = dict(force.constants)["free"]
        size = max(abs(x) for _, values in coordinate.constants for x in values)
        return abs(at_start(system, coordinate) - free) > FLAT * max(1.0, size)

    def length_by_definition(
        self,
        equations: NewtonEulerEquations,
        courses: Mapping[int, BodyMotion],
        constants: Mapping[str, Sequence[Real]],
    ) -> tuple[Jet, Real]:
        """Value u of the coordinate, and u⁰, in rad or m."""
        return equations.coordinate(self.force.coordinate, courses), constants["free"][0]

    def by_definition(
        self,
        equations: NewtonEulerEquations,
        courses: Mapping[int, BodyMotion],
        names: Mapping[str, Jet],
        constants: Mapping[str, Sequence[Real]],
        loads: AppliedForces,
    ) -> tuple[Real, Real]:
        """Add Jᵀτ; return the power without potential energy, and ½ k (u − u⁰)²."""
        force = self.force
        energy: Real = 0
        value, free = self.length_by_definition(equations, courses, constants)
        elongation = value.x - free
        if force.law:
            arguments = {"x": Jet(elongation), "v": Jet(value.d)}
            moment = constants["moment"][0]
            tau = damping = -moment * equations.value(force.law, {**names, **arguments}).x
        else:
            damping = -constants["damping"][0] * value.d
            tau = damping - constants["stiffness"][0] * elongation
            energy = constants["stiffness"][0] * elongation**2 / 2
        self.add(equations, courses, tau, loads)
        return damping * value.d, energy
