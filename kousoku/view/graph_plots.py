"""Plots of kernels: the expression graph with and without sharing, and counts of operations.

Needs matplotlib (the extra ``plot``).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import matplotlib as mpl
from matplotlib.collections import LineCollection

from kousoku.model.operations.graph import Op
from kousoku.view.plots import Drawing

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.typing import RcKeyType

    from kousoku.model.operations.kernel import Kernel

    #: Nodes as (x, depth, operation), and the lines between them.
    Layers = tuple[list[tuple[float, int, Op]], list[list[tuple[float, int]]]]

_STYLE: dict[RcKeyType, Any] = {
    "axes.spines.right": False,
    "axes.spines.top": False,
    "font.size": 9.0,
}
_EDGE = "#c8c8c8"
#: Sort of a node, its operations, marker and colour: readable without colour vision.
_LOOKS = (
    ("input or number", (Op.INPUT, Op.CONST), "o", "#9a9a9a"),
    ("product", (Op.MUL, Op.DIV, Op.NEG), "s", "#1f6f8b"),
    ("sum", (Op.ADD, Op.SUB), "^", "#d1603d"),
    ("function", (Op.SQRT, Op.SIN, Op.COS, Op.ATAN2), "D", "#5b3a8c"),
)
#: Sweeps that move each node towards those that use it; more change nothing that can be seen.
_SWEEPS = 12


def draw_sharing(kernel: Kernel, *, title: str) -> Figure:
    """Draw a kernel's graph twice: each use computed again, and each value computed once.

    Parameters
    ----------
    kernel : Kernel
        A small one; the drawing without sharing grows exponentially.
    title : str
        Printed above.
    """
    drawings = (_tree(kernel), _graph(kernel))
    with mpl.rc_context(_STYLE):
        figure = Drawing(figsize=(7.2, 5.6), layout="constrained")
        panels = figure.subplots(2, 1)
        for panel, words, drawing in zip(panels, ("not shared", "shared"), drawings, strict=True):
            _draw(panel, drawing)
            count = sum(op not in _LOOKS[0][1] for _, _, op in drawing[0])
            panel.set_title(f"{words}: {count} operations", loc="left")
        figure.legend(
            *panels[0].get_legend_handles_labels(),
            frameon=False,
            ncols=len(_LOOKS),
            loc="outside lower center",
        )
        figure.suptitle(title)
    return figure


def draw_counts(counts: Mapping[str, Sequence[int]], names: Sequence[str], *, title: str) -> Figure:
    """Draw counts of operations as bars, one group for each kernel.

    Parameters
    ----------
    counts : mapping of str to sequence of int
        For each stage the count of each kernel.
    names : sequence of str
        The kernels.
    title : str
        Printed above.
    """
    height = 0.8 / len(counts)
    shades = ("#f2c4b3", "#d1603d", "#a8cfdb", "#1f6f8b")
    with mpl.rc_context(_STYLE):
        figure = Drawing(figsize=(6.4, 0.9 + 0.9 * len(names)), layout="constrained")
        axes = figure.subplots()
        for k, (stage, values) in enumerate(counts.items()):
            positions = [row + (k - (len(counts) - 1) / 2) * height for row in range(len(names))]
            bars = axes.barh(positions, values, height, label=stage, color=shades[k % len(shades)])
            axes.bar_label(bars, padding=3, fontsize=8)
        axes.set_yticks(range(len(names)), names)
        axes.invert_yaxis()
        axes.set_xlabel("operations [-]")
        axes.margins(x=0.1)
        figure.legend(frameon=False, loc="outside lower center", ncols=2, fontsize=8)
        axes.set_title(title)
    return figure


def _draw(axes: Axes, drawing: Layers) -> None:
    nodes, lines = drawing
    axes.add_collection(LineCollection(lines, colors=_EDGE, linewidths=0.5, zorder=1))
    size = 16 if len(nodes) < 150 else 5
    for label, ops, marker, colour in _LOOKS:
        x = [abscissa for abscissa, _, op in nodes if op in ops]
        y = [level for _, level, op in nodes if op in ops]
        if x:
            axes.scatter(x, y, s=size, c=colour, marker=marker, label=label, zorder=2)
    axes.margins(0.02, 0.06)
    axes.set_ylabel("operations on top of\none another [-]")
    axes.spines["bottom"].set_visible(False)
    axes.set_xticks([])


def _heights(kernel: Kernel) -> list[int]:
    """Heights of the nodes: length of the longest chain of operations below each."""
    heights: list[int] = []
    for node in kernel.nodes:
        heights.append(1 + max((heights[arg] for arg in node.args), default=-1))
    return heights


def _tree(kernel: Kernel) -> Layers:
    """Drawing in which each use of a value has a node of its own."""
    nodes: list[tuple[float, int, Op]] = []
    lines: list[list[tuple[float, int]]] = []
    leaves = 0

    def add(node: int, level: int) -> float:
        nonlocal leaves
        args = kernel.nodes[node].args
        below = [add(arg, level - 1) for arg in args]
        if below:
            x = sum(below) / len(below)
        else:
            x, leaves = float(leaves), leaves + 1
        nodes.append((x, level, kernel.nodes[node].op))
        lines.extend([(x, level), (child, level - 1)] for child in below)
        return x

    top = max(_heights(kernel))
    for result in kernel.results:
        for node in result:
            add(node, top)
    return nodes, lines


def _graph(kernel: Kernel) -> Layers:
    """Drawing in which each value has one node, in layers, near to its neighbours."""
    heights = _heights(kernel)
    neighbours: list[list[int]] = [[] for _ in kernel.nodes]
    for k, node in enumerate(kernel.nodes):
        for arg in node.args:
            neighbours[arg].append(k)
            neighbours[k].append(arg)
    layers = [[k for k, h in enumerate(heights) if h == level] for level in range(max(heights) + 1)]
    widest = max(map(len, layers))
    x = [0.0] * len(kernel.nodes)
    for _ in range(_SWEEPS):
        for layer in layers:
            step = widest / len(layer)
            for index, k in enumerate(layer):
                x[k] = (index + 0.5) * step
        for layer in layers:
            layer.sort(key=lambda k: sum(x[n] for n in neighbours[k]) / max(1, len(neighbours[k])))
    nodes = [(x[k], heights[k], node.op) for k, node in enumerate(kernel.nodes)]
    lines = [
        [(x[k], heights[k]), (x[arg], heights[arg])]
        for k, node in enumerate(kernel.nodes)
        for arg in node.args
    ]
    return nodes, lines
