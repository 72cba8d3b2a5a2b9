"""What is shipped: what a wheel and an sdist hold, and that a wheel runs."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).parents[2]
SHIPPED_SUFFIXES = {
    "codegen": (".py", ".jinja"),
    "generated": (".py", ".c", ".h", ".json"),
    "ledger": (".py", ".json", ".toml"),
    "model": (".py", ".json"),
    "runtime": (".py", ".c", ".h"),
    "symbolic": (".py",),
    "kousoku": (".py", ".typed", ".css", ".html", ".js"),
}
IGNORED = shutil.ignore_patterns(".*cache", ".git", ".venv", "build", "dist", "*.egg-info")


class Distributions(NamedTuple):
    """The names of the files in an sdist, and a wheel unpacked."""

    sdist: list[str]
    wheel: Path


@pytest.fixture(scope="module")
def distributions(tmp_path_factory: pytest.TempPathFactory) -> Distributions:
    """Build an sdist and, from nothing but the sdist, a wheel."""
    folder = tmp_path_factory.mktemp("distributions")
    tree = folder / "tree"
    shutil.copytree(ROOT, tree, symlinks=True, ignore=IGNORED)
    build = "import sys; from setuptools import build_meta as b; b.build_{}(sys.argv[1])"
    run = [sys.executable, "-W", "ignore", "-c"]
    subprocess.run([*run, build.format("sdist"), folder], cwd=tree, check=True, capture_output=True)
    (archive,) = folder.glob("*.tar.gz")
    with tarfile.open(archive) as sdist:
        inside = [name.partition("/")[2] for name in sdist.getnames()]
        sdist.extractall(folder, filter="data")
    unpacked = folder / archive.name.removesuffix(".tar.gz")
    subprocess.run(
        [*run, build.format("wheel"), folder], cwd=unpacked, check=True, capture_output=True
    )
    (wheel,) = folder.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive_of_wheel:
        archive_of_wheel.extractall(folder / "site")
    return Distributions(inside, folder / "site")


def shipped(folder: str) -> list[Path]:
    """Files of a root folder that a wheel must hold, links left out."""
    return [
        path.relative_to(ROOT)
        for path in (ROOT / folder).rglob("*")
        if path.suffix in SHIPPED_SUFFIXES[folder]
        and not any(parent.is_symlink() for parent in path.parents)
    ]


@pytest.mark.parametrize("folder", SHIPPED_SUFFIXES)
def test_the_wheel_holds_all_that_runs(distributions: Distributions, folder: str) -> None:
    parent = "" if folder == "kousoku" else "kousoku"
    wanted = [distributions.wheel / parent / path for path in shipped(folder)]
    assert wanted
    assert not [path for path in wanted if not path.is_file()]


def test_the_wheel_holds_nothing_else(distributions: Distributions) -> None:
    tops = {path.name for path in distributions.wheel.iterdir()}
    assert {top for top in tops if not top.endswith(".dist-info")} == {"kousoku"}


@pytest.mark.parametrize(
    "name",
    [
        "pyproject.toml",
        "README.md",
        "Makefile",
        "build_backend.py",
        "tasks.py",
        "scenes/lever_crank.toml",
        "tests/conftest.py",
    ],
)
def test_the_sdist_is_complete(distributions: Distributions, name: str) -> None:
    assert name in distributions.sdist


@pytest.mark.parametrize("has_links", [True, False])
def test_type_checkers_follow_an_editable_install(tmp_path: Path, has_links: bool) -> None:
    """It is found by a path, not by a finder that runs, in a checkout with links and without."""
    tree, site = tmp_path / "tree", tmp_path / "site"
    shutil.copytree(ROOT, tree, symlinks=True, ignore=IGNORED)
    for link in [path for path in (tree / "kousoku").iterdir() if path.is_symlink()]:
        if not has_links:
            target = link.readlink().as_posix()
            link.unlink()
            link.write_text(target)
    build = "import sys, build_backend as b; b.build_editable(sys.argv[1])"
    run = [sys.executable, "-W", "ignore", "-c", build, str(tmp_path)]
    subprocess.run(run, cwd=tree, check=True, capture_output=True)
    (wheel,) = tmp_path.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(site)
    assert not list(site.rglob("*.py"))
    (pth,) = site.glob("*.pth")
    followed = Path(pth.read_text().strip()) / "kousoku"
    assert (followed / "py.typed").is_file()
    assert (followed / "model" / "reading" / "read.py").is_file()


#: Refuses all that only deriving, emitting and the command line need.
NUMPY_ONLY = """
import sys
class Refuse:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in {"sympy", "mpmath", "jinja2", "msgspec", "typer", "rich"}:
            raise ModuleNotFoundError(name)
sys.meta_path.insert(0, Refuse())
"""
SOLVE_AND_CALL = """
import kousoku, numpy as np
from kousoku.generated import lever_crank
from kousoku.generated.kinds import n1
C, _ = n1.constraint([1, 0, 0, 0], [1, 0, 0], [1, 0, 0, 0], [0, 1, 0])
print(kousoku.__file__, len(lever_crank.solve()), *np.ravel(C))
"""


def run_from(site: Path, *arguments: object) -> str:
    """Run Python with an unpacked wheel before everything else, outside of the checkout."""
    return subprocess.run(
        [sys.executable, *map(str, arguments)],
        cwd=site,
        env={**os.environ, "PYTHONPATH": str(site)},
        capture_output=True,
        text=True,
        check=True,
    ).stdout


def test_an_installed_wheel_solves_where_only_numpy_is(distributions: Distributions) -> None:
    printed = run_from(distributions.wheel, "-c", NUMPY_ONLY + SOLVE_AND_CALL).split()
    assert Path(printed[0]).is_relative_to(distributions.wheel)
    assert printed[1:] == ["61", "0.0"]


def test_an_installed_wheel_solves_a_users_scene(distributions: Distributions) -> None:
    scene = ROOT / "scenes" / "watt_six_bar.toml"
    assert "61 positions" in run_from(distributions.wheel, "-m", "kousoku", "solve", scene)
