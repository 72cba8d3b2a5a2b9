"""``kousoku verify`` of scenes: by file, by name, and of a folder that was generated."""

from __future__ import annotations

import gzip
import hashlib
import json
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from kousoku.model.files.manifest import Manifest

if TYPE_CHECKING:
    from collections.abc import Callable

    from tests.cli.conftest import Result

    Run = Callable[..., Result]

SCENES = Path(__file__).parents[2] / "scenes"


@pytest.fixture(autouse=True)
def cache(monkeypatch: pytest.MonkeyPatch, tmp_path_factory: pytest.TempPathFactory) -> None:
    monkeypatch.setenv("KOUSOKU_CACHE", str(tmp_path_factory.mktemp("cache")))


def test_scene_of_bodies_is_verified_by_its_file_and_by_its_name(run: Run) -> None:
    code, out, _ = run("verify", SCENES / "pendulum.toml", "--target", "numpy")
    assert code == 0
    tables = [line.split()[:3] for line in out.splitlines()]
    assert ["solver", "v_dot", "NumPy"] in tables
    assert ["newton_euler", "acceleration", "NumPy"] in tables
    assert "units of at most 4" in out
    answer = json.loads(run("verify", "pendulum", "--target", "numpy", "--json").out)
    assert answer["ok"]
    assert answer["packages"][0]["rows"][0]["way"] == "NumPy"


def test_linkage_is_verified_by_its_file(run: Run) -> None:
    code, out, _ = run("verify", SCENES / "five_bar.toml", "--target", "numpy")
    assert code == 0
    assert "units of at most 4" in out


def test_folder_of_a_scene_that_computes_something_else_is_a_disagreement(
    run: Run, tmp_path: Path
) -> None:
    assert run("generate", SCENES / "pendulum.toml", "--out", tmp_path).code == 0
    folder = tmp_path / "pendulum"
    assert run("verify", folder, "--target", "numpy").code == 0
    path = folder / "reference.json.gz"
    data = json.loads(gzip.decompress(path.read_bytes()))
    data["points"][1]["outputs"]["v_dot"]["high"][0] += 1e-13
    text = json.dumps(data).encode()
    path.write_bytes(gzip.compress(text))
    code, out, _ = run("verify", folder, "--target", "numpy")
    assert code == 1
    assert "reference.json" in out
    manifest_path = folder / "manifest.json"
    manifest = Manifest.from_json(manifest_path.read_text(encoding="utf-8"))
    digest = hashlib.sha256(text).hexdigest()
    files = tuple((n, digest if n == "reference.json.gz" else d) for n, d in manifest.files)
    manifest_path.write_text(replace(manifest, files=files).to_json(), encoding="utf-8")
    code, out, _ = run("verify", folder, "--target", "numpy")
    assert code == 1
    assert "WRONG: solver: v_dot[0] by NumPy is" in out
    assert "near the start, moving" in out


def test_scene_that_cannot_be_is_bad_input(run: Run, tmp_path: Path) -> None:
    bad = tmp_path / "bad.toml"
    bad.write_text('name = "bad"\nunit = "m"\n[bodies]\na = { mass = -1 }\n', encoding="utf-8")
    assert run("verify", bad).code == 2
    code, _, err = run("verify", "nothing_of_this_name")
    assert code == 2
    assert "no such package" in err
