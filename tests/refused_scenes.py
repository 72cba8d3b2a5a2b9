"""Scenes that are refused: trees with one value changed, and what is said of it where."""

from __future__ import annotations

from typing import Any

import pytest

from kousoku.model.errors import SceneError
from kousoku.model.reading.read import scene_from_dict

Tree = dict[str, Any]


def refused(tree: Tree, key: str, says: str) -> None:
    """Check that a scene is refused at a key, for a reason."""
    with pytest.raises(SceneError) as caught:
        scene_from_dict(tree)
    assert caught.value.key == key
    assert says in caught.value.problem


def put(tree: Tree, place: str, value: object) -> Tree:
    """Set one value of a tree by its dotted key."""
    *tables, last = place.split(".")
    table = tree
    for name in tables:
        table = table.setdefault(name, {})
    table[last] = value
    return tree
