"""Rotations of links at nodes, merged where a rigid connection or an input ties them together."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING

from kousoku.model.numbers.directions import heading

if TYPE_CHECKING:
    from kousoku.model.records.scene import Scene


@dataclass(frozen=True, slots=True)
class NodeRotation:
    """Rotation at a node: of one link where it is hinged, of several where they are rigid.

    β of each link in frame O, Yamada and Tatsumi (1981), (10) and (11), is that of the first + its
    angle.

    Parameters
    ----------
    node : str
        The node.
    links : tuple of str
        The links that turn together; the angle of the first is the coordinate.
    angles : tuple of Fraction [rad], (links,)
        Angle from the first link to each, counter-clockwise, seen from the node.
    input : str
        The input that prescribes the angle of the first link, empty where it is unknown.
    """

    node: str
    links: tuple[str, ...]
    angles: tuple[Fraction, ...]
    input: str = ""


def merge_rotations(scene: Scene, notes: list[str]) -> tuple[NodeRotation, ...]:
    """Rotations of a scene, node by node; merged ones are appended to ``notes``."""
    inputs = {
        (item.link, item.about): name
        for name, item in scene.inputs.items()
        if item.link is not None and item.about is not None
    }
    rotations: list[NodeRotation] = []
    for node in scene.nodes:
        merged: set[str] = set()
        for link in (name for name, item in scene.links.items() if node in item.nodes):
            if link in merged:
                continue
            angles = _tied(scene, node, link)
            merged |= angles.keys()
            rotation = _from_input(node, angles, inputs)
            if len(angles) > 1:
                notes.append(
                    f"rotations of {', '.join(rotation.links)} at {node} merged: rigid connection"
                )
            if len(angles) > 1 or not scene.is_ground(link):
                rotations.append(rotation)
    return tuple(rotations)


def _tied(scene: Scene, node: str, first: str) -> dict[str, Fraction]:
    """Links tied to ``first`` at a node, each with its angle from ``first``."""
    angles = {first: Fraction(0)}
    queue = [first]
    used: set[str] = set()
    while queue:
        link = queue.pop(0)
        for key, rigid in scene.rigid.items():
            if rigid.at != node or link not in rigid.links or key in used:
                continue
            used.add(key)
            for other in rigid.links:
                if other != link:
                    angles[other] = angles[link] + _angle(scene, key, link, other)
                    queue.append(other)
    return angles


def _angle(scene: Scene, key: str, link: str, other: str) -> Fraction:
    """Angle from one link of a rigid connection to another one."""
    return _from_base(scene, key, other) - _from_base(scene, key, link)


def _from_base(scene: Scene, key: str, link: str) -> Fraction:
    rigid = scene.rigid[key]
    base = rigid.links[0]
    if link == base:
        return Fraction(0)
    if rigid.angle is not None and link == rigid.links[1]:
        return Fraction(rigid.angle)
    return direction(scene, link, rigid.at) - direction(scene, base, rigid.at)


def direction(scene: Scene, link: str, node: str) -> Fraction:
    """Angle atan2(Δy, Δx), a number [rad], of a link from a node, frame O, as the scene has it."""
    x1, y1 = map(Fraction, scene.nodes[node].at)
    x2, y2 = map(Fraction, scene.nodes[scene.links[link].other(node)].at)
    return heading(x2 - x1, y2 - y1)


def _from_input(
    node: str, angles: dict[str, Fraction], inputs: dict[tuple[str, str], str]
) -> NodeRotation:
    """Rotation whose first link is the one that is prescribed, if any is."""
    first = next((link for link in angles if (link, node) in inputs), next(iter(angles)))
    links = (first, *(link for link in angles if link != first))
    relative = tuple(angles[link] - angles[first] for link in links)
    return NodeRotation(node, links, relative, inputs.get((first, node), ""))
