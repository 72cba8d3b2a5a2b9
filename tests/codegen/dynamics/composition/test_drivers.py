"""Driven and coupled scenes against closed forms, from the scene to the motion."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.model.reading.read import scene_from_dict
from kousoku.runtime.dynamics import load_dynamics

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from kousoku.runtime.dynamics import DynamicsSolver

    Load = Callable[..., DynamicsSolver]

pytestmark = pytest.mark.usefixtures("compiler")

OUTPUTS = ["coordinates", "accelerations", "reactions", "energies"]
INERTIA, MASS, ARM, GRAVITY = 0.4, 2.0, 0.7, 9.81
MOMENT = 0.5
WHEEL = {"mass": 3.0, "inertia": {"xx": 0.3, "yy": 0.3, "zz": MOMENT}}
GOLDEN = (1 + math.sqrt(5)) / 2


@pytest.fixture
def load(bodies_folder: Callable[..., Path]) -> Load:
    """Loader that generates a scene once and loads it for a target."""

    def loaded(scene: dict[str, Any], target: Any = "c") -> DynamicsSolver:
        return load_dynamics(
            bodies_folder(scene_from_dict(scene), tuple(scene["outputs"])), target=target
        )

    return loaded


def pendulum(law: str, **given: Any) -> dict[str, Any]:
    """Pendulum in the xz-plane whose angle is driven, in units of a decimetre."""
    return {
        "name": "driven",
        "unit": "dm",
        "gravity": [0.0, 0.0, -10 * GRAVITY],
        "outputs": OUTPUTS,
        "bodies": {
            "rod": {
                "mass": MASS,
                "inertia": {"xx": 20.0, "yy": 100 * INERTIA, "zz": 30.0},
                "position": [10 * ARM, 0.0, 0.0],
            }
        },
        "joints": {
            "hinge": {
                "type": "revolute",
                "bodies": ["ground", "rod"],
                "at": [0.0, 0.0, 0.0],
                "axis": [0.0, -1.0, 0.0],
            }
        },
        "coordinates": {"theta": {"joint": "hinge"}},
        "drivers": {"motor": {"coordinate": "theta", "value": law}},
    } | given


def test_driven_pendulum_follows_its_formula_with_the_torque_that_it_takes(load: Load) -> None:
    motion = load(pendulum("2*pi*t + sin(t)^2")).simulate(30, samples=61)
    t = motion.time
    theta, rate = 2 * np.pi * t + np.sin(t) ** 2, 2 * np.pi + np.sin(2 * t)
    alpha = 2 * np.cos(2 * t)
    np.testing.assert_allclose(motion.coordinate["theta"], theta, rtol=0, atol=1e-13)
    np.testing.assert_allclose(motion.coordinate_rate["theta"], rate, rtol=0, atol=1e-13)
    np.testing.assert_allclose(motion.coordinate_acceleration["theta"], alpha, rtol=0, atol=1e-11)
    place = 10 * ARM * np.stack([np.cos(theta), 0 * t, np.sin(theta)], axis=1)
    np.testing.assert_allclose(motion.position["rod"], place, rtol=0, atol=1e-12)
    torque = (INERTIA + MASS * ARM**2) * alpha + MASS * GRAVITY * ARM * np.cos(theta)
    np.testing.assert_allclose(motion.torque["motor"][:, 1], -100 * torque, rtol=0, atol=1e-9)
    np.testing.assert_array_equal(motion.force["motor"], 0.0)
    assert motion.columns()["theta_dot"] is motion.coordinate_rate["theta"]


@pytest.mark.parametrize("method", ["dop853", "kinematics"])
def test_work_of_a_driver_is_the_change_of_energy(load: Load, method: str) -> None:
    solver = load(pendulum("2*pi*t + sin(t)^2"))
    errors = []
    for tolerance in (1e-6, 1e-12):
        motion = solver.simulate(3, samples=4, method=method, tolerance=tolerance)
        change = motion.energy["total"] - motion.energy["total"][0]
        assert np.abs(change).max() > 500
        errors.append(np.abs(motion.work["motor"] - change).max())
        assert motion.ledger.energy_error == pytest.approx(errors[-1] / 100, rel=0.01, abs=1e-10)
    assert errors[0] < 0.1
    assert errors[1] < 1e-6


@pytest.mark.usefixtures("numpy_solver", "shipped_flags")
def test_both_targets_drive_with_the_same_bits(load: Load) -> None:
    one, other = (
        load(pendulum("2*pi*t + sin(t)^2"), target).simulate(3, samples=7, method="dop853")
        for target in ("c", "numpy")
    )
    for name, values in one.columns().items():
        np.testing.assert_array_equal(values, other.columns()[name], err_msg=name)


def gears(ratio: float) -> dict[str, Any]:
    """Two wheels whose angles are coupled, the first one turned by a torque."""
    speeds = (20.0, 20.0 * ratio)
    return {
        "name": "gears",
        "unit": "m",
        "gravity": [0.0, 0.0, 0.0],
        "outputs": OUTPUTS,
        "bodies": {
            f"wheel{k}": {
                **WHEEL,
                "position": [2.0 * k, 0.0, 0.0],
                "angular_velocity": [0.0, 0.0, speed],
            }
            for k, speed in enumerate(speeds)
        },
        "joints": {
            **{
                name: {
                    "type": "revolute",
                    "bodies": ["ground", f"wheel{k}"],
                    "at": [2.0 * k, 0.0, 0.0],
                    "axis": [0.0, 0.0, 1.0],
                }
                for k, name in enumerate("ab")
            },
            "mesh": {"type": "gear", "joints": ["a", "b"], "ratio": ratio},
        },
        "coordinates": {"alpha": {"joint": "a"}, "beta": {"joint": "b", "near": 4 * math.pi}},
        "forces": {"push": {"type": "torque", "body": "wheel0", "torque": [0.0, 0.0, 2.0]}},
    }


def test_gears_keep_an_irrational_ratio_over_a_hundred_turns(load: Load) -> None:
    ratio = -1 / GOLDEN
    motion = load(gears(ratio)).simulate(16, samples=9)
    alpha, beta = motion.coordinate["alpha"], motion.coordinate["beta"]
    assert alpha[-1] > 200 * math.pi
    np.testing.assert_allclose(beta - 4 * math.pi, ratio * alpha, rtol=0, atol=1e-12)
    second = 2.0 / (MOMENT * (1 + ratio**2))
    wanted = 20 * motion.time + second * motion.time**2 / 2
    np.testing.assert_allclose(alpha, wanted, rtol=1e-8, atol=0)
    np.testing.assert_allclose(motion.coordinate_acceleration["alpha"], second, rtol=1e-12)
    torques = {"mesh.wheel0": MOMENT * second - 2.0, "mesh.wheel1": MOMENT * ratio * second}
    for name, torque in torques.items():
        np.testing.assert_allclose(motion.torque[name][:, 2], torque, rtol=1e-12)


def test_turns_are_counted_on_when_a_run_is_resumed(load: Load) -> None:
    solver = load(gears(-1 / GOLDEN))
    whole = solver.simulate(16, samples=9)
    run = solver.begin(whole.time)
    run.advance(max_steps=3)
    again = solver.resume(run.save()).finish()
    for name, values in whole.columns().items():
        np.testing.assert_array_equal(values, again.columns()[name], err_msg=name)


def screw(pitch: float) -> dict[str, Any]:
    body = {"mass": MASS, "inertia": {"xx": 3e3, "yy": 3e3, "zz": 4e3}, "position": [0, 0, 0]}
    thread = {"type": "screw", "bodies": ["ground", "nut"], "axis": [0, 0, 1], "pitch": pitch}
    return {
        "name": "screwed",
        "unit": "mm",
        "gravity": [0.0, 0.0, -9810.0],
        "outputs": OUTPUTS,
        "bodies": {"nut": body},
        "joints": {"thread": {**thread, "at": [0, 0, 0]}},
        "coordinates": {
            "theta": {"joint": "thread", "of": "angle"},
            "height": {"joint": "thread", "of": "displacement"},
        },
    }


@pytest.mark.parametrize("pitch", [30.0, -30.0])
def test_a_screw_falls_as_its_pitch_lets_it(load: Load, pitch: float) -> None:
    motion = load(screw(pitch)).simulate(3, samples=4, tolerance=1e-12)
    advance = pitch / (2 * math.pi)
    fall = 9810.0 / (1 + 4e3 / (MASS * advance**2))
    height, theta = motion.coordinate["height"], motion.coordinate["theta"]
    assert height[-1] < -3 * abs(pitch)
    np.testing.assert_allclose(height, -fall * motion.time**2 / 2, rtol=1e-10)
    np.testing.assert_allclose(theta, height / advance, rtol=1e-13, atol=1e-13)
    np.testing.assert_allclose(motion.force["thread"][:, 2], MASS * (9810.0 - fall), rtol=1e-12)
    np.testing.assert_allclose(motion.torque["thread"][:, 2], -4e3 * fall / advance, rtol=1e-12)


def test_a_parameter_in_a_formula_is_an_argument_of_the_run(load: Load) -> None:
    scene = pendulum("speed*t", parameters={"speed": 2.0})
    for speed in (2.0, -0.75):
        given = {"speed": speed} if speed != 2.0 else None
        motion = load(scene).simulate(3, samples=4, parameters=given)
        wanted = speed * motion.time
        np.testing.assert_allclose(motion.coordinate["theta"], wanted, rtol=0, atol=1e-14)


def test_a_driven_point_goes_its_way(load: Load) -> None:
    """A point mass in space is led along a helix; the driver carries its weight."""
    path = {"body": "bead", "path": ["cos(t)", "sin(t)", "0.1*t"]}
    scene = {
        "name": "helix",
        "unit": "m",
        "gravity": [0.0, 0.0, -GRAVITY],
        "outputs": ["reactions"],
        "bodies": {"bead": {"mass": MASS, "point": True, "position": [1.0, 0.0, 0.0]}},
        "joints": {},
        "drivers": {"hand": path},
    }
    motion = load(scene).simulate(10, samples=11)
    t = motion.time
    wanted = np.stack([np.cos(t), np.sin(t), 0.1 * t], axis=1)
    np.testing.assert_allclose(motion.position["bead"], wanted, rtol=0, atol=1e-14)
    force = MASS * np.stack([-np.cos(t), -np.sin(t), GRAVITY + 0 * t], axis=1)
    np.testing.assert_allclose(motion.force["hand"], force, rtol=0, atol=1e-13)
