"""What joints do to their bodies: the segment ``reaction``."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.recorder import Block, column, zeros
from kousoku.model.mechanism import GROUND_INDEX

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.codegen.dynamics.bodies import BodyBlocks
    from kousoku.codegen.dynamics.joints import JointBlocks
    from kousoku.codegen.dynamics.recorder import Recorder
    from kousoku.codegen.dynamics.schur import Schur


def record_reactions(
    recorder: Recorder, schur: Schur, joints: Sequence[JointBlocks], bodies: Sequence[BodyBlocks]
) -> None:
    """Record force and torque of each joint on body j, or on i where j is the ground.

    Parameters
    ----------
    recorder : Recorder
        Where they are recorded; it has the region ``lam``.
    schur : Schur
        The factors of C_q M⁻¹ C_qᵀ.
    joints : sequence of JointBlocks
        With their Jacobians.
    bodies : sequence of BodyBlocks
        In the order of the system.
    """
    lam = _region(recorder, "lam")
    ends = [joint.i if joint.j == GROUND_INDEX else joint.j for joint in joints]
    widths = [len(bodies[end].columns) for end in ends]
    target = recorder.region("reactions", sum(widths))
    recorder.begin("reaction")
    first = 0
    for joint, end, width in zip(joints, ends, widths, strict=True):
        product = (joint.jacobian[end].T, lam.part(joint.first, joint.count))
        schur.gather(zeros(width, 1), [product], target.part(first, width))
        first += width


def _region(recorder: Recorder, name: str) -> Block:
    """Return a region that was set aside before, as a column."""
    region = next(one for one in recorder.regions if one.name == name)
    return column(range(region.base + 2, region.base + region.size + 2))
