"""Which bodies are one, because fixed joints hold them together."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.model.mechanism import COMBINATION, GROUND_INDEX

if TYPE_CHECKING:
    from collections.abc import Iterator

    from kousoku.model.mechanism import System

    #: The bodies that a fixed joint joins.
    Edge = tuple[int, int]

#: What a fixed joint is composed of.
RIGID = ["n1", "p1", "point"]
#: Joints of a body that is made of two that move: the rows of each are coupled with all others, and
#: with six revolute joints that costs more than the fixed joint.
MOST_JOINTS = 4
#: Kinds of constraints and of forces that are known to mean the same in another frame.
CONSTRAINTS = frozenset({"point", "distance", "n1", "n2", "p1", "p2", COMBINATION})
FORCES = frozenset(
    {"force", "torque", "force_b", "torque_b", "spring_damper", "along", "coordinate_spring"}
)


def grouped(system: System) -> tuple[tuple[int, ...], ...]:
    """Return the bodies that are one, in groups of two and more; what stands still with the ground.

    A group is left as it is where a coordinate lies in it, or a force whose work is told or whose
    energy depends on parameters, or where a force or constraint is not known to mean the same in
    the frame of another body; and all are where nothing else would move.
    Two that move are not made one where that one would have more than :data:`MOST_JOINTS` joints:
    it would cost more than it saves.
    """
    edges = fixed_joints(system)
    count = len(system.bodies)
    leaders = _Leaders(count)
    beside: list[list[int]] = [[] for _ in range(count + 1)]
    for i, j in edges:
        beside[i].append(j)
        beside[j].append(i)
    waiting = [GROUND_INDEX]
    while waiting:
        body = waiting.pop()
        for other in beside[body]:
            if leaders.join(GROUND_INDEX, other):
                waiting.append(other)
    joints = _joint_counts(system, edges)
    for i, j in edges:
        a, b = leaders.of(i), leaders.of(j)
        if a != b and joints[a] + joints[b] <= MOST_JOINTS:
            leaders.join(a, b)
            joints[leaders.of(a)] = joints[a] + joints[b]
    spoiled = {leaders.of(body) for body in _kept(system, leaders)}
    members: dict[int, list[int]] = {}
    for body in range(GROUND_INDEX, count):
        members.setdefault(leaders.of(body), []).append(body)
    if len(members) == 1 and GROUND_INDEX in members:
        return ()
    found = (group for leader, group in members.items() if leader not in spoiled)
    return tuple(tuple(group) for group in found if len(group) > 1)


class _Leaders:
    """Disjoint sets of bodies, each with the lowest of its members as its leader."""

    def __init__(self, count: int) -> None:
        #: The ground stands last, where its index −1 finds it.
        self._above = [*range(count), GROUND_INDEX]

    def of(self, body: int) -> int:
        """Return the leader of a body."""
        while self._above[body] != body:
            self._above[body] = self._above[self._above[body]]
            body = self._above[body]
        return body

    def join(self, a: int, b: int) -> bool:
        """Make two sets one; return whether they were two."""
        low, high = sorted((self.of(a), self.of(b)))
        self._above[high] = low
        return low != high


def fixed_joints(system: System) -> list[Edge]:
    """Return the bodies of each joint that leaves no motion."""
    kinds: dict[tuple[str, int, int], list[str]] = {}
    for one in system.constraints:
        kinds.setdefault((one.joint, one.i, one.j), []).append(one.kind.partition("_")[0])
    return [(i, j) for (_, i, j), parts in kinds.items() if i != j and sorted(parts) == RIGID]


def _joint_counts(system: System, edges: list[Edge]) -> dict[int, int]:
    """Return how many joints each body has beside those that are fixed."""
    joints = dict.fromkeys((one.joint, one.bodies) for one in system.constraints)
    counts = dict.fromkeys(range(GROUND_INDEX, len(system.bodies)), 0)
    for _, bodies in joints:
        for body in bodies:
            counts[body] += 1
    for edge in edges:
        for body in edge:
            counts[body] -= 1
    return counts


def _kept(system: System, leaders: _Leaders) -> Iterator[int]:
    """Yield a body of each group that is left as it is."""
    for coordinate in system.coordinates:
        if leaders.of(coordinate.i) == leaders.of(coordinate.j):
            yield coordinate.i
    for one in system.constraints:
        name, _, axis = one.kind.partition("_")
        if (name if len(axis) == 1 else one.kind) not in CONSTRAINTS:
            yield from one.bodies
    for force in system.forces:
        is_inner = leaders.of(force.i) == leaders.of(force.j)
        if force.kind not in FORCES or (is_inner and (force.works or force.formulas)):
            yield from (force.i, force.j)
    if any(system.gravity_law):
        yield GROUND_INDEX
