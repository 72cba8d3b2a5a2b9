"""What random scenes are held to: as close as the order of a method tells, and no closer."""

from __future__ import annotations

import random
from typing import Any
from unittest.mock import patch

import pytest

from tests.random_scenes import random_scene
from tests.stress import scenes

#: What they look at is no part of kousoku.
pytestmark = pytest.mark.release

#: Steps over a bend of a spring's law: of fixed length, and of DOP853.
BENT = ("1 44 4", "1 68 1")


def found(place: str) -> list[Any]:
    with scenes.quick_to_compile():
        return scenes.look(random_scene(random.Random(place)), place).findings


@pytest.mark.usefixtures("compiler")
@pytest.mark.parametrize("place", [*BENT, "1 79 2"])
def test_methods_are_held_to_their_order(place: str) -> None:
    assert found(place) == []


@pytest.mark.usefixtures("compiler")
@pytest.mark.parametrize("place", BENT)
def test_steps_that_end_at_bends_are_held_closer(place: str) -> None:
    """Where none does, as of a product of which each side is as smooth, that is found."""
    with patch.object(scenes, "LOCATED", "x*abs(x)"):
        assert any("are apart, and trusted" in one.title for one in found(place))
