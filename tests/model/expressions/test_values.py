"""The value of a formula, and nothing where it has none that is real and finite."""

from __future__ import annotations

import math

import pytest

from kousoku.model.expressions.parser import ARGUMENTS, parse_expression
from kousoku.model.expressions.values import value_of

VALUES = {"t": 0.75, "k": -2.0}

FORMULAS = {
    "2*t + k - 1": -1.5,
    "-(t/k)": 0.375,
    "k^2 + t^k + 4^0.5": 4 + 0.75**-2 + 2,
    "sin(t)": math.sin(0.75),
    "cos(t)": math.cos(0.75),
    "tan(t)": math.tan(0.75),
    "asin(t)": math.asin(0.75),
    "acos(t)": math.acos(0.75),
    "atan(k)": math.atan(-2),
    "atan2(t, k)": math.atan2(0.75, -2),
    "sqrt(t)": math.sqrt(0.75),
    "exp(k)": math.exp(-2),
    "log(t)": math.log(0.75),
    "abs(k)": 2,
    "sign(k)": -1,
    "min(t, k)": -2,
    "max(t, k, 3)": 3,
    "pi": math.pi,
}


@pytest.mark.parametrize("text", FORMULAS)
def test_a_formula_has_its_value(text: str) -> None:
    assert value_of(parse_expression(text, VALUES), VALUES) == pytest.approx(FORMULAS[text])


def test_every_function_is_tried() -> None:
    assert all(any(f"{name}(" in text for text in FORMULAS) for name in ARGUMENTS)


@pytest.mark.parametrize("text", ["log(k)", "1/(t - t)", "sqrt(k)", "k^0.3", "exp(exp(exp(9)))"])
def test_what_is_not_real_and_finite_is_not_a_number(text: str) -> None:
    assert math.isnan(value_of(parse_expression(text, VALUES), VALUES))
