"""One motion in other units of time, length and mass: the same steps, and the same digits."""

from __future__ import annotations

import random
import tomllib
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np
import pytest

import kousoku
from tests.random_scenes import random_scene
from tests.stress.changes import Scaled
from tests.stress.scenes import quick_to_compile

if TYPE_CHECKING:
    from kousoku.runtime.integrate.motion import Motion

#: Times, lengths and masses are multiplied by these.
UNITS = [(3600.0, 1.0, 1.0), (1e-3, 1.0, 1e-6), (1.0, 1e-3, 1.0), (1000.0, 60.0, 1e3)]
COUNTS = ("steps", "rejected", "derivatives")
ALL_COUNTS = (*COUNTS, "factorisations", "corrections")
#: Lengths, masses and times are multiplied by these: powers of two, which round nothing.
EXACT_UNITS = [(2.0**-30, 1.0, 1.0), (1.0, 2.0**-20, 1.0), (2.0**10, 2.0**7, 2.0**9)]
SCENES = {
    path.stem: tree
    for path in sorted((Path(kousoku.__file__).parents[1] / "scenes").glob("*.toml"))
    if "bodies" in (tree := tomllib.loads(path.read_text(encoding="utf-8")))
}

pytestmark = pytest.mark.usefixtures("numpy_solver")


def bar(mass: float, length: float, x: float) -> dict[str, Any]:
    return {
        "position": [x, 0, 0],
        "mass": mass,
        "center": [length / 2, 0, 0],
        "inertia": dict.fromkeys(("xx", "yy", "zz"), mass * length**2 / 12),
    }


def hinge(*bodies: str, x: float = 0.0) -> dict[str, Any]:
    return {"type": "revolute", "bodies": list(bodies), "at": [x, 0, 0], "axis": [0, 0, 1]}


def double_pendulum(t: float, s: float, m: float) -> dict[str, Any]:
    """Double pendulum that falls from rest, with a damper at its second hinge."""
    return {
        "name": "double_pendulum",
        "unit": "m",
        "gravity": [0, -9.81 * s / t**2, 0],
        "outputs": ["energies"],
        "bodies": {"one": bar(m, s, 0), "two": bar(0.5 * m, s, s)},
        "joints": {"a": hinge("ground", "one"), "b": hinge("one", "two", x=s)},
        "forces": {
            "damper": {
                "type": "rotational_spring_damper",
                "joint": "b",
                "damping": 0.01 * m * s**2 / t,
            }
        },
    }


def led(t: float, s: float, m: float) -> dict[str, Any]:
    """Crank led by a driver against a load, and a bar that hangs from it."""
    scene = double_pendulum(t, s, m)
    turn = f"0.5*sin(3*t/{t!r})"
    return {
        **scene,
        "name": "led",
        "coordinates": {"turn": {"joint": "a"}},
        "drivers": {"motor": {"coordinate": "turn", "value": turn}},
    }


def oscillator(t: float, s: float, m: float) -> dict[str, Any]:
    """Body on a spring that a force shakes from rest, weakly."""
    return {
        "name": "oscillator",
        "unit": "m",
        "outputs": ["energies"],
        "bodies": {"cart": bar(m, s, 0)},
        "joints": {
            "rail": {
                "type": "prismatic",
                "bodies": ["ground", "cart"],
                "at": [0, 0, 0],
                "axis": [1, 0, 0],
            }
        },
        "coordinates": {"x": {"joint": "rail"}},
        "forces": {
            "spring": {
                "type": "along",
                "coordinate": "x",
                "force": f"{-4 * m / t**2!r}*x + {0.01 * m * s / t**2!r}*sin(3*t/{t!r})",
            }
        },
    }


def weight(t: float, s: float, m: float) -> dict[str, Any]:
    """Weight on a spring that hardens, whose joint has no length."""
    scene = oscillator(t, s, m)
    middle = [0, 0, 0]
    scene["bodies"] = {"cart": {**bar(m, s, s), "center": middle}}
    scene["joints"]["rail"] = {**scene["joints"]["rail"], "points": [middle, middle]}
    del scene["joints"]["rail"]["at"]
    scene["forces"]["spring"]["force"] = f"{-m / t**2!r}*(x + 3*x^3/{s!r}^2)"
    return {**scene, "name": "weight"}


def moved(scene: dict[str, Any], end: float, **options: Any) -> Motion:
    """Motion of a scene to an end."""
    return cast("Motion", kousoku.load(scene, target="numpy").simulate(end, samples=11, **options))


@pytest.mark.parametrize("units", UNITS, ids=lambda units: "-".join(f"{x:g}" for x in units))
@pytest.mark.parametrize("method", ["dopri5", "dop853"])
@pytest.mark.parametrize("scene", [double_pendulum, oscillator, led, weight])
def test_steps_are_those_of_the_same_motion_in_other_units(
    scene: Any, method: str, units: tuple[float, float, float]
) -> None:
    t, s, m = units
    options = {"method": method, "tolerance": 1e-6}
    usual, other = moved(scene(1, 1, 1), 2.0, **options), moved(scene(*units), 2.0 * t, **options)
    for name in COUNTS:
        assert getattr(other.ledger, name) == getattr(usual.ledger, name)
    for body, position in usual.position.items():
        np.testing.assert_allclose(other.position[body], s * position, rtol=0, atol=1e-8 * s)
        velocity, wanted = other.velocity[body] * t / s, usual.velocity[body]
        np.testing.assert_allclose(velocity, wanted, rtol=0, atol=1e-7)
    energy = m * (s / t) ** 2
    for name, work in usual.ledger.works.items():
        assert other.ledger.works[name] / energy == pytest.approx(work, rel=1e-6)


