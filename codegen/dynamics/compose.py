"""From a system to its program: bodies, joints, and the equations that couple them.

M v̇ + C_qᵀλ = f with C_q v̇ = γ is solved by S λ = C_q M⁻¹f − γ, S = C_q M⁻¹ C_qᵀ, with one block of
S for each joint; see :mod:`kousoku.codegen.dynamics.solve`.
"""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.auxiliary import WORK, Auxiliaries, Copy, entries_of
from kousoku.codegen.dynamics.bodies import (
    GROUND,
    BodyBlocks,
    body_blocks,
    coordinates,
    gyroscopic_ratios,
    require_masses,
    sizes,
)
from kousoku.codegen.dynamics.force_tasks import ForceTasks
from kousoku.codegen.dynamics.joints import JointBlocks, joints_of, require_few_joints
from kousoku.codegen.dynamics.operations import (
    Energy,
    FreeAcceleration,
    Joint,
    Motion,
    Move,
    Orientation,
    Rates,
    Sum,
)
from kousoku.codegen.dynamics.planar import plane_of
from kousoku.codegen.dynamics.program import Program, Row
from kousoku.codegen.dynamics.reactions import record_reactions
from kousoku.codegen.dynamics.recorder import Block, Recorder, column, zeros
from kousoku.codegen.dynamics.schur import Schur
from kousoku.codegen.dynamics.turned import named_back, turned, turned_row
from kousoku.model.formulas import TIME
from kousoku.model.mechanism import GROUND_INDEX

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping, Sequence

    from kousoku.model.mechanism import System

#: How many terms one task adds up.
CHUNK = 4


def compose(
    system: System,
    wanted: Collection[str] = (),
    *,
    rows: Mapping[int, Sequence[int]] | None = None,
    may_be_planar: bool = True,
) -> Program:
    """Return the program of a system: its segments are those of ``SEGMENTS``.

    Parameters
    ----------
    system : System
        The scene.
    wanted : collection of str
        What is computed beyond the motion: ``reactions`` for the region ``lam`` and the segment
        ``reaction``, ``energies`` for the segment ``energy``, ``checks`` for the segment ``check``.
        Other names are not looked at.
    rows : mapping of int to sequence of int, optional
        For instances of which not all rows are kept, by their place in ``system.constraints``, the
        rows that are.
    may_be_planar : bool
        Whether a scene that stays in a coordinate plane gets planar coordinates.

    Returns
    -------
    Program
        Segments ``geometry``, ``position``, ``move``, ``velocity``, ``acceleration``, and
        ``reaction``, ``energy`` and ``check`` where they are wanted.

    Raises
    ------
    SceneError
        A body lacks a mass or a moment that its motion needs, or has too many joints.
    """
    require_few_joints(system)
    kept = rows or {}
    shift = plane_of(system) if may_be_planar else None
    if shift is None:
        require_masses(system, is_planar=False)
        return _Composer(system, wanted, kept, is_planar=False).program()
    other = turned(system, shift)
    require_masses(other, is_planar=True)
    kinds = [instance.kind for instance in system.constraints]
    kept = {k: [turned_row(kinds[k], row, shift) for row in own] for k, own in kept.items()}
    return named_back(_Composer(other, wanted, kept, is_planar=True).program(), system, shift)


