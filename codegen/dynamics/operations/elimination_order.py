"""Order in which joints are eliminated, and the fill-in that follows from it."""

from __future__ import annotations

import heapq
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable


@dataclass(frozen=True, slots=True)
class Pivot:
    """One step of the elimination.

    Parameters
    ----------
    joint : int
        Joint that is eliminated.
    neighbours : tuple of int
        Joints that are coupled with it and not yet eliminated, in the order of elimination.
    """

    joint: int
    neighbours: tuple[int, ...]


def minimum_degree(
    count: int, pairs: Iterable[tuple[int, int]], *, at_once: bool = True
) -> tuple[Pivot, ...]:
    """Order that eliminates the node with the fewest neighbours.

    Among equals that one comes first which waits for the shortest sequence of others: a chain is
    eliminated from both ends in turn, and a processor works on both at once. Unless ``at_once``
    the lowest number comes first.

    Parameters
    ----------
    count : int
        Count of joints, numbered from 0.
    pairs : iterable of (int, int)
        Pairs that are coupled.
    at_once : bool
        Whether the order may leave a processor several pivots to work on at once.
    """
    adjacent: list[dict[int, None]] = [{} for _ in range(count)]
    for a, b in pairs:
        adjacent[a][b] = adjacent[b][a] = None
    levels = [0] * count
    queue = [(len(neighbours), 0, joint) for joint, neighbours in enumerate(adjacent)]
    heapq.heapify(queue)
    order: list[tuple[int, tuple[int, ...]]] = []
    position: dict[int, int] = {}
    while queue:
        degree, level, joint = heapq.heappop(queue)
        if joint in position or (degree, level) != (len(adjacent[joint]), levels[joint]):
            continue
        position[joint] = len(order)
        neighbours = tuple(adjacent[joint])
        order.append((joint, neighbours))
        for a in neighbours:
            del adjacent[a][joint]
            adjacent[a].update((b, None) for b in neighbours if b != a)
            levels[a] = max(levels[a], level + 1) if at_once else 0
            heapq.heappush(queue, (len(adjacent[a]), levels[a], a))
    return tuple(
        Pivot(joint, tuple(sorted(neighbours, key=position.__getitem__)))
        for joint, neighbours in order
    )
