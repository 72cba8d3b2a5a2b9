"""Reactions of joints on their bodies: the segment ``reaction``."""

from __future__ import annotations

from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.composition.least_norm import LeastNorm, merged
from kousoku.codegen.dynamics.operations.joint_ends import loaded_bodies
from kousoku.codegen.dynamics.recording.recorder import zeros
from kousoku.model.mechanics.multibody import GROUND_INDEX

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from kousoku.codegen.dynamics.composition.joints import JointBlocks
    from kousoku.codegen.dynamics.composition.least_norm import Scale
    from kousoku.codegen.dynamics.composition.schur import Schur
    from kousoku.codegen.dynamics.recording.recorder import Recorder, SlotMatrix
    from kousoku.codegen.dynamics.simplification.body_blocks import BodyBlocks


@dataclass(slots=True)
class Reaction:
    """A joint: the rows of it that are kept, and those that are left out.

    Parameters
    ----------
    name : str
        As in the scene.
    end, j : int
        The body that force and torque act on: body j, or i where j is the ground; and body j.
    ends : tuple of int
        The bodies whose force and torque are recorded, see
        :mod:`~kousoku.codegen.dynamics.operations.joint_ends`.
    kept, left_out : JointBlocks or None
        With their Jacobians; one of them is there, unless all rows are satisfied.
    satisfied : JointBlocks or None
        Rows that joint coordinates satisfy: their forces are known without multipliers.
    multipliers : list of (JointBlocks, SlotMatrix)
        Rows, and their multipliers.
    """

    name: str
    end: int
    j: int
    ends: tuple[int, ...]
    kept: JointBlocks | None = None
    left_out: JointBlocks | None = None
    satisfied: JointBlocks | None = None
    multipliers: list[tuple[JointBlocks, SlotMatrix]] = field(default_factory=list)

    @property
    def blocks(self) -> list[JointBlocks]:
        """All rows of it."""
        return [rows for rows in (self.kept, self.left_out, self.satisfied) if rows]


def reactions_of(
    kept: Sequence[JointBlocks],
    left_out: Sequence[JointBlocks],
    satisfied: Sequence[JointBlocks] = (),
) -> list[Reaction]:
    """Reactions of all joints in the order of the system."""
    reactions: dict[tuple[str, int, int], Reaction] = {}
    for joint in (*kept, *left_out, *satisfied):
        ends = loaded_bodies(joint.bodies)
        end = joint.i if joint.j == GROUND_INDEX else joint.j
        new = Reaction(joint.name, end, joint.j, ends)
        reaction = reactions.setdefault((joint.name, joint.i, joint.j), new)
        if any(joint is rows for rows in kept):
            reaction.kept = joint
        elif any(joint is rows for rows in satisfied):
            reaction.satisfied = joint
        else:
            reaction.left_out = joint
    return sorted(reactions.values(), key=lambda x: min(min(rows.instances) for rows in x.blocks))


