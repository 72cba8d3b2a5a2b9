"""The solver of a scene of bodies in programs of C and C++, without Python."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.model.reading.families import chain, n_four_bar
from kousoku.model.reading.read import read_scene
from kousoku.runtime.dynamics import load_dynamics
from kousoku.runtime.integrate.settings import Doubt
from tests.programs import STRICT, compiled, compiled_as_cpp, compiled_with_sanitizers

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.runtime.toolchain import Toolchain

    Folder = Callable[..., Path]

ROOT = Path(__file__).parents[2]
EXAMPLE = ROOT / "docs" / "examples" / "pendulum.c"
ALL = ("accelerations", "reactions", "energies")
MAKERS: dict[str, Callable[[], Any]] = {
    "pendulum": lambda: read_scene(ROOT / "scenes" / "pendulum.toml"),
    "free_body": lambda: read_scene(ROOT / "scenes" / "free_body.toml"),
    "heavy_top": lambda: read_scene(ROOT / "scenes" / "heavy_top.toml"),
    "point": lambda: read_scene(ROOT / "scenes" / "pendulum_on_a_rod.toml"),
    "four_bars": lambda: n_four_bar(2),
    "chain": lambda: chain(10),
}


def copied(folder: Path, place: Path, main: str) -> None:
    """Copy the solver, and the example as the main program."""
    for name in ("solver.c", "solver.h"):
        shutil.copy(folder / name, place)
    shutil.copytree(folder / "integrate", place / "integrate")
    shutil.copy(EXAMPLE, place / main)


def assert_moves_the_pendulum(program: Path, folder: Path) -> None:
    run = subprocess.run([program], capture_output=True, text=True, check=True)
    assert run.stderr.startswith("trusted: doubts 0, energy off by ")
    got = np.array([[float(x) for x in line.split()] for line in run.stdout.splitlines()])
    solver = load_dynamics(folder)
    motion = solver.simulate(10, samples=11, tolerance=1e-12)
    centre = 0.75 * motion.position["rod"][:, :2]
    assert got.shape == (11, 3)
    np.testing.assert_allclose(got[:, 0], motion.time, rtol=0, atol=0)
    np.testing.assert_allclose(got[:, 1:], centre, rtol=0, atol=1e-9)
    assert np.ptp(got[:, 1]) > 0.5


def test_example_is_at_most_thirty_lines() -> None:
    assert len(EXAMPLE.read_text(encoding="utf-8").splitlines()) <= 32


def test_example_moves_the_pendulum(
    compiler: Toolchain, bodies_folder: Folder, tmp_path: Path
) -> None:
    folder = bodies_folder(MAKERS["pendulum"]())
    copied(folder, tmp_path, "main.c")
    compiled(compiler, tmp_path, "-std=c99", *STRICT, "main.c", "solver.c", "-lm", "-o", "program")
    assert_moves_the_pendulum(tmp_path / "program", folder)


def test_example_ends_with_3_and_the_doubts_of_a_run_that_is_wrong(
    compiler: Toolchain, bodies_folder: Folder, tmp_path: Path
) -> None:
    copied(bodies_folder(MAKERS["pendulum"]()), tmp_path, "main.c")
    main = tmp_path / "main.c"
    text = main.read_text(encoding="utf-8")
    assert "{ 1e-12, 1e300, 0, 1, 1 }" in text
    main.write_text(text.replace("1e300, 0, 1", "1e300, 0.5, 1"), encoding="utf-8")
    compiled(compiler, tmp_path, "main.c", "solver.c", "-lm", "-o", "program")
    run = subprocess.run([tmp_path / "program"], capture_output=True, text=True, check=False)
    told = re.match(r"not trusted: doubts (\d+), energy off by (\S+) J, wanted at", run.stderr)
    assert told is not None
    assert run.returncode == 3
    assert Doubt.ENERGY in Doubt(int(told[1]))
    assert float(told[2]) > 1e-3


def test_example_compiles_as_cpp_too(
    compiler: Toolchain, bodies_folder: Folder, tmp_path: Path
) -> None:
    folder = bodies_folder(MAKERS["pendulum"]())
    copied(folder, tmp_path, "main.cpp")
    compiled_as_cpp(compiler, tmp_path)
    assert_moves_the_pendulum(tmp_path / "program", folder)


def test_example_is_clean_under_sanitizers(
    compiler: Toolchain, bodies_folder: Folder, tmp_path: Path
) -> None:
    folder = bodies_folder(MAKERS["pendulum"]())
    copied(folder, tmp_path, "main.c")
    compiled_with_sanitizers(compiler, tmp_path)
    assert_moves_the_pendulum(tmp_path / "program", folder)


@pytest.mark.parametrize(
    ("name", "outputs"),
    [("pendulum", ()), *((name, ALL) for name in MAKERS)],
    ids=lambda x: x if isinstance(x, str) else "all" if x else "bare",
)
def test_solver_is_strict_c_without_state_and_heap(
    compiler: Toolchain,
    bodies_folder: Folder,
    tmp_path: Path,
    name: str,
    outputs: tuple[str, ...],
) -> None:
    folder = bodies_folder(MAKERS[name](), outputs)
    output = tmp_path / "solver.o"
    flags = ("-std=c99", "-O2", "-fno-pic", "-fno-pie", *STRICT)
    compiled(compiler, folder, *flags, "-c", "solver.c", "-o", str(output))
    nm = shutil.which("nm")
    if nm is None:
        pytest.skip("no nm")
    lines = subprocess.run([nm, output], capture_output=True, text=True, check=True).stdout
    symbols = [line.split()[-2:] for line in lines.splitlines()]
    assert not [name for kind, name in symbols if kind in "bBdDC"]
    assert not {"malloc", "calloc", "realloc", "free"} & {name for _, name in symbols}
