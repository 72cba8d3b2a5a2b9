"""Numbers with derivatives along many directions at once: truncated polynomials of degree two.

A plain number is a ``float``, or a number of mpmath of as many digits as wanted. A :class:`Jet` is
x(ε) = x + x₁ ε + x₂ ε² along each of some directions: where bodies move, what is made of their
positions has ẋ = x₁ and ẍ = 2 x₂.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    Number = Any
    Vector = Sequence[Any]
    Matrix = Sequence[Vector]


@dataclass(frozen=True, slots=True, eq=False)
class Jet:
    """A number and its first two coefficients along some directions.

    Parameters
    ----------
    value : number
        What it is.
    first, second : array
        x₁ and x₂ along each direction.
    """

    value: Number
    first: Any
    second: Any

    def through(self, f: Number, slope: Number, bend: Number) -> Jet:
        """Value f(x), given f, f′ and f″ at its value."""
        square = self.first * self.first
        return Jet(f, slope * self.first, slope * self.second + bend / 2 * square)

    def __neg__(self) -> Jet:
        return Jet(-self.value, -self.first, -self.second)

    def __add__(self, other: Number) -> Number:
        if not isinstance(other, Jet):
            return Jet(self.value + other, self.first, self.second)
        first, second = self.first + other.first, self.second + other.second
        return Jet(self.value + other.value, first, second)

    __radd__ = __add__

    def __sub__(self, other: Number) -> Number:
        return self + -other

    def __rsub__(self, other: Number) -> Number:
        return -self + other

    def __mul__(self, other: Number) -> Number:
        if not isinstance(other, Jet):
            return Jet(self.value * other, self.first * other, self.second * other)
        x, y = self.value, other.value
        first = self.first * y + other.first * x
        second = self.second * y + self.first * other.first + other.second * x
        return Jet(x * y, first, second)

    __rmul__ = __mul__

    def __truediv__(self, other: Number) -> Number:
        return self * (other**-1 if isinstance(other, Jet) else 1 / other)

    def __rtruediv__(self, other: Number) -> Number:
        return self**-1 * other

    def __pow__(self, n: Number) -> Number:
        if isinstance(n, Jet):
            return exp(log(self) * n)
        x = self.value
        slope = n * x ** (n - 1) if n else 0
        bend = n * (n - 1) * x ** (n - 2) if n * (n - 1) else 0
        return self.through(x**n, slope, bend)

    def __rpow__(self, base: Number) -> Number:
        return exp(self * log(base))


def value_of(x: Number) -> Number:
    """Value of a number, without its derivatives."""
    return x.value if isinstance(x, Jet) else x


def _plain(name: str, x: Number, *more: Number) -> Number:
    """Function of plain numbers: of mpmath where one of them is."""
    for one in (x, *more):
        if hasattr(one, "context"):
            return getattr(one.context, name)(x, *more)
    return getattr(math, name)(x, *more)


def _smooth(
    name: str, slope: Callable[[Number, Number], Number], bend: Callable[[Number, Number], Number]
) -> Callable[[Number], Number]:
    """Smooth function by its name, given f′ and f″ from x and f."""

    def function(x: Number) -> Number:
        f = _plain(name, value_of(x))
        if not isinstance(x, Jet):
            return f
        return x.through(f, slope(x.value, f), bend(x.value, f))

    return function


sin = _smooth("sin", lambda x, _: _plain("cos", x), lambda _, f: -f)
cos = _smooth("cos", lambda x, _: -_plain("sin", x), lambda _, f: -f)
tan = _smooth("tan", lambda _, f: 1 + f * f, lambda _, f: 2 * f * (1 + f * f))
exp = _smooth("exp", lambda _, f: f, lambda _, f: f)
log = _smooth("log", lambda x, _: 1 / x, lambda x, _: -1 / (x * x))
atan = _smooth(
    "atan", lambda x, _: 1 / (1 + x * x), lambda x, _: -2 * x / ((1 + x * x) * (1 + x * x))
)
sqrt = _smooth("sqrt", lambda _, f: 1 / (2 * f), lambda x, f: -1 / (4 * x * f))
asin = _smooth(
    "asin",
    lambda x, _: 1 / _plain("sqrt", 1 - x * x),
    lambda x, _: x / ((1 - x * x) * _plain("sqrt", 1 - x * x)),
)
acos = _smooth(
    "acos",
    lambda x, _: -1 / _plain("sqrt", 1 - x * x),
    lambda x, _: -x / ((1 - x * x) * _plain("sqrt", 1 - x * x)),
)


def atan2(y: Number, x: Number) -> Number:
    """Angle of (x, y), in (−π, π] but for what its derivatives add."""
    angle = _plain("atan2", value_of(y), value_of(x))
    if not (isinstance(x, Jet) or isinstance(y, Jet)):
        return angle
    c, s = cos(angle), sin(angle)
    rest = atan((y * c - x * s) / (x * c + y * s))
    return Jet(angle, rest.first, rest.second)


def sign(x: Number) -> Number:
    """Sign −1, 0 or 1."""
    return int(value_of(x) > 0) - int(value_of(x) < 0)


def absolute(x: Number) -> Number:
    """Absolute value |x|."""
    return -x if value_of(x) < 0 else x


def least(*given: Number) -> Number:
    """Smallest of some numbers."""
    return min(given, key=value_of)


def largest(*given: Number) -> Number:
    """Largest of some numbers."""
    return max(given, key=value_of)


def dot(a: Vector, b: Vector) -> Number:
    """Scalar product a·b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector, b: Vector) -> Vector:
    """Cross product a × b."""
    return [a[k - 2] * b[k - 1] - a[k - 1] * b[k - 2] for k in range(3)]


