"""Options of a run: where it starts, how long and in which steps, what is shown; completion."""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.cli.completing import files

if TYPE_CHECKING:
    from collections.abc import Callable

    Run = Callable[..., tuple[int, str, str]]

SCENES = Path(__file__).parents[2] / "scenes"
LOOP = SCENES / "loop_free.toml"
LEVER = SCENES / "lever_crank.toml"
CART = """
name = "cart"
unit = "m"
outputs = ["coordinates"]
coordinates = { way = { joint = "rail" } }
[bodies]
cart = { position = [0, 0, 0], mass = 1, center = [0, 0, 0], inertia = { xx = 1, yy = 1, zz = 1 } }
[joints]
rail = { type = "prismatic", bodies = ["ground", "cart"], at = [0, 0, 0], axis = [1, 0, 0] }
"""
PNG = b"\x89PNG\r\n\x1a\n"


@pytest.fixture
def rows(run: Run, tmp_path: Path, compiler: object) -> Callable[..., Any]:
    """Rows of a run of the loop, by name."""

    def moved(*options: object, scene: Path = LOOP) -> Any:
        out = tmp_path / "rows.csv"
        code, _, err = run("simulate", scene, *options, "--out", out)
        assert (code, err) == (0, "")
        return np.genfromtxt(out, delimiter=",", names=True, deletechars="")

    return moved


@pytest.mark.parametrize(
    "given",
    [
        *("30deg", "30 deg", "3e1deg", "30*deg", str(math.pi / 6)),
        *("pi/6", "asin(1/2)", "(10 + 5*4) * deg", "pi/2 - 60 deg"),
    ],
)
def test_a_run_starts_where_it_is_told(rows: Callable[..., Any], given: str) -> None:
    options = ("--initial", f"crank_angle={given}", "--initial", "crank_angle_dot=-0.5")
    found = rows("--end", 1, "--samples", 3, *options)
    assert found["crank_angle"][0] == pytest.approx(math.pi / 6, rel=1e-12)
    assert found["crank_angle_dot"][0] == pytest.approx(-0.5, rel=1e-12)


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ("crank_angle", "--initial crank_angle: wanted a name, = and a number: angle=pi/6, or"),
        ("crank_angle=", "wanted a name, = and a number"),
        ("crank_angle=30 degrees", "column 4: 'degrees' stands where an operator is wanted"),
        ("crank_angle=30 deg/s", "a rate, angle_dot, is per second"),
        ("crank_angle=__import__('os')", "column 1: unknown name '__import__'"),
        ("crank_angle=9**9**9", "column 2: '**' is no operator"),
        ("crank_angle=9^9^9^9", "initial crank_angle is nan"),
        ("crank_angle=1/0", "column 3: a division by zero"),
        ("crank_angle=sqrt(-1)*deg", "initial crank_angle is nan"),
        ("=3", "--initial =3: wanted a name, = and a number"),
        ("crank_angel=3", "no coordinate 'crank_angel'"),
        ("crank_angle=nan", "initial crank_angle is nan; wanted a finite number"),
    ],
)
def test_a_start_that_is_none_is_one_line(
    run: Run, compiler: object, given: str, says: str
) -> None:
    code, out, err = run("simulate", LOOP, "--end", 1, "--initial", given)
    assert (code, out) == (2, "")
    assert err.count("\n") == 1 and says in err


@pytest.mark.parametrize(
    ("given", "wanted"),
    [("1/4", 0.25), ("2*pi/3", 2 * math.pi / 3), ("30 deg", math.pi / 6), ("sqrt(2) - 1e-3", None)],
)
def test_a_parameter_is_a_formula_as_in_files(
    run: Run, compiler: object, given: str, wanted: float | None
) -> None:
    code, out, _ = run("simulate", LOOP, "--end", 0.1, "--set", f"mass={given}", "--json")
    mass = json.loads(out)["ledger"]["parameters"]["mass"]
    wanted = math.sqrt(2) - 1e-3 if wanted is None else wanted
    assert (code, mass) == (0, pytest.approx(wanted, rel=1e-15))


@pytest.mark.parametrize("given", ["30deg", "2*15deg"])
def test_a_length_is_no_angle(run: Run, compiler: object, tmp_path: Path, given: str) -> None:
    scene = tmp_path / "cart.toml"
    scene.write_text(CART, encoding="utf-8")
    assert run("simulate", scene, "--end", 0.1, "--initial", "way=1/2")[0] == 0
    code, _, err = run("simulate", scene, "--end", 0.1, "--initial", f"way={given}")
    assert code == 2 and "initial way is '" in err and "deg'; wanted a finite number\n" in err


