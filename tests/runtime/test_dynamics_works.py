"""Works under kinematics: right for every number of rows, and checked by a rule of their own."""

from __future__ import annotations

import math
import sys
import tomllib
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import kousoku

if TYPE_CHECKING:
    from kousoku.mechanism import Mechanism

SCENES = Path(__file__).parents[2] / "scenes"
OMEGA, DAMPING, PULL = 40 * math.pi, 0.01, 100.0
#: The most that a count of evaluations may have grown.
MORE = 1.05

pytestmark = pytest.mark.usefixtures("numpy_solver")


def shaker(value: str, force: str) -> Mechanism:
    """Shaft that a driver leads against a load."""
    scene = {
        "name": "shaker",
        "unit": "m",
        "outputs": ["energies"],
        "bodies": {
            "shaft": {
                "position": [0, 0, 0],
                "mass": 1,
                "inertia": {"xx": 0.1, "yy": 0.1, "zz": 0.1},
            }
        },
        "joints": {
            "axle": {
                "type": "revolute",
                "bodies": ["ground", "shaft"],
                "at": [0, 0, 0],
                "axis": [0, 0, 1],
            }
        },
        "coordinates": {"turn": {"joint": "axle"}},
        "drivers": {"motor": {"coordinate": "turn", "value": value}},
        "forces": {"load": {"type": "along", "coordinate": "turn", "force": force}},
    }
    return kousoku.load(scene, target="numpy")


@pytest.mark.parametrize("samples", [2, 3, 8, 41])
def test_works_are_right_for_every_number_of_rows(samples: int) -> None:
    run = shaker("sin(40*pi*t)", f"-{DAMPING}*turn_dot").simulate(1, samples=samples)
    lost = DAMPING * OMEGA**2 / 2
    assert run.ledger.works["load"] == pytest.approx(-lost, rel=1e-8)
    assert run.ledger.works["motor"] == pytest.approx(lost, rel=1e-8)
    assert run.ledger.trust.is_trusted
    assert run.ledger.trust.work_error is not None
    assert run.ledger.trust.work_error < 1e-6 * lost


@pytest.mark.parametrize("samples", [2, 11, 101])
def test_small_changes_of_a_large_power_count(samples: int) -> None:
    """The shaft turns on as it swings: what swings is a hundredth of the power."""
    run = shaker("5*t + sin(3*t)", f"-{PULL} - {DAMPING}*turn_dot").simulate(2, samples=samples)
    turned = 10 + math.sin(6)
    squares = 2 * 25 + 10 * math.sin(6) + 9 * (1 + math.sin(12) / 12)
    wanted = -PULL * turned - DAMPING * squares
    assert run.ledger.works["load"] == pytest.approx(wanted, rel=1e-9)


@pytest.mark.compiles
@pytest.mark.parametrize("samples", [21, 1001])
def test_work_of_a_motor_is_the_energy_that_moves(samples: int) -> None:
    run = kousoku.load(SCENES / "engine.toml", outputs=["energies"]).simulate(1, samples=samples)
    trust = run.ledger.trust
    assert trust.is_trusted
    assert trust.energy_error is not None
    assert trust.energy_moved is not None
    assert trust.energy_error < 1e-8 * trust.energy_moved


#: Evaluations of committed scenes in 2 s, two rows, at tolerances, before a second rule of
#: quadrature checked works, which were off by up to 5,000 tolerances then.
EVALUATIONS = {
    "engine": {1e-4: 2842, 1e-6: 6037},
    "loop": {1e-6: 46, 1e-9: 154},
    "constant_velocity": {1e-9: 299},
    "gear_train": {1e-4: 26, 1e-9: 26},
}


@pytest.mark.compiles
@pytest.mark.parametrize("name", EVALUATIONS)
def test_works_cost_no_more_evaluations_than_unchecked_ones(name: str) -> None:
    mechanism = kousoku.load(SCENES / f"{name}.toml", outputs=["energies"])
    for tolerance, most in EVALUATIONS[name].items():
        ledger = mechanism.simulate(2, samples=2, tolerance=tolerance).ledger
        trust = ledger.trust
        assert ledger.derivatives <= MORE * most
        assert trust.energy_error is not None
        assert trust.energy_moved is not None
        assert trust.energy_error <= 0.5 * trust.limit * trust.energy_moved


@pytest.mark.compiles
@pytest.mark.parametrize("samples", [21, 61])
@pytest.mark.parametrize("tolerance", [1e-9, 1e-11])
def test_works_hold_in_rows_between_positions(samples: int, tolerance: float) -> None:
    """Its power is nearly straight where the motion begins: three of them tell no error there."""
    mechanism = kousoku.load(SCENES / "constant_velocity.toml", outputs=["energies"])
    for method in ("kinematics", "dopri5", "dop853"):
        options: Any = {"samples": samples, "method": method, "tolerance": tolerance}
        trust = mechanism.simulate(0.5, **options).ledger.trust
        assert trust.is_trusted
        assert trust.energy_error is not None
        assert trust.energy_moved is not None
        assert trust.energy_error < 0.3 * trust.limit * trust.energy_moved


