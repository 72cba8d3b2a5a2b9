"""What random scenes are held to: as close as the order of a method tells, and no closer."""

from __future__ import annotations

import random
import tomllib
from typing import Any
from unittest.mock import patch

import pytest

import kousoku as ks
from tests.random_scenes import random_scene
from tests.stress import scenes
from tests.stress.kit import Outcome

#: What they look at is no part of kousoku.
pytestmark = pytest.mark.release

#: Steps over a bend of a spring's law: of fixed length, and of DOP853.
BENT = ("1 44 4", "1 68 1")

#: A crank that a driver leads.
LED = """
name = "led"
unit = "m"
gravity = [0, -9.81, 0]
outputs = ["accelerations"]
[bodies]
crank = { position = [0, 0, 0], rods = [{ mass = 1, ends = [[0, 0, 0], [1, 0, 0]] }] }
[joints]
pin = { type = "revolute", bodies = ["ground", "crank"], at = [0, 0, 0], axis = [0, 0, 1] }
[coordinates]
turn = { joint = "pin" }
[drivers]
motor = { coordinate = "turn", value = "sin(3*t)" }
"""


def found(place: str) -> list[Any]:
    with scenes.quick_to_compile():
        return scenes.look(random_scene(random.Random(place)), place).findings


@pytest.mark.usefixtures("compiler")
@pytest.mark.parametrize("place", [*BENT, "1 79 2"])
def test_methods_are_held_to_their_order(place: str) -> None:
    assert found(place) == []


@pytest.mark.usefixtures("compiler")
@pytest.mark.parametrize("place", BENT)
def test_steps_that_end_at_bends_are_held_closer(place: str) -> None:
    """Where none does, as of a product of which each side is as smooth, that is found."""
    with patch.object(scenes, "LOCATED", "x*abs(x)"):
        assert any("are apart, and trusted" in one.title for one in found(place))


@pytest.mark.usefixtures("compiler")
def test_each_method_has_the_same_bits_in_numpy_and_a_unit_more_is_found() -> None:
    tree = tomllib.loads(LED)
    led, wrong = Outcome(), Outcome()
    with scenes.quick_to_compile():
        scenes.targets(tree, ks.load(tree, target="c"), led, "")
        del tree["drivers"]
        with scenes.rounded_up():
            scenes.targets(tree, ks.load(tree, target="c"), wrong, "")
    assert led.findings == []
    same = {name.rpartition(", ")[2]: number for name, number in led.counts.items()}
    assert same == dict.fromkeys(scenes.STEPS, 1)
    of_steps = {name for name in scenes.STEPS if name != "kinematics"}
    assert {finding.details.split("; ")[1] for finding in wrong.findings} == of_steps
