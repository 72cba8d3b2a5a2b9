"""The one table of differentials: against differences in 50 digits, and of formulas."""

from __future__ import annotations

import pytest

from kousoku.model.expressions.derivative import FORMULAS
from kousoku.model.numbers.digits import CONTEXT, HIGH
from kousoku.model.numbers.traced import traced
from kousoku.model.operations.differentials import DIFFERENTIALS, slopes_of
from kousoku.model.operations.expression import Expression, symbol
from kousoku.model.operations.graph import BINARY_OPS, GRAPH_OPS, Op

#: Where all of them have a value, and both arguments of max differ.
AT = (CONTEXT.mpf("0.7"), CONTEXT.mpf("0.3"))
#: Differentials of two arguments.
CHANGES = (CONTEXT.mpf("1.3"), CONTEXT.mpf("-0.4"))
STEP = CONTEXT.mpf(10) ** -16
FORMULA_OPS = (
    *(Op.MUL, Op.DIV, Op.NEG, Op.ATAN2),
    *(Op.SIN, Op.COS, Op.TAN, Op.SQRT, Op.ASIN, Op.ACOS, Op.ATAN, Op.EXP, Op.LOG),
)


def count(op: Op) -> int:
    return 2 if op in BINARY_OPS else 1


@pytest.mark.parametrize("op", DIFFERENTIALS)
def test_a_slope_is_the_limit_of_differences(op: Op) -> None:
    args = AT[: count(op)]
    found = slopes_of(op, HIGH.applied(op, args), args, HIGH)
    assert len(found) == len(args)
    for k, slope in enumerate(found):
        sides = [[x + side * STEP * (n == k) for n, x in enumerate(args)] for side in (-1, 1)]
        less, more = (HIGH.applied(op, side) for side in sides)
        assert abs((more - less) / (2 * STEP) - slope) < 1e-30


@pytest.mark.parametrize("op", DIFFERENTIALS)
def test_a_differential_is_the_sum_of_slopes_times_those_of_the_arguments(op: Op) -> None:
    args, changes = AT[: count(op)], CHANGES[: count(op)]
    value = HIGH.applied(op, args)
    total = DIFFERENTIALS[op](value, args, changes, HIGH)
    slopes = slopes_of(op, value, args, HIGH)
    assert abs(total - sum(a * b for a, b in zip(slopes, changes, strict=True))) < 1e-45


def test_every_operation_of_the_graph_has_a_differential() -> None:
    assert GRAPH_OPS - {Op.CONST, Op.INPUT} <= DIFFERENTIALS.keys()


@pytest.mark.parametrize("op", FORMULA_OPS)
def test_differentials_of_formulas_have_the_values_of_those_of_numbers(op: Op) -> None:
    x, dx = (tuple(map(symbol, names[: count(op)])) for names in ("ab", "cd"))
    args, changes = AT[: count(op)], CHANGES[: count(op)]
    formula = DIFFERENTIALS[op](Expression(op, x), x, dx, FORMULAS)
    number = DIFFERENTIALS[op](HIGH.applied(op, args), args, changes, HIGH)
    names = dict(zip((one.name for one in (*x, *dx)), (*args, *changes), strict=True))
    assert traced(formula, names) == number
