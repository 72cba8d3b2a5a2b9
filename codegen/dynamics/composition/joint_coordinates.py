"""The bodies of a program that hang on the ground by one joint, and keep what it leaves free.

The composer asks here, segment by segment, for what differs of such bodies.
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
    found : mapping of int to VelocityTransformation
        What describes them, by the body.
    system : System
        The scene.
    recorder : Recorder
        The program.
    body : callable
        Returns the blocks of a body by its index.
    combinations : Combinations
        What records the formulas of drivers.
    """

    def __init__(
        self,
        found: Mapping[int, VelocityTransformation],
        system: System,
        recorder: Recorder,
        body: Callable[[int], BodyBlocks],
        combinations: Combinations,
    ) -> None:
        self.recorder = recorder
        self.tasks = {
            k: JointCoordinateRecorder(one, system, recorder, body, combinations)
            for k, one in found.items()
        }
        self._free: dict[int, SlotMatrix] = {}

    @property
    def instances(self) -> list[int]:
        """The joints that bodies are put onto and their drivers, by their places."""
        return [place for one in self.tasks.values() for place in one.one.instances]

    @property
    def placed(self) -> tuple[int, ...]:
        """The bodies whose centre of mass follows from all else."""
        return tuple(k for k, one in self.tasks.items() if one.one.is_placed)

    def geometry(self, bodies: list[BodyBlocks]) -> None:
        """Record R (c, f), and put it into the blocks of the bodies."""
        for k, one in self.tasks.items():
            basis, inverse = one.geometry()
            bodies[k] = replace(bodies[k], basis=basis, inverse=inverse)

    def project_velocity(
        self, by_body: list[SlotMatrix]
    ) -> tuple[dict[int, SlotMatrix], dict[int, SlotMatrix]]:
        """Record velocities that fit, put u into ``by_body``; return what v lacks, and β, (c,)."""
        lacks, beta = {}, {}
        for k, one in self.tasks.items():
            by_body[k], lacks[k], beta[k] = one.project_velocity()
        return lacks, beta

    def reduce_forces(self, free: list[SlotMatrix]) -> dict[int, SlotMatrix]:
        """Record u̇ without joints, and put it into ``free``, which has M⁻¹f; return η."""
        drifts = {k: one.bias_acceleration() for k, one in self.tasks.items()}
        for k, one in self.tasks.items():
            self._free[k] = one.reduce_forces(free[k], drifts[k])
            free[k] = one.chosen(self._free[k])
        return drifts

    def keep(self, free: Sequence[SlotMatrix]) -> None:
        """Record M⁻¹f (c,) in a region of its own: forces of joints follow from it."""
        if self.tasks:
            whole = self.recorder.region("free", sum(free[k].height for k in self.tasks))
            for part, k in zip(self._parts(whole), self.tasks, strict=True):
                self.recorder.call(Copy(), free[k], into=(part,))

    def wrenches(
        self,
        schur: Schur,
        joints: Sequence[JointBlocks],
        v_dot: Sequence[SlotMatrix],
        coordinates: CoordinateRecorder,
    ) -> dict[tuple[str, int], SlotMatrix]:
        """Forces M v̇ − f + Σ C_qᵀλ of joints with the ground and drivers, by name and body."""
        found: dict[tuple[str, int], SlotMatrix] = {}
        if not self.tasks:
            return found
        lam, whole = self.recorder.known("lam"), self.recorder.known("free")
        multipliers = [lam.part(joint.first, joint.count) for joint in joints]
        for free, (k, one) in zip(self._parts(whole), self.tasks.items(), strict=True):
            others = self._others(schur, k, joints, multipliers)
            own = one.wrenches(v_dot[k], free, others, coordinates)
            found |= {(name, k): wrench for name, wrench in own.items()}
        return found

    def _parts(self, whole: SlotMatrix) -> list[SlotMatrix]:
        """Parts of a region that has the columns of each body."""
        counts = [len(one.blocks.columns) for one in self.tasks.values()]
        return [whole.part(sum(counts[:n]), count) for n, count in enumerate(counts)]

    def _others(
        self, schur: Schur, k: int, joints: Sequence[JointBlocks], multipliers: Sequence[SlotMatrix]
    ) -> SlotMatrix:
        """Record what other joints do to body k, −Σ C_qᵀλ."""
        pairs = zip(joints, multipliers, strict=True)
        products = [(joint.whole[k].T, solution) for joint, solution in pairs if k in joint.bodies]
        return schur.gather(zeros(len(self.tasks[k].blocks.columns), 1), products)

    def powers(
        self,
        schur: Schur,
        joints: Sequence[JointBlocks],
        multipliers: Sequence[SlotMatrix],
        *,
        is_whole: bool,
    ) -> list[tuple[str, SlotMatrix]]:
        """Power (1,) [W] of each driver of a joint with the ground, by its name, recorded.

        Unless it is the whole, what the multipliers add to it.
        """
        found = []
        for k, one in self.tasks.items():
            if one.one.prescribed:
                others = self._others(schur, k, joints, multipliers)
                found += one.powers(self._free[k] if is_whole else None, others)
        return found

    def spread(
        self,
        schur: Schur,
        totals: list[SlotMatrix],
        products: list[list[Product]],
        beyond: Mapping[int, SlotMatrix] | None,
    ) -> None:
        """Record what others do to u, and put R u and what is beyond that in its place."""
        own = {k: schur.gather(totals[k], products[k]) for k in self.tasks}
        for k, one in self.tasks.items():
            basis = one.blocks.basis
            assert basis is not None
            totals[k] = beyond[k] if beyond else zeros(basis.height, 1)
            products[k] = [(-basis, own[k])]
