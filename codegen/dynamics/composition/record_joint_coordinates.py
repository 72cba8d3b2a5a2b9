"""The tasks of bodies that hang on the ground by one joint, with v = R u + β.

Such a body is put onto its joint wherever a position is moved, and its velocities are projected
onto it before other joints are solved for. Only the rows of other joints are solved for, with
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
    motion : VelocityTransformation
        Its joint with the ground, and the motions that this leaves free.
    system : System
        The scene.
    recorder : Recorder
        The program.
    body : callable
        Returns the blocks of a body.
    combinations : Combinations
        Recorder of the formulas of drivers.
    """

    motion: VelocityTransformation
    system: System
    recorder: Recorder
    body: Callable[[int], BodyBlocks]
    combinations: Combinations
    arm: SlotMatrix = field(default_factory=lambda: zeros(3, 0))

    @property
    def blocks(self) -> BodyBlocks:
        """The blocks of the body."""
        return self.body(self.motion.body)

    @property
    def moving(self) -> MovingBody:
        """The body."""
        return self.system.bodies[self.motion.body]

    @property
    def point(self) -> SlotMatrix:
        """The point s′ (3,) [m] of the joint in the body."""
        return self._vector(self.motion.joint_b)

    @property
    def axis_b(self) -> SlotMatrix:
        """Axes a′ that it rotates about, by columns (3, rotations) [-]."""
        motion = self.motion
        if motion.rotates_about == POINT:
            return SlotMatrix((1, 0, 0, 0, 1, 0, 0, 0, 1), 3, 3)
        return self._vector(motion.axis_b) if motion.rotates_about != NOTHING else zeros(3, 0)

    def geometry(self) -> tuple[SlotMatrix, SlotMatrix]:
        """R (c, f) of the free motions and (Rᵀ M R)⁻¹ (f, f); the arm A (s′ × a′) is recorded.

        The arm is the velocity (3, rotations) [m] of the centre of mass per rotation, frame O:
        d/dt(−A s′) = A (s′ × ω′) with ω′ = a′ u.
        """
        arms = self._matrix(arms_of(self.motion))
        operation = MatrixProduct("arm of a joint with the ground")
        (self.arm,) = self.recorder.call(operation, self.blocks.orientation, arms)
        masses, free = reduced_mass_matrix(self.motion, self.moving), self.motion.free
        inverse = self._matrix(inverse_of([[masses[a][b] for b in free] for a in free]))
        return _selected_columns(self._basis(), free), inverse

    def project_position(
        self, dr: SlotMatrix, dtheta: SlotMatrix, into: SlotMatrix
    ) -> dict[int, SlotMatrix]:
        """Record r = r_joint − A s′ + a x and p; return formulas of drivers by coordinates."""
        motion, blocks, vector = self.motion, self.blocks, self._vector
        drivers = [(driver, self._law(driver, 0)) for _, driver in motion.prescribed]
        joint = GroundJointBlocks(
            point=vector(motion.joint),
            point_b=self.point,
            p=vector(motion.p),
            r=vector(motion.base),
            across=self._two_columns(motion.across),
            beside=self._two_columns(motion.beside),
            p_turned=vector(_compose(motion.p, motion.axis_b)),
            axis=vector(motion.axis),
        )
        self.recorder.call(
            ProjectPosition(
                blocks.coordinates,
                motion.rotates_about,
                motion.slides,
                bool(motion.prescribed_rotation),
                bool(motion.prescribed_slide),
            ),
            *(blocks.r, blocks.p, dr, dtheta, *joint),
            *(self._since_start(driver, law) for driver, law in drivers),
            into=(into,),
        )
        return {
            self.system.constraints[driver.instance].terms[0].coordinate: law
            for driver, law in drivers
        }

    def project_velocity(self) -> tuple[SlotMatrix, SlotMatrix, SlotMatrix]:
        """Velocities u (f,), the difference R u + β − v (c,), and β (c,), recorded."""
        motion, blocks = self.motion, self.blocks
        masses, moments = shares_of(motion, self.moving)
        is_skew = motion.rotates_about == AXIS and not (
            motion.prescribed_rotation or is_principal(motion, self.moving)
        )
        fitted = ProjectVelocity(
            blocks.columns,
            motion.rotates_about,
            motion.slides,
            bool(motion.prescribed_rotation),
            bool(motion.prescribed_slide),
            is_skew,
        )
        u, difference, beta = self.recorder.call(
            fitted,
            *(blocks.v_r, blocks.omega_b, self.arm, self.axis_b, self._vector(motion.axis)),
            *(self._two_columns(motion.across_b), self._two_columns(motion.across)),
            *map(self._matrix, (masses, moments) if is_skew else (masses,)),
            *self._derivatives(1),
        )
        return u, difference, beta

    def bias_acceleration(self) -> SlotMatrix:
        """Bias acceleration η (c,) [m/s², rad/s²], recorded."""
        motion, blocks = self.motion, self.blocks
        operation = BiasAcceleration(
            blocks.columns,
            motion.rotates_about,
            bool(motion.prescribed_rotation),
            bool(motion.prescribed_slide),
        )
        (eta,) = self.recorder.call(
            operation,
            *(blocks.omega_b, self.arm, blocks.orientation, self.axis_b),
            *(self._vector(motion.axis), self.point),
            *self._derivatives(2),
        )
        return eta

    def reduce_forces(self, free: SlotMatrix, eta: SlotMatrix) -> SlotMatrix:
        """Accelerations u̇ of all freedoms, those that are driven too, under M⁻¹f, recorded."""
        motion, (masses, moments) = self.motion, shares_of(self.motion, self.moving)
        (rates,) = self.recorder.call(
            ReduceForces(self.blocks.columns, motion.rotates_about, motion.slides),
            *(free, self.arm, self._vector(motion.axis), eta),
            *(self._matrix(masses), self._matrix(moments)),
        )
        return rates

    def undriven(self, values: SlotMatrix) -> SlotMatrix:
        """Values of the freedoms that are not driven, out of those of all."""
        return column([values.entries[k] for k in self.motion.free])

    def powers(self, values: SlotMatrix | None, others: SlotMatrix) -> list[tuple[str, SlotMatrix]]:
        """Power [W] of each driver by :class:`DriverPower`, with its name, recorded.

        Parameters
        ----------
        values : SlotMatrix or None
            As :meth:`reduce_forces` returned it; without it only forces of other joints count.
        others : SlotMatrix (c,) [N, N m]
            Forces of other joints on the body, −Σ C_qᵀλ.
        """
        basis, masses, by_driver = self._basis(), reduced_mass_matrix(self.motion, self.moving), []
        zero = column((0,))
        for (k, driver), rate in zip(self.motion.prescribed, self._derivatives(1), strict=True):
            mass = self.recorder.constant((masses[k][k],))
            forces = (self._derivative(driver, 2), values.part(k, 1)) if values else (zero, zero)
            direction = _selected_columns(basis, (k,))
            (power,) = self.recorder.call(DriverPower(), mass, *forces, direction, others, rate)
            by_driver.append((self.system.constraints[driver.instance].joint, power))
        return by_driver

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
            Forces of other joints on the body, −Σ C_qᵀλ.
        coordinates : CoordinateRecorder
            Recorder of the Jacobians of coordinates.
        """
        body, constraints, by_driver = self.moving, self.system.constraints, {}
        diagonal = (*(body.mass,) * 3, *body.inertia)
        masses = self._vector([diagonal[k] for k in self.blocks.columns]).T
        (rest,) = self.recorder.call(JointWrench(), masses, second, free, others)
        for k, driver in self.motion.prescribed:
            constraint = constraints[driver.instance]
            jacobian = coordinates.jacobian(constraint.terms[0].coordinate)[self.motion.body]
            direction = _selected_columns(self._basis(), (k,))
            wrench, rest = self.recorder.call(DriverWrench(driver.sign), rest, direction, jacobian)
            by_driver[constraint.joint] = wrench
        return {constraints[self.motion.instances[0]].joint: rest, **by_driver}

    def _basis(self) -> SlotMatrix:
        """Matrix R of all freedoms, those that are driven too."""
        spins, count = self.axis_b, self.motion.rotations
        rows = []
        for k in self.blocks.columns:
            source = self.arm if k < 3 else spins
            rows.append(source.entries[count * (k % 3) : count * (k % 3 + 1)])
        if self.motion.slides:
            axis = (*self._vector(self.motion.axis).entries, 0, 0, 0)
            rows = [(*row, axis[k]) for row, k in zip(rows, self.blocks.columns, strict=True)]
        width = count + self.motion.slides
        return SlotMatrix(tuple(x for row in rows for x in row), len(rows), width)

    def _law(self, driver: Prescribed, order: int) -> SlotMatrix:
        return self.combinations.law(self.system.constraints[driver.instance], order)

    def _since_start(self, driver: Prescribed, law: SlotMatrix) -> SlotMatrix:
        start = self.recorder.constant((driver.start,))
        return self.recorder.call(PrescribedValue(driver.sign), law, start)[0]

    def _derivatives(self, order: int) -> list[SlotMatrix]:
        """Record the derivatives of the driven turn and displacement."""
        return [self._derivative(driver, order) for _, driver in self.motion.prescribed]

    def _derivative(self, driver: Prescribed, order: int) -> SlotMatrix:
        law = self._law(driver, order)
        return self.recorder.call(PrescribedValue(driver.sign), law, column((0,)))[0]

    def _vector(self, values: Sequence[float]) -> SlotMatrix:
        return self.recorder.constant(values)

    def _matrix(self, rows: Sequence[Sequence[Fraction]]) -> SlotMatrix:
        """Numbers as a matrix."""
        numbers = [x for row in rows for x in row]
        return SlotMatrix(
            self.recorder.constant(numbers).entries, len(rows), len(rows[0]) if rows else 0
        )

    def _two_columns(self, pair: tuple[Sequence[float], Sequence[float]]) -> SlotMatrix:
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


def _selected_columns(block: SlotMatrix, kept: Sequence[int]) -> SlotMatrix:
    """Columns of a block."""
    width = block.width
    entries = tuple(block.entries[width * row + k] for row in range(block.height) for k in kept)
    return SlotMatrix(entries, block.height, len(kept))
