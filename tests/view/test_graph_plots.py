"""The plots of kernels: every node is there, and the same kernel gives the same bytes."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import kousoku as ks
from kousoku.codegen.passes.trace import without_sharing
from kousoku.model.files.quantity import Quantity
from kousoku.model.operations.graph import Graph
from kousoku.model.operations.kernel import Kernel

if TYPE_CHECKING:
    from matplotlib.figure import Figure

graph_plots = pytest.importorskip("kousoku.view.graph_plots", reason="needs matplotlib")
plots = pytest.importorskip("kousoku.view.plots", reason="needs matplotlib")


@pytest.fixture
def kernel() -> Kernel:
    """Build f = √(x + y) · (x + y): 3 operations, 4 where the sum is not shared."""
    graph = Graph()
    inputs = tuple(Quantity(name, (), "m", "") for name in "xy")
    total = graph.add(graph.input("x", 0), graph.input("y", 0))
    result = graph.mul(graph.sqrt(total), total)
    outputs = (Quantity("f", (), "-", ""),)
    return Kernel("k", "", "", "", inputs, outputs, tuple(graph.nodes), ((result,),))


def marks(figure: Figure) -> list[int]:
    """Number of nodes that each panel shows."""
    return [
        sum(np.asarray(item.get_offsets()).shape[0] for item in panel.collections[1:])
        for panel in figure.axes
    ]


def test_both_graphs_show_every_node_and_count_the_operations(kernel: Kernel) -> None:
    figure = graph_plots.draw_sharing(kernel, title="k")
    assert [panel.get_title(loc="left") for panel in figure.axes] == [
        "not shared: 4 operations",
        "shared: 3 operations",
    ]
    assert without_sharing(kernel) == 4
    assert marks(figure) == [8, 5]
    lines = [panel.collections[0].get_segments() for panel in figure.axes]
    assert [len(segments) for segments in lines] == [7, 5]


def test_bars_are_as_long_as_the_counts() -> None:
    counts = {"before": [12, 30], "after": [8, 29]}
    figure = graph_plots.draw_counts(counts, ["one", "two"], title="k")
    (axes,) = figure.axes
    assert [bar.get_width() for bar in axes.patches] == [12, 30, 8, 29]
    assert [label.get_text() for label in axes.get_yticklabels()] == ["one", "two"]
    assert axes.yaxis_inverted()


def test_a_derivation_is_explained_stage_by_stage() -> None:
    derivation = ks.derive("n1")
    found = ks.explain(derivation)
    whole, alone = found.graph("constraint"), found.graph("constraint", "C")
    assert whole.operations.total() > alone.operations.total() > 0
    (matrix,) = [s for s in found.stages if (s.kernel, s.level) == ("constraint", "matrix level")]
    assert (matrix.shared, matrix.not_shared) == (whole.operations.total(), without_sharing(whole))
    assert matrix.after_factor <= matrix.after_drop_dead <= matrix.shared < matrix.not_shared
    emitted = dict(ks.kernels("n1", target="numpy").manifest.kernels[0].operations)
    assert sum(emitted.values()) == matrix.after_factor
    assert str(found).count("\n") == len(found.as_data()["stages"]) == 2 * len(derivation.functions)
    figure: Any = found.plot()
    (bars,) = figure.axes
    wanted = [(s.shared, s.after_factor) for s in found.stages]
    assert sorted(bar.get_width() for bar in bars.patches) == sorted(
        x for two in wanted for x in two
    )
    shared = found.plot("constraint", "C").axes[1].get_title(loc="left")
    assert shared == f"shared: {alone.operations.total()} operations"


@pytest.mark.parametrize(
    ("names", "wanted"),
    [
        (("constrain",), "n1: no kernel 'constrain'; has constraint, rates, reaction"),
        (("constraint", "D"), "n1: no output of constraint 'D'; has C, C_q"),
    ],
)
def test_a_graph_that_there_is_not_is_refused(names: tuple[str, ...], wanted: str) -> None:
    with pytest.raises(ks.KousokuError, match=f"^{re.escape(wanted)}$"):
        ks.explain(ks.derive("n1")).graph(*names)


def test_the_same_kernel_gives_the_same_bytes(kernel: Kernel) -> None:
    first, again = (
        plots.to_svg(graph_plots.draw_sharing(kernel, title="k")).encode() for _ in range(2)
    )
    assert first == again
