"""``kousoku simulate``: what it prints, writes and refuses, and what it keeps of a broken run."""

from __future__ import annotations

import json
import re
import signal
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.runtime.dynamics import DynamicsSolver

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.runtime.integrate.motion import Motion
    from kousoku.runtime.toolchain import Toolchain

    Run = Callable[..., tuple[int, str, str]]

ROOT = Path(__file__).parents[2]
PENDULUM = ROOT / "scenes" / "pendulum.toml"
FREE = ROOT / "scenes" / "free_body.toml"
BODY = ("x", "y", "z", "e0", "e1", "e2", "e3", "vx", "vy", "vz", "omega_x", "omega_y", "omega_z")
PHASES = ("load",)
WANTED = ("--output", "reactions", "--output", "energies")

pytestmark = pytest.mark.usefixtures("needs_compiler")


@pytest.fixture
def needs_compiler(compiler: Toolchain) -> Toolchain:
    return compiler


def test_ledger_of_the_run_is_printed_below_the_rows(run: Run) -> None:
    code, out, err = run("simulate", PENDULUM, "--end", 2)
    assert (code, err) == (0, "")
    for text in (
        "dop853, tolerance 1e-09:",
        "rejected",
        "energy 0 J at the start, largest change",
        "left of the constraints, position:",
        "left of the constraints, acceleration:",
        *PHASES,
    ):
        assert text in out
    assert "pivot ratio" not in out  # no rows are solved for
    code, out, _ = run("simulate", PENDULUM.with_stem("n_four_bar"), "--end", 1, "--samples", 2)
    assert (code, "smallest pivot ratio" in out) == (0, True)


def test_strict_refuses_a_start_that_assembly_changed(run: Run, tmp_path: Path) -> None:
    text = PENDULUM.read_text(encoding="utf-8")
    moved = tmp_path / "pendulum.toml"
    started = text.replace("mass = 1", "velocity = [1, 2, 0]\nmass = 1")
    moved.write_text(started, encoding="utf-8")
    code, out, _ = run("simulate", moved, "--end", 1, "--samples", 2)
    assert (code, "assembly changed bodies.rod: velocity by 1 m/s" in out) == (0, True)
    code, _, err = run("simulate", moved, "--end", 1, "--samples", 2, "--strict")
    assert (code, "strict refuses that" in err) == (2, True)
    assert run("simulate", PENDULUM, "--end", 1, "--samples", 2, "--strict")[0] == 0


@pytest.mark.parametrize("samples", [2, 13, 14, 102])
def test_the_table_has_at_most_13_rows_and_the_last_of_them(run: Run, samples: int) -> None:
    code, out, _ = run("simulate", PENDULUM, "--end", 2, "--samples", samples)
    lines = out.splitlines()
    head = next(k for k, line in enumerate(lines) if line.split()[:1] == ["time"])
    numbers = [line for line in lines[head + 1 :] if re.match(r" *\d+\.\d{9} ", line)]
    assert code == 0
    assert len(numbers) == {2: 2, 13: 13, 14: 8, 102: 13}[samples]
    assert float(numbers[-1].split()[0]) == 2.0


def test_json_has_the_ledger(run: Run) -> None:
    code, out, _ = run("simulate", PENDULUM, "--end", 2, "--samples", 5, "--json")
    data = json.loads(out)
    assert code == 0
    assert data["rows"] == 5
    assert data["is_complete"] is True
    ledger = data["ledger"]
    assert ledger["steps"] > 10
    assert 0 < ledger["energy_error"] < 1e-6
    assert list(ledger["violations"]) == ["hinge"]
    assert 0 < ledger["violations"]["hinge"]["metres"][2] < 1e-12
    assert max(ledger["violations"]["hinge"]["metres"]) < 1e-12
    assert set(data["seconds"]) == {*PHASES, "start", "run"}


@pytest.mark.parametrize("suffix", ["csv", "npz"])
def test_file_has_a_column_for_all_that_is_wanted(run: Run, tmp_path: Path, suffix: str) -> None:
    out = tmp_path / f"pendulum.{suffix}"
    assert run("simulate", PENDULUM, "--end", 1, "--samples", 3, "--out", out, *WANTED)[0] == 0
    names = ["time", *(f"rod.{name}" for name in BODY)]
    names += [f"hinge.{name}" for name in ("fx", "fy", "fz", "mx", "my", "mz")]
    names += ["energy.kinetic", "energy.potential", "energy.total"]
    if suffix == "csv":
        assert out.read_text(encoding="utf-8").splitlines()[0].split(",") == names
        table = dict(zip(names, np.loadtxt(out, delimiter=",", skiprows=1).T, strict=True))
    else:
        with np.load(out) as columns:
            table = dict(columns)
        assert [name for name in table if not name.startswith("kousoku")] == names
    assert table["hinge.fy"][0] == pytest.approx(9.81 / 4)
    np.testing.assert_allclose(table["energy.total"], 0.0, atol=1e-8)


