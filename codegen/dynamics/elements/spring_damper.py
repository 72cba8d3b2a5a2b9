"""A spring and damper between two points: M⁻¹f, the power of its damper, ½ k (l − l⁰)²."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.elements.facets import Applied, ForceFacets
from kousoku.codegen.dynamics.operations.applied_forces import ELONGATION, accelerations, column_of
from kousoku.codegen.dynamics.operations.formulas import formula_node
from kousoku.codegen.dynamics.operations.heights import heights_of_ends, is_level
from kousoku.codegen.dynamics.operations.jets import Jet, dot, sqrt
from kousoku.codegen.dynamics.operations.mechanics import COLUMNS, frozen, inputs_of_body
from kousoku.model.elements.spring_damper import PointSpring
from kousoku.model.mechanics.multibody import RelativeCoordinate
from kousoku.model.numbers import precise

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from kousoku.codegen.dynamics.checking.newton_euler import (
        AppliedForces,
        BodyMotion,
        NewtonEulerEquations,
    )
    from kousoku.codegen.dynamics.composition.record_forces import ForceRecorder
    from kousoku.codegen.dynamics.elements.facets import Source
    from kousoku.codegen.dynamics.operations.placement import Placement
    from kousoku.codegen.dynamics.recording.matrix import Matrix
    from kousoku.codegen.dynamics.recording.recorder import SlotMatrix
    from kousoku.codegen.dynamics.recording.traces import Trace
    from kousoku.model.mechanics.multibody import System
    from kousoku.model.numbers.real import Real

#: Names of the constants of a spring, in their order.
ENDS, LAW = ("s_i_b", "s_j_b"), ("stiffness", "damping", "free_length")


@dataclass(frozen=True, slots=True)
class SpringEffect:
    """M⁻¹f of a spring and damper, and the power without potential energy.

    f = −T ∂l/∂q with T = k (l − l⁰) + c l̇ [N] and l = |d|, lecture 8.2, (8.8). Blocks: r (3,) [m],
    p (4,), A (3, 3), v (3,) [m/s] in frame O, ω′ (3,) [rad/s] in the principal frame and the
    diagonal of M⁻¹ of body i, those of body j, then the two ends s′ (3,) [m], stiffness, damping
    and free length; of a law of its own unit and free length, then value and unit of each name that
    it may depend on beside elongation and rate.

    Parameters
    ----------
    columns_i, columns_j : tuple of int
        Columns of each body that are coordinates: none of the ground.
    law : str
        Tension as a formula, empty where linear.
    names : tuple of str
        Names that it depends on beside elongation and rate.
    works : bool
        Whether its power is wanted.
    """

    columns_i: tuple[int, ...]
    columns_j: tuple[int, ...]
    law: str
    names: tuple[str, ...]
    works: bool
    title: str = "spring and damper"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Accelerations (c, 1) of the coordinates of i and j; power (1, 1) [W], −c l̇² if linear."""
        (*i, inverse_mass_i), (*j, inverse_mass_j) = blocks[:6], blocks[6:12]
        state = inputs_of_body(trace, "i", *i) | inputs_of_body(trace, "j", *j)
        state |= dict(zip(ENDS, blocks[12:14], strict=True))
        length = _inline(trace, "length", state)
        if self.law:
            tension = damped = self._tension(trace, length, *blocks[14:])
        else:
            law = dict(zip(LAW, blocks[14:], strict=True))
            tension = _inline(trace, "law", length | law)["T"]
            damped = law["damping"] @ length["l_dot"]
        force = _inline(trace, "force", state | {"T": tension})["force"].flat
        effect = (
            accelerations(trace, force[:COLUMNS], self.columns_i, inverse_mass_i),
            accelerations(trace, force[COLUMNS:], self.columns_j, inverse_mass_j),
        )
        if not self.works:
            return effect
        return *effect, -(damped @ length["l_dot"])

    def _tension(self, trace: Trace, length: dict[str, Matrix], *constants: Matrix) -> Matrix:
        """Tension [N] by the formula."""
        unit, free, *others = constants
        elongation = length["l"] - free
        arguments = [elongation, unit, length["l_dot"], unit, *others]
        value = formula_node(trace, self.law, (*ELONGATION, *self.names), arguments)
        return unit @ column_of(trace, value)


