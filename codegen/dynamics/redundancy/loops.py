"""Parts of a system whose joints close loops; trees that hang on them are left out.

Two joints are in one part when some loop passes both, the ground being a body that loops may pass.
Constraints between bodies do not depend on a common motion of all of these. So parts that share one
body or none do not affect each other's ranks, and the rows of a joint in no loop are independent.

A joint may connect more than two bodies, as a gear between the joints of two wheels does: it is a
vertex of its own, with an edge to each of its bodies, and these edges stay in one part.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.disjoint_sets import DisjointSets
from kousoku.model.mechanics.multibody import GROUND_INDEX

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from kousoku.model.mechanics.multibody import System


@dataclass(frozen=True, slots=True)
class LoopPart:
    """Bodies and joints that loops connect.

    Parameters
    ----------
    bodies : tuple of int
        Moving bodies, in the order of the system.
    instances : tuple of int
        Indices of the constraints in the system.
    is_grounded : bool
        Whether the ground is one of its bodies.
    """

    bodies: tuple[int, ...]
    instances: tuple[int, ...]
    is_grounded: bool


def loops_of(system: System) -> tuple[LoopPart, ...]:
    """Parts of a system that loops connect, in the order of their first constraints."""
    joints: dict[tuple[object, ...], list[int]] = {}
    for index, instance in enumerate(system.constraints):
        key = (instance.joint, *sorted(instance.bodies))
        joints.setdefault(key, []).append(index)
    instances_of = list(joints.values())
    bodies = [system.constraints[indices[0]].bodies for indices in instances_of]
    parts = []
    for group in _groups(len(system.bodies), bodies):
        if len(group) > 1:
            connected = sorted({body for joint in group for body in bodies[joint]})
            instances = sorted(index for joint in group for index in instances_of[joint])
            moving = tuple(body for body in connected if body != GROUND_INDEX)
            parts.append(LoopPart(moving, tuple(instances), GROUND_INDEX in connected))
    return tuple(sorted(parts, key=lambda part: part.instances))


def _groups(count: int, bodies: Sequence[Sequence[int]]) -> list[list[int]]:
    """Joints of each loop part, from the bodies of each joint."""
    ends: list[tuple[int, int]] = []
    joint_of: list[int] = []
    vertices = count
    for joint, connected in enumerate(bodies):
        if len(connected) == 2:
            ends.append((connected[0], connected[1]))
            joint_of.append(joint)
            continue
        ends += [(vertices, body) for body in connected]
        joint_of += [joint] * len(connected)
        vertices += 1
    joints = DisjointSets(range(len(bodies)))
    for edges in _biconnected(vertices, ends):
        for edge in edges[1:]:
            joints.join(joint_of[edges[0]], joint_of[edge])
    return joints.sets()


def _biconnected(count: int, ends: Sequence[tuple[int, int]]) -> Iterator[list[int]]:
    """Edges of each biconnected component; vertices are −1 … count − 1 (Tarjan)."""
    edges_at: dict[int, list[tuple[int, int]]] = {k: [] for k in range(-1, count)}
    for edge, (i, j) in enumerate(ends):
        edges_at[i].append((edge, j))
        edges_at[j].append((edge, i))
    number: dict[int, int] = {}
    low: dict[int, int] = {}
    stack: list[int] = []
    for root in range(-1, count):
        if root in number:
            continue
        number[root] = low[root] = len(number)
        path: list[tuple[int, int, Iterator[tuple[int, int]]]] = [(root, -1, iter(edges_at[root]))]
        while path:
            vertex, entry, remaining = path[-1]
            for edge, other in remaining:
                if edge == entry:
                    continue
                if other not in number:
                    number[other] = low[other] = len(number)
                    stack.append(edge)
                    path.append((other, edge, iter(edges_at[other])))
                    break
                if number[other] < number[vertex]:
                    stack.append(edge)
                    low[vertex] = min(low[vertex], number[other])
            else:
                path.pop()
                if path:
                    parent = path[-1][0]
                    low[parent] = min(low[parent], low[vertex])
                    if low[vertex] >= number[parent]:
                        start = stack.index(entry)
                        yield stack[start:]
                        del stack[start:]
