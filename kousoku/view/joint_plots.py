"""Draw the joints: ``python -m kousoku.view.joint_plots FOLDER`` writes one SVG for each.

Needs matplotlib (the extra ``plot``). The same version of it gives the same bytes.
"""

from __future__ import annotations

import sys
from pathlib import Path as FilePath
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.patches import Circle, FancyArrowPatch, Polygon
from matplotlib.path import Path

from kousoku.view.coupling_shapes import COUPLING_PICTURES
from kousoku.view.joint_shapes import JOINT_PICTURES, Ball, BoxShape, CylinderShape
from kousoku.view.plots import save

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes

    from kousoku.model.numbers.real import Array
    from kousoku.model.records.orientation import Vector
    from kousoku.view.joint_shapes import JointFreedom, JointPicture, Solid

_COLORS = {"i": "#5b8db8", "j": "#e0a04d", "-": "#9a9a9a"}
_SHIFT, _TURN, _AXIS = "#1a7a3c", "#8a2b8f", "#b02020"
#: Directions of the picture: to the right, up, and away from who looks at it.
_RIGHT = np.array([np.cos(0.5), np.sin(0.5), 0.0])
_AWAY = np.array([-np.sin(0.5) * np.cos(0.4), np.cos(0.5) * np.cos(0.4), -np.sin(0.4)])
_UP = np.cross(_RIGHT, _AWAY)
_HALF = (2.35, 1.6)
_ROUND = np.linspace(0.0, 2.0 * np.pi, 49)


def draw_joint(shape: JointPicture) -> Figure:
    """Draw two bodies, their points and axes, and an arrow for each freedom that is left.

    Parameters
    ----------
    shape : JointPicture
        What is drawn: body i blue, body j orange, axes red; displacements of body j green and
        straight, its turns violet and round, a screw a violet thread.
    """
    figure = Figure(figsize=(3.5, 3.5 * _HALF[1] / _HALF[0]))
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set(xlim=(-_HALF[0], _HALF[0]), ylim=(-_HALF[1], _HALF[1]), aspect="equal")
    axes.axis("off")
    for solid in shape.solids:
        _draw_solid(axes, solid)
    for point, direction in shape.axes:
        ends = np.array([_flat(np.add(point, np.multiply(s, direction))) for s in (-1.3, 1.3)])
        axes.plot(*ends.T, color=_AXIS, linewidth=1.0, dashes=(8, 2, 2, 2))
    for freedom in shape.freedoms:
        _draw_freedom(axes, freedom)
    for point in shape.points:
        axes.plot(*_flat(point), "o", color="black", markersize=4.5, zorder=6)
    for owner in ("i", "j"):
        _label(axes, shape, owner)
    return figure


def _flat(points: Array | Vector) -> Array:
    """Points in the picture."""
    flat: Array = np.asarray(points) @ np.stack([_RIGHT, _UP], axis=1)
    return flat


def _shade(owner: str, normal: Array) -> tuple[float, ...]:
    """Colour of a face: light on top, dark on the right."""
    light = 0.75 + 0.25 * float(normal @ np.array([-0.35, -0.2, 0.91]))
    return tuple(min(1.0, light * channel + 0.12) for channel in to_rgb(_COLORS[owner]))


def _fill(axes: Axes, points: Array, color: Sequence[float]) -> None:
    axes.add_patch(
        Polygon(_flat(points), facecolor=tuple(color), edgecolor="#303030", linewidth=0.7, zorder=2)
    )


def _draw_solid(axes: Axes, solid: Solid) -> None:
    match solid:
        case BoxShape(owner, low, high):
            for k, side in np.ndindex(3, 2):
                normal = np.eye(3)[k] * (2 * side - 1)
                if normal @ _AWAY < 0.0:
                    _fill(axes, _face(low, high, k, side), _shade(owner, normal))
        case CylinderShape(owner, start, end, radius):
            _draw_cylinder(axes, owner, np.array(start), np.array(end), radius)
        case Ball(owner, at, radius):
            color = _shade(owner, np.array([-0.35, -0.2, 0.6]))
            look = {"facecolor": color, "edgecolor": "#303030", "linewidth": 0.7, "zorder": 2}
            axes.add_patch(Circle(tuple(_flat(at)), radius, **look))


