"""Kinds of numbers: what an expression is evaluated over beside the operators of Python."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from math import isqrt
from typing import TYPE_CHECKING, Generic, TypeVar

if TYPE_CHECKING:
    from collections.abc import Callable

Number = TypeVar("Number")


@dataclass(frozen=True, slots=True)
class Arithmetic(Generic[Number]):
    """A kind of numbers: what the operators + − × ÷ of Python leave open.

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


def _exact_sqrt(value: Fraction) -> Fraction:
    root = Fraction(isqrt(value.numerator), isqrt(value.denominator))
    if root * root != value:
        raise ArithmeticError(f"{value} has no rational square root")
    return root


def _not_rational(*_: Fraction) -> Fraction:
    raise ArithmeticError("angle functions, powers of e and logarithms are not rational")


#: Python floats; a division by zero raises, as it does in Python.
FLOAT: Arithmetic[float] = Arithmetic(
    float, math.sqrt, math.sin, math.cos, math.atan2, math.exp, math.log, abs, max
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
