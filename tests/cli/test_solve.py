"""``kousoku solve``: files, summaries, plots, and what it refuses."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

if TYPE_CHECKING:
    from collections.abc import Callable

    Run = Callable[..., tuple[int, str, str]]

pytestmark = pytest.mark.usefixtures("compiler")

ROOT = Path(__file__).parents[2]
PISTON = ROOT / "scenes" / "piston_crank.toml"
LEVER = ROOT / "scenes" / "lever_crank.toml"
MOTION = [f"{letter}{axis}" for letter in ("", "v", "a") for axis in "xy"]


def test_csv_has_a_row_for_each_position_and_the_papers_names(run: Run, tmp_path: Path) -> None:
    out = tmp_path / "lever.csv"
    code, _, err = run("solve", LEVER, "--out", out)
    assert (code, err) == (0, "")
    lines = out.read_text(encoding="utf-8").splitlines()
    names = [f"{node}.{name}" for node in ("O1", "O2", "O3", "O4") for name in MOTION]
    assert lines[0].split(",") == ["alpha", *names]
    table = np.loadtxt(out, delimiter=",", skiprows=1)
    assert table.shape == (61, 25)
    np.testing.assert_allclose(table[:, 0], 2 * np.pi * np.arange(61) / 60, rtol=1e-15)
    np.testing.assert_allclose(np.hypot(table[:, 7], table[:, 8]), 30.0, rtol=1e-15)


def test_npz_holds_the_same_numbers_as_csv(run: Run, tmp_path: Path) -> None:
    for suffix in ("csv", "npz"):
        assert run("solve", PISTON, "--out", tmp_path / f"piston.{suffix}")[0] == 0
    table = np.genfromtxt(tmp_path / "piston.csv", delimiter=",", names=True, deletechars="")
    with np.load(tmp_path / "piston.npz") as columns:
        names = [name for name in columns if not name.startswith("kousoku")]
        assert names == list(table.dtype.names or ())
        for name in names:
            np.testing.assert_array_equal(columns[name], table[name])


def test_several_inputs_have_a_column_each(run: Run, tmp_path: Path) -> None:
    out = tmp_path / "five.csv"
    assert run("solve", ROOT / "scenes" / "five_bar.toml", "--out", out)[0] == 0
    first = out.read_text(encoding="utf-8").splitlines()[0].split(",")
    assert first[:3] == ["alpha", "beta", "O1.x"]


@pytest.mark.parametrize(("scene", "length"), [(PISTON, 2.0), (LEVER, 100.0)])
def test_json_summary_compares_with_the_closed_form(run: Run, scene: Path, length: float) -> None:
    code, out, _ = run("solve", scene, "--json")
    summary = json.loads(out)
    assert code == 0
    assert (summary["method"], summary["divisions"], summary["rows"]) == ("newton", 60, 61)
    assert 0 < summary["iterations"]["max"] <= summary["iterations"]["total"]
    assert summary["residual_max"] <= 1e-13
    assert summary["errors"]["position"] <= 4e-15 * length
    assert summary["errors"]["velocity"] <= 1e-14 * length
    assert summary["errors"]["acceleration"] <= 2e-14 * length


def test_the_papers_method_needs_more_iterations(run: Run) -> None:
    counts = [
        json.loads(run("solve", LEVER, "--method", method, "--json")[1])["iterations"]
        for method in ("newton", "paper")
    ]
    assert counts[0]["max"] < counts[1]["min"]


def test_a_linkage_without_closed_form_has_no_errors_to_tell(run: Run) -> None:
    summary = json.loads(run("solve", ROOT / "scenes" / "watt_six_bar.toml", "--json")[1])
    assert summary["errors"] is None


def test_the_table_for_people_shows_the_last_node_that_moves(run: Run) -> None:
    code, out, _ = run("solve", PISTON)
    assert code == 0
    assert "O3.ax" in out and "O2.x" not in out and "closed form" in out
    assert "O2.ax" in run("solve", PISTON, "--node", "O2")[1]


def test_plots_are_those_of_the_paper(run: Run, tmp_path: Path) -> None:
    folder = tmp_path / "plots"
    code, _, _ = run("solve", LEVER, "--plot", folder)
    assert code == 0
    names = {path.name for path in folder.iterdir()}
    assert names == {f"lever_crank_O3_{p}.svg" for p in ("motion", "velocity", "acceleration")}


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (("--out", "x.txt"), "x.txt"),
        (("--out", "no/such/folder/x.csv"), "there is no folder no/such/folder"),
        (("--node", "O9"), "O9"),
        (("--method", "magic"), "magic"),
        (("--divisions", "0"), "divisions"),
        (("--divisions", "1" + 20 * "0"), "no room for 1"),
        (("--turns", "1" + 12 * "0"), "no room for 6"),
        (("--first-turn", "1" + 18 * "0"), "fewer turns"),
    ],
)
def test_bad_options_are_refused_before_anything_is_solved(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: list[str], word: str
) -> None:
    monkeypatch.chdir(tmp_path)
    code, out, err = run("solve", LEVER, *arguments)
    assert (code, out) == (2, "")
    assert word in err and "Traceback" not in err
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("scene", ["missing.toml", "pendulum.toml"])
def test_what_has_no_inputs_is_one_message(run: Run, scene: str) -> None:
    code, out, err = run("solve", ROOT / "scenes" / scene)
    assert (code, out) == (2, "")
    assert err.count("\n") == 1 and scene in err


CRANK = """
name = "crank"
unit = "m"
divisions = 8
outputs = ["accelerations", "reactions"]
gravity = [0, 0, -9.81]
[bodies.arm]
position = [0, 0, 0]
boxes = [{ mass = 2, size = [1, 0.1, 0.1], at = [0.5, 0, 0] }]
[joints.hinge]
type = "revolute"
bodies = ["ground", "arm"]
at = [0, 0, 0]
axis = [0, 0, 1]
[inputs]
alpha = { joint = "hinge", from = 0, turns = 1, rate = 2 }
"""


@pytest.fixture
def crank(tmp_path: Path) -> Path:
    path = tmp_path / "crank.toml"
    path.write_text(CRANK, encoding="utf-8")
    return path


@pytest.mark.usefixtures("numpy_solver")
@pytest.mark.parametrize("target", ["auto", "numpy"])
def test_bodies_are_solved_at_the_divisions_of_their_input(
    run: Run, crank: Path, tmp_path: Path, target: str
) -> None:
    out = tmp_path / "crank.csv"
    code, printed, err = run("solve", crank, "--target", target, "--out", out, "--divisions", 4)
    assert (code, err) == (0, "")
    assert "kinematics, driven: " in printed and f"wrote {out}" in printed
    names = out.read_text(encoding="utf-8").splitlines()[0].split(",")
    table = dict(zip(names, np.loadtxt(out, delimiter=",", skiprows=1).T, strict=True))
    np.testing.assert_allclose(table["time"], np.linspace(0, np.pi, 5), rtol=1e-15)
    np.testing.assert_allclose(table["arm.omega_z"], 2, rtol=1e-14)
    np.testing.assert_allclose(table["hinge.fx"][::2], [-4, 4, -4], rtol=1e-13)
    np.testing.assert_allclose(table["hinge.fz"], 2 * 9.81, rtol=1e-13)


def test_options_of_the_other_scenes_are_refused(run: Run, crank: Path) -> None:
    for scene, option, says in (
        (crank, ("--turns", 2), "--turns is an option of linkages of nodes; this one is a scene"),
        (crank, ("--node", "O3"), "no body 'O3': there are arm"),
        (LEVER, ("--body", "arm"), "no node 'arm': there are O1, O2, O3, O4"),
        (LEVER, ("--set", "k=3"), "a linkage has no parameters"),
        (crank, ("--set", "k=3"), "its formulas have none"),
    ):
        code, out, err = run("solve", scene, *option)
        assert (code, out) == (2, "")
        assert says in err


def test_bodies_that_their_input_leaves_free_are_sent_to_simulate(run: Run, tmp_path: Path) -> None:
    bob = "[bodies.bob]\nposition = [0, 0, 5]\nmass = 1\npoint = true\n"
    scene = tmp_path / "falling.toml"
    scene.write_text(CRANK.replace("[joints.hinge]", f"{bob}[joints.hinge]"), encoding="utf-8")
    code, out, err = run("solve", scene)
    assert (code, out) == (2, "")
    assert f"{scene}" in err and "kinematics" in err and "moves freely" in err


def test_a_dead_centre_keeps_the_last_good_position(run: Run, tmp_path: Path) -> None:
    out = tmp_path / "out.csv"
    code, printed, err = run("solve", ROOT / "tests/scenes/second_loop_stops.toml", "--out", out)
    assert (code, printed) == (3, "")
    assert err.count("\n") == 1
    assert ": inputs.alpha: a dead centre" in err
    rows = len(out.read_text(encoding="utf-8").splitlines()) - 1
    assert 0 < rows < 61


def test_a_users_scene_starts_no_sympy(loaded_by: Callable[..., set[str]], tmp_path: Path) -> None:
    scene = tmp_path / "mine.toml"
    text = LEVER.read_text(encoding="utf-8").replace("lever_crank", "mine")
    scene.write_text(text.replace("length = 60", "length = 61"), encoding="utf-8")
    modules = loaded_by("solve", scene, "--out", tmp_path / "mine.csv")
    assert "numpy" in modules and "sympy" not in modules


def test_without_a_compiler_one_line_says_so(tmp_path: Path) -> None:
    import os
    import subprocess
    import sys

    done = subprocess.run(
        [sys.executable, "-m", "kousoku", "solve", LEVER],
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, "KOUSOKU_CC": "none"},
    )
    assert "by numpy" in done.stdout
    assert done.stderr.count("\n") == 1 and "NumPy" in done.stderr


def test_all_problems_of_a_scene_are_told_at_once_with_their_lines(
    run: Run, tmp_path: Path
) -> None:
    text = LEVER.read_text(encoding="utf-8")
    lines = text.splitlines()
    scene = tmp_path / "lever.toml"
    scene.write_text(text.replace('"cm"', '"ells"').replace('about = "O1"', 'about = "O3"'))
    code, out, err = run("solve", scene)
    unit = next(k for k, line in enumerate(lines, 1) if '"cm"' in line)
    alpha = next(k for k, line in enumerate(lines, 1) if 'about = "O1"' in line)
    first, second = err.splitlines()
    assert (code, out) == (2, "")
    assert first.startswith(f"kousoku: {scene}:{unit}: unit: the text 'ells' stands where")
    assert second.startswith(f"{scene}:{alpha}: inputs.alpha.about: 'O3' is no end of it")


def test_a_linkage_that_does_not_fit_is_told_with_the_lines_of_its_links(run: Run) -> None:
    file = ROOT / "tests" / "scenes" / "second_loop_open.toml"
    lines = file.read_text().splitlines()
    at = {name: k for k, line in enumerate(lines, 1) for name in [line.partition(" =")[0]]}

    code, _, err = run("solve", file)

    assert code == 2
    rod, rocker = at["rod2"], at["rocker"]
    links = f"links.rod2 (line {rod}), links.rocker (line {rocker}): the linkage cannot be"
    assert f"{file}:{rod}: second_loop_open: {links}" in err
