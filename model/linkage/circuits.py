"""Circuits that no motion can close: a side that is longer than every way round it."""

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
    """Check that no link, and no distance in the frame, exceeds the rest of a circuit.

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
        limit = scene.length(name) - tolerance  # the link itself is too long to be a way
        for node, way in _ways(scene, graph, first, limit):
            if node == second and not scene.is_ground(name):
                raise SceneError(
                    f"cannot be assembled: its length {scene.length(name):.12g} {scene.unit} "
                    f"exceeds the rest of a circuit from {first} to {second}, which reaches only "
                    f"{way:.12g} {scene.unit}",
                    key=f"links.{name}",
                )


def _check_frame(scene: Scene, graph: Neighbours, tolerance: float) -> None:
    frame = {name: node.at for name, node in scene.nodes.items() if node.fixed}
    for first, origin in frame.items():
        reach = max(dist(origin, other) for other in frame.values())
        for node, way in _ways(scene, graph, first, reach, jumps=False):
            if node in frame and way < dist(origin, frame[node]) - tolerance:
                raise SceneError(
                    f"cannot be assembled: {first} and {node} are fixed "
                    f"{dist(origin, frame[node]):.12g} {scene.unit} apart, but the links between "
                    f"them reach only {way:.12g} {scene.unit}",
                    key=f"nodes.{node}.at",
                )


def _ways(
    scene: Scene, graph: Neighbours, start: str, limit: float, *, jumps: bool = True
) -> Iterator[tuple[str, float]]:
    """Nodes with their shortest way from `start`, as long as it is below `limit`.

    The frame is a way between fixed nodes where `jumps` says so.
    """
    frame = [name for name, node in scene.nodes.items() if node.fixed] if jumps else []
    queue, reached = [(0.0, start)], set[str]()
    while queue:
        way, node = heapq.heappop(queue)
        if way >= limit:
            return
        if node in reached:
            continue
        reached.add(node)
        yield node, way
        for end, length in graph[node]:
            heapq.heappush(queue, (way + length, end))
        for end in frame if scene.nodes[node].fixed else ():
            length = dist(scene.nodes[node].at, scene.nodes[end].at)
            if way + length < limit and end not in reached:
                heapq.heappush(queue, (way + length, end))
