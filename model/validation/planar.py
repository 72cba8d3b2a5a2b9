"""Check the elements of a planar linkage one by one: names resolve, lengths are positive."""

from __future__ import annotations

from math import hypot, isfinite
from typing import TYPE_CHECKING

from kousoku.model.errors import SceneError
from kousoku.model.records.design import LARGEST
from kousoku.model.records.dotted_keys import join, require_known, unknown

if TYPE_CHECKING:
    from kousoku.model.records.planar import Link, Rigid, Slider
    from kousoku.model.records.problems import Problems
    from kousoku.model.records.scene import Scene

FRAME_TOLERANCE = 8 * 2.0**-52
"""Relative difference that a length between two fixed nodes may have to their distance."""

MOST_LINKS = 2000
"""Links of the largest planar scene."""


def check_planar(scene: Scene, problems: Problems) -> None:
    """Check nodes, links, sliders and rigid connections.

    Parameters
    ----------
    scene : Scene
        What could be built of it.
    problems : Problems
        What is broken in it, and where to note what else is wrong.
    """
    _check_tables(scene, problems)
    for name, node in scene.nodes.items():
        key = join("nodes", name)
        problems.check(key, [key], _check_point, node.at, f"{key}.at")
    _check_links(scene, problems)
    if not problems.touches("nodes", "links", "method"):
        problems.check("links", [], _check_scale, scene)
    if not problems.touches("nodes", "links"):
        _check_connected(scene, problems)
    if not problems.touches("nodes", "links", "sliders"):
        problems.check("nodes", [], _check_frame, scene)
    _check_sliders(scene, problems)
    for name, rigid in scene.rigid.items():
        key = join("rigid", name)
        uses = [join("nodes", rigid.at), *(join("links", link) for link in rigid.links)]
        problems.check(key, [key, *uses], _check_rigid, scene, rigid, key)


def _check_tables(scene: Scene, problems: Problems) -> None:
    if not (scene.nodes or scene.links or problems.touches("nodes", "links")):
        problem = (
            "has no mechanism: wanted nodes and links, a planar linkage whose inputs are"
            " prescribed, or bodies and joints, in space or in a plane; 'kousoku new' writes one to"
            " begin with"
        )
        problems.add(problem, "")
        problems.break_("nodes")
        problems.break_("links")
        return
    for table, wanted in (("nodes", "nodes and links"), ("links", "one link at least")):
        if not getattr(scene, table) and not problems.touches(table):
            problems.add(f"is missing; wanted {wanted}", table, breaks=table)
    if len(scene.links) > MOST_LINKS:
        problem = f"has {len(scene.links)} links; the limit is {MOST_LINKS}"
        problems.add(problem, "links", breaks="links")


def _check_point(point: tuple[float, ...], key: str) -> None:
    for component in point:
        if not abs(component) <= LARGEST:
            raise SceneError(f"{component!r} is not a number below {LARGEST:g}", key=key)


def _check_links(scene: Scene, problems: Problems) -> None:
    link_of: dict[frozenset[str], str] = {}
    known = tuple(scene.nodes)
    for name, link in scene.links.items():
        key = join("links", name)
        uses = [join("nodes", node) for node in link.nodes]
        for node, node_key in zip(link.nodes, uses, strict=True):
            is_known = node in scene.nodes or problems.is_broken(node_key, key)
            if not is_known and not problems.is_full:
                broken = problems.broken("nodes")
                problem = unknown(f"node {node[:40]!r}", node, (*known, *broken))
                problems.add(problem, f"{key}.nodes", breaks=key)
        problems.check(key, [key, *uses], _check_ends, scene, name, link_of)
        problems.check(key, [], _check_length, link, key)
        problems.check(key, [key], _check_distance, scene, name)


def _check_ends(scene: Scene, name: str, link_of: dict[frozenset[str], str]) -> None:
    link, key = scene.links[name], join("links", name)
    if link.nodes[0] == link.nodes[1]:
        raise SceneError(f"connects {link.nodes[0]} to itself; wanted two different nodes", key=key)
    other = link_of.setdefault(frozenset(link.nodes), name)
    if other != name:
        first, second = scene.length(other), scene.length(name)
        why = "repeats it" if first == second else f"contradicts it: {second!r}, not {first!r}"
        raise SceneError(
            f"connects the same nodes as links.{other} and {why}; leave one of them out", key=key
        )


def _check_length(link: Link, key: str) -> None:
    if link.length is not None and not (1 / LARGEST <= link.length <= LARGEST):
        problem = "has zero length" if link.length == 0 else f"has the length {link.length!r}"
        raise SceneError(
            f"{problem}; wanted a length between {1 / LARGEST:g} and {LARGEST:g}",
            key=f"{key}.length",
        )


