"""The list of packages and the links: all that is on disk is shipped."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import pytest

from kousoku.model.version import __version__

ROOT = Path(__file__).parents[1]
FOLDERS = ("codegen", "generated", "ledger", "model", "runtime", "symbolic")


def setuptools_table() -> dict[str, Any]:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    table: dict[str, Any] = project["tool"]["setuptools"]
    return table


def test_the_version_is_the_same_wherever_it_stands() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    assert project["project"]["version"] == __version__
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8").splitlines()
    assert f"version: {__version__}" in citation


def package_of(folder: Path) -> str:
    parts = folder.relative_to(ROOT).parts
    return ".".join(parts if parts[0] == "kousoku" else ("kousoku", *parts))


def packages_on_disk() -> list[str]:
    inits = [
        path
        for folder in ("kousoku", *FOLDERS)
        for path in (ROOT / folder).rglob("__init__.py")
        if not any(parent.is_symlink() for parent in path.parents)
    ]
    return sorted(package_of(path.parent) for path in inits)


def test_every_package_on_disk_is_listed_and_no_other() -> None:
    assert sorted(setuptools_table()["packages"]) == packages_on_disk()


def test_every_root_folder_is_mapped_under_its_own_name() -> None:
    mapping = setuptools_table()["package-dir"]
    assert mapping == {"kousoku": "kousoku"} | {f"kousoku.{name}": name for name in FOLDERS}


@pytest.mark.parametrize("name", FOLDERS)
def test_each_link_points_at_its_folder(name: str) -> None:
    link = ROOT / "kousoku" / name
    if not link.is_symlink():
        pytest.skip("links are text files in this checkout")
    assert link.resolve() == ROOT / name
