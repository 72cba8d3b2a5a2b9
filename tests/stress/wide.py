"""Formulas of a derivation at many points at once, with about 38 digits.

A number is a pair of long doubles: twice their digits, and a range in which no product of scaled
inputs overflows. It tells where to look; what is found is computed once more with mpmath.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import mpmath
import numpy as np

from kousoku.codegen.tape import Step

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from kousoku.codegen.tape import Entry, Tape

LONG = np.longdouble
#: Splits a long double into halves, of which products are exact.
SPLIT = LONG(2) ** ((np.finfo(LONG).nmant + 2) // 2) + 1
#: Products above it are rounded as doubles are; what cancels may be smaller.
SMALLEST = LONG(2) ** -960
#: Digits of angle functions, which mpmath computes one by one.
DIGITS = 45


@dataclass(frozen=True, slots=True)
class Pair:
    """Numbers high + low, one for each point."""

    high: Any
    low: Any

    def __add__(self, other: Pair) -> Pair:
        total, error = _two_sum(self.high, other.high)
        small, rest = _two_sum(self.low, other.low)
        total, error = _renormalised(total, error + small)
        return Pair(*_renormalised(total, error + rest))

    def __neg__(self) -> Pair:
        return Pair(-self.high, -self.low)

    def __mul__(self, other: Pair) -> Pair:
        product, error = _two_product(self.high, other.high)
        error = error + (self.high * other.low + self.low * other.high)
        return Pair(*_renormalised(product, error))

    def inverse(self) -> Pair:
        """Return 1/x by a step of Newton's method."""
        guess = Pair(1 / self.high, np.zeros_like(self.high))
        return guess * (number(2, guess) + -(self * guess))

    def root(self) -> Pair:
        """Return √x; NaN of a negative number."""
        guess = np.sqrt(self.high)
        rest = self + -(Pair(guess, 0 * guess) * Pair(guess, 0 * guess))
        return Pair(*_renormalised(guess, np.where(guess == 0, 0, rest.high / (2 * guess))))


def number(value: Fraction | int, like: Pair) -> Pair:
    """Return the same number at every point."""
    high = LONG(value.numerator) / LONG(value.denominator)
    exact = Fraction(*(int(x) for x in high.as_integer_ratio()))
    rest = Fraction(value) - exact
    low = LONG(rest.numerator) / LONG(rest.denominator) if rest else LONG(0)
    return Pair(np.full_like(like.high, high), np.full_like(like.high, low))


def _two_sum(a: Any, b: Any) -> tuple[Any, Any]:
    total = a + b
    part = total - a
    return total, (a - (total - part)) + (b - part)


def _renormalised(a: Any, b: Any) -> tuple[Any, Any]:
    total = a + b
    return total, b - (total - a)


def _two_product(a: Any, b: Any) -> tuple[Any, Any]:
    product = a * b
    a_high, b_high = (SPLIT * x - (SPLIT * x - x) for x in (a, b))
    a_low, b_low = a - a_high, b - b_high
    error = ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low
    return product, error


def _each(function: Callable[..., Any], *args: Pair) -> Pair:
    """Return an angle function of each number."""
    with mpmath.workdps(DIGITS):
        columns = [[_exact(x, y) for x, y in zip(p.high, p.low, strict=True)] for p in args]
        values = [function(*row) for row in zip(*columns, strict=True)]
        high = [LONG(float(x)) + LONG(float(x - float(x))) for x in values]
        low = [LONG(float(x - _exact(y))) for x, y in zip(values, high, strict=True)]
    return Pair(np.array(high, dtype=LONG), np.array(low, dtype=LONG))


def _exact(*parts: Any) -> Any:
    ratios = (part.as_integer_ratio() for part in parts)
    return sum((mpmath.mpf(int(a)) / mpmath.mpf(int(b)) for a, b in ratios), mpmath.mpf(0))


