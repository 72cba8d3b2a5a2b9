"""What a planar linkage of nodes looks like: bars in layers, pins, sliders, the ground."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, Any

import numpy as np

from kousoku.view.shapes import (
    GROUND,
    LIGHT,
    METAL,
    THIN,
    BodyShape,
    JointMark,
    Part,
    Shapes,
    Strut,
    box,
    cylinder,
    pedestal,
)

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from kousoku.model.scene import Scene
    from kousoku.view.picture import Picture

    Array = NDArray[np.float64]

OUT = np.array([0.0, 0.0, 1.0])
UP = np.array([0.0, 1.0, 0.0])


def linkage_at_rest(scene: Scene) -> Picture:
    """Return the picture of a linkage at the positions of its nodes as they are written."""
    from kousoku.view.picture import Picture

    nodes = {name: np.array([node.at], dtype=np.float64) for name, node in scene.nodes.items()}
    shapes, position, turn = _linkage(scene, nodes)
    return Picture(
        name=scene.name,
        title=scene.title or scene.name,
        unit=scene.unit,
        shapes=shapes,
        time=np.zeros(1),
        position=position,
        turn=turn,
        force={},
        paths=(),
        normal=OUT,
        speed=1.0,
    )


def linkage_motion(
    result: Any, scene: Scene
) -> tuple[Shapes, Array, Array, Array, tuple[Array, Array]]:
    """Return shapes, times, positions, Euler parameters and velocities of a linkage's links.

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
    """Return when the first input has its values: it moves at its rate, or by one in a second."""
    name, given = next(iter(scene.inputs.items()))
    values = np.asarray(result.inputs[name])
    found: Array = np.abs(values - values[0]) / (abs(given.rate) or 1.0)
    return found


def _linkage(scene: Scene, nodes: Mapping[str, Array]) -> tuple[Shapes, Array, Array]:
    """Return shapes of a linkage, and where its bodies are, row by row."""
    first = np.array([rows[0] for rows in nodes.values()])
    size = float(np.linalg.norm(first.max(axis=0) - first.min(axis=0))) or 1.0
    thick, wide = 0.9 * THIN * size, 1.6 * THIN * size
    bodies = [BodyShape("ground", GROUND)]
    position, turn = [], []
    rows = len(next(iter(nodes.values())))
    links = [name for name in scene.links if not scene.is_ground(name)]
    layers: dict[str, list[float]] = {}
    owners: dict[str, tuple[int, Array]] = {}
    for k, name in enumerate(links):
        start, end = (nodes[node] for node in scene.links[name].nodes)
        length = float(np.linalg.norm(end[0] - start[0]))
        height = 2.2 * thick * k
        color = 2 + k % (len(LIGHT) - 2)
        middle = np.array([length / 2, 0.0, height])
        half = np.diag([length / 2 + 0.7 * wide, wide, thick])
        shape = BodyShape(name, color, [box(middle, half, color, size)], middle)
        bodies.append(shape)
        position.append(_lifted(start))
        angle = np.unwrap(np.arctan2(end[:, 1] - start[:, 1], end[:, 0] - start[:, 0])) / 2
        zero = np.zeros(rows)
        turn.append(np.stack([np.cos(angle), zero, zero, np.sin(angle)], axis=1))
        for node, x in zip(scene.links[name].nodes, (0.0, length), strict=True):
            layers.setdefault(node, []).append(height)
            owners.setdefault(node, (len(bodies) - 1, np.array([x, 0.0, 0.0])))
    struts = []
    for name, slider in scene.sliders.items():
        along = np.array([*slider.direction, 0.0]) / np.hypot(*slider.direction)
        across = np.cross(OUT, along)
        way = (nodes[slider.node] - np.array(slider.through)) @ along[:2]
        columns = np.column_stack([3.2 * wide * along, 2.0 * wide * across, 1.4 * thick * OUT])
        block = BodyShape(name, METAL, [box(np.zeros(3), columns, METAL, size)])
        bodies.append(block)
        position.append(_lifted(nodes[slider.node]))
        turn.append(np.tile([1.0, 0.0, 0.0, 0.0], (rows, 1)))
        low, high = way.min() - 6 * wide, way.max() + 6 * wide
        through = np.array([*slider.through, 0.0])
        rail = np.column_stack([(high - low) / 2 * along, 0.5 * wide * across, thick * OUT])
        middle = through + (high + low) / 2 * along
        side = -1.0 if across[1] >= 0.0 else 1.0  # the rail is below the block
        bodies[0].parts.append(box(middle + side * 2.5 * wide * across, rail, GROUND, size))
        struts.append(Strut("guide", 0, 0, through + low * along, through + high * along, wide))
    marks = []
    for name, node in scene.nodes.items():
        owner, s = (0, np.array([*node.at, 0.0])) if node.fixed else owners.get(name, (0, None))
        if s is None:
            continue
        heights = layers.get(name, [0.0])
        low, high = min(heights) - 1.5 * thick, max(heights) + 1.5 * thick
        if node.fixed:
            bodies[0].parts.append(pedestal(s, OUT, UP, 4.2 * THIN * size))
        bodies[owner].parts.append(_pin(s, low, high, 0.75 * wide))
        marks.append(JointMark(name, owner, owner, s, s))
    for name, rigid in scene.rigid.items():
        bodies_of = {link: k + 1 for k, link in enumerate(links)}
        held = [link for link in rigid.links if link in bodies_of]
        _brace(scene, nodes, rigid.at, held, bodies, bodies_of, (position, turn), size)
    shapes = Shapes(tuple(bodies), tuple(marks), (), tuple(struts), UP, size)
    return shapes, np.stack(position, axis=1), np.stack(turn, axis=1)


def _lifted(points: Array) -> Array:
    return np.column_stack([points, np.zeros(len(points))])


def _pin(s: Array, low: float, high: float, radius: float) -> Part:
    pin = cylinder(s + low * OUT, s + high * OUT, radius, METAL, 1e300)
    return Part("cylinder 1", pin.matrix, METAL)


def _brace(
    scene: Scene,
    nodes: Mapping[str, Array],
    at: str,
    held: list[str],
    bodies: list[BodyShape],
    places: Mapping[str, int],
    poses: tuple[list[Array], list[Array]],
    size: float,
) -> None:
    """Add to the first link bars from it to the others of a rigid connection."""
    center = nodes[at][0]
    reach = 0.35 * min(float(np.linalg.norm(_arm(scene, nodes, link, at))) for link in held)
    if len(held) < 2:
        return
    body = places[held[0]]
    angle = 2 * np.arctan2(poses[1][body - 1][0, 3], poses[1][body - 1][0, 0])
    back = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    points = []
    for link in held:
        arm = _arm(scene, nodes, link, at)
        place = center + reach * arm / np.linalg.norm(arm)
        points.append(back @ (place - poses[0][body - 1][0, :2]))
    for a, b in itertools.pairwise(points):
        middle = np.array([*(a + b) / 2, bodies[body].parts[0].matrix[2, 3]])
        along = np.array([*(b - a) / 2, 0.0])
        across = np.cross(OUT, along)
        across *= 0.8 * THIN * size / np.linalg.norm(across)
        columns = np.column_stack([along, across, 0.8 * THIN * size * OUT])
        bodies[body].parts.append(box(middle, columns, bodies[body].color, size))


def _arm(scene: Scene, nodes: Mapping[str, Array], link: str, at: str) -> Array:
    found: Array = nodes[scene.links[link].other(at)][0] - nodes[at][0]
    return found
