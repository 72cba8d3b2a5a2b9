"""The same bytes under every hash seed, BLAS, supported SymPy, with and without gmpy2."""

from __future__ import annotations

import os
import subprocess
import sys
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from pathlib import Path

#: One kind of each style of formulas: vectors, quotients and angles, sums over bodies.
KINDS = ("p1", "link", "mass_points")

WHICH = "import sympy, mpmath.libmp; print(sympy.__version__, mpmath.libmp.BACKEND)"

#: What is laid over the environment of the tests, and what must then be found there.
ENVIRONMENTS = {
    "oldest SymPy, no gmpy2": (("sympy==1.13.*",), "1.13", "python"),
    "newest SymPy, gmpy2": (("sympy==1.14.*", "gmpy2"), "1.14", "gmpy"),
}


def run(*arguments: str, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, *arguments],
        env=os.environ | environment,
        capture_output=True,
        text=True,
        check=False,
    )


def contents(folder: Path) -> dict[str, bytes]:
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def test_every_hash_seed_gives_the_same_bytes(tmp_path: Path) -> None:
    found = []
    for seed in ("0", "1", "1981"):
        out = tmp_path / seed
        result = run(
            *("-m", "kousoku", "generate", *KINDS, "--out", str(out)),
            PYTHONHASHSEED=seed,
            KOUSOKU_CACHE=str(tmp_path / f"cache {seed}"),
        )
        assert result.returncode == 0, result.stderr
        found.append(contents(out))
    assert len(found[0]) == 11 * len(KINDS)
    assert found[0] == found[1] == found[2]


@pytest.mark.parametrize("core", ["Prescott", "Haswell", "Zen"])
def test_a_scene_has_the_committed_bytes_whatever_the_kernels_of_blas(
    core: str, tmp_path: Path
) -> None:
    """OpenBLAS rounds in another order for each sort of processor."""
    result = run(
        *("-m", "kousoku", "generate", "--check", "pendulum"),
        OPENBLAS_CORETYPE=core,
        KOUSOKU_CACHE=str(tmp_path / "cache"),
    )
    assert result.returncode == 0, result.stdout + result.stderr


def lay_over(folder: Path, requirements: tuple[str, ...]) -> None:
    """Install packages into a folder of their own, which wins over what is installed."""
    result = run(
        *("-m", "pip", "install", "--quiet", "--disable-pip-version-check"),
        *("--no-deps", "--only-binary", ":all:", "--target", str(folder), *requirements),
    )
    if result.returncode != 0:
        pytest.skip(f"pip cannot install {' '.join(requirements)} here: {result.stderr[-300:]}")


@pytest.mark.parametrize("name", ENVIRONMENTS)
def test_every_supported_environment_gives_the_committed_bytes(name: str, tmp_path: Path) -> None:
    requirements, sympy, backend = ENVIRONMENTS[name]
    lay_over(tmp_path / "site", requirements)
    environment = {
        "PYTHONPATH": str(tmp_path / "site"),
        "PYTHONHASHSEED": "7",
        "KOUSOKU_CACHE": str(tmp_path / "cache"),
    }
    which = run("-c", WHICH, **environment).stdout
    assert which.startswith(sympy)
    assert backend in which
    result = run("-m", "kousoku", "generate", "--check", **environment)
    assert result.returncode == 0, result.stdout + result.stderr
