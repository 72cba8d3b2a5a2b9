"""Exponentials that cancel: what their quotients are, and what bounds them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import pytest

from kousoku.model.expressions.derivative import derivative
from kousoku.model.expressions.enclosure import Bounds, enclosure
from kousoku.model.expressions.exponentials import without_overflow
from kousoku.model.expressions.parser import parse_expression
from kousoku.model.expressions.values import value_of
from kousoku.model.operations.expression import symbol
from tests.in_doubles import in_doubles

if TYPE_CHECKING:
    from kousoku.model.operations.expression import Expression

SPANS = {"t": Bounds(symbol("first"), symbol("last"))}
#: Each is positive, at most 1, and less than 1e-12 where t is beyond 40.
HILLS = (
    "2/(exp(t) + exp(-t))",
    "4/(exp(t) + exp(-t))^2",
    "(2/(exp(t) + exp(-t)))^2",
    "exp(t)/(1 + exp(t))^2",
    "exp(-t)/(2*(1 + exp(-t))^2)",
    "1/(1 + exp(-t - 9)) - 1/(1 + exp(9 - t))",
    "(exp(t + 9) - exp(t - 9))/(1 + exp(t - 9))/(exp(t + 9) + 1)",
    "1/(1 + 3*exp(t^2/2))",
    "1/exp(t^2/2)",
    "exp(t)/(3*exp(t^2/2))/2",
    "(3 + exp(t))/(4*exp(t^2/2))/exp(1)",
    "1/(exp(t^2/2)/(3 + exp(-t)) + 5)",
)


def bounds_of(formula: Expression, first: float, last: float) -> tuple[float, float]:
    """Least and greatest value between two times."""
    bounds = enclosure(formula, SPANS)
    values = {"first": first, "last": last}
    return in_doubles(bounds.least, values), in_doubles(bounds.most, values)


@pytest.mark.parametrize("text", HILLS)
def test_what_is_written_anew_is_the_same_and_has_the_same_rate(text: str) -> None:
    formula = parse_expression(text, ["t"])
    anew = without_overflow(formula)
    assert anew != formula
    for one, other in ((formula, anew), (derivative(formula, "t"), derivative(anew, "t"))):
        for time in (-20.0, -3.0, -0.5, 0.0, 1e-3, 2.0, 12.5):
            low, high = bounds_of(other, time, time)
            assert low == high
            assert low == pytest.approx(value_of(one, {"t": time}), rel=1e-9, abs=1e-13)


@pytest.mark.parametrize("text", HILLS)
def test_hills_have_bounds_at_all_distances(text: str) -> None:
    formula = without_overflow(parse_expression(text, ["t"]))
    rate = derivative(formula, "t")
    for far in (60.0, 400.0, 1e4, 1e8, 1e150):
        for span in ((far, 1.2 * far), (-1.2 * far, -far)):
            for part in (formula, rate):
                least, most = bounds_of(part, *span)
                assert -1e-8 < least <= most < 1e-8


def test_bounds_are_as_narrow_as_intervals() -> None:
    formula = without_overflow(parse_expression(HILLS[0], ["t"]))
    slowest, fastest = bounds_of(derivative(formula, "t"), -1e-6, 1e-6)
    assert -3e-6 < slowest < -0.9e-6
    assert 0.9e-6 < fastest < 3e-6


def test_other_formulas_stay_what_they_are() -> None:
    for text in ("exp(-t^2)", "1/(1 + t^2)", "2/(exp(t) - exp(-t))", "(exp(t) + exp(-t))/2"):
        formula = parse_expression(text, ["t"])
        assert without_overflow(formula) is formula
    rate = derivative(parse_expression(HILLS[0], ["t"]), "t")
    assert math.isnan(bounds_of(rate, 800.0, 900.0)[1])
