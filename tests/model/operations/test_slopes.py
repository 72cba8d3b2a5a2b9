"""The one table of derivatives: against differences in 50 digits, and what it gives of formulas."""

from __future__ import annotations

import pytest

from kousoku.model.expressions.derivative import FORMULAS
from kousoku.model.numbers.digits import CONTEXT, HIGH
from kousoku.model.numbers.traced import traced
from kousoku.model.operations.expression import Expression, symbol
from kousoku.model.operations.graph import BINARY_OPS, GRAPH_OPS, Op
from kousoku.model.operations.slopes import SLOPES

#: Where all of them have a value, and both arguments of max differ.
AT = (CONTEXT.mpf("0.7"), CONTEXT.mpf("0.3"))
STEP = CONTEXT.mpf(10) ** -16


@pytest.mark.parametrize("op", SLOPES)
def test_a_slope_is_the_limit_of_differences(op: Op) -> None:
    args = AT if op in BINARY_OPS else AT[:1]
    found = SLOPES[op](HIGH.applied(op, args), args, HIGH)
    assert len(found) == len(args)
    for k, slope in enumerate(found):
        sides = [[x + side * STEP * (n == k) for n, x in enumerate(args)] for side in (-1, 1)]
        less, more = (HIGH.applied(op, side) for side in sides)
        assert abs((more - less) / (2 * STEP) - slope) < 1e-30


def test_every_operation_of_the_graph_has_slopes() -> None:
    assert GRAPH_OPS - {Op.CONST, Op.INPUT} <= SLOPES.keys()


@pytest.mark.parametrize("op", [Op.SIN, Op.COS, Op.TAN, Op.SQRT, Op.ASIN, Op.ACOS, Op.ATAN, Op.LOG])
def test_slopes_of_formulas_have_the_values_of_slopes_of_numbers(op: Op) -> None:
    x = symbol("x")
    (formula,) = SLOPES[op](Expression(op, (x,)), (x,), FORMULAS)
    (number,) = SLOPES[op](HIGH.applied(op, AT[:1]), AT[:1], HIGH)
    assert traced(formula, {"x": AT[0]}) == number
