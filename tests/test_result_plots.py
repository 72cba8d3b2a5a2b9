"""The plots of a run: what they show, and that the same motion gives the same bytes."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import kousoku as ks

if TYPE_CHECKING:
    from kousoku.runtime.integrate.result import Result

plots = pytest.importorskip("kousoku.result_plots", reason="needs matplotlib")
pytestmark = pytest.mark.usefixtures("compiler")

SCENES = Path(__file__).parents[1] / "scenes"


def moved(name: str, end: float = 1.0, outputs: Any = None) -> Result:
    return ks.load(SCENES / f"{name}.toml", outputs=outputs).simulate(end, samples=31)


@pytest.fixture(scope="module")
def loop() -> Result:
    return moved("loop", 2.0, ["coordinates", "reactions", "energies"])


def labels(figure: Any) -> list[str]:
    return [axes.get_ylabel() for axes in figure.axes]


def test_what_was_asked_for_is_drawn_with_its_names_and_units(loop: Result) -> None:
    figure = loop.plot()
    assert labels(figure)[:3] == ["rocking [rad]", "rocking_dot [rad/s]", "motor: torque [N m]"]
    np.testing.assert_array_equal(figure.axes[0].lines[0].get_ydata(), loop["rocking"])
    np.testing.assert_array_equal(figure.axes[0].lines[0].get_xdata(), loop.time)
    (torque,) = figure.axes[2].lines  # about the axis of the motor; the others are zero
    np.testing.assert_array_equal(torque.get_ydata(), loop["motor.mx"])


def test_each_part_of_a_run_has_a_figure(loop: Result) -> None:
    figures = plots.figures_of(loop)
    bodies, joints = ["crank", "coupler", "rocker"], ["a", "b", "c", "d"]
    assert [*figures] == ["coordinates", *bodies, *joints, "drivers", "energies"]
    assert labels(figures["energies"]) == ["energy [J]", "work [J]"]
    assert labels(figures["a"]) == ["force [N]", "torque [N m]"]


def test_forces_and_energies_of_a_scene_in_mm_are_in_newtons_and_joules() -> None:
    """Its columns are in kg mm/s² and kg mm²/s², as their units say."""
    run = moved("gear_train", 0.1, ["coordinates", "reactions", "energies"])
    figures, units = plots.figures_of(run), run.units
    assert labels(figures["energies"])[0] == "energy [J]"
    assert labels(figures["rack_guide"]) == ["force [N]"]
    for name, per, of in (
        ("energy.kinetic", 1e-6, "kg mm²/s²"),
        ("rack_guide.fy", 1e-3, "kg mm/s²"),
        ("motor.mz", 1e-6, "kg mm²/s²"),
    ):
        (line,) = run.plot(name).axes[0].lines
        drawn = np.asarray(line.get_ydata(), dtype=float)
        np.testing.assert_allclose(drawn, per * run[name], rtol=1e-12, atol=0.0)
        assert units[name] == of


def test_a_body_whose_origin_rests_is_drawn_by_its_centre_of_mass(loop: Result) -> None:
    figure = plots.figures_of(loop, of="rocker")["rocker"]
    assert labels(figure)[0] == "centre of mass [m]"
    x = figure.axes[0].lines[0].get_ydata()
    np.testing.assert_allclose(x, 3 - np.sin(loop["rocking"]), atol=1e-12)


def test_columns_that_are_named_are_drawn_as_they_are(loop: Result) -> None:
    figure = loop.plot("rocking", "rocker.x", "crank.z")
    assert labels(figure) == ["rocking [rad]", "rocker: position [m]", "crank: position [m]"]
    for axes, name in zip(figure.axes, ("rocking", "rocker.x", "crank.z"), strict=True):
        np.testing.assert_array_equal(axes.lines[0].get_ydata(), loop[name])


@pytest.mark.parametrize("scene", ["heavy_top", "engine"])
def test_rounding_is_not_drawn(scene: str) -> None:
    for name, figure in plots.figures_of(moved(scene, 0.1)).items():
        for axes in figure.axes:
            curves = [np.asarray(line.get_ydata(), dtype=float) for line in axes.lines]
            assert max(float(np.abs(one).max()) for one in curves) > 1e-8, (name, axes)


def test_a_constant_with_rounding_is_a_flat_line() -> None:
    run = moved("heavy_top", 0.5)
    axes = run.plot("top.vx").axes[0]
    low, high = axes.get_ylim()
    assert np.ptp(run["top.vx"]) < 1e-6 * (high - low)


def test_columns_parts_and_pictures_are_chosen(loop: Result, tmp_path: Path) -> None:
    assert labels(loop.plot("a.fx", "motor")) == ["a: force [N]", "motor: torque [N m]", "work [J]"]
    for suffix, begins in ("png", b"\x89PNG"), ("svg", b"<?xml"):
        (file,) = plots.draw_into(loop, tmp_path / f"run.{suffix}", columns=["rocking"])
        assert file.read_bytes().startswith(begins)
    with pytest.raises(KeyError, match="did you mean 'rocking'"):
        loop.plot("rockin")
    with pytest.raises(ks.SolveError, match="time is what columns are drawn over"):
        loop.plot("time")
    a_list: Any = ["rocking", "motor"]
    with pytest.raises(ks.SolveError, match=r"no column .*; wanted names, one by one"):
        loop.plot(a_list)


def test_many_bodies_are_not_all_drawn_unless_one_is_named() -> None:
    run = ks.load(SCENES / "families" / "chain_100.toml").simulate(0.01, samples=3)
    names = [*run.mechanism.scene.bodies]
    assert len([x for x in plots.figures_of(run) if x in names]) == plots.MOST_PARTS == 12
    assert [*plots.figures_of(run, of=names[-1])] == [names[-1]]


def test_a_linkage_has_the_figures_of_the_paper() -> None:
    run = ks.load(SCENES / "lever_crank.toml").solve()
    assert [*run.figures("O2")] == ["O2_velocity", "O2_acceleration", "O2_motion"]
    assert [*run.figures()] == ["O3_velocity", "O3_acceleration", "O3_motion"]
    assert labels(run.plot()) == [
        "O3: position [cm]",
        "O3: velocity [cm/s]",
        "O3: acceleration [cm/s²]",
    ]
    assert run.plot().axes[-1].get_xlabel() == "time [s]"


def test_the_same_motion_gives_the_same_bytes(loop: Result, tmp_path: Path) -> None:
    pair = [plots.draw_into(loop, tmp_path / name)[0] for name in "ab"]
    first, second = (path.read_bytes() for path in pair)
    assert first == second
    assert ET.fromstring(first).tag.endswith("svg")
