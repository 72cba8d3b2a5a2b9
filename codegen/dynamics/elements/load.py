"""A force or a torque on a body: M⁻¹f, power, and −F·r of a constant force."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.elements.facets import Applied, ForceFacets
from kousoku.codegen.dynamics.operations.applied_forces import accelerations, at_point, column_of
from kousoku.codegen.dynamics.operations.heights import is_level
from kousoku.codegen.dynamics.operations.mechanics import frozen, share
from kousoku.codegen.dynamics.operations.placement import seen_from_carriers
from kousoku.codegen.dynamics.recording.recorder import column
from kousoku.model.elements.load import Load
from kousoku.model.numbers import precise

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from kousoku.codegen.dynamics.checking.newton_euler import (
        AppliedForces,
        BodyMotion,
        NewtonEulerEquations,
    )
    from kousoku.codegen.dynamics.composition.record_forces import ForceRecorder
    from kousoku.codegen.dynamics.operations.jets import Jet
    from kousoku.codegen.dynamics.operations.placement import Placement
    from kousoku.codegen.dynamics.recording.matrix import Matrix
    from kousoku.codegen.dynamics.recording.recorder import SlotMatrix
    from kousoku.codegen.dynamics.recording.traces import Trace
    from kousoku.model.mechanics.multibody import System
    from kousoku.model.numbers.real import Real


@dataclass(frozen=True, slots=True)
class LoadEffect:
    """M⁻¹f of a force or torque f = (F, s̃′AᵀF) or (0, N′), and its power.

    Blocks: p (4,), A (3, 3), v (3,) [m/s] in frame O, ω′ (3,) [rad/s] in the principal frame and
    the diagonal of M⁻¹ (1, c) of the body, of a force its point s′ (3,) [m], then vectors (3,) [N
    or N m] that are added up. The torque is that of three mass points, (torque-definition).

    Parameters
    ----------
    kind : str
        ``force``, ``force_b``, ``torque`` or ``torque_b``.
    columns : tuple of int
        The body's coordinates.
    works : bool
        Whether its power is wanted.
    """

    kind: str
    columns: tuple[int, ...]
    works: bool

    @property
    def title(self) -> str:
        """Name the kind."""
        return f"{self.kind} on a body"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Accelerations of the coordinates (c, 1); power F·v + N′·ω′ (1, 1) [W] if wanted."""
        p, orientation, v, omega, inverse_mass, *constants = blocks
        share(trace, p, orientation)
        point = constants.pop(0) if self.kind in ("force", "force_b") else None
        vector = sum(constants[1:], constants[0])
        zeros = (trace.graph.const(0),) * 3
        if self.kind == "torque":
            forces = (*zeros, *(orientation.T @ vector).flat)
        elif point is None:
            forces = (*zeros, *vector.flat)
        elif self.kind == "force":
            forces = at_point(trace, p.flat, point, vector)
        else:
            still = (trace.graph.const(1), *zeros)
            torque = at_point(trace, still, point, vector)[3:]
            forces = (*(orientation @ vector).flat, *torque)
        effect = (accelerations(trace, forces, self.columns, inverse_mass),)
        if not self.works:
            return effect
        mul, rates = trace.graph.mul, (*v.flat, *omega.flat)
        power = trace.graph.sum(mul(a, b) for a, b in zip(forces, rates, strict=True))
        return *effect, column_of(trace, power)


@dataclass(frozen=True, slots=True)
class LoadEnergy:
    """Potential energy of a constant force. Blocks: r and p of the body, the point, the force.

    r (3,) [m] and F (3,) [N] are in frame O, the point s′ (3,) [m] in the principal frame.
    """

    title: str = "energy of force"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Energies (0, V) (2,) [J]: V = −F·(r + A s′)."""
        graph = trace.graph
        r, p, point, force = blocks
        inputs = {"r": r.flat, "p": p.flat, "s_b": point.flat}
        position = trace.inline(frozen("rotation", "point"), inputs)["r_P"]
        work = graph.sum(graph.mul(a, b) for a, b in zip(force.flat, position, strict=True))
        return (column_of(trace, graph.const(0), graph.neg(work)),)


class LoadFacets(ForceFacets[Load]):
    """A force F at s′, f = (F, s̃′AᵀF), or a torque N, f = (0, AᵀN), on a body: (3,) [N, N m]."""

    is_carried = True

    def effect(self, tasks: ForceRecorder) -> tuple[SlotMatrix, ...]:
        """M⁻¹f of body j, and the power, recorded."""
        j = tasks.body(self.force.j)
        blocks = (j.p, j.orientation, j.v_r, j.omega_b, j.inverse_mass)
        operation = LoadEffect(self.force.kind, j.columns, self.force.is_nonconservative)
        constants = tasks.constants(self.force)
        return (column(()), *tasks.recorder.call(operation, *blocks, *constants))

    def energy(self, tasks: ForceRecorder) -> SlotMatrix:
        """Energies (0, −F·(r + A s′)) (2,) [J], recorded."""
        constants, j = tasks.constants(self.force), tasks.body(self.force.j)
        return tasks.recorder.call(LoadEnergy(), j.r, j.p, *constants)[0]

    def leaves_plane(self, system: System, normal: int) -> bool:
        """Whether a torque is not about the normal, or a force not in the plane."""
        constants = dict(self.force.constants)
        if self.force.is_torque:
            return any(x for row in constants.values() for k, x in enumerate(row) if k != normal)
        if any(vector[normal] for vector in self.force.vectors):
            return True
        return not is_level([constants["s_j_b"][normal]], list(constants.values()))

    def seen_from(self, i: Placement, j: Placement) -> Load:
        """Force on the body that carries its own; one that turns with a body is a vector of it."""
        constants = seen_from_carriers(self.force.constants, i, j, turning=self.force.is_body_fixed)
        return replace(self.force, i=i.carrier, j=j.carrier, constants=constants)

    def resting_energy(self, i: Placement, j: Placement) -> Real:
        """Energy −F·(r + A s′) of a force on the ground [J]."""
        constants = dict(self.force.constants)
        end = precise.triple(j.point(constants["s_j_b"]))
        energy: Real = -precise.dot(precise.triple(constants["force"]), end)
        return energy

    def applied(self) -> Applied:
        """Directions of its parts, any where it turns with the body."""
        vectors = None if self.force.is_body_fixed else self.force.vectors
        return Applied(torques=vectors) if self.force.is_torque else Applied(forces=vectors)

    def by_definition(
        self,
        equations: NewtonEulerEquations,
        courses: Mapping[int, BodyMotion],
        names: Mapping[str, Jet],
        constants: Mapping[str, Sequence[Real]],
        loads: AppliedForces,
    ) -> tuple[Real, Real]:
        """Add F at its point, or N; return F·ṙ_P or N·ω, and −F·r_P of its point."""
        force = self.force
        vectors = [values for name, values in constants.items() if name != "s_j_b"]
        vector = [sum(parts) for parts in zip(*vectors, strict=True)]
        course = courses[force.j]
        if force.is_body_fixed:
            vector = [x.x for x in course.vector(vector)]
        if force.is_torque:
            return equations.apply_torque(force.j, course, vector, loads), 0
        point = course.point(constants["s_j_b"])
        equations.apply_force(force.j, course, constants["s_j_b"], vector, loads)
        power = sum(a * x.d for a, x in zip(vector, point, strict=True))
        return power, -sum(a * x.x for a, x in zip(vector, point, strict=True))
