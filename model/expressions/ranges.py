"""Ranges of formulas: interval arithmetic with what is known of functions, whatever varies."""

from __future__ import annotations

import sys
from collections import Counter
from itertools import product
from math import acos, asin, atan, copysign, exp, inf, isinf, log, nextafter, pi, sqrt
from typing import TYPE_CHECKING

from kousoku.model.numbers.real import SMALLEST_SUBNORMAL
from kousoku.model.operations.expression import Expression, ordered
from kousoku.model.operations.graph import Op

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from fractions import Fraction

#: Functions that rise or fall, with the numbers between which they have a value.
MONOTONIC: Mapping[Op, tuple[Callable[[float], float], float, float]] = {
    Op.EXP: (exp, -inf, inf),
    Op.LOG: (lambda x: log(x) if x > 0.0 else -inf, 0.0, inf),
    Op.SQRT: (sqrt, 0.0, inf),
    Op.ATAN: (atan, -inf, inf),
    Op.ASIN: (asin, -1.0, 1.0),
    Op.ACOS: (acos, -1.0, 1.0),
}
#: Least and greatest values of other functions, whatever they are of.
RANGES = {Op.SIN: (-1.0, 1.0), Op.COS: (-1.0, 1.0), Op.SHARE: (0.0, 1.0)}
#: The largest double.
LARGEST = sys.float_info.max


def range_of(expression: Expression) -> tuple[float, float]:
    """Least and greatest value of a formula, as the ranges of its functions tell.

    The least of what is above zero is no less than the smallest double.
    """
    known: dict[int, tuple[float, float]] = {}
    for part in ordered(expression):
        least, most = -inf, inf
        if part.value is not None:
            least = most = _double(part.value)
        elif part.args:
            least, most = _range(part, known)
        known[id(part)] = min(least, LARGEST), max(most, -LARGEST)
    return known[id(expression)]


def _double(value: Fraction) -> float:
    """Number as a double, infinite where it is too large for that."""
    try:
        return float(value)
    except OverflowError:
        return inf if value > 0 else -inf


def _range(part: Expression, known: Mapping[int, tuple[float, float]]) -> tuple[float, float]:
    """Least and greatest value of a function, given those of its arguments."""
    args = [known[id(arg)] for arg in part.args]
    least, most = args[0]
    if part.op in MONOTONIC:
        function, first, last = MONOTONIC[part.op]
        ends = (min(max(end, first), last) for end in args[0])
        least, most = sorted(ends, reverse=part.op is Op.ACOS)
        low = SMALLEST_SUBNORMAL if part.op is Op.EXP else -inf
        return max(_end(function, least, -inf), low), _end(function, most, inf)
    match part.op:
        case Op.ADD:
            return sum(low for low, _ in args), sum(high for _, high in args)
        case Op.MAX | Op.MIN:
            combine = max if part.op is Op.MAX else min
            return combine(low for low, _ in args), combine(high for _, high in args)
        case Op.NEG:
            return -most, -least
        case Op.MUL | Op.DIV:
            sign, *sides = fraction_of(part)
            low, high = _quotient(*(_range_of_product(factors, known) for factors in sides))
            return (low, high) if sign > 0 else (-high, -low)
        case Op.POW:
            return _range_of_power(part, args)
        case Op.ABS:
            return _range_of_size(least, most)
        case Op.SIGN:
            return float((least > 0.0) - (least < 0.0)), float((most > 0.0) - (most < 0.0))
        case Op.ATAN2:
            half = nextafter(pi, inf) / (2.0 if args[1][0] >= 0.0 else 1.0)
            return 0.0 if least > 0.0 else -half, 0.0 if most < 0.0 else half  # zeros have signs
        case Op.LOG_SUM:  # of two that are equal it is larger by log(2)
            return max(low for low, _ in args), max(high for _, high in args) + 0.7
    return RANGES.get(part.op, (-inf, inf))


def _end(function: Callable[[float], float], at: float, beyond: float) -> float:
    """Value of a function at an end of a range, rounded to the outside unless it is exact."""
    try:
        value = function(at)
    except OverflowError:
        value = copysign(inf, at)
    return value if {at, value} <= {0.0, 1.0} else nextafter(value, beyond)


def _range_of_size(least: float, most: float) -> tuple[float, float]:
    """Least and greatest absolute value."""
    return max(least, -most, 0.0), max(most, -least)


def _range_of_power(part: Expression, args: Sequence[tuple[float, float]]) -> tuple[float, float]:
    """Least and greatest value of a power; one that is not whole is of a positive number."""
    (least, most), exponents = args
    exponent = part.args[1].value
    if exponent is None:
        if least <= 0.0:
            return 0.0 if least == 0.0 else -inf, inf
        low, high = _product(exponents, (_end(log, least, -inf), _end(log, most, inf)))
        return max(_end(exp, low, -inf), SMALLEST_SUBNORMAL), _end(exp, high, inf)
    if exponent.denominator > 1:
        least, most = max(least, 0.0), max(most, 0.0)
    elif exponent % 2 == 0:
        least, most = _range_of_size(least, most)
    size = float(abs(exponent))
    low, high = _end(lambda x: x**size, least, -inf), _end(lambda x: x**size, most, inf)
    low = max(low, SMALLEST_SUBNORMAL) if least > 0.0 else low
    return (low, high) if exponent > 0 else _quotient((1.0, 1.0), (low, high))


def _range_of_product(
    factors: Mapping[Expression, int], known: Mapping[int, tuple[float, float]]
) -> tuple[float, float]:
    """Least and greatest value of a product, of factors that may be there several times."""
    whole = 1.0, 1.0
    for factor, count in factors.items():
        ends = known[id(factor)]
        size = _range_of_size(*ends)
        for k in range(count):  # a square is not below zero
            whole = _product(whole, ends if k == 0 and count % 2 else size)
    return whole


def _product(a: tuple[float, float], b: tuple[float, float]) -> tuple[float, float]:
    """Least and greatest value of a product, which is zero where one of both is."""
    ends = [_above_zero(x * y, x, y) if x and y else 0.0 for x in a for y in b]
    return min(ends), max(ends)


def _quotient(a: tuple[float, float], b: tuple[float, float]) -> tuple[float, float]:
    """Least and greatest value of a quotient; unknown where the divisor may change its sign."""
    if b[0] < 0.0 < b[1] or b == (0.0, 0.0):
        return -inf, inf
    side = copysign(1.0, b[0] + b[1])
    ends = []
    for x, y in product(a, b):
        if not x or isinf(y):
            ends.append(0.0)
        else:
            ends.append(_above_zero(x / y, x, y) if y else copysign(inf, x) * side)
    return min(ends), max(ends)


def _above_zero(value: float, a: float, b: float) -> float:
    """Value of a product or quotient of numbers other than zero, which it is not either."""
    return value or copysign(SMALLEST_SUBNORMAL, a) * copysign(1.0, b)


def fraction_of(part: Expression) -> tuple[int, Counter[Expression], Counter[Expression]]:
    """Sign of a product, and what it is multiplied and divided by, with how often that is there."""
    sign, above, below = 1, Counter[Expression](), Counter[Expression]()
    while part.op in {Op.MUL, Op.DIV, Op.NEG} and part not in above:  # as (x/m)*(x/m)
        if part.op is Op.NEG:
            sign = -sign
        else:
            (above if part.op is Op.MUL else below)[part.args[1]] += 1
        part = part.args[0]
    above[part] += 1
    return sign, above, below
