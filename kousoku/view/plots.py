"""Plots of a motion, such as figures 5, 7 and 8 of Yamada and Tatsumi (1981).

Needs matplotlib (the extra ``plot``). The same numbers give the same bytes of SVG.
"""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from kousoku.model.files.cache import write_atomically

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from matplotlib.typing import RcKeyType

    from kousoku.model.numbers.real import Array

STYLE: dict[RcKeyType, Any] = {
    "axes.grid": True,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "font.size": 9.0,
    "grid.alpha": 0.3,
    "svg.fonttype": "none",  # text stays text: small files, and no dependence on fonts
    "svg.hashsalt": "kousoku",
}
_PATH = "#404040"
_LINK = "#b0b0b0"
_TURN = "viridis"  # ordered, and readable without colour vision


class Drawing(Figure):
    """A figure that a notebook shows as SVG, at the end of a cell, without ``pyplot``."""

    def _repr_svg_(self) -> str:
        return to_svg(self)


def draw_motion(
    alpha: Array,
    curves: Sequence[tuple[str, Array]],
    *,
    title: str,
    symbol: str = "α",
) -> Figure:
    """Draw a node's position, velocity and acceleration over the input (Fig. 5).

    Parameters
    ----------
    alpha : (n,) [rad]
        The input.
    curves : sequence of (str, (n, 2) array)
        Label with unit, and the x and y components.
    title : str
        Printed above.
    symbol : str
        Name of the input.
    """
    with mpl.rc_context(STYLE):
        figure = Drawing(figsize=(5.5, 1.9 * len(curves)), layout="constrained")
        panels = figure.subplots(len(curves), 1, sharex=True, squeeze=False)[:, 0]
        for panel, (label, values) in zip(panels, curves, strict=True):
            for k, name in enumerate("xy"):
                panel.plot(alpha, values[:, k], label=name)
            panel.set_ylabel(label)
        panels[-1].set_xlabel(f"{symbol} [rad]")
        panels[0].legend(frameon=False, ncols=2)
        figure.suptitle(title)
    return figure


def draw_vectors(
    alpha: Array,
    path: Array,
    vectors: Array,
    *,
    links: Sequence[Array],
    title: str,
    unit: str,
    symbol: str = "α",
) -> Figure:
    """Draw a vector at each position of a node, over the linkage in one position (Figs 7 and 8).

    Parameters
    ----------
    alpha : (n,) [rad]
        The input, shown as colour: a node that returns on its path has two vectors at each place.
    path : (n, 2) [unit]
        Positions of the node.
    vectors : (n, 2)
        Its velocities or accelerations; one scale for all, fitted to the picture.
    links : sequence of (2, 2) [unit]
        End points of the links in the position that is drawn.
    title : str
        Printed above.
    unit : str
        Length unit of both axes.
    symbol : str
        Name of the input.
    """
    scale = _scale(path, vectors, links)
    with mpl.rc_context(STYLE):
        figure = Drawing(figsize=(6.0, 4.2), layout="constrained")
        axes = figure.subplots()
        for ends in links:
            axes.plot(ends[:, 0], ends[:, 1], "o-", color=_LINK, linewidth=2.5, markersize=4)
        axes.plot(path[:, 0], path[:, 1], color=_PATH, linewidth=1.2)
        arrows = axes.quiver(
            *path.T,
            *vectors.T,
            alpha,
            angles="xy",
            scale_units="xy",
            scale=scale,
            cmap=_TURN,
            width=0.003,
            zorder=3,
        )
        figure.colorbar(arrows, label=f"{symbol} [rad]", shrink=0.8)
        axes.update_datalim(path + vectors / scale)
        axes.set_aspect("equal")
        axes.margins(0.06)
        axes.autoscale_view()
        axes.set_xlabel(f"x [{unit}]")
        axes.set_ylabel(f"y [{unit}]")
        axes.set_title(title)
    return figure


def draw_linkage(motion: Any, node: str | None = None) -> dict[str, Figure]:
    """Draw a linkage as figures 5, 7 and 8 of the paper do.

    Parameters
    ----------
    motion : Trajectory
        The motion of a linkage of nodes.
    node : str, optional
        The node whose path and vectors are drawn; the last one that moves unless given.

    Returns
    -------
    dict of str to Figure
        The figures by node and what they show.
    """
    if node is None:
        node = next(
            name for name, path in [*motion.positions.items()][::-1] if np.ptp(path, 0).any()
        )
    symbol, alpha = next(iter(motion.inputs.items()))
    name, unit, path = motion.name, motion.unit, motion.positions[node]
    curves = [(f"position [{unit}]", path)]
    figures = {}
    row = len(motion) // 8
    links = [
        np.array([motion.positions[first][row], motion.positions[second][row]])
        for _, first, second, _ in motion.links
    ]
    for quantity, per, vectors in (
        ("velocity", "s", motion.velocities),
        ("acceleration", "s²", motion.accelerations),
    ):
        if vectors:
            curves.append((f"{quantity} [{unit}/{per}]", vectors[node]))
            title = f"{name}: {quantity} of {node}"
            figures[quantity] = draw_vectors(
                alpha, path, vectors[node], links=links, title=title, unit=unit, symbol=symbol
            )
    figures["motion"] = draw_motion(alpha, curves, title=f"{name}: {node}", symbol=symbol)
    return {f"{node}_{quantity}": figure for quantity, figure in figures.items()}


def save(figure: Figure, path: Path) -> None:
    """Write a figure, whole or not at all; the suffix of the path chooses the format."""
    if path.suffix == ".svg":
        write_atomically(path, to_svg(figure).encode())
        return
    image = io.BytesIO()
    with mpl.rc_context(STYLE):
        figure.savefig(image, format=path.suffix.removeprefix(".") or None)
    write_atomically(path, image.getvalue())


def to_svg(figure: Figure) -> str:
    """Figure as SVG, the same text in every run."""
    text = io.StringIO()
    with mpl.rc_context(STYLE):
        figure.savefig(text, format="svg", metadata={"Date": None})
    return text.getvalue()


def _scale(path: Array, vectors: Array, links: Sequence[Array]) -> float:
    """Length of a vector's unit in the picture: the longest takes a third of it."""
    points = [*path.tolist(), *(point for ends in links for point in ends.tolist())]
    extent = max(max(p[k] for p in points) - min(p[k] for p in points) for k in (0, 1))
    longest = float((vectors**2).sum(axis=1).max()) ** 0.5
    return 3.0 * longest / extent if longest > 0.0 and extent > 0.0 else 1.0
