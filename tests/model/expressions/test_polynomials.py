"""Formulas as polynomials: their square parts, and whether they have real roots."""

import math

import pytest

from kousoku.model.expressions.parser import parse_expression
from kousoku.model.expressions.polynomials import is_never_zero, polynomial_of, square_part
from kousoku.model.expressions.values import value_of

VALUES = {"x": 1.25, "y": -0.75, "z": 2.5}


@pytest.mark.parametrize(
    ("formula", "rest", "root"),
    [
        ("x^2 - 2*x + 1", "1", "x - 1"),
        ("4*x*x - 4*x + 1", "4", "x - 1/2"),
        ("2*(x - 1)^2*(x^2 + 1)", "2*x^2 + 2", "x - 1"),
        ("(x - 1)^2*(x - 2)^4*(x - 3)^3", "(x - 3)^3", "(x - 1)*(x - 2)^2"),
        ("x^6*(y + 1)^2*z^5", "z^5", "x^3*(y + 1)"),
        ("-x^4 + 2*x^2 - 1", "-1", "x^2 - 1"),
        ("x^2 - 2*x*y + y^2", "1", "x - y"),
        ("3*z*(x^2 + y^2 + z^2 + 2*x*y - 2*x*z - 2*y*z)", "3*z", "x + y - z"),
        ("x^2*y + x^2*z", "y + z", "x"),
        ("(x^2 - x*y + 1)^2/7", "1/7", "x^2 - x*y + 1"),
        ("sin(x)^2 - 2*sin(x) + 1", "1", "sin(x) - 1"),
        ("0.01 - 0.2*x + x^2", "1", "x - 0.1"),
    ],
)
def test_the_square_part_of_a_polynomial(formula: str, rest: str, root: str) -> None:
    found = square_part(parse_expression(formula, VALUES))
    assert found is not None
    product = math.prod(value_of(a, VALUES) ** (n // 2) for a, n in found.powers)
    for value, wanted in ((value_of(found.rest, VALUES), rest), (product, root)):
        right = value_of(parse_expression(wanted, VALUES), VALUES)
        assert abs(value) == pytest.approx(abs(right), rel=1e-13)


@pytest.mark.parametrize(
    "formula",
    [
        "x",
        "x^2 - 2*x + 1.0000000001",
        "x^3",
        "x^2 + y^2",
        "4",
        "0*x",
        "sqrt(x)",
        "x^2 - y",
        "x*y*z",
    ],
)
def test_what_has_no_square_part(formula: str) -> None:
    assert square_part(parse_expression(formula, VALUES)) is None


@pytest.mark.parametrize(
    ("formula", "is_known"),
    [
        ("x^2 - x + 1", True),
        ("x^4 + 1e-9 - 2*x^2 + 1", True),
        ("x^4 - 1e-9 - 2*x^2 + 1", False),
        ("x^2 - 2*x + 1", False),
        ("x^3 + x + 1", False),
        ("sin(x)^2 + sin(x) + 1", True),
        ("x^2 + y^2 + 1", False),  # of several variables nothing is said
        ("x", False),
        ("0*x", False),
    ],
)
def test_which_polynomials_have_no_real_root(formula: str, is_known: bool) -> None:
    assert is_never_zero(parse_expression(formula, VALUES)) == is_known


def test_polynomials_that_would_be_too_long_are_left() -> None:
    for formula in ("(x + y + z + 1)^23", "((x + 1)^20)^20", "(x^20 + 1)*(x^20 + 2)"):
        assert polynomial_of(parse_expression(formula, VALUES)) is None


@pytest.mark.parametrize(
    ("formula", "same"),
    [
        ("sqrt(x^2 - 2*x + 1)", "sqrt((x - 1)^2)"),
        ("sqrt(9*x^2 - 18*x + 9)", "3*sqrt((x - 1)^2)"),
        ("(9*x^2 - 18*x + 9)^1.5", "27*((x - 1)^2)^1.5"),
        ("sqrt((x^2 - 2*x + 1)/y)", "sqrt(1/y)*sqrt((x - 1)^2)"),
        ("sqrt((x^2 - 1)^2/y)", "sqrt(1/y)*sqrt((x^2 - 1)^2)"),
        ("sqrt(1 + x^2)", "sqrt(1 + x^2)"),
        ("sqrt((x - 1)*(x - 1))", "sqrt((x - 1)*(x - 1))"),
        ("sqrt(-x^2)", "sqrt(-x^2)"),
    ],
)
def test_squares_in_a_root_are_read_as_such(formula: str, same: str) -> None:
    assert parse_expression(formula, VALUES) == parse_expression(same, VALUES)
