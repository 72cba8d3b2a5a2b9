"""Drivers become combinations of one coordinate and a law, inputs of joints become drivers."""

from __future__ import annotations

from math import isnan, pi, tau
from pathlib import Path
from typing import Any

import pytest

from kousoku.model.errors import SceneError
from kousoku.model.expressions.parser import parse_expression
from kousoku.model.expressions.values import value_of
from kousoku.model.linkage.input_drivers import drivers_of, formula_text, time_of, times_of
from kousoku.model.lowering.system import system_of
from kousoku.model.mechanics.constraints import COMBINATION
from kousoku.model.numbers import precise
from kousoku.model.reading.read import read_scene, scene_from_dict
from kousoku.model.records.planar import Input

ROOT = Path(__file__).parents[3]
Tree = dict[str, Any]


@pytest.fixture
def crank() -> Tree:
    """Tables of a body on an axle, in centimetres, new for each test."""
    joint = {"type": "revolute", "bodies": ["ground", "crank"], "at": [0, 0, 0], "axis": [0, 0, 1]}
    return {
        "name": "crank",
        "unit": "cm",
        "bodies": {"crank": {"position": [0, 0, 0], "mass": 1}},
        "joints": {"axle": joint},
    }


def test_a_driver_is_a_coordinate_less_its_law(crank: Tree) -> None:
    crank["parameters"] = {"speed": 3}
    crank["drivers"] = {"motor": {"joint": "axle", "value": "speed*t + 1"}}
    system = system_of(scene_from_dict(crank))
    (angle,), motor = system.coordinates, system.constraints[-1]
    assert (angle.name, angle.kind, angle.near) == ("axle.angle", "angle", 1)
    assert (motor.joint, motor.kind, motor.unit) == ("motor", COMBINATION, "rad")
    assert (motor.law, motor.law_unit, motor.offset) == ("speed*t + 1", 1, 0)
    assert [(term.coordinate, term.factor) for term in motor.terms] == [(0, 1)]
    assert motor.is_driver
    assert system.parameters == (("speed", 3.0),)


def test_a_driven_angle_starts_at_the_turn_of_its_law_unless_the_scene_says_near(
    crank: Tree,
) -> None:
    crank["drivers"] = {"motor": {"coordinate": "turn", "value": "100 + t"}}
    crank["coordinates"] = {"turn": {"joint": "axle"}}
    assert system_of(scene_from_dict(crank)).coordinates[0].near == 100
    crank["coordinates"]["turn"]["near"] = 99
    assert system_of(scene_from_dict(crank)).coordinates[0].near == 99
    crank["coordinates"]["turn"]["near"] = 96
    with pytest.raises(SceneError, match="is 100 at t = 0, and turn is near 96"):
        scene_from_dict(crank)


def test_a_path_is_three_places_in_the_unit_of_the_scene(crank: Tree) -> None:
    path = ["cos(t)", "sin(t)", 2.5]
    crank["drivers"] = {"hand": {"body": "crank", "point": [1, 0, 0], "path": path}}
    system = system_of(scene_from_dict(crank))
    rows = [one for one in system.constraints if one.joint == "hand"]
    assert [one.law for one in rows] == ["cos(t)", "sin(t)", "2.5"]
    assert {one.law_unit for one in rows} == {0.01}
    assert {one.unit for one in rows} == {"m"}
    assert [c.name for c in system.coordinates] == ["hand.x", "hand.y", "hand.z"]
    for k, place in enumerate(system.coordinates):
        constants = dict(place.constants)
        assert constants["a_i_b"] == tuple(float(k == m) for m in range(3))
        assert constants["s_j_b"] == (0.01, 0, 0)


def test_an_input_is_a_law_of_second_degree(crank: Tree) -> None:
    given = {"joint": "axle", "from": 0.5, "turns": 2, "rate": 3, "acceleration": -0.25}
    crank["inputs"] = {"alpha": given}
    (driver,) = drivers_of(scene_from_dict(crank)).values()
    law = parse_expression(str(driver.value), ("t",))
    assert value_of(law, {"t": 2.0}) == 0.5 + 3 * 2 - 0.25 / 2 * 4


def test_an_input_takes_its_divisions_at_the_times_of_its_law(crank: Tree) -> None:
    crank["divisions"] = 4
    crank["inputs"] = {"alpha": {"joint": "axle", "turns": -1, "rate": -pi}}
    assert times_of(scene_from_dict(crank)) == [0, 0.5, 1, 1.5, 2]
    crank["inputs"]["alpha"]["acceleration"] = -1.5
    scene = scene_from_dict(crank)
    for k, time in enumerate(times_of(scene) or ()):
        assert -pi * time - 0.75 * time**2 == pytest.approx(-tau * k / 4, abs=1e-14)
    del crank["inputs"], crank["divisions"]
    assert times_of(scene_from_dict(crank)) is None


