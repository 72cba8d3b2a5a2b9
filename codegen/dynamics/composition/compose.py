"""From a system to its program: bodies, joints, and the equations that couple them.

M v̇ + C_qᵀλ = f with C_q v̇ = γ is solved by S λ = C_q M⁻¹f − γ, S = C_q M⁻¹ C_qᵀ, with one block of
S for each joint; see :mod:`kousoku.codegen.dynamics.composition.schur`.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.analyse import in_xy_plane
from kousoku.codegen.dynamics.composition.auxiliary import (
    WORK,
    Auxiliaries,
    Copy,
    drivers_of,
    entries_of,
)
from kousoku.codegen.dynamics.composition.combinations import Combinations
from kousoku.codegen.dynamics.composition.energies import record_energies
from kousoku.codegen.dynamics.composition.formula_names import FormulaNames
from kousoku.codegen.dynamics.composition.joint_coordinates import JointCoordinates
from kousoku.codegen.dynamics.composition.joints import (
    JointBlocks,
    joints_of,
    rows_of,
    store_constants,
)
from kousoku.codegen.dynamics.composition.least_norm import Scale, Shared
from kousoku.codegen.dynamics.composition.momentum import record_momenta
from kousoku.codegen.dynamics.composition.reactions import record_reactions, record_wrenches
from kousoku.codegen.dynamics.composition.record_coordinates import CoordinateRecorder
from kousoku.codegen.dynamics.composition.record_forces import ForceRecorder
from kousoku.codegen.dynamics.composition.record_joints import JointRecorder
from kousoku.codegen.dynamics.composition.schur import Schur
from kousoku.codegen.dynamics.composition.setup import record_setup
from kousoku.codegen.dynamics.composition.switching import record_switching
from kousoku.codegen.dynamics.operations.body_coordinates import coordinate_counts
from kousoku.codegen.dynamics.operations.characteristic_length import characteristic_length
from kousoku.codegen.dynamics.operations.joint_ends import points_of
from kousoku.codegen.dynamics.operations.mechanics import (
    BodyOrientation,
    FreeAcceleration,
    Move,
    PoseRate,
)
from kousoku.codegen.dynamics.operations.sums import summed
from kousoku.codegen.dynamics.recording.program import ON_DEMAND, ConservedMomenta, Program
from kousoku.codegen.dynamics.recording.recorder import Recorder, SlotMatrix, column, zeros
from kousoku.codegen.dynamics.redundancy.redundant_rows import by_instance
from kousoku.codegen.dynamics.simplification.axis_permutation import permuted_back, shift_of
from kousoku.codegen.dynamics.simplification.body_blocks import (
    GROUND,
    BodyBlocks,
    body_blocks,
    coordinates,
    gyroscopic_ratios,
)
from kousoku.model.mechanics.multibody import GROUND_INDEX

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Mapping, Sequence
    from contextlib import AbstractContextManager

    from kousoku.codegen.dynamics.analyse import Analysed

#: A tree of so few joints is eliminated one joint after the other: a chain that is eliminated from
#: both ends wants more kernels, and a processor gains nothing from it.
SMALL_TREE_JOINTS = 16


def compose(analysed: Analysed, wanted: Collection[str] = ()) -> Program:
    """Program of a system, in segments.

    Parameters
    ----------
    analysed : Analysed
        The scene, with all that is decided of it.
    wanted : collection of str
        What is computed beyond the motion: ``reactions`` for the region ``lam`` and the segment
        ``reaction``; ``coordinates`` for the segment ``coordinate``, and ``accelerations`` for
        second derivatives in it; ``energies`` for the segment ``energy``; ``checks`` for the
        segments ``check`` and ``momentum``, and for those that a run calls where digits are lost.
        Other names are not looked at.

    Returns
    -------
    Program
        Its segments are those of ``SEGMENTS`` and ``ON_DEMAND`` that the scene and ``wanted`` need.

    Raises
    ------
    SceneError
        Too many rows depend on each other for their reactions.
    """
    permuted = in_xy_plane(analysed)
    program = _ProgramComposer(permuted, wanted).program()
    return permuted_back(program, permuted.system, shift_of(analysed.outline.plane))


class _ProgramComposer:
    """A program while it is composed."""

    def __init__(self, analysed: Analysed, wanted: Collection[str]) -> None:
        system, is_planar = analysed.system, analysed.outline.is_planar
        self.analysed, self.system = analysed, system
        self.shared = Shared(analysed.mobility.shared, by_instance(analysed.mobility.idle))
        self.wanted = wanted
        self.is_planar = is_planar
        self.recorder = Recorder()
        self.time = self.recorder.region("t", 1)
        self.parameters = self.recorder.region("parameters", len(system.parameters))
        positions, velocities = coordinate_counts(system, is_planar=is_planar)
        self.auxiliary = Auxiliaries(entries_of(system), positions)
        size = positions + len(self.auxiliary.entries)
        region = self.recorder.region
        self.q, self.v = region("q", size), region("v", velocities)
        self.dq, self.q_moved = region("dq", velocities), region("q_moved", size)
        self.dv = region("dv", velocities)
        self.q_dot, self.v_dot = region("q_dot", size), region("v_dot", velocities)
        self.bodies = body_blocks(system, self.recorder, self.q, self.v, is_planar=is_planar)
        self.coordinates = CoordinateRecorder(
            system, self.recorder, self.body, self.auxiliary, self.q
        )
        rates, arguments = self._by_body(self.v), (self.time, self.parameters)
        names = FormulaNames(system, self.recorder, self.coordinates, arguments, rates)
        self.forces = ForceRecorder(self.recorder, self.body, self.coordinates, names, rates)
        parameters = tuple(name for name, _ in system.parameters)
        combinations = Combinations(self.recorder, self.coordinates, *arguments, parameters)
        self.tasks = JointRecorder(system, self.recorder, self.body, combinations)
        self.joint_coordinates = JointCoordinates(
            analysed.transformations, system, self.recorder, self.body, combinations
        )
        indices = (*self.joint_coordinates.instances, *range(len(system.constraints)))
        store_constants(system, self.recorder, indices)
        self.joints, self.satisfied, self.left_out = (
            joints_of(system, self.recorder, by_instance(rows))
            for rows in (analysed.solved, analysed.satisfied, analysed.left_out)
        )
        self.rows = sum(joint.count for joint in self.joints)
        self.residuals = region("C", self.rows)
        watched = sum(joint.count for joint in (*self.left_out, *self.satisfied))
        self.other_residuals = region("C_left_out", watched)
        at_once = not self.left_out and (len(self.joints) > SMALL_TREE_JOINTS or analysed.has_loops)
        self.schur = Schur(self.recorder, region("pivots", self.rows), at_once=at_once)

    def body(self, index: int) -> BodyBlocks:
        """Blocks of a body, or of the ground."""
        return GROUND if index == GROUND_INDEX else self.bodies[index]

    def _of_body(self, index: int) -> AbstractContextManager[None]:
        """Name the body that tasks belong to."""
        return self.recorder.of(self.system.bodies[index].name)

    def program(self) -> Program:
        """Record all segments."""
        self._geometry()
        self._position()
        self._move()
        self._velocity()
        self._acceleration()
        for name, record in (("reactions", self._reaction), ("coordinates", self._coordinates)):
            if name in self.wanted:
                record()
        if "energies" in self.wanted:
            record_energies(self.recorder, self.system, self.bodies, self.forces)
        conserved = self.analysed.momenta if "checks" in self.wanted else ()
        if conserved:
            record_momenta(self.recorder, self.system, conserved, self.body)
        if "checks" in self.wanted:
            self._check()
            self._record_rank_loss()
        record_switching(self.recorder, self.system, self.parameters, self.forces)
        return self._program(conserved)

    def _program(self, conserved: tuple[ConservedMomenta, ...]) -> Program:
        """Program of all that was recorded."""
        pairs = zip(self.system.bodies, self.bodies, strict=True)
        bodies = tuple(coordinates(body, blocks) for body, blocks in pairs)
        design = record_setup(self.recorder, self.system, self.parameters, bodies)
        segments, regions, size = self.recorder.finish()
        return Program(
            name=self.system.name,
            kernels=tuple(self.recorder.kernels),
            segments=tuple(x for x in segments if x.name not in ON_DEMAND),
            on_demand=tuple(x for x in segments if x.name in ON_DEMAND),
            regions=tuple(regions),
            constants=tuple(self.recorder.constants),
            size=size,
            bodies=bodies,
            rows=rows_of(self.joints),
            left_out=rows_of(self.left_out),
            has_misses=bool(self.left_out and (self.analysed.mobility.closed or design)),
            satisfied=rows_of(self.satisfied),
            placed=self.joint_coordinates.placed,
            is_planar=self.is_planar,
            auxiliary=self.auxiliary.placed(self.q),
            parameters=tuple(value for _, value in self.system.parameters),
            conserved=conserved,
            design=design,
        )

    def _geometry(self) -> None:
        """Orientations, residuals, Jacobians, and the factors of the Schur complement."""
        self.recorder.begin("geometry")
        for k, blocks in enumerate(self.bodies):
            with self._of_body(k):
                (orientation,) = self.recorder.call(BodyOrientation(), blocks.p)
            self.bodies[k] = replace(blocks, orientation=orientation)
        self.joint_coordinates.geometry(self.bodies)
        for joint in self.joints:
            self.tasks.jacobian(joint, self._rows_of(self.residuals, joint))
        self.schur.factorise(self.joints)

    @staticmethod
    def _rows_of(region: SlotMatrix, joint: JointBlocks) -> SlotMatrix:
        return region.part(joint.first, joint.count)

    def _position(self) -> None:
        self.recorder.begin("position")
        residuals = [self._rows_of(self.residuals, joint) for joint in self.joints]
        self._record_corrections(self.schur.solve(residuals), None, self.dq)

    def _record_corrections(
        self,
        multipliers: Sequence[SlotMatrix],
        free: Sequence[SlotMatrix] | None,
        region: SlotMatrix,
        bias: Mapping[int, SlotMatrix] | None = None,
    ) -> None:
        """Write free − M⁻¹ C_qᵀ λ of each body; of one that is reduced R u + bias."""
        terms: list[list[tuple[SlotMatrix, SlotMatrix]]] = [[] for _ in self.bodies]
        for joint, block in zip(self.joints, multipliers, strict=True):
            for index, scaled in joint.scaled.items():
                if index != GROUND_INDEX:
                    terms[index].append((scaled.T, block))
        totals = list(
            free or (zeros(blocks.effective_inverse_mass.width, 1) for blocks in self.bodies)
        )
        self.joint_coordinates.spread(self.schur, totals, terms, bias)
        for k, (total, products) in enumerate(zip(totals, terms, strict=True)):
            blocks = self.bodies[k]
            with self._of_body(k):
                self.schur.gather(total, products, region.part(blocks.v, len(blocks.columns)))

    def _move(self) -> None:
        self.recorder.begin("move")
        laws: dict[int, SlotMatrix] = {}
        # Without rows nothing corrects q. Where parameters are changed bodies are moved aside, to
        # see whether rows hold that are not solved for: continuation.h.
        has_others = self.left_out or (self.satisfied and self.system.parameters)
        is_corrected = self.joints or has_others
        dq = self.dq if is_corrected else zeros(self.dq.height, 1)
        for k, blocks in enumerate(self.bodies):
            change = blocks.spread(dq.part(blocks.v, len(blocks.columns)).entries)
            target = self.q_moved.part(blocks.q, len(blocks.coordinates))
            if k in self.joint_coordinates.tasks:
                laws |= self.joint_coordinates.tasks[k].project_position(*change, target)
            else:
                position = (blocks.r, blocks.p)
                with self._of_body(k):
                    self.recorder.call(Move(blocks.coordinates), *position, *change, into=(target,))
        kept, targets = self.auxiliary.kept(self.q), self.auxiliary.kept(self.q_moved)
        for block, target in zip(kept, targets, strict=True):
            self.recorder.call(Copy(), block, into=(target,))
        self.coordinates.count_turns(self.q_moved, laws)

    def _rates(
        self,
        output: str,
        by_body: Sequence[SlotMatrix],
        region: SlotMatrix | None = None,
        joints: Sequence[JointBlocks] | None = None,
        bias: Mapping[int, SlotMatrix] | None = None,
    ) -> list[SlotMatrix]:
        """Differences C_q x − ν or C_q x − γ, joint by joint; ``region`` has their slots."""
        differences = []
        for joint in self.joints if joints is None else joints:
            into = self._rows_of(region, joint) if region else None
            differences.append(self.tasks.rates(joint, output, by_body, into, bias))
        return differences

    def _velocity(self) -> None:
        self.recorder.begin("velocity")
        by_body = self._by_body(self.v)
        differences, bias = self.joint_coordinates.project_velocity(by_body)
        rates = self._rates("nu", by_body, bias=bias)
        self._record_corrections(self.schur.solve(rates), None, self.dv, differences)

    def _by_body(self, region: SlotMatrix) -> list[SlotMatrix]:
        """Parts of a region in the order of v."""
        return [region.part(blocks.v, len(blocks.columns)) for blocks in self.bodies]

    def _acceleration(self) -> None:
        lam = self.recorder.region("lam", self.rows) if "reactions" in self.wanted else None
        self.recorder.begin("acceleration")
        gravity = self.forces.gravity(self.system)
        for k, blocks in enumerate(self.bodies):
            with self._of_body(k):
                self.recorder.call(
                    PoseRate(blocks.coordinates),
                    blocks.p,
                    blocks.v_r,
                    blocks.omega_b,
                    into=(self.q_dot.part(blocks.q, len(blocks.coordinates)),),
                )
        self.coordinates.angle_rates(self.q_dot, self._by_body(self.v))
        free: list[SlotMatrix] = []
        for k, (body, blocks) in enumerate(zip(self.system.bodies, self.bodies, strict=True)):
            ratios = self.recorder.constant(gyroscopic_ratios(body, blocks.columns))
            operation = FreeAcceleration(blocks.columns)
            with self._of_body(k):
                free += self.recorder.call(operation, gravity, blocks.omega_b, ratios)
        for name, power in self.forces.act(self.system.forces, free).items():
            self._record_work_rate(name, power)
        if lam:
            self.joint_coordinates.keep(free)
        bias = self.joint_coordinates.reduce_forces(free)
        targets = [self._rows_of(lam, joint) for joint in self.joints] if lam else None
        multipliers = self.schur.solve(self._rates("gamma", free, bias=bias), targets)
        self._record_corrections(multipliers, free, self.v_dot, bias)
        powers = zip(drivers_of(self.system), self._powers(multipliers), strict=True)
        for name, power in powers:
            self._record_work_rate(name, power)

    def _record_work_rate(self, name: str, power: SlotMatrix) -> None:
        """Record the power of a force or a driver as the rate of its work."""
        target = self.auxiliary.of(self.q_dot, WORK, name)
        self.recorder.call(Copy(), power, into=(target,))

    def _powers(
        self, multipliers: Sequence[SlotMatrix], *, is_total: bool = True
    ) -> list[SlotMatrix]:
        """Record the power of each driver, or the share of the multipliers in it."""
        by_joint = self.tasks.powers(self.joints, multipliers)
        powers = {name: [power] for name, power in by_joint.items()}
        ground = self.joint_coordinates.powers(
            self.schur, self.joints, multipliers, is_total=is_total
        )
        for name, power in ground:
            powers.setdefault(name, []).append(power)
        zero = [column((0,))]
        names = drivers_of(self.system)
        return [summed(self.recorder, powers.get(name, zero)) for name in names]

    def _reaction(self, record: Callable[..., None] | None = None) -> None:
        """Record force and torque of each joint."""
        length = characteristic_length(self.system)
        if record is None:
            v_dot = self._by_body(self.v_dot)
            record = partial(
                record_reactions,
                satisfied=self.satisfied,
                ground=partial(
                    self.joint_coordinates.wrenches,
                    self.schur,
                    self.joints,
                    v_dot,
                    self.coordinates,
                ),
                in_loops="checks" in self.wanted and self.analysed.shares_out,
            )
        record(
            self.recorder,
            self.schur,
            self.body,
            rows=(self.joints, self.left_out),
            geometry=lambda joint: self.tasks.jacobian(joint, None),
            scale=Scale(points_of(self.system), length, self.shared),
        )

    def _coordinates(self) -> None:
        """Record the coordinates that are shown."""
        with_accelerations = "accelerations" in self.wanted
        count = (3 if with_accelerations else 2) * len(self.system.shown)
        region = self.recorder.region("coordinates", count)
        self.recorder.begin("coordinate")
        v_dot = self._by_body(self.v_dot) if with_accelerations else None
        self.coordinates.show(region, self._by_body(self.v), v_dot)

    def _check(self) -> None:
        """Record residuals of constraints and their rates, of rows that depend on others, too."""
        count = self.rows + self.other_residuals.height
        rates, second = (self.recorder.region(name, count) for name in ("C_dot", "C_ddot"))
        self.recorder.begin("check")
        for joint in (*self.left_out, *self.satisfied):
            self.tasks.watch(joint, self._rows_of(self.other_residuals, joint))
        for output, values, region in (("nu", self.v, rates), ("gamma", self.v_dot, second)):
            by_body = self._by_body(values)
            self._rates(output, by_body, region)
            others = region.part(self.rows, self.other_residuals.height)
            self._rates(output, by_body, others, [*self.left_out, *self.satisfied])

    def _record_rank_loss(self) -> None:
        """Record the segments of runs that lose digits, or whose rows become dependent."""
        if self.analysed.refines:
            self._refinement()
        if "reactions" in self.wanted and self.analysed.takes_over:
            self._reaction(record_wrenches)

    def _refinement(self) -> None:
        """Record the corrections by the residual C_q v̇ − γ."""
        names, region = drivers_of(self.system), self.recorder.region
        lam = region("more_lam", self.rows) if "reactions" in self.wanted else None
        powers = region("more_power", len(names)) if names else column(())
        self.recorder.begin("refinement")
        targets = [self._rows_of(lam, joint) for joint in self.joints] if lam else None
        rates = self._rates("gamma", self._by_body(self.v_dot))
        multipliers = self.schur.solve(rates, targets)
        self._record_corrections(multipliers, None, self.dv)
        for k, correction in enumerate(self._powers(multipliers, is_total=False)):
            self.recorder.call(Copy(), correction, into=(powers.part(k, 1),))
