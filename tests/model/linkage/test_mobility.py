"""Degrees of freedom: how many inputs a linkage wants, and what repeats what."""

from __future__ import annotations

import random
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kousoku.model.errors import SceneError
from kousoku.model.linkage.mobility import check_mobility
from kousoku.model.reading.builder import SceneBuilder
from kousoku.model.reading.read import scene_from_dict

Tree = dict[str, Any]


def test_the_message_counts_degrees_of_freedom(lever: Tree) -> None:
    lever["inputs"] = {}
    with pytest.raises(SceneError) as caught:
        scene_from_dict(lever)
    assert caught.value.problem == (
        "wrong number of inputs: the linkage has 1 degree of freedom (4 coordinates of free nodes "
        "− 3 constraints of links, sliders and rigid connections) and wants 1 input, got 0"
    )


def test_a_structure_wants_no_input(lever: Tree) -> None:
    lever["links"]["brace"] = {"nodes": ["O1", "O3"], "length": 73}
    with pytest.raises(SceneError, match=r"0 degrees of freedom .* wants 0 inputs, got 1"):
        scene_from_dict(lever)


def test_a_frame_link_takes_no_freedom_away(lever: Tree) -> None:
    lever["links"]["l4"] = {"nodes": ["O4", "O1"], "length": 100}
    scene_from_dict(lever)


def test_a_link_welded_to_the_frame_cannot_turn(lever: Tree) -> None:
    lever["links"]["l4"] = {"nodes": ["O4", "O1"], "length": 100}
    lever["rigid"] = {"weld": {"at": "O1", "links": ["l4", "l1"]}}
    with pytest.raises(SceneError, match="wants 0 inputs, got 1"):
        scene_from_dict(lever)


def test_an_over_braced_part_is_named(lever: Tree) -> None:
    lever["nodes"] |= {"P": {"at": [40, 30]}, "Q": {"at": [10, 40]}}
    sides = {"a": "O2 P", "b": "O3 P", "c": "P Q", "d": "O2 Q", "e": "O3 Q"}
    lever["links"] |= {name: {"nodes": ends.split()} for name, ends in sides.items()}
    with pytest.raises(SceneError) as caught:
        scene_from_dict(lever)
    assert caught.value.key == "links.e"
    assert caught.value.problem.startswith(
        "repeats what links.l2, links.a, links.b, links.c and links.d already determine"
    )


def test_inputs_that_prescribe_the_same_are_named(lever: Tree) -> None:
    """The count is right, but one part is driven twice and the other not at all."""
    lever["nodes"]["P"] = {"at": [100, 20]}
    lever["links"]["pendulum"] = {"nodes": ["O4", "P"]}
    lever["inputs"]["beta"] = {"link": "l3", "about": "O4"}
    with pytest.raises(SceneError) as caught:
        scene_from_dict(lever)
    assert caught.value.key == "inputs.beta"
    assert "links.l1, links.l2, links.l3 and inputs.alpha already determine" in str(caught.value)


@pytest.mark.parametrize(
    ("tables", "key"),
    [
        ({"inputs": {"i": {"link": "l1", "about": "O1"}, "k": {"link": "arm", "about": "Q"}}}, "k"),
        ({"rigid": {x: {"at": "O1", "links": ["l1", "arm"]} for x in "ab"}}, "b"),
    ],
)
def test_what_a_rigid_connection_ties_is_turned_and_tied_once(
    piston: Tree, tables: Tree, key: str
) -> None:
    """Another crank is left free, so that the count is right."""
    piston["nodes"] |= {
        "P": {"at": [0, 9]},
        "F": {"at": [0, 8], "fixed": True},
        "Q": {"at": [1, 1]},
    }
    piston["links"] |= {"spare": {"nodes": ["P", "F"]}, "arm": {"nodes": ["Q", "O1"]}}
    piston["rigid"] = {"a": {"at": "O1", "links": ["l1", "arm"]}}
    (table,) = tables
    with pytest.raises(SceneError) as caught:
        scene_from_dict(piston | tables)
    assert caught.value.key == f"{table}.{key}"


def test_two_sliders_on_one_line_hold_the_direction_of_their_rod() -> None:
    builder = (
        SceneBuilder("rail", unit="m")
        .node("A", at=(0, 0))
        .node("B", at=(1, 1))
        .link("rod", "A", "B")
        .slider("s1", node="A", through=(0, 0), direction=(1, 1))
        .slider("s2", node="B", through=(0, 0), direction=(1, 1))
        .input("alpha", link="rod", about="A")
    )
    with pytest.raises(SceneError, match=r"prescribes what .*sliders\.s1"):
        builder.build()


def test_a_driven_slider_moves_a_crank(piston: Tree) -> None:
    piston["inputs"] = {"s": {"slider": "piston", "from": 1.5, "to": 2.5}}
    scene_from_dict(piston)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32), st.integers(1, 8))
def test_a_crank_with_dyads_has_one_degree_of_freedom(seed: int, n_dyads: int) -> None:
    """A node on two links takes nothing away and adds nothing; one link less frees one more."""
    draw = random.Random(seed)
    builder = (
        SceneBuilder("dyads", unit="m")
        .node("O", at=(0, 0), fixed=True)
        .node("N0", at=(1, 0))
        .link("crank", "O", "N0")
        .input("alpha", link="crank", about="O", to=0.001)
    )
    nodes = ["O", "N0"]
    for number in range(1, n_dyads + 1):
        builder.node(f"N{number}", at=(draw.uniform(-9, 9), draw.uniform(-9, 9)))
        for side, end in enumerate(draw.sample(nodes, 2)):
            builder.link(f"l{number}{side}", f"N{number}", end)
        nodes.append(f"N{number}")
    scene = builder.build()
    check_mobility(scene)
    links = dict(list(scene.links.items())[:-1])
    with pytest.raises(SceneError, match="2 degrees of freedom"):
        check_mobility(
            type(scene)(name="x", unit="m", nodes=scene.nodes, links=links, inputs=scene.inputs)
        )
