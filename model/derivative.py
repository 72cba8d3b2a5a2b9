"""Exact derivatives of formulas, by the rules."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING

from kousoku.model.polynomials import even_power
from kousoku.model.terms import (
    ONE,
    ZERO,
    Apply,
    Function,
    Name,
    Number,
    add,
    apply,
    div,
    mul,
    neg,
    number,
    ordered,
    power,
)

if TYPE_CHECKING:
    from kousoku.model.terms import Expression


def derivative(expression: Expression, name: str) -> Expression:
    """Return the partial derivative of a formula; all other names are held fixed.

    At a kink the derivative is the mean of both sides: that of ``abs`` is ``sign``, which is 0 at
    0, and where two arguments of ``max`` are equal their derivatives count half each.

    Parameters
    ----------
    expression : Expression
        What is differentiated.
    name : str
        By what.
    """
    known: dict[int, Expression] = {}
    for part in ordered(expression):
        match part:
            case Number():
                known[id(part)] = ZERO
            case Name():
                known[id(part)] = ONE if part.name == name else ZERO
            case Apply() if (same := _smooth_root(part)) is not None:
                known[id(part)] = derivative(same, name)
            case Apply():
                slopes = tuple(known[id(arg)] for arg in part.args)
                is_fixed = all(slope == ZERO for slope in slopes)
                known[id(part)] = ZERO if is_fixed else _derivative(part, slopes)
    return known[id(expression)]


def _smooth_root(part: Apply) -> Expression | None:
    """Return a root of an even power as a power of ``abs(a)`` where that has two derivatives.

    Those of the root, ``(a^2)^1.5``, are 0/0 where a is zero.
    """
    if part.function not in {Function.SQRT, Function.POW}:
        return None
    exponent = Number(Fraction(1, 2)) if part.function is Function.SQRT else part.args[1]
    if not isinstance(exponent, Number) or exponent.value.denominator == 1:
        return None
    found = even_power(part.args[0])
    if found is None or found[1] * exponent.value < 2:
        return None
    size = found[0] if found[1] * exponent.value % 2 == 0 else apply(Function.ABS, found[0])
    return power(size, Number(found[1] * exponent.value))


def _derivative(part: Apply, slopes: tuple[Expression, ...]) -> Expression:
    """Return the derivative of a function of formulas, given those of its arguments."""
    args = part.args
    match part.function:
        case Function.ADD:
            return add(*slopes)
        case Function.MUL:
            (a, b), (da, db) = args, slopes
            return add(mul(da, b), mul(a, db))
        case Function.DIV:
            (_, b), (da, db) = args, slopes
            return div(add(da, neg(mul(part, db))), b)
        case Function.NEG:
            return neg(slopes[0])
        case Function.POW:
            return _of_power(part, *slopes)
        case Function.ATAN2:
            (y, x), (dy, dx) = args, slopes
            square = add(mul(y, y), mul(x, x))
            return div(add(mul(dy, x), neg(mul(y, dx))), square)
        case Function.MAX | Function.MIN:
            return _of_extreme(part, *slopes)
        case Function.LOG_SUM:
            (a, b), (da, db) = args, slopes
            shares = [apply(Function.SHARE, add(x, neg(y))) for x, y in ((a, b), (b, a))]
            return add(mul(shares[0], da), mul(shares[1], db))
        case _:
            return mul(_slope(part), slopes[0])


def _of_power(part: Apply, da: Expression, db: Expression) -> Expression:
    a, b = part.args
    if isinstance(b, Number):
        base = a if b.value > 1 else _where_positive(a)
        return mul(b, power(base, number(b.value - 1)), da)
    through_a = mul(b, power(a, add(b, neg(ONE))), da)
    return add(through_a, mul(part, apply(Function.LOG, a), db))


def _where_positive(a: Expression) -> Expression:
    """Return a, and of ``max(0, x)`` something that is not zero where x is negative.

    There its derivative is zero, and so are those of its powers, which else are 0 ∞.
    """
    if not isinstance(a, Apply) or a.function is not Function.MAX or ZERO not in a.args:
        return a
    x = a.args[a.args[0] == ZERO]
    return add(a, div(add(ONE, neg(apply(Function.SIGN, x))), number(2)))


def _of_extreme(part: Apply, da: Expression, db: Expression) -> Expression:
    """Return ½ ((1 + s) a′ + (1 − s) b′), where s is the sign of a − b, or of b − a for ``MIN``."""
    a, b = part.args if part.function is Function.MAX else part.args[::-1]
    sign = apply(Function.SIGN, add(a, neg(b)))
    both = add(mul(add(ONE, sign), da), mul(add(ONE, neg(sign)), db))
    return div(both, number(2))


def _slope(part: Apply) -> Expression:
    """Return the derivative of a function by its only argument."""
    (x,) = part.args
    match part.function:
        case Function.SIN:
            return apply(Function.COS, x)
        case Function.COS:
            return neg(apply(Function.SIN, x))
        case Function.TAN:
            return add(ONE, mul(part, part))
        case Function.ASIN:
            return div(ONE, _arc(x))
        case Function.ACOS:
            return div(number(-1), _arc(x))
        case Function.ATAN:
            return div(ONE, add(ONE, mul(x, x)))
        case Function.SQRT:
            return div(ONE, mul(number(2), part))
        case Function.EXP:
            return part
        case Function.LOG:
            return div(ONE, x)
        case Function.ABS:
            return apply(Function.SIGN, x)
        case Function.SHARE:
            return mul(part, apply(Function.SHARE, neg(x)))
        case _:  # SIGN
            return ZERO


def _arc(x: Expression) -> Expression:
    """Return √(1 − x²), as a product that keeps its digits near ±1."""
    return apply(Function.SQRT, mul(add(ONE, neg(x)), add(ONE, x)))