def _face(low: Vector, high: Vector, k: int, side: int) -> Array:
    """Corners of a face of a box."""
    inside = [m for m in range(3) if m != k]
    corners = np.empty((4, 3))
    for corner, (a, b) in zip(corners, ((0, 0), (0, 1), (1, 1), (1, 0)), strict=True):
        corner[k] = (low, high)[side][k]
        corner[inside[0]] = (low, high)[a][inside[0]]
        corner[inside[1]] = (low, high)[b][inside[1]]
    return corners


def _circle(center: Array, axis: Array, radius: float, angles: Array) -> Array:
    """Points of a circle about an axis."""
    first = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    first /= np.linalg.norm(first)
    second = np.cross(axis, first)
    return center + radius * (np.outer(np.cos(angles), first) + np.outer(np.sin(angles), second))


def _draw_cylinder(axes: Axes, owner: str, start: Array, end: Array, radius: float) -> None:
    axis = (end - start) / np.linalg.norm(end - start)
    if axis @ _AWAY > 0.0:  # the face at the end is the one that is seen
        start, end, axis = end, start, -axis
    across = np.cross(axis, _AWAY)
    across *= radius / np.linalg.norm(across)
    toward = np.cross(across, axis)  # radius long, in the plane of the faces
    half = np.linspace(0.0, np.pi, 25)
    behind = np.outer(np.cos(half), across) + np.outer(np.sin(half), toward)
    if (toward @ _UP) * (axis @ _UP) + (toward @ _RIGHT) * (axis @ _RIGHT) > 0.0:
        behind = np.outer(np.cos(half), across) - np.outer(np.sin(half), toward)
    outline = np.concatenate([start + behind, end - across[None], end + across[None]])
    _fill(axes, outline, _shade(owner, -_AWAY))
    _fill(axes, _circle(end, axis, radius, _ROUND[:-1]), _shade(owner, axis))


def _draw_freedom(axes: Axes, freedom: JointFreedom) -> None:
    at, direction = np.array(freedom.at), np.array(freedom.direction)
    if freedom.kind == "shift":
        points = np.stack([at - freedom.size * direction, at + freedom.size * direction])
        color = _SHIFT
    elif freedom.kind == "screw":
        angles = np.linspace(-1.7 * np.pi, 1.7 * np.pi, 97)
        along = np.outer(freedom.pitch * angles / (2 * np.pi), direction)
        points = _circle(at, direction, freedom.size, angles) + along
        color = _TURN
    else:
        circle = _circle(np.zeros(3), direction, 1.0, _ROUND)
        far = float(_ROUND[int(np.argmax(circle @ _AWAY))])  # it is open on the far side
        points = _circle(at, direction, freedom.size, far + np.linspace(0.6, 2 * np.pi - 0.6, 41))
        color = _TURN
    axes.add_patch(
        FancyArrowPatch(
            path=Path(_flat(points)),
            arrowstyle="<|-|>",
            mutation_scale=9.0,
            linewidth=1.5,
            color=color,
            zorder=5,
        )
    )


def _label(axes: Axes, shape: JointPicture, owner: str) -> None:
    """Write the name of a body onto its largest box, cylinder or ball."""
    middles = [_middle(solid) for solid in shape.solids if solid.owner == owner]
    middle = max(middles, key=lambda sized: sized[1])[0]
    x, y = _flat(middle).tolist()
    axes.text(x, y, owner, style="italic", ha="center", va="center", zorder=7, fontsize=11)


def _middle(solid: Solid) -> tuple[Array, float]:
    """Middle of the visible part of a solid, and its size."""
    match solid:
        case BoxShape(owner, low, high):
            size = np.subtract(high, low)
            aside = np.array([-0.3 if owner == "i" else 0.42, -0.5, -0.3])
            return np.add(low, high) / 2 + aside * size, float(np.prod(size))
        case CylinderShape(_, start, end, radius):
            length = float(np.linalg.norm(np.subtract(end, start)))
            return np.add(start, end) / 2 - 0.5 * radius * _UP, 3.0 * length * radius**2
        case Ball(_, at, radius):
            return np.array(at) - 0.5 * radius * _UP, 4.0 * radius**3


def main(folder: str) -> None:
    """Write the pictures of all joints and couplings into a folder."""
    FilePath(folder).mkdir(parents=True, exist_ok=True)
    for name, shape in (JOINT_PICTURES | COUPLING_PICTURES).items():
        save(draw_joint(shape), FilePath(folder) / f"{name}.svg")


if __name__ == "__main__":
    main(sys.argv[1])