@pytest.mark.parametrize("units", UNITS, ids=lambda units: "-".join(f"{x:g}" for x in units))
def test_works_under_kinematics_are_summed_in_the_same_steps(
    units: tuple[float, float, float],
) -> None:
    t, s, m = units

    def crank(t: float, s: float, m: float) -> dict[str, Any]:
        scene = led(t, s, m)
        del scene["bodies"]["two"], scene["joints"]["b"], scene["forces"]
        return scene

    usual, other = moved(crank(1, 1, 1), 2.0), moved(crank(*units), 2.0 * t)
    for name in COUNTS:
        assert getattr(other.ledger, name) == getattr(usual.ledger, name)
    energy = m * (s / t) ** 2
    assert other.ledger.works["motor"] / energy == pytest.approx(usual.ledger.works["motor"])


def test_a_body_that_nothing_moves_needs_few_steps() -> None:
    scene = double_pendulum(1, 1, 1)
    scene["gravity"] = [9.81, 0, 0]  # it hangs
    ledger = moved(scene, 1000.0).ledger
    assert ledger.steps < 200
    assert ledger.trust.is_trusted


def test_a_point_alone_may_have_a_parameter_for_its_mass() -> None:
    point = {"point": True, "position": [1, 2, 3], "mass": "k"}
    scene = {"name": "alone", "unit": "m", "bodies": {"b": point}, "parameters": {"k": 2.0}}
    run = moved({**scene, "gravity": [0, 0, -2]}, 3.0, parameters={"k": 5.0})
    np.testing.assert_allclose(run.position["b"][-1], [1, 2, 3 - 9], rtol=0, atol=1e-14)


def in_units(tree: dict[str, Any], length: float, mass: float, time: float, target: Any) -> Motion:
    """Motion of a scene whose lengths, masses and times are multiplied by numbers."""
    other = kousoku.load(Scaled(tree, length, mass, time).tree, target=target)
    return cast("Motion", other.simulate(0.25 * time, samples=3))


def assert_same_steps(usual: Motion, other: Motion, counts: tuple[str, ...] = COUNTS) -> None:
    for name in counts:
        assert getattr(other.ledger, name) == getattr(usual.ledger, name), name


def assert_same_bits(tree: dict[str, Any], target: str) -> None:
    """No number of a motion knows in which units its scene is written."""
    usual = in_units(tree, 1.0, 1.0, 1.0, target)
    for length, mass, time in EXACT_UNITS:
        other = in_units(tree, length, mass, time, target)
        assert_same_steps(usual, other, ALL_COUNTS)
        for body, position in usual.position.items():
            np.testing.assert_array_equal(other.position[body], length * position)
            velocity = length / time * usual.velocity[body]
            np.testing.assert_array_equal(other.velocity[body], velocity)
        for body, orientation in usual.orientation.items():
            np.testing.assert_array_equal(other.orientation[body], orientation)


@pytest.mark.parametrize("name", ["bricard", "constant_velocity", "spatial_four_bar"])
def test_bits_are_those_of_the_same_motion_in_units_of_powers_of_two(name: str) -> None:
    """Rows in metres and in radians: pivots of both are compared, of bodies without masses, too."""
    assert_same_bits(SCENES[name], "numpy")


@pytest.mark.release
@pytest.mark.parametrize("name", SCENES)
def test_bits_of_committed_scenes_are_the_same_in_units_of_powers_of_two(name: str) -> None:
    with quick_to_compile():
        assert_same_bits(SCENES[name], "c")


@pytest.mark.release
@pytest.mark.parametrize("number", range(6))
def test_steps_of_random_scenes_are_the_same_in_other_units(number: int) -> None:
    tree = random_scene(random.Random(f"units {number}"))
    with quick_to_compile():
        usual = in_units(tree, 1.0, 1.0, 1.0, "c")
        for units in EXACT_UNITS:
            assert_same_steps(usual, in_units(tree, *units, "c"))


@pytest.mark.parametrize("power", [7, 31, 50])
def test_a_force_that_grows_from_nothing_has_the_same_steps_in_other_times(power: int) -> None:
    """At rest there is no rate yet, whose unit the first step could take."""

    def pushed(time: float) -> Motion:
        scene = oscillator(time, 1.0, 1.0)
        scene["forces"]["spring"]["force"] = f"{1e5 / time**3!r}*t"
        return moved(scene, 2.0 * time, tolerance=1e-9)

    usual, other = pushed(1.0), pushed(2.0**power)
    assert_same_steps(usual, other)
    np.testing.assert_array_equal(other.position["cart"], usual.position["cart"])
