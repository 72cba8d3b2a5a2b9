"""What is refused of bodies and joints before anything is derived."""

from __future__ import annotations

from typing import Any

import pytest

from kousoku.model.errors import SceneError
from kousoku.model.reading.read import scene_from_dict
from tests.refused_scenes import put, refused

Tree = dict[str, Any]


@pytest.fixture
def bar() -> Tree:
    """Tables of a spatial pendulum, new for each test."""
    zero = [0, 0, 0]
    joint = {"type": "revolute", "bodies": ["ground", "bar"], "points": [zero, zero]}
    return {
        "name": "pendulum",
        "unit": "m",
        "bodies": {"bar": {"position": zero}},
        "joints": {"a": {**joint, "axes": [[0, 0, 1], [0, 0, 1]]}},
        "inputs": {"alpha": {"joint": "a"}},
    }


def test_a_spatial_pendulum_is_valid(bar: Tree) -> None:
    assert scene_from_dict(bar).is_spatial


def test_outputs_of_bodies_are_not_those_of_links(bar: Tree) -> None:
    outputs = ["reactions", "energies"]
    assert scene_from_dict(bar | {"outputs": outputs}).outputs == tuple(outputs)
    refused(bar | {"outputs": ["reactions", "angles"]}, "outputs[1]", "no output of bodies")


@pytest.mark.parametrize(
    ("place", "value", "key", "says"),
    [
        ("nodes.A", {"at": [0, 0]}, "nodes", "wanted either nodes and links, or bodies"),
        ("bodies", {}, "bodies", "is missing; joints need bodies to connect"),
        ("bodies.ground", {"position": [0, 0, 0]}, "bodies.ground", "is the fixed body"),
        ("bodies.bar.position", [0, 0], "bodies.bar.position", "a list of 3 numbers is wanted"),
        ("bodies.bar.mass", -1, "bodies.bar.mass", "wanted a positive mass"),
        ("bodies.bar.center", [1, 0, 0], "bodies.bar.mass", "is missing, but center is given"),
        ("joints.a.type", "hing", "joints.a.type", "unknown joint 'hing'; did you mean 'hinge'?"),
        ("joints.a.bodies", ["ground", "bra"], "joints.a.bodies[1]", "did you mean 'bar'?"),
        ("joints.a.axes", [[0, 0, 1], [0, 0, 0]], "joints.a.axes[1]", "has zero length"),
        ("joints.a.type", "spherical", "joints.a.axes", "a spherical joint has no axis"),
        ("inputs.beta", {"joint": "a"}, "inputs.beta", "prescribes the joint a, as inputs.alpha"),
    ],
)
def test_a_body_or_joint_is_refused(
    bar: Tree, place: str, value: object, key: str, says: str
) -> None:
    refused(put(bar, place, value), key, says)


def test_a_revolute_joint_needs_axes(bar: Tree) -> None:
    del bar["joints"]["a"]["axes"]
    refused(bar, "joints.a.axes", "a revolute joint wants an axis in each body")


@pytest.mark.parametrize(
    ("orientation", "key", "says"),
    [
        ({"quaternion": [1, 0, 0, 0]}, ".order", "is missing; wanted one of 'wxyz', 'xyzw'"),
        ({"quaternion": [0, 0, 0, 0], "order": "wxyz"}, ".quaternion", "has zero length"),
        ({"quaternion": [1, 0, 0], "order": "wxyz"}, ".quaternion", "a list of 4 numbers"),
    ],
)
def test_a_quaternion_is_given_with_its_order(
    bar: Tree, orientation: Tree, key: str, says: str
) -> None:
    bar["bodies"]["bar"]["orientation"] = orientation
    refused(bar, f"bodies.bar.orientation{key}", says)


def joint(kind: str, **keys: object) -> Tree:
    """Joint between the ground and the bar."""
    return {"type": kind, "bodies": ["ground", "bar"], **keys}


