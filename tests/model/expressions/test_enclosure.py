"""Bounds of formulas: their parts are shared, and are walked once."""

from __future__ import annotations

import math
import random

import pytest

from kousoku.model.expressions.enclosure import Bounds, enclosure
from kousoku.model.expressions.parser import DEEPEST, parse_expression
from kousoku.model.operations.expression import ordered, symbol
from tests.in_doubles import in_doubles

SPANS = {"t": Bounds(symbol("t_least"), symbol("t_most"))}


@pytest.mark.parametrize("form", ["sin({})", "atan2({}, 2)", "0.5*({})", "({})^2", "t*({})"])
def test_the_deepest_formula_has_bounds_of_a_size_that_grows_with_it(form: str) -> None:
    sizes = []
    for depth in (DEEPEST // 4, DEEPEST // 2):
        text = "t"
        for _ in range(depth):
            text = form.format(text)
        bounds = enclosure(parse_expression(text, ["t"]), SPANS)
        sizes.append(len(list(ordered(bounds.most))))
    assert sizes[1] < 3 * sizes[0]


@pytest.mark.parametrize(
    "text",
    ["1/t", "1/abs(t)", "t^-2", "t^-3", "1/(1 + (1/t)^2)", "1/(1 + exp(1/t))", "min(1/t^2, 3)",
     "1/(1 + 1/(1 + 1/t))", "1/(t - t^2)", "1/(1 + (t/(cos(t)^2 + 0.1))^2)",
     "2*sqrt(t^2 - t + 1)", "max(2*log(t^2 - t + 1), -9)", "2*(t^2 - t + 1)^t",
     "2*asin(0.7*sin(t) + 0.3*sin(2*t)*cos(t)^2)", "min(acos(sin(t)*cos(3*t)^2), 2)"],
)  # fmt: skip
def test_no_value_is_outside(text: str) -> None:
    """Where an argument might be outside of a domain, bounds were no number, and left out."""
    draw, formula = random.Random(text), parse_expression(text, ["t"])
    bounds = enclosure(formula, SPANS)
    for _ in range(2000):
        ends = sorted(draw.choice((draw.gauss(0.0, 2.0), 0.0, 1e-200, 1e100)) for _ in range(2))
        place = ends[0] + (ends[1] - ends[0]) * draw.random()
        values = dict(zip(("t_least", "t_most"), ends, strict=True))
        least, most = (in_doubles(bound, values) for bound in bounds)
        value = in_doubles(formula, {"t": place})
        rounding = 1e-12 * (1.0 + abs(value))
        assert not math.isfinite(value) or least - rounding <= value <= most + rounding
