"""A mechanism at rest as a figure of matplotlib."""

from __future__ import annotations

from typing import TYPE_CHECKING

import matplotlib as mpl
import numpy as np
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.patheffects import withStroke

from kousoku.view.plots import STYLE, Drawing
from kousoku.view.shapes import LIGHT, METAL
from kousoku.view.stills import Camera, Face, color_of, drawn, grid_seen, placed

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from kousoku.view.picture import Picture

SIZE = (6400.0, 4200.0)
AXIS, EDGE = "#b02020", "#2b3140"


def draw(picture: Picture) -> Figure:
    """Draw a picture where it starts, over a grid whose unit is told.

    Parameters
    ----------
    picture : Picture
        The mechanism.
    """
    camera = Camera(picture, SIZE, 420.0)
    with mpl.rc_context(STYLE | {"axes.grid": False}):
        figure = Drawing(figsize=(6.4, 4.2))
        axes = figure.add_axes((0.0, 0.0, 1.0, 0.93))
        axes.set(xlim=(0.0, SIZE[0]), ylim=(SIZE[1], 0.0), aspect="equal")
        axes.axis("off")
        figure.suptitle(picture.title, fontsize=10)
        grid, step = grid_seen(picture, camera)
        lines = [stroke.points for stroke in grid]
        axes.add_collection(LineCollection(lines, colors="#dde1e8", linewidths=0.6, zorder=0))
        _draw_items(axes, picture, camera)
        _draw_names(axes, picture, camera)
        _draw_directions(axes, camera, f"grid {step:.3g} [{picture.unit}]")
    return figure


def _draw_items(axes: Axes, picture: Picture, camera: Camera) -> None:
    """Draw faces and lines in their order; faces without edges that follow each other at once."""
    run: list[Face] = []
    for index, item in enumerate(drawn(picture, 0, camera)):
        order = 1.0 + index * 1e-4
        if isinstance(item, Face):
            run.append(item)
            if not item.edges:
                continue
        _draw_faces(axes, run, order)
        run = []
        if isinstance(item, Face):
            count = len(item.points)
            sides = [item.points[[k, (k + 1) % count]] for k in range(count) if item.edges >> k & 1]
            edges = LineCollection(sides, colors=EDGE, linewidths=0.5, alpha=0.7)
            edges.set_zorder(order + 5e-5)
            axes.add_collection(edges)
        else:
            is_axis = item.look == "axis"
            width = 0.9 if is_axis else max(1.0, item.width * 72 / 1000)
            color = AXIS if is_axis else LIGHT[METAL]
            axes.plot(*item.points.T, color=color, linewidth=width, zorder=order)
    _draw_faces(axes, run, 9.0)


def _draw_faces(axes: Axes, faces: list[Face], order: float) -> None:
    if faces:
        fills = [color_of(face.color, face.shade) for face in faces]
        points = [face.points for face in faces]
        patches = PolyCollection(points, facecolors=fills, edgecolors=fills, linewidths=0.4)
        patches.set_zorder(order)
        axes.add_collection(patches)


def _draw_names(axes: Axes, picture: Picture, camera: Camera) -> None:
    """Write the names of bodies and joints where nothing is written yet."""
    bodies = list(enumerate(picture.shapes.bodies))[1:]
    labels = [(body.name, k, body.at, color_of(body.color, 2), "bold") for k, body in bodies]
    labels += [(m.name, m.j, m.s_j, "#5b6474", "normal") for m in picture.shapes.joints]
    occupied: list[tuple[float, float]] = []
    halo = [withStroke(linewidth=2.5, foreground="white")]
    for name, body, s, color, weight in labels:
        (x, y), _ = camera.seen(placed(picture, 0, body, s))
        for dx, dy in ((110.0, -90.0), (110.0, 130.0), (-110.0, -90.0), (-110.0, 130.0)):
            if all(abs(x + dx - a) > 420.0 or abs(y + dy - b) > 150.0 for a, b in occupied):
                occupied.append((x + dx, y + dy))
                side = "left" if dx > 0 else "right"
                axes.text(
                    x + dx, y + dy, name, color=color, weight=weight, ha=side, va="center",
                    fontsize=8, zorder=11, parse_math=False, path_effects=halo,
                )  # fmt: skip
                break


def _draw_directions(axes: Axes, camera: Camera, note: str) -> None:
    x, y = 400.0, SIZE[1] - 380.0
    for k, ink in enumerate(("#b3261e", "#2e7d32", "#1a56c4")):
        dx, dy = 280 * camera.axes[0, k], -280 * camera.axes[1, k]
        if np.hypot(dx, dy) >= 30.0:
            axes.plot([x, x + dx], [y, y + dy], color=ink, linewidth=1.4, zorder=10)
            at = (x + 1.35 * dx, y + 1.35 * dy)
            axes.text(*at, "xyz"[k], color=ink, ha="center", va="center", style="italic")
    axes.text(820.0, SIZE[1] - 180.0, note, color="#5b6474", fontsize=8, parse_math=False)