def test_run_without_end_of_steps_keeps_its_rows_in_the_file(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    begin = DynamicsSolver.begin
    monkeypatch.setattr(
        DynamicsSolver, "begin", lambda *a, **options: begin(*a, most_steps=20, **options)
    )
    out = tmp_path / "part.csv"
    code, _, err = run("simulate", PENDULUM, "--end", 100, "--out", out)
    assert code == 3
    assert "20 steps are made" in err
    assert f"what was computed before is in {out}" in err
    assert 2 < len(out.read_text(encoding="utf-8").splitlines()) < 1002


@pytest.mark.usefixtures("interrupts")
def test_interrupt_keeps_its_rows_in_the_file(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    simulate = DynamicsSolver.simulate

    def pressed(solver: DynamicsSolver, end: float, **options: Any) -> Motion:
        options["progress"] = lambda *_: signal.raise_signal(signal.SIGINT)
        return simulate(solver, end, **options)

    monkeypatch.setattr(DynamicsSolver, "simulate", pressed)
    out = tmp_path / "part.csv"
    code, _, err = run("simulate", PENDULUM, "--end", 100, "--out", out)
    assert code == 130
    assert "stopped at t = " in err
    assert f"what was computed before is in {out}" in err
    assert 2 < len(out.read_text(encoding="utf-8").splitlines()) < 1002


def test_progress_is_shown_on_a_terminal_only(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(type(sys.stderr), "isatty", lambda _: True)
    _, out, err = run("simulate", PENDULUM, "--end", 3, "--json")
    assert " s of 3 s" in err
    assert json.loads(out)["rows"] == 1001


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (("--end", 0), "end 0.0; wanted one above 0, in seconds"),
        (("--end", 1, "--tolerance", 0), "tolerance 0.0; wanted one from 1e-15, below 1\n"),
        (("--end", 1, "--body", "bob"), "no body 'bob': there are rod"),
        (("--end", 1, "--out", "rows.txt"), "must end in"),
        (("--end", 1, "--body", "rood"), "no body 'rood': there are rod; did you mean 'rod'?"),
        (("--end", 1, "--output", "angles"), "angles"),
        (("--end", 1, "--set", "mass=1", "--set", "mass=2"), "--set mass=2: mass is given twice"),
        (("--end", 1, "--initial", "a=1", "--initial", "a=2"), "--initial a=2: a is given twice"),
    ],
)
def test_options_that_are_not_possible_are_refused(
    run: Run, options: tuple[object, ...], says: str
) -> None:
    code, _, err = run("simulate", PENDULUM, *options)
    assert code == 2
    assert says in err


def test_a_linkage_follows_its_inputs_in_time(run: Run, tmp_path: Path) -> None:
    out = tmp_path / "lever.csv"
    scene = ROOT / "scenes" / "lever_crank.toml"
    code, printed, err = run("simulate", scene, "--end", 1, "--samples", 5, "--out", out)
    assert (code, err) == (0, "")
    rows = np.genfromtxt(out, delimiter=",", names=True, deletechars="")
    np.testing.assert_allclose(rows["time"], np.linspace(0, 1, 5))
    assert "newton by c: 5 positions" in printed and "time [s]" in printed
    code, _, err = run("simulate", scene, "--end", 1, "--tolerance", 1e-6)
    assert (code, "tolerance is an option of scenes of bodies" in err) == (2, True)


CRANK = """
name = "crank"
unit = "m"
[parameters]
rate = 4
phase = 0.5
[bodies.arm]
position = [0, 0, 0]
boxes = [{ mass = 2, size = [1, 0.1, 0.1], at = [0.5, 0, 0] }]
[joints.hinge]
type = "revolute"
bodies = ["ground", "arm"]
at = [0, 0, 0]
axis = [0, 0, 1]
[drivers]
motor = { joint = "hinge", value = "rate*t + phase" }
"""


@pytest.fixture
def crank(tmp_path: Path) -> Path:
    path = tmp_path / "crank.toml"
    path.write_text(CRANK, encoding="utf-8")
    return path


def test_parameters_of_a_run_are_set_and_reported(run: Run, crank: Path, tmp_path: Path) -> None:
    out = tmp_path / "rows.csv"
    for given, rate in ((), 4.0), (("--set", "rate=9"), 9.0):
        options = ("--end", 1, "--samples", 2, "--out", out, "--json")
        code, printed, err = run("simulate", crank, *options, *given)
        assert (code, err) == (0, "")
        assert json.loads(printed)["ledger"]["parameters"] == {"rate": rate, "phase": 0.5}
        rows = np.genfromtxt(out, delimiter=",", names=True, deletechars="")
        np.testing.assert_allclose(rows["arm.omega_z"], rate, rtol=1e-14)
        np.testing.assert_allclose(np.abs(rows["arm.e0"]), np.abs(np.cos([0.25, (rate + 0.5) / 2])))


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (
            ("--set", "raet=2"),
            "no parameter 'raet': its formulas have rate, phase; did you mean 'rate'?",
        ),
        (("--set", "rate=nan"), "parameter rate is nan, wanted a finite number"),
        (("--set", "rate"), "wanted a name, = and a number"),
        (("--step", "-1"), "step -1.0; wanted seconds, above 0"),
        (("--step", "0.1"), "the method 'kinematics' goes from one time to the next"),
    ],
)
def test_what_a_run_cannot_take_is_one_line(
    run: Run, crank: Path, options: tuple[str, ...], says: str
) -> None:
    code, out, err = run("simulate", crank, "--end", 1, *options)
    assert (code, out) == (2, "")
    assert err.count("\n") == 1 and says in err