def test_steps_are_no_longer_than_the_longest(run: Run, compiler: object) -> None:
    options = ("simulate", LOOP, "--end", 1, "--samples", 2, "--json")
    free, bound = (
        json.loads(run(*options, *more)[1])["ledger"]["steps"]
        for more in ((), ("--largest-step", 0.001))
    )
    assert free < 100
    assert bound >= 1000
    code, _, err = run(*options, "--largest-step", -1)
    assert code == 2 and "--largest-step -1.0; wanted one above 0" in err


def test_too_many_steps_stop_the_run(run: Run, compiler: object, tmp_path: Path) -> None:
    out = tmp_path / "part.npz"
    code, _, err = run("simulate", LOOP, "--end", 9, "--most-steps", 10, "--out", out)
    assert code == 3
    assert "10 steps are made" in err and f"what was computed before is in {out}" in err
    with np.load(out) as columns:
        assert 1 < len(columns["time"]) < 1001


def test_a_scene_has_a_duration_of_its_own(rows: Callable[..., Any], tmp_path: Path) -> None:
    scene = tmp_path / "loop_free.toml"
    scene.write_text(f"duration = 0.75\n{LOOP.read_text(encoding='utf-8')}", encoding="utf-8")
    assert rows("--samples", 4, scene=scene)["time"].tolist() == [0.0, 0.25, 0.5, 0.75]
    assert rows("--samples", 2, "--end", 0.5, scene=scene)["time"][-1] == 0.5


def test_the_columns_that_are_named_are_printed(run: Run, compiler: object) -> None:
    options = ("simulate", LOOP, "--end", 1, "--samples", 2)
    _, out, _ = run(*options, "--column", "rocking", "--column", "a.fz")
    head = ["time", "[s]", "rocking", "[rad]", "a.fz", "[N]"]
    assert out.splitlines()[1].split() == head
    _, out, _ = run(*options, "--column", "a")
    assert all(f"a.{x}" in out for x in ("fx", "fy", "fz", "mx", "my", "mz"))


@pytest.mark.parametrize("more", [(), ("--json",), ("--plot", "x.png"), ("--out", "x.csv")])
def test_a_column_that_there_is_not_is_one_line(
    run: Run, compiler: object, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, more: Any
) -> None:
    monkeypatch.chdir(tmp_path)
    code, out, err = run("simulate", LOOP, "--end", 1, "--column", "rockin", *more)
    assert (code, out) == (2, "")
    assert err.count("\n") == 1
    assert "--column: loop_free: no column 'rockin'" in err and "mean 'rocking'" in err
    assert not list(tmp_path.iterdir())


