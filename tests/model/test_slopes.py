"""The one table of derivatives: against differences in 50 digits, and what it gives of formulas."""

from __future__ import annotations

import pytest

from kousoku.model.derivative import FORMULAS
from kousoku.model.digits import CONTEXT, HIGH
from kousoku.model.graph import Op
from kousoku.model.slopes import SLOPES
from kousoku.model.terms import Apply, Function, Name
from kousoku.model.traced import traced

#: Where all of them have a value, and both arguments of max differ.
AT = (CONTEXT.mpf("0.7"), CONTEXT.mpf("0.3"))
TWO = {"add", "sub", "mul", "div", "atan2", "max"}
STEP = CONTEXT.mpf(10) ** -16


@pytest.mark.parametrize("operation", SLOPES)
def test_a_slope_is_the_limit_of_differences(operation: str) -> None:
    args = AT if operation in TWO else AT[:1]
    found = SLOPES[operation](HIGH.applied(operation, args), args, HIGH)
    assert len(found) == len(args)
    for k, slope in enumerate(found):
        sides = [[x + side * STEP * (n == k) for n, x in enumerate(args)] for side in (-1, 1)]
        less, more = (HIGH.applied(operation, side) for side in sides)
        assert abs((more - less) / (2 * STEP) - slope) < 1e-30


def test_every_operation_of_the_graph_has_slopes() -> None:
    assert {op.value for op in Op} - {"const", "input"} <= SLOPES.keys()


@pytest.mark.parametrize("operation", ["sin", "cos", "tan", "sqrt", "asin", "acos", "atan", "log"])
def test_slopes_of_formulas_have_the_values_of_slopes_of_numbers(operation: str) -> None:
    x = Name("x")
    (formula,) = SLOPES[operation](Apply(Function(operation), (x,)), (x,), FORMULAS)
    (number,) = SLOPES[operation](HIGH.applied(operation, AT[:1]), AT[:1], HIGH)
    assert traced(formula, {"x": AT[0]}) == number
