"""The tasks of joints: residuals, Jacobians, and what they ask of velocities and accelerations."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.coordinates import Along
from kousoku.codegen.dynamics.operations import Joint, Rates
from kousoku.codegen.dynamics.recorder import column
from kousoku.model.mechanism import COMBINATION, GROUND_INDEX

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from kousoku.codegen.dynamics.bodies import BodyBlocks
    from kousoku.codegen.dynamics.combinations import Combinations
    from kousoku.codegen.dynamics.joints import JointBlocks
    from kousoku.codegen.dynamics.recorder import Block, Recorder
    from kousoku.model.mechanism import System


@dataclass(frozen=True, slots=True)
class JointTasks:
    """What records the rows of joints.

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

    def jacobian(self, joint: JointBlocks, residuals: Block | None) -> None:
        """Record C and C_q of a joint, and put C_q into it; ``residuals`` says where C goes."""
        (i, j, *others), n = map(self.body, joint.bodies), len(joint.bodies)
        _, *found, joint.own = self.recorder.call(
            Joint(joint.parts, tuple(one.columns for one in (i, j, *others))),
            *(i.r, i.p, i.orientation, i.inverse_mass),
            *(j.r, j.p, j.orientation, j.inverse_mass),
            *(one.inverse_mass for one in others),
            *self._of_parts(joint, "C"),
            into=(residuals,),
        )
        joint.jacobian = dict(zip(joint.bodies, found[:n], strict=True))
        joint.scaled = dict(zip(joint.bodies, found[n:], strict=True))

    def rates(
        self, joint: JointBlocks, output: str, by_body: Sequence[Block], into: Block | None
    ) -> Block:
        """Record C_q x minus ν or γ of a joint, for x in the order of v, body by body."""
        i, j = self.body(joint.i), self.body(joint.j)
        x_i, x_j, *others = (column(()) if k == GROUND_INDEX else by_body[k] for k in joint.bodies)
        slopes = (joint.jacobian[k] for k in joint.others)
        (difference,) = self.recorder.call(
            Rates(joint.parts, output, len(others)),
            *(i.p, i.orientation, i.v_r, i.omega_b, x_i, joint.jacobian[joint.i]),
            *(j.p, j.orientation, j.v_r, j.omega_b, x_j, joint.jacobian[joint.j]),
            *(i.r, j.r),
            *(block for pair in zip(others, slopes, strict=True) for block in pair),
            *self._of_parts(joint, output),
            into=(into,),
        )
        return difference

    def powers(
        self, joints: Sequence[JointBlocks], multipliers: Sequence[Block]
    ) -> dict[str, Block]:
        """Record what each driver does to the bodies, −λ·ν, by the name of the driver [W]."""
        pairs: dict[str, list[Block]] = {}
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
            name: self.recorder.call(Along(), *own, column((0,)))[0] for name, own in pairs.items()
        }

    def _of_parts(self, joint: JointBlocks, output: str) -> list[Block]:
        """Return what the parts of a joint take: constants, or what is combined of coordinates."""
        found: list[Block] = []
        parts = zip(joint.instances, joint.parts, joint.constants, strict=True)
        for place, part, constants in parts:
            one = self.system.constraints[place]
            if part.kind != COMBINATION:
                found += constants
            elif output == "C":
                found.append(self.combinations.residual(one))
                found += (self.combinations.slopes(one, k, self.body(k)) for k in joint.bodies)
            else:
                found.append(self.combinations.rate(one, output))
        return found
