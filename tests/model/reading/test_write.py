"""Scenes as TOML: what is written reads back the same."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import pytest

from kousoku.model.reading.builder import SceneBuilder
from kousoku.model.reading.read import read_scene, scene_from_toml
from kousoku.model.reading.write import to_toml, toml_of

ROOT = Path(__file__).parents[3]


@pytest.mark.parametrize("path", sorted((ROOT / "scenes").glob("*.toml")), ids=lambda p: p.stem)
def test_a_scene_survives_being_written(path: Path) -> None:
    scene = read_scene(path)
    text = to_toml(scene)
    assert scene_from_toml(text) == scene
    assert to_toml(scene_from_toml(text)) == text


def test_numbers_keep_all_their_digits_and_defaults_are_left_out() -> None:
    scene = (
        SceneBuilder("crank", unit="m", title="Kurbel ± 1")
        .node("A", at=(0, 0), fixed=True)
        .node("B", at=(0.1 + 0.2, 1e-30))
        .link("l", "A", "B")
        .input("alpha", link="l", about="A", start=-1e22)
        .build()
    )
    assert to_toml(scene) == (
        'name = "crank"\nunit = "m"\ntitle = "Kurbel ± 1"\n\n'
        "[nodes]\n"
        "A = { at = [0.0, 0.0], fixed = true }\n"
        "B = { at = [0.30000000000000004, 1e-30] }\n\n"
        "[links]\n"
        'l = { nodes = ["A", "B"] }\n\n'
        "[inputs]\n"
        'alpha = { link = "l", about = "A", from = -1e+22 }\n'
    )
    assert scene_from_toml(to_toml(scene)) == scene


def test_any_tree_reads_back() -> None:
    """Also keys that are no names, and characters that stand in no text of TOML."""
    inner: dict[str, Any] = {"a b": [1, 1.5, True], "": {"é": '"\n\x7f\\', "c-d": []}}
    tree: dict[str, Any] = {"x.y": -1e-300, "text": "\0\x7f", "table": inner, "empty": {}}
    assert tomllib.loads(toml_of(tree)) == tree
