"""Groups of bodies that fixed joints connect rigidly."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.disjoint_sets import DisjointSets
from kousoku.codegen.dynamics.elements.force_facets import facets_of
from kousoku.model.elements.joints import JOINTS
from kousoku.model.lowering.moved import moved_by_parameters
from kousoku.model.mechanics.constraints import base_of, is_known
from kousoku.model.mechanics.multibody import GROUND_INDEX

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from kousoku.model.mechanics.multibody import System

    #: The bodies that a fixed joint joins.
    Edge = tuple[int, int]

#: Kinds of the constraints of a fixed joint.
RIGID = sorted(part.kind for part in JOINTS["fixed"].parts)
#: Joints at most of a composite of two moving bodies: the rows of each joint are coupled with all
#: others, and with six revolute joints that costs more than the fixed joint.
MOST_JOINTS_OF_PAIR = 4


def grouped(system: System) -> tuple[tuple[int, ...], ...]:
    """Groups of two and more bodies that become one; those fixed to the ground with the ground.

    Two bodies of a group stay apart if there is a coordinate between them, or a force whose work is
    reported or whose energy depends on parameters; so does a body with a force or constraint that
    is not known to mean the same in another frame, and the ground where gravity depends on
    parameters. All bodies do where nothing else would move. Two moving bodies are not joined where
    the composite would have more than :data:`MOST_JOINTS_OF_PAIR` joints: it would cost more than
    it saves.
    """
    fixed = fixed_joints(system)
    edges = [edge for edge in fixed if not (GROUND_INDEX in edge and any(system.gravity_law))]
    count = len(system.bodies)
    joints = _joint_counts(system, fixed)
    leaders = _joined(count, edges, joints)
    while kept := _kept(system, leaders) & {body for edge in edges for body in edge}:
        edges = [edge for edge in edges if kept.isdisjoint(edge)]
        leaders = _joined(count, edges, joints)
    groups = leaders.sets()
    if len(groups) == 1:
        return ()
    return tuple(tuple(group) for group in groups if len(group) > 1)


def _joined(count: int, edges: Sequence[Edge], counts: Mapping[int, int]) -> DisjointSets:
    """Groups that fixed joints connect: first the bodies that they fix to the ground."""
    leaders = DisjointSets(range(GROUND_INDEX, count))
    neighbours: dict[int, list[int]] = {}
    for i, j in edges:
        neighbours.setdefault(i, []).append(j)
        neighbours.setdefault(j, []).append(i)
    waiting = [GROUND_INDEX]
    while waiting:
        for other in neighbours.get(waiting.pop(), ()):
            if leaders.join(GROUND_INDEX, other):
                waiting.append(other)
    joints = dict(counts)
    for i, j in edges:
        a, b = leaders.of(i), leaders.of(j)
        if a != b and joints[a] + joints[b] <= MOST_JOINTS_OF_PAIR:
            leaders.join(a, b)
            joints[leaders.of(a)] = joints[a] + joints[b]
    return leaders


def fixed_joints(system: System) -> list[Edge]:
    """Pairs of bodies whose joint leaves no motion."""
    kinds: dict[tuple[str, int, int], list[str]] = {}
    for c in system.constraints:
        if moved_by_parameters(system, c):
            continue
        kinds.setdefault((c.joint, c.i, c.j), []).append(base_of(c.kind))
    return [(i, j) for (_, i, j), parts in kinds.items() if i != j and sorted(parts) == RIGID]


def _joint_counts(system: System, edges: list[Edge]) -> dict[int, int]:
    """Number of joints of each body beside those that are fixed."""
    joints = dict.fromkeys((c.joint, c.bodies) for c in system.constraints)
    counts = dict.fromkeys(range(GROUND_INDEX, len(system.bodies)), 0)
    for _, bodies in joints:
        for body in bodies:
            counts[body] += 1
    for edge in edges:
        for body in edge:
            counts[body] -= 1
    return counts


def _kept(system: System, leaders: DisjointSets) -> set[int]:
    """Bodies that must not be joined with others of their groups."""
    kept: set[int] = set()
    for coordinate in system.coordinates:
        if leaders.of(coordinate.i) == leaders.of(coordinate.j):
            kept |= {coordinate.i, coordinate.j}
    for instance in system.constraints:
        is_inner = len({leaders.of(body) for body in instance.bodies}) == 1
        opens = is_inner and moved_by_parameters(system, instance)
        if opens or not is_known(instance.kind):
            kept |= {*instance.bodies}
    for force in system.forces:
        is_inner = leaders.of(force.i) == leaders.of(force.j)
        is_carried = facets_of(force).is_carried
        if not is_carried or (is_inner and (force.is_nonconservative or force.formulas)):
            kept |= {force.i, force.j}
    return kept - {GROUND_INDEX}
