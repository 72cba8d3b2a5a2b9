"""The plots of bodies: what they show, and that the same motion gives the same bytes."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

if TYPE_CHECKING:
    from pathlib import Path

motion_plots = pytest.importorskip("kousoku.motion_plots", reason="needs matplotlib")

TIME = np.linspace(0.0, 1.0, 11)


def vectors(factor: float) -> Any:
    return factor * np.stack([np.sin(TIME), np.cos(TIME), TIME], axis=1)


def motion(bodies: int = 2, **tables: Any) -> Any:
    """Return what the plots take of a motion."""
    names = [f"body_{k}" for k in range(bodies)]
    given = {
        "name": "scene",
        "time": TIME,
        "position": {name: vectors(1.0) for name in names},
        "velocity": {name: vectors(2.0) for name in names},
        "angular_velocity": {name: vectors(3.0) for name in names[1:]},
        "acceleration": {},
        "coordinate": {},
        "coordinate_rate": {},
        "coordinate_acceleration": {},
        "energy": {},
        "work": {},
    }
    return SimpleNamespace(**given | tables)


def test_a_body_has_a_panel_for_each_table_that_it_is_in() -> None:
    figures = motion_plots.figures_of(motion(), "mm", ["body_0", "body_1"])
    panels = {name: [axes.get_ylabel() for axes in figure.axes] for name, figure in figures.items()}
    assert panels == {
        "body_0": ["position [mm]", "velocity [mm/s]"],
        "body_1": ["position [mm]", "velocity [mm/s]", "ω′ [rad/s]"],
    }
    lines = figures["body_1"].axes[1].lines
    assert [line.get_label() for line in lines] == ["x", "y", "z"]
    np.testing.assert_array_equal(lines[1].get_ydata(), 2.0 * np.cos(TIME))
    np.testing.assert_array_equal(lines[1].get_xdata(), TIME)


def test_coordinates_and_energies_have_figures_where_they_are_wanted() -> None:
    given = motion(
        coordinate={"theta": TIME},
        coordinate_rate={"theta": 2 * TIME},
        energy={"kinetic": TIME, "total": TIME},
        work={"damper": -TIME},
    )
    figures = motion_plots.figures_of(given, "m", [])
    assert [*figures] == ["coordinates", "energies"]
    (rate,) = figures["coordinates"].axes[1].lines
    np.testing.assert_array_equal(rate.get_ydata(), 2 * TIME)
    assert [len(axes.lines) for axes in figures["energies"].axes] == [2, 1]


def test_many_bodies_are_not_all_drawn_unless_one_is_named(tmp_path: Path) -> None:
    files = motion_plots.draw_bodies(motion(14), "m", tmp_path / "all")
    assert len(files) == motion_plots.MOST_BODIES == 12
    (file,) = motion_plots.draw_bodies(motion(14), "m", tmp_path / "one", "body_13")
    assert file.name == "scene_body_13.svg"


def test_the_same_motion_gives_the_same_bytes(tmp_path: Path) -> None:
    pair = [motion_plots.draw_bodies(motion(1), "m", tmp_path / name)[0] for name in "ab"]
    first, second = (path.read_bytes() for path in pair)
    assert first == second
    assert ET.fromstring(first).tag.endswith("svg")
