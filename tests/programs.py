"""Programs of C and C++ that tests compile: a solver in a folder, and what calls it."""

from __future__ import annotations

import shutil
import subprocess
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from pathlib import Path

    from kousoku.runtime.toolchain import Toolchain

#: No compiler may warn of anything.
STRICT = ("-Wall", "-Wextra", "-Wpedantic", "-Wshadow", "-Wconversion", "-Werror")


def compiled(compiler: Toolchain, folder: Path, *flags: str) -> None:
    """Run the compiler in a folder."""
    run = subprocess.run(
        (*compiler.command, *flags), cwd=folder, capture_output=True, text=True, check=False
    )
    assert run.returncode == 0, run.stderr


def compiled_as_cpp(compiler: Toolchain, folder: Path) -> None:
    """Compile ``main.cpp``; without a compiler of C++ the test is skipped."""
    cpp = shutil.which("c++") or shutil.which("g++") or shutil.which("clang++")
    if cpp is None:
        pytest.skip("no C++ compiler")
    compiled(compiler, folder, "-c", "solver.c", "-o", "solver.o")
    flags = ("-std=c++11", "-Wall", "-Wextra", "-Wpedantic", "-Werror")
    subprocess.run(
        [cpp, *flags, "main.cpp", "solver.o", "-lm", "-o", "program"], cwd=folder, check=True
    )


def compiled_with_sanitizers(compiler: Toolchain, folder: Path) -> None:
    """Compile ``main.c`` with sanitizers; where there are none the test is skipped."""
    sanitizers = ("-g", "-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
    run = subprocess.run(
        (*compiler.command, *sanitizers, "main.c", "solver.c", "-lm", "-o", "program"),
        cwd=folder,
        capture_output=True,
        check=False,
    )
    if run.returncode != 0:
        pytest.skip("the compiler has no sanitizers")