def plus(a: Vector, b: Vector) -> Vector:
    """Sum a + b."""
    return [x + y for x, y in zip(a, b, strict=True)]


def minus(a: Vector, b: Vector) -> Vector:
    """Difference a − b."""
    return [x - y for x, y in zip(a, b, strict=True)]


def times(factor: Number, a: Vector) -> Vector:
    """Vector multiplied by a number."""
    return [x * factor for x in a]


def norm(a: Vector) -> Number:
    """Norm |a|."""
    return sqrt(dot(a, a))


def unit(a: Vector) -> Vector:
    """Unit vector a / |a|, in two steps, so that no square overflows."""
    size = max(abs(value_of(x)) for x in a)
    a = [x / size for x in a]
    return times(1 / norm(a), a)


def across(a: Vector, b: Vector) -> Vector:
    """Unit vector along what of b is across a, a of norm one."""
    return unit(minus(b, times(dot(a, b), a)))


def any_across(a: Vector) -> Vector:
    """One of the unit vectors across another one."""
    k = min(range(3), key=lambda m: abs(value_of(a[m])))
    return across(a, [int(m == k) for m in range(3)])


def turned(A: Matrix, a: Vector) -> Vector:
    """Vector A a."""
    return [dot(row, a) for row in A]


def transposed(A: Matrix) -> Matrix:
    """Transpose Aᵀ."""
    return [[row[k] for row in A] for k in range(3)]


def back(A: Matrix, a: Vector) -> Vector:
    """Vector Aᵀ a."""
    return turned(transposed(A), a)


def product(A: Matrix, B: Matrix) -> Matrix:
    """Product A B."""
    return transposed([turned(A, column) for column in transposed(B)])


IDENTITY: Matrix = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]


def rotation(p: Vector) -> Matrix:
    """Matrix A of a quaternion of any norm but zero, the images of the axes under p ∘ a ∘ p⁻¹."""
    square = p[0] * p[0] + dot(p[1:], p[1:])
    images = []
    for axis in IDENTITY:
        image = hamilton(hamilton(p, [0, *axis]), [p[0], *times(-1, p[1:])])
        images.append(times(1 / square, image[1:]))
    return transposed(images)


def hamilton(p: Vector, q: Vector) -> Vector:
    """Product of two quaternions, scalar first."""
    e, f = p[1:], q[1:]
    vector = plus(plus(times(p[0], f), times(q[0], e)), cross(e, f))
    return [p[0] * q[0] - dot(e, f), *vector]


def about(axis: Vector, angle: Number) -> Matrix:
    """Matrix A of a turn about an axis of any length; none where the axis is zero."""
    if not any(axis):
        return IDENTITY
    return rotation([cos(angle / 2), *times(sin(angle / 2), unit(axis))])


def least_turn(a: Vector, b: Vector) -> Matrix:
    """Matrix A of the smallest turn that takes a unit vector to another one."""
    between = plus(a, b)
    if max(abs(x) for x in between) < 1e-7:  # half a turn, about any direction across
        return rotation([0, *any_across(a)])
    return rotation([dot(a, unit(between)), *cross(a, unit(between))])


def array(values: Any) -> Any:
    """Array of doubles, or of objects where there are numbers of mpmath."""
    return np.array(values, dtype=float if _are_doubles(values) else object)


def _are_doubles(values: Any) -> bool:
    flat = np.array(values, dtype=object).ravel()
    return all(isinstance(x, float | int | np.floating) for x in flat)
