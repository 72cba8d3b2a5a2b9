"""Kinks and poles of formulas: which functions are zero there."""

from __future__ import annotations

import pytest

from kousoku.model.expressions.parser import parse_expression
from kousoku.model.expressions.switching import poles_of, switching_functions, varying_parts
from kousoku.model.operations.expression import symbol

NAMES = ("x", "y", "m")


@pytest.mark.parametrize(
    ("text", "kinks"),
    [
        ("-x*abs(x)", False),
        ("-x*abs(x)/m", False),
        ("x*abs(x)/(y^2 + 1)", False),
        ("x*abs(x)/tan(x)^2", True),
        ("x*abs(x)/(exp(x) - 1)^2", True),
        ("abs(x)/m", True),
    ],
)
def test_a_square_with_a_sign_is_smooth_unless_it_is_divided(text: str, kinks: bool) -> None:
    found = [*switching_functions(parse_expression(text, NAMES))]
    assert (symbol("x") in found) is kinks


@pytest.mark.parametrize(
    ("text", "is_pole"),
    [
        ("1/x", True),
        ("exp(1/x)", True),
        ("exp(-(1/x)^2)", False),
        ("exp(-(1/x))", True),
        ("tan(1/x)", True),
        ("y + x/abs(y/x)", True),
        ("atan(1/x)", False),
        ("sin(1/x)*y", False),
        ("atan2(y, 1/x)", False),
        ("sign(1/x)", False),
    ],
)
def test_what_is_bounded_has_no_pole(text: str, is_pole: bool) -> None:
    """Places were known to the noise of a pole there, and jumps were met late."""
    assert (symbol("x") in poles_of(parse_expression(text, NAMES), ("x", "y"))) is is_pole


def test_a_jump_is_looked_for_in_what_roots_and_powers_divide_by() -> None:
    found = [*switching_functions(parse_expression("atan(y/sqrt(x^3))", NAMES))]
    assert symbol("x") in found


