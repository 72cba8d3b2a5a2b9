"""The command that says what a scene does not need."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from collections.abc import Callable

    Run = Callable[..., tuple[int, str, str]]

SCENES = Path(__file__).parents[2] / "scenes"

TWICE = """
name = "twice"
unit = "m"
gravity = [0, -9.81, 0]
bodies.b = { position = [0, 0, 0], boxes = [{ mass = 1, size = [1, 2, 3], at = [1, 0, 0] }] }
joints.one = { type = "weld", bodies = ["ground", "b"], at = [0, 0, 0] }
joints.two = { type = "ball", bodies = ["ground", "b"], at = [2, 0, 0] }
"""


def test_the_list_names_steps_what_remains_and_freedoms(run: Run) -> None:
    code, out, _ = run("explain", SCENES / "bricard.toml")

    assert code == 0
    for step in ("kinds not used", "ground has no columns", "planar", "straight-line code"):
        assert step in out
    assert "35 coordinates, 30 velocities, 29 rows" in out
    assert "1 degree of freedom: 30 velocities less rank 29" in out
    assert "1 row of 30 depends on the others of a, b, c, d, e, f: along the branch" in out
    assert "reactions are not unique at a, b, c, d, e, f" in out


def test_a_program_reads_the_same_numbers(run: Run) -> None:
    code, out, _ = run("explain", SCENES / "n_four_bar.toml", "--json")
    data = json.loads(out)

    assert code == 0
    assert data["is_planar"] is True
    assert (data["structure"]["rows"], data["structure"]["dependent"]) == (8, 6)
    assert data["freedom"]["degrees"] == 1
    steps = {step["name"]: step for step in data["steps"]}
    assert steps["planar"]["columns"] == 15
    assert sum(data["segments"].values()) > 1000
    assert data["removed"] == []


def test_a_body_that_is_held_twice_cannot_move(run: Run, tmp_path: Path) -> None:
    scene = tmp_path / "twice.toml"
    scene.write_text(TWICE, encoding="utf-8")
    code, out, _ = run("explain", scene)

    assert code == 0
    assert "0 degrees of freedom: 3 velocities less rank 3" in out
    assert "nothing can move" in out
    assert "of one, two" in out


def test_the_blocks_of_a_linkage_are_told(run: Run) -> None:
    code, out, _ = run("explain", SCENES / "lever_crank.toml")
    assert code == 0
    assert "1 input, 4 unknowns solved block after block: 2, 2" in out
    assert "position_1" in out
    assert "l4 dropped: both of its nodes are fixed\n" in out
    assert "rotations left out, on which nothing that is asked for depends: l1@O2, l2@O2," in out

    _, out, _ = run("explain", SCENES / "lever_crank.toml", "--json")
    assert json.loads(out)["blocks"] == [{"unknowns": 2, "rows": 2}] * 2


@pytest.mark.parametrize("scene", ["pendulum", "heavy_top", "free_body", "piston_crank_bodies"])
def test_every_scene_can_be_explained(run: Run, scene: str) -> None:
    code, out, _ = run("explain", SCENES / f"{scene}.toml")
    assert code == 0
    assert "none depends on others" in out


WELDED = """
name = "welded"
unit = "m"
gravity = [0, 0, -9.81]
bodies.a = { position = [0, 0, 0], boxes = [{ mass = 1, size = [1, 2, 3], at = [1, 0, 0] }] }
bodies.b = { position = [1, 1, 0], boxes = [{ mass = 2, size = [2, 1, 1] }] }
bodies.c = { position = [5, 0, 0], boxes = [{ mass = 1, size = [2, 1, 1] }] }
bodies.d = { position = [1, 2, 0] }
joints.hinge = { type = "hinge", bodies = ["ground", "a"], at = [0, 0, 0], axis = [0, 1, 1] }
joints.weld = { type = "weld", bodies = ["a", "b"], at = [1, 0, 0] }
joints.tip = { type = "weld", bodies = ["b", "d"], at = [1, 2, 0] }
joints.base = { type = "weld", bodies = ["ground", "c"], at = [5, 0, 0] }
"""


def test_bodies_that_are_one_and_bodies_that_are_ground_are_told(run: Run, tmp_path: Path) -> None:
    """One of them need not weigh anything."""
    scene = tmp_path / "welded.toml"
    scene.write_text(WELDED, encoding="utf-8")
    code, out, _ = run("explain", scene, "--json")
    data = json.loads(out)
    step = next(step for step in data["steps"] if step["name"] == "bodies joined rigidly")

    assert code == 0
    assert (step["rows"], step["columns"]) == (18, 18)
    assert "weld, tip, base left out: 4 bodies move as 1" in step["detail"]
    assert data["structure"]["velocities"] == 6
    assert data["freedom"]["degrees"] == 1


def test_what_drivers_leave_to_integrate_is_told(run: Run) -> None:
    code, out, _ = run("explain", SCENES / "gear_train.toml")

    assert code == 0
    assert "motor: pinion; nothing is left to integrate" in out
    assert "wheel, rack: by what the ground leaves free" in out
    assert "9 velocities, 7 of which follow from the others, 2 rows" in out
    assert "the motion is that of motor" in out
    assert "not done" not in out


MASSLESS = """name = "massless"
unit = "m"
[bodies.arm]
position = [0, 0, 0]
[bodies.bob]
position = [1, 0, 0]
mass = 1
[joints.ball]
type = "ball"
bodies = ["arm", "bob"]
at = [0, 0, 0]
"""


@pytest.mark.parametrize("command", ["explain", "generate", "verify"])
def test_what_is_found_when_a_scene_is_put_together_has_its_file_and_lines(
    run: Run, tmp_path: Path, command: str
) -> None:
    file = tmp_path / "massless.toml"
    file.write_text(MASSLESS)

    code, _, err = run(command, file)

    assert code == 2
    assert f"{file}:3: bodies.arm.mass: is missing" in err
    assert f"{file}:5: bodies.bob.inertia: has a principal moment of 0.0" in err


@pytest.mark.parametrize("command", [("explain",), ("simulate", "--end", 1)])
def test_a_scene_that_does_not_fit_is_told_with_its_file_and_the_lines_of_its_joints(
    run: Run, tmp_path: Path, command: tuple[object, ...]
) -> None:
    file = tmp_path / "torn.toml"
    text = TWICE.replace("one", "torn").replace("at = [2, 0, 0]", FAR_POINTS)
    file.write_text(text)

    code, _, err = run(*command, file)

    assert code == 2
    shown = re.findall(r"joints\.([a-z]+) \(line ([0-9]+)\) by [0-9.]+ m", err)
    lines = [text.split("\n")[int(line) - 1] for _, line in shown]
    assert len(lines) == 2
    for (joint, _), line in zip(shown, lines, strict=True):
        assert line.startswith(f"joints.{joint} = ")
    assert f"{file}:{shown[0][1]}: twice: does not fit together" in err


FAR_POINTS = "points = [[9, 0, 0], [2, 0, 0]]"
