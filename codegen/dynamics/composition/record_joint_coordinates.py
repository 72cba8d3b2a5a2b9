"""The tasks of bodies that hang on the ground by one joint, with v = R u + β.

Such a body is put onto its joint wherever a position is moved, and its velocities are fitted to it
before those of other joints are looked at. Only the rows of other joints are solved for, with
C_q R for C_q and (Rᵀ M R)⁻¹ for M⁻¹:

    u̇ = (Rᵀ M R)⁻¹ Rᵀ (f − M η − C_qᵀ λ),  v̇ = R u̇ + η.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.operations.formulas import MatrixProduct
from kousoku.codegen.dynamics.operations.joint_projections import (
    AXIS,
    NOTHING,
    POINT,
    BiasAcceleration,
    DriverPower,
    DriverWrench,
    GroundJointBlocks,
    JointWrench,
    PrescribedValue,
    ProjectPosition,
    ProjectVelocity,
    ReduceForces,
)
from kousoku.codegen.dynamics.recording.recorder import SlotMatrix, column, zeros
from kousoku.codegen.dynamics.simplification.reduced_mass import (
    arms_of,
    inverse_of,
    is_principal,
    reduced_mass_matrix,
    shares_of,
)
from kousoku.model.numbers import precise

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from fractions import Fraction

    from kousoku.codegen.dynamics.composition.combinations import Combinations
    from kousoku.codegen.dynamics.composition.record_coordinates import CoordinateRecorder
    from kousoku.codegen.dynamics.recording.recorder import Recorder
    from kousoku.codegen.dynamics.simplification.body_blocks import BodyBlocks
    from kousoku.codegen.dynamics.simplification.ground_joints import (
        Prescribed,
        VelocityTransformation,
    )
    from kousoku.model.mechanics.multibody import MovingBody, System


@dataclass(slots=True)
class JointCoordinateRecorder:
    """Recorder of one body: v = R u + β, v̇ = R u̇ + η.

    v (c,) [m/s, rad/s] has the columns δr in frame O, δθ′ in the principal frame, R is (c, f).

    Parameters
    ----------
    one : VelocityTransformation
        How it hangs.
    system : System
        The scene.
    recorder : Recorder
        The program.
    body : callable
        Returns the blocks of a body.
    combinations : Combinations
        What records the formulas of drivers.
    """

    one: VelocityTransformation
    system: System
    recorder: Recorder
    body: Callable[[int], BodyBlocks]
    combinations: Combinations
    arm: SlotMatrix = field(default_factory=lambda: zeros(3, 0))

    @property
    def blocks(self) -> BodyBlocks:
        """The blocks of the body."""
        return self.body(self.one.body)

    @property
    def moving(self) -> MovingBody:
        """The body."""
        return self.system.bodies[self.one.body]

    @property
    def point(self) -> SlotMatrix:
        """The point s′ (3,) [m] of the joint in the body."""
        return self._vector(self.one.joint_b)

    @property
    def axis_b(self) -> SlotMatrix:
        """Axes a′ that it rotates about, by columns (3, rotations) [-]."""
        if self.one.rotates_about == POINT:
            return SlotMatrix((1, 0, 0, 0, 1, 0, 0, 0, 1), 3, 3)
        return self._vector(self.one.axis_b) if self.one.rotates_about != NOTHING else zeros(3, 0)

    def geometry(self) -> tuple[SlotMatrix, SlotMatrix]:
        """R (c, f) of what is free and (Rᵀ M R)⁻¹ (f, f); the arm A (s′ × a′) is recorded.

        That is the velocity (3, rotations) [m] of the centre of mass for each of them, frame O:
        d/dt(−A s′) = A (s′ × ω′) with ω′ = a′ u.
        """
        arm, arms = MatrixProduct("arm of a joint with the ground"), self._table(arms_of(self.one))
        (self.arm,) = self.recorder.call(arm, self.blocks.orientation, arms)
        masses, free = reduced_mass_matrix(self.one, self.moving), self.one.free
        inverse = self._table(inverse_of([[masses[a][b] for b in free] for a in free]))
        return _chosen(self._columns(), free), inverse

    def project_position(
        self, dr: SlotMatrix, dtheta: SlotMatrix, into: SlotMatrix
    ) -> dict[int, SlotMatrix]:
        """Record r = r_joint − A s′ + a x and p; return formulas of drivers by coordinates."""
        one, blocks, vector = self.one, self.blocks, self._vector
        drivers = [(led, self._law(led, 0)) for _, led in one.prescribed]
        joint = GroundJointBlocks(
            point=vector(one.joint),
            point_b=self.point,
            p=vector(one.p),
            r=vector(one.base),
            across=self._pair(one.across),
            beside=self._pair(one.beside),
            p_turned=vector(_compose(one.p, one.axis_b)),
            axis=vector(one.axis),
        )
        self.recorder.call(
            ProjectPosition(
                blocks.coordinates,
                one.rotates_about,
                one.slides,
                bool(one.prescribed_rotation),
                bool(one.prescribed_slide),
            ),
            *(blocks.r, blocks.p, dr, dtheta, *joint),
            *(self._since(led, law) for led, law in drivers),
            into=(into,),
        )
        return {
            self.system.constraints[led.instance].terms[0].coordinate: law for led, law in drivers
        }

    def project_velocity(self) -> tuple[SlotMatrix, SlotMatrix, SlotMatrix]:
        """Velocities u (f,), what v lacks of R u + β, and β (c,), recorded."""
        one, blocks = self.one, self.blocks
        masses, moments = shares_of(one, self.moving)
        is_skew = one.rotates_about == AXIS and not (
            one.prescribed_rotation or is_principal(one, self.moving)
        )
        fitted = ProjectVelocity(
            blocks.columns,
            one.rotates_about,
            one.slides,
            bool(one.prescribed_rotation),
            bool(one.prescribed_slide),
            is_skew,
        )
        u, lacks, beta = self.recorder.call(
            fitted,
            *(blocks.v_r, blocks.omega_b, self.arm, self.axis_b, self._vector(one.axis)),
            *(self._pair(one.across_b), self._pair(one.across)),
            *map(self._table, (masses, moments) if is_skew else (masses,)),
            *self._derivatives(1),
        )
        return u, lacks, beta

    def bias_acceleration(self) -> SlotMatrix:
        """Bias acceleration η (c,) [m/s², rad/s²], recorded."""
        one, blocks = self.one, self.blocks
        operation = BiasAcceleration(
            blocks.columns,
            one.rotates_about,
            bool(one.prescribed_rotation),
            bool(one.prescribed_slide),
        )
        (eta,) = self.recorder.call(
            operation,
            *(blocks.omega_b, self.arm, blocks.orientation, self.axis_b),
            *(self._vector(one.axis), self.point),
            *self._derivatives(2),
        )
        return eta

    def reduce_forces(self, free: SlotMatrix, eta: SlotMatrix) -> SlotMatrix:
        """Accelerations u̇ of all freedoms, those that are driven too, under M⁻¹f, recorded."""
        one, (masses, moments) = self.one, shares_of(self.one, self.moving)
        (found,) = self.recorder.call(
            ReduceForces(self.blocks.columns, one.rotates_about, one.slides),
            *(free, self.arm, self._vector(one.axis), eta),
            *(self._table(masses), self._table(moments)),
        )
        return found

    def chosen(self, values: SlotMatrix) -> SlotMatrix:
        """Values of the freedoms that are free, of those of all."""
        return column([values.entries[k] for k in self.one.free])

    def powers(self, values: SlotMatrix | None, others: SlotMatrix) -> list[tuple[str, SlotMatrix]]:
        """Power [W] of each driver: its name, and what :class:`DriverPower` gives, recorded.

        Parameters
        ----------
        values : SlotMatrix or None
            As :meth:`reduce_forces` returned it; without it only what others do counts.
        others : SlotMatrix (c,) [N, N m]
            What other joints do to the body, −Σ C_qᵀλ.
        """
        whole, masses, found = self._columns(), reduced_mass_matrix(self.one, self.moving), []
        zero = column((0,))
        for (k, led), rate in zip(self.one.prescribed, self._derivatives(1), strict=True):
            mass = self.recorder.constant((masses[k][k],))
            forces = (self._derivative(led, 2), values.part(k, 1)) if values else (zero, zero)
            own = _chosen(whole, (k,))
            (power,) = self.recorder.call(DriverPower(), mass, *forces, own, others, rate)
            found.append((self.system.constraints[led.instance].joint, power))
        return found

    def wrenches(
        self,
        second: SlotMatrix,
        free: SlotMatrix,
        others: SlotMatrix,
        coordinates: CoordinateRecorder,
    ) -> dict[str, SlotMatrix]:
        """Forces M v̇ − f + Σ C_qᵀλ of the joint and each of its drivers, by their names, recorded.

        Parameters
        ----------
        second, free : SlotMatrix (c,) [m/s², rad/s²]
            v̇ and M⁻¹f of the body.
        others : SlotMatrix (c,) [N, N m]
            What other joints do to the body, −Σ C_qᵀλ.
        coordinates : CoordinateRecorder
            What records the Jacobians of coordinates.
        """
        body, constraints, found = self.moving, self.system.constraints, {}
        diagonal = (*(body.mass,) * 3, *body.inertia)
        masses = self._vector([diagonal[k] for k in self.blocks.columns]).T
        (left,) = self.recorder.call(JointWrench(), masses, second, free, others)
        for k, led in self.one.prescribed:
            one = constraints[led.instance]
            jacobian = coordinates.jacobian(one.terms[0].coordinate)[self.one.body]
            column = _chosen(self._columns(), (k,))
            own, left = self.recorder.call(DriverWrench(led.sign), left, column, jacobian)
            found[one.joint] = own
        return {constraints[self.one.instances[0]].joint: left, **found}

    def _columns(self) -> SlotMatrix:
        """Matrix R of all freedoms, those that are driven too."""
        spins, count = self.axis_b, self.one.rotations
        rows = []
        for k in self.blocks.columns:
            source = self.arm if k < 3 else spins
            rows.append(source.entries[count * (k % 3) : count * (k % 3 + 1)])
        if self.one.slides:
            axis = (*self._vector(self.one.axis).entries, 0, 0, 0)
            rows = [(*row, axis[k]) for row, k in zip(rows, self.blocks.columns, strict=True)]
        width = count + self.one.slides
        return SlotMatrix(tuple(x for row in rows for x in row), len(rows), width)

    def _law(self, led: Prescribed, order: int) -> SlotMatrix:
        return self.combinations.law(self.system.constraints[led.instance], order)

    def _since(self, led: Prescribed, law: SlotMatrix) -> SlotMatrix:
        start = self.recorder.constant((led.start,))
        return self.recorder.call(PrescribedValue(led.sign), law, start)[0]

    def _derivatives(self, order: int) -> list[SlotMatrix]:
        """Record the derivatives of what drives turn and displacement."""
        return [self._derivative(led, order) for _, led in self.one.prescribed]

    def _derivative(self, led: Prescribed, order: int) -> SlotMatrix:
        return self.recorder.call(PrescribedValue(led.sign), self._law(led, order), column((0,)))[0]

    def _vector(self, values: Sequence[float]) -> SlotMatrix:
        return self.recorder.constant(values)

    def _table(self, rows: Sequence[Sequence[Fraction]]) -> SlotMatrix:
        """Numbers as a matrix."""
        flat = [x for row in rows for x in row]
        return SlotMatrix(
            self.recorder.constant(flat).entries, len(rows), len(rows[0]) if rows else 0
        )

    def _pair(self, pair: tuple[Sequence[float], Sequence[float]]) -> SlotMatrix:
        return SlotMatrix(
            tuple(x for k in zip(*map(self._entries, pair), strict=True) for x in k),
            len(pair[0]),
            2,
        )

    def _entries(self, values: Sequence[float]) -> tuple[int, ...]:
        return self._vector(values).entries


def _compose(p: Sequence[float], axis_b: Sequence[float]) -> tuple[float, ...]:
    """Product p ∘ (0, a′), rounded once."""
    turned = precise.compose(precise.quadruple(p), precise.quadruple((0.0, *axis_b)))
    return precise.rounded(turned)


def _chosen(block: SlotMatrix, kept: Sequence[int]) -> SlotMatrix:
    """Columns that are kept."""
    width = block.width
    entries = tuple(block.entries[width * row + k] for row in range(block.height) for k in kept)
    return SlotMatrix(entries, block.height, len(kept))
