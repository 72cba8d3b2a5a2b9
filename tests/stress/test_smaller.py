"""Findings are made smaller: each by itself, without what nothing refers to, and not for long."""

from __future__ import annotations

import tomllib
from typing import Any

import pytest
from hypothesis import strategies as st

from tests.stress import scenes, smaller
from tests.stress.kit import Disagreement, Outcome, falsify

#: What they look at is no part of kousoku.
pytestmark = pytest.mark.release


def test_parameters_that_nothing_refers_to_are_left_out() -> None:
    tree = {"parameters": {"a": 1, "b": 2, "c": 3, "d": 4}, "bodies": {"x": {"mass": "2*a + b"}}}

    def is_found(smaller: dict[str, Any]) -> bool:
        return {"a", "b", "d"} <= smaller["parameters"].keys() and "x" in smaller["bodies"]

    assert smaller.unnamed(tree) == {"c", "d"}
    assert smaller.smallest(tree, is_found)["parameters"] == {"a": 1, "b": 2, "d": 4}
    found = smaller.smallest(tree, lambda one: "a" in one["bodies"]["x"]["mass"])
    assert "parameters" not in found


def test_each_finding_has_the_smallest_scene_that_shows_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def look(tree: dict[str, Any], place: str) -> Outcome:
        outcome = Outcome()
        for name in tree.get("forces", ()):
            outcome.find(f"{name} is wrong", place)
        return outcome

    monkeypatch.setattr(scenes, "look", look)
    force = {"type": "torque", "body": "b", "torque": [1, 0, 0]}
    outcome, tree = Outcome(), {"forces": {"one": force, "two": force}}
    scenes.ask(tree, outcome, "there")
    shown = {
        finding.title: {*tomllib.loads(finding.files["scene.toml"])["forces"]}
        for finding in outcome.findings
    }
    assert shown == {"one is wrong": {"one"}, "two is wrong": {"two"}}


def test_an_example_is_made_smaller_for_some_seconds_only(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = list[list[int]]()

    def check(example: list[int]) -> None:
        asked.append(example)
        raise Disagreement(f"{len(example)} numbers")

    numbers = st.lists(st.integers(), min_size=3)
    found = falsify(numbers, check, seed=1, examples=9)
    assert found is not None
    assert found[0] == [0, 0, 0]
    monkeypatch.setattr(smaller, "MOST_SECONDS", 0.0)
    asked.clear()
    found = falsify(numbers, check, seed=1, examples=9)
    assert found is not None
    assert (found[0], str(found[1])) == (asked[0], f"{len(asked[0])} numbers")
    assert len(asked) == 1
