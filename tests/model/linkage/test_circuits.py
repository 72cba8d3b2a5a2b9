"""Circuits that no motion can close."""

from __future__ import annotations

from typing import Any

import pytest

from kousoku.model.errors import SceneError
from kousoku.model.reading.builder import SceneBuilder
from kousoku.model.reading.read import scene_from_dict

Tree = dict[str, Any]


def triangle(a: float, b: float, c: float) -> SceneBuilder:
    """Triangle that turns about one corner."""
    return (
        SceneBuilder("triangle", unit="m")
        .node("A", at=(0, 0), fixed=True)
        .node("B", at=(3, 0))
        .node("C", at=(3, 4))
        .link("a", "A", "B", length=a)
        .link("b", "B", "C", length=b)
        .link("c", "A", "C", length=c)
        .input("alpha", link="a", about="A")
    )


def test_a_triangle_that_closes_is_valid() -> None:
    triangle(3, 4, 5).build()


@pytest.mark.parametrize("sides", [(3, 4, 8), (8, 3, 4), (4, 8, 3)])
def test_a_side_longer_than_the_two_others_is_refused(sides: tuple[float, float, float]) -> None:
    with pytest.raises(SceneError, match=r"8 m exceeds the rest of a circuit .* only 7 m"):
        triangle(*sides).build()


@pytest.mark.parametrize("sides", [(0.1, 0.2, 0.3), (0.3, 0.1, 0.2), (1e9, 2e9, 3e9)])
def test_a_flat_triangle_is_not_refused(sides: tuple[float, float, float]) -> None:
    triangle(*sides).build()


def test_a_frame_out_of_reach_is_refused(lever: Tree) -> None:
    lever["nodes"]["O4"]["at"] = [171, 0]
    with pytest.raises(SceneError, match=r"fixed 171 cm apart, .* reach only 170 cm"):
        scene_from_dict(lever)


def test_the_frame_closes_circuits_too(lever: Tree) -> None:
    lever["links"]["l3"]["length"] = 191
    with pytest.raises(SceneError, match=r"links\.l3: .* 191 cm exceeds .* only 190 cm"):
        scene_from_dict(lever)


def test_a_frame_link_with_a_length_that_is_rounded_is_no_circuit(lever: Tree) -> None:
    lever["links"]["l4"] = {"nodes": ["O4", "O1"], "length": 100 * (1 - 2**-52)}
    scene_from_dict(lever)
