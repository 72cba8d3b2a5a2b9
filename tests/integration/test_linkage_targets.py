"""The solver of a linkage in NumPy makes the motion of the one in C, and stops where it stops."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.model.errors import KousokuError
from tests.integration.test_inputs import SLIDER
from tests.integration.test_stops import PARALLELOGRAM, four_bar

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.runtime.linkage import LinkageSolver, Trajectory

    Solver = Callable[[str, str], LinkageSolver]

#: Two cranks, of which one turns backwards; a slider that drives; a triangle that is carried along.
TWO_INPUTS = """
name = "two_inputs"
unit = "mm"
[nodes]
O1 = { at = [0, 0], fixed = true }
O5 = { at = [100, 0], fixed = true }
A = { at = [30, 0] }
B = { at = [50, 88] }
C = { at = [100, 25] }
T = { at = [20, 110] }
[links]
crank1 = { nodes = ["O1", "A"], length = 30 }
rod1 = { nodes = ["A", "B"], length = 90 }
rod2 = { nodes = ["C", "B"], length = 80 }
crank2 = { nodes = ["C", "O5"], length = 25 }
tip = { nodes = ["B", "T"], length = 40 }
[rigid]
coupler = { at = "B", links = ["rod1", "tip"], angle = 2 }
[inputs]
alpha = { link = "crank1", about = "O1", turns = 1, rate = 1.5, acceleration = 0.25 }
beta = { link = "crank2", about = "O5", from = 1.5, turns = -2, rate = -0.5, acceleration = 2 }
"""

GOOD = {"piston_crank": "piston_crank", "six_bar": "stephenson_six_bar"} | {
    "two_inputs": TWO_INPUTS,
    "ram": SLIDER,
    "nearly_dead": four_bar((30, 70.01, 60, 100), o3="[70, 58]"),
}
STOPPED: dict[str, tuple[str, dict[str, Any]]] = {
    "change_point": (PARALLELOGRAM, {}),
    "dead_centre": (four_bar((60, 60, 80, 100), "[60, 0]", "[90, 60]"), {"divisions": 17}),
    "dead_at_the_start": (four_bar((30, 100, 30, 100), o3="[130, 0]"), {}),
    "no_assembly": (four_bar((30, 10, 20, 100), o3="[70, 10]"), {}),
    "below_rounding": (four_bar(), {"limit": 1e-17}),
    "no_divisions": (four_bar(), {"divisions": 0}),
}


def assert_equal(one: Trajectory, other: Trajectory) -> None:
    """Only where the C library and NumPy round an angle's sine apart the last digits differ."""
    np.testing.assert_array_equal(one.iterations, other.iterations)
    size = max(np.abs(rows).max() for rows in one.positions.values())
    assert [*one.columns()] == [*other.columns()]
    for key, column in one.columns().items():
        np.testing.assert_allclose(column, other.columns()[key], atol=1e-13 * size, rtol=1e-12)


@pytest.mark.parametrize(
    ("name", "method"), [*((name, "newton") for name in GOOD), ("ram", "paper")]
)
@pytest.mark.usefixtures("compiler", "shipped_flags")
def test_both_targets_make_the_same_motion(solver_in: Solver, name: str, method: str) -> None:
    # Where it is nearly dead few divisions are made finer, as often as the last digits say.
    divisions = 60 if name == "nearly_dead" else 15
    options: dict[str, Any] = {"method": method, "divisions": divisions}
    one, other = (solver_in(GOOD[name], target).solve(**options) for target in ("c", "numpy"))
    assert (one.target, other.target) == ("c", "numpy")
    assert_equal(one, other)


@pytest.mark.usefixtures("compiler", "shipped_flags")
def test_both_targets_count_all_turns_alike(solver_in: Solver) -> None:
    options: dict[str, Any] = {"first_turn": 10_000, "turns": 2, "divisions": 7}
    one, other = (solver_in("lever_crank", at).solve(**options) for at in ("c", "numpy"))
    assert_equal(one, other)


@pytest.mark.parametrize("name", STOPPED)
@pytest.mark.usefixtures("compiler", "shipped_flags")
def test_both_targets_stop_alike(solver_in: Solver, name: str) -> None:
    text, options = STOPPED[name]
    stops = []
    for target in ("c", "numpy"):
        with pytest.raises(KousokuError) as stop:
            solver_in(text, target).solve(**options)
        stops.append(stop.value)
    one, other = stops
    assert type(one) is type(other)
    assert str(one) == str(other)
    kept = [getattr(stop, "trajectory", None) for stop in stops]
    assert (kept[0] is None) == (kept[1] is None)
    if kept[0] is not None and kept[1] is not None:
        assert_equal(kept[0], kept[1])
