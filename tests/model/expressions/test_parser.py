"""Formulas of a scene: what is read, and what is refused at which column."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kousoku.model.angles import PI
from kousoku.model.errors import ExpressionError
from kousoku.model.expressions.parser import ARGUMENTS, DEEPEST, LONGEST_FORMULA, parse_expression
from kousoku.model.operations.expression import Expression, names_of, number, ordered, symbol
from kousoku.model.operations.graph import Op

NAMES = ("t", "x", "spring.elongation")
T, X = symbol("t"), symbol("x")


def read(text: str) -> Expression:
    return parse_expression(text, NAMES)


def num(value: float | str) -> Expression:
    return number(Fraction(value))


def call(op: Op, *args: Expression) -> Expression:
    return Expression(op, args)


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("t", T),
        ("spring.elongation", symbol("spring.elongation")),
        ("0.1", num("1/10")),
        (" 1.5e-3 ", num("3/2000")),
        (".5 + 1.", num("3/2")),
        ("pi", number(PI)),
        ("deg", number(PI / 180)),
        ("30 deg", number(PI / 6)),
        ("30*deg", number(PI / 6)),
        ("-30deg", number(-PI / 6)),
        ("1/2*deg", number(PI / 360)),
        ("30 deg/2", number(PI / 12)),
        ("1/(2 deg)", number(90 / PI)),
        ("(2 deg)^2", number(PI / 90 * PI / 90)),
        ("30 deg + t", call(Op.ADD, number(PI / 6), T)),
        ("30 deg*t", call(Op.MUL, number(PI / 6), T)),
        ("t + x", call(Op.ADD, T, X)),
        ("t - x", call(Op.ADD, T, call(Op.NEG, X))),
        ("2*3*t", call(Op.MUL, num(6), T)),
        ("t/x/2", call(Op.DIV, call(Op.DIV, T, X), num(2))),
        ("t*x^2", call(Op.MUL, T, call(Op.POW, X, num(2)))),
        ("-t^2", call(Op.NEG, call(Op.POW, T, num(2)))),
        ("t^-2", call(Op.POW, T, num(-2))),
        ("2^3^2", num(512)),
        ("(2^3)^2", num(64)),
        ("-2^2", num(-4)),
        ("--t", T),
        ("t*-x", call(Op.MUL, T, call(Op.NEG, X))),
        ("0*t + x", X),
        ("atan2(t, x)", call(Op.ATAN2, T, X)),
        ("max(t, x, 1)", call(Op.MAX, call(Op.MAX, T, X), num(1))),
        ("sin(\n t )", call(Op.SIN, T)),
    ],
)
def test_a_formula_is_read_as_it_is_written_by_hand(text: str, wanted: Expression) -> None:
    assert read(text) == wanted


@pytest.mark.parametrize("name", ARGUMENTS)
def test_every_function_can_be_called(name: str) -> None:
    args = ("t", "x")[: ARGUMENTS[name]]
    assert read(f"{name}({', '.join(args)})") == call(Op(name), *map(symbol, args))


@pytest.mark.parametrize(
    ("text", "column", "says"),
    [
        ("", 1, "the formula ends where a number, a name or a '(' is wanted"),
        ("t +", 4, "the formula ends where"),
        ("2 * * t", 5, "'*' stands where a number"),
        ("2 ** t", 3, "'**' is no operator; wanted ^"),
        ("2 t", 3, "'t' stands where an operator is wanted; write the multiplication sign"),
        ("t(2)", 2, "write the multiplication sign"),
        ("t)", 2, "')' stands where an operator is wanted"),
        ("(t", 3, "the formula ends before the '(' of column 1 is closed"),
        ("sin(t x)", 7, "'x' stands before the '(' of column 4 is closed"),
        ("sin t", 5, "'(' is missing: sin is a function"),
        ("sin()", 5, "')' stands where a number"),
        ("sin(t, x)", 1, "sin of 2 arguments; wanted 1"),
        ("min(t)", 1, "min of 1 arguments; wanted 2 or more"),
        ("2 + sni(t)", 5, "unknown name 'sni'; did you mean 'sin'?"),
        ("spring.elongatoin", 1, "did you mean 'spring.elongation'?"),
        ("t.x", 1, "unknown name 't.x'"),
        ("t / 0", 5, "a division by zero"),
        ("t / (1 - 1)", 5, "a division by zero"),
        ("(-2)^0.5", 1, "a negative number to a power that is not whole"),
        ("0^-1", 1, "zero to a power"),
        ("1e51", 1, "too large"),
        ("1e-200", 1, "too small"),
        ("t + 9^900*x", 1, "has a number beyond 1.8e+308, the largest double"),
        ("t^-9^900", 1, "has a number beyond 1.8e+308"),
        ("t; x", 2, "';' belongs to no formula"),
        ("t = 2", 3, "'=' belongs to no formula"),
        ("[t]", 1, "'[' belongs to no formula"),
        ('"t"', 1, "'\"' belongs to no formula"),
        ("２", 1, "belongs to no formula"),
        ("__import__('os').system('ls')", 1, "unknown name '__import__'"),
        ("t.__class__", 1, "unknown name 't.__class__'"),
        ("(lambda: 0)()", 8, "':' belongs to no formula"),
    ],
)
def test_what_is_no_formula_is_refused_at_its_column(text: str, column: int, says: str) -> None:
    with pytest.raises(ExpressionError) as caught:
        read(text)
    assert caught.value.column == column
    assert says in caught.value.problem
    assert str(caught.value).startswith(f"column {column}: ")


@pytest.mark.parametrize(
    "text",
    [
        "(" * 5000 + "t" + ")" * 5000,
        "(" * (DEEPEST + 1) + "t" + ")" * (DEEPEST + 1),
        "sin(" * (DEEPEST + 1) + "t" + ")" * (DEEPEST + 1),
        "-" * (DEEPEST + 1) + "t",
        "t^" * (DEEPEST + 1) + "t",
        "t*" * (DEEPEST + 1) + "t",
        "t" + " " * LONGEST_FORMULA,
        "9" * 41,
    ],
)
def test_a_formula_without_end_is_refused(text: str) -> None:
    with pytest.raises(ExpressionError):
        read(text)


def test_a_deep_formula_and_a_long_sum_are_read() -> None:
    assert names_of(read("(" * DEEPEST + "t" + ")" * DEEPEST)) == ("t",)
    assert names_of(read("x" + " + sin(t)" * 200)) == ("x", "t")


@pytest.mark.parametrize("text", ["9^9^9^9^9", "((1e50^64)^64)^64", "(1.1^99)^99^99"])
def test_a_tower_of_powers_stays_small(text: str) -> None:
    numbers = [part.value for part in ordered(read(text)) if part.value is not None]
    assert all(max(map(int.bit_length, n.as_integer_ratio())) < 10_000 for n in numbers)


def test_a_name_that_is_given_wins_over_a_function() -> None:
    assert parse_expression("pi + exp", ("exp", "pi")) == call(Op.ADD, symbol("pi"), symbol("exp"))


@settings(max_examples=500, deadline=None)
@given(st.text(max_size=40) | st.text("tx+-*/^(),. 0123456789sinmaxpe", max_size=40))
def test_any_text_is_a_formula_or_refused(text: str) -> None:
    try:
        expression = read(text)
    except ExpressionError as error:
        assert 1 <= error.column <= len(text) + 1
        assert error.problem
    else:
        assert set(names_of(expression)) <= set(NAMES)