class _Composer:
    """A program while it is composed."""

    def __init__(
        self,
        system: System,
        wanted: Collection[str],
        rows: Mapping[int, Sequence[int]],
        *,
        is_planar: bool,
    ) -> None:
        self.system = system
        self.wanted = wanted
        self.is_planar = is_planar
        self.recorder = Recorder()
        self.time = self.recorder.region("t", 1)
        own, velocities = sizes(system, is_planar=is_planar)
        self.auxiliary = Auxiliaries(entries_of(system), own)
        positions = own + len(self.auxiliary.entries)
        region = self.recorder.region
        self.q, self.v = region("q", positions), region("v", velocities)
        self.dq, self.q_moved = region("dq", velocities), region("q_moved", positions)
        self.dv = region("dv", velocities)
        self.q_dot, self.v_dot = region("q_dot", positions), region("v_dot", velocities)
        names = {TIME: (self.time, self.recorder.constant((1,)))}
        self.forces = ForceTasks(self.recorder, self.body, names)
        self.bodies = body_blocks(system, self.recorder, self.q, self.v, is_planar=is_planar)
        self.joints = joints_of(system, self.recorder, rows, self.body)
        self.rows = sum(joint.count for joint in self.joints)
        self.residuals = region("C", self.rows)
        self.schur = Schur(self.recorder, region("pivots", self.rows))

    def body(self, index: int) -> BodyBlocks:
        """Return the blocks of a body, or of the ground."""
        return GROUND if index == GROUND_INDEX else self.bodies[index]

    def program(self) -> Program:
        """Record all segments."""
        self._geometry()
        self._position()
        self._move()
        self._velocity()
        self._acceleration()
        if "reactions" in self.wanted:
            record_reactions(self.recorder, self.schur, self.joints, self.bodies)
        if "energies" in self.wanted:
            self._energy()
        if "checks" in self.wanted:
            self._check()
        segments, regions, size = self.recorder.finish()
        pairs = zip(self.system.bodies, self.bodies, strict=True)
        return Program(
            name=self.system.name,
            kernels=tuple(self.recorder.kernels),
            segments=tuple(segments),
            regions=tuple(regions),
            constants=tuple(self.recorder.constants),
            size=size,
            bodies=tuple(coordinates(body, blocks) for body, blocks in pairs),
            rows=tuple(
                Row(joint.name, instance, row)
                for joint in self.joints
                for instance, part in zip(joint.instances, joint.parts, strict=True)
                for row in part.rows
            ),
            is_planar=self.is_planar,
            auxiliary=self.auxiliary.placed(self.q),
        )

    def _geometry(self) -> None:
        """Orientations, residuals, Jacobians, and the factors of the Schur complement."""
        self.recorder.begin("geometry")
        for k, blocks in enumerate(self.bodies):
            (orientation,) = self.recorder.call(Orientation(), blocks.p)
            self.bodies[k] = replace(blocks, orientation=orientation)
        for joint in self.joints:
            i, j = self.body(joint.i), self.body(joint.j)
            _, left, right, scaled_left, scaled_right, own = self.recorder.call(
                Joint(joint.parts, i.columns, j.columns),
                *(i.r, i.p, i.orientation, i.inverse_mass),
                *(j.r, j.p, j.orientation, j.inverse_mass),
                *joint.constants,
                into=(self._rows_of(self.residuals, joint),),
            )
            joint.jacobian = {joint.i: left, joint.j: right}
            joint.scaled = {joint.i: scaled_left, joint.j: scaled_right}
            joint.own = own
        self.schur.factorise(self.joints)

    @staticmethod
    def _rows_of(region: Block, joint: JointBlocks) -> Block:
        return region.part(joint.first, joint.count)

    def _position(self) -> None:
        self.recorder.begin("position")
        residuals = [self._rows_of(self.residuals, joint) for joint in self.joints]
        self._pull(self.schur.solve(residuals), None, self.dq)

    def _pull(
        self, multipliers: Sequence[Block], free: Sequence[Block] | None, region: Block
    ) -> None:
        """Write free − M⁻¹ C_qᵀ λ of each body."""
        terms: list[list[tuple[Block, Block]]] = [[] for _ in self.bodies]
        for joint, block in zip(self.joints, multipliers, strict=True):
            for index, scaled in joint.scaled.items():
                if index != GROUND_INDEX:
                    terms[index].append((scaled.T, block))
        for k, blocks in enumerate(self.bodies):
            count = len(blocks.columns)
            total = free[k] if free else zeros(count, 1)
            self.schur.gather(total, terms[k], region.part(blocks.v, count))

    def _move(self) -> None:
        self.recorder.begin("move")
        for blocks in self.bodies:
            change = self.dq.part(blocks.v, len(blocks.columns))
            target = self.q_moved.part(blocks.q, len(blocks.coordinates))
            self.recorder.call(
                Move(blocks.coordinates),
                blocks.r,
                blocks.p,
                *blocks.spread(change.entries),
                into=(target,),
            )
        kept, targets = self.auxiliary.kept(self.q), self.auxiliary.kept(self.q_moved)
        for block, target in zip(kept, targets, strict=True):
            self.recorder.call(Copy(), block, into=(target,))

    def _rates(
        self, output: str, by_body: Sequence[Block], region: Block | None = None
    ) -> list[Block]:
        """Return C_q x minus ν or γ, joint by joint; ``region`` says where to put it."""
        found = []
        for joint in self.joints:
            i, j = self.body(joint.i), self.body(joint.j)
            x_i, x_j = (column(()) if k == GROUND_INDEX else by_body[k] for k in (joint.i, joint.j))
            (difference,) = self.recorder.call(
                Rates(joint.parts, output),
                *(i.p, i.orientation, i.v_r, i.omega_b, x_i, joint.jacobian[joint.i]),
                *(j.p, j.orientation, j.v_r, j.omega_b, x_j, joint.jacobian[joint.j]),
                *(i.r, j.r),
                *joint.constants,
                into=(self._rows_of(region, joint) if region else None,),
            )
            found.append(difference)
        return found

    def _velocity(self) -> None:
        self.recorder.begin("velocity")
        rates = self._rates("nu", self._by_body(self.v))
        self._pull(self.schur.solve(rates), None, self.dv)

    def _by_body(self, region: Block) -> list[Block]:
        """Return the parts of a region in the order of v."""
        return [region.part(blocks.v, len(blocks.columns)) for blocks in self.bodies]

    def _acceleration(self) -> None:
        gravity = self.recorder.constant(self.system.gravity)
        lam = self.recorder.region("lam", self.rows) if "reactions" in self.wanted else None
        self.recorder.begin("acceleration")
        for blocks in self.bodies:
            self.recorder.call(
                Motion(blocks.coordinates),
                blocks.p,
                blocks.v_r,
                blocks.omega_b,
                into=(self.q_dot.part(blocks.q, len(blocks.coordinates)),),
            )
        free: list[Block] = []
        for body, blocks in zip(self.system.bodies, self.bodies, strict=True):
            ratios = self.recorder.constant(gyroscopic_ratios(body, blocks.columns))
            operation = FreeAcceleration(blocks.columns)
            free += self.recorder.call(operation, gravity, blocks.omega_b, ratios)
        self._add_forces(free)
        targets = [self._rows_of(lam, joint) for joint in self.joints] if lam else None
        self._pull(self.schur.solve(self._rates("gamma", free), targets), free, self.v_dot)

    def _add_forces(self, free: list[Block]) -> None:
        """Add what forces beside gravity give each body, and write the power of those that work."""
        shares: list[list[Block]] = [[block] for block in free]
        for force in self.system.forces:
            added, power = self.forces.effect(force)
            for index, block in added.items():
                shares[index].append(block)
            if power is not None:
                target = self.auxiliary.of(self.q_dot, WORK, force.name)
                self.recorder.call(Copy(), power, into=(target,))
        free[:] = [self._sum(parts) for parts in shares]

    def _sum(self, parts: list[Block]) -> Block:
        """Return the sum of blocks, a few at a time."""
        while len(parts) > 1:
            parts = [
                self.recorder.call(Sum(), *parts[k : k + CHUNK])[0]
                for k in range(0, len(parts), CHUNK)
            ]
        return parts[0]

    def _check(self) -> None:
        """Record what is left of the constraints at the levels of velocity and acceleration."""
        rates, second = (self.recorder.region(name, self.rows) for name in ("C_dot", "C_ddot"))
        self.recorder.begin("check")
        self._rates("nu", self._by_body(self.v), rates)
        self._rates("gamma", self._by_body(self.v_dot), second)

    def _energy(self) -> None:
        target = self.recorder.region("energies", 2)
        self.recorder.begin("energy")
        parts: list[Block] = []
        for body, blocks in zip(self.system.bodies, self.bodies, strict=True):
            mass = Fraction(body.mass)
            halves = self.recorder.constant(
                [mass / 2] * 3 + [Fraction(x) / 2 for x in body.inertia]
            )
            weight = self.recorder.constant([-mass * Fraction(g) for g in self.system.gravity])
            parts += self.recorder.call(
                Energy(), blocks.r, blocks.v_r, blocks.omega_b, halves, weight
            )
        for force in self.system.forces:
            if force.has_potential:
                parts.append(self.forces.stored(force))
        while len(parts) > CHUNK:
            parts = [
                self.recorder.call(Sum(), *parts[k : k + CHUNK])[0]
                for k in range(0, len(parts), CHUNK)
            ]
        self.recorder.call(Sum(), *parts, into=(target,))
