"""A force along a coordinate u: f = Jᵀτ, where J is the Jacobian of u."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.elements.constraints import facets_of_kind
from kousoku.codegen.dynamics.elements.facets import Applied, E, ForceFacets
from kousoku.model.elements.along import CoordinateForce

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from kousoku.codegen.dynamics.checking.newton_euler import (
        AppliedForces,
        BodyMotion,
        NewtonEulerEquations,
    )
    from kousoku.codegen.dynamics.composition.record_forces import ForceRecorder
    from kousoku.codegen.dynamics.elements.facets import Source
    from kousoku.codegen.dynamics.operations.jets import Jet
    from kousoku.codegen.dynamics.recording.matrix import Matrix
    from kousoku.codegen.dynamics.recording.recorder import SlotMatrix
    from kousoku.codegen.dynamics.recording.traces import Trace
    from kousoku.model.mechanics.multibody import System
    from kousoku.model.numbers.real import Real


@dataclass(frozen=True, slots=True)
class AlongEffect:
    """M⁻¹f of a force τ [N or N m] along a coordinate u, f = Jᵀτ, and its power.

    Blocks: J (1, c) and the diagonal of M⁻¹ (1, c) of body i, columns δr in frame O and δθ′ in the
    principal frame, those of body j, the rate u̇ [m/s or rad/s], τ.
    """

    title: str = "force along a coordinate"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Accelerations M⁻¹Jᵀτ (c, 1) of the coordinates of i and j; power τ u̇ (1, 1) [W]."""
        left, inverse_mass_i, right, inverse_mass_j, rate, tau = blocks
        return left.scaled(inverse_mass_i).T @ tau, right.scaled(inverse_mass_j).T @ tau, rate @ tau


class OnCoordinate(ForceFacets[E]):
    """Force along a coordinate, or spring against it.

    A force τ [N or N m] along u acts by Jᵀτ (c,), with u̇ = J v: δr in frame O, δθ′ in the
    principal frame.
    """

    is_carried = True

    def jacobians(self, tasks: ForceRecorder) -> list[SlotMatrix]:
        """Jacobian J (1, c) of body i and the diagonal of its M⁻¹ (1, c), then those of body j."""
        jacobian = tasks.coordinates.jacobian(self.force.coordinate)
        return [
            block
            for index in (self.force.i, self.force.j)
            for block in (jacobian[index], tasks.body(index).inverse_mass)
        ]

    def rate(self, tasks: ForceRecorder) -> SlotMatrix:
        """Rate u̇ = J v (1,) [m/s or rad/s]."""
        return tasks.coordinates.rate(self.force.coordinate, tasks.by_body)

    def leaves_plane(self, system: System, normal: int) -> bool:
        """Whether J leads out of the plane."""
        coordinate = system.coordinates[self.force.coordinate]
        return facets_of_kind(coordinate.kind).leaves_plane(system, coordinate, normal) is not False

    def applied(self) -> Applied:
        """Nothing applied: its effects on both bodies cancel."""
        return Applied()

    def source(self, system: System) -> Source:
        """Coordinate, in whose directions the ground pushes."""
        return system.coordinates[self.force.coordinate]

    def add(
        self,
        equations: NewtonEulerEquations,
        courses: Mapping[int, BodyMotion],
        tau: Real,
        loads: AppliedForces,
    ) -> None:
        """Add Jᵀτ: an entry of J is u̇ where that velocity alone is one."""
        ends = {body: courses[body] for body in (self.force.i, self.force.j)}
        for column, moving in equations.each_column(ends):
            loads.force[column] += tau * equations.coordinate(self.force.coordinate, moving).d


class AlongFacets(OnCoordinate[CoordinateForce]):
    """A force along a coordinate."""

    def effect(self, tasks: ForceRecorder) -> tuple[SlotMatrix, ...]:
        """M⁻¹Jᵀτ of both bodies, and τ u̇, recorded."""
        constants = tasks.constants(self.force)
        ends = self.jacobians(tasks)
        return tasks.recorder.call(AlongEffect(), *ends, self.rate(tasks), *constants)

    def by_definition(
        self,
        equations: NewtonEulerEquations,
        courses: Mapping[int, BodyMotion],
        names: Mapping[str, Jet],
        constants: Mapping[str, Sequence[Real]],
        loads: AppliedForces,
    ) -> tuple[Real, Real]:
        """Add Jᵀτ; return τ u̇, and no energy."""
        (tau,) = constants["force"]
        self.add(equations, courses, tau, loads)
        return tau * equations.coordinate(self.force.coordinate, courses).d, 0
