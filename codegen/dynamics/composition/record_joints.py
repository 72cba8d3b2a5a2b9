"""The tasks of joints: residuals, Jacobians, right-hand sides ν and γ, and power of drivers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.operations.coordinates import CoordinateRate
from kousoku.codegen.dynamics.operations.mechanics import JointRows, JointSystem, Rates
from kousoku.codegen.dynamics.recording.recorder import column
from kousoku.model.mechanics.multibody import GROUND_INDEX

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from kousoku.codegen.dynamics.composition.combinations import Combinations
    from kousoku.codegen.dynamics.composition.joints import JointBlocks
    from kousoku.codegen.dynamics.recording.recorder import Recorder, SlotMatrix
    from kousoku.codegen.dynamics.simplification.body_blocks import BodyBlocks
    from kousoku.model.mechanics.multibody import System


@dataclass(frozen=True, slots=True)
class JointRecorder:
    """Recorder of the rows of joints: C (n,) [m, rad or -], δC = C_q (δr, δθ′).

    δr [m] is in frame O, δθ′ [rad] in the principal frame of each body, C_q (n, c) by body.

    Parameters
    ----------
    system : System
        The scene.
    recorder : Recorder
        The program.
    body : callable
        Returns the blocks of a body by its index.
    combinations : Combinations
        Recorder of the rows that combine coordinates.
    """

    system: System
    recorder: Recorder
    body: Callable[[int], BodyBlocks]
    combinations: Combinations

    def jacobian(self, joint: JointBlocks, residuals: SlotMatrix | None) -> None:
        """Record C and C_q of a joint, and put C_q into it; ``residuals`` says where C goes."""
        ends, n = [self.body(k) for k in joint.bodies], len(joint.bodies)
        i, j, *others = ends
        reduced = tuple(k for k, end in enumerate(ends) if end.basis)
        with self.recorder.of(joint.name):
            _, *blocks = self.recorder.call(
                JointSystem(joint.parts, tuple(end.columns for end in ends), reduced),
                *(
                    i.r,
                    i.p,
                    i.orientation,
                    i.effective_inverse_mass,
                    j.r,
                    j.p,
                    j.orientation,
                    j.effective_inverse_mass,
                ),
                *(end.effective_inverse_mass for end in others),
                *(end.basis for end in ends if end.basis),
                *self._operands(joint, "C"),
                into=(residuals,),
            )
        joint.jacobian = dict(zip(joint.bodies, blocks[:n], strict=True))
        joint.scaled = dict(zip(joint.bodies, blocks[n : 2 * n], strict=True))
        joint.diagonal, full = blocks[2 * n], blocks[2 * n + 1 :]
        joint.c_q = joint.jacobian | {
            joint.bodies[k]: block for k, block in zip(reduced, full, strict=True)
        }

    def watch(self, joint: JointBlocks, residuals: SlotMatrix) -> None:
        """Record C and C_q of rows that are not solved for."""
        i, j, *others = map(self.body, joint.bodies)
        with self.recorder.of(joint.name):
            _, *jacobians = self.recorder.call(
                JointRows(joint.parts, tuple(end.columns for end in (i, j, *others))),
                *(i.r, i.p, i.orientation, j.r, j.p, j.orientation),
                *self._operands(joint, "C"),
                into=(residuals,),
            )
        joint.c_q = dict(zip(joint.bodies, jacobians, strict=True))

    def rates(
        self,
        joint: JointBlocks,
        output: str,
        by_body: Sequence[SlotMatrix],
        into: SlotMatrix | None,
        bias: Mapping[int, SlotMatrix] | None = None,
    ) -> SlotMatrix:
        """Difference C_q x − ν or C_q x − γ (n,) of a joint, for x in the order of v, recorded.

        With ``bias`` b, by body, x = R u + b of bodies that are reduced, and ``by_body`` has u.
        """
        i, j = self.body(joint.i), self.body(joint.j)
        jacobian = joint.c_q if bias is None else joint.jacobian
        x_i, x_j, *others = (column(()) if k == GROUND_INDEX else by_body[k] for k in joint.bodies)
        pairs = [(x, jacobian[k]) for x, k in zip(others, joint.others, strict=True)]
        pairs += [(x, joint.c_q[k]) for k, x in (bias or {}).items() if k in joint.bodies]
        with self.recorder.of(joint.name):
            (difference,) = self.recorder.call(
                Rates(joint.parts, output, len(pairs)),
                *(i.p, i.orientation, i.v_r, i.omega_b, x_i, jacobian[joint.i]),
                *(j.p, j.orientation, j.v_r, j.omega_b, x_j, jacobian[joint.j]),
                *(i.r, j.r),
                *(block for pair in pairs for block in pair),
                *self._operands(joint, output),
                into=(into,),
            )
        return difference

    def powers(
        self, joints: Sequence[JointBlocks], multipliers: Sequence[SlotMatrix]
    ) -> dict[str, SlotMatrix]:
        """Power −λ·ν [W] of each driver, by its name, recorded."""
        pairs: dict[str, list[SlotMatrix]] = {}
        for joint, solution in zip(joints, multipliers, strict=True):
            first = 0
            for index, part in zip(joint.instances, joint.parts, strict=True):
                instance = self.system.constraints[index]
                if instance.is_driver:
                    rate = self.combinations.law(instance, 1)
                    minus_nu = column([-entry for entry in rate.entries])
                    pairs.setdefault(instance.joint, []).extend((minus_nu, solution.part(first, 1)))
                first += len(part.rows)
        return {
            name: self.recorder.call(CoordinateRate(), *factors, column((0,)))[0]
            for name, factors in pairs.items()
        }

    def _operands(self, joint: JointBlocks, output: str) -> list[SlotMatrix]:
        """Operands of the parts of a joint: constants, or the rows of combined coordinates."""
        operands: list[SlotMatrix] = []
        parts = zip(joint.instances, joint.parts, joint.constants, strict=True)
        for index, part, constants in parts:
            instance = self.system.constraints[index]
            if not part.is_combination:
                operands += constants
            elif output == "C":
                operands.append(self.combinations.residual(instance))
                operands += (
                    self.combinations.jacobian(instance, k, self.body(k)) for k in joint.bodies
                )
            else:
                operands.append(self.combinations.rate(instance, output))
        return operands
