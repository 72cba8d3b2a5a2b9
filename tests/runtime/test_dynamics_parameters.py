"""Parameters of a run, and steps of a fixed length."""

from __future__ import annotations

import pickle
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.model.angles import number_of
from kousoku.model.errors import SolveError
from kousoku.model.reading.families import chain, n_four_bar
from kousoku.model.reading.read import scene_from_toml

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.runtime.dynamics import DynamicsSolver

    Load = Callable[..., DynamicsSolver]

ARM = """
name = "arm"
unit = "m"
[parameters]
rate = 4
phase = 0.5
[bodies.arm]
position = [0, 0, 0]
boxes = [{ mass = 2, size = [1, 0.1, 0.1], at = [0.5, 0, 0] }]
[bodies.bob]
position = [2, 0, 0]
mass = 1
point = true
[joints.hinge]
type = "revolute"
bodies = ["ground", "arm"]
at = [0, 0, 0]
axis = [0, 0, 1]
[drivers]
motor = { joint = "hinge", value = "rate*t + phase" }
[forces.push]
type = "force"
body = "bob"
force = ["rate", "phase*t", 0]
"""
TIMES = np.linspace(0.0, 2.0, 9)


@pytest.fixture
def arm(load: Load) -> Any:
    return load(scene_from_toml(ARM))


def moved(motion: Any) -> tuple[Any, Any]:
    """Angle of the arm and the displacement of the bob."""
    e = motion.orientation["arm"]
    return np.unwrap(2 * np.arctan2(e[:, 3], e[:, 0])), motion.position["bob"] - [2.0, 0.0, 0.0]


@pytest.mark.parametrize("given", [{}, {"rate": -3.0}, {"phase": 1, "rate": 0.25}])
def test_formulas_take_the_parameters_of_the_run(arm: Any, given: dict[str, float]) -> None:
    values = {"rate": 4.0, "phase": 0.5} | given
    motion = arm.simulate(times=TIMES, parameters=given, tolerance=1e-12)
    angle, way = moved(motion)
    turns = angle - (values["rate"] * TIMES + values["phase"])
    np.testing.assert_allclose(turns, turns[0], rtol=0, atol=1e-12)
    assert turns[0] / (4 * np.pi) == pytest.approx(round(turns[0] / (4 * np.pi)), abs=1e-12)
    np.testing.assert_allclose(way[:, 0], values["rate"] * TIMES**2 / 2, rtol=0, atol=1e-11)
    np.testing.assert_allclose(way[:, 1], values["phase"] * TIMES**3 / 6, rtol=0, atol=1e-11)
    assert motion.ledger.parameters == values


def test_parameters_may_be_angles_in_degrees(arm: Any) -> None:
    given = arm.simulate(times=TIMES, parameters={"phase": "30 deg", "rate": "2"})
    assert dict(given.parameters) == {"rate": 2.0, "phase": number_of("30 deg")}
    assert dict(arm.at({"phase": "30 deg", "rate": 2.0}).parameters) == dict(given.parameters)


def test_a_saved_run_keeps_its_parameters(arm: Any) -> None:
    given = {"rate": 1.5}
    wanted = arm.simulate(times=TIMES, parameters=given).columns()
    run = arm.begin(TIMES, parameters=given)
    run.advance(2, 3)
    motion = arm.resume(pickle.loads(pickle.dumps(run.save()))).finish()
    for name, values in motion.columns().items():
        np.testing.assert_array_equal(values, wanted[name], err_msg=name)
    assert motion.ledger.parameters == {"rate": 1.5, "phase": 0.5}


@pytest.mark.parametrize(
    ("given", "says"),
    [
        (
            {"rat": 1.0},
            r"arm: no parameter 'rat': its formulas have rate, phase; did you mean 'rate'\?",
        ),
        (
            {"x": 1.0, "rate": np.inf},
            "no parameter 'x': .*; parameter rate is inf, wanted a finite",
        ),
        ({"rate": "fast"}, "parameter rate is 'fast', wanted a finite number"),
    ],
)
def test_parameters_that_cannot_be_are_named_at_once(
    arm: Any, given: dict[str, Any], says: str
) -> None:
    with pytest.raises(SolveError, match=says):
        arm.begin(TIMES, parameters=given)


def test_scenes_without_parameters_say_so(load: Load) -> None:
    with pytest.raises(SolveError, match="no parameter 'k': its formulas have none"):
        load(n_four_bar(1)).begin(TIMES, parameters={"k": 1.0})


@pytest.mark.parametrize(("method", "order"), [("dopri5", 5), ("dop853", 8)])
def test_errors_of_fixed_steps_fall_with_the_order_of_the_method(
    load: Load, method: str, order: int
) -> None:
    solver = load(chain(2))
    exact = solver.simulate(times=[0.0, 0.5], tolerance=1e-14).position["bar_1"][-1]
    errors = []
    for step in (0.1, 0.05):
        motion = solver.simulate(times=[0.0, 0.5], method=method, step=step)
        assert motion.ledger.steps == round(0.5 / step)
        assert (motion.ledger.rejected, motion.ledger.fixed_step) == (0, step)
        assert motion.ledger.worst("position")[0] < 1e-13
        errors.append(np.abs(motion.position["bar_1"][-1] - exact).max())
    assert errors[0] > 2 ** (order - 1.5) * errors[1] > 0.0


def test_rows_between_fixed_steps_meet_the_constraints(load: Load) -> None:
    solver = load(chain(2))
    motion = solver.simulate(0.5, samples=101, step=0.013)
    assert motion.ledger.steps == 39
    assert motion.ledger.worst("position")[0] < 1e-13
    close = solver.simulate(0.5, samples=101, tolerance=1e-13)
    np.testing.assert_allclose(motion.position["bar_1"], close.position["bar_1"], atol=1e-9)
