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
        What is eliminated.
    neighbours : tuple of int
        What is coupled with it and still there, in the order in which it will be eliminated.
    """

    joint: int
    neighbours: tuple[int, ...]


def minimum_degree(
    count: int, pairs: Iterable[tuple[int, int]], *, at_once: bool = True
) -> tuple[Pivot, ...]:
    """Order that eliminates the node with the fewest neighbours.

    Of equals that comes which has to wait for the fewest others, one after another: a chain is
    eliminated from both ends in turn, and a processor works on both at once. Or the first comes.

    Parameters
    ----------
    count : int
        Count of joints, numbered from 0.
    pairs : iterable of (int, int)
        Which are coupled.
    at_once : bool
        Whether the order may leave a processor several pivots to work on at once.
    """
    beside: list[dict[int, None]] = [{} for _ in range(count)]
    for a, b in pairs:
        beside[a][b] = beside[b][a] = None
    levels = [0] * count
    queue = [(len(neighbours), 0, joint) for joint, neighbours in enumerate(beside)]
    heapq.heapify(queue)
    order: list[tuple[int, tuple[int, ...]]] = []
    place: dict[int, int] = {}
    while queue:
        degree, level, joint = heapq.heappop(queue)
        if joint in place or (degree, level) != (len(beside[joint]), levels[joint]):
            continue
        place[joint] = len(order)
        neighbours = tuple(beside[joint])
        order.append((joint, neighbours))
        for a in neighbours:
            del beside[a][joint]
            beside[a].update((b, None) for b in neighbours if b != a)
            levels[a] = max(levels[a], level + 1) if at_once else 0
            heapq.heappush(queue, (len(beside[a]), levels[a], a))
    return tuple(
        Pivot(joint, tuple(sorted(neighbours, key=place.__getitem__)))
        for joint, neighbours in order
    )
