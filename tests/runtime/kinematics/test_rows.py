"""What is asked: whole turns, the scene's own answers, and inputs without rounding."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from kousoku.runtime.kinematics.rows import RunRequest, request

SCENE = RunRequest(
    method=1,
    max_iterations=20,
    limit=1e-9,
    divisions=12,
    rows=13,
    origin=(0.5, 0.0),
    span=(0.0, 3.0),
    turns=(2, 0),
    rate=(1.0, 1.0),
    rate_dot=(0.0, 0.0),
)
TURNING = replace(SCENE, turns=(2, -1))


def test_what_is_left_out_is_as_in_the_scene() -> None:
    assert request(SCENE) == SCENE


def test_turns_are_counted_in_divisions() -> None:
    run = request(TURNING, method="newton", divisions=5, turns=3, first_turn=4, from_turn=2)
    assert (run.method, run.divisions, run.limit) == (0, 5, 1e-9)
    assert (run.start, run.first, run.rows) == (10, 20, 16)
    assert request(TURNING, first_turn=4).start == 0


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"method": "euler"}, "got 'euler', wanted newton or paper"),
        ({"divisions": 0}, "got divisions=0"),
        ({"turns": 0}, "turns=0"),
        ({"first_turn": 1, "from_turn": 2}, "0 <= from_turn <= first_turn"),
        ({"from_turn": -1}, "from_turn=-1"),
    ],
)
def test_impossible_options_are_refused(options: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        request(TURNING, **options)


@pytest.mark.parametrize(
    "wrong",
    [
        *({"divisions": 0}, {"rows": 0}, {"start": 1}, {"start": -1, "first": 0}),
        *({"max_iterations": 0}, {"limit": 0.0}, {"limit": np.nan}, {"rate": (np.inf, 1.0)}),
        *({"times": np.array([1.0, 0.5])}, {"times": np.array([0.0, np.inf])}),
        {"times": np.array([0.0, 1.0]), "first": 1},
    ],
    ids=str,
)
def test_a_run_is_impossible_whatever_else_is_right(wrong: dict[str, Any]) -> None:
    assert SCENE.is_possible
    assert not replace(SCENE, **wrong).is_possible


@pytest.mark.parametrize("options", [{"turns": 2}, {"first_turn": 1}])
def test_inputs_that_do_not_turn_are_not_turned_on(options: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match="leave turns out"):
        request(SCENE, **options)


def test_inputs_of_a_late_turn_are_those_of_the_first() -> None:
    for division in (0, 5, 11):
        first, _ = TURNING.inputs_of(division)
        late, delta = TURNING.inputs_of(division + 12 * 10**12)
        np.testing.assert_array_equal(late, first)
        np.testing.assert_allclose(delta, [2 * np.pi / 6, -2 * np.pi / 12])


def test_inputs_that_go_a_span_are_divided() -> None:
    alpha, delta = SCENE.inputs_of(4)
    np.testing.assert_allclose(alpha, [0.5 + 4 * np.pi / 3, 1.0])
    assert delta[1] == 0.25
    np.testing.assert_allclose(SCENE.counted_inputs(24), [0.5 + 8 * np.pi, 6.0])
