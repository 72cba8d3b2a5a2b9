"""The plots: what they show, and that the same numbers give the same bytes."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from typing import TYPE_CHECKING

import numpy as np
import pytest

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray

plots = pytest.importorskip("kousoku.view.plots", reason="needs matplotlib")


def circle(radius: float = 2.0) -> tuple[NDArray[np.float64], ...]:
    """Angle of a point that turns with unit speed, and its motion."""
    alpha = np.linspace(0.0, 2.0 * np.pi, 61)
    position = radius * np.stack([np.cos(alpha), np.sin(alpha)], axis=1)
    velocity = radius * np.stack([-np.sin(alpha), np.cos(alpha)], axis=1)
    return alpha, position, velocity


def test_motion_has_one_panel_for_each_curve_and_one_line_for_each_component() -> None:
    alpha, position, velocity = circle()
    figure = plots.draw_motion(alpha, [("x [cm]", position), ("v [cm/s]", velocity)], title="O3")
    assert [len(panel.lines) for panel in figure.axes] == [2, 2]
    np.testing.assert_array_equal(figure.axes[1].lines[0].get_ydata(), velocity[:, 0])


def test_vector_diagram_shows_every_vector_whole() -> None:
    alpha, position, velocity = circle()
    links = [np.array([[0.0, 0.0], [2.0, 0.0]])]
    figure = plots.draw_vectors(alpha, position, velocity, links=links, title="O3", unit="cm")
    axes = figure.axes[0]
    (arrows,) = (item for item in axes.collections if hasattr(item, "U"))
    tips = position + velocity / arrows.scale
    assert axes.get_xlim()[0] < tips[:, 0].min() and tips[:, 0].max() < axes.get_xlim()[1]
    assert axes.get_ylim()[0] < tips[:, 1].min() and tips[:, 1].max() < axes.get_ylim()[1]


def test_a_node_at_rest_can_be_drawn() -> None:
    rest = np.zeros((5, 2))
    plots.draw_vectors(np.arange(5.0), rest, rest, links=[], title="O1", unit="m")


def test_the_same_motion_gives_the_same_bytes(tmp_path: Path) -> None:
    motion = circle()
    for name in ("a.svg", "b.svg"):
        figure = plots.draw_vectors(*motion, links=[], title="O3", unit="cm")
        plots.save(figure, tmp_path / name)
    first, second = ((tmp_path / name).read_bytes() for name in ("a.svg", "b.svg"))
    assert first == second
    assert ET.fromstring(first).tag.endswith("svg")