@pytest.mark.parametrize(
    ("given", "key", "says"),
    [
        (joint("revolute", axis=[0, 0, 1]), ".points", "is missing; a revolute joint wants"),
        (joint("ball", at=[0, 0, 0], points=[[0] * 3] * 2), ".at", "has points too"),
        (joint("rod", at=[0, 0, 0]), ".at", "its two points are apart"),
        (joint("parallel", at=[0, 0, 0], axis=[0, 0, 1]), ".at", "has no point; leave it out"),
        (joint("hinge", at=[0, 0, 0], axis=[0, 0, 0]), ".axis", "has zero length"),
        (
            joint("hinge", at=[0, 0, 0], axis=[0, 0, 1], axes=[[0, 0, 1]] * 2),
            ".axis",
            "has axes too; wanted one of them",
        ),
        (joint("hinge", at=[0, 0, 0], second_axis=[0, 0, 1]), ".axis", "is missing"),
        (
            joint("hinge", at=[0, 0, 0], axis=[0, 0, 1], second_axis=[0, 0, 1]),
            ".second_axis",
            "a hinge joint has one axis",
        ),
        (joint("hooke", at=[0, 0, 0], axis=[0, 0, 1]), ".second_axis", "wanted the axis of body j"),
        (joint("ball", at=[0, 0, 0], length=1), ".length", "a ball joint has no length"),
        (joint("rod", points=[[0] * 3] * 2, length=0), ".length", "take a spherical joint"),
    ],
)
def test_a_joint_has_the_keys_of_its_type(bar: Tree, given: Tree, key: str, says: str) -> None:
    refused(put(bar, "joints.a", given), f"joints.a{key}", says)


@pytest.mark.parametrize(
    ("given", "key", "says"),
    [
        (joint("revolute", at=[0, 0, 0], axis=[0, 0, 1]), ".bodies[1]", "bar is a point, which"),
        (joint("ball", points=[[0, 0, 0], [1, 0, 0]]), ".points[1]", "wanted [0, 0, 0]"),
        (
            {**joint("inline", at=[0, 0, 0], axis=[0, 0, 1]), "bodies": ["bar", "ground"]},
            ".bodies[0]",
            "bar is a point",
        ),
    ],
)
def test_a_point_keeps_no_orientation(bar: Tree, given: Tree, key: str, says: str) -> None:
    bar["bodies"]["bar"] = {"position": [0, 0, 0], "point": True, "mass": 1}
    refused(put(bar, "joints.a", given), f"joints.a{key}", says)


def test_a_point_moves_on_a_line_or_in_a_plane(bar: Tree) -> None:
    bar["bodies"]["bar"] = {"position": [0, 0, 0], "point": True, "mass": 1}
    del bar["inputs"]
    for kind in ("inline", "inplane"):
        bar["joints"]["a"] = joint(kind, at=[0, 0, 0], axis=[0, 0, 1])
        assert scene_from_dict(bar).joints["a"].type == kind


@pytest.mark.parametrize("key", ["orientation", "angular_velocity", "angular_velocity_b"])
def test_a_point_does_not_turn(bar: Tree, key: str) -> None:
    value = {"rotation_vector": [0, 0, 1]} if key == "orientation" else [0, 0, 1]
    bar["bodies"]["bar"] = {"position": [0, 0, 0], "point": True, key: value}
    refused(bar, f"bodies.bar.{key}", "a point does not turn")


def test_an_angular_velocity_is_given_once(bar: Tree) -> None:
    bar["bodies"]["bar"] |= {"angular_velocity": [0, 0, 1], "angular_velocity_b": [0, 0, 1]}
    refused(bar, "bodies.bar.angular_velocity_b", "wanted one of them")


def test_a_linkage_of_nodes_and_links_has_no_gravity(lever: Tree) -> None:
    refused(lever | {"gravity": [0, -9.81, 0]}, "gravity", "has no masses")


def test_a_hundred_thousand_bodies_are_refused_at_once(bar: Tree) -> None:
    bar["bodies"] = dict.fromkeys((f"b{k}" for k in range(100_000)), None)
    refused(bar, "bodies", "has 100000 elements; the limit is 20000")


def test_a_method_of_linkages_is_refused_of_bodies(bar: Tree) -> None:
    refused(put(bar, "method.scheme", "paper"), "method", "belongs to a planar linkage")


def test_what_is_wrong_with_a_body_hides_no_problem_of_joints_and_forces(bar: Tree) -> None:
    tree = put(bar, "bodies.bar.mass", -1)
    tree = put(tree, "bodies.bar.orientation", {"rotation_vector": [0, 0, 0], "angle": 1})
    hinge = {"type": "hinge", "bodies": ["bar", "bar"], "at": [0, 0, 0], "axis": [0, 0, 0]}
    tree = put(tree, "joints.twice", hinge | {"pitch": 1, "length": 1})
    tree = put(tree, "joints.odd", {"type": "hnge", "bodies": ["ground", "bar"]})
    load = {"type": "force", "body": "no_such", "force": ["2 +", "x", 0]}
    tree = put(tree, "forces.load", load)

    with pytest.raises(SceneError) as caught:
        scene_from_dict(tree)

    assert {one.key for one in caught.value.problems} == {
        *("bodies.bar.mass", "bodies.bar.orientation.angle"),
        *("joints.twice.bodies", "joints.twice.axis", "joints.twice.pitch", "joints.twice.length"),
        *("joints.odd.type", "forces.load.body", "forces.load.force[0]", "forces.load.force[1]"),
    }
