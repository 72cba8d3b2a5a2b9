"""The emitted solver in programs of C and C++, without Python."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from kousoku.generated import lever_crank
from kousoku.model.reading.read import read_scene
from tests.programs import STRICT, compiled, compiled_as_cpp, compiled_with_sanitizers

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.model.records.scene import Scene
    from kousoku.runtime.toolchain import Toolchain

ROOT = Path(__file__).parents[2]
EXAMPLE = ROOT / "docs" / "examples" / "lever_crank.c"
SCENES = ("piston_crank", "lever_crank", "five_bar", "watt_six_bar", "stephenson_six_bar")
#: A slider and two loops; the others are compiled for a release.
ALWAYS = ("piston_crank", "watt_six_bar")


@pytest.fixture
def folder(folder_of: Callable[[Scene], Path]) -> Path:
    return folder_of(read_scene(ROOT / "scenes" / "lever_crank.toml"))


def copy_sources(folder: Path, place: Path) -> None:
    """Copy what a program of C needs of a folder."""
    for name in ("solver.c", "solver.h"):
        shutil.copy(folder / name, place)
    shutil.copytree(folder / "kinematics", place / "kinematics")


def printed(program: Path) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    run = subprocess.run([program], capture_output=True, text=True, check=True)
    return np.array([[float(x) for x in line.split()] for line in run.stdout.splitlines()])


def assert_is_the_lever_crank(table: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> None:
    motion = lever_crank.solve()
    assert table.shape == (61, 5)
    np.testing.assert_allclose(table[:, 1:3], motion.positions["O3"], rtol=0, atol=4e-13)
    np.testing.assert_allclose(table[:, 3:5], motion.velocities["O3"], rtol=0, atol=1e-12)


def test_example_is_at_most_thirty_lines() -> None:
    assert len(EXAMPLE.read_text(encoding="utf-8").splitlines()) <= 30


def test_example_compiles_with_the_plain_command_and_solves(
    compiler: Toolchain, folder: Path, tmp_path: Path
) -> None:
    copy_sources(folder, tmp_path)
    shutil.copy(EXAMPLE, tmp_path / "main.c")
    compiled(compiler, tmp_path, "main.c", "solver.c", "-lm", "-o", "program")
    assert_is_the_lever_crank(printed(tmp_path / "program"))


def test_example_compiles_as_cpp_too(compiler: Toolchain, folder: Path, tmp_path: Path) -> None:
    copy_sources(folder, tmp_path)
    shutil.copy(EXAMPLE, tmp_path / "main.cpp")
    compiled_as_cpp(compiler, tmp_path)
    assert_is_the_lever_crank(printed(tmp_path / "program"))


def test_example_is_clean_under_sanitizers(
    compiler: Toolchain, folder: Path, tmp_path: Path
) -> None:
    copy_sources(folder, tmp_path)
    shutil.copy(EXAMPLE, tmp_path / "main.c")
    compiled_with_sanitizers(compiler, tmp_path)
    assert_is_the_lever_crank(printed(tmp_path / "program"))


@pytest.mark.parametrize(
    "name",
    [x if x in ALWAYS else pytest.param(x, marks=pytest.mark.release) for x in SCENES],
)
def test_solvers_compile_without_a_warning(
    compiler: Toolchain, folder_of: Callable[[Scene], Path], tmp_path: Path, name: str
) -> None:
    folder = folder_of(read_scene(ROOT / "scenes" / f"{name}.toml"))
    output = str(tmp_path / "object.o")
    compiled(compiler, folder, "-std=c99", "-O2", *STRICT, "-c", "solver.c", "-o", output)


@pytest.mark.parametrize("name", SCENES)
def test_solvers_have_no_state_and_no_heap(
    compiler: Toolchain, folder_of: Callable[[Scene], Path], tmp_path: Path, name: str
) -> None:
    folder = folder_of(read_scene(ROOT / "scenes" / f"{name}.toml"))
    nm = shutil.which("nm")
    if nm is None:
        pytest.skip("no nm")
    output = tmp_path / "solver.o"
    flags = (
        "-std=c99",
        "-O2",
        "-fno-pic",
        "-fno-pie",
    )  # else tables of strings wait for an address
    compiled(compiler, folder, *flags, "-c", "solver.c", "-o", str(output))
    lines = subprocess.run([nm, output], capture_output=True, text=True, check=True).stdout
    symbols = [line.split()[-2:] for line in lines.splitlines()]
    assert not [name for kind, name in symbols if kind in "bBdDC"]
    assert not {"malloc", "calloc", "realloc", "free"} & {name for _, name in symbols}
