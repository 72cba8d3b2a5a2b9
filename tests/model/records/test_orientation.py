"""Orientations in every form give the same rotation, each by its own convention."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from kousoku.model.errors import SceneError
from kousoku.model.lowering.quaternions import quaternion
from kousoku.model.numbers import precise
from kousoku.model.reading.decode import decode
from kousoku.model.records.orientation import Orientation, check_orientation

Tree = dict[str, Any]
UNITS = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def matrix(**keys: Any) -> np.ndarray:
    """Matrix A of an orientation as it is computed."""
    given = decode(keys, Orientation)
    check_orientation(given, "orientation")
    p = quaternion(given)
    columns = [[float(x) for x in precise.rotate(p, precise.triple(unit))] for unit in UNITS]
    return np.array(columns).T


def about(axis: str, angle: float) -> np.ndarray:
    """Matrix of a turn about a coordinate axis, written down element by element."""
    c, s = math.cos(angle), math.sin(angle)
    return {
        "x": np.array([[1, 0, 0], [0, c, -s], [0, s, c]]),
        "y": np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]),
        "z": np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]),
    }[axis]


@pytest.mark.parametrize("sequence", ["xyz", "zyx", "zxz", "yxy", "xzy"])
def test_angles_about_axes_of_the_body_are_multiplied_in_their_order(sequence: str) -> None:
    angles = (0.3, -1.1, 2.5)
    first, second, third = (about(*turn) for turn in zip(sequence, angles, strict=True))
    turned = matrix(angles=angles, sequence=sequence, about="body")
    assert turned == pytest.approx(first @ second @ third, abs=1e-15)
    fixed = matrix(angles=angles, sequence=sequence, about="fixed")
    assert fixed == pytest.approx(third @ second @ first, abs=1e-15)


@pytest.mark.parametrize("axis", ["x", "y", "z"])
@pytest.mark.parametrize("angle", [0.0, 0.7, -3.0, math.pi])
def test_an_axis_and_an_angle_turn_counter_clockwise(axis: str, angle: float) -> None:
    unit = np.array(UNITS["xyz".index(axis)])
    expected = about(axis, angle)
    assert matrix(axis=(3 * unit).tolist(), angle=angle) == pytest.approx(expected, abs=1e-15)
    assert matrix(rotation_vector=(angle * unit).tolist()) == pytest.approx(expected, abs=1e-15)


def test_a_quaternion_has_its_scalar_where_its_order_says() -> None:
    c, s = math.cos(0.35), math.sin(0.35)
    first = matrix(quaternion=[c, 0, 0, s], order="wxyz")
    last = matrix(quaternion=[0, 0, 5 * s, 5 * c], order="xyzw")
    assert first == pytest.approx(about("z", 0.7), abs=1e-15)
    assert last == pytest.approx(about("z", 0.7), abs=1e-15)


@pytest.mark.parametrize(
    "vector", [[0.1, 0.2, -0.3], [3.1, 0, 0], [0, 3.1, 0.1], [0, 0, -3.1], [1, 2, 2], [0, 0, 0]]
)
def test_a_matrix_is_taken_as_it_is(vector: list[float]) -> None:
    expected = matrix(rotation_vector=vector)
    assert matrix(matrix=expected.tolist()) == pytest.approx(expected, abs=2e-15)


def test_a_right_angle_as_a_quaternion_leaves_no_last_digits() -> None:
    turned = matrix(quaternion=[1, 0, 0, 1], order="wxyz")
    assert turned.tolist() == [[0, -1, 0], [1, 0, 0], [0, 0, 1]]


def refused(keys: Tree, key: str, says: str) -> None:
    """Check that an orientation is refused at a key, for a reason."""
    with pytest.raises(SceneError) as caught:
        matrix(**keys)
    assert caught.value.key == f"orientation{key}"
    assert says in caught.value.problem


@pytest.mark.parametrize(
    ("keys", "key", "says"),
    [
        ({}, "", "wanted one of quaternion, rotation_vector, axis, angles, matrix; got none"),
        ({"axis": [1, 0, 0], "rotation_vector": [1, 0, 0]}, "", "got rotation_vector and axis"),
        ({"axis": [1, 0, 0]}, ".angle", "is missing; wanted the angle about the axis"),
        ({"axis": [0, 0, 0], "angle": 1}, ".axis", "has zero length; wanted an axis"),
        ({"angles": [1, 2, 3], "about": "body"}, ".sequence", "is missing; wanted the axes"),
        ({"angles": [1, 2, 3], "sequence": "xyz"}, ".about", "is missing; wanted 'body'"),
        ({"rotation_vector": [1, 0, 0], "order": "wxyz"}, ".order", "does not belong to"),
        ({"matrix": [[1, 0, 0], [0, 2, 0], [0, 0, 1]]}, ".matrix", "by 3; wanted at most 1e-06"),
        ({"matrix": [[1, 0, 0], [0, 1, 0], [0, 0, -1]]}, ".matrix", "is a reflection"),
    ],
)
def test_an_orientation_is_given_once_and_with_its_convention(
    keys: Tree, key: str, says: str
) -> None:
    refused(keys, key, says)


def test_a_turn_about_one_axis_twice_is_no_sequence() -> None:
    with pytest.raises(SceneError, match="one of 'xyz', 'xzy'"):
        matrix(angles=[1, 2, 3], sequence="xxy", about="body")
