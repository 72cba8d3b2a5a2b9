"""Printed operations: precedence, signs, and numbers that read back as they were."""

from fractions import Fraction

import pytest

from kousoku.codegen.printers import NUMPY, C, Precedence, Text
from kousoku.model.errors import EmitError
from kousoku.model.operations.graph import Op

A, B, X = Text("a"), Text("b"), Text("x")


def c(op: Op, *args: Text) -> Text:
    return C.apply(op, args)


SUM, DIFFERENCE = c(Op.ADD, A, B), c(Op.SUB, A, B)
PRODUCT, QUOTIENT, MINUS = c(Op.MUL, A, B), c(Op.DIV, A, B), c(Op.NEG, A)


@pytest.mark.parametrize(
    ("printed", "text"),
    [
        (c(Op.ADD, SUM, X), "a + b + x"),
        (c(Op.ADD, X, SUM), "a + b + x"),
        (c(Op.ADD, SUM, SUM), "a + b + (a + b)"),
        (c(Op.SUB, X, SUM), "x - (a + b)"),
        (c(Op.SUB, SUM, X), "a + b - x"),
        (c(Op.SUB, X, DIFFERENCE), "x - (a - b)"),
        (c(Op.MUL, SUM, X), "(a + b) * x"),
        (c(Op.MUL, X, PRODUCT), "a * b * x"),
        (c(Op.MUL, PRODUCT, PRODUCT), "a * b * (a * b)"),
        (c(Op.DIV, X, PRODUCT), "x / (a * b)"),
        (c(Op.DIV, PRODUCT, X), "a * b / x"),
        (c(Op.MUL, X, QUOTIENT), "a / b * x"),
        (c(Op.DIV, X, QUOTIENT), "x / (a / b)"),
        (c(Op.NEG, PRODUCT), "-(a * b)"),
        (c(Op.NEG, SUM), "-(a + b)"),
        (c(Op.MUL, MINUS, B), "-a * b"),
        (c(Op.MUL, B, MINUS), "b * -a"),
        (c(Op.NEG, MINUS), "-(-a)"),
        (c(Op.ADD, A, PRODUCT), "a + a * b"),
        (c(Op.SQRT, SUM), "sqrt(a + b)"),
        (c(Op.ATAN2, A, SUM), "atan2(a, a + b)"),
        (NUMPY.apply(Op.ATAN2, (A, SUM)), "np.arctan2(a, a + b)"),
        (NUMPY.apply(Op.SQRT, (X,)), "np.sqrt(x)"),
        (c(Op.EXP, X), "exp(x)"),
        (NUMPY.apply(Op.LOG, (X,)), "np.log(x)"),
        (c(Op.ABS, X), "fabs(x)"),
        (NUMPY.apply(Op.ABS, (X,)), "np.abs(x)"),
        (c(Op.MAX, A, B), "fmax(a, b)"),
        (NUMPY.apply(Op.MAX, (A, B)), "np.fmax(a, b)"),
        (c(Op.MUL, X, C.constant(Fraction(2))), "2.0 * x"),
        (c(Op.ADD, X, C.constant(Fraction(-1))), "x + -1.0"),
        (c(Op.DIV, C.constant(Fraction(1)), X), "1.0 / x"),
    ],
)
def test_the_text_keeps_the_order_of_evaluation(printed: Text, text: str) -> None:
    assert printed.text == text


@pytest.mark.parametrize("value", [0.1, 0.1 + 0.2, 1e-320, 1.7976931348623157e308, -1 / 3, 1e23])
def test_numbers_read_back_and_are_the_same_in_every_language(value: float) -> None:
    text = C.constant(Fraction(value)).text
    assert float(text) == value
    assert NUMPY.constant(Fraction(value)).text == text


def test_a_negative_number_binds_as_a_sign_does() -> None:
    assert C.constant(Fraction(-2)).precedence is Precedence.SIGN


def test_an_operation_without_an_entry_is_refused() -> None:
    with pytest.raises(EmitError, match="no entry"):
        C.apply(Op.CONST, ())


def test_a_number_beyond_the_doubles_is_refused() -> None:
    with pytest.raises(EmitError, match="scale the formula"):
        C.constant(Fraction(10) ** 400)
