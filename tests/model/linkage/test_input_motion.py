"""Values of the inputs: whole turns are counted, not added up."""

from __future__ import annotations

from math import tau

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kousoku.model.linkage.input_motion import input_values, period, turns_of
from kousoku.model.records.planar import Input
from kousoku.model.records.scene import Scene


def test_an_input_of_a_link_makes_one_turn_unless_it_says_otherwise() -> None:
    assert turns_of(Input(link="l", about="A")) == 1
    assert turns_of(Input(link="l", about="A", turns=-2.5)) == -2.5
    assert turns_of(Input(link="l", about="A", to=1.0)) is None
    assert turns_of(Input(slider="s", to=1.0)) is None


def test_one_turn_in_sixty_divisions() -> None:
    values = input_values(Input(link="l", about="A"), 60, range(61))
    np.testing.assert_array_equal(values[:60], [tau * (k / 60) for k in range(60)])
    assert values[60] == values[0] == 0


@given(st.integers(0, 600_000), st.integers(1, 10_000), st.floats(-7, 7))
def test_every_turn_has_the_same_angles_bit_for_bit(k: int, turns: int, start: float) -> None:
    once = input_values(Input(link="l", about="A", start=start), 60, [k % 60])
    often = input_values(Input(link="l", about="A", start=start, turns=turns), 60 * turns, [k])
    assert once == often


def test_a_backward_turn_meets_the_same_angles() -> None:
    forward = input_values(Input(link="l", about="A", turns=1), 60, range(61))
    backward = input_values(Input(link="l", about="A", turns=-1), 60, range(61))
    np.testing.assert_array_equal(forward, backward[::-1])


def test_parts_of_a_turn_are_rounded_once() -> None:
    values = input_values(Input(link="l", about="A", turns=0.1), 7, range(8))
    np.testing.assert_allclose(values, tau * 0.1 * np.arange(8) / 7, rtol=4e-16, atol=0)


def test_a_range_goes_from_its_first_to_its_last_value() -> None:
    given_range = Input(slider="s", start=-1.0, to=3.0)
    np.testing.assert_array_equal(input_values(given_range, 4, range(5)), [-1, 0, 1, 2, 3])


@pytest.mark.parametrize(
    ("turns", "divisions", "repeats"),
    [((1,), 60, 60), ((10_000,), 600_000, 60), ((1, -2), 60, 60), ((2, 3), 60, 60), ((0.5,), 9, 9)],
)
def test_positions_repeat_after_the_turns_of_all_inputs(
    turns: tuple[float, ...], divisions: int, repeats: int
) -> None:
    inputs = {f"i{n}": Input(link="l", about="A", turns=count) for n, count in enumerate(turns)}
    assert period(Scene(name="x", unit="m", inputs=inputs, divisions=divisions)) == repeats


def test_a_range_repeats_only_at_its_end() -> None:
    inputs = {"s": Input(slider="s", to=1.0)}
    assert period(Scene(name="x", unit="m", inputs=inputs, divisions=12)) == 12