def test_kinematics_is_refused_where_the_motion_is_free(run: Run) -> None:
    code, _, err = run("simulate", PENDULUM, "--end", 1, "--method", "kinematics")
    assert code == 2
    assert "wanted dopri5 or dop853, or more drivers" in err


def test_plots_are_drawn_into_the_folder(run: Run, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    code, out, _ = run(
        *("simulate", PENDULUM, "--end", 1, "--samples", 5, "--output", "energies"),
        *("--plot", tmp_path / "plots"),
    )
    assert code == 0
    files = sorted(path.name for path in (tmp_path / "plots").iterdir())
    assert files == ["pendulum_energies.svg", "pendulum_rod.svg"]
    assert all(f"wrote {tmp_path / 'plots' / name}" in out for name in files)


def test_steps_of_a_fixed_length_are_told_in_the_ledger(run: Run) -> None:
    _, out, _ = run("simulate", PENDULUM, "--end", 1, "--step", 0.01)
    assert "steps of 0.01 s without control of the error: 100 steps, 0 rejected" in out


@pytest.mark.parametrize(
    ("output", "says"),
    [("reactions", "no joints and no drivers"), ("coordinates", "no coordinates")],
)
def test_an_output_of_what_there_is_none_of_is_refused(run: Run, output: str, says: str) -> None:
    code, out, err = run("simulate", FREE, "--end", 1, "--output", output)
    assert (code, out) == (2, "")
    assert f"outputs: {output}: the scene has {says}; leave it out" in err


@pytest.mark.parametrize("output", ["energies", "reactions"])
def test_outputs_of_bodies_are_refused_for_linkages_and_theirs_are_there(
    run: Run, output: str
) -> None:
    lever = ROOT / "scenes" / "lever_crank.toml"
    linkage = ("simulate", lever, "--end", 1, "--samples", 2, "--target", "numpy")
    code, out, err = run(*linkage, "--output", output)
    assert (code, out) == (2, "")
    assert f"outputs: {output}: '{output}' is no output of a planar linkage; leave it out" in err
    code, out, _ = run(*linkage, "--output", "angles")
    assert code == 0
    assert out.splitlines()[1].split()[-6::2] == ["l1.angle", "l2.angle", "l3.angle"]


def test_run_that_is_not_trusted_exits_with_3_in_one_line(run: Run) -> None:
    code, out, err = run("simulate", PENDULUM, "--end", 2, "--step", 0.2)
    assert code == 3
    assert len(err.splitlines()) == 1
    assert "not trusted: energy is off by" in err
    assert "not trusted: energy is off by" in out


def test_estimated_error_is_on_the_screen(run: Run) -> None:
    code, out, err = run("simulate", PENDULUM, "--end", 1, "--samples", 5, "--estimate-error")
    assert (code, err) == (0, "")
    assert re.search(r"trust: energy .* · error \S+e-\d+ m, \S+e-\d+ rad", out)


def test_a_run_that_an_event_ends_is_no_failure(run: Run, tmp_path: Path) -> None:
    scene = tmp_path / "swing.toml"
    event = """
[coordinates]
turn = { joint = "pin" }
[events]
through = { when = "turn_dot", action = "count" }
there = { when = "t - 1.25", action = "stop" }
"""
    text = PENDULUM.read_text(encoding="utf-8")
    joint = re.search(r"\[joints\.(\w+)\]|\[joints\]\n(\w+)", text)
    assert joint is not None
    name = joint[1] or joint[2]
    scene.write_text(text + event.replace('"pin"', f'"{name}"'), encoding="utf-8")
    code, out, err = run("simulate", scene, "--end", 2, "--samples", 5)
    assert (code, err) == (0, "")
    assert "ended at t = 1.25 s by events.there" in out
    assert "there 1" in out
    code, out, _ = run("simulate", scene, "--end", 2, "--samples", 5, "--json")
    data = json.loads(out)
    assert (code, data["stopped_by"], data["rows"], data["is_complete"]) == (0, "there", 4, False)
    there = pytest.approx([1.25], rel=4e-16)
    assert data["events"]["there"] == {"action": "stop", "count": 1, "times": there}
    assert data["events"]["through"]["times"] == []
    assert data["ledger"]["events"]["through"] == data["events"]["through"]["count"] > 0
