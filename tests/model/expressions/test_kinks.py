"""Kinks of a formula of time, and which of them two derivatives go through."""

import pytest

from kousoku.model.expressions.kinks import kink_of
from kousoku.model.expressions.parser import parse_expression

PARAMETERS = {"h": 0.3, "T": 2.0, "w": 3.0}


def kink(formula: str) -> str:
    found = kink_of(parse_expression(formula, ("t", *PARAMETERS)), "t", PARAMETERS)
    return found.op.value if found else ""


def blend(x: str) -> str:
    return f"(10*{x}^3 - 15*{x}^4 + 6*{x}^5)"


@pytest.mark.parametrize(
    "formula",
    [
        blend("min(t, 1)"),
        "h*" + blend("min(t/T, 1)"),
        blend("min(max(t - 1, 0), 1)"),
        blend("max(min((t - w)/T, 1), 0)"),
        "min(t, 1) - sin(2*pi*min(t, 1))/(2*pi)",
        "max(t - 1, 0)^3",
        "h*abs(t - T)^3",
        "min(h, w)*t",
        "t*sqrt((2 + sin(t))^2)",
        "((t - T)^2)^(3/2)",
        "((t - T)^2)^1.25",
        "((2 + sin(t))^2)^0.75",
        "h*sqrt((t - T)^2)*(t - T)^2",
        "(t^2 - 2*t + 1)*sqrt(t^2 - 2*t + 1)",
        "(t^4 - 4*t^3 + 6*t^2 - 4*t + 1)^(1/2)",
        "(t^4 - 4*t^3 + 6*t^2 - 4*t + 1)^0.75",
        "sqrt(2)*abs(t - 1) - sqrt(2*t^2 - 4*t + 2) + t",
        "sqrt(t^4 - 2*t^3 + 3*t^2 - 2*t + 1)",  # of t² - t + 1, which is never zero
        "sqrt((t + 1)^3)*h + sqrt(t^2 - 2*t + 1.0001)",
    ],
)
def test_two_derivatives_go_through(formula: str) -> None:
    assert kink(formula) == ""


@pytest.mark.parametrize(
    ("formula", "where"),
    [
        ("min(t, 1)", "min"),
        ("3*min(t, 1)^2 - 2*min(t, 1)^3", "min"),
        ("(1 - cos(pi*min(t, 1)))/2", "min"),
        ("max(t - 1, 0)^2", "max"),
        ("abs(t)", "abs"),
        ("sign(t - 1)", "sign"),
        ("sqrt((t - h)^2)", "sqrt"),
        ("t + ((t - 1)*(t - 1))^(1/2)", "pow"),
        ("((t - 1)^6)^(1/6)", "pow"),
        ("((t - T)^2)^0.75", "pow"),
        ("h*((t - T)^4)^(1/3)", "pow"),
        ("sqrt(t^2 - 2*t + 1)", "sqrt"),
        ("h + sqrt(T^2 + t*t - 2*T*t)", "sqrt"),
        ("sqrt(2*t^2 - 0.4*t + 0.02)", "sqrt"),
        ("sqrt((1 + t^2)*(t^2 - 2*t + 1)/h)", "sqrt"),
        ("sqrt(h^2*t^2 - 2*h*t + 1)", "sqrt"),
        ("sqrt(sin(t)^2 - sin(t) + 0.25)", "sqrt"),
        ("(t^4 - 4*t^3 + 6*t^2 - 4*t + 1)^0.25", "pow"),
        ("(t^2 - 2*t + 1)^0.75", "pow"),
        ("abs(t - T)^1.5", "abs"),
        ("min(t^2, 1)", "min"),
        (blend("min(t, T)"), "min"),
        (blend("min(t, 1)") + " + 1e-9*max(t - 1, 0)^2", "max"),
        (blend("min(max(t - 1, 0), 2)"), "min"),
    ],
)
def test_derivatives_jump_or_cannot_be_told(formula: str, where: str) -> None:
    assert kink(formula) == where


def test_parameters_of_the_scene_alone_do_not_make_it_smooth() -> None:
    """A run may change them: the coefficients must follow the parameter."""
    fitted = "10*min(t,T)^3/8 - 15*min(t,T)^4/16 + 6*min(t,T)^5/32"
    assert kink(fitted) == "min"
    assert kink(fitted.replace("T", "2")) == ""
