"""Components of force and torque of joints that the motion does not determine.

Rows that depend on each other have multipliers that cancel each other on all bodies, and can be
added to any others. The wrench of such multipliers at a joint is not determined; a component of
force and torque that is zero for all of them is unique, though rows of the joint take part.
"""

from __future__ import annotations

from itertools import chain
from typing import TYPE_CHECKING

import numpy as np

from kousoku.codegen.dynamics.operations.joint_ends import loaded_bodies, points_of
from kousoku.model.mechanics.multibody import GROUND_INDEX
from kousoku.runtime.integrate.euler_parameters import crossed, rotated
from kousoku.runtime.integrate.motion import JOINT

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    from kousoku.codegen.dynamics.recording.program import RowIndex
    from kousoku.codegen.dynamics.redundancy.branch import Branch, BranchPosition
    from kousoku.codegen.dynamics.redundancy.loops import LoopPart
    from kousoku.model.mechanics.multibody import System
    from kousoku.model.numbers.real import Array

    #: Joints, and the columns of their force and torque that are not unique.
    Undetermined = tuple[tuple[str, tuple[str, ...]], ...]

#: Names of the components of force and torque.
COLUMNS = tuple(chain.from_iterable(JOINT.values()))
#: Positions that are looked at: where a scene starts, directions may be special.
POSITIONS_LOOKED_AT = 3


def undetermined(
    system: System,
    part: LoopPart,
    branch: Branch,
    rows: Sequence[RowIndex],
    positions: Sequence[BranchPosition],
    *,
    joints: Collection[str],
    takes_part: float,
) -> Undetermined:
    """Components of joints that are not unique at some of the positions.

    Parameters
    ----------
    system : System
        The scene.
    part : LoopPart
        The part of it that loops connect.
    branch : Branch
        The branch on which the part moves.
    rows : sequence of RowIndex
        Rows of joints of the part.
    positions : sequence of BranchPosition
        Positions at which these depend on each other.
    joints : collection of str
        Joints whose rows take part.
    takes_part : float
        Limit, in lengths of the scene and radians, up to which a component counts as zero.

    Returns
    -------
    tuple of (str, tuple of str)
        Joints with columns such as ``"fx"`` and ``"mz"``: force and torque at the joint's point in
        frame O, as results have them.
    """
    points, length = points_of(system), branch.length
    steps = range(0, len(positions), max(1, (len(positions) - 1) // (POSITIONS_LOOKED_AT - 1)))
    groups = [[k for k, row in enumerate(rows) if row.joint == joint] for joint in joints]
    ends = []
    for joint, group in zip(joints, groups, strict=True):
        instances = [system.constraints[rows[k].instance] for k in group]
        bodies = tuple(dict.fromkeys(body for instance in instances for body in instance.bodies))
        ends.append((bodies, np.array(points.get(joint, (0.0, 0.0, 0.0))) / length))
    largest = np.zeros((len(groups), len(COLUMNS)))
    for position in (positions[k] for k in steps):
        reactions = branch.reaction_directions(position, groups)
        for k, ((bodies, point), directions) in enumerate(zip(ends, reactions, strict=True)):
            for end in loaded_bodies(bodies):
                base = end if len(bodies) > 2 else bodies[1]
                arm = np.array(system.bodies[end].origin_b) / length if len(bodies) > 2 else point
                body = part.bodies.index(end)
                at = arm if base == GROUND_INDEX else _point(position, part.bodies.index(base), arm)
                wrench = _wrench_at(position, body, directions[:, body], at)
                largest[k] = np.maximum(largest[k], np.abs(wrench).max(axis=0, initial=0.0))
    not_unique = []
    for joint, sizes in zip(joints, largest.tolist(), strict=True):
        names = tuple(name for name, x in zip(COLUMNS, sizes, strict=True) if x > takes_part)
        if names:  # a joint that is not listed counts with all components
            not_unique.append((joint, names))
    return tuple(not_unique)


def _point(position: BranchPosition, body: int, arm: Array) -> Array:
    """Position of a point of a body."""
    point: Array = position.r[body] + rotated(position.p[body], arm)
    return point


def _wrench_at(position: BranchPosition, body: int, directions: Array, point: Array) -> Array:
    """Wrench at a point in frame O, from force and torque at the centre of mass of a body."""
    force, torque_b = directions[:, :3].T, directions[:, 3:].T
    p = position.p[body][:, np.newaxis]
    arm = (position.r[body] - point)[:, np.newaxis]
    torque = rotated(p, torque_b) + crossed(np.broadcast_to(arm, force.shape), force)
    return np.concatenate([force, torque]).T
