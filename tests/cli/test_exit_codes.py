"""Exit codes of every command: 0, 1 disagreement, 2 bad input, 3 a motion that stopped, 130."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
import typer.main

import kousoku.ledger
from kousoku.cli.app import app

if TYPE_CHECKING:
    from collections.abc import Callable

    Run = Callable[..., tuple[int, str, str]]

ROOT = Path(__file__).parents[2]
LEVER, PENDULUM = ROOT / "scenes" / "lever_crank.toml", ROOT / "scenes" / "pendulum.toml"
STOPS = ROOT / "tests" / "scenes" / "second_loop_stops.toml"
IN_NUMPY = ("--target", "numpy")

#: For each command: one that succeeds, one with bad input, and what it calls.
COMMANDS: dict[str, tuple[tuple[Any, ...], tuple[Any, ...], str]] = {
    "animate": ((LEVER, *IN_NUMPY), ("nowhere.toml",), "kousoku.loading.load"),
    "cache": ((), ("--everything",), "kousoku.model.files.cache.entries"),
    "check": ((LEVER,), ("nowhere.toml",), "kousoku.model.reading.read.read_scene"),
    "derive": (("n1",), ("n9",), "kousoku.symbolic.derive"),
    "explain": ((LEVER,), ("nowhere.toml",), "kousoku.checking.explain"),
    "generate": (
        ("n1", "--out", "."),
        ("nowhere.toml", "--out", "."),
        "kousoku.codegen.generate.write_tree",
    ),
    "ledger": (("7.19",), ("8.111",), "kousoku.ledger.find"),
    "list": ((), ("all",), "kousoku.cli.listing.generated_packages"),
    "new": (("pendulum",), ("pendulum", "x.txt"), "kousoku.cli.new.template"),
    "schema": ((), ("--json", "nothing"), "kousoku.model.reading.schema.schema_text"),
    "simulate": (
        (LEVER, "--end", 0.1, *IN_NUMPY),
        (LEVER, "--end", -1, *IN_NUMPY),
        "kousoku.loading.load",
    ),
    "solve": ((LEVER, *IN_NUMPY), (PENDULUM, *IN_NUMPY), "kousoku.loading.load"),
    "verify": (("n1", *IN_NUMPY), ("nowhere.toml",), "kousoku.cli.verify.find_packages"),
}


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_every_command_is_in_these_tests() -> None:
    group: Any = typer.main.get_command(app)
    commands = group.commands
    assert sorted(COMMANDS) == sorted(commands)


def test_exit_codes_are_told(run: Run) -> None:
    told = " ".join(run("--help")[1].split())
    codes = (
        "0 all is well",
        "1 emitted",
        "2 bad input",
        "130 Ctrl-C",
        "141 a pipe that was closed",
    )
    assert all(code in told for code in codes)
    assert "3 a motion that stopped or cannot be trusted" in told


@pytest.mark.parametrize("command", COMMANDS)
def test_success_bad_input_and_wrong_usage(run: Run, command: str) -> None:
    good, bad, _ = COMMANDS[command]
    assert run(command, *good)[0] == 0
    code, _, err = run(command, *bad)
    assert code == 2
    assert "Traceback" not in err
    code, out, err = run(command, *good, "--no-such-option")
    assert (code, out) == (2, "")
    assert "--no-such-option" in err


@pytest.mark.parametrize("command", COMMANDS)
def test_an_interrupt_is_130(run: Run, monkeypatch: pytest.MonkeyPatch, command: str) -> None:
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    good, _, called = COMMANDS[command]
    monkeypatch.setattr(called, interrupted)
    code, out, err = run(command, *good)
    assert (code, out) == (130, "")
    assert "Traceback" not in err


@pytest.mark.skipif(os.name == "nt", reason="pipes end in other ways there")
@pytest.mark.parametrize("arguments", [["list"], ["schema"], ["--help"], ["simulate", "--help"]])
def test_a_reader_that_has_seen_enough_is_141_and_no_disagreement(arguments: list[str]) -> None:
    reading, writing = os.pipe()
    os.close(reading)
    command = [sys.executable, "-m", "kousoku", *arguments]
    done = subprocess.run(command, stdout=writing, stderr=subprocess.PIPE, text=True, check=False)
    os.close(writing)
    assert (done.returncode, done.stderr) == (141, "")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="a device of Linux")
@pytest.mark.parametrize("arguments", [["list"], ["schema"], ["--help"], ["check", str(LEVER)]])
def test_a_full_disk_is_told_of_what_is_printed(arguments: list[str]) -> None:
    command = [sys.executable, "-m", "kousoku", *arguments]
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    told = "kousoku: standard output: cannot be written: No space left on device\n"
    assert (done.returncode, done.stderr) == (2, told)


def test_what_the_system_refuses_begins_with_its_path(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(tmp_path / "kernels.c"))

    monkeypatch.setattr("kousoku.codegen.generate.write_tree", refuse)
    code, _, told = run("generate", "n1", "--out", tmp_path)
    assert (code, told) == (2, f"kousoku: {tmp_path / 'kernels.c'}: {os.strerror(errno.ENOSPC)}\n")


@pytest.mark.parametrize(
    "command",
    [
        ("solve", STOPS, *IN_NUMPY),
        ("simulate", STOPS, "--end", 10, *IN_NUMPY),
        ("animate", STOPS, *IN_NUMPY),
        ("simulate", PENDULUM, "--end", 9, "--most-steps", 3, *IN_NUMPY),
    ],
)
@pytest.mark.usefixtures("numpy_solver")
def test_a_motion_that_stopped_is_3(run: Run, command: tuple[Any, ...]) -> None:
    code, _, err = run(*command)
    assert code == 3
    assert err.strip().count("\n") <= 1  # beside it, that NumPy takes longer
    assert f"kousoku: {command[1]}: " in err


def test_c_that_cannot_be_checked_is_2_and_no_disagreement(
    run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("KOUSOKU_CC", "none")
    code, out, err = run("verify", "n1", "--target", "c")
    assert (code, out) == (2, "")
    assert err == "kousoku: KOUSOKU_CC=none switches the C compiler off\n"


def test_a_disagreement_is_1(run: Run, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert run("generate", "n1", "--check", "--out", folder)[0] == 1
    run("generate", "n1", "--out", folder)
    formulas = folder / "n1" / "kernels.py"
    formulas.write_text(formulas.read_text(encoding="utf-8") + "# other\n", encoding="utf-8")
    assert run("verify", folder / "n1", *IN_NUMPY)[0] == 1
    wrong = replace(kousoku.ledger.find("7.19"), verdict="notation")
    monkeypatch.setattr(kousoku.ledger, "find", lambda _: wrong)
    assert run("ledger", "7.19")[0] == 1


@pytest.mark.usefixtures("numpy_solver")
def test_events_without_a_value_are_refused_and_stop_a_motion(run: Run, folder: Path) -> None:
    scene = (ROOT / "scenes" / "bouncing_ball.toml").read_text(encoding="utf-8")
    scene += '[events.lost]\nwhen = "WHEN"\n'
    for when, code, words in (
        ("log(z - 50)", 2, "has no finite value where the run starts"),
        ("sqrt(z)", 3, "has no finite value from here on"),
    ):
        (folder / "lost.toml").write_text(scene.replace("WHEN", when), encoding="utf-8")
        got, _, err = run("simulate", "lost.toml", "--samples", 2, *IN_NUMPY)
        assert got == code
        assert f"events.lost: {when} {words}" in " ".join(err.split())
        got, out, _ = run("check", "lost.toml")
        assert got == (2 if code == 2 else 0)
        is_told = f"events.lost.when: {when} has no finite value where the scene starts" in out
        assert is_told == (code == 2)
