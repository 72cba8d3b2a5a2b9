"""What is refused of bodies and joints before anything is derived."""

from __future__ import annotations

from typing import Any

import pytest

from kousoku.model.errors import SceneError
from kousoku.model.read import scene_from_dict

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


@pytest.fixture
def bar() -> Tree:
    """Return the tables of a spatial pendulum, new for each test."""
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