def record_reactions(
    recorder: Recorder,
    schur: Schur,
    body: Callable[[int], BodyBlocks],
    *,
    rows: tuple[Sequence[JointBlocks], Sequence[JointBlocks]],
    geometry: Callable[[JointBlocks], None],
    scale: Scale,
    satisfied: Sequence[JointBlocks] = (),
    ground: Callable[[], Mapping[tuple[str, int], SlotMatrix]] = dict,
    in_loops: bool = False,
) -> None:
    """Record force and torque of each joint on the bodies that :func:`loaded_bodies` gives.

    They are −C_qᵀλ (c,): force [N] in frame O, torque [N m] about the centre of mass in the
    principal frame.

    Parameters
    ----------
    recorder : Recorder
        The program; it has the region ``lam``.
    schur : Schur
        The factors of the rows that are kept.
    body : callable
        The blocks of a body by its index.
    rows : pair of sequence of JointBlocks
        The rows that are kept, with their Jacobians, and those that depend on them.
    geometry : callable
        Records the Jacobians of the latter.
    scale : Scale
        Weights of the squares that are least where reactions are not unique.
    satisfied : sequence of JointBlocks
        Joints with the ground that bodies are put onto.
    ground : callable
        Records force and torque of these, by the name of the joint and the body.
    in_loops : bool
        Whether a run finds them with :func:`record_wrenches`: then there is their region alone.
    """
    joints, left_out = rows
    reactions = reactions_of(joints, left_out, satisfied)
    widths = [len(body(end).columns) for joint in reactions for end in joint.ends]
    target = recorder.region("reactions", sum(widths))
    if in_loops:
        return
    lam = recorder.known("lam")
    recorder.begin("reaction")
    wrenches = ground()
    for joint in reactions:
        if joint.kept:
            joint.multipliers = [(joint.kept, lam.part(joint.kept.first, joint.kept.count))]
    for block in left_out:
        geometry(block)
    groups = scale.shared.groups
    for group in merged([[joint.name for joint in reactions]] if groups is None else groups):
        members = [joint for joint in reactions if joint.name in group]
        if any(joint.left_out for joint in members):
            LeastNorm(recorder, schur, body, joints, scale).share_out(members)
    _write_reactions(schur, reactions, widths, target, wrenches)


def _write_reactions(
    schur: Schur,
    reactions: Sequence[Reaction],
    widths: Sequence[int],
    target: SlotMatrix,
    wrenches: Mapping[tuple[str, int], SlotMatrix] = MappingProxyType({}),
) -> None:
    """Record force and torque of each joint on its bodies, of its multipliers."""
    first = 0
    ends = ((joint, end) for joint in reactions for end in joint.ends)
    for (joint, end), width in zip(ends, widths, strict=True):
        products = [(rows.c_q[end].T, x) for rows, x in joint.multipliers if end in rows.c_q]
        total = wrenches.get((joint.name, end)) or zeros(width, 1)
        schur.gather(total, products, target.part(first, width))
        first += width


def record_wrenches(
    recorder: Recorder,
    schur: Schur,
    body: Callable[[int], BodyBlocks],
    *,
    rows: tuple[Sequence[JointBlocks], Sequence[JointBlocks]],
    geometry: Callable[[JointBlocks], None],
    scale: Scale,
) -> None:
    """Record the forces of joints for any multipliers of all rows: the segment ``wrench``.

    It gives reactions −C_qᵀλ (c,) [N, N m] as :func:`record_reactions` does, and at its point force
    and torque / ℓ (6,) of each joint, frame O, whose squares are least where reactions are not
    unique; behind them the weighted multipliers of constraints that have idle rows. Parameters
    are those of that function.
    """
    joints, left_out = rows
    reactions = reactions_of(joints, left_out)
    least = LeastNorm(recorder, schur, body, joints, scale)
    kept = sum(block.count for block in joints)
    lam = recorder.region("all_lam", kept + sum(block.count for block in left_out))
    idle = {id(joint): least.idle_rows(joint) for joint in reactions}
    size = sum(least.height(joint) + sum(n for *_, n in idle[id(joint)]) for joint in reactions)
    wrenches = recorder.region("wrenches", size)
    recorder.begin("wrench")
    for block in left_out:
        geometry(block)
    first = 0
    for joint in reactions:
        starts = ((part, 0 if part is joint.kept else kept) for part in joint.blocks)
        joint.multipliers = [
            (part, lam.part(start + part.first, part.count)) for part, start in starts
        ]
        least.wrench(joint, wrenches.part(first, least.height(joint)))
        first += least.height(joint)
        multipliers = {id(part): x for part, x in joint.multipliers}
        for part, row, count in idle[id(joint)]:
            least.multipliers(multipliers[id(part)].part(row, count), wrenches.part(first, count))
            first += count
    widths = [len(body(end).columns) for joint in reactions for end in joint.ends]
    _write_reactions(schur, reactions, widths, recorder.known("reactions"))
