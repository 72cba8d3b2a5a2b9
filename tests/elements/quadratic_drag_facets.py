"""A force that is not shipped, as a program and its analyses know it: quadratic drag on a point."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.elements.facets import ForceFacets
from kousoku.codegen.dynamics.operations.applied_forces import accelerations, at_point, column_of
from kousoku.codegen.dynamics.operations.heights import is_level
from kousoku.codegen.dynamics.operations.mechanics import share
from kousoku.codegen.dynamics.recording.recorder import column
from tests.elements.quadratic_drag import Drag

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from kousoku.codegen.dynamics.checking.newton_euler import (
        AppliedForces,
        BodyMotion,
        NewtonEulerEquations,
    )
    from kousoku.codegen.dynamics.composition.record_forces import ForceRecorder
    from kousoku.codegen.dynamics.operations.jets import Jet
    from kousoku.codegen.dynamics.recording.matrix import Matrix
    from kousoku.codegen.dynamics.recording.recorder import SlotMatrix
    from kousoku.codegen.dynamics.recording.traces import Trace
    from kousoku.model.mechanics.multibody import System
    from kousoku.model.numbers.real import Real


@dataclass(frozen=True, slots=True)
class DragEffect:
    """M⁻¹f of a drag, and its power.

    Blocks: p, A, v, ω′ and the diagonal of M⁻¹ of the body, the point, c.
    """

    columns: tuple[int, ...]
    title: str = "quadratic drag"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Share of the drag in the acceleration of each coordinate, and its power F·v_P."""
        p, orientation, v, omega, weights, point, coefficient = blocks
        share(trace, p, orientation)
        velocity = v + orientation @ omega.cross(point)
        (square,) = (velocity.T @ velocity).flat
        force = -(velocity @ (coefficient @ column_of(trace, trace.graph.sqrt(square))))
        forces = at_point(trace, p.flat, point, force)
        return accelerations(trace, forces, self.columns, weights), force.T @ velocity


class DragFacets(ForceFacets[Drag]):
    """Quadratic drag on a point."""

    is_carried = True

    def effect(self, tasks: ForceRecorder) -> tuple[SlotMatrix, ...]:
        """Record M⁻¹f of body j, and F·v_P."""
        j, constants = tasks.body(self.force.j), tasks.constants(self.force)
        blocks = (j.p, j.orientation, j.v_r, j.omega_b, j.inverse_mass, *constants)
        return (column(()), *tasks.recorder.call(DragEffect(j.columns), *blocks))

    def leaves_plane(self, system: System, normal: int) -> bool:
        """Whether the point is not level with the body."""
        point = dict(self.force.constants)["s_j_b"]
        return not is_level([point[normal]], [point])

    def by_definition(
        self,
        equations: NewtonEulerEquations,
        courses: Mapping[int, BodyMotion],
        names: Mapping[str, Jet],
        constants: Mapping[str, Sequence[Real]],
        loads: AppliedForces,
    ) -> tuple[Real, Real]:
        """Add −c |ṙ_P| ṙ_P at its point; return its power, and no energy."""
        (coefficient,), course = constants["coefficient"], courses[self.force.j]
        rate = [x.d for x in course.point(constants["s_j_b"])]
        speed = equations.digits.sqrt(sum(x * x for x in rate))
        force = [-coefficient * speed * x for x in rate]
        equations.apply_force(self.force.j, course, constants["s_j_b"], force, loads)
        return sum(a * b for a, b in zip(force, rate, strict=True)), 0
