"""Motions without drivers keep to their branch where another one comes near, or say so."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from msgspec.structs import replace

from kousoku.model.reading.families import n_four_bar
from kousoku.model.reading.read import scene_from_toml
from kousoku.model.reading.write import to_toml
from kousoku.runtime.dynamics import load_dynamics
from tests.runtime.test_dynamics_driven import CRANK, end_of, four_bar, pin

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from kousoku.model.records.scene import Scene
    from kousoku.runtime.dynamics import DynamicsSolver

    Load = Callable[..., DynamicsSolver]

TORQUE = '\n[forces]\nm = { type = "torque", body = "crank", torque = [0, 0, 40] }\n'


def turned_by_a_torque(gap: float) -> Scene:
    """Four-bar whose rocker is longer than its crank by a gap: nearly a parallelogram."""
    scene = replace(four_bar(rocker=CRANK + gap), drivers={}, parameters={}, gravity=(0, 0, 0))
    return scene_from_toml(to_toml(scene) + TORQUE)


def off_branch(motion: Any, gap: float) -> float:
    """Largest distance of the end of the rocker from where coupler and rocker meet."""
    crank = end_of(motion, "crank", CRANK)
    wanted = pin(np.arctan2(crank[:, 1], crank[:, 0]), CRANK + gap)
    return float(np.abs(end_of(motion, "rocker", CRANK + gap) - wanted).max())


@pytest.mark.parametrize("gap", [1e-8, 1e-6, 1e-5, 1e-4])
@pytest.mark.parametrize(
    ("method", "tolerance"), [("dopri5", 1e-3), ("dopri5", 1e-5), ("dop853", 1e-3)]
)
def test_no_step_leaps_onto_the_branch_that_comes_near(
    load: Load, gap: float, method: Any, tolerance: float
) -> None:
    motion = load(turned_by_a_torque(gap)).simulate(1.0, tolerance=tolerance, method=method)
    assert off_branch(motion, gap) < 1e-9
    assert motion.ledger.branch_points == 0


@pytest.mark.parametrize(
    ("gap", "method", "tolerance", "end"),
    [
        (4.340235696184842e-09, "dop853", 5.056795787588038e-4, 1.8904569742489217),
        (1.299987729570446e-09, "dopri5", 9.316186824494735e-4, 0.9677333649813499),
        (1.4368991900073658e-09, "dop853", 6.911550037302846e-4, 1.9883912725866348),
    ],
    ids=["by the end of a step", "by the start of one", "by the start where roots level off"],
)
def test_no_long_step_leaps_at_an_end_of_it(
    load: Load, gap: float, method: Any, tolerance: float, end: float
) -> None:
    """No stage is near the place, and roots of pivot ratios at the ends are large or level."""
    motion = load(turned_by_a_torque(gap)).simulate(
        end, samples=21, tolerance=tolerance, method=method
    )
    assert off_branch(motion, gap) < 1e-9


@pytest.mark.usefixtures("compiler")
@pytest.mark.parametrize("gap", [1.3e-9, 4.4e-9, 2.7e-8])
@pytest.mark.parametrize("method", ["dopri5", "dop853"])
def test_no_motion_at_loose_tolerances_is_wrong_and_trusted(
    bodies_folder: Callable[..., Path], gap: float, method: Any
) -> None:
    solver = load_dynamics(bodies_folder(turned_by_a_torque(gap), ()), target="c")
    motions = [
        solver.simulate(2.0, samples=21, tolerance=float(tolerance), method=method)
        for tolerance in np.geomspace(2e-4, 1e-3, 200)
    ]
    wrong = [motion for motion in motions if off_branch(motion, gap) > 1e-6]
    assert not any(motion.ledger.trust.is_trusted for motion in wrong)
    assert sum(motion.ledger.trust.is_trusted for motion in motions) > 50


@pytest.mark.parametrize("method", ["dopri5", "dop853"])
def test_branches_that_no_step_tells_apart_are_told(load: Load, method: Any) -> None:
    """They are 3e-6 of a length from each other where they are nearest."""
    motion = load(turned_by_a_torque(1e-11)).simulate(1.0, tolerance=1e-3, method=method)
    trust = motion.ledger.trust
    assert not trust.is_trusted
    assert "may be that of another branch" in trust.why
    assert motion.ledger.branch_point_time is not None
    assert 0.55 < motion.ledger.branch_point_time < 1.0
    assert "may be that of another branch" in str(motion.ledger)


@pytest.mark.parametrize("tolerance", [1e-2, 1e-4, 1e-6])
@pytest.mark.parametrize("method", ["dopri5", "dop853"])
def test_where_branches_do_meet_motions_go_straight_on_and_are_trusted(
    load: Load, method: Any, tolerance: float
) -> None:
    motion = load(n_four_bar(2)).simulate(4.0, tolerance=tolerance, method=method)
    assert motion.ledger.growth < 1e-2
    assert motion.ledger.trust.is_trusted
    first = motion.position["coupler_0"]
    assert np.abs(motion.position["coupler_1"] - first - [1, 0, 0]).max() < 1e-9


@pytest.mark.parametrize("gap", [1e-13, 4e-13])
@pytest.mark.parametrize("method", ["dopri5", "dop853"])
def test_bodies_are_carried_over_gaps_that_numbers_of_a_scene_are_rounded_to(
    load: Load, method: Any, gap: float
) -> None:
    """A parallelogram in kilometres has such gaps in metres: it stopped there, or crept."""
    motion = load(turned_by_a_torque(gap)).simulate(1.0, tolerance=1e-8, method=method)
    crank, rocker = end_of(motion, "crank", CRANK), end_of(motion, "rocker", CRANK)
    assert np.abs(rocker - crank - [3.0, 0.0]).max() < 1e-5
    assert motion.ledger.steps < 200
    assert motion.ledger.trust.is_trusted
    assert "branches meet at t = " in str(motion.ledger.trust)


def test_steps_of_a_fixed_length_tell_that_they_leapt(load: Load) -> None:
    motion = load(turned_by_a_torque(1e-6)).simulate(1.0, step=0.02, method="dopri5")
    assert off_branch(motion, 1e-6) > 0.1
    assert "may be that of another branch" in motion.ledger.trust.why


@pytest.mark.usefixtures("numpy_solver")
@pytest.mark.parametrize("gap", [0.0, 1e-5, 1e-11])
def test_both_targets_find_the_branch_with_the_same_bits(
    compiler: object, bodies_folder: Callable[..., Path], gap: float
) -> None:
    del compiler
    folder = bodies_folder(turned_by_a_torque(gap), ())
    runs = []
    for target in ("c", "numpy"):
        runs.append(load_dynamics(folder, target=target).begin([0.0, 0.7], tolerance=1e-3))
        runs[-1].finish()
    assert np.array_equal(runs[0].save().state, runs[1].save().state)
