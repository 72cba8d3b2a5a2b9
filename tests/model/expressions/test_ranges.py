"""Ranges of formulas: no value is outside."""

from __future__ import annotations

import random
import sys
from fractions import Fraction
from math import e, inf, isfinite, log, pi, tan

import pytest

from kousoku.model.errors import ExpressionError
from kousoku.model.expressions.parser import parse_expression
from kousoku.model.expressions.ranges import range_of
from kousoku.model.expressions.values import value_of
from kousoku.model.operations.expression import add, apply, number, ordered, symbol
from kousoku.model.operations.graph import Op

NAMES = frozenset({"x", "y", "m"})
LEAVES = ("x", "y", "1", "2", "-3", "0.5", "-0.25")
FORMS = (
    *("(A + B)", "(A - B)", "(A*B)", "(A/B)", "(-A)", "(A*A)", "(A/B)*(A/B)", "sin(A)", "cos(A)"),
    *("exp(A)", "log(A)", "sqrt(A)", "abs(A)", "sign(A)", "atan(A)", "asin(A)", "acos(A)"),
    *("atan2(A, B)", "min(A, B)", "max(A, B)", "(A)^2", "(A)^3", "(A)^(-2)", "(A)^1.5", "(A)^B"),
)


def random_formula(draw: random.Random, depth: int) -> str:
    """Formula of x and y."""
    if depth == 0 or draw.random() < 0.15:
        return draw.choice(LEAVES)
    form = draw.choice(FORMS)
    a, b = (random_formula(draw, depth - 1) for _ in range(2))
    return form.replace("A", "\0").replace("B", b).replace("\0", a)


@pytest.mark.parametrize("seed", range(10))
def test_no_value_is_outside(seed: int) -> None:
    """Of formulas at 20 places each, but for the rounding of values."""
    draw, asked = random.Random(seed), 0
    while asked < 100:
        text = random_formula(draw, 4)
        try:
            formula = parse_expression(text, NAMES)
        except ExpressionError:  # divided by zero, or a root of a negative number
            continue
        asked += 1
        least, most = range_of(formula)
        for _ in range(20):
            at = {name: tan(draw.uniform(-1.57, 1.57)) for name in NAMES}
            parts = {part: value_of(part, at) for part in ordered(formula)}
            underflows = any(part.op in {Op.EXP, Op.POW} and not parts[part] for part in parts)
            if all(map(isfinite, parts.values())) and not underflows:
                value = parts[formula]
                close = 1e-9 * (1.0 + abs(value))
                assert least - close <= value <= most + close, (text, at, value)


@pytest.mark.parametrize(
    ("text", "least", "most"),
    [
        ("x*m*x", -inf, inf),
        ("-x*x/(m*m)", -inf, 0.0),
        ("-(x - 1)*y*(x - 1)/2*y", -inf, 0.0),
        ("-(x/m)*(x/m)", -inf, 0.0),
        ("x*x*x", -inf, inf),
        ("(cos(x) - 1)/m^2", -inf, 0.0),
        ("(2 + sin(x))/(cos(y) - 3)", -1.5, -0.25),
        ("1/(1 + x^2)", 0.0, 1.0),
        ("1/(x^2 - 1)", -inf, inf),
        ("1/(abs(x)*(-1))", -inf, 0.0),
        ("exp(sin(x))", 1.0 / e, e),
        ("exp(1000*cos(x))", 5e-324, inf),
        ("(3 + cos(x))^(-2)", 0.0625, 0.25),
        ("(cos(x) - 3)^3", -64.0, -8.0),
        ("sin(x)^2", 0.0, 1.0),
        ("2^sin(x)", 0.5, 2.0),
        ("(1 + abs(x))^1.5", 1.0, inf),
        ("abs(cos(x) - 3)", 2.0, 4.0),
        ("sqrt(1 + x^2)", 1.0, inf),
        ("log(2 + x^2)", log(2.0), inf),
        ("sign(1 + x^2)", 1.0, 1.0),
        ("atan(exp(x))", 0.0, pi / 2.0),
        ("acos(abs(x))", 0.0, pi / 2.0),
        ("asin(-abs(x))", -pi / 2.0, 0.0),
        ("atan2(x, 1 + y^2)", -pi / 2.0, pi / 2.0),
        ("min(cos(x), 3) + max(y^2, 5)", 4.0, inf),
        ("1/abs(x)", 0.0, inf),
        ("exp(-x^2)", 5e-324, 1.0),
        ("exp(exp(x))", 1.0, inf),
        ("atan2(1 + x^2, y)", 0.0, pi),
        ("max(x, 1)*min(y, -1)", -inf, -1.0),
        ("sign(2 + cos(x))", 1.0, 1.0),
    ],
)
def test_ends_are_those_of_the_functions(text: str, least: float, most: float) -> None:
    """Quotients had none, products one only where all ends are finite or no factor is negative."""
    low, high = range_of(parse_expression(text, NAMES))
    assert low <= least
    assert high >= most
    assert (low, high) == pytest.approx((least, most), rel=1e-6, abs=1e-300)


def test_a_number_beyond_doubles_is_the_largest_or_more() -> None:
    size = apply(Op.ABS, symbol("x"))
    assert range_of(add(size, number(Fraction(10) ** 400))) == (sys.float_info.max, inf)


def test_what_is_above_zero_is_told_from_what_may_be_zero() -> None:
    assert range_of(parse_expression("exp(x)*exp(y)", NAMES))[0] > 0.0
    assert range_of(parse_expression("exp(x)*abs(y)", NAMES))[0] == 0.0
