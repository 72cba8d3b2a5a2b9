"""The tasks of joints: residuals, Jacobians, and what they ask of velocities and accelerations."""

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
        Where they are recorded.
    body : callable
        Returns the blocks of a body by its index.
    combinations : Combinations
        What records the rows that combine coordinates.
    """

    system: System
    recorder: Recorder
    body: Callable[[int], BodyBlocks]
    combinations: Combinations

    def jacobian(self, joint: JointBlocks, residuals: SlotMatrix | None) -> None:
        """Record C and C_q of a joint, and put C_q into it; ``residuals`` says where C goes."""
        ends, n = [self.body(k) for k in joint.bodies], len(joint.bodies)
        i, j, *others = ends
        reduced = tuple(k for k, one in enumerate(ends) if one.basis)
        with self.recorder.of(joint.name):
            _, *found = self.recorder.call(
                JointSystem(joint.parts, tuple(one.columns for one in ends), reduced),
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
                *(one.effective_inverse_mass for one in others),
                *(one.basis for one in ends if one.basis),
                *self._of_parts(joint, "C"),
                into=(residuals,),
            )
        joint.jacobian = dict(zip(joint.bodies, found[:n], strict=True))
        joint.scaled = dict(zip(joint.bodies, found[n : 2 * n], strict=True))
        joint.own, whole = found[2 * n], found[2 * n + 1 :]
        joint.whole = joint.jacobian | {
            joint.bodies[k]: block for k, block in zip(reduced, whole, strict=True)
        }

    def watch(self, joint: JointBlocks, residuals: SlotMatrix) -> None:
        """Record C and C_q of rows that are not solved for."""
        i, j, *others = map(self.body, joint.bodies)
        with self.recorder.of(joint.name):
            _, *found = self.recorder.call(
                JointRows(joint.parts, tuple(one.columns for one in (i, j, *others))),
                *(i.r, i.p, i.orientation, j.r, j.p, j.orientation),
                *self._of_parts(joint, "C"),
                into=(residuals,),
            )
        joint.whole = dict(zip(joint.bodies, found, strict=True))

    def rates(
        self,
        joint: JointBlocks,
        output: str,
        by_body: Sequence[SlotMatrix],
        into: SlotMatrix | None,
        beyond: Mapping[int, SlotMatrix] | None = None,
    ) -> SlotMatrix:
        """Difference C_q x − ν or C_q x − γ (n,) of a joint, for x in the order of v, recorded.

        With ``beyond`` it is x = R u + what that says of bodies that are reduced, and u is given.
        """
        i, j = self.body(joint.i), self.body(joint.j)
        jacobian = joint.whole if beyond is None else joint.jacobian
        x_i, x_j, *others = (column(()) if k == GROUND_INDEX else by_body[k] for k in joint.bodies)
        pairs = [(x, jacobian[k]) for x, k in zip(others, joint.others, strict=True)]
        pairs += [(x, joint.whole[k]) for k, x in (beyond or {}).items() if k in joint.bodies]
        with self.recorder.of(joint.name):
            (difference,) = self.recorder.call(
                Rates(joint.parts, output, len(pairs)),
                *(i.p, i.orientation, i.v_r, i.omega_b, x_i, jacobian[joint.i]),
                *(j.p, j.orientation, j.v_r, j.omega_b, x_j, jacobian[joint.j]),
                *(i.r, j.r),
                *(block for pair in pairs for block in pair),
                *self._of_parts(joint, output),
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
            for place, part in zip(joint.instances, joint.parts, strict=True):
                one = self.system.constraints[place]
                if one.is_driver:
                    rate = self.combinations.law(one, 1)
                    given = column([-entry for entry in rate.entries])
                    pairs.setdefault(one.joint, []).extend((given, solution.part(first, 1)))
                first += len(part.rows)
        return {
            name: self.recorder.call(CoordinateRate(), *own, column((0,)))[0]
            for name, own in pairs.items()
        }

    def _of_parts(self, joint: JointBlocks, output: str) -> list[SlotMatrix]:
        """Blocks that the parts of a joint take: constants, or what is combined of coordinates."""
        found: list[SlotMatrix] = []
        parts = zip(joint.instances, joint.parts, joint.constants, strict=True)
        for place, part, constants in parts:
            one = self.system.constraints[place]
            if not part.is_combination:
                found += constants
            elif output == "C":
                found.append(self.combinations.residual(one))
                found += (self.combinations.jacobian(one, k, self.body(k)) for k in joint.bodies)
            else:
                found.append(self.combinations.rate(one, output))
        return found
