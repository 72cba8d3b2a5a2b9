"""From tables to records: types, missing keys, keys with unusual characters."""

from __future__ import annotations

import datetime
from typing import Any

import pytest

from kousoku.model.errors import SceneError
from kousoku.model.reading.decode import decode
from kousoku.model.records.planar import Link, Node, Rigid
from kousoku.model.records.scene import Scene


def test_whole_numbers_become_floats_with_all_their_digits() -> None:
    node = decode({"at": [1, 0.1]}, Node)
    assert node == Node(at=(1.0, 0.1))
    assert all(type(component) is float for component in node.at)


@pytest.mark.parametrize(
    ("value", "got"),
    [
        (True, "true"),
        ("1", "the text '1'"),
        ([1], "a list of 1"),
        ({}, "a table"),
        (datetime.date(1981, 10, 22), "a date or time"),
        (None, "a value of type NoneType"),
    ],
)
def test_what_is_no_number_is_refused_by_what_it_is(value: object, got: str) -> None:
    with pytest.raises(SceneError) as caught:
        decode({"nodes": ["A", "B"], "length": value}, Link, key="links.l1")
    assert caught.value.key == "links.l1.length"
    assert caught.value.problem.startswith(f"{got} stands where a number is wanted")


@pytest.mark.parametrize(
    ("tree", "record", "message"),
    [
        ({"at": [1, 2, 3]}, Node, "at: a list of 3 stands where a list of 2 numbers is wanted"),
        ({"at": 1}, Node, "at: the number 1 stands where a list of 2 numbers is wanted"),
        ({"at": [1, "x"]}, Node, r"at\[1\]: the text 'x' stands where a number is wanted"),
        ({}, Node, "at: is missing; wanted a list of 2 numbers"),
        ({"at": [0, 0], "fixed": 1}, Node, "fixed: the number 1 .* true or false is wanted"),
        ({"at": "A", "links": "ab"}, Rigid, "links: the text 'ab' stands where a list is wanted"),
        ({"at": 3, "links": []}, Rigid, "at: the number 3 stands where a text is wanted"),
        ({"at": "A\ud800", "links": []}, Rigid, r"at: the text 'A.ud800' has half of a character"),
    ],
)
def test_a_value_of_the_wrong_type_is_refused(
    tree: dict[str, Any], record: type[Node | Rigid], message: str
) -> None:
    with pytest.raises(SceneError, match=message):
        decode(tree, record)


@pytest.mark.parametrize(
    ("value", "says"),
    [
        (10**400, "a whole number of more than 20 digits is too large; wanted at most 1e+50"),
        (-2e50, "-2e+50 is too large"),
        (float("inf"), "inf is not a finite number"),
        (float("nan"), "nan is not a finite number"),
    ],
)
def test_numbers_that_would_overflow_are_refused(value: float, says: str) -> None:
    with pytest.raises(SceneError) as caught:
        decode({"at": [0, value]}, Node)
    assert caught.value.key == "at[1]"
    assert says in caught.value.problem


def test_a_table_of_elements_must_be_a_table() -> None:
    with pytest.raises(SceneError, match="nodes: a list of 1 stands where a table is wanted"):
        decode({"name": "x", "unit": "m", "nodes": [{"at": [0, 0]}]}, Scene)


def test_keys_with_line_breaks_stay_on_one_line() -> None:
    with pytest.raises(SceneError) as caught:
        decode({"a\nb": 1}, Node, key="nodes.A")
    assert caught.value.key == 'nodes.A."a\\nb"'


def test_endless_keys_and_values_are_cut_short() -> None:
    with pytest.raises(SceneError) as caught:
        decode({"x" * 10**6: 1}, Node)
    assert len(str(caught.value)) < 200
    with pytest.raises(SceneError) as caught:
        decode({"at": ["1" * 10**6, 0]}, Node)
    assert len(str(caught.value)) < 200


def test_a_key_unlike_all_others_gets_the_list() -> None:
    with pytest.raises(SceneError, match="unknown key; known here: at, fixed"):
        decode({"at": [0, 0], "zzz": 1}, Node)
