"""Enclosures: bounds of a formula whose names are anywhere between two values.

The bounds are formulas themselves, the natural interval extension of Moore: each function is
replaced by its effect on intervals. Rounding is not directed outward, so that a bound may be
exceeded by units in the last place.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from kousoku.model.angles import PI
from kousoku.model.operations.expression import (
    ONE,
    ZERO,
    Expression,
    add,
    apply,
    div,
    evaluated,
    mul,
    names_of,
    neg,
    number,
    power,
    symbol,
)
from kousoku.model.operations.graph import Op

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence


class Bounds(NamedTuple):
    """Lower and upper bound of a formula."""

    least: Expression
    most: Expression

    @property
    def is_point(self) -> bool:
        """Whether both are the same formula."""
        return self.least is self.most or self.least == self.most


#: Functions that never fall.
RISING = frozenset(
    {
        *(Op.EXP, Op.LOG, Op.SQRT, Op.SIGN),
        *(Op.ASIN, Op.ATAN, Op.MIN, Op.MAX),
        *(Op.LOG_SUM, Op.SHARE),
    }
)
#: Where functions of one argument have values, if not everywhere: from here, to there.
DOMAINS: dict[Op, tuple[Expression, Expression | None]] = {
    **dict.fromkeys((Op.SQRT, Op.LOG), (ZERO, None)),
    **dict.fromkeys((Op.ASIN, Op.ACOS), (number(-1), ONE)),
}


def enclosure(expression: Expression, spans: Mapping[str, Bounds]) -> Bounds:
    """Bounds of a formula.

    Parameters
    ----------
    expression : Expression
        The formula.
    spans : mapping of str to Bounds
        Bounds of each name that varies; other names bound themselves.
    """
    names = {name: spans.get(name) or _point(symbol(name)) for name in names_of(expression)}
    return evaluated(expression, lambda value: _point(number(value)), names, _applied)


def _point(formula: Expression) -> Bounds:
    return Bounds(formula, formula)


def _applied(op: Op, args: Sequence[Bounds]) -> Bounds:
    """Bounds of a function of intervals."""
    if all(x.is_point for x in args):
        return _point(composed(op, *(x.least for x in args)))
    args = [_within(x, *DOMAINS[op]) if op in DOMAINS else x for x in args]
    first = args[0]
    match op:
        case Op.ADD:
            return Bounds(add(*(x.least for x in args)), add(*(x.most for x in args)))
        case Op.NEG:
            return Bounds(neg(first.most), neg(first.least))
        case Op.MUL:
            return product_of(*args)
        case Op.DIV:
            return quotient_of(first, args[1])
        case Op.POW:
            return _power(*args)
        case Op.ABS:
            return _magnitude(first)
        case Op.SIN | Op.COS:
            return _wave(op, first)
        case Op.TAN:
            waves = (_wave(function, first) for function in (Op.SIN, Op.COS))
            sine, cosine = waves
            return quotient_of(sine, cosine)
        case Op.ACOS:
            return Bounds(apply(op, first.most), apply(op, first.least))
        case Op.ATAN2:
            return _angle(*args)
        case _:
            assert op in RISING
            return Bounds(
                composed(op, *(x.least for x in args)),
                composed(op, *(x.most for x in args)),
            )


def composed(op: Op, *args: Expression) -> Expression:
    """Function of formulas, in functions that texts have, so that none overflows."""
    match op:
        case Op.LOG_SUM:
            a, b = args
            apart = neg(apply(Op.ABS, add(a, neg(b))))
            less = apply(Op.LOG, add(ONE, apply(Op.EXP, apart)))
            return add(apply(Op.MAX, a, b), less)
        case Op.SHARE:
            return div(ONE, add(ONE, apply(Op.EXP, neg(args[0]))))
        case _:
            return apply(op, *args)


def _least(*terms: Expression) -> Expression:
    least = terms[0]
    for term in terms[1:]:
        least = apply(Op.MIN, least, term)
    return least


def _most(*terms: Expression) -> Expression:
    most = terms[0]
    for term in terms[1:]:
        most = apply(Op.MAX, most, term)
    return most


def product_of(a: Bounds, b: Bounds) -> Bounds:
    """Bounds of a product."""
    # The ends are not hashed: parts are shared, and a tree has many times as many.
    sides = [(x.least,) if x.is_point else x for x in (a, b)]
    products = [mul(x, y) for x in sides[0] for y in sides[1]]
    return Bounds(_least(*products), _most(*products))


def quotient_of(a: Bounds, b: Bounds) -> Bounds:
    """Bounds of a quotient."""
    return product_of(a, _reciprocal(b))


def _within(x: Bounds, first: Expression, last: Expression | None) -> Bounds:
    """Part of an interval that is in a domain; one that is outside as a whole stays there."""
    least = _most(x.least, _least(x.most, first))
    return Bounds(least, x.most if last is None else _least(x.most, _most(x.least, last)))


def _magnitude(x: Bounds) -> Bounds:
    """Bounds of the absolute value."""
    return Bounds(_most(x.least, neg(x.most), ZERO), _most(neg(x.least), x.most))


def _reciprocal(x: Bounds) -> Bounds:
    """Bounds of 1 / x: within ± the largest, which is infinite where x may be zero.

    Elsewhere they are 1 / most and 1 / least. What tells the two apart is h/h, which is no number
    where h is 0 or infinite: maxima and minima leave it out.
    """
    if x.is_point:
        return _point(div(ONE, x.least))
    h = apply(Op.ABS, _most(x.least, neg(x.most), ZERO))  # how far x is from zero; not -0
    largest, is_apart = div(ONE, h), div(h, h)
    return Bounds(
        _most(neg(largest), div(is_apart, x.most)), _least(largest, div(is_apart, x.least))
    )


def _power(a: Bounds, b: Bounds) -> Bounds:
    exponent = b.least.value
    if exponent is None:
        return _applied(Op.EXP, [product_of(b, _applied(Op.LOG, [a]))])
    size = number(abs(exponent))
    if exponent.denominator > 1:  # of a positive number only: others have no power
        a = _within(a, ZERO, None)
    elif exponent.numerator % 2 == 0:
        a = _magnitude(a)
    bounds = Bounds(power(a.least, size), power(a.most, size))
    return bounds if exponent > 0 else _reciprocal(bounds)


def _wave(op: Op, x: Bounds) -> Bounds:
    """Bounds of a sine or cosine: ± (|slope in the middle| r + r²/2) within r of it."""
    other = Op.COS if op is Op.SIN else Op.SIN
    middle = div(add(x.least, x.most), number(2))
    r = div(add(x.most, neg(x.least)), number(2))
    value, slope = apply(op, middle), apply(Op.ABS, apply(other, middle))
    change = add(mul(slope, r), div(mul(r, r), number(2)))
    return Bounds(_most(number(-1), add(value, neg(change))), _least(ONE, add(value, change)))


def _angle(y: Bounds, x: Bounds) -> Bounds:
    """Bounds of atan2: within 2 asin(r/d) of the angle in the middle, d away from zero.

    r is the half diagonal of the rectangle. One that lies across the jump has all angles.
    """
    middle = [div(add(a.least, a.most), number(2)) for a in (y, x)]
    halves = [div(add(a.most, neg(a.least)), number(2)) for a in (y, x)]
    r, d = (apply(Op.SQRT, add(mul(a, a), mul(b, b))) for a, b in (halves, middle))
    value = apply(Op.ATAN2, *middle)
    change = mul(number(2), apply(Op.ASIN, _least(div(r, d), ONE)))
    least, most = add(value, neg(change)), add(value, change)
    pi, turn = number(PI), number(2 * PI)

    def turn_if(excess: Expression) -> Expression:
        return mul(turn, apply(Op.SIGN, _most(excess, ZERO)))

    return Bounds(
        _most(neg(pi), add(least, neg(turn_if(add(most, neg(pi)))))),
        _least(pi, add(most, turn_if(neg(add(least, pi))))),
    )
