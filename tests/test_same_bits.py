"""The program that compares two versions tells where they differ, and nothing else."""

from __future__ import annotations

import json
import math
from typing import Any

import pytest

from tests.same_bits import array, difference, flat, scenes

WAS: dict[str, Any] = {
    "c/default/rows": array([[0.0, 1.0], [0.5, math.nan]]),
    "c/default/state": array([3.0, 1.0, 2.0]),
    "c/default/status": 0,
    "c/default/ledger.works": {},
}


def test_what_was_written_and_read_is_the_same() -> None:
    assert difference(json.loads(json.dumps(WAS)), WAS) == ""


@pytest.mark.parametrize(
    ("key", "value", "text"),
    [
        (
            "c/default/rows",
            array([[0.0, 1.0], [-0.5, math.nan]]),
            "rows[1, 0]: -0.5, was 0.5; 1 of",
        ),
        ("c/default/rows", array([[0.0, 1.0]]), "rows: has the shape (1, 2), was (2, 2)"),
        ("c/default/state", array([3.0, 1.0, -2.0]), "state[2]: -2.0, was 2.0"),
        ("c/default/state", array([3.0, 1.5, 2.0, 0.0]), "state: has the shape (4,), was (3,)"),
        ("c/default/status", -1, "status: -1, was 0"),
        ("c/default/ledger.works", 1.0, "works: 1.0, was {}"),
        ("c/default/stopped", "MotionError: it stops", "stopped: is new, 'MotionError: it stops'"),
    ],
)
def test_the_first_difference_is_told(key: str, value: Any, text: str) -> None:
    assert text in difference(WAS, WAS | {key: value})


@pytest.mark.parametrize("state", [[3.0, 0.0, 1.0, 2.0], [3.0, 1.0, 2.0, 0.0]])
def test_a_state_counts_by_its_content_wherever_empty_fields_are(state: list[float]) -> None:
    assert difference(WAS, WAS | {"c/default/state": array(state)}) == ""


def test_a_result_that_is_gone_is_a_difference() -> None:
    less = {key: value for key, value in WAS.items() if key != "c/default/status"}
    assert "status: is not there any more" in difference(WAS, less)


def test_tables_are_told_leaf_by_leaf_and_empty_ones_too() -> None:
    data = {"a": {"b": [1, 2]}, "c": (), "d": None}
    assert dict(flat(data, "x")) == {"x.a.b.0": 1, "x.a.b.1": 2, "x.c": (), "x.d": None}


def test_scenes_are_those_that_are_committed_and_the_random_ones() -> None:
    assert {"pendulum", "lever_crank", "adams/tsda_case02", "random_0", "random_49"} <= {*scenes()}
