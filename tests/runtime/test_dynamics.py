"""What a run gives: outputs that are wanted, at the times that are asked for, and its ledger."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.codegen.dynamics.generate import generate_dynamics
from kousoku.model.errors import SolveError
from kousoku.model.reading.builder import SceneBuilder
from kousoku.model.reading.families import chain, n_four_bar
from kousoku.model.reading.read import read_scene
from kousoku.runtime.run_ledger import CONSTRAINT_LEVELS

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.model.records.scene import Scene
    from kousoku.model.records.units import Unit
    from kousoku.runtime.dynamics import DynamicsSolver

    Load = Callable[..., DynamicsSolver]

SCENES = Path(__file__).parents[2] / "scenes"
ALL = ("accelerations", "reactions", "energies")


def tilted_pendulum(unit: Unit = "m") -> Scene:
    """Rod of 2 kg and 1 m on a hinge at one end, in no coordinate plane, swinging."""
    size = {"m": 1, "mm": 1000}[unit]
    builder = SceneBuilder("tilted", unit=unit).gravity(0, 0, -9.81 * size)
    builder.body(
        "rod",
        position=(0, 0, 0),
        orientation={"axis": (0, 1, 0), "angle": 0.4},
        angular_velocity=(0, 1.5, 0),
        boxes=[
            {"mass": 2, "size": (size, 0.1 * size, 0.2 * size), "at": (0.5 * size, 0.3 * size, 0)}
        ],
    )
    builder.joint("hinge", type="revolute", bodies=("ground", "rod"), at=(0, 0, 0), axis=(0, 1, 0))
    return builder.build()


def differences(values: Any, time: Any) -> Any:
    """Derivatives of columns by central differences of fourth order, at inner rows."""
    h = time[1] - time[0]
    return (values[:-4] - 8 * values[1:-3] + 8 * values[3:-1] - values[4:]) / (12 * h)


@pytest.mark.parametrize("scene", [tilted_pendulum(), chain(3)], ids=["pendulum", "chain"])
def test_accelerations_are_the_derivatives_of_velocities(load: Load, scene: Scene) -> None:
    motion = load(scene, *ALL).simulate(0.5, samples=501, tolerance=1e-12)
    for body in motion.position:
        for rate, value in (("acceleration", "velocity"), ("angular_acceleration",) * 2):
            name = value if rate == "acceleration" else "angular_velocity"
            got = getattr(motion, rate)[body][2:-2]
            wanted = differences(getattr(motion, name)[body], motion.time)
            np.testing.assert_allclose(got, wanted, atol=2e-8 * max(1.0, np.abs(wanted).max()))


def test_force_at_a_hinge_is_what_the_motion_of_the_centre_of_mass_asks_for(load: Load) -> None:
    motion = load(tilted_pendulum(), *ALL).simulate(1.0, tolerance=1e-12)
    p = motion.orientation["rod"]
    center = np.array([0.5, 0.3, 0.0])
    omega, alpha = motion.angular_velocity["rod"], motion.angular_acceleration["rod"]
    a_b = np.cross(alpha, center) + np.cross(omega, np.cross(omega, center))
    force = 2 * (turned(p, a_b) + np.array([0, 0, 9.81]))
    np.testing.assert_allclose(motion.force["hinge"], force, atol=1e-10)
    inertia = 2 / 12 * np.diag([0.1**2 + 0.2**2, 1 + 0.2**2, 1 + 0.1**2])
    spin = alpha @ inertia + np.cross(omega, omega @ inertia)
    arm = turned(p, np.broadcast_to(center, omega.shape))
    torque = turned(p, spin) + np.cross(arm, force)
    np.testing.assert_allclose(motion.torque["hinge"], torque, atol=1e-10)
    assert np.abs(torque).max() > 1.0
    assert np.abs(motion.torque["hinge"][:, 1]).max() < 1e-12


def turned(p: Any, vectors: Any) -> Any:
    """Vectors A(p) v, row by row."""
    e0, e = p[:, :1], p[:, 1:]
    t = 2 * np.cross(e, vectors)
    return vectors + e0 * t + np.cross(e, t)


def test_force_on_a_body_that_hangs_at_rest_is_against_gravity(load: Load) -> None:
    builder = SceneBuilder("hanging", unit="m").gravity(0, 0, -10)
    builder.body("bob", position=(0, 0, -1), mass=3, point=True)
    builder.joint("rod", type="rod", bodies=("ground", "bob"), points=((0, 0, 0), (0, 0, 0)))
    motion = load(builder.build(), *ALL).simulate(0.1, samples=3)
    np.testing.assert_allclose(motion.force["rod"], [[0, 0, 30]] * 3, atol=1e-12)
    np.testing.assert_allclose(motion.torque["rod"], 0, atol=1e-12)


def test_force_on_the_ground_side_changes_sign_when_the_bodies_change_places(load: Load) -> None:
    def scene(bodies: tuple[str, str]) -> Scene:
        builder = SceneBuilder("ball", unit="m").gravity(0, 0, -9.81)
        builder.body(
            "rod", position=(0, 0, 0), boxes=[{"mass": 1, "size": (1, 0.1, 0.1), "at": (0.5, 0, 0)}]
        )
        builder.joint("ball", type="spherical", bodies=bodies, at=(0, 0, 0))
        return builder.build()

    one, other = (
        load(scene(bodies), *ALL).simulate(0.5, samples=11)
        for bodies in (("ground", "rod"), ("rod", "ground"))
    )
    np.testing.assert_allclose(one.force["ball"], -other.force["ball"], atol=1e-9)
    assert one.force["ball"][0, 2] == pytest.approx(9.81 / 4, rel=0.02)


def test_energies_are_those_of_the_bodies(load: Load) -> None:
    motion = load(tilted_pendulum(), *ALL).simulate(1.0, samples=11, tolerance=1e-12)
    omega = motion.angular_velocity["rod"]
    inertia = 2 / 12 * np.diag([0.05, 1.04, 1.01])
    arm = np.broadcast_to([0.5, 0.3, 0.0], omega.shape)
    speed = np.cross(omega, arm)
    kinetic = 0.5 * np.sum(omega @ inertia * omega, axis=1) + np.sum(speed * speed, axis=1)
    potential = 2 * 9.81 * turned(motion.orientation["rod"], arm)[:, 2]
    np.testing.assert_allclose(motion.energy["kinetic"], kinetic, rtol=1e-12)
    np.testing.assert_allclose(motion.energy["potential"], potential, atol=1e-12)
    np.testing.assert_allclose(motion.energy["total"], kinetic + potential, rtol=1e-12)


def test_results_are_in_the_unit_of_the_scene(load: Load) -> None:
    metres, millimetres = (
        load(tilted_pendulum(unit), *ALL).simulate(0.5, samples=5) for unit in ("m", "mm")
    )
    for name, power in (("position", 1), ("acceleration", 1), ("force", 1), ("torque", 2)):
        for key, values in getattr(metres, name).items():
            got = getattr(millimetres, name)[key]
            np.testing.assert_allclose(got, values * 1000.0**power, atol=1e-6 * 1000.0**power)
    total = millimetres.energy["total"]
    np.testing.assert_allclose(total, metres.energy["total"] * 1e6, rtol=1e-6)
    assert millimetres.ledger.energy == pytest.approx(metres.ledger.energy)


def test_only_what_is_wanted_is_computed_and_the_rest_keeps_its_bits(load: Load) -> None:
    scene = chain(3)
    full, bare = (load(scene, *outputs).simulate(0.5, samples=7) for outputs in (ALL, ()))
    assert not bare.acceleration
    assert not bare.force
    assert not bare.energy
    for name, values in bare.columns().items():
        np.testing.assert_array_equal(values, full.columns()[name])
    assert {"bar_0.ax", "bar_0.alpha_z", "joint_0.fx", "joint_2.mz", "energy.total"} <= set(
        full.columns()
    )
    text = generate_dynamics(scene, ())["solver.c"]
    assert "HAS_REACTIONS" not in text
    assert "static void reaction(" not in text


def test_forces_out_of_the_plane_are_zero_in_a_flat_scene(load: Load) -> None:
    flat = load(n_four_bar(1), *ALL).simulate(0.2, samples=3)
    np.testing.assert_array_equal(flat.force["ground_0"][:, 2], 0.0)
    hinged = load(read_scene(SCENES / "pendulum.toml"), *ALL).simulate(1, samples=3)
    np.testing.assert_array_equal(hinged.torque["hinge"][:, :2], 0.0)


def test_forces_out_of_the_plane_are_found_in_space_for_a_thin_body_too(load: Load) -> None:
    def pendulum(**made_of: Any) -> Any:
        builder = SceneBuilder("beside", unit="m").gravity(0, -9.81, 0)
        builder.body("rod", position=(0, 0, 0.5), **made_of)
        builder.joint(
            "hinge", type="revolute", bodies=("ground", "rod"), at=(0, 0, 0), axis=(0, 0, 1)
        )
        return load(builder.build(), *ALL).simulate(0.2, samples=3)

    box = pendulum(boxes=[{"mass": 1, "size": (1, 0.1, 0.1), "at": (0.5, 0, 0)}])
    assert box.torque["hinge"][0, 0] == pytest.approx(-0.5 * box.force["hinge"][0, 1])
    thin = pendulum(rods=[{"mass": 1, "ends": ((0, 0, 0), (1, 0, 0))}])
    assert thin.torque["hinge"][0, 0] == pytest.approx(-0.5 * thin.force["hinge"][0, 1])
    assert thin.not_unique == ()


def test_ledger_says_what_is_left_of_the_constraints_and_of_the_energy(load: Load) -> None:
    motion = load(chain(5)).simulate(2.0, tolerance=1e-10)
    ledger = motion.ledger
    assert list(ledger.violations) == [f"joint_{k}" for k in range(5)]
    assert 0.0 < ledger.worst("position")[0] < 1e-14
    assert 0.0 < ledger.worst("velocity")[0] < 1e-12
    assert 0.0 < ledger.worst("acceleration")[0] < 1e-9
    assert len({ledger.worst(level)[0] for level in CONSTRAINT_LEVELS}) == 3
    assert ledger.energy_error is not None
    assert 0.0 < ledger.energy_error < 1e-6
    loose = load(chain(5)).simulate(2.0, tolerance=1e-5).ledger
    assert loose.energy_error is not None
    assert loose.energy_error > 10 * ledger.energy_error
    assert json.loads(json.dumps(motion.summary()))["ledger"]["steps"] == ledger.steps
    assert "left of the constraints, velocity" in str(ledger)
    assert f"most at joints.{ledger.worst_joint('velocity')}" in str(ledger).splitlines()[4]


def test_energy_error_of_the_ledger_is_that_of_the_rows(load: Load) -> None:
    motion = load(chain(3), *ALL).simulate(2.0, tolerance=1e-6)
    total = motion.energy["total"]
    assert motion.ledger.energy_error == pytest.approx(np.abs(total - total[0]).max(), rel=1e-9)


def test_checks_can_be_left_out_and_change_no_bit(load: Load) -> None:
    solver = load(chain(3), *ALL)
    with_checks, without = (solver.simulate(1.0, samples=9, checks=x) for x in (True, False))
    assert without.ledger.energy_error is None
    assert not without.ledger.violations
    for name, values in without.columns().items():
        np.testing.assert_array_equal(values, with_checks.columns()[name])


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_start_that_is_no_number_is_refused(load: Load, bad: float) -> None:
    solver = load(chain(2))
    kept = solver.v[0]
    solver.v[0] = bad
    try:
        with pytest.raises(SolveError, match="not finite"):
            solver.simulate(1.0)
    finally:
        solver.v[0] = kept
