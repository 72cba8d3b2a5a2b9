"""The verdict on a run: it speaks against motions that are wrong, and not against healthy ones."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np
import pytest

import kousoku
from kousoku.runtime.error_estimate import error_estimate
from kousoku.runtime.integrate.motion import Motion
from kousoku.runtime.messages import shortly

if TYPE_CHECKING:
    from kousoku.mechanism import Mechanism

SCENES = Path(__file__).parents[2] / "scenes"
CART: dict[str, Any] = {
    "name": "cart",
    "unit": "m",
    "bodies": {
        "cart": {
            "position": [0, 0, 0],
            "velocity": [10, 0, 0],
            "mass": 1,
            "inertia": {"xx": 0.1, "yy": 0.1, "zz": 0.1},
        }
    },
    "joints": {
        "rail": {
            "type": "prismatic",
            "bodies": ["ground", "cart"],
            "at": [0, 0, 0],
            "axis": [1, 0, 0],
        }
    },
    "coordinates": {"x": {"joint": "rail"}},
    "outputs": ["energies", "accelerations"],
}

pytestmark = pytest.mark.usefixtures("numpy_solver")


def cart(force: str, *, target: Any = "numpy") -> Mechanism:
    loads = {"load": {"type": "along", "coordinate": "x", "force": force}}
    return kousoku.load({**CART, "forces": loads}, target=target)


def double_pendulum() -> Mechanism:
    return kousoku.load(SCENES / "pendulum_on_a_rod.toml", target="numpy")


def test_healthy_run_is_trusted_and_says_so_first() -> None:
    run = cart("-3*x").simulate(2, samples=21)
    trust = run.ledger.trust
    assert trust.is_trusted
    assert str(trust).startswith("trust: energy ")
    assert "constraints at rounding" in str(trust)
    assert str(trust).endswith("error not estimated")
    assert str(run.ledger).splitlines()[0] == repr(run).splitlines()[0] == str(trust)
    assert trust.energy_moved == pytest.approx(50, rel=1e-3)


@pytest.mark.compiles
@pytest.mark.parametrize("target", ["numpy", "c"])
@pytest.mark.parametrize("method", ["dop853", "kinematics"])
def test_energy_that_has_moved_is_that_of_all_steps(method: Any, target: Any) -> None:
    bump = {"coordinate": "x", "value": "0.05/(1 + ((t - 3)/0.01)^2)"}
    at_rest = {"cart": {**CART["bodies"]["cart"], "velocity": [0, 0, 0]}}
    tree = {**CART, "bodies": at_rest, "drivers": {"road": bump}}
    mechanism = kousoku.load(tree, target=target)
    few, many = (mechanism.simulate(10, samples=n, method=method).ledger.trust for n in (2, 101))
    # at both ends nothing moves; between, the cart has up to 0.5*(9/(8 sqrt 3) 5 m/s)^2
    assert few.energy_moved is not None
    assert few.energy_moved == pytest.approx(many.energy_moved, rel=0.05)
    assert few.energy_moved > 5.2
    assert few.is_trusted


@pytest.mark.compiles
@pytest.mark.parametrize("tolerance", [1e-3, 1e-4, 1e-6, 1e-9])
@pytest.mark.parametrize("method", ["dopri5", "dop853"])
@pytest.mark.parametrize("load", ["-30*(x - 1e-14) - 20*x_dot", "-3e3*(x - 1e-15) - 2e3*x_dot"])
def test_what_is_held_at_rest_is_trusted(load: str, method: Any, tolerance: float) -> None:
    """Rounding moves it; the longest steps that dampers allow make of that what a tolerance may."""
    at_rest = {"cart": {**CART["bodies"]["cart"], "velocity": [0, 0, 0]}}
    loads = {"load": {"type": "along", "coordinate": "x", "force": load}}
    mechanism = kousoku.load({**CART, "bodies": at_rest, "forces": loads}, target="c")
    for end in (0.1, 2.0, 50.0):
        run = mechanism.simulate(end, samples=3, method=method, tolerance=tolerance)
        assert np.abs(run.body("cart").position).max() < tolerance
        assert run.ledger.trust.is_trusted, run.ledger.trust


def test_a_motion_that_is_small_beside_the_tolerance_is_told() -> None:
    """Its rows are right to the tolerance, in lengths of the scene, and of no use."""
    start = {"cart": {**CART["bodies"]["cart"], "velocity": [1e-6, 0, 0]}}
    loads = {"load": {"type": "along", "coordinate": "x", "force": "-100*x"}}
    mechanism = kousoku.load({**CART, "bodies": start, "forces": loads}, target="numpy")
    coarse, fine = (mechanism.simulate(20, samples=3, tolerance=x).ledger for x in (1e-3, 1e-12))
    assert coarse.trust.is_trusted
    assert coarse.trust.stillness is not None
    assert 1e-9 < coarse.trust.stillness < 1e-4
    assert "of a length or rad a step, less than this tolerance tells" in str(coarse.trust)
    assert fine.trust.stillness is None


def table(swing: float, unit: float = 1.0, **more: Any) -> dict[str, Any]:
    """Turntable of 10 m with a slider at its rim, on a spring; lengths in other units."""
    place, heavy = 10.0 * unit, 1e4 * unit * unit
    turn = {"angular_velocity": [0, 0, 1]}
    start = {"position": [place, 0, swing * unit], "velocity": [0, place, 0]}
    light = {"xx": unit * unit, "yy": unit * unit, "zz": unit * unit}
    zero = [[1, 0, 0], [1, 0, 0]]
    points, axes = [[place, 0, 0], [0, 0, 0]], [[0, 0, 1], [0, 0, 1]]
    return {
        "name": "table",
        "unit": {1.0: "m", 1e3: "mm"}[unit],
        "outputs": ["coordinates", "energies"],
        "bodies": {
            "t": {
                **turn,
                "position": [0, 0, 0],
                "mass": 1000,
                "inertia": {"xx": heavy, "yy": heavy, "zz": heavy},
            },
            "s": {**turn, **start, "mass": 1, "inertia": light},
        },
        "joints": {
            "hinge": {
                **{"type": "revolute", "bodies": ["ground", "t"]},
                **{"at": [0, 0, 0], "axis": [0, 0, 1]},
            },
            "slider": {
                **{"type": "prismatic", "bodies": ["t", "s"]},
                **{"points": points, "axes": axes, "zero": zero},
            },
        },
        "coordinates": {"turn": {"joint": "hinge"}, "z": {"joint": "slider"}},
        "forces": {"f": {"type": "along", "coordinate": "z", "force": "-3947.84176*z"}},
        **more,
    }


@pytest.mark.compiles
@pytest.mark.parametrize("target", ["numpy", "c"])
@pytest.mark.parametrize("method", ["dopri5", "dop853"])
def test_a_small_motion_beside_a_large_one_is_told(method: Any, target: Any) -> None:
    """Errors are compared with lengths of the scene: a swing of 1e-8 of these dies, or grows."""
    mechanism = kousoku.load(table(1e-7), target=target)
    found = [
        mechanism.simulate(4, samples=n, method=method, tolerance=1e-6).ledger.trust
        for n in (2, 333)
    ]
    small = found[0].below_tolerance
    assert [*small] == ["coordinates.z"]
    assert found[1].below_tolerance == small  # of steps, not of rows
    assert found[0].is_trusted
    told = f"coordinates.z moves by {shortly(small['coordinates.z'])} of a length or rad, less than"
    assert told in str(found[0])
    fine = mechanism.simulate(4, samples=2, method=method, tolerance=1e-12)
    assert fine.ledger.trust.below_tolerance == {}
    assert np.abs(fine["z"]).max() <= 1.0001e-7


@pytest.mark.compiles
def test_a_small_motion_is_told_in_any_unit() -> None:
    scenes = [kousoku.load(table(1e-5, unit), target="c") for unit in (1.0, 1e3)]
    metres, millimetres = (
        one.simulate(1, samples=2, tolerance=1e-6).ledger.trust.below_tolerance["coordinates.z"]
        for one in scenes
    )
    assert metres == pytest.approx(millimetres, rel=1e-3)


@pytest.mark.compiles
@pytest.mark.parametrize("swing", [0.0, 0.1])
def test_what_stands_still_and_what_moves_far_are_not_told_as_small(swing: float) -> None:
    run = kousoku.load(table(swing), target="c").simulate(1, samples=2, tolerance=1e-6)
    assert run.ledger.trust.below_tolerance == {}


@pytest.mark.compiles
def test_a_small_motion_that_is_driven_is_exact() -> None:
    """A driver leads z, and a coupling another slider by a part of it."""
    other = {**table(0.0)["bodies"]["s"], "position": [0, 10, 0], "velocity": [-10, 0, 0]}
    tree = table(0.0, drivers={"shake": {"coordinate": "z", "value": "1e-7*t^2"}}, forces={})
    tree["bodies"]["o"] = other
    tree["joints"]["other"] = {
        **tree["joints"]["slider"],
        **{"bodies": ["t", "o"], "points": [[0, 10, 0], [0, 0, 0]]},
    }
    tree["coordinates"]["y"] = {"joint": "other"}
    tree["joints"]["lever"] = {"type": "linear", "coordinates": ["z", "y"], "factors": [1, -2]}
    run = kousoku.load(tree, target="c").simulate(1, samples=2, tolerance=1e-6, method="dop853")
    assert abs(run["z"][-1]) == pytest.approx(1e-7, rel=1e-6)
    assert run.ledger.trust.below_tolerance == {}


@pytest.mark.compiles
def test_a_body_without_a_coordinate_that_moves_by_little_is_told() -> None:
    tree = table(1e-7, outputs=["energies"])
    still = {**tree["bodies"]["s"], "position": [3, 0, 1e-7], "velocity": [0, 0, 0]}
    tree["bodies"]["apart"] = still | {"angular_velocity": [0, 0, 0]}
    tree["forces"]["own"] = {
        **{"type": "spring_damper", "bodies": ["ground", "apart"]},
        **{"points": [[3, 0, -5], [0, 0, 0]], "stiffness": 100, "free_length": 5},
    }
    trust = kousoku.load(tree, target="c").simulate(1, samples=2, tolerance=1e-6).ledger.trust
    assert [*trust.below_tolerance] == ["bodies.apart"]
    assert "bodies.apart moves by " in str(trust)


@pytest.mark.compiles
def test_a_run_that_lost_its_energy_in_many_steps_is_not_trusted() -> None:
    loads = {"load": {"type": "along", "coordinate": "x", "force": "-1e6*x"}}
    mechanism = kousoku.load({**CART, "forces": loads}, target="c")
    trust = mechanism.simulate(40, samples=3, tolerance=1e-3).ledger.trust
    assert trust.energy_error is not None
    assert trust.energy_moved is not None
    assert trust.energy_error > 0.5 * trust.energy_moved
    assert not trust.is_trusted


def test_energy_that_no_work_explains_is_told_with_its_limit() -> None:
    run = cart("-3*x").simulate(20, samples=21, step=1.0)
    trust = run.ledger.trust
    assert not trust.is_trusted
    assert trust.energy_error is not None
    assert trust.energy_moved is not None
    assert trust.energy_error > trust.limit * trust.energy_moved
    assert trust.limit == pytest.approx(1e-7)  # a fixed step has no tolerance
    assert str(trust).startswith("not trusted: energy is off by ")
    assert "try a smaller step" in str(trust)


@pytest.mark.compiles
@pytest.mark.parametrize("target", ["numpy", "c"])
@pytest.mark.parametrize("mass", [1e-30, 1.0, 1e9])
def test_the_same_motion_of_another_mass_is_trusted_alike(mass: float, target: Any) -> None:
    inertia = dict.fromkeys(("xx", "yy", "zz"), 0.1 * mass)
    body = CART["bodies"]["cart"] | {"mass": mass, "inertia": inertia}
    loads = {"load": {"type": "along", "coordinate": "x", "force": f"-{mass}*x"}}
    mechanism = kousoku.load({**CART, "bodies": {"cart": body}, "forces": loads}, target=target)
    assert mechanism.simulate(20, samples=2).ledger.trust.is_trusted
    for method in ("dopri5", "dop853"):
        run = mechanism.simulate(20, samples=2, method=method, step=1.5)
        assert not run.ledger.trust.is_trusted


@pytest.mark.compiles
@pytest.mark.parametrize("target", ["numpy", "c"])
@pytest.mark.parametrize("method", ["dopri5", "dop853"])
def test_fixed_steps_in_which_bodies_turn_too_far_are_told(method: Any, target: Any) -> None:
    """Energy says nothing of the angle of a rotor; that Euler parameters lose their norm does."""
    rotor = {**CART["bodies"]["cart"], "velocity": [0, 0, 0], "angular_velocity": [0, 0, 314]}
    hinge = {**CART["joints"]["rail"], "type": "revolute", "axis": [0, 0, 1]}
    changes = {"bodies": {"cart": rotor}, "joints": {"rail": hinge}, "outputs": ["coordinates"]}
    mechanism = kousoku.load({**CART, **changes}, target=target)
    wrong, right = (
        mechanism.simulate(1, samples=3, method=method, step=step) for step in (0.02, 1e-3)
    )
    assert abs(wrong["x"][-1] - 314) > 0.01
    assert not wrong.ledger.trust.is_trusted
    assert "a step left the constraints by" in wrong.ledger.trust.why
    assert right["x"][-1] == pytest.approx(314, abs=1e-5)
    assert right.ledger.trust.is_trusted


def test_rows_between_steps_that_are_off_the_constraints_are_told() -> None:
    run = double_pendulum().simulate(2, samples=101, step=0.5)
    trust = run.ledger.trust
    assert trust.row_drift is not None
    assert trust.row_drift > trust.limit
    assert "rows between steps are off the constraints by" in trust.why


def test_corrections_where_nothing_is_free_are_no_error() -> None:
    def hinge(bodies: list[str], at: list[int], axis: list[int]) -> dict[str, Any]:
        return {"type": "revolute", "bodies": bodies, "at": at, "axis": axis}

    tree: dict[str, Any] = {
        "name": "wiper",
        "unit": "m",
        "bodies": {"arm": {"position": [0, 0, 0]}, "blade": {"position": [1, 0, 0]}},
        "joints": {
            "pivot": hinge(["ground", "arm"], [0, 0, 0], [0, 0, 1]),
            "hinge": hinge(["arm", "blade"], [1, 0, 0], [0, 1, 0]),
        },
        "drivers": {
            "motor": {"joint": "pivot", "value": "0.3*sin(2*t)"},
            "tilt": {"joint": "hinge", "value": "t"},
        },
        "outputs": [],
    }
    run = kousoku.load(tree, target="numpy").simulate(1, samples=11, method="dopri5")
    assert run.ledger.drift > 10 * run.ledger.trust.limit
    angle = 0.3 * np.sin(2 * run.time)
    np.testing.assert_allclose(run["blade.x"], np.cos(angle), rtol=0, atol=1e-15)
    np.testing.assert_allclose(run["blade.y"], np.sin(angle), rtol=0, atol=1e-15)
    assert run.ledger.trust.is_trusted


@pytest.mark.compiles
@pytest.mark.parametrize("target", ["numpy", "c"])
def test_rows_that_are_not_finite_are_told_with_their_time(target: str) -> None:
    run = cart("sin(t - 0.5)/(t - 0.5)", target=target).simulate(1, samples=101)
    assert np.isnan(run["cart.ax"]).tolist() == (run.time == 0.5).tolist()
    assert "first at t = 0.5 s" in run.ledger.trust.why
    assert not run.ledger.trust.is_trusted


@pytest.mark.compiles
def test_fixed_steps_go_over_a_quotient_without_a_value() -> None:
    run = cart("sin(t - 0.53)/(t - 0.53)", target="c").simulate(1, samples=3, step=0.1)
    assert run.ledger.steps < 30
    assert run.ledger.trust.is_trusted
    run = cart("((t + 1)^0.3 - 1.53^0.3)/(t - 0.53)", target="c").simulate(1, samples=3, step=0.1)
    assert 1000 < run.ledger.steps < 3000
    assert run.ledger.unresolved == run.ledger.trust.unresolved > 0
    told = f"narrow forces may be passed over in {run.ledger.unresolved} step"
    assert told in run.ledger.trust.why
    assert not run.ledger.trust.is_trusted


def test_rest_is_trusted() -> None:
    tree = {**CART, "bodies": {"cart": {**CART["bodies"]["cart"], "velocity": [0, 0, 0]}}}
    run = kousoku.load(tree, target="numpy").simulate(1, samples=3)
    assert run.ledger.trust.is_trusted


def test_without_checks_energy_is_not_known() -> None:
    trust = cart("-3*x").simulate(1, samples=3, checks=False).ledger.trust
    assert trust.energy_error is None
    assert "rows not checked" in str(trust)


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8, 1e-10])
def test_estimated_error_is_near_the_true_one(tolerance: float) -> None:
    mechanism, times = cart("-3*x"), np.linspace(0.0, 5.0, 51)
    run = mechanism.simulate(times=times, tolerance=tolerance, estimate_error=True)
    error, omega = run.ledger.trust.error, np.sqrt(3.0)
    true = np.abs(run["cart.x"] - 10.0 / omega * np.sin(omega * times)).max()
    assert true / 3 < error.length < 30 * true
    assert f"error {error.length:.0g}"[:7] in str(run.ledger.trust)


@pytest.mark.parametrize("options", [{"step": 0.05}, {"step": 0.05, "method": "dopri5"}])
def test_error_of_fixed_steps_is_near_the_true_one(options: dict[str, Any]) -> None:
    times = np.linspace(0.0, 5.0, 51)
    run = cart("-3*x").simulate(times=times, estimate_error=True, **options)
    omega = np.sqrt(3.0)
    true = np.abs(run["cart.x"] - 10.0 / omega * np.sin(omega * times)).max()
    assert true / 3 < run.ledger.trust.error.length < 30 * true


def test_it_says_from_when_on_nothing_is_known() -> None:
    mechanism = cart("-3*x")
    first = cast(Motion, mechanism.simulate(1, samples=11))
    second = cast(Motion, mechanism.simulate(1, samples=11))
    second.rows = second.rows.copy()
    second.rows[7:, 1:4] += 0.5
    error = error_estimate(first, second, 1.0)
    assert error.unknown_from == pytest.approx(0.6)  # between two rows nothing was compared
    assert error.length == 0.0
    assert "up to t = 0.6 s" in str(error)
    assert "chaotic" in error.unknown
    assert error_estimate(first, first, 1.0).unknown_from is None


def test_it_says_that_the_second_run_stops() -> None:
    first = cast(Motion, cart("-3*x").simulate(1, samples=11))
    second = Motion(first.layout, first.rows[:6], target="", method="dopri5")
    error = error_estimate(first, second, 1.0, "the force has no finite value")
    assert error.unknown_from == pytest.approx(0.5)
    assert error.unknown.endswith("stops: the force has no finite value")
    assert "chaotic" not in error.unknown


def test_driven_motion_is_compared_at_its_rows_by_other_steps() -> None:
    loop = kousoku.load(SCENES / "oldham_coupling.toml", target="numpy")
    error = loop.simulate(1, samples=6, estimate_error=True).ledger.trust.error
    assert error.unknown_from is None
    assert 0.0 <= error.length < 1e-12
    assert error.angle < 1e-12


@pytest.mark.parametrize("method", ["dop853", "dopri5"])
@pytest.mark.parametrize("times", [[0, 0.1, 3], [0, 0.1, np.pi / 2 / np.sqrt(3), 3]])
def test_a_run_that_an_event_ends_is_compared_up_to_there(times: list[float], method: Any) -> None:
    """Where the cart turns; the second run comes there a little before, or behind."""
    forces = {"load": {"type": "along", "coordinate": "x", "force": "-3*x"}}
    events = {"turns": {"when": "x_dot", "action": "stop"}}
    mechanism = kousoku.load({**CART, "forces": forces, "events": events}, target="numpy")
    run = mechanism.simulate(times=times, method=method, tolerance=1e-6, estimate_error=True)
    error, true = run.ledger.trust.error, np.abs(run["cart.x"][-1] - 10 / np.sqrt(3))
    assert run.stopped_by == "turns"
    assert error.unknown_from is None
    assert true / 3 < error.length < 1e-4
    assert run.ledger.trust.is_trusted


def test_a_resumed_run_is_compared_with_one_from_where_it_began() -> None:
    mechanism = cart("-3*x")
    options: dict[str, Any] = {"v0": [-1, 0, 0, 0, 0, 0], "estimate_error": True}
    run = mechanism.begin([0, 0.5, 1], **options)
    run.advance(max_steps=2)
    resumed = mechanism.resume(run.save()).finish().ledger.trust
    assert resumed.error == run.finish().ledger.trust.error
    assert resumed.is_trusted


@pytest.mark.compiles
@pytest.mark.parametrize("target", ["c", "numpy"])
def test_bodies_at_rest_have_no_kinks_in_their_rounding(target: Any) -> None:
    upright = {"type": "revolute", "axis": [0, 0, 1]}
    body = {"mass": 1, "inertia": {"xx": 1, "yy": 1, "zz": 1}}
    turned = {"angles": [-0.375, 0.0, 0.9375], "sequence": "xyz", "about": "fixed"}
    tree = {
        "name": "rest",
        "unit": "m",
        "gravity": [0, 0, -9.81],
        "bodies": {
            "a": {**body, "position": [1, 2, 0], "orientation": {"rotation_vector": [0, 0, 0.1]}},
            "b": {**body, "position": [3, 2.5, 0], "orientation": turned},
        },
        "joints": {
            "h": {**upright, "bodies": ["ground", "a"], "at": [0, 0, 0]},
            "g": {**upright, "bodies": ["a", "b"], "at": [2, 1, 0]},
        },
        "coordinates": {"c": {"joint": "g"}},
        "forces": {"f": {"type": "force", "body": "b", "force": ["abs(c_dot)*cos(t)", 0, 0]}},
    }
    mechanism = kousoku.load(tree, target=target)
    for tolerance in (1e-9, 1e-12, 1e-13):  # the last one took ever shorter steps
        run = mechanism.simulate(0.25, samples=3, tolerance=tolerance, most_steps=100)
        assert run.ledger.steps < 5
        assert run.ledger.trust.is_trusted


@pytest.mark.compiles
def test_no_step_leaves_the_constraints_by_what_estimates_do_not_see() -> None:
    """A nut turns by some radians in a step, along which estimates of its error are zero once."""
    nut = kousoku.load(SCENES / "falling_nut.toml")
    for tolerance in (1e-4, 1e-5, 1e-6, 1e-7):
        trust = nut.simulate(0.5, samples=21, method="dop853", tolerance=tolerance).ledger.trust
        assert trust.is_trusted
        assert trust.drift is not None
        assert trust.drift <= 50 * tolerance
