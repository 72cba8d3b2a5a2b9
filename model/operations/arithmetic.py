"""Kinds of numbers to evaluate expressions over: functions beside the operators of Python."""

from __future__ import annotations

import math
import operator
from dataclasses import dataclass
from fractions import Fraction
from functools import reduce
from math import isqrt
from typing import TYPE_CHECKING, Any, Generic, TypeVar, cast

from kousoku.model.operations.graph import Op

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

Number = TypeVar("Number")


@dataclass(frozen=True, slots=True)
class Arithmetic(Generic[Number]):
    """A kind of numbers: its functions beside the operators + − × ÷ of Python.

    Parameters
    ----------
    number : callable
        Turns the exact value of a constant into a number, rounding once.
    sqrt, sin, cos, atan2, exp, log, abs, max : callable
        The functions of the graph; angles in radians.
    """

    number: Callable[[Fraction], Number]
    sqrt: Callable[[Number], Number]
    sin: Callable[[Number], Number]
    cos: Callable[[Number], Number]
    atan2: Callable[[Number, Number], Number]
    exp: Callable[[Number], Number]
    log: Callable[[Number], Number]
    abs: Callable[[Number], Number]
    max: Callable[[Number, Number], Number]


@dataclass(frozen=True, slots=True)
class FormulaArithmetic(Arithmetic[Number]):
    """A kind of numbers with all functions that the formulas of a scene may have.

    Parameters
    ----------
    number : callable
        Makes a number of an exact value or a double, which stands for its exact value.
    tan, asin, acos, atan, sign, min, pow : callable
        Functions that graphs lack.
    """

    number: Callable[[Fraction | float], Number]
    tan: Callable[[Number], Number]
    asin: Callable[[Number], Number]
    acos: Callable[[Number], Number]
    atan: Callable[[Number], Number]
    sign: Callable[[Number], Number]
    min: Callable[[Number, Number], Number]
    pow: Callable[[Number, Number], Number]

    def applied(self, op: Op, args: Sequence[Number]) -> Number:
        """Result of an operation on numbers; a sum may have more than two, from left to right."""
        if op is Op.ADD:
            return reduce(operator.add, args)
        call = OPERATORS.get(op) or getattr(self, op.value)
        return cast("Number", call(*args))


OPERATORS: dict[Op, Callable[..., Any]] = {
    Op.ADD: operator.add,
    Op.SUB: operator.sub,
    Op.MUL: operator.mul,
    Op.DIV: operator.truediv,
    Op.NEG: operator.neg,
}
"""Operators of Python that all numbers have."""


def _exact_sqrt(value: Fraction) -> Fraction:
    root = Fraction(isqrt(value.numerator), isqrt(value.denominator))
    if root * root != value:
        raise ArithmeticError(f"{value} has no rational square root")
    return root


def _not_rational(*_: Fraction) -> Fraction:
    raise ArithmeticError("angle functions, powers of e and logarithms are not rational")


#: Python floats; a division by zero raises, as it does in Python.
FLOAT: FormulaArithmetic[float] = FormulaArithmetic(
    number=float,
    sqrt=math.sqrt,
    sin=math.sin,
    cos=math.cos,
    atan2=math.atan2,
    exp=math.exp,
    log=math.log,
    abs=abs,
    max=max,
    tan=math.tan,
    asin=math.asin,
    acos=math.acos,
    atan=math.atan,
    sign=lambda a: float((a > 0) - (a < 0)),
    min=min,
    pow=pow,
)

#: Exact fractions; a root of what is not a square raises.
EXACT: Arithmetic[Fraction] = Arithmetic(
    Fraction,
    _exact_sqrt,
    _not_rational,
    _not_rational,
    _not_rational,
    _not_rational,
    _not_rational,
    abs,
    max,
)