def test_the_four_bar_makes_its_turn_in_two_pi_seconds() -> None:
    times = times_of(read_scene(ROOT / "scenes" / "spatial_four_bar.toml"))
    assert times is not None
    assert (len(times), times[0], times[-1]) == (61, 0, tau)


@pytest.mark.parametrize(
    ("rate", "acceleration", "to"),
    [(1.0, 0.0, -1.0), (0.0, 0.0, 1.0), (1.0, -1.0, 1.0), (-1.0, 5.0, 1.0), (1.0, 0.0, 0.0)],
)
def test_a_way_that_is_not_reached_takes_no_time(
    rate: float, acceleration: float, to: float
) -> None:
    """At 1 − t the way is at most ½; a way that begins with the other direction is none."""
    assert isnan(time_of(Input(joint="a", to=to, rate=rate, acceleration=acceleration), 1.0))


def test_several_inputs_take_their_divisions_at_the_same_times(crank: Tree) -> None:
    second = {"type": "prismatic", "bodies": ["crank", "tool"], "at": [0] * 3, "axis": [0, 0, 1]}
    crank["bodies"]["tool"] = {"position": [0, 0, 0], "mass": 1}
    crank["joints"]["slide"] = second
    crank["inputs"] = {"alpha": {"joint": "axle"}, "beta": {"joint": "slide", "to": 2 * tau}}
    with pytest.raises(SceneError, match="wanted the same times") as caught:
        scene_from_dict(crank)
    assert caught.value.key == "inputs.beta"
    crank["inputs"]["beta"]["rate"] = 2
    assert scene_from_dict(crank).inputs


def test_a_displacement_makes_no_turns(crank: Tree) -> None:
    crank["joints"]["axle"]["type"] = "prismatic"
    crank["inputs"] = {"alpha": {"joint": "axle", "turns": 1}}
    with pytest.raises(SceneError, match="makes no turns; wanted 'to'"):
        scene_from_dict(crank)
    crank["inputs"] = {"alpha": {"joint": "axle"}}
    with pytest.raises(SceneError, match=r"inputs\.alpha\.to: is missing"):
        scene_from_dict(crank)


def test_an_input_of_a_joint_with_two_freedoms_wants_a_driver(crank: Tree) -> None:
    crank["joints"]["axle"]["type"] = "cylindrical"
    crank["inputs"] = {"alpha": {"joint": "axle"}}
    with pytest.raises(SceneError, match="wanted a driver with 'of'"):
        scene_from_dict(crank)
    del crank["inputs"]
    crank["drivers"] = {"motor": {"joint": "axle", "of": "displacement", "value": "3*t"}}
    driver = system_of(scene_from_dict(crank)).constraints[-1]
    assert (driver.unit, driver.law_unit) == ("m", float(precise.number(0.01)))


@pytest.mark.parametrize(
    "text", ["min(t, 1)", "max(t, 1)", "sign(t)", "1 + abs(t - 5)", "sqrt((t - 5)^2)"]
)
def test_a_law_with_a_kink_is_refused(crank: Tree, text: str) -> None:
    crank["drivers"] = {"motor": {"joint": "axle", "value": text}}
    with pytest.raises(SceneError, match="has a kink"):
        scene_from_dict(crank)


@pytest.mark.parametrize("text", ["1/t", "log(t)", "t^1.5", "acos(2 + t)", "exp(exp(exp(9)))"])
def test_a_law_without_value_or_derivatives_at_the_start_is_refused(crank: Tree, text: str) -> None:
    crank["drivers"] = {"motor": {"joint": "axle", "value": text}}
    with pytest.raises(SceneError, match="has no finite"):
        scene_from_dict(crank)


@pytest.mark.parametrize("value", [0.1, -2.5e-7, 1e22, -1e50, 3e-50, 1.5e-51, -2e-100, 5e-324])
def test_a_number_is_a_formula_of_the_same_value(crank: Tree, value: float) -> None:
    assert float(value_of(parse_expression(formula_text(value), ()), {})) == value
    crank["drivers"] = {"motor": {"joint": "axle", "value": value}}
    assert system_of(scene_from_dict(crank)).coordinates[0].near == value
    crank["drivers"] = {}
    crank["inputs"] = {"alpha": {"joint": "axle", "from": value, "acceleration": abs(value)}}
    assert system_of(scene_from_dict(crank)).coordinates[0].near == value
