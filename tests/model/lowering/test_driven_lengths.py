"""Distances that drivers prescribe, found among rows that combine coordinates."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from kousoku.model.expressions.parser import parse_expression
from kousoku.model.expressions.values import value_of
from kousoku.model.lowering.driven_lengths import driven_lengths
from kousoku.model.lowering.system import system_of
from kousoku.model.reading.read import scene_from_toml

if TYPE_CHECKING:
    from kousoku.model.lowering.driven_lengths import DrivenLength

#: Three gears that drive each other, a screw, and a point whose distance is coupled with these.
GEARS = """
name = "gears"
unit = "mm"
parameters = { a = 3.0 }
[bodies]
first = { position = [0, 0, 0] }
second = { position = [0, 0, 0] }
third = { position = [0, 0, 0] }
nut = { position = [0, 0, 0] }
slider = { position = [100, 0, 0], point = true }
[joints]
one = { type = "revolute", bodies = ["ground", "first"], at = [0, 0, 0], axis = [0, 0, 1] }
two = { type = "revolute", bodies = ["ground", "second"], at = [0, 0, 0], axis = [0, 0, 1] }
three = { type = "revolute", bodies = ["ground", "third"], at = [0, 0, 0], axis = [0, 0, 1] }
lead = { type = "screw", bodies = ["ground", "nut"], at = [0, 0, 0], axis = [0, 0, 1], pitch = 5 }
rail = { type = "point_on_line", bodies = ["ground", "slider"], at = [0, 0, 0], axis = [1, 0, 0] }
meet = { type = "gear", joints = ["one", "two"], ratio = 0.3 }
mesh = { type = "gear", joints = ["two", "three"], ratio = 0.7 }
ring = { type = "gear", joints = ["one", "three"], ratio = 0.21 }
drive = { type = "linear", coordinates = ["c", "turn"], factors = [2, "-a"] }
tie = { type = "linear", coordinates = ["far", "way"], factors = [1, 4] }
[coordinates]
c = { joint = "three" }
far = { bodies = ["ground", "slider"], points = [[0, 0, 0], [0, 0, 0]] }
turn = { joint = "lead", of = "angle" }
way = { joint = "lead", of = "displacement" }
start = { joint = "one" }
"""
MOTOR = '[drivers]\nmotor = { coordinate = "start", value = "2*pi*t" }\n'


def found(text: str) -> list[DrivenLength]:
    """Driven distances of a scene."""
    system = system_of(scene_from_toml(text))
    names = {"t", *dict(system.parameters)}
    return [
        *driven_lengths(
            system,
            {
                k: parse_expression(one.law, names)
                for k, one in enumerate(system.constraints)
                if one.law
            },
        )
    ]


@pytest.mark.parametrize("ring", [True, False])
def test_a_distance_follows_a_driver_through_gears_and_a_screw(ring: bool) -> None:
    """Of gears in a circle one row is implied, but for rounding of ratios."""
    lines = GEARS.splitlines(keepends=True)
    text = "".join(line for line in lines if ring or not line.startswith("ring"))
    (one,) = found(text + MOTOR)
    assert one.driver.startswith("motor with joints.")
    assert {"joints.tie", "joints.lead", "joints.drive"} <= {*one.driver.replace(",", "").split()}
    for a in (3.0, 5.0):
        for time in (0.0, 0.25, 2.0):
            wanted = 100.0 - 4.0 * 5.0 * (2.0 / a * 0.21 * time)
            assert value_of(one.law, {"t": time, "a": a}) == pytest.approx(wanted, rel=1e-14)


def test_the_factor_of_a_distance_may_depend_on_parameters() -> None:
    text = GEARS.replace('["far", "way"], factors = [1, 4]', '["far", "way"], factors = ["a", 4]')
    (one,) = found(text + MOTOR)
    for a in (3.0, 5.0):
        wanted = 100.0 - 4.0 / a * 5.0 * (2.0 / a * 0.21 * 0.5)
        assert value_of(one.law, {"t": 0.5, "a": a}) == pytest.approx(wanted, rel=1e-14)


@pytest.mark.parametrize("left_out", ["meet", "lead", "drive", "tie"])
def test_a_distance_follows_no_driver_where_a_coupling_is_left_out(left_out: str) -> None:
    lines = [
        line
        for line in (GEARS + MOTOR).splitlines(keepends=True)
        if not line.startswith((left_out, "ring"))
    ]
    text = "".join(lines)
    if left_out == "lead":
        text = text.replace("[joints]", LOOSE)
    assert not found(text)


#: In place of the screw.
LOOSE = """[joints]
lead = { type = "cylindrical", bodies = ["ground", "nut"], at = [0, 0, 0], axis = [0, 0, 1] }"""


def test_without_a_driver_no_distance_is_driven() -> None:
    assert not found(GEARS)
