"""A driver that is not shipped takes one file and its name in a table."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.codegen.dynamics.generate import generate_dynamics
from kousoku.codegen.generate import write_tree
from kousoku.model.elements.drivers import DRIVERS
from kousoku.model.errors import SceneError
from kousoku.model.reading.read import scene_from_dict, scene_from_toml
from kousoku.model.reading.schema import scene_schema
from kousoku.model.reading.write import to_toml
from kousoku.runtime import verify
from kousoku.runtime.dynamics import load_dynamics
from tests.elements.swing import Swing

if TYPE_CHECKING:
    from pathlib import Path

Tree = dict[str, Any]

BALL = {"xx": 1, "yy": 1, "zz": 1}
PIN = {"type": "revolute", "at": [0, 0, 0], "axis": [0, 0, 1]}


@pytest.fixture(autouse=True)
def swing(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let scenes have it."""
    monkeypatch.setitem(DRIVERS, "swing", Swing())


def arm(**keys: Any) -> Tree:
    """Arm on a hinge that a driver swings."""
    motor = {"swing": "hinge", "amplitude": 0.5, "phase": "w*t"} | keys
    return {
        "name": "arm",
        "unit": "m",
        "parameters": {"w": 2.0},
        "bodies": {"arm": {"position": [0, 0, 0], "mass": 1, "inertia": BALL}},
        "joints": {"hinge": PIN | {"bodies": ["ground", "arm"]}},
        "coordinates": {"angle": {"joint": "hinge"}},
        "drivers": {"motor": {name: x for name, x in motor.items() if x is not None}},
        "outputs": ["positions", "velocities", "coordinates"],
    }


def test_a_scene_with_it_is_written_and_read_again() -> None:
    scene = scene_from_dict(arm())
    assert scene_from_toml(to_toml(scene)) == scene
    assert "amplitude" in scene_schema()["$defs"]["Driver"]["properties"]


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"amplitude": None}, "drivers.motor.amplitude is missing; a swing wants it"),
        ({"amplitude": "much"}, "drivers.motor.amplitude 'much' stands where a number"),
        ({"phase": "abs(t)"}, "drivers.motor.phase abs has a kink"),
        ({"phase": "angle"}, "drivers.motor.phase unknown name 'angle'"),
        ({"value": "t"}, "drivers.motor.value does not belong to 'swing'"),
        ({"joint": "hinge"}, "drivers.motor wanted one of coordinate, joint, body and swing, got"),
        ({"ampltude": 1}, "drivers.motor.ampltude unknown key; did you mean 'amplitude'"),
        ({"swing": "hing"}, "drivers.motor.joint unknown joint 'hing'; did you mean 'hinge'"),
    ],
)
def test_what_is_wrong_with_it_is_told(keys: Tree, message: str) -> None:
    with pytest.raises(SceneError, match=re.escape(message.split(" ", 1)[1])) as caught:
        scene_from_dict(arm(**keys))
    assert message.split(" ", 1)[0] in str(caught.value)


def test_a_shipped_driver_has_none_of_its_keys() -> None:
    keys = {"swing": None, "joint": "hinge", "value": "t", "amplitude": 0.5, "phase": None}
    with pytest.raises(SceneError, match=r"drivers\.motor\.amplitude: does not belong to 'joint'"):
        scene_from_dict(arm(**keys))


@pytest.mark.usefixtures("compiler")
def test_the_angle_follows_its_law(tmp_path: Path) -> None:
    tree = generate_dynamics(scene_from_dict(arm()), references=True)
    write_tree(tmp_path / "arm", tree)
    assert verify(tmp_path / "arm", target="c").problems == ()
    times = np.linspace(0, 1, 5)
    solver = load_dynamics(tmp_path / "arm", target="c")
    motion = solver.simulate(times=times, parameters={"w": 3.0})
    np.testing.assert_allclose(motion.coordinate["angle"], 0.5 * np.sin(3 * times), atol=1e-9)
