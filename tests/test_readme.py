"""The README tells the truth: its programs run and print what stands there, its links lead on."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from kousoku.codegen.dynamics.generate import generate_dynamics
from kousoku.codegen.generate import write_tree
from kousoku.model.read import scene_from_toml
from kousoku.runtime.dynamics import load_dynamics
from kousoku.symbolic import KINDS

if TYPE_CHECKING:
    from kousoku.runtime.toolchain import Toolchain

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))]
LEVER = ROOT / "generated" / "lever_crank"


def blocks(language: str) -> list[tuple[str, str]]:
    """Return the fenced blocks of a language, each with the text block that follows it."""
    fence = rf"```{language}\n(.*?)```\n(?:\n```text\n(.*?)```)?"
    return [(code, shown) for code, shown in re.findall(fence, README, re.DOTALL)]


def test_the_two_commands_are_the_first_lines() -> None:
    lines = README.splitlines()[:4]
    assert lines[1].startswith("make demo") and lines[2].startswith("make test")


@pytest.mark.usefixtures("compiler")
def test_the_python_example_prints_what_stands_below_it() -> None:
    ((code, shown),) = blocks("python")
    assert len(code.splitlines()) <= 15
    run = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT
    )
    assert run.stdout == shown


def program(folder: Path) -> tuple[Path, str]:
    """Lay out the C program beside the solver's files; return it and what it prints."""
    ((code, shown),) = blocks("c")
    assert len(code.splitlines()) <= 30
    for name in ("kernels.c", "expressions.h", "kernels.h"):
        shutil.copy(LEVER / name, folder / name)
    shutil.copytree(LEVER / "kinematics", folder / "kinematics")
    main = folder / "main.c"
    main.write_text(code, encoding="utf-8")
    return main, shown


def numbers(text: str) -> np.ndarray:
    return np.array([[float(word) for word in line.split()] for line in text.splitlines()])


@pytest.mark.parametrize("flags", [(), ("-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror")])
def test_the_c_program_compiles_and_solves_the_lever_crank(
    compiler: Toolchain, tmp_path: Path, flags: tuple[str, ...]
) -> None:
    main, shown = program(tmp_path)
    command = [*compiler.command, *flags, main.name, "kernels.c", "-lm", "-o", "solve"]
    built = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (built.returncode, built.stderr) == (0, "")
    run = subprocess.run([tmp_path / "solve"], capture_output=True, text=True, check=True)
    np.testing.assert_allclose(numbers(run.stdout), numbers(shown), rtol=0, atol=2e-9)


def test_the_c_program_compiles_as_cpp(compiler: Toolchain, tmp_path: Path) -> None:
    cpp = shutil.which("c++") or shutil.which("g++") or shutil.which("clang++")
    if cpp is None:
        pytest.skip("no C++ compiler here")
    main, shown = program(tmp_path)
    main.rename(tmp_path / "main.cpp")
    for command in (
        [*compiler.command, "-c", "kernels.c"],
        [cpp, "-Wall", "-Wextra", "-Werror", "main.cpp", "kernels.o", "-lm", "-o", "solve"],
    ):
        subprocess.run(command, cwd=tmp_path, check=True)
    run = subprocess.run([tmp_path / "solve"], capture_output=True, text=True, check=True)
    np.testing.assert_allclose(numbers(run.stdout), numbers(shown), rtol=0, atol=2e-9)


def test_the_driven_loop_closes_and_its_motor_lifts_the_bodies(
    compiler: Toolchain, tmp_path: Path
) -> None:
    """With the crank at α and the rocker at φ the ends of the coupler stay √10 m apart."""
    ((code, _),) = blocks("toml")
    assert len(code.splitlines()) <= 20
    (tmp_path / "loop").mkdir()
    write_tree(tmp_path / "loop", generate_dynamics(scene_from_toml(code)))
    motion = load_dynamics(tmp_path / "loop").simulate(2, samples=21, parameters={"speed": 2.0})
    alpha, phi = 2.0 * motion.time, motion.coordinate["rocking"]
    crank = np.array([0 * alpha, np.cos(alpha), np.sin(alpha)])
    rocker = np.array([3 - 2 * np.sin(phi), 2 * np.cos(phi), 0 * phi])
    assert np.abs(np.sum((crank - rocker) ** 2, axis=0) - 10).max() < 1e-13
    assert np.abs(phi).max() > 0.6
    assert motion.torque["motor"][0] == pytest.approx([9.81 * (2 / 2 + 3 / 2), 0, 0], abs=1e-9)


def test_the_table_of_kinds_is_complete() -> None:
    rows = re.findall(r"^\| `(\w+)`", README, re.MULTILINE)
    assert rows == list(KINDS)


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.stem)
def test_every_link_inside_the_project_leads_somewhere(path: Path) -> None:
    prose = re.sub(r"```.*?```|\$[^$\n]*\$", "", path.read_text(encoding="utf-8"), flags=re.DOTALL)
    for target in re.findall(r"\]\(([^)#]+)[^)]*\)", prose):
        assert "://" in target or (path.parent / target).exists(), target


def test_the_steps_of_ci_are_targets_of_the_makefile_and_tasks() -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    ci = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    steps = re.search(r"^for step in (.*); do$", ci, re.MULTILINE)
    targets = [
        name
        for _, names in re.findall(r"^(TASKS|TESTED) := (.*)$", makefile, re.MULTILINE)
        for name in names.split()
    ]
    usage = subprocess.run(
        [sys.executable, ROOT / "tasks.py", "--help"], capture_output=True, text=True, check=True
    ).stderr
    tasks = re.findall(r"^  (\S+)", usage, re.MULTILINE)
    assert steps is not None
    assert {*steps[1].split(), "demo", "notebooks"} <= set(tasks)
    assert sorted(targets) == sorted(tasks)
