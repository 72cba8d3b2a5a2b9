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

from kousoku.model.operations.arithmetic import Arithmetic
from kousoku.model.operations.interpret import node_values

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from kousoku.model.operations.kernel import Kernel

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
        """Inverse 1/x by a step of Newton's method."""
        guess = Pair(1 / self.high, np.zeros_like(self.high))
        return guess * (number(2, guess) + -(self * guess))

    def root(self) -> Pair:
        """Root √x; NaN of a negative number."""
        guess = np.sqrt(self.high)
        rest = self + -(Pair(guess, 0 * guess) * Pair(guess, 0 * guess))
        return Pair(*_renormalised(guess, np.where(guess == 0, 0, rest.high / (2 * guess))))


def number(value: Fraction | int, like: Pair) -> Pair:
    """Number that is the same at every point."""
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
    """Angle function of each number."""
    with mpmath.workdps(DIGITS):
        columns = [[_exact(x, y) for x, y in zip(p.high, p.low, strict=True)] for p in args]
        values = [function(*row) for row in zip(*columns, strict=True)]
        high = [LONG(float(x)) + LONG(float(x - float(x))) for x in values]
        low = [LONG(float(x - _exact(y))) for x, y in zip(values, high, strict=True)]
    return Pair(np.array(high, dtype=LONG), np.array(low, dtype=LONG))


def _exact(*parts: Any) -> Any:
    ratios = (part.as_integer_ratio() for part in parts)
    return sum((mpmath.mpf(int(a)) / mpmath.mpf(int(b)) for a, b in ratios), mpmath.mpf(0))


@dataclass(frozen=True, slots=True)
class Wide:
    """Numbers with what an error is told by, one for each point.

    Parameters
    ----------
    value : Pair
        The numbers.
    gradient : mapping of (str, int) to (n,) array
        Derivatives by elements of inputs, in long doubles.
    whole : (n,) array
        What the numbers would be if no terms cancelled in sums.
    """

    value: Pair
    gradient: Mapping[tuple[str, int], Any]
    whole: Any

    def __add__(self, other: Wide) -> Wide:
        return _of(self.value + other.value, self.whole + other.whole, (self, 1), (other, 1))

    def __sub__(self, other: Wide) -> Wide:
        return self + -other

    def __neg__(self) -> Wide:
        return _of(-self.value, self.whole, (self, -1))

    def __mul__(self, other: Wide) -> Wide:
        a, b = self.value, other.value
        return _of(a * b, self.whole * other.whole, (self, b.high), (other, a.high))

    def __truediv__(self, other: Wide) -> Wide:
        inverse = other.value.inverse()
        quotient = self.value * inverse
        slopes = (self, inverse.high), (other, -quotient.high * inverse.high)
        return _of(quotient, self.whole * abs(inverse.high), *slopes)


def _of(value: Pair, whole: Any, *parts: tuple[Wide, Any]) -> Wide:
    """Numbers with the gradient Σ slope · ∇argument."""
    gradient: dict[tuple[str, int], Any] = {}
    for argument, slope in parts:
        for place, derivative in argument.gradient.items():
            gradient[place] = gradient.get(place, 0) + LONG(slope) * derivative
    return Wide(value, gradient, whole)


def _sqrt(x: Wide) -> Wide:
    root = x.value.root()
    return _of(root, np.sqrt(x.whole), (x, 1 / (2 * root.high)))


def _sin(x: Wide) -> Wide:
    value = _each(mpmath.sin, x.value)
    return _of(value, abs(value.high), (x, np.cos(x.value.high)))


def _cos(x: Wide) -> Wide:
    value = _each(mpmath.cos, x.value)
    return _of(value, abs(value.high), (x, -np.sin(x.value.high)))


def _atan2(y: Wide, x: Wide) -> Wide:
    value, square = _each(mpmath.atan2, y.value, x.value), y.value.high**2 + x.value.high**2
    slopes = (y, x.value.high / square), (x, -y.value.high / square)
    return _of(value, abs(value.high), *slopes)


def _none(*_: Wide) -> Wide:
    raise NotImplementedError("no formula of a kind has it")


def run(kernel: Kernel, points: Any) -> tuple[list[tuple[Pair, Any, Any]], Any]:
    """Evaluate a kernel at many points.

    Parameters
    ----------
    kernel : Kernel
        What is evaluated.
    points : (n, inputs) array
        The numbers of the inputs, one after the other, row-major; finite.

    Returns
    -------
    values : list of (Pair, (n,) array, (n,) array)
        For each element of each output its value, Σ |x ∂f/∂x|, and what it would be if no terms
        cancelled. Where the point is a pole they are not finite.
    is_double : (n,) array of bool
        Whether all numbers on the way are normal doubles or zero.
    """
    zero = np.zeros(len(points), dtype=LONG)

    def constant(value: Fraction) -> Wide:
        pair = number(value, Pair(zero, zero))
        return Wide(pair, {}, abs(pair.high))

    arithmetic = Arithmetic(
        constant, _sqrt, _sin, _cos, _atan2, exp=_none, log=_none, abs=_none, max=_none
    )
    places = [(quantity.name, k) for quantity in kernel.inputs for k in range(quantity.size)]
    columns = dict(zip(places, np.asarray(points, dtype=LONG).T, strict=True))
    inputs = {
        quantity.name: [
            Wide(Pair(x, zero), {place: 1 + zero}, abs(x))
            for place, x in columns.items()
            if place[0] == quantity.name
        ]
        for quantity in kernel.inputs
    }
    with np.errstate(all="ignore"):
        every = node_values(kernel, inputs, arithmetic)
        sizes = np.array([abs(one.value.high) for one in every])
        is_double = (sizes < np.finfo(float).max) & (sizes > SMALLEST) | (sizes == 0)
        found = [every[node] for result in kernel.results for node in result]
        return [
            (x.value, sum((abs(columns[p] * d) for p, d in x.gradient.items()), zero), x.whole)
            for x in found
        ], is_double.all(axis=0)