#: A light shaft that is driven fast, and a heavy one that hardly turns.
HEAVY = """
name = "heavy"
unit = "m"
[bodies]
light = { position = [0, 0, 0], mass = 0.01, inertia = { xx = 1e-4, yy = 1e-4, zz = 1e-4 } }
heavy = { position = [2, 0, 0], mass = 1e5, inertia = { xx = 1e4, yy = 1e4, zz = 1e4 } }
[joints]
fast = { type = "revolute", bodies = ["ground", "light"], at = [0, 0, 0], axis = [0, 0, 1] }
slow = { type = "revolute", bodies = ["ground", "heavy"], at = [2, 0, 0], axis = [0, 0, 1] }
[coordinates]
x = { joint = "fast" }
y = { joint = "slow" }
[forces.load]
type = "along"
coordinate = "x"
force = "0.02*sin(3*x)*x_dot - 0.001*x_dot*abs(x_dot)"
[drivers]
one = { coordinate = "x", value = "t + 0.5*sin(3*t)" }
other = { coordinate = "y", value = "1e-4*t" }
"""


@pytest.mark.compiles
def test_works_are_exact_where_heavy_bodies_hardly_move() -> None:
    mechanism = kousoku.load(tomllib.loads(HEAVY))
    wanted = mechanism.simulate(10, samples=3, method="dop853", tolerance=1e-12).ledger.works
    works = mechanism.simulate(10, samples=3, method="kinematics").ledger.works
    for name in ("load", "one"):
        assert works[name] == pytest.approx(wanted[name], rel=1e-7)


#: A point that is pushed for a moment, a wheel that turns, and a heavy body that does not.
PUSHED = """
name = "pushed"
unit = "m"
[bodies]
point = { position = [0, 0, 0], point = true, mass = 1 }
heavy = { position = [5, 0, 0], mass = 500, inertia = { xx = 50, yy = 50, zz = 50 } }
[bodies.wheel]
position = [3, 0, 0]
mass = 0.5
inertia = { xx = 0.05, yy = 0.05, zz = 0.05 }
angular_velocity = [0, 0, 0.6]
[joints]
axle = { type = "revolute", bodies = ["ground", "wheel"], at = [3, 0, 0], axis = [0, 0, 1] }
hinge = { type = "revolute", bodies = ["ground", "heavy"], at = [5, 0, 0], axis = [0, 0, 1] }
[forces.push]
type = "force"
body = "point"
force = ["0", "0", "sin(5*t)"]
"""


@pytest.mark.compiles
@pytest.mark.parametrize("method", ["dopri5", "dop853"])
def test_a_motion_beside_heavy_bodies_that_stand_is_trusted(method: Any) -> None:
    mechanism = kousoku.load(tomllib.loads(PUSHED))
    assert mechanism.simulate(0.25, samples=51, method=method).ledger.trust.is_trusted


def pulsing(monkeypatch: pytest.MonkeyPatch) -> Mechanism:
    """Shaft that turns evenly, whose load is 2 at rows and between, and 1 on average.

    Nothing bounds the formula: steps know of it what they sample.
    """
    mechanism = shaker("t", "2*cos(40*pi*t)^2")
    target: Any = mechanism.solver.target
    integrator = sys.modules[type(target.solver).__module__]
    monkeypatch.setattr(integrator, "resolved_step", lambda _tolerance, _h, _part, end, *_: end)
    return mechanism


def test_what_the_rule_of_steps_cannot_see_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    mechanism = pulsing(monkeypatch)
    run = mechanism.begin(np.linspace(0.0, 8.0, 81))
    solver: Any = mechanism.solver
    solver.state["steps"].view(run.state)[...] = 1.0  # its first steps are not tried
    trust = run.finish().ledger.trust
    assert trust.energy_error is not None
    assert trust.energy_moved is not None
    assert trust.work_error is not None
    assert trust.energy_error < 1e-12  # load and motor miss the same
    assert trust.work_error > 0.1 * trust.energy_moved
    assert "works are off by" in trust.why
    assert not trust.is_trusted


def test_steps_that_are_tried_do_not_depend_on_bounds_of_formulas(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    run = pulsing(monkeypatch).simulate(4, samples=2)
    assert run.ledger.works["load"] == pytest.approx(4, rel=1e-8)
    assert run.ledger.trust.is_trusted


def test_other_methods_have_no_second_rule() -> None:
    mechanism = shaker("sin(3*t)", f"-{DAMPING}*turn_dot")
    options: Any = {"samples": 3}
    assert mechanism.simulate(1, method="dop853", **options).ledger.trust.work_error is None
    assert mechanism.simulate(1, checks=False, **options).ledger.trust.work_error is None
    assert mechanism.simulate(1, **options).ledger.trust.work_error is not None