def _check_distance(scene: Scene, name: str) -> None:
    link, key = scene.links[name], join("links", name)
    first, second = (scene.nodes[node].at for node in link.nodes)
    distance = hypot(second[0] - first[0], second[1] - first[1])
    if distance == 0:
        problem = "has zero length" if link.length is None else "has no direction"
        raise SceneError(
            f"{problem}: {link.nodes[0]} and {link.nodes[1]} are given at the same position; "
            "wanted positions that show where the link points",
            key=key,
        )
    length = scene.length(name)
    if scene.is_ground(name) and abs(length - distance) > FRAME_TOLERANCE * distance:
        raise SceneError(
            f"the length {length!r} contradicts the fixed nodes {link.nodes[0]} and "
            f"{link.nodes[1]}, which are {distance!r} apart; leave it out",
            key=f"{key}.length",
        )


def _check_scale(scene: Scene) -> None:
    """Refuse links within the limit of the residual, and a limit below rounding."""
    limit = scene.residual_limit
    for name in scene.links:
        if not scene.length(name) > limit:
            raise SceneError(
                f"the length {scene.length(name)!r} is within the limit of the residual, "
                f"{limit!r}; wanted a longer link, a smaller residual, or a frame near the origin",
                key=f"links.{name}",
            )
    rounding = 2.0**-53 * max(scene.largest_length, scene.largest_coordinate)
    if limit < rounding:
        raise SceneError(
            f"{limit!r} is below the rounding of the largest length or coordinate; wanted at least "
            f"{rounding!r}, or leave it out for {scene.default_residual!r}",
            key="method.residual",
        )


def _check_connected(scene: Scene, problems: Problems) -> None:
    used = {node for link in scene.links.values() for node in link.nodes}
    for name in scene.nodes:
        if name not in used:
            problem = "no link is connected to this node; connect it or leave it out"
            problems.add(problem, join("nodes", name), breaks=join("nodes", name))


def _check_frame(scene: Scene) -> None:
    if not any(node.fixed for node in scene.nodes.values()) and not scene.sliders:
        raise SceneError("nothing is fixed; wanted 'fixed = true' for the frame", key="nodes")
    if all(scene.is_ground(name) for name in scene.links):
        raise SceneError("every node is fixed; wanted something that moves", key="nodes")


def _check_sliders(scene: Scene, problems: Problems) -> None:
    slider_of: dict[str, str] = {}
    for name, slider in scene.sliders.items():
        key = join("sliders", name)
        uses = [key, join("nodes", slider.node)]
        problems.check(key, uses, _check_sliding, scene, name, slider_of)
        problems.check(key, [], _check_line, slider, key)


def _check_sliding(scene: Scene, name: str, slider_of: dict[str, str]) -> None:
    slider, key = scene.sliders[name], join("sliders", name)
    require_known("node", slider.node, scene.nodes, f"{key}.node")
    if scene.nodes[slider.node].fixed:
        raise SceneError(f"the node {slider.node} is fixed and cannot slide", key=f"{key}.node")
    other = slider_of.setdefault(slider.node, name)
    if other != name:
        raise SceneError(
            f"the node {slider.node} slides on sliders.{other} already; a node on two lines "
            "cannot move, fix it instead",
            key=f"{key}.node",
        )


def _check_line(slider: Slider, key: str) -> None:
    _check_point(slider.through, f"{key}.through")
    _check_point(slider.direction, f"{key}.direction")
    if not hypot(*slider.direction) >= 1 / LARGEST:
        raise SceneError("has zero length; wanted a direction", key=f"{key}.direction")


def _check_rigid(scene: Scene, rigid: Rigid, key: str) -> None:
    require_known("node", rigid.at, scene.nodes, f"{key}.at")
    if len(rigid.links) < 2:
        raise SceneError("wanted two links or more", key=f"{key}.links")
    for index, name in enumerate(rigid.links):
        item_key = f"{key}.links[{index}]"
        require_known("link", name, scene.links, item_key)
        if name in rigid.links[:index]:
            raise SceneError(f"the link {name} stands there twice", key=item_key)
        if rigid.at not in scene.links[name].nodes:
            first, second = scene.links[name].nodes
            raise SceneError(
                f"the link {name} runs from {first} to {second} and does not meet {rigid.at}",
                key=item_key,
            )
    if rigid.angle is not None and len(rigid.links) > 2:
        raise SceneError(
            "one angle cannot describe more than two links; leave it out, or write a connection "
            "for each pair",
            key=f"{key}.angle",
        )
    if rigid.angle is not None and not isfinite(rigid.angle):
        raise SceneError(f"{rigid.angle!r} is not a finite number", key=f"{key}.angle")
