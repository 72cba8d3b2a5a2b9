"""Pictures of planar linkages of nodes: bars in layers, pins, sliders, the ground."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from kousoku.view.meshes import cylinder_name
from kousoku.view.shapes import (
    GROUND,
    LIGHT,
    METAL,
    THIN,
    BodyShape,
    JointMark,
    MeshPart,
    Shapes,
    Strut,
    box,
    cylinder,
    pedestal,
    rotation,
)

if TYPE_CHECKING:
    from collections.abc import Mapping

    from kousoku.model.numbers.real import Array
    from kousoku.model.records.scene import Scene

OUT = np.array([0.0, 0.0, 1.0])
UP = np.array([0.0, 1.0, 0.0])


def linkage_at_rest(scene: Scene) -> tuple[Shapes, Array, Array]:
    """Shapes, positions and Euler parameters of a linkage whose nodes are as they are written."""
    nodes = {name: np.array([node.at], dtype=np.float64) for name, node in scene.nodes.items()}
    return _linkage(scene, nodes)


def linkage_motion(
    result: Any, scene: Scene
) -> tuple[Shapes, Array, Array, Array, tuple[Array, Array]]:
    """Shapes, times, positions, Euler parameters and velocities of a linkage's links.

    Parameters
    ----------
    result : Trajectory
        Positions of its nodes; velocities where they were wanted.
    scene : Scene
        The linkage.
    """
    shapes, position, turn = _linkage(scene, dict(result.positions))
    time = getattr(result, "time", None)
    time = _times_of(result, scene) if time is None else np.asarray(time, dtype=np.float64)
    rates = np.full(position.shape, np.nan)  # places between rows lie on straight lines
    cosine = np.abs((turn[1:] * turn[:-1]).sum(axis=-1)).clip(0.0, 1.0)
    step = np.diff(time)[:, None]
    spin = np.divide(2 * np.arccos(cosine), step, out=np.zeros(cosine.shape), where=step > 0.0)
    omega = np.zeros((max(1, len(spin)), turn.shape[1], 3))
    omega[: len(spin), :, 2] = spin
    return shapes, time, position, turn, (rates, omega)


def _times_of(result: Any, scene: Scene) -> Array:
    """Times at which the first input has its values: at its rate, or by one in a second."""
    name, drive = next(iter(scene.inputs.items()))
    values = np.asarray(result.inputs[name])
    times: Array = np.abs(values - values[0]) / (abs(drive.rate) or 1.0)
    return times


def _linkage(scene: Scene, nodes: Mapping[str, Array]) -> tuple[Shapes, Array, Array]:
    """Shapes of a linkage, and where its bodies are, row by row."""
    drawn = _LinkageShapes(scene, nodes)
    drawn.add_links()
    drawn.add_sliders()
    drawn.add_nodes()
    drawn.add_braces()
    shapes = Shapes(
        tuple(drawn.bodies), tuple(drawn.marks), (), tuple(drawn.struts), UP, drawn.size
    )
    return shapes, np.stack(drawn.position, axis=1), np.stack(drawn.turn, axis=1)


class _LinkageShapes:
    """The shapes of a linkage while they are collected; its bars lie in layers, one above another.

    Parameters
    ----------
    scene : Scene
        The linkage.
    nodes : mapping of str to (rows, 2)
        Positions of its nodes.
    """

    def __init__(self, scene: Scene, nodes: Mapping[str, Array]) -> None:
        first = np.array([rows[0] for rows in nodes.values()])
        self._scene, self._nodes = scene, nodes
        self.size = float(np.linalg.norm(np.ptp(first, axis=0))) or 1.0
        self._thick, self._wide = 0.9 * THIN * self.size, 1.6 * THIN * self.size
        self.bodies = [BodyShape("ground", GROUND)]
        self.position: list[Array] = []
        self.turn: list[Array] = []
        self.marks: list[JointMark] = []
        self.struts: list[Strut] = []
        self._places: dict[str, int] = {}
        self._layers: dict[str, list[float]] = {}
        self._owners: dict[str, tuple[int, Array]] = {}

    def add_links(self) -> None:
        """Add a bar for each link that moves; its frame is at its first node, x along it."""
        links = [name for name in self._scene.links if not self._scene.is_ground(name)]
        for k, name in enumerate(links):
            ends = self._scene.links[name].nodes
            start, end = (self._nodes[node] for node in ends)
            length = float(np.linalg.norm(end[0] - start[0]))
            height = 2.2 * self._thick * k
            color = 2 + k % (len(LIGHT) - 2)
            middle = np.array([length / 2, 0.0, height])
            half = np.diag([length / 2 + 0.7 * self._wide, self._wide, self._thick])
            bar = box(middle, half, color, self.size)
            self._places[name] = len(self.bodies)
            for node, x in zip(ends, (0.0, length), strict=True):
                self._layers.setdefault(node, []).append(height)
                self._owners.setdefault(node, (len(self.bodies), np.array([x, 0.0, 0.0])))
            angle = np.arctan2(end[:, 1] - start[:, 1], end[:, 0] - start[:, 0])
            self._add(BodyShape(name, color, [bar], middle), start, np.unwrap(angle))

    def add_sliders(self) -> None:
        """Add a block for each slider, and a rail below it as long as its way."""
        for name, slider in self._scene.sliders.items():
            along = np.array([*slider.direction, 0.0]) / np.hypot(*slider.direction)
            across = np.cross(OUT, along)
            wide, thick = self._wide, self._thick
            columns = np.column_stack([3.2 * wide * along, 2.0 * wide * across, 1.4 * thick * OUT])
            block = box(np.zeros(3), columns, METAL, self.size)
            points = self._nodes[slider.node]
            self._add(BodyShape(name, METAL, [block]), points, np.zeros(len(points)))
            travel = (points - np.array(slider.through)) @ along[:2]
            low, high = travel.min() - 6 * wide, travel.max() + 6 * wide
            through = np.array([*slider.through, 0.0])
            rail = np.column_stack([(high - low) / 2 * along, 0.5 * wide * across, thick * OUT])
            below = -2.5 * wide * across if across[1] >= 0.0 else 2.5 * wide * across
            middle = through + (high + low) / 2 * along + below
            self.bodies[0].parts.append(box(middle, rail, GROUND, self.size))
            ends = through + low * along, through + high * along
            self.struts.append(Strut("guide", 0, 0, *ends, wide))

    def add_nodes(self) -> None:
        """Add a pin for each node, and a pedestal for each that is fixed."""
        for name, node in self._scene.nodes.items():
            owner, s = self._owners.get(name, (0, np.array([*node.at, 0.0])))
            if node.fixed:
                owner, s = 0, np.array([*node.at, 0.0])
                self.bodies[0].parts.append(pedestal(s, OUT, UP, 4.2 * THIN * self.size))
            heights = self._layers.get(name, [0.0])
            low, high = min(heights) - 1.5 * self._thick, max(heights) + 1.5 * self._thick
            pin = cylinder(s + low * OUT, s + high * OUT, 0.75 * self._wide, METAL, 1e300)
            self.bodies[owner].parts.append(MeshPart(cylinder_name(1), pin.matrix, METAL))
            self.marks.append(JointMark(name, owner, owner, s, s))

    def add_braces(self) -> None:
        """Add bars between links that are connected rigidly, to the first of them."""
        for rigid in self._scene.rigid.values():
            moving = [link for link in rigid.links if link in self._places]
            if len(moving) < 2:
                continue
            arms = [self._arm(link, rigid.at) for link in moving]
            reach = 0.35 * min(float(np.linalg.norm(arm)) for arm in arms)
            body = self._places[moving[0]]
            back = rotation(self.turn[body - 1][0])
            origin = _lifted(self._nodes[rigid.at])[0] - self.position[body - 1][0]
            points = [(origin + reach * arm / np.linalg.norm(arm)) @ back for arm in arms]
            shape = self.bodies[body]
            for a, b in pairwise(points):
                across = np.cross(OUT, b - a)
                across *= 0.5 * self._wide / np.linalg.norm(across)
                columns = np.column_stack([(b - a) / 2, across, 0.9 * self._thick * OUT])
                middle = (a + b) / 2 + shape.at[2] * OUT
                shape.parts.append(box(middle, columns, shape.color, self.size))

    def _add(self, shape: BodyShape, points: Array, angle: Array) -> None:
        zero = np.zeros(len(angle))
        self.bodies.append(shape)
        self.position.append(_lifted(points))
        self.turn.append(np.stack([np.cos(angle / 2), zero, zero, np.sin(angle / 2)], axis=1))

    def _arm(self, link: str, at: str) -> Array:
        """Direction of a link from one of its nodes where the motion starts."""
        other = self._scene.links[link].other(at)
        arm: Array = _lifted(self._nodes[other][:1] - self._nodes[at][:1])[0]
        return arm


def _lifted(points: Array) -> Array:
    return np.column_stack([points, np.zeros(len(points))])
