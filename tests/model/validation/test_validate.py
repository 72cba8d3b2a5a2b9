"""What is refused before anything is derived; the common cases are files in tests/scenes/bad."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from kousoku.model.errors import SceneError
from kousoku.model.reading.read import read_scene, scene_from_dict
from kousoku.model.records.planar import Link, Node
from kousoku.model.records.scene import Scene
from kousoku.model.validation.validate import check, require_planar
from tests.refused_scenes import put, refused

ROOT = Path(__file__).parents[3]
Tree = dict[str, Any]


@pytest.mark.parametrize(
    ("place", "value", "key", "says"),
    [
        ("nodes", {}, "nodes", "is missing; wanted nodes and links"),
        ("links", {}, "links", "is missing; wanted one link at least"),
        ("nodes.l1", {"at": [9, 9]}, "links.l1", "the name 'l1' is also in nodes"),
        ("inputs.O2", {"link": "l1"}, "inputs.O2", "the name 'O2' is also in nodes"),
        ("links.l1.length", 1e-60, "links.l1.length", "has the length 1e-60"),
        ("links.l1.length", 1e-14, "links.l1", "within the limit of the residual"),
        ("nodes.O3.at", [30, 0], "links.l2", "has no direction: O2 and O3 are given at the same"),
        ("links.l4", {"nodes": ["O4", "O1"], "length": 99}, "links.l4.length", "contradicts"),
        ("links.l4", {"nodes": ["O2", "O1"], "length": 30}, "links.l4", "and repeats it"),
        ("method", {"residual": 1e-20}, "method.residual", "below the rounding"),
        ("method", {"iterations": 0}, "method.iterations", "0 iterations; wanted 1 to 100000"),
        ("divisions", 10**40, "divisions", "more than 10²⁰ divisions"),
        ("divisions", 10**4000, "divisions", "more than 20 digits is too large"),
        ("inputs.alpha.turns", 1e20, "inputs.alpha.turns", "1e+20 turns in 60 divisions cannot"),
        ("inputs.alpha.turns", -601, "inputs.alpha.turns", "wanted at most 10 turns a division"),
        ("inputs.alpha.to", -1e9, "inputs.alpha.to", "cannot be followed"),
        ("outputs", ["angles", "angles"], "outputs", "stands there twice"),
        ("outputs", ["angles", "energies"], "outputs[1]", "no output of a planar linkage"),
        ("outputs", ["speeds"], "outputs[0]", "one of 'positions', 'velocities'"),
        ("title", "a\nb", "title", "wanted one line"),
        ("title", "\u202egnp.exe", "title", "wanted one line"),
        ("title", "t" * 1000, "title", "at most 120"),
        ("title", 'a "b"', "title", "without double quotes"),
        ("title", "a\\", "title", "backslashes"),
    ],
)
def test_a_setting_or_element_is_refused(
    lever: Tree, place: str, value: object, key: str, says: str
) -> None:
    refused(put(lever, place, value), key, says)


def test_a_title_may_be_in_any_language(lever: Tree) -> None:
    assert scene_from_dict(put(lever, "title", "てこクランク機構")).title == "てこクランク機構"


def test_a_frame_link_may_differ_by_rounding_only(lever: Tree) -> None:
    lever["nodes"]["O4"]["at"] = [70.71067811865476, 70.71067811865476]
    lever["links"]["l4"] = {"nodes": ["O4", "O1"], "length": 100}
    assert scene_from_dict(lever).is_ground("l4")
    lever["nodes"]["O4"]["at"] = [70.7107, 70.7107]
    refused(lever, "links.l4.length", "contradicts the fixed nodes O4 and O1, which are 100.0000")


def test_a_frame_far_from_the_origin_has_a_coarser_residual(lever: Tree) -> None:
    near = scene_from_dict(lever)
    assert near.residual_limit == 8 * 2**-52 * 80
    for name in lever["nodes"]:
        lever["nodes"][name]["at"][1] += 2**20
    far = scene_from_dict(lever)
    assert far.residual_limit == 2**-32
    refused(put(lever, "method", {"residual": 1e-13}), "method.residual", "wanted at least 1.16")


def test_a_frame_too_far_from_the_origin_is_refused(lever: Tree) -> None:
    for name in lever["nodes"]:
        lever["nodes"][name]["at"][1] += 2**60
    refused(lever, "links.l1", "or a frame near the origin")


@pytest.mark.parametrize(
    ("given", "place", "says"),
    [
        ({}, "", "wanted one of link, slider and joint, got none of them"),
        ({"link": "l1", "slider": "s"}, "", "got link and slider"),
        ({"link": "l9", "about": "O1"}, ".link", "unknown link 'l9'; known here: l1, l2, l3"),
        ({"slider": "s", "to": 1}, ".slider", "unknown slider 's'; known here: none"),
        ({"joint": "j"}, ".joint", "unknown joint 'j'"),
    ],
)
def test_an_input_must_drive_something(lever: Tree, given: Tree, place: str, says: str) -> None:
    refused(put(lever, "inputs.alpha", given), f"inputs.alpha{place}", says)


def test_an_input_may_not_turn_the_frame(lever: Tree) -> None:
    lever["links"]["l4"] = {"nodes": ["O4", "O1"]}
    lever["inputs"]["alpha"] = {"link": "l4", "about": "O1"}
    refused(lever, "inputs.alpha.link", "lies between fixed nodes and cannot turn")


def test_two_inputs_on_one_link_are_refused(lever: Tree) -> None:
    lever["inputs"]["beta"] = {"link": "l1", "about": "O2"}
    refused(lever, "inputs.beta", "prescribes the link l1, as inputs.alpha does")


@pytest.mark.parametrize(
    ("given", "place", "says"),
    [
        ({"slider": "piston", "turns": 1}, ".turns", "a slider makes no turns; wanted 'to'"),
        ({"slider": "piston"}, ".to", "is missing; wanted the last displacement"),
        ({"slider": "piston", "to": 2, "about": "O1"}, ".about", "belongs to an input of a link"),
    ],
)
def test_an_input_of_a_slider_has_a_last_displacement(
    piston: Tree, given: Tree, place: str, says: str
) -> None:
    refused(put(piston, "inputs.alpha", given), f"inputs.alpha{place}", says)


@pytest.mark.parametrize(
    ("place", "value", "key", "says"),
    [
        ("node", "O9", ".node", "unknown node 'O9'"),
        ("node", "O1", ".node", "the node O1 is fixed and cannot slide"),
        ("direction", [0, 0], ".direction", "has zero length; wanted a direction"),
    ],
)
def test_a_slider_needs_a_free_node_and_a_direction(
    piston: Tree, place: str, value: object, key: str, says: str
) -> None:
    refused(put(piston, f"sliders.piston.{place}", value), f"sliders.piston{key}", says)


def test_a_node_slides_on_one_line_only(piston: Tree) -> None:
    piston["sliders"]["second"] = {"node": "O3", "through": [0, 0], "direction": [0, 1]}
    refused(piston, "sliders.second.node", "slides on sliders.piston already")


@pytest.mark.parametrize(
    ("rigid", "place", "says"),
    [
        ({"at": "O9", "links": ["l1", "l2"]}, ".at", "unknown node 'O9'"),
        ({"at": "O2", "links": ["l1"]}, ".links", "wanted two links or more"),
        ({"at": "O2", "links": ["l1", "l1"]}, ".links[1]", "the link l1 stands there twice"),
        ({"at": "O2", "links": ["l1", "l7"]}, ".links[1]", "unknown link 'l7'"),
        ({"at": "O2", "links": ["l1", "l3"]}, ".links[1]", "and does not meet O2"),
    ],
)
def test_a_rigid_connection_joins_links_at_their_node(
    lever: Tree, rigid: Tree, place: str, says: str
) -> None:
    refused(put(lever, "rigid.corner", rigid), f"rigid.corner{place}", says)


def test_one_angle_does_not_describe_three_links(lever: Tree) -> None:
    lever["nodes"]["P"] = {"at": [20, 30]}
    lever["links"]["p"] = {"nodes": ["O2", "P"]}
    lever["rigid"] = {"star": {"at": "O2", "links": ["l1", "l2", "p"], "angle": 1}}
    refused(lever, "rigid.star.angle", "one angle cannot describe more than two links")


def test_a_frame_alone_is_no_linkage(lever: Tree) -> None:
    for node in lever["nodes"].values():
        node["fixed"] = True
    for link in lever["links"].values():
        del link["length"]
    refused(lever | {"inputs": {}}, "nodes", "every node is fixed; wanted something that moves")


def test_too_many_links_are_refused_at_once(lever: Tree) -> None:
    for i in range(3000):
        lever["links"][f"m{i}"] = {"nodes": ["O1", "O2"]}
    refused(lever, "links", "has 3003 links; the limit is 2000")


def test_a_scene_that_python_made_by_hand_is_checked_for_numbers_too() -> None:
    nodes = {"A": Node(at=(0.0, 0.0), fixed=True), "B": Node(at=(float("nan"), 0.0))}
    scene = Scene(name="x", unit="m", nodes=nodes, links={"l": Link(nodes=("A", "B"))})
    with pytest.raises(SceneError, match=r"nodes\.B\.at: nan is not a number"):
        check(scene)


def test_spatial_scenes_are_validated_but_refused_by_the_solver() -> None:
    scene = read_scene(ROOT / "scenes" / "spatial_four_bar.toml")
    assert [joint.type for joint in scene.joints.values()].count("revolute") == 2
    with pytest.raises(SceneError, match="is a scene of bodies; wanted a planar linkage"):
        require_planar(scene)


def test_planar_scenes_are_not_refused_by_the_solver() -> None:
    require_planar(read_scene(ROOT / "scenes" / "five_bar.toml"))
