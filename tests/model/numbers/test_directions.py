"""Roots and angles of exact numbers."""

from __future__ import annotations

import math
from fractions import Fraction

import mpmath
import pytest

from kousoku.model.numbers.directions import BITS, HALF_TURN, heading, square_root, unit_vector


@pytest.mark.parametrize("value", [0, 1, Fraction(9, 4), 10**40, Fraction(1, 10**40)])
def test_rational_roots_are_exact(value: Fraction) -> None:
    assert square_root(Fraction(value)) ** 2 == value


@pytest.mark.parametrize("value", [2, Fraction(1, 3), 3 * 10**41, Fraction(7, 10**301), 1e-300])
def test_other_roots_are_good_to_many_bits(value: Fraction) -> None:
    exact = Fraction(value)
    assert abs(square_root(exact) ** 2 / exact - 1) < Fraction(1, 2**BITS)


def test_unit_vector_of_a_pythagorean_triple_is_exact() -> None:
    assert unit_vector(Fraction(-3), Fraction(4)) == (Fraction(-3, 5), Fraction(4, 5))


def test_headings_are_angles_in_every_quadrant() -> None:
    for x, y in ((1, 0), (1, 2), (0, 3), (-1, 2), (-1, -2), (0, -1), (2, -1)):
        assert float(heading(x, y)) == float(mpmath.atan2(y, x))


def test_half_a_turn_is_pi_to_many_digits() -> None:
    with mpmath.workdps(60):
        difference = mpmath.mpf(HALF_TURN.numerator) / HALF_TURN.denominator - mpmath.pi
        assert abs(difference) < mpmath.mpf(2) ** -198


def test_the_precision_that_other_code_has_set_never_changes(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Not even for a moment: that code may run in another thread."""

    def refuse(*_: object) -> None:
        raise AssertionError("the precision of mpmath changes")

    context = type(mpmath.mp)
    monkeypatch.setattr(context, "prec", property(context.prec.fget, refuse))
    assert float(heading(1, 1)) == math.pi / 4