@dataclass(frozen=True, slots=True)
class SpringLength:
    """Length of a spring and its rate. Blocks: r, p, v and ω′ of both bodies, then the two ends.

    Units and frames are those of :class:`SpringEffect`: r [m] in frame O, s′ in the principal
    frame.
    """

    title: str = "length of a spring"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Length l = |d| (1,) [m] and its derivative by time l̇ = d·ḋ/l (1,) [m/s]."""
        ends = (f"{name}_{body}" for body in "ij" for name in ("r", "p", "v", "omega"))
        names = (name + "_b" if "omega" in name else name for name in (*ends, *ENDS))
        length = _inline(trace, "length", dict(zip(names, blocks, strict=True)))
        return length["l"], length["l_dot"]


@dataclass(frozen=True, slots=True)
class SpringEnergy:
    """Potential energy of a spring. Blocks: r and p of both bodies, the constants.

    r (3,) [m] is in frame O, the ends s′ (3,) [m] in the principal frames; k [N/m], c, l⁰ [m].
    """

    title: str = "energy of spring_damper"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Energies (0, V) (2,) [J]: V = ½ k (l − l⁰)²."""
        zero = trace.graph.const(0)
        positions = dict(zip(("r_i", "p_i", "r_j", "p_j", *ENDS), blocks[:6], strict=True))
        still = column_of(trace, zero, zero, zero)
        motion = dict.fromkeys(("v_i", "omega_i_b", "v_j", "omega_j_b"), still)
        length = _inline(trace, "length", positions | motion)
        law = dict(zip(LAW, blocks[6:], strict=True))
        (energy,) = _inline(trace, "law", length | law)["V"].flat
        return (column_of(trace, zero, energy),)


