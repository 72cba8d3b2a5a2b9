"""Nodes of a linkage whose motion follows from the inputs alone: pins of cranks, driven sliders."""

from __future__ import annotations

from dataclasses import dataclass
from math import hypot, pi
from typing import TYPE_CHECKING

import numpy as np

from kousoku.model.linkage.input_motion import input_values

if TYPE_CHECKING:
    from kousoku.model.records.scene import Scene


@dataclass(frozen=True, slots=True)
class PrescribedDirection:
    """The direction of a link, from its first node to its second, that an input prescribes.

    Parameters
    ----------
    input : str
        The input.
    offset : float [rad]
        Constant angle from the value of the input to the direction.
    """

    input: str
    offset: float


@dataclass(frozen=True, slots=True)
class Crank:
    """A link that an input turns about a fixed node.

    Parameters
    ----------
    input, link, center : str
        The input, the link, the fixed node.
    offset : float [rad]
        Constant angle from the value of the input to the direction from center to pin.
    """

    input: str
    link: str
    center: str
    offset: float


@dataclass(frozen=True, slots=True)
class Known:
    """Positions of a node at some divisions.

    Parameters
    ----------
    at : (2, n) or (2, 1) ndarray [unit of the scene]
        Positions; one only where the node never moves.
    crank : Crank, optional
        The crank whose pin it is.
    """

    at: np.ndarray
    crank: Crank | None = None


def known_nodes(scene: Scene, ks: np.ndarray) -> dict[str, Known]:
    """Nodes whose positions at the divisions `ks` follow from the inputs, in the order of finding.

    The far end of a link of length l that starts at a known node r with the direction β is at
    r + l (cos β, sin β), that of a driven slider at through + unit direction · value.

    Parameters
    ----------
    scene : Scene
        A linkage of nodes.
    ks : (n,) array
        Divisions of the motion; they may lie between whole ones.

    Returns
    -------
    dict of str to Known
        Positions (2, n) in frame O [unit of the scene], (2, 1) of nodes that never move.
    """
    known = {
        name: Known(np.array(node.at).reshape(2, 1))
        for name, node in scene.nodes.items()
        if node.fixed
    }
    values = {
        name: input_values(motion, scene.divisions, ks) for name, motion in scene.inputs.items()
    }
    for name, motion in scene.inputs.items():
        if motion.slider is not None:
            slider = scene.sliders[motion.slider]
            unit = np.array(slider.direction)[:, None] / hypot(*slider.direction)
            known[slider.node] = Known(np.array(slider.through)[:, None] + unit * values[name])
    directions = _directions(scene)
    while reached := _reach(scene, known, directions, values):
        known |= reached
    return known


def _directions(scene: Scene) -> dict[str, PrescribedDirection]:
    """Links whose direction is prescribed, through rigid connections too."""
    directions: dict[str, PrescribedDirection] = {}
    for name, motion in scene.inputs.items():
        if motion.link is not None:
            turned = 0.0 if motion.about == scene.links[motion.link].nodes[0] else pi
            directions[motion.link] = PrescribedDirection(name, turned)
    is_growing = True
    while is_growing:
        is_growing = False
        for name, rigid in scene.rigid.items():
            base = next((link for link in rigid.links if link in directions), None)
            if base is None:
                continue
            for link in rigid.links:
                if link not in directions:
                    angle = scene.rigid_angle(name, link) - scene.rigid_angle(name, base)
                    angle += _flip(scene, link, rigid.at) - _flip(scene, base, rigid.at)
                    offset = directions[base].offset + angle
                    directions[link] = PrescribedDirection(directions[base].input, offset)
                    is_growing = True
    return directions


def _flip(scene: Scene, link: str, node: str) -> float:
    """Angle, 0 or π, from the direction of a link as seen from `node` to its own direction."""
    return 0.0 if scene.links[link].nodes[0] == node else pi


def _reach(
    scene: Scene,
    known: dict[str, Known],
    directions: dict[str, PrescribedDirection],
    values: dict[str, np.ndarray],
) -> dict[str, Known]:
    """Nodes at the far ends of known links that start at known nodes."""
    reached: dict[str, Known] = {}
    for name, direction in directions.items():
        link = scene.links[name]
        near = next((node for node in link.nodes if node in known), None)
        if near is None or link.other(near) in known:
            continue
        offset = direction.offset + _flip(scene, name, near)
        angle = values[direction.input] + offset
        at = known[near].at + scene.length(name) * np.array([np.cos(angle), np.sin(angle)])
        is_crank = scene.nodes[near].fixed
        crank = Crank(direction.input, name, near, offset) if is_crank else None
        reached[link.other(near)] = Known(at, crank)
    return reached
