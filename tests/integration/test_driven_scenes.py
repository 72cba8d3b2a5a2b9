"""Screws, gears, racks, shafts and drivers move as their closed forms do, and carry what they say.

The closed forms are written out in each test; lengths are in the unit of the scene.
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

import msgspec
import numpy as np
import pytest

from kousoku.model.linkage.input_drivers import times_of
from kousoku.model.reading.read import read_scene, scene_from_dict
from kousoku.model.records.spatial import Coordinate, Driver
from tests.integration.conftest import SCENES

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.runtime.dynamics import DynamicsSolver
    from kousoku.runtime.integrate.motion import Motion

Tree = dict[str, Any]
G = 9.80665
ZERO, X, Z = [0, 0, 0], [1, 0, 0], [0, 0, 1]

near = partial(np.testing.assert_allclose, rtol=0)


@pytest.fixture
def moved(mover: Callable[..., DynamicsSolver]) -> Callable[..., Motion]:
    """Motion of a scene over some seconds."""

    def move(scene: Any, outputs: tuple[str, ...], end: float, **options: Any) -> Motion:
        return mover(scene, outputs).simulate(end, **{"samples": 41, **options})

    return move


def test_wheels_turn_in_their_ratio_and_count_their_turns(moved: Callable[..., Motion]) -> None:
    motion = moved("gear_train", ("coordinates", "reactions", "accelerations"), 5.0)
    turned = 2 * np.pi * motion.time
    assert motion.ledger.method == "kinematics"
    near(motion.coordinate["pinion_angle"], turned, atol=1e-13)
    near(motion.coordinate["wheel_angle"], -turned / 3, atol=1e-13)
    near(motion.coordinate["rack_place"], -20 * turned, atol=1e-12)
    near(motion.position["rack"][:, 0], 80 - 20 * turned, atol=1e-12)
    near(motion.coordinate_rate["wheel_angle"], -2 * np.pi / 3, atol=1e-13)


def test_the_motor_of_a_gear_train_turns_all_inertias_by_the_square_of_their_ratios(
    moved: Callable[..., Motion],
) -> None:
    """T = (I₁ + I₂ / 9 + m (60 / 3)²) α, with I = ½ m r² of each wheel; no work of gravity."""
    train = read_scene(SCENES / "gear_train.toml")
    motor = Driver(coordinate="pinion_angle", value="2*sin(3*t)")
    scene = msgspec.structs.replace(train, drivers={"motor": motor})
    motion = moved(scene, ("accelerations", "reactions", "coordinates"), 2.0)
    inertia = 0.5 * 0.1 * 20**2 + 0.5 * 0.9 * 60**2 / 9 + 0.5 * 20**2
    angular = -18 * np.sin(3 * motion.time)
    near(motion.coordinate_acceleration["pinion_angle"], angular, atol=1e-12)
    near(motion.torque["motor"][:, 2], inertia * angular, atol=1e-9)
    # The rack is pushed by the teeth alone, with m a; they press at 60 mm from the wheel's axle.
    push = motion.force["teeth.rack"][:, 0]
    near(push, -0.5 * 20 * angular, atol=1e-9)
    near(motion.torque["teeth.wheel"][:, 2], -60 * push, atol=1e-9)


def test_a_nut_falls_on_its_screw_with_a_part_of_the_acceleration_of_free_fall(
    moved: Callable[..., Motion],
) -> None:
    """With m d̈ + I (2π / p)² d̈ = −m g the thread lifts with m (g − a), turns with −I (2π / p) a."""
    motion = moved("falling_nut", ("coordinates", "reactions"), 2.0, tolerance=1e-12)
    lead = 2 * np.pi / 0.1
    a = 2 * G / (2 + 0.001 * lead**2)
    fallen = a * motion.time**2 / 2
    near(motion.coordinate["height"], -fallen, atol=2e-11)
    near(motion.coordinate["turned"], -lead * fallen, atol=1e-9)
    near(motion.force["thread"], [[0, 0, 2 * (G - a)]] * 41, atol=1e-11)
    near(motion.torque["thread"], [[0, 0, -0.001 * lead * a]] * 41, atol=1e-12)


def test_a_constant_velocity_joint_turns_evenly_and_a_universal_joint_does_not(
    moved: Callable[..., Motion],
) -> None:
    motion = moved("constant_velocity", ("coordinates",), 3.0)
    turned = 2 * np.pi * motion.time
    lagged = np.unwrap(np.arctan2(np.cos(np.pi / 6) * np.sin(turned), np.cos(turned)))
    near(motion.coordinate["turned"], turned, atol=1e-13)
    near(motion.coordinate["followed"], turned, atol=1e-13)
    near(motion.coordinate_rate["followed"], 2 * np.pi, atol=1e-12)
    near(motion.coordinate["lagged"], lagged, atol=1e-13)
    assert np.abs(lagged - turned).max() > 0.07


def test_the_disc_of_an_oldham_coupling_runs_twice_through_a_circle_in_a_turn(
    moved: Callable[..., Motion],
) -> None:
    """Its middle is where the two grooves cross: e (sin² α, −sin α cos α), e = 20 mm."""
    motion = moved("oldham_coupling", ("coordinates",), 2.0)
    alpha = 2 * np.pi * motion.time
    sine, cosine = np.sin(alpha), np.cos(alpha)
    place = np.stack([20 * sine**2, -20 * sine * cosine, 0 * alpha], axis=1)
    near(motion.coordinate["followed"], alpha, atol=1e-13)
    near(motion.position["disc"], place, atol=1e-12)


def test_the_rocker_of_the_spatial_four_bar_is_where_the_coupler_reaches_it(
    moved: Callable[..., Motion],
) -> None:
    """|C − B|² = 10, C = (3 + 2 cos φ, 2 sin φ, 0), B = (0, cos α, sin α).

    So 12 cos φ − 4 cos α sin φ = −4, which begins with φ = π / 2.
    """
    linkage = read_scene(SCENES / "spatial_four_bar.toml")
    rocker = Coordinate(joint="d")
    scene = msgspec.structs.replace(linkage, coordinates={"rocker_angle": rocker})
    times = times_of(scene)
    assert times is not None
    motion = moved(scene, ("coordinates", "accelerations"), times[-1], samples=61)
    near(motion.time, times, atol=1e-14)
    alpha = motion.time
    side = -4 * np.cos(alpha)
    phi = np.arctan2(side, 12) + np.arccos(-4 / np.hypot(12, side))
    near(motion.coordinate["rocker_angle"], -(phi - np.pi / 2), atol=2e-13)
    near(motion.orientation["crank"][:, 1], np.sin(alpha / 2), atol=1e-13)
    # Differentiated once: φ̇ (12 sin φ + 4 cos α cos φ) = 4 sin α sin φ.
    rate = 4 * np.sin(alpha) * np.sin(phi) / (12 * np.sin(phi) + 4 * np.cos(alpha) * np.cos(phi))
    near(motion.coordinate_rate["rocker_angle"], -rate, atol=2e-13)


def point(name: str, **tables: Any) -> Any:
    """Scene of one point body."""
    body = {"position": X, "point": True, "mass": 2}
    tree = {"name": name, "unit": "m", "bodies": {"tip": body}}
    return scene_from_dict({**tree, **tables})


def test_a_point_is_led_on_its_path_by_the_force_that_its_mass_wants(
    moved: Callable[..., Motion],
) -> None:
    path = ["cos(3*t)", "2*sin(t)", "speed*t^2"]
    drivers = {"hand": {"body": "tip", "path": path}}
    scene = point("led", drivers=drivers, parameters={"speed": 0.5}, gravity=[0, 0, -G])
    motion = moved(scene, ("accelerations", "reactions"), 4.0)
    t = motion.time
    place = np.stack([np.cos(3 * t), 2 * np.sin(t), 0.5 * t**2], axis=1)
    velocity = np.stack([-3 * np.sin(3 * t), 2 * np.cos(t), t], axis=1)
    acceleration = np.stack([-9 * np.cos(3 * t), -2 * np.sin(t), np.ones_like(t)], axis=1)
    near(motion.position["tip"], place, atol=1e-14)
    near(motion.velocity["tip"], velocity, atol=1e-14)
    near(motion.acceleration["tip"], acceleration, atol=1e-13)
    near(motion.force["hand"], 2 * acceleration + [0, 0, 2 * G], atol=1e-12)


def test_a_point_on_a_line_that_is_drawn_in_keeps_its_angular_momentum(
    moved: Callable[..., Motion],
) -> None:
    """The length l is driven, r² φ̇ is not changed by a force through the centre."""
    span = {"bodies": ["ground", "tip"], "points": [ZERO, ZERO]}
    scene = point(
        "drawn",
        bodies={"tip": {"position": X, "point": True, "mass": 2, "velocity": [0, 1.5, 0]}},
        coordinates={"span": span},
        drivers={"winch": {"coordinate": "span", "value": "1 - 0.1*t"}},
    )
    motion = moved(scene, ("coordinates", "reactions"), 4.0, tolerance=1e-12)
    place, velocity, span_left = (
        motion.position["tip"],
        motion.velocity["tip"],
        1 - 0.1 * motion.time,
    )
    near(motion.coordinate["span"], span_left, atol=1e-14)
    near(np.cross(place, velocity)[:, 2], 1.5, atol=1e-10)
    pull = np.einsum("ij,ij->i", motion.force["winch"], place) / span_left
    near(pull, -2 * 1.5**2 / span_left**3, atol=1e-9)


def test_a_pendulum_on_a_lift_that_speeds_up_is_one_under_more_gravity(
    moved: Callable[..., Motion],
) -> None:
    bob = {"position": [0.6, 0, -0.8], "mass": 1, "inertia": {"xx": 0.1, "yy": 0.1, "zz": 0.1}}
    lift = {"position": ZERO, "mass": 3, "inertia": bob["inertia"]}
    joints = {
        "shaft": {"type": "prismatic", "bodies": ["ground", "lift"], "at": ZERO, "axis": Z},
        "hinge": {"type": "hinge", "bodies": ["lift", "bob"], "at": ZERO, "axis": [0, 1, 0]},
    }
    tree = {"name": "lift", "unit": "m", "bodies": {"lift": lift, "bob": bob}, "joints": joints}
    tree["coordinates"] = {"swing": {"joint": "hinge"}}
    swings = []
    for acceleration, gravity in ((2.0, -G), (0.0, -G - 2.0)):
        law = f"{acceleration / 2!r}*t^2"
        tree["drivers"] = {"motor": {"joint": "shaft", "value": law}}
        scene = scene_from_dict({**tree, "gravity": [0, 0, gravity]})
        motion = moved(scene, ("coordinates",), 3.0, tolerance=1e-12)
        near(motion.position["lift"][:, 2], acceleration / 2 * motion.time**2, atol=1e-14)
        swings.append(motion.coordinate["swing"])
    near(swings[0], swings[1], atol=1e-10)
    assert np.ptp(swings[0]) > 1


def test_a_body_on_a_cross_is_turned_about_both_of_its_arms(moved: Callable[..., Motion]) -> None:
    """About the arm of the ground by 5 t, then about its own by 3 t²."""
    joint = {"type": "cardan", "bodies": ["ground", "body"], "points": [ZERO, ZERO]}
    joint |= {"axes": [X, [0, 1, 0]], "zero": [[0, 1, 0], X]}
    tree = {
        "name": "cross",
        "unit": "m",
        "bodies": {"body": {"position": ZERO}},
        "joints": {"cross": joint},
        "coordinates": {
            "outer": {"joint": "cross", "of": "angle"},
            "inner": {"joint": "cross", "of": "second_angle"},
        },
        "drivers": {
            "first": {"coordinate": "outer", "value": "5*t"},
            "second": {"coordinate": "inner", "value": "3*t^2"},
        },
    }
    motion = moved(scene_from_dict(tree), ("coordinates",), 3.0)
    outer, inner = 5 * motion.time, 3 * motion.time**2
    near(motion.coordinate["outer"], outer, atol=1e-13)
    near(motion.coordinate["inner"], inner, atol=1e-13)
    (a, b), (c, d) = ((np.cos(x / 2), np.sin(x / 2)) for x in (outer, inner))
    turned = np.stack([a * c, b * c, a * d, b * d], axis=1)
    near(np.abs(np.einsum("ij,ij->i", motion.orientation["body"], turned)), 1, atol=1e-14)


@pytest.mark.parametrize("of", ["angle", "second_angle"])
@pytest.mark.parametrize("other", ["ground", "hub"])
def test_a_driver_of_either_angle_of_a_cross_turns_body_j(
    of: str, other: str, moved: Callable[..., Motion]
) -> None:
    """What a motor does to body j: moment of inertia times 2, about the arm that it turns."""
    joint = {"type": "cardan", "bodies": [other, "body"], "points": [ZERO, ZERO]}
    joint |= {"axes": [X, [0, 1, 0]]}
    body = {"position": ZERO, "mass": 1, "inertia": {"xx": 3, "yy": 2, "zz": 4}}
    heavy = {"position": ZERO, "mass": 1, "inertia": dict.fromkeys(("xx", "yy", "zz"), 1e12)}
    tree = {
        "name": "cross",
        "unit": "m",
        "bodies": {"body": body} | ({} if other == "ground" else {other: heavy}),
        "joints": {"cross": joint},
        "drivers": {"motor": {"joint": "cross", "of": of, "value": "t^2"}},
    }
    motion = moved(scene_from_dict(tree), ("reactions", "energies"), 1.0)
    moment = [6, 0, 0] if of == "angle" else [0, 4, 0]
    near(motion.torque["motor"][0], moment, atol=1e-9)
    size = 2 if of == "second_angle" else 3
    near(motion.work["motor"], size / 2 * (2 * motion.time) ** 2, atol=1e-8)


def test_a_planet_turns_by_the_formula_of_willis(moved: Callable[..., Motion]) -> None:
    """On a fixed sun a planet turns 1 + z_s / z_p times as far as its arm."""
    wheel = {"mass": 1, "inertia": {"xx": 1, "yy": 1, "zz": 1}}
    axle = {"type": "revolute", "axis": Z}
    tree = {
        "name": "planet",
        "unit": "m",
        "bodies": {
            "arm": {"position": ZERO, **wheel},
            "planet": {"position": X, **wheel},
        },
        "joints": {
            "sun": {**axle, "bodies": ["arm", "ground"], "at": ZERO},
            "axle": {**axle, "bodies": ["arm", "planet"], "at": X},
            "mesh": {"type": "gear", "joints": ["sun", "axle"], "ratio": -2.5},
        },
        "drivers": {"motor": {"joint": "sun", "value": "-3*t"}},
        "coordinates": {"rolled": {"joint": "axle"}},
    }
    motion = moved(scene_from_dict(tree), ("coordinates",), 2.0)
    turned = 3.5 * 3 * motion.time
    near(motion.coordinate["rolled"], turned - 3 * motion.time, atol=1e-13)
    near(np.abs(motion.orientation["planet"][:, 0]), np.abs(np.cos(turned / 2)), atol=1e-13)
    arm = np.stack([np.cos(3 * motion.time), np.sin(3 * motion.time), 0 * turned], axis=1)
    near(motion.position["planet"], arm, atol=1e-13)


def test_a_differential_turns_its_carrier_by_the_mean_of_both_wheels(
    moved: Callable[..., Motion],
) -> None:
    """2 c = a + b as a linear coupling of three angles, two of them driven."""
    wheel = {"position": ZERO, "mass": 1, "inertia": {"xx": 1, "yy": 1, "zz": 1}}
    axle = {"type": "revolute", "at": ZERO, "axis": Z}
    names = ("a", "b", "c")
    coupling = {"type": "linear", "coordinates": list(names), "factors": [1, 1, -2]}
    tree = {
        "name": "differential",
        "unit": "m",
        "bodies": {f"wheel_{n}": wheel for n in names},
        "joints": {
            **{f"axle_{n}": {**axle, "bodies": ["ground", f"wheel_{n}"]} for n in names},
            "mean": coupling,
        },
        "coordinates": {n: {"joint": f"axle_{n}"} for n in names},
        "drivers": {
            "left": {"coordinate": "a", "value": "4*t"},
            "right": {"coordinate": "b", "value": "sin(t)"},
        },
    }
    motion = moved(scene_from_dict(tree), ("coordinates", "reactions"), 3.0)
    t = motion.time
    near(motion.coordinate["c"], (4 * t + np.sin(t)) / 2, atol=1e-13)
    # The carrier is turned by I c̈, of which each wheel gives half to its motor.
    near(motion.torque["left"][:, 2], -np.sin(t) / 4, atol=1e-12)
    near(motion.torque["right"][:, 2], -np.sin(t) * (1 + 1 / 4), atol=1e-12)


@pytest.mark.parametrize("speed", [1.0, 1e4, 1e8])
def test_a_fast_driver_takes_the_steps_of_a_slow_one(
    moved: Callable[..., Motion], speed: float
) -> None:
    """Errors of displacements are far below the rounding of velocities that they are added to."""
    tree: Tree = {
        "name": "spindle",
        "unit": "m",
        "outputs": [],
        "gravity": [0, 0, -9.81 * speed**2],
        "bodies": {
            "shaft": {"position": ZERO, "mass": 1, "inertia": {"xx": 1, "yy": 1, "zz": 1}},
            "swing": {"position": [0.5, 0, 0], "mass": 1, "inertia": {"xx": 1, "yy": 1, "zz": 1}},
        },
        "joints": {
            "bearing": {"type": "revolute", "bodies": ["ground", "shaft"], "at": ZERO, "axis": Z},
            "pin": {"type": "revolute", "bodies": ["shaft", "swing"], "at": ZERO, "axis": X},
        },
        "drivers": {"motor": {"joint": "bearing", "value": f"3*{speed!r}*t"}},
    }
    tree["bodies"]["swing"]["center"] = [0, 0.3, 0]
    motion = moved(scene_from_dict(tree), (), 1.0 / speed, tolerance=1e-12)
    assert motion.ledger.rejected <= 2
    assert motion.ledger.steps < 60
