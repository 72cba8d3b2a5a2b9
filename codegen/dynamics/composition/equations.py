"""The program of all equations of a system as it stands: no row left out, nothing solved.

It is made of the same tasks as a solver: C, C_q, ν and γ of every row, and forces on the bodies.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.composition.auxiliary import Auxiliaries, Copy, entries_of
from kousoku.codegen.dynamics.composition.combinations import Combinations
from kousoku.codegen.dynamics.composition.formula_names import FormulaNames
from kousoku.codegen.dynamics.composition.joints import joints_of, rows_of, store_constants
from kousoku.codegen.dynamics.composition.record_coordinates import CoordinateRecorder
from kousoku.codegen.dynamics.composition.record_forces import ForceRecorder
from kousoku.codegen.dynamics.composition.record_joints import JointRecorder
from kousoku.codegen.dynamics.composition.setup import record_setup
from kousoku.codegen.dynamics.operations.body_coordinates import coordinate_counts
from kousoku.codegen.dynamics.operations.mechanics import BodyOrientation
from kousoku.codegen.dynamics.recording.design import number
from kousoku.codegen.dynamics.recording.program import Program
from kousoku.codegen.dynamics.recording.recorder import Recorder, SlotMatrix, column, zeros
from kousoku.codegen.dynamics.simplification.body_blocks import GROUND, body_blocks, coordinates
from kousoku.codegen.dynamics.simplification.outline import live_rows
from kousoku.model.mechanics.multibody import GROUND_INDEX

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.codegen.dynamics.simplification.body_blocks import BodyBlocks
    from kousoku.model.mechanics.multibody import System

#: Numbers of a body in the region ``masses``: mass, moments, origin and axes of the user's frame.
NUMBERS = 11


@dataclass(frozen=True, slots=True)
class SystemEquations:
    """The equations of a system as a program: M v̇ + C_qᵀλ = f, C_q v = ν, C_q v̇ = γ.

    Columns are δr [m] in frame O and δθ′ [rad] in the principal frame of each body.

    Parameters
    ----------
    program : Program
        The segment ``masses`` fills the region of that name, :data:`NUMBERS` for each body;
        ``geometry`` all others: ``C``; ``jacobian``, the blocks of C_q by body; ``minus_nu`` and
        ``minus_gamma``; ``forces`` [N, N m] on each body at its centre of mass, in the order of v,
        weight too.
    places : tuple of (int, int)
        Row and column in C_q of each number of ``jacobian``; columns in the order of v.
    """

    program: Program
    places: tuple[tuple[int, int], ...]


def system_equations(system: System) -> SystemEquations:
    """Program of all equations of a system in space, as :class:`SystemEquations` has them.

    SI units; six columns (n,) for each body, three for a point: M v̇ + C_qᵀλ = f, about the centre
    of mass, in frame O and the principal frames.

    Parameters
    ----------
    system : System
        A scene, assembled or as it is written.
    """
    return _Equations(system).recorded()


class _Equations:
    """The program while it is recorded; blocks are those of a solver, but for masses of one.

    M⁻¹f of a force is then f itself.
    """

    def __init__(self, system: System) -> None:
        self.system = system
        self.recorder = Recorder()
        region = self.recorder.region
        arguments = region("t", 1), region("parameters", len(system.parameters))
        positions, self.columns = coordinate_counts(system, is_planar=False)
        self.auxiliary = Auxiliaries(entries_of(system), positions)
        self.q = region("q", positions + len(self.auxiliary.entries))
        self.v = region("v", self.columns)
        bodies = body_blocks(system, self.recorder, self.q, self.v, is_planar=False)
        self.bodies = [
            replace(blocks, inverse_mass=column((1,) * len(blocks.columns)).T) for blocks in bodies
        ]
        self.parameters = arguments[1]
        relative = CoordinateRecorder(system, self.recorder, self.body, self.auxiliary, self.q)
        by_body = [self.v.part(blocks.v, len(blocks.columns)) for blocks in self.bodies]
        names = FormulaNames(system, self.recorder, relative, arguments, by_body)
        self.forces = ForceRecorder(self.recorder, self.body, relative, names, by_body)
        parameters = tuple(name for name, _ in system.parameters)
        combinations = Combinations(self.recorder, relative, *arguments, parameters)
        self.tasks = JointRecorder(system, self.recorder, self.body, combinations)

    def body(self, index: int) -> BodyBlocks:
        """Blocks of a body, or of the ground."""
        return GROUND if index == GROUND_INDEX else self.bodies[index]

    def recorded(self) -> SystemEquations:
        """Record all tasks."""
        store_constants(self.system, self.recorder, range(len(self.system.constraints)))
        live = live_rows(self.system, is_planar=False)
        joints = joints_of(self.system, self.recorder, dict(enumerate(live)))
        count = sum(joint.count for joint in joints)
        names = ("C", "minus_nu", "minus_gamma")
        residuals, *rates = (self.recorder.region(name, count) for name in names)
        self.recorder.begin("masses")
        self._write("masses", [self._inertia(k) for k in range(len(self.bodies))])
        self.recorder.begin("geometry")
        for k, blocks in enumerate(self.bodies):
            (orientation,) = self.recorder.call(BodyOrientation(), blocks.p)
            self.bodies[k] = replace(blocks, orientation=orientation)
        still = [zeros(len(blocks.columns), 1) for blocks in self.bodies]
        jacobian: list[SlotMatrix] = []
        places: list[tuple[int, int]] = []
        for joint in joints:
            self.tasks.watch(joint, residuals.part(joint.first, joint.count))
            for name, target in zip(("nu", "gamma"), rates, strict=True):
                self.tasks.rates(joint, name, still, target.part(joint.first, joint.count))
            for index, block in joint.c_q.items():
                if index != GROUND_INDEX:
                    jacobian.append(block)
                    rows = range(joint.first, joint.first + joint.count)
                    columns = range(self.body(index).v, self.body(index).v + block.width)
                    places += ((row, k) for row in rows for k in columns)
        self._write("jacobian", jacobian)
        self._write("forces", self._loads())
        pairs = zip(self.system.bodies, self.bodies, strict=True)
        bodies = tuple(coordinates(body, blocks) for body, blocks in pairs)
        design = record_setup(self.recorder, self.system, self.parameters, bodies)
        segments, regions, size = self.recorder.finish()
        program = Program(
            name=self.system.name,
            kernels=tuple(self.recorder.kernels),
            segments=tuple(segments),
            regions=tuple(regions),
            constants=tuple(self.recorder.constants),
            size=size,
            bodies=bodies,
            rows=rows_of(joints),
            is_planar=False,
            auxiliary=self.auxiliary.placed(self.q),
            parameters=tuple(value for _, value in self.system.parameters),
            design=design,
        )
        return SystemEquations(program, tuple(places))

    def _loads(self) -> list[SlotMatrix]:
        """Record f of each body: weight, and all forces."""
        gravity = self.forces.gravity(self.system)
        loads = []
        for body, blocks in zip(self.system.bodies, self.bodies, strict=True):
            minus_weight = self.forces.weight(self.system, gravity, number(body.mass))
            no_torque = (0,) * (len(blocks.columns) - minus_weight.height)
            loads.append(column((*(-minus_weight).entries, *no_torque)))
        self.forces.act(self.system.forces, loads)
        return loads

    def _inertia(self, index: int) -> SlotMatrix:
        body = self.system.bodies[index]
        return self.recorder.constant((body.mass, *body.inertia, *body.origin_b, *body.axes_b))

    def _write(self, name: str, blocks: Sequence[SlotMatrix]) -> None:
        """Write blocks one after the other into a region."""
        target = self.recorder.region(name, sum(len(block.entries) for block in blocks))
        first = 0
        for block in blocks:
            size = len(block.entries)
            if size:
                flat = column(block.entries)
                self.recorder.call(Copy(), flat, into=(target.part(first, size),))
            first += size
