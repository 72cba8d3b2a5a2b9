"""The bodies of a program that hang on the ground by one joint, in the coordinates that it leaves.

The composer asks here, segment by segment, for the tasks of such bodies that differ.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.composition.auxiliary import Copy
from kousoku.codegen.dynamics.composition.record_joint_coordinates import JointCoordinateRecorder
from kousoku.codegen.dynamics.recording.recorder import zeros

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from kousoku.codegen.dynamics.composition.combinations import Combinations
    from kousoku.codegen.dynamics.composition.joints import JointBlocks
    from kousoku.codegen.dynamics.composition.record_coordinates import CoordinateRecorder
    from kousoku.codegen.dynamics.composition.schur import Schur
    from kousoku.codegen.dynamics.recording.recorder import Recorder, SlotMatrix
    from kousoku.codegen.dynamics.simplification.body_blocks import BodyBlocks
    from kousoku.codegen.dynamics.simplification.ground_joints import VelocityTransformation
    from kousoku.model.mechanics.multibody import System

    #: A matrix, and the vector that it is multiplied with.
    Product = tuple[SlotMatrix, SlotMatrix]


class JointCoordinates:
    """The bodies that are reduced, v = R u + β, none of them unless there are some.

    v (c,) [m/s, rad/s] has the columns δr in frame O, δθ′ in the principal frame; R (c, f), u (f,).

    Parameters
    ----------
    transformations : mapping of int to VelocityTransformation
        R and β of each, by the body.
    system : System
        The scene.
    recorder : Recorder
        The program.
    body : callable
        Returns the blocks of a body by its index.
    combinations : Combinations
        Recorder of the formulas of drivers.
    """

    def __init__(
        self,
        transformations: Mapping[int, VelocityTransformation],
        system: System,
        recorder: Recorder,
        body: Callable[[int], BodyBlocks],
        combinations: Combinations,
    ) -> None:
        self.recorder = recorder
        self.tasks = {
            k: JointCoordinateRecorder(motion, system, recorder, body, combinations)
            for k, motion in transformations.items()
        }
        self._free: dict[int, SlotMatrix] = {}

    @property
    def instances(self) -> list[int]:
        """The joints that bodies are put onto and their drivers, by their indices."""
        return [index for task in self.tasks.values() for index in task.motion.instances]

    @property
    def placed(self) -> tuple[int, ...]:
        """The bodies whose centre of mass follows from all else."""
        return tuple(k for k, task in self.tasks.items() if task.motion.is_placed)

    def geometry(self, bodies: list[BodyBlocks]) -> None:
        """Record R (c, f), and put it into the blocks of the bodies."""
        for k, task in self.tasks.items():
            basis, inverse = task.geometry()
            bodies[k] = replace(bodies[k], basis=basis, inverse=inverse)

    def project_velocity(
        self, by_body: list[SlotMatrix]
    ) -> tuple[dict[int, SlotMatrix], dict[int, SlotMatrix]]:
        """Record projected velocities, put u into ``by_body``; return R u + β − v and β, (c,)."""
        differences, beta = {}, {}
        for k, task in self.tasks.items():
            by_body[k], differences[k], beta[k] = task.project_velocity()
        return differences, beta

    def reduce_forces(self, free: list[SlotMatrix]) -> dict[int, SlotMatrix]:
        """Record u̇ without joints, and put it into ``free``, which has M⁻¹f; return η."""
        biases = {k: task.bias_acceleration() for k, task in self.tasks.items()}
        for k, task in self.tasks.items():
            self._free[k] = task.reduce_forces(free[k], biases[k])
            free[k] = task.undriven(self._free[k])
        return biases

    def keep(self, free: Sequence[SlotMatrix]) -> None:
        """Record M⁻¹f (c,) in a region of its own: forces of joints follow from it."""
        if self.tasks:
            region = self.recorder.region("free", sum(free[k].height for k in self.tasks))
            for part, k in zip(self._by_body(region), self.tasks, strict=True):
                self.recorder.call(Copy(), free[k], into=(part,))

    def wrenches(
        self,
        schur: Schur,
        joints: Sequence[JointBlocks],
        v_dot: Sequence[SlotMatrix],
        coordinates: CoordinateRecorder,
    ) -> dict[tuple[str, int], SlotMatrix]:
        """Forces M v̇ − f + Σ C_qᵀλ of joints with the ground and drivers, by name and body."""
        by_body: dict[tuple[str, int], SlotMatrix] = {}
        if not self.tasks:
            return by_body
        lam, region = self.recorder.known("lam"), self.recorder.known("free")
        multipliers = [lam.part(joint.first, joint.count) for joint in joints]
        for free, (k, task) in zip(self._by_body(region), self.tasks.items(), strict=True):
            others = self._other_forces(schur, k, joints, multipliers)
            by_name = task.wrenches(v_dot[k], free, others, coordinates)
            by_body |= {(name, k): wrench for name, wrench in by_name.items()}
        return by_body

    def _by_body(self, region: SlotMatrix) -> list[SlotMatrix]:
        """Parts of a region that has the columns of each body."""
        counts = [len(task.blocks.columns) for task in self.tasks.values()]
        return [region.part(sum(counts[:n]), count) for n, count in enumerate(counts)]

    def _other_forces(
        self, schur: Schur, k: int, joints: Sequence[JointBlocks], multipliers: Sequence[SlotMatrix]
    ) -> SlotMatrix:
        """Record the forces of other joints on body k, −Σ C_qᵀλ."""
        pairs = zip(joints, multipliers, strict=True)
        products = [(joint.c_q[k].T, solution) for joint, solution in pairs if k in joint.bodies]
        return schur.gather(zeros(len(self.tasks[k].blocks.columns), 1), products)

    def powers(
        self,
        schur: Schur,
        joints: Sequence[JointBlocks],
        multipliers: Sequence[SlotMatrix],
        *,
        is_total: bool,
    ) -> list[tuple[str, SlotMatrix]]:
        """Power (1,) [W] of each driver of a joint with the ground, by its name, recorded.

        Unless it is the total, the share of the multipliers alone.
        """
        by_driver = []
        for k, task in self.tasks.items():
            if task.motion.prescribed:
                others = self._other_forces(schur, k, joints, multipliers)
                by_driver += task.powers(self._free[k] if is_total else None, others)
        return by_driver

    def spread(
        self,
        schur: Schur,
        totals: list[SlotMatrix],
        products: list[list[Product]],
        bias: Mapping[int, SlotMatrix] | None,
    ) -> None:
        """Record u with the forces of other joints, and put R u + bias, by terms, in its place."""
        rates = {k: schur.gather(totals[k], products[k]) for k in self.tasks}
        for k, task in self.tasks.items():
            basis = task.blocks.basis
            assert basis is not None
            totals[k] = bias[k] if bias else zeros(basis.height, 1)
            products[k] = [(-basis, rates[k])]
