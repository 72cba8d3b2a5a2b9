"""Where a run cannot go on, what it says, and how it passes where the rank drops."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.model.errors import MotionError, SolveError
from kousoku.model.reading.builder import SceneBuilder
from kousoku.model.reading.families import chain, n_four_bar
from kousoku.model.reading.read import scene_from_dict
from kousoku.runtime.integrate.motion import Motion
from kousoku.runtime.run_stop import joints_at_stop

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.model.records.scene import Scene
    from kousoku.runtime.dynamics import DynamicsSolver

    Load = Callable[..., DynamicsSolver]

#: A start from which a stage of a step falls near a position where the rank drops.
ANGLE = 2 * math.pi / 10 + 0.1


def four_bars(angle: float = ANGLE) -> Scene:
    return n_four_bar(2, turned=(math.cos(angle), math.sin(angle)))


def crank_angle(end: float) -> float:
    """Angle of the cranks of a double parallelogram, by small steps of fourth order."""
    factor = 9.81 * (1.5 + 2) / (1 + 2)
    steps = 40_000
    h, theta, rate = end / steps, ANGLE, -1.0
    for _ in range(steps):
        a = -factor * math.cos(theta)
        b = -factor * math.cos(theta + h * rate / 2 + h * h * a / 8)
        c = -factor * math.cos(theta + h * rate + h * h * b / 2)
        theta += h * rate + h * h * (a + 2 * b) / 6
        rate += h * (a + 4 * b + c) / 6
    return theta


def test_error_falls_with_the_tolerance_where_stages_come_near_a_loss_of_rank(load: Load) -> None:
    solver, theta = load(four_bars()), crank_angle(10.0)
    errors = []
    for tolerance in (1e-7, 1e-8, 1e-9, 1e-10, 1e-11):
        motion = solver.simulate(10.0, samples=11, tolerance=tolerance)
        x, y = motion.position["coupler_0"][-1, :2]
        errors.append(math.hypot(x - math.cos(theta), y - math.sin(theta)))
    assert errors == sorted(errors, reverse=True)
    assert errors[-1] < 1e-8
    assert errors[0] > 1e-7


def test_ledger_notes_where_the_rank_nearly_dropped_and_how_it_was_passed(load: Load) -> None:
    ledger = load(four_bars()).simulate(10.0, samples=1001, tolerance=1e-11).ledger
    assert ledger.avoided > 0
    assert ledger.growth < 1e-4
    rows = load(four_bars()).simulate(times=[0.0, ledger.growth_time], tolerance=1e-11)
    x, y = rows.position["coupler_0"][-1, :2]
    assert abs(y) < 0.2 < abs(x)
    elsewhere = load(four_bars(-math.pi / 2)).simulate(0.3, tolerance=1e-9).ledger
    assert elsewhere.avoided == 0
    assert elsewhere.growth > 1e-4


def test_steps_are_not_made_shorter_where_small_pivots_are_the_rule(load: Load) -> None:
    usual = load(chain(3)).simulate(1.0, samples=3).ledger
    run = load(chain(3)).begin([0.0, 0.5, 1.0])
    best = run.solver.state["largest_pivot_ratio"].view(run.state)
    best[...] = 1e30
    ledger = run.finish().ledger
    assert best < 1e8
    assert ledger.avoided == 0
    assert abs(ledger.steps - usual.steps) <= 1  # what is normal is no error of the first


@pytest.mark.parametrize("tolerance", [1e-13, 1e-14, 1e-15])
def test_tolerances_near_rounding_do_not_stagnate(load: Load, tolerance: float) -> None:
    ledger = load(four_bars()).simulate(10.0, samples=3, tolerance=tolerance).ledger
    assert ledger.steps < 2000
    assert ledger.rejected < 100


def test_run_that_needs_too_many_steps_is_stopped_and_keeps_its_rows(load: Load) -> None:
    with pytest.raises(MotionError, match=r"at t = \S+ s: 20 steps are made .* larger tol") as stop:
        load(chain(3)).simulate(10.0, samples=1001, most_steps=20)
    motion = stop.value.result
    assert isinstance(motion, Motion)
    assert 10 < len(motion) < 1001
    assert not motion.is_complete
    assert motion.ledger.steps == 20


def rubbed(law: str, speed: float) -> dict[str, Any]:
    """Block on a line under a force."""
    block = {"position": [0, 0, 0], "velocity": [speed, 0, 0], "point": True, "mass": 1}
    line = {"type": "point_on_line", "bodies": ["ground", "block"]}
    return {
        "name": "rub",
        "unit": "m",
        "bodies": {"block": block},
        "joints": {"a": line | {"points": [[0] * 3] * 2, "axes": [[1, 0, 0]] * 2}},
        "coordinates": {"s": {"body": "block", "along": [1, 0, 0]}},
        "forces": {"rub": {"type": "along", "coordinate": "s", "force": law}},
    }


@pytest.mark.parametrize("law", ["-3*sign(s_dot)", "-3*s_dot/abs(s_dot)"])
def test_run_that_chatters_at_a_sign_says_which_force_to_smooth(load: Load, law: str) -> None:
    with pytest.raises(MotionError, match=r"the sign in forces\.rub jumps, .* x/sqrt\(x\^2"):
        load(scene_from_dict(rubbed(law, 1.0))).simulate(2.0, samples=3, most_steps=2000)


@pytest.mark.parametrize(
    "rub", ["s_dot/abs(s_dot)", "s_dot^3/sqrt(s_dot^6)", "s_dot/sqrt(s_dot^2)"]
)
def test_a_body_starts_from_rest_against_friction_that_is_written_as_a_quotient(
    load: Load, rub: str
) -> None:
    """Its force was 0/0 there, and the start was refused."""
    motion = load(scene_from_dict(rubbed(f"2 - 0.5*{rub}", 0.0))).simulate(2.0, samples=3)
    assert motion.position["block"][:, 0] == pytest.approx([0.0, 0.75, 3.0], abs=1e-8)
    assert motion.ledger.trust


def test_start_without_a_determined_motion_names_the_joint_that_depends(load: Load) -> None:
    with pytest.raises(SolveError, match=r"do not determine.*dependent at joints\.after_0"):
        load(four_bars(0.0)).simulate(1.0)


def test_motion_that_is_too_fast_for_any_step_stops_at_its_last_good_state(load: Load) -> None:
    builder = SceneBuilder("fast", unit="m").gravity(0, -9.81, 0)
    builder.body(
        "rod",
        position=(0, 0, 0),
        angular_velocity=(0, 0, 1e20),
        boxes=[{"mass": 1, "size": (1, 1, 1), "at": (1, 0, 0)}],
    )
    builder.joint("hinge", type="revolute", bodies=("ground", "rod"), at=(0, 0, 0), axis=(0, 0, 1))
    with pytest.raises(MotionError, match=r"at t = .* no step can be taken.*joints\.hinge") as stop:
        load(builder.build()).simulate(1.0)
    motion = stop.value.result
    assert isinstance(motion, Motion)
    assert len(motion) == 1
    assert np.isfinite(motion.position["rod"]).all()
    assert not motion.is_complete


def test_stop_names_open_joints_the_worst_first_and_joints_whose_rows_depend() -> None:
    rows = [("a", "m"), ("a", "rad"), ("b", "m"), ("c", "rad"), ("d", "m")]
    residuals = np.array([1e-3, -0.5, 1e-12, 2.0, 1e-2])
    text = joints_at_stop(rows, residuals, np.array([1.0, 2.0, 1e-13, 5.0, np.nan]))
    assert text == (
        "; open: joints.c by 2 rad, joints.a by 0.5 rad, joints.d by 0.01 m;"
        " rows are nearly dependent at joints.b (pivot ratio 2.0e-14)"
    )
    quiet = joints_at_stop(rows, np.zeros(5), np.array([1.0, 0.1, 0.01, 0.5, 0.6]))
    assert quiet.startswith("; the smallest pivots are at joints.b, joints.a")
    assert joints_at_stop([], np.zeros(0), np.zeros(0)) == ""


def test_stop_names_joints_whose_pivots_rounding_made_negative() -> None:
    rows = [("a", "m"), ("b", "m"), ("c", "m")]
    text = joints_at_stop(rows, np.zeros(3), np.array([1.0, -1e-14, 2.0]))
    assert "rows are nearly dependent at joints.b (" in text


def test_rows_in_the_last_step_that_is_allowed_are_written(load: Load) -> None:
    """More of them than are asked for in one call."""
    solver, times = load(chain(1)), np.linspace(0.0, 0.01, 5000)
    steps = solver.simulate(times=times).ledger.steps
    assert len(solver.simulate(times=times, most_steps=steps)) == len(times)
