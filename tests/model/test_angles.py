"""Angles as texts: what they are in radians, and what is refused."""

from __future__ import annotations

import copy
import math
import pickle

import pytest

from kousoku.model.angles import Angle, number_of


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("30 deg", math.pi / 6),
        ("-90deg", -math.pi / 2),
        ("+ 180 deg ", math.pi),
        ("30*deg", math.pi / 6),
        ("deg", math.pi / 180),
        ("1e2 deg", math.pi / 1.8),
        ("45 deg/2", math.pi / 8),
        ("pi", math.pi),
        ("-pi/6", -math.pi / 6),
        ("3*pi/4", 3 * math.pi / 4),
        ("0.5", 0.5),
        (".5e-3", 0.0005),
        ("1/3", 1 / 3),
    ],
)
def test_a_text_is_the_nearest_double(text: str, wanted: float) -> None:
    assert number_of(text) == pytest.approx(wanted, rel=3e-16)


def test_degrees_are_rounded_once() -> None:
    """Of 30 degrees the product of two doubles is not the nearest one to pi/6."""
    assert number_of("30 deg") == 0.5235987755982989 != math.radians(30)


@pytest.mark.parametrize(
    "text",
    ["", "deg 30", "30 grad", "30 degrees", "1/0", "t", "1 deg deg", "1 2", "--1", "1e999", "٣"],
)
def test_a_text_that_is_no_angle_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match=r"no number and no angle, such as 0\.5, '30 deg' or"):
        number_of(text)


def test_what_is_given_by_the_second_is_told_the_unit() -> None:
    with pytest.raises(ValueError, match="per second is understood, leave '/s' out"):
        number_of("30 deg/s")


def test_a_long_text_is_refused_in_a_moment() -> None:
    with pytest.raises(ValueError, match="is no number"):
        number_of("1" * 1_000_000)


def test_an_angle_keeps_its_text_and_is_a_float() -> None:
    angle = Angle("30 deg")
    for one in (angle, copy.deepcopy(angle), pickle.loads(pickle.dumps(angle))):
        assert (one, one.text, repr(one)) == (number_of("30 deg"), "30 deg", "0.5235987755982989")
    assert type(angle * 2) is float
