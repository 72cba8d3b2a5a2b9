"""Scenes that grow: those that are committed are what the families build today."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from kousoku.model.reading.families import chain, n_four_bar
from kousoku.model.reading.read import read_scene
from kousoku.model.reading.write import to_toml

if TYPE_CHECKING:
    from kousoku.model.records.scene import Scene

FAMILIES = Path(__file__).parents[3] / "scenes" / "families"


@pytest.mark.parametrize(
    "scene", [n_four_bar(40), *map(chain, (10, 100, 1000))], ids=lambda scene: scene.name
)
def test_a_committed_scene_is_what_its_family_builds(scene: Scene) -> None:
    path = FAMILIES / f"{scene.name}.toml"
    assert path.read_text(encoding="utf-8") == to_toml(scene)
    assert read_scene(path) == scene
