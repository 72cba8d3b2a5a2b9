"""Circuits that no motion can close: a side that is longer than every other path of its ends."""

from __future__ import annotations

import heapq
from math import dist
from typing import TYPE_CHECKING

from kousoku.model.errors import SceneError

if TYPE_CHECKING:
    from collections.abc import Iterator

    from kousoku.model.records.scene import Scene

Neighbours = dict[str, list[tuple[str, float]]]
"""For each node its neighbours: the node at the other end of a link, and the length."""


def check_circuits(scene: Scene) -> None:
    """Check that no link, and no distance of fixed nodes, exceeds the other sides of a circuit.

    Raises
    ------
    SceneError
        The linkage cannot be assembled in any position.
    """
    graph: Neighbours = {node: [] for node in scene.nodes}
    for name, link in scene.links.items():
        for node in link.nodes:
            if not scene.is_ground(name):
                graph[node].append((link.other(node), scene.length(name)))
    tolerance = max(scene.residual_limit, 2.0**-40 * scene.largest_length)
    _check_links(scene, graph, tolerance)
    _check_frame(scene, graph, tolerance)


def _check_links(scene: Scene, graph: Neighbours, tolerance: float) -> None:
    for name, link in scene.links.items():
        first, second = link.nodes
        limit = scene.length(name) - tolerance  # excludes the path of the link itself
        for node, length in _shortest_paths(scene, graph, first, limit):
            if node == second and not scene.is_ground(name):
                raise SceneError(
                    f"cannot be assembled: its length {scene.length(name):.12g} {scene.unit} "
                    f"exceeds the rest of a circuit from {first} to {second}, which reaches only "
                    f"{length:.12g} {scene.unit}",
                    key=f"links.{name}",
                )


def _check_frame(scene: Scene, graph: Neighbours, tolerance: float) -> None:
    frame = {name: node.at for name, node in scene.nodes.items() if node.fixed}
    for first, origin in frame.items():
        reach = max(dist(origin, other) for other in frame.values())
        for node, length in _shortest_paths(scene, graph, first, reach, uses_frame=False):
            if node in frame and length < dist(origin, frame[node]) - tolerance:
                raise SceneError(
                    f"cannot be assembled: {first} and {node} are fixed "
                    f"{dist(origin, frame[node]):.12g} {scene.unit} apart, but the links between "
                    f"them reach only {length:.12g} {scene.unit}",
                    key=f"nodes.{node}.at",
                )


def _shortest_paths(
    scene: Scene, graph: Neighbours, start: str, limit: float, *, uses_frame: bool = True
) -> Iterator[tuple[str, float]]:
    """Nodes with the length of the shortest path from `start`, while it is below `limit`.

    Paths of Dijkstra's algorithm, along links, and with `uses_frame` between fixed nodes, too.
    """
    frame = [name for name, node in scene.nodes.items() if node.fixed] if uses_frame else []
    queue, reached = [(0.0, start)], set[str]()
    while queue:
        length, node = heapq.heappop(queue)
        if length >= limit:
            return
        if node in reached:
            continue
        reached.add(node)
        yield node, length
        for end, edge in graph[node]:
            heapq.heappush(queue, (length + edge, end))
        for end in frame if scene.nodes[node].fixed else ():
            edge = dist(scene.nodes[node].at, scene.nodes[end].at)
            if length + edge < limit and end not in reached:
                heapq.heappush(queue, (length + edge, end))
