"""The closed forms: equal to the paper's formulas, and consistent with themselves."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from kousoku.closed_form import NodeMotion, closed_form
from kousoku.model.reading.read import read_scene, scene_from_toml

SCENES = Path(__file__).parents[1] / "scenes"


def solved(name: str, divisions: int = 60) -> NodeMotion:
    motion = closed_form(read_scene(SCENES / f"{name}.toml"), divisions, divisions + 1)
    assert motion is not None
    return motion


def test_the_piston_is_the_papers_formulas() -> None:
    motion, l1, l2 = solved("piston_crank"), 1.0, 2.0
    alpha = 2 * np.pi * np.arange(61) / 60
    s, c, root = np.sin(alpha), np.cos(alpha), np.sqrt(l2**2 - l1**2 * np.sin(alpha) ** 2)
    last = l1**2 * (l1**2 * s**4 + l2**2 * np.cos(2 * alpha)) / (l2**2 - l1**2 * s**2) / root
    formulas = (l1 * c + root, -l1 * s - l1**2 * s * c / root, -l1 * c - last)  # (30), (31), (32)
    for got, wanted in zip(
        (motion.positions, motion.velocities, motion.accelerations), formulas, strict=True
    ):
        np.testing.assert_allclose(got["O3"][:, 0], wanted, rtol=0, atol=5e-15)
        np.testing.assert_array_equal(got["O3"][:, 1], 0.0)


@pytest.mark.parametrize("name", ["piston_crank", "lever_crank"])
def test_velocities_and_accelerations_are_derivatives(name: str) -> None:
    divisions = 3600
    motion = solved(name, divisions)
    step = 2 * np.pi / divisions
    for node in motion.positions:
        for value, rate in (
            (motion.positions, motion.velocities),
            (motion.velocities, motion.accelerations),
        ):
            x = value[node]
            difference = (8 * (x[3:-1] - x[1:-3]) - (x[4:] - x[:-4])) / (12 * step)
            np.testing.assert_allclose(rate[node][2:-2], difference, rtol=0, atol=1e-7)


def test_the_lever_keeps_its_lengths_above_the_frame() -> None:
    motion = solved("lever_crank")
    pin, end = motion.positions["O2"], motion.positions["O3"]
    np.testing.assert_allclose(np.hypot(*(end - pin).T), 60.0, rtol=1e-15)
    np.testing.assert_allclose(np.hypot(*(end - [100.0, 0.0]).T), 80.0, rtol=1e-15)
    assert (end[:, 1] > 0).all()


def test_the_approximate_position_chooses_the_side() -> None:
    text = (SCENES / "lever_crank.toml").read_text(encoding="utf-8")
    below = closed_form(scene_from_toml(text.replace("[45, 58]", "[45, -58]")), 60, 61)
    above = solved("lever_crank")
    assert below is not None
    np.testing.assert_allclose(
        below.positions["O3"], above.positions["O3"][::-1] * [1, -1], rtol=0, atol=1e-12
    )


@pytest.mark.parametrize("name", ["watt_six_bar", "stephenson_six_bar", "five_bar"])
def test_other_linkages_have_none(name: str) -> None:
    assert closed_form(read_scene(SCENES / f"{name}.toml"), 60, 61) is None


def test_later_turns_repeat_the_first_bit_for_bit() -> None:
    scene = read_scene(SCENES / "lever_crank.toml")
    motion = closed_form(scene, 12, 37)
    assert motion is not None
    for table in (motion.positions, motion.velocities, motion.accelerations):
        assert table["O3"].shape == (37, 2)
        np.testing.assert_array_equal(table["O3"][24:], table["O3"][:13])
    first = closed_form(scene, 12, 13)
    assert first is not None
    np.testing.assert_array_equal(first.positions["O3"], motion.positions["O3"][:13])