class SpringFacets(ForceFacets[PointSpring]):
    """A spring and damper between two points: T = k (l − l⁰) + c l̇ [N] draws them together."""

    is_carried = True

    def effect(self, tasks: ForceRecorder) -> tuple[SlotMatrix, ...]:
        """M⁻¹f of both bodies, and the power without potential energy, recorded."""
        constants = tasks.constants(self.force)
        i, j = tasks.body(self.force.i), tasks.body(self.force.j)
        ends = [
            block
            for body in (i, j)
            for block in (
                *(body.r, body.p, body.orientation),
                *(body.v_r, body.omega_b, body.inverse_mass),
            )
        ]
        names, arguments = tasks.law(self.force)
        operation = SpringEffect(
            i.columns, j.columns, self.force.law, names, self.force.is_nonconservative
        )
        return tasks.recorder.call(operation, *ends, *constants, *arguments)

    def energy(self, tasks: ForceRecorder) -> SlotMatrix:
        """Energies (0, ½ k (l − l⁰)²) (2,) [J], recorded."""
        constants = tasks.constants(self.force)
        i, j = tasks.body(self.force.i), tasks.body(self.force.j)
        return tasks.recorder.call(SpringEnergy(), i.r, i.p, j.r, j.p, *constants)[0]

    def elongation(
        self, tasks: ForceRecorder
    ) -> tuple[SlotMatrix, SlotMatrix, SlotMatrix, SlotMatrix]:
        """Length l [m] and its rate [m/s], recorded; l⁰ and the unit of its law: (1,) each."""
        start, end, *law, free = tasks.constants(self.force)
        unit = law[0] if self.force.law else tasks.recorder.constant((1,))
        bodies = (tasks.body(self.force.i), tasks.body(self.force.j))
        ends = [block for x in bodies for block in (x.r, x.p, x.v_r, x.omega_b)]
        length, rate = tasks.recorder.call(SpringLength(), *ends, start, end)
        return length, rate, free, unit

    def leaves_plane(self, system: System, normal: int) -> bool:
        """Whether its ends are not level with the bodies and each other."""
        heights = heights_of_ends(system, self.force, normal)
        return not is_level(heights, [values for _, values in self.force.constants])

    def resting_energy(self, i: Placement, j: Placement) -> Real:
        """Energy ½ k (l − l⁰)² in one body [J]."""
        constants = dict(self.force.constants)
        end = precise.triple(j.point(constants["s_j_b"]))
        start = precise.triple(i.point(constants["s_i_b"]))
        length = precise.length(precise.subtract(end, start))
        (stiffness,), (free,) = constants["stiffness"], constants["free_length"]
        energy: Real = precise.number(stiffness) * (length - precise.number(free)) ** 2 / 2
        return energy

    def applied(self) -> Applied:
        """Nothing applied: its effects on both bodies cancel."""
        return Applied()

    def source(self, system: System) -> Source:
        """Distance of its ends, along which it pulls."""
        ends = self.force.constants[: len(ENDS)]
        return RelativeCoordinate(self.force.name, "length", self.force.i, self.force.j, ends)

    def _across(
        self, courses: Mapping[int, BodyMotion], inputs: Mapping[str, Sequence[Real]]
    ) -> list[Jet]:
        """Vector d (3,) [m] from one end to the other along a motion, frame O."""
        start = courses[self.force.i].point(inputs["s_i_b"])
        end = courses[self.force.j].point(inputs["s_j_b"])
        return [b - a for a, b in zip(start, end, strict=True)]

    def length_by_definition(
        self,
        equations: NewtonEulerEquations,
        courses: Mapping[int, BodyMotion],
        constants: Mapping[str, Sequence[Real]],
    ) -> tuple[Jet, Real]:
        """Distance l = |d| [m] of the ends, and l⁰."""
        d = self._across(courses, constants)
        (free,) = constants["free_length"]
        return sqrt(dot(d, d), equations.digits), free

    def by_definition(
        self,
        equations: NewtonEulerEquations,
        courses: Mapping[int, BodyMotion],
        names: Mapping[str, Jet],
        constants: Mapping[str, Sequence[Real]],
        loads: AppliedForces,
    ) -> tuple[Real, Real]:
        """Add the tension along the line; return the power of its damper, and ½ k (l − l⁰)²."""
        force, d = self.force, self._across(courses, constants)
        length, free = self.length_by_definition(equations, courses, constants)
        elongation = length - Jet(free)
        energy: Real = 0
        if force.law:
            (unit,) = constants["unit"]
            arguments = {"x": Jet(elongation.x / unit), "v": Jet(length.d / unit)}
            tension = damped = unit * equations.value(force.law, {**names, **arguments}).x
        else:
            (stiffness,), (damping,) = constants["stiffness"], constants["damping"]
            damped = damping * length.d
            tension = stiffness * elongation.x + damped
            energy = stiffness * elongation.x**2 / 2
        pull = [tension * x.x / length.x for x in d]
        i, j = courses[force.i], courses[force.j]
        equations.apply_force(force.i, i, constants["s_i_b"], pull, loads)
        equations.apply_force(force.j, j, constants["s_j_b"], [-x for x in pull], loads)
        return -damped * length.d, energy


def _inline(trace: Trace, kernel: str, inputs: dict[str, Matrix]) -> dict[str, Matrix]:
    """Rebuild a kernel of the spring; return its outputs as columns."""
    nodes = {name: block.flat for name, block in inputs.items()}
    outputs = trace.inline(frozen("spring_damper", kernel), nodes)
    return {name: column_of(trace, *flat) for name, flat in outputs.items()}