def run(tape: Tape, points: Any) -> tuple[list[tuple[Pair, Any, Any]], Any]:
    """Evaluate a tape at many points.

    Parameters
    ----------
    tape : Tape
        What is evaluated.
    points : (n, inputs) array
        The numbers of the inputs, in the order of the tape; finite.

    Returns
    -------
    values : list of (Pair, (n,) array, (n,) array)
        For each element of each output its value, Σ |x ∂f/∂x|, and what it would be if no terms
        cancelled. Where the point is a pole they are not finite.
    is_double : (n,) array of bool
        Whether all numbers on the way are normal doubles or zero.
    """
    numbers = np.asarray(points, dtype=LONG).T
    values: list[Pair] = []
    slopes: list[dict[int, Any]] = []
    wholes: list[Any] = []
    with np.errstate(all="ignore"):
        for entry in tape.entries:
            value, partials = _evaluate(entry, [values[k] for k in entry.args], numbers)
            own = {entry.place: np.ones_like(numbers[0])} if entry.step is Step.INPUT else {}
            for argument, partial in zip(entry.args, partials, strict=True):
                for place, slope in slopes[argument].items():
                    own[place] = own.get(place, 0) + partial * slope
            values.append(value)
            slopes.append(own)
            wholes.append(_whole(entry, value, [wholes[k] for k in entry.args]))
        found = [position for _, positions in tape.outputs for position in positions]
        zero = np.zeros_like(numbers[0])
        sizes = np.array([abs(value.high) for value in values])
        is_double = (sizes < np.finfo(float).max) & (sizes > SMALLEST) | (sizes == 0)
        return [
            (values[k], sum((abs(numbers[i] * x) for i, x in slopes[k].items()), zero), wholes[k])
            for k in found
        ], is_double.all(axis=0)


def _whole(entry: Entry, value: Pair, args: Sequence[Any]) -> Any:
    """Return what an entry would be if no terms cancelled in sums."""
    if entry.step is Step.SUM:
        return sum(args)
    if entry.step is Step.PRODUCT:
        return np.prod(args, axis=0)
    if entry.step is Step.POWER and entry.number > 0:
        return args[0] ** LONG(float(entry.number))
    return abs(value.high)


def _evaluate(entry: Entry, args: Sequence[Pair], numbers: Any) -> tuple[Pair, list[Any]]:
    """Return the value of an entry, and its derivatives by its arguments."""
    like = Pair(numbers[0], 0 * numbers[0])
    match entry.step:
        case Step.NUMBER:
            return number(_ratio(entry), like), []
        case Step.INPUT:
            return Pair(numbers[entry.place], 0 * numbers[0]), []
        case Step.SUM:
            total = args[0]
            for other in args[1:]:
                total = total + other
            return total, [LONG(1)] * len(args)
        case Step.PRODUCT:
            return _product(args)
        case Step.POWER:
            return _power(args[0], _ratio(entry))
        case Step.SIN:
            return _each(mpmath.sin, *args), [np.cos(args[0].high)]
        case Step.COS:
            return _each(mpmath.cos, *args), [-np.sin(args[0].high)]
        case Step.ATAN2:
            y, x = (arg.high for arg in args)
            square = x * x + y * y
            return _each(mpmath.atan2, *args), [x / square, -y / square]


def _product(args: Sequence[Pair]) -> tuple[Pair, list[Any]]:
    value, partials = args[0], [LONG(1)]
    for other in args[1:]:
        partials = [x * other.high for x in partials] + [value.high]
        value = value * other
    return value, partials


def _power(base: Pair, exponent: Fraction) -> tuple[Pair, list[Any]]:
    """Return x^(n/2)."""
    factor = base.root() if exponent.denominator == 2 else base
    power = number(1, base)
    for _ in range(abs(exponent.numerator)):
        power = power * factor
    if exponent < 0:
        power = power.inverse()
    slope = LONG(exponent.numerator) / LONG(exponent.denominator) * power.high / base.high
    if exponent > 0:
        slope = np.where(base.high == 0, 1 if exponent == 1 else 0, slope)
    return power, [slope]


def _ratio(entry: Entry) -> Fraction:
    """Return a number of a tape: they are rational with small denominators."""
    return Fraction(float(entry.number)).limit_denominator(10**6)
