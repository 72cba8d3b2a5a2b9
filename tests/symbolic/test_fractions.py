"""Norms are divided out of fractions exactly, or not at all."""

from __future__ import annotations

from sympy.polys.domains import QQ
from sympy.polys.rings import ring

from kousoku.symbolic.fractions import Fraction, Norm

RING, A, B, C = ring("a b c", QQ)
SQUARE = A**2 + B**2
NORM = Norm(0, B**2)


def test_a_norm_divides_its_multiples_alone() -> None:
    for quotient in (RING.one, 2 * C, A**3 * B - C / 3, A + B, SQUARE * C):
        assert NORM.divide(quotient * SQUARE) == quotient
        for rest in (RING.one, A, B * C, A * C + 1):
            assert NORM.divide(quotient * SQUARE + rest) is None


def test_only_norms_that_divide_both_parts_are_cancelled() -> None:
    x = Fraction(C * SQUARE**2, SQUARE**3 * (C + 1))
    assert x.cancelled([NORM]) == Fraction(C, SQUARE * (C + 1))
    assert Fraction(A, SQUARE).cancelled([NORM]) == Fraction(A, SQUARE)
    assert Fraction(A, C).cancelled([NORM]) == Fraction(A, C)


def test_without_norms_a_denominator_that_divides_is_cancelled() -> None:
    assert Fraction(A * C, C).cancelled([]) == Fraction(A, RING.one)
    assert Fraction(A, C).cancelled([]) == Fraction(A, C)
