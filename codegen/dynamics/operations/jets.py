"""Numbers with their first and second derivative by time, in doubles or in 50 digits.

A function of a motion r(t), A(t) is evaluated with its rates: a residual C of a joint gives Ċ and
C̈, without a Jacobian.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from kousoku.model.operations.arithmetic import FormulaArithmetic
from kousoku.model.operations.expression import evaluated
from kousoku.model.operations.graph import Op

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from kousoku.model.numbers.real import Real
    from kousoku.model.operations.expression import Expression


class Jet:
    """A number x with ẋ and ẍ, in its unit, per s and per s².

    Parameters
    ----------
    x, d, dd : number
        Value, first and second derivative by time.
    """

    __slots__ = ("d", "dd", "x")

    def __init__(self, x: Real, d: Real = 0, dd: Real = 0) -> None:
        self.x, self.d, self.dd = x, d, dd

    def __add__(self, other: Jet) -> Jet:
        return Jet(self.x + other.x, self.d + other.d, self.dd + other.dd)

    def __sub__(self, other: Jet) -> Jet:
        return Jet(self.x - other.x, self.d - other.d, self.dd - other.dd)

    def __neg__(self) -> Jet:
        return Jet(-self.x, -self.d, -self.dd)

    def __mul__(self, other: Jet) -> Jet:
        return Jet(
            self.x * other.x,
            self.d * other.x + self.x * other.d,
            self.dd * other.x + 2 * self.d * other.d + self.x * other.dd,
        )

    def __truediv__(self, other: Jet) -> Jet:
        return self * other.through(1 / other.x, -1 / other.x**2, 2 / other.x**3)

    def times(self, factor: Real) -> Jet:
        """Product c x with a constant c, of derivatives c ẋ and c ẍ."""
        return Jet(factor * self.x, factor * self.d, factor * self.dd)

    def through(self, g: Real, first: Real, second: Real) -> Jet:
        """Jet of g(x), of derivatives g′ ẋ and g″ ẋ² + g′ ẍ, from g, g′ and g″ at x."""
        return Jet(g, first * self.d, second * self.d**2 + first * self.dd)


JetVector = tuple[Jet, Jet, Jet]


def dot(a: Sequence[Jet], b: Sequence[Jet]) -> Jet:
    """Scalar product a·b of vectors (n,) of jets in one frame; its unit is that of a b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Sequence[Any], b: Sequence[Any]) -> tuple[Any, Any, Any]:
    """Vector product a × b (3,), of jets or of numbers, in one frame; its unit is that of a b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def sqrt(a: Jet, digits: FormulaArithmetic[Any]) -> Jet:
    """Square root √a, in the root of the unit of a."""
    root = digits.sqrt(a.x)
    return a.through(root, 1 / (2 * root), -1 / (4 * root * a.x))


def atan2(y: Jet, x: Jet, digits: FormulaArithmetic[Any]) -> Jet:
    """Angle θ of the vector (x, y) from the axis x [rad], θ̇ = (x ẏ − y ẋ)/(x² + y²) [rad/s]."""
    square = x * x + y * y
    rate = (Jet(x.x, x.d) * Jet(y.d, y.dd) - Jet(y.x, y.d) * Jet(x.d, x.dd)) / square
    return Jet(digits.atan2(y.x, x.x), rate.x, rate.d)


def formula(
    expression: Expression, names: Mapping[str, Jet], digits: FormulaArithmetic[Any]
) -> Jet:
    """Value of a formula with its derivatives.

    Parameters
    ----------
    expression : Expression
        The formula.
    names : mapping of str to Jet
        Values of its names.
    digits : FormulaArithmetic
        Arithmetic of its numbers.
    """
    jets = arithmetic_of(digits)
    return evaluated(expression, jets.number, names, jets.applied)


def arithmetic_of(digits: FormulaArithmetic[Any]) -> FormulaArithmetic[Jet]:
    """Arithmetic of jets, for the evaluation of formulas and kernels."""

    def unary(op: Op) -> Callable[[Jet], Jet]:
        def applied(a: Jet) -> Jet:
            value = digits.applied(op, (a.x,))
            return a.through(value, *_SLOPES[op](a.x, value, digits))

        return applied

    return FormulaArithmetic(
        number=lambda value: Jet(digits.number(value)),
        sqrt=lambda a: sqrt(a, digits),
        atan2=lambda y, x: atan2(y, x, digits),
        abs=lambda a: a if a.x >= 0 else -a,
        max=lambda a, b: a if a.x >= b.x else b,
        sign=lambda a: Jet(digits.sign(a.x)),
        min=lambda a, b: a if a.x <= b.x else b,
        pow=lambda a, b: _power(a, b, digits),
        **{op.value: unary(op) for op in _SLOPES},
    )


def _power(a: Jet, b: Jet, digits: FormulaArithmetic[Any]) -> Jet:
    if b.d or b.dd:
        logarithm = a.through(digits.log(a.x), 1 / a.x, -1 / a.x**2)
        exponent = logarithm * b
        value = digits.exp(exponent.x)
        return exponent.through(value, value, value)
    nearest = round(float(b.x))
    n = nearest if b.x == nearest else b.x
    first = n * a.x ** (n - 1) if n != 0 else 0
    second = n * (n - 1) * a.x ** (n - 2) if n not in {0, 1} else 0
    return a.through(a.x**n, first, second)


#: First and second derivative of functions of one argument, from the argument and the value.
_SLOPES: dict[Op, Callable[[Real, Real, FormulaArithmetic[Any]], tuple[Real, Real]]] = {
    Op.SIN: lambda x, y, digits: (digits.cos(x), -y),
    Op.COS: lambda x, y, digits: (-digits.sin(x), -y),
    Op.EXP: lambda _, y, __: (y, y),
    Op.LOG: lambda x, *_: (1 / x, -1 / x**2),
    Op.TAN: lambda _, y, __: (1 + y**2, 2 * y * (1 + y**2)),
    Op.ATAN: lambda x, *_: (1 / (1 + x**2), -2 * x / (1 + x**2) ** 2),
    Op.ASIN: lambda x, *_: ((1 - x**2) ** -0.5, x * (1 - x**2) ** -1.5),
    Op.ACOS: lambda x, *_: (-((1 - x**2) ** -0.5), -x * (1 - x**2) ** -1.5),
}
