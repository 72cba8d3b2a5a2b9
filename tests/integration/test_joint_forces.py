"""Forces along coordinates move bodies as closed forms do, and their work balances the energy."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.codegen.dynamics.generate import generate_dynamics
from kousoku.codegen.generate import write_tree
from kousoku.model.reading.read import read_scene, scene_from_dict
from kousoku.runtime.dynamics import load_dynamics

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.runtime.dynamics import DynamicsSolver
    from kousoku.runtime.toolchain import Toolchain

Tree = dict[str, Any]

SCENES = Path(__file__).parents[2] / "scenes"
INERTIA = {"xx": 0.3, "yy": 0.4, "zz": 0.5}
HINGE = {"type": "hinge", "bodies": ["ground", "wheel"], "at": [0, 0, 0], "axis": [0, 0, 1]}
TIMES = np.linspace(0.0, 3.0, 13)


def wheel(joint: Tree, forces: Tree, **other: Any) -> Tree:
    """Wheel of 2 kg on a joint with the ground."""
    body = {"position": [0, 0, 0], "mass": 2, "inertia": INERTIA} | other.pop("body", {})
    tree = {"name": "wheel_on_a_joint", "unit": "m", "bodies": {"wheel": body}}
    return tree | {"joints": {"joint": joint}, "forces": forces} | other


def spring(**keys: Any) -> Tree:
    return {"type": "rotational_spring_damper", **keys}


@pytest.mark.parametrize(
    ("keys", "free"),
    [
        ({"joint": "joint", "stiffness": 8}, 0.0),
        ({"coordinate": "theta", "stiffness": "k/2", "free_angle": "-k"}, -16.0),
        ({"joint": "joint", "moment": "k/2*x", "free_angle": 4}, 4.0),
    ],
)
def test_a_spring_that_is_wound_up_counts_the_turns(
    mover: Callable[..., DynamicsSolver], keys: Tree, free: float
) -> None:
    tree = wheel(HINGE, {"spring": spring(**keys)}, body={"angular_velocity": [0, 0, 60]})
    given: Tree = {"coordinates": {"theta": {"joint": "joint"}}}
    if "k/2" in f"{keys}":
        given["parameters"] = {"k": 16}
    solver = mover(scene_from_dict(tree | given), outputs=("coordinates", "energies"))
    motion = solver.simulate(times=TIMES, tolerance=1e-13)
    rate = math.sqrt(8 / 0.5)
    turned = free - free * np.cos(rate * TIMES) + 60 / rate * np.sin(rate * TIMES)
    assert np.abs(turned).max() > 2 * math.tau
    np.testing.assert_allclose(motion.coordinate["theta"], turned, rtol=0, atol=2e-10)
    assert motion.ledger.energy_error == pytest.approx(0.0, abs=1e-7)
    if "moment" in keys:
        elastic = 4 * ((turned - free) ** 2 - free**2)
        np.testing.assert_allclose(motion.work["spring"], -elastic, rtol=0, atol=1e-7)
    else:
        assert motion.work == {}
        np.testing.assert_allclose(
            motion.energy["potential"], 4 * (turned - free) ** 2, rtol=1e-9, atol=1e-7
        )


def test_friction_takes_what_moves_away_in_every_freedom_of_a_joint(
    mover: Callable[..., DynamicsSolver],
) -> None:
    joint = HINGE | {"type": "cylindrical"}
    forces = {"slow": {"type": "friction", "joint": "joint", "damping": "c"}}
    start = {"velocity": [0, 0, 3], "angular_velocity": [0, 0, 5]}
    tree = wheel(joint, forces, body=start, parameters={"c": 0.8})
    solver = mover(scene_from_dict(tree), outputs=("energies",))
    motion = solver.simulate(times=TIMES, tolerance=1e-13)
    slower, turning = (np.exp(-0.8 * TIMES / x) for x in (2.0, 0.5))
    np.testing.assert_allclose(motion.velocity["wheel"][:, 2], 3 * slower, rtol=0, atol=1e-11)
    found = motion.angular_velocity["wheel"][:, 2]
    np.testing.assert_allclose(found, 5 * turning, rtol=0, atol=1e-11)
    lost = 9.0 * (1 - slower**2) + 6.25 * (1 - turning**2)
    np.testing.assert_allclose(motion.work["slow"], -lost, rtol=0, atol=1e-9)


def test_friction_may_be_in_one_freedom_only(mover: Callable[..., DynamicsSolver]) -> None:
    joint = HINGE | {"type": "cylindrical"}
    slow = {"type": "friction", "joint": "joint", "damping": 0.8, "of": "displacement"}
    start = {"velocity": [0, 0, 3], "angular_velocity": [0, 0, 5]}
    solver = mover(scene_from_dict(wheel(joint, {"slow": slow}, body=start)))
    motion = solver.simulate(times=[0.0, 1.0], tolerance=1e-12)
    assert motion.angular_velocity["wheel"][1, 2] == pytest.approx(5.0, abs=1e-13)
    assert motion.velocity["wheel"][1, 2] == pytest.approx(3 * math.exp(-0.4), abs=1e-11)


def test_a_force_along_a_displacement_is_in_the_unit_of_the_scene(
    mover: Callable[..., DynamicsSolver],
) -> None:
    """2 kg on a slider: 500 N/m against it in newtons is 500 kg/s² in any unit of length."""
    tree: Tree = {
        "name": "pushed",
        "unit": "mm",
        "bodies": {"wheel": {"position": [0, 0, 0], "mass": 2, "velocity": [0, 100, 0]}},
        "joints": {"joint": HINGE | {"type": "slider", "axis": [0, 1, 0]}},
        "coordinates": {"h": {"joint": "joint"}},
        "forces": {"push": {"type": "along", "coordinate": "h", "force": "-500*h + 0*h_dot*t"}},
    }
    tree["bodies"]["wheel"]["inertia"] = {"xx": 1e5, "yy": 1e5, "zz": 1e5}
    motion = mover(scene_from_dict(tree), outputs=("energies",)).simulate(
        times=TIMES, tolerance=1e-13
    )
    rate = math.sqrt(250.0)
    height = 100 / rate * np.sin(rate * TIMES)
    np.testing.assert_allclose(motion.position["wheel"][:, 1], height, rtol=0, atol=1e-8)
    np.testing.assert_allclose(motion.work["push"], -250 * height**2, rtol=0, atol=1e-5)


def bushing(**keys: Any) -> Tree:
    body = {"mass": 2, "inertia": INERTIA} | keys.pop("body")
    mount = {"type": "bushing", "bodies": ["ground", "block"], **keys}
    return {"name": "mounted", "unit": "m", "bodies": {"block": body}, "forces": {"mount": mount}}


def test_a_bushing_is_a_spring_and_damper_along_each_of_its_directions(
    mover: Callable[..., DynamicsSolver],
) -> None:
    """Directions y, −x, z: what is given first acts along y."""
    given = {
        "points": [[0, 0, 0], [0, 0, 0]],
        "axes": [[0, 2, 0], [-1, 0.5, 0]],
        "stiffness": [200, 300, "k", 9, 9, 9],
        "damping": [0, 0, 4, 0, 0, 0],
    }
    tree = bushing(body={"position": [0.3, 0.2, 0.1]}, **given) | {"parameters": {"k": 400}}
    motion = mover(scene_from_dict(tree), outputs=("energies",)).simulate(
        times=TIMES, tolerance=1e-13
    )
    x, y, z = motion.position["block"].T
    np.testing.assert_allclose(x, 0.3 * np.cos(math.sqrt(150) * TIMES), rtol=0, atol=1e-11)
    np.testing.assert_allclose(y, 0.2 * np.cos(math.sqrt(100) * TIMES), rtol=0, atol=1e-11)
    rate = math.sqrt(200 - 1)
    wave = np.cos(rate * TIMES) + np.sin(rate * TIMES) / rate
    np.testing.assert_allclose(z, 0.1 * np.exp(-TIMES) * wave, rtol=0, atol=1e-11)
    assert motion.ledger.energy_error == pytest.approx(0.0, abs=1e-10)
    assert list(motion.work) == ["mount"]
    assert motion.work["mount"][-1] == pytest.approx(-0.5 * 400 * 0.01, rel=1e-2)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_bushing_holds_small_turns_about_each_of_its_directions(
    mover: Callable[..., DynamicsSolver], axis: int
) -> None:
    stiffness = (4.0, 5.0, 6.0)
    spin = [1e-4 * (k == axis) for k in range(3)]
    body = {"position": [1, 2, 3], "angular_velocity": spin}
    tree = bushing(body=body, at=[1, 2, 3], stiffness=[50, 50, 50, *stiffness])
    motion = mover(scene_from_dict(tree)).simulate(times=TIMES, tolerance=1e-13)
    rate = math.sqrt(stiffness[axis] / list(INERTIA.values())[axis])
    found = 2 * motion.orientation["block"][:, 1 + axis]
    np.testing.assert_allclose(found, 1e-4 / rate * np.sin(rate * TIMES), rtol=0, atol=1e-12)


def test_parameters_of_a_run_are_those_of_its_forces_and_of_gravity(
    mover: Callable[..., DynamicsSolver],
) -> None:
    tree: Tree = {
        "name": "dropped",
        "unit": "dm",
        "gravity": [0, "-10*g", 0],
        "parameters": {"g": 9.81, "f": 0.0},
        "bodies": {"ball": {"position": [0, 0, 0], "point": True, "mass": 2}},
        "forces": {"push": {"type": "force", "body": "ball", "force": ["20*f", 0, "f*t"]}},
    }
    solver = mover(scene_from_dict(tree), outputs=("energies",))
    for g, f in ((9.81, 0.0), (1.62, 3.0)):
        motion = solver.simulate(times=[0.0, 2.0], tolerance=1e-12, parameters={"g": g, "f": f})
        wanted = [20 * f, -20 * g, f * 8 / 12]
        np.testing.assert_allclose(motion.position["ball"][1], wanted, rtol=0, atol=1e-10)
        assert motion.ledger.energy_error == pytest.approx(0.0, abs=1e-10)


def test_a_torque_may_follow_the_rate_of_a_coordinate(
    mover: Callable[..., DynamicsSolver],
) -> None:
    """A regulator: a torque against the excess of the rate."""
    torque = ["0*theta", 0, "-2*(theta_dot - 7)"]
    forces = {"motor": {"type": "torque", "body": "wheel", "torque": torque}}
    tree = wheel(HINGE, forces, coordinates={"theta": {"joint": "joint"}})
    motion = mover(scene_from_dict(tree)).simulate(times=TIMES, tolerance=1e-13)
    found = motion.angular_velocity["wheel"][:, 2]
    np.testing.assert_allclose(found, 7 * (1 - np.exp(-4 * TIMES)), rtol=0, atol=1e-11)


def test_a_motor_on_rubber_mounts_keeps_its_energy_balance(
    mover: Callable[..., DynamicsSolver],
) -> None:
    solver = mover("mounted_motor", outputs=("coordinates", "energies"))
    motion = solver.simulate(0.5, samples=51, tolerance=1e-10)
    assert list(motion.work) == ["motor", "rubber", "losses", "air", "mounts"]
    change = motion.energy["total"] - motion.energy["total"][0]
    np.testing.assert_allclose(sum(motion.work.values()), change, rtol=0, atol=1e-8)
    assert motion.work["motor"][-1] > 100.0
    assert motion.coordinate["turn"][-1] > 4 * math.tau
    slow = solver.simulate(0.5, samples=51, tolerance=1e-10, parameters={"friction": 0.02})
    assert slow.work["losses"][-1] < 5 * motion.work["losses"][-1]


@pytest.mark.usefixtures("numpy_solver", "shipped_flags")
def test_both_targets_take_the_same_bits_for_formulas_and_turns(
    tmp_path: Path, compiler: Toolchain
) -> None:
    scene = read_scene(SCENES / "mounted_motor.toml")
    write_tree(tmp_path, generate_dynamics(scene, ("coordinates", "energies")))
    solvers = (load_dynamics(tmp_path, target="c"), load_dynamics(tmp_path, target="numpy"))
    found = [one.simulate(0.1, samples=5, tolerance=1e-8) for one in solvers]
    first, second = (motion.columns() for motion in found)
    for name, values in first.items():
        np.testing.assert_array_equal(values, second[name], err_msg=name)
    assert dict(found[0].ledger.works) == dict(found[1].ledger.works)
