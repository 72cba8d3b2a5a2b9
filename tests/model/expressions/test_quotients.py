"""Quotients that are 0/0 somewhere: which have a limit there, and what bounds them."""

from __future__ import annotations

from itertools import islice
from unittest.mock import patch

import numpy as np
import pytest

from kousoku.model.expressions import quotients
from kousoku.model.expressions.derivative import derivative
from kousoku.model.expressions.enclosure import Bounds
from kousoku.model.expressions.parser import parse_expression
from kousoku.model.expressions.quotients import coefficients, without_quotients
from kousoku.model.numbers.digits import CONTEXT
from kousoku.model.numbers.traced import traced
from kousoku.model.operations.expression import ZERO, mul, symbol
from tests.in_doubles import in_doubles

SPANS = {"t": Bounds(symbol("first"), symbol("last"))}
#: Each with the power of what is zero at 5 that it is divided by.
LIMITS = {
    "sin(t - 5)/(t - 5)": 1,
    "(1 - cos(t - 5))/(t - 5)^2": 2,
    "(exp(t - 5) - 1)/(t - 5)": 1,
    "(t - 5)/(exp(t - 5) - 1)": 1,
    "sin(2*t - 10)/(t - 5)": 1,
    "(t - 5)/sin(t - 5)": 1,
    "(sin(3*(t - 5)) - 3*(t - 5))/(t - 5)^3": 3,
}


@pytest.mark.parametrize("text", LIMITS)
def test_bounds_are_those_of_the_limit(text: str) -> None:
    formula = parse_expression(text, ["t"])
    _, (quotient,) = without_quotients(formula, SPANS)
    assert quotient.order == LIMITS[text]
    rate = derivative(formula, "t")
    bounds = quotient.bounds(rate, derivative(quotient.vanishing_argument, "t"), SPANS)
    for first, last in ((4.9, 5.2), (4.99, 5.0), (5.0, 5.001), (4.8, 4.81), (5.05, 5.06)):
        times = [CONTEXT.mpf(time) for time in np.linspace(first, last, 8)[1:-1]]
        for name, one in ((quotient.name, formula), (quotient.rate, rate)):
            least, most = (
                in_doubles(bound, {"first": first, "last": last}) for bound in bounds[name]
            )
            values = [float(traced(one, {"t": time})) for time in times]
            assert least - 1e-9 <= min(values) <= max(values) <= most + 1e-9
            assert most - least < 30.0 * (last - first)


def test_a_quotient_of_a_quotient_varies_with_it() -> None:
    formula = parse_expression("sin(t)/t*(exp(t - 1) - 1)/(t - 1)", ["t"])
    anew, found = without_quotients(formula, SPANS)
    assert anew == mul(*(symbol(one.name) for one in found))
    assert [one.order for one in found] == [1, 1]
    assert without_quotients(parse_expression("(sin(t)/t)/t", ["t"]), SPANS)[1] == found[:1]


def test_what_varies_beside_is_a_factor() -> None:
    formula = parse_expression("t*sin(t - k)/(3*(t - k))", ["t", "k"])
    anew, (quotient,) = without_quotients(formula, SPANS)
    assert quotient.formula == parse_expression("sin(t - k)/(3*(t - k))", ["t", "k"])
    assert anew == mul(symbol("t"), symbol(quotient.name))


@pytest.mark.parametrize(
    "text",
    [
        *("1/(t - 5)", "cos(t - 5)/(t - 5)", "sin(t - 5)/(t - 5)^2", "sin(t)/(t - 5)", "abs(t)/t"),
        *("sqrt(t)/t", "sin(k)/k", "t*k/2", "log(t)/t", "sin(t)/(1 + t^2)", "t^0.5/sin(t)"),
    ],
)
def test_others_stay_what_they_are(text: str) -> None:
    formula = parse_expression(text, ["t", "k"])
    assert without_quotients(formula, SPANS) == (formula, ())


def test_factors_with_kinks_are_none_of_what_is_divided_by_z() -> None:
    """Their derivatives by the rules do not tell what happens across the kink."""
    formula = parse_expression("abs(t - 5)*(t - 5)/atan(t - 5)", ["t"])
    _, (quotient,) = without_quotients(formula, SPANS)
    assert quotient.formula == parse_expression("(t - 5)/atan(t - 5)", ["t"])
    formula = parse_expression("abs(t - 5)/sin(t - 5)", ["t"])
    assert without_quotients(formula, SPANS) == (formula, ())


def test_factors_are_those_of_taylor() -> None:
    formula = parse_expression("(exp(t) - 1)/t", ["t"])
    _, (quotient,) = without_quotients(formula, SPANS)
    found = [*islice(coefficients(quotient.numerator), 4)]
    assert found[0] == ZERO
    assert [one.value * 6 for one in found[1:] if one.value is not None] == [6, 3, 1]


def test_no_derivative_is_taken_that_tells_nothing() -> None:
    steps = "h*(t - p)/sqrt((t - p)^2 + w^2)*(t^3 + p*t^2 + w*t + 1)/(t^4 + p*t^2 + w^2)"
    formula = parse_expression(steps, ["t", "h", "p", "w"])
    with patch.object(quotients, "derivative", wraps=derivative) as taken:
        assert without_quotients(formula, ["t"]) == (formula, ())
    assert taken.call_count < 10  # and not all of each candidate for z
