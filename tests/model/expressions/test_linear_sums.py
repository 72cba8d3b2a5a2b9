"""Linear sums of quantities that move together: what bounds them, and what they stand for."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import pytest

from kousoku.model.expressions.enclosure import Bounds
from kousoku.model.expressions.linear_sums import without_linear_sums
from kousoku.model.expressions.parser import parse_expression
from kousoku.model.operations.expression import ONE, add, mul, number, replaced, symbol
from tests.in_doubles import in_doubles

if TYPE_CHECKING:
    from collections.abc import Callable

NAMES = ("t", "x", "y", "x_dot", "y_dot", "k")
RATES = {
    "t": ONE,
    **{name: symbol(f"{name}_dot") for name in "xy"},
    **{f"{name}_dot": symbol(f"{name}_ddot") for name in "xy"},
}
VARYING = ("t", *(f"{name}{rate}" for name in "xy" for rate in ("", "_dot", "_ddot")))
SPANS = {name: Bounds(symbol(f"{name}.least"), symbol(f"{name}.most")) for name in VARYING}

#: A place, velocity and acceleration at each time.
Motion = tuple["Callable[[float], float]", "Callable[[float], float]", "Callable[[float], float]"]
MOTIONS: dict[str, tuple[Motion, Motion]] = {
    "as fast as each other": (
        (lambda t: 100.0 * t, lambda _: 100.0, lambda _: 0.0),
        (lambda t: 3.0 + 100.0 * t, lambda _: 100.0, lambda _: 0.0),
    ),
    "falling": (
        (lambda t: 7.0 * t - 4.9 * t * t, lambda t: 7.0 - 9.8 * t, lambda _: -9.8),
        (lambda t: 1.0 - 2.0 * t - 4.9 * t * t, lambda t: -2.0 - 9.8 * t, lambda _: -9.8),
    ),
    "turning back": (
        (
            lambda t: math.sin(9.0 * t),
            lambda t: 9.0 * math.cos(9.0 * t),
            lambda t: -81.0 * math.sin(9.0 * t),
        ),
        (
            lambda t: math.cos(5.0 * t),
            lambda t: -5.0 * math.sin(5.0 * t),
            lambda t: -25.0 * math.cos(5.0 * t),
        ),
    ),
}


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize(
    "text", ["y - x", "k*(x - y)/3 + 2 - 4*t", "x_dot - y_dot + x", "x - 100*t"]
)
@pytest.mark.parametrize("h", [1e-3, 0.05, 0.3])
def test_values_and_rates_are_within_their_bounds(motion: str, text: str, h: float) -> None:
    formula = parse_expression(text, NAMES)
    left, (linear,) = without_linear_sums(formula, RATES)
    assert left == symbol(linear.name)
    rate = add(*(mul(c, RATES[name]) for name, c in linear.coefficients.items()))
    bounds = linear.bounds("t", RATES, SPANS)
    for first in np.linspace(0.0, 1.0, 7):
        points = [point(motion, t) for t in np.linspace(first, first + h, 41)]
        numbers = {"k": -2.5}
        for name in VARYING:
            values = [one[name] for one in points]
            numbers |= {f"{name}.least": min(values), f"{name}.most": max(values)}
        for name, one in ((linear.name, formula), (linear.rate, rate)):
            least, most = (in_doubles(bound, numbers) for bound in bounds[name])
            values = [in_doubles(one, at | numbers) for at in points]
            assert least - 1e-9 <= min(values) <= max(values) <= most + 1e-9


def point(motion: str, t: float) -> dict[str, float]:
    numbers = {"t": t}
    for name, functions in zip("xy", MOTIONS[motion], strict=True):
        for rate, function in zip(("", "_dot", "_ddot"), functions, strict=True):
            numbers[f"{name}{rate}"] = function(t)
    return numbers


@pytest.mark.parametrize("motion", ["as fast as each other", "falling"])
def test_what_moves_alike_cancels(motion: str) -> None:
    """The distance of two bodies that fall changes as if one rested: by 0.9 in 0.1 s, not by 2."""
    (linear,) = without_linear_sums(parse_expression("y - x", NAMES), RATES)[1]
    ends = point(motion, 0.2), point(motion, 0.3)
    numbers = {
        f"{name}{end}": of(one[name] for one in ends)
        for name in VARYING
        for end, of in ((".least", min), (".most", max))
    }
    exact = abs((ends[1]["y"] - ends[1]["x"]) - (ends[0]["y"] - ends[0]["x"]))
    for name, width in ((linear.name, exact), (linear.rate, 0.0)):
        least, most = (in_doubles(b, numbers) for b in linear.bounds("t", RATES, SPANS)[name])
        assert most - least == pytest.approx(width, abs=0.1)


def test_the_largest_sums_have_names() -> None:
    formula = parse_expression("sin(2*(y - x) + t)*(k + x)*exp(y - x) + x^2", NAMES)
    left, sums = without_linear_sums(formula, RATES)
    named = {parse_expression("2*(y - x) + t", NAMES): "a", parse_expression("y - x", NAMES): "b"}
    assert {linear.formula for linear in sums} == named.keys()
    for linear in sums:
        left = replaced(left, symbol(linear.name), symbol(named[linear.formula]))
    assert left == parse_expression("sin(a)*(k + x)*exp(b) + x^2", [*NAMES, "a", "b"])
    (wave,) = (linear for linear in sums if "t" in linear.coefficients)
    assert wave.coefficients == {"x": number(-2), "y": number(2), "t": ONE}
    assert without_linear_sums(parse_expression("x*y + k*x + sin(t)", NAMES), RATES)[1] == ()