@pytest.mark.parametrize(
    ("text", "hidden"),
    [
        ("sin(x + 3*exp(-(y^2)))", ["exp(-(y^2))"]),
        ("y*sqrt(1 + (x + sin(y))^2)", ["(x + sin(y))^2", "2*x*sin(y)"]),  # times a slope
        ("(m*(x + cos(y)))^12", ["12*(m*x)^11*(m*cos(y))"]),
        ("atan(-x*(2 + exp(-(x^2))))", ["exp(-(x^2))*x", "exp(-(x^2))"]),
        ("atan(x*(2 + exp(-(x^2))))", ["exp(-(x^2))*x", "exp(-(x^2))"]),
        ("sin(x + exp(-m*(y - 2)^2))", ["exp(-m*(y - 2)^2)"]),
        ("sin(x + exp(-abs(y)/m))", ["exp(-abs(y)/m)"]),
        ("1/(exp(x) + exp(-x) + exp(2*cos(y)))", ["exp(2*cos(y))", "cos(y)"]),  # others overflow
        ("atan(x + 2^y)", []),
        ("sin((x + exp(-(y^2)))/m)", ["exp(-(y^2))"]),
        ("sin(abs(m*(x + cos(y))))", ["cos(y)"]),
        ("log(max(x + cos(y), 1))", ["cos(y)"]),
        ("sin(x + exp(-(y^2))/(x + 1))", ["exp(-(y^2))/(x + 1)"]),
        ("exp(x + sin(y + cos(x)))", ["exp(x)*sin(y + cos(x))", "cos(x)"]),
        ("1/(2 + x^2 + max(1, cos(y)))", ["cos(y)"]),
        ("sin(exp(-(x^2)))", []),  # it stands beside nothing
        ("cos(m + sin(x))", ["sin(x)"]),
        ("1/(1 + m*exp(-(x^2)))", ["exp(-(x^2))"]),
        ("exp(m*exp(-(x^2)))", ["exp(-(x^2))"]),
        ("(x*(2 + exp(-(x^2))))^2", ["2*(2*x)*(exp(-(x^2))*x)", "exp(-(x^2))"]),
        ("(x + 3*exp(-(x^2)))^(-2)", ["exp(-(x^2))"]),  # not x^(-3) times that, which is infinite
        ("sin(cos(x) + 1/(2 + cos(x)))", ["cos(x)", "1/(2 + cos(x))"]),
        ("sin(cos(x) + 1/cos(x))", ["cos(x)", "1/cos(x)"]),
        ("exp(1 - exp((x - m)^2/2))", []),  # it grows
        ("exp(1 - exp((x - m)^2/(-2)))", ["exp((x - m)^2/(-2))"]),
        ("exp(m*exp(-(m*x/(x + 5))^2))", ["exp(-(m*x/(x + 5))^2)"]),  # zero at the pole
        ("1/(1 + m*exp(-(x/(x + 5))^2))", ["exp(-(x/(x + 5))^2)"]),
        ("exp(m/(1 + (x/(x + 5))^2))", ["m/(1 + (x/(x + 5))^2)"]),
        ("exp(m*(1 + (x/(x + 5))^2)^(-1.5))", ["(1 + (x/(x + 5))^2)^(-1.5)"]),
        ("sin(x + exp(1 - sqrt(1 + x^2)))", ["sqrt(1 + x^2)", "exp(1 - sqrt(1 + x^2))"]),
        ("sin(x + exp(-m*log(1 + x^2)))", ["log(1 + x^2)", "exp(-m*log(1 + x^2))"]),
        ("1/(2 + 1/(exp(x) + exp(-x)))", ["1/(exp(x) + exp(-x))"]),
        ("exp(1/(exp(x) + exp(-x)))", ["1/(exp(x) + exp(-x))"]),
        ("sin(x + 1/(1 + exp(-m*x)))", ["1/(1 + exp(-m*x))"]),
        ("asin(m + exp(-(x - m)*(x - m)/(m*m)))", ["exp(-(x - m)*(x - m)/(m*m))"]),
        ("sqrt(1 + m*exp(-x*x/m^2))", ["exp(-x*x/m^2)"]),
        ("asin(m + exp(-((x - m)/m)*((x - m)/m)))", ["exp(-((x - m)/m)*((x - m)/m))"]),
        ("sqrt(1 + m*exp(x*x/m^2))", []),
        ("sqrt(1 + exp((x - m)*(y - m)))", []),
        ("sqrt(1 + exp((cos(x) - 1)/m^2))", ["cos(x)", "exp((cos(x) - 1)/m^2)"]),
        ("log(2 + exp(-(1 - cos(x))/m^2))", ["cos(x)", "exp(-(1 - cos(x))/m^2)"]),
        ("1/(1 + exp(cos(x)/m^2))", ["cos(x)", "exp(cos(x)/m^2)"]),
        ("sqrt(1 + exp(-sqrt(x^2 + m^2)/m))", ["sqrt(x^2 + m^2)", "exp(-sqrt(x^2 + m^2)/m)"]),
        ("1/(2 + m^2/(m^2 + x^2))", ["m^2/(m^2 + x^2)"]),
        ("cos(m/(m + exp(x) + exp(-x)))", ["m/(m + exp(x) + exp(-x))"]),
        ("atan(1 + exp((m - 2)*x))", []),
        ("atan(x + exp(-1/x))", []),  # it is infinite on one side
        ("atan2(sin(x), cos(x))", []),
        ("atan2(abs(sin(x)), cos(x))", []),
        ("atan2(1 + x, exp(-(x^2)))", ["exp(-(x^2))"]),
        ("m^exp(-(x^2))", ["exp(-(x^2))"]),
        ("exp(-exp(-(x^2))^2/m)", ["exp(-(x^2))^2"]),
        ("exp(-y*sin(x)^2)", ["-y*sin(x)^2"]),
        ("exp(-abs(exp(-abs(x))))", ["exp(-abs(x))"]),
        ("exp(-(x^14))", []),
        ("1/(2 + m*exp(-(x^2))/y)", ["exp(-(x^2))"]),
        ("atan(1 + exp(-(x^2))*log(2 + x))", ["exp(-(x^2))"]),
        ("sin(x + exp(-(x^2))*2^x)", ["exp(-(x^2))"]),
        ("atan2(1, 2*exp(-(x^2))*3/(1 + x))", ["exp(-(x^2))"]),
        ("atan2(sin(x), m)", ["sin(x)"]),
        ("sin(x + y^2)", []),
        ("atan(x + 1/y^2)", []),  # it is infinite where y is zero, and the formula is not
        ("sin(x) + cos(y)", []),
    ],
)
def test_what_varies_beside_others_in_an_argument_is_a_part_of_its_own(
    text: str, hidden: list[str]
) -> None:
    parts = {part for part, _ in varying_parts(parse_expression(text, NAMES), {"x", "y"})}
    inner = {parse_expression(part, NAMES) for part in hidden}
    assert inner <= parts
    assert len(parts - inner) == (2 if text == "sin(x) + cos(y)" else 1)


def test_the_parts_of_long_sums_are_no_more_than_their_terms() -> None:
    """Slopes of exponentials were looked into in turn: as many parts as permutations."""
    text = "exp(" + " + ".join(f"cos({k}*x + y)" for k in range(1, 13)) + ")"
    assert len([*varying_parts(parse_expression(text, NAMES), {"x", "y"})]) < 40
