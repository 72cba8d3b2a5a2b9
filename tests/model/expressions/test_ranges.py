"""Ranges of formulas: no value is outside."""

from __future__ import annotations

import math
import random
import sys

import pytest

from kousoku.model.errors import ExpressionError
from kousoku.model.expressions.parser import parse_expression
from kousoku.model.expressions.ranges import range_of
from kousoku.model.expressions.values import value_of
from kousoku.model.operations.expression import ordered
from kousoku.model.operations.graph import Op

NAMES = frozenset({"x", "y"})
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
            at = {name: math.tan(draw.uniform(-1.57, 1.57)) for name in NAMES}
            parts = {part: value_of(part, at) for part in ordered(formula)}
            underflows = any(part.op in {Op.EXP, Op.POW} and not parts[part] for part in parts)
            if all(map(math.isfinite, parts.values())) and not underflows:
                value = parts[formula]
                close = 1e-9 * (1.0 + abs(value))
                assert least - close <= value <= most + close, (text, at, value)


@pytest.mark.parametrize(
    ("text", "least", "most"),
    [
        ("(x - 3)*(x - 3)", 0.0, math.inf),
        ("-(x/y)*(x/y)", -math.inf, 0.0),
        ("(cos(x) - 1)/4", -0.5, 0.0),
        ("1/(2 + sin(x))", 1.0 / 3.0, 1.0),
        ("1/x", -math.inf, math.inf),
        ("1/abs(x)", 0.0, math.inf),
        ("sqrt(4 + x^2)", 2.0, math.inf),
        ("exp(-x^2)", 0.0, 1.0),
        ("exp(exp(x))", 1.0, math.inf),
        ("log(1 + x^2)", 0.0, math.inf),
        ("atan2(1 + x^2, y)", 0.0, math.pi),
        ("max(x, 1)*min(y, -1)", -math.inf, -1.0),
        ("sign(2 + cos(x))", 1.0, 1.0),
        ("abs(x) + (10^200)^2", sys.float_info.max, math.inf),
    ],
)
def test_ends_are_those_of_the_functions(text: str, least: float, most: float) -> None:
    found = range_of(parse_expression(text, NAMES))
    assert found == pytest.approx((least, most), rel=1e-12, abs=1e-300)


def test_what_is_above_zero_is_told_from_what_may_be_zero() -> None:
    assert range_of(parse_expression("exp(x)*exp(y)", NAMES))[0] > 0.0
    assert range_of(parse_expression("exp(x)*abs(y)", NAMES))[0] == 0.0
