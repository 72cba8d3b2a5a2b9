"""A coupling that is not shipped takes one file and its name in a table."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.codegen.dynamics.generate import generate_dynamics
from kousoku.codegen.generate import write_tree
from kousoku.model.elements.joints import COUPLINGS, NAMES
from kousoku.model.errors import SceneError
from kousoku.model.reading.read import scene_from_dict, scene_from_toml
from kousoku.model.reading.schema import scene_schema
from kousoku.model.reading.write import to_toml
from kousoku.runtime import verify
from kousoku.runtime.dynamics import load_dynamics
from tests.elements.belt import Belt

if TYPE_CHECKING:
    from pathlib import Path

Tree = dict[str, Any]


@pytest.fixture(autouse=True)
def belt(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let scenes have it; :data:`NAMES` is made of the tables when they are imported."""
    monkeypatch.setitem(COUPLINGS, "belt", Belt())
    for name in ("belt", *Belt.aliases):
        monkeypatch.setitem(NAMES, name, "belt")


def pulleys(**keys: Any) -> Tree:
    """Two pulleys, one of which is turned by a moment of 6 N m."""
    inertia = {"xx": 1, "yy": 1, "zz": 2}
    drive = {"type": "belt", "joints": ["a", "b"], "radii": ["r", 0.3]} | keys
    return {
        "name": "pulleys",
        "unit": "m",
        "parameters": {"r": 0.1},
        "bodies": {
            name: {"position": [x, 0, 0], "mass": 1, "inertia": inertia}
            for name, x in (("small", 0), ("large", 2))
        },
        "joints": {
            "a": pin("small", 0),
            "b": pin("large", 2),
            "drive": {name: x for name, x in drive.items() if x is not None},
        },
        "coordinates": {"turn": {"joint": "a"}, "slow": {"joint": "b"}},
        "forces": {"motor": {"type": "torque", "body": "small", "torque": [0, 0, 6]}},
        "outputs": ["positions", "velocities", "accelerations", "coordinates", "energies"],
    }


def pin(body: str, x: float) -> Tree:
    return {"type": "revolute", "bodies": ["ground", body], "at": [x, 0, 0], "axis": [0, 0, 1]}


def test_a_scene_with_it_is_written_and_read_again() -> None:
    scene = scene_from_dict(pulleys(type="chain_drive"))
    assert scene_from_toml(to_toml(scene)) == scene
    assert "radii" in scene_schema()["$defs"]["Joint"]["properties"]


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"radii": None}, r"joints\.drive\.radii is missing; a belt wants the radii of two"),
        ({"radii": [0.1, -1]}, r"joints\.drive\.radii\[1\] a radius of -1\.0; wanted a positive"),
        ({"radii": [0.1]}, r"joints\.drive\.radii"),
        ({"ratio": 2}, r"joints\.drive\.ratio a belt couples what joints leave free, and has none"),
        ({"radi": [1, 1]}, r"joints\.drive\.radi unknown key; did you mean 'radii'"),
        ({"joints": ["a", "a"]}, r"joints\.drive\.joints couples a to itself"),
    ],
)
def test_what_is_wrong_with_it_is_told(keys: Tree, message: str) -> None:
    with pytest.raises(SceneError) as caught:
        scene_from_dict(pulleys(**keys))
    assert re.search(message, str(caught.value).replace(": ", " "))


@pytest.mark.usefixtures("compiler")
def test_it_turns_both_pulleys_as_their_radii_say(tmp_path: Path) -> None:
    """(I + I (r/R)²) φ̈ = M."""
    tree = generate_dynamics(scene_from_dict(pulleys()), references=True)
    write_tree(tmp_path / "pulleys", tree)
    assert verify(tmp_path / "pulleys", target="c").problems == ()
    solver = load_dynamics(tmp_path / "pulleys", target="c")
    for radius in (0.1, 0.2):
        times = np.linspace(0, 2, 5)
        motion = solver.simulate(times=times, tolerance=1e-11, parameters={"r": radius})
        turn = 6 / (2 + 2 * (radius / 0.3) ** 2) * times**2 / 2
        np.testing.assert_allclose(motion.coordinate["turn"], turn, atol=1e-9)
        np.testing.assert_allclose(motion.coordinate["slow"], turn * radius / 0.3, atol=1e-9)
        assert motion.ledger.energy_error is not None
        assert motion.ledger.energy_error < 1e-9