def test_plots_go_into_one_picture(run: Run, compiler: object, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    for name, begin in (("x.png", PNG), ("x.svg", b"<?xml")):
        place = tmp_path / name
        code, out, err = run(
            *("simulate", LOOP, "--end", 1, "--column", "rocking", "--plot", place)
        )
        assert (code, err) == (0, "")
        assert place.read_bytes().startswith(begin)
        assert f"wrote {place}" in out


def test_a_run_that_was_kept_is_animated(run: Run, compiler: object, tmp_path: Path) -> None:
    kept, page, other = (tmp_path / name for name in ("run.npz", "kept.html", "moved.html"))
    options = ("--end", 2, "--set", "mass=1.5", "--initial", "crank_angle=20deg")
    assert run("simulate", LOOP, *options, "--out", kept, "--samples", 1001)[0] == 0
    code, out, err = run("animate", kept, "--out", page)
    assert (code, err) == (0, "")
    assert out.startswith(f"wrote {page}, ")
    assert run("animate", LOOP, *options, "--out", other)[0] == 0
    assert page.read_bytes() == other.read_bytes()
    kept.write_bytes(kept.read_bytes()[:-100])
    code, out, err = run("animate", kept, "--out", page)
    assert (code, out) == (2, "")
    assert err.startswith(f"kousoku: {kept}: holds no run") and err.count("\n") == 1


@pytest.mark.parametrize("missing", [["pyarrow"], ["pandas", "pyarrow"]])
def test_a_table_without_its_packages_is_refused_before_it_moves(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, missing: list[str]
) -> None:
    monkeypatch.setattr("kousoku.cli.moving.find_spec", lambda name: name not in missing or None)
    code, out, err = run("simulate", LOOP, "--end", 1, "--out", tmp_path / "x.parquet")
    assert (code, out, [*tmp_path.iterdir()]) == (2, "", [])
    needed = " and ".join(missing)
    assert err == f"kousoku: --out *.parquet needs {needed}: pip install kousoku[table]\n"


@pytest.mark.parametrize("name", ["x.gif", "plots.d", "x.bmp"])
def test_a_plot_of_another_format_is_refused_before_it_moves(
    run: Run, tmp_path: Path, name: str
) -> None:
    code, out, err = run("simulate", LOOP, "--end", 1, "--plot", tmp_path / name)
    assert (code, out, [*tmp_path.iterdir()]) == (2, "", [])
    wanted = "wanted a folder, or a name that ends in .png or .svg or .pdf"
    assert err == f"kousoku: --plot {tmp_path / name}: {wanted}\n"


def test_a_folder_with_a_point_in_its_name_takes_plots(
    run: Run, compiler: object, tmp_path: Path
) -> None:
    place = tmp_path / "run.1"
    place.mkdir()
    assert run("simulate", LOOP, "--end", 1, "--plot", place)[0] == 0
    assert (place / "loop_free_coordinates.svg").exists()


@pytest.mark.parametrize(
    ("command", "says"),
    [
        (["simulate", LOOP], "a last time is wanted: --end SECONDS; or give the scene a duration"),
        (["simulate", LOOP, "--end", 9, "--most-steps", 3], "--most-steps allows more of them"),
        (
            ["simulate", LOOP, "--end", 9, "--step", 1, "--largest-step", 0.1],
            "step 1.0 with --largest-step 0.1",
        ),
        (
            ["simulate", LOOP, "--end", 1, "--largest-step", 0],
            "--largest-step 0.0; wanted one",
        ),
        (
            ["simulate", LOOP, "--end", 1, "--initial", "crank_angle=1", "--output", "energies"],
            'was generated without "coordinates"; the scene wants outputs = [..., "coordinates"]',
        ),
        (
            ["simulate", LEVER, "--end", 1, "--estimate-error"],
            "--estimate-error is an option of scenes of bodies; this one is a linkage of nodes\n",
        ),
        (
            ["simulate", LEVER, "--end", 1, "--set", "k=1"],
            "--set is an option of scenes of bodies; this one is a linkage of nodes\n",
        ),
        (
            ["solve", SCENES / "oldham_coupling.toml", "--first-turn", 1],
            "--first-turn is an option of linkages of nodes; this one is a scene of bodies\n",
        ),
        (["solve", LOOP], "or nothing drives: kousoku simulate\n"),
    ],
)
def test_messages_name_options_as_they_are_typed(
    run: Run, compiler: object, command: list[Any], says: str
) -> None:
    code, _, err = run(*command)
    assert (code in {2, 3}, says in err, err.count("\n")) == (True, True, 1), err


# ---- completion ---------------------------------------------------------------------------------


@pytest.fixture
def tree(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scenes" / "more").mkdir(parents=True)
    (tmp_path / ".hidden").mkdir()
    for name in ("loop.toml", "lever.toml", "notes.txt", "run.npz"):
        (tmp_path / "scenes" / name).touch()
    return tmp_path


def test_scene_files_and_folders_are_completed(tree: Path) -> None:
    complete = files(".toml")
    inside = [f"scenes/{name}" for name in ("lever.toml", "loop.toml", "more/")]
    assert complete("") == complete("sc") == complete("scenes/") == inside
    assert complete("scenes/l") == inside[:2]
    assert complete("scenes/lo") == ["scenes/loop.toml"]
    assert complete(f"{tree}/scenes/lo") == [f"{tree}/scenes/loop.toml"]
    assert complete("nowhere/") == complete("scenes/n") == complete("scenes/more/") == []
    assert files(".toml", ".npz")("scenes/r") == ["scenes/run.npz"]


@pytest.mark.usefixtures("tree")
@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_a_shell_is_told(shell: str) -> None:
    words = "kousoku simulate scenes/l"
    name = "_KOUSOKU_COMPLETE"
    done = subprocess.run(
        [
            sys.executable,
            "-c",
            "import sys; sys.argv = ['kousoku']; import kousoku.cli as c; c.main()",
        ],
        capture_output=True,
        text=True,
        env={
            **os.environ,
            **{name: f"complete_{shell}", "COMP_WORDS": words, "COMP_CWORD": "2"},
            **{"_TYPER_COMPLETE_ARGS": words, "_TYPER_COMPLETE_FISH_ACTION": "get-args"},
        },
        check=False,
    )
    assert [x for x in ("lever", "loop", "notes") if f"scenes/{x}.t" in done.stdout] == [
        "lever",
        "loop",
    ]
