"""Bounds of formulas: their parts are shared, and are walked once."""

from __future__ import annotations

import pytest

from kousoku.model.expressions.enclosure import Bounds, enclosure
from kousoku.model.expressions.parser import DEEPEST, parse_expression
from kousoku.model.operations.expression import ordered, symbol

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
