"""Quotients that are 0/0 somewhere and have a limit there, as sin(x)/x: what bounds them.

Intervals tell nothing of a quotient N/D where D may be zero. Where N and D are zero with z, and so
are their derivatives by z before the k-th, both are divided by zᵏ: with Taylor's theorem N/zᵏ is
a + b z + r z², where r is between values of N⁽ᵏ⁺²⁾/(k + 2)! from zero to z, and r' between those of
N⁽ᵏ⁺³⁾/(k + 3)!. So are D/zᵏ and the quotient of both.
"""

from __future__ import annotations

from itertools import chain
from math import factorial
from typing import TYPE_CHECKING, NamedTuple

from kousoku.model.expressions.derivative import derivative
from kousoku.model.expressions.enclosure import Bounds, enclosure, product_of
from kousoku.model.expressions.polynomials import polynomial_of
from kousoku.model.operations.expression import (
    ONE,
    ZERO,
    Expression,
    add,
    apply,
    div,
    mul,
    names_of,
    neg,
    number,
    ordered,
    power,
    rebuilt,
    replaced,
    symbol,
)
from kousoku.model.operations.graph import Op

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator, Mapping


#: The names of z, of the quotient itself, and of what is left of a series of two.
PLACE, ITSELF, REST = ".z", ".itself", ".rest"
#: The highest power of z that is divided by.
HIGHEST = 3
#: What functions are of zero; of others that is not known.
AT_ZERO = {
    **dict.fromkeys((Op.SIN, Op.TAN, Op.ASIN, Op.ATAN), ZERO),
    Op.COS: ONE,
    Op.EXP: ONE,
}


#: What bounds names.
Spans = dict[str, Bounds]


class Quotient(NamedTuple):
    """A quotient that is 0/0 where z is zero.

    Parameters
    ----------
    name : str
        What stands for it in formulas; its rate follows that.
    whole : Expression
        As it is written.
    place : Expression
        z.
    above, below : Expression
        What is divided and by what, of :data:`PLACE`.
    order : int
        Of z: both are divided by that power of it.
    """

    name: str
    whole: Expression
    place: Expression
    above: Expression
    below: Expression
    order: int

    @property
    def rate(self) -> str:
        """The name of its rate."""
        return f"{self.name}.rate"

    def bounds(self, rate: Expression, speed: Expression, spans: Mapping[str, Bounds]) -> Spans:
        """Bounds of it and its rate.

        Parameters
        ----------
        rate, speed : Expression
            The rate of it as it is written, and that of z.
        spans : mapping of str to Bounds
            What bounds each name that varies.
        """
        place = enclosure(self.place, spans)
        ends = (apply(Op.MIN, place.least, ZERO), apply(Op.MAX, place.most, ZERO))
        near = {
            PLACE: place,
            **self._rests(self.above, 0, ends),
            **self._rests(self.below, 1, ends),
        }
        (a, da), (b, db) = (self._series(one, k) for k, one in enumerate((self.above, self.below)))
        near[ITSELF] = value = self._both(
            enclosure(self.whole, spans), enclosure(div(a, b), near), place
        )
        slope = enclosure(div(add(da, neg(mul(symbol(ITSELF), db))), b), near)
        moved = product_of(slope, enclosure(speed, spans))
        return {self.name: value, self.rate: self._both(enclosure(rate, spans), moved, place)}

    def _series(self, formula: Expression, k: int) -> tuple[Expression, Expression]:
        """One of both divided by a power of z, to the second power, and its derivative."""
        a, b = coefficients(formula, self.order + 2)[self.order :]
        z, rest, slope = symbol(PLACE), symbol(f"{REST}{k}"), symbol(f"{REST}{k}.slope")
        square = power(z, number(2))
        if _is_short(formula, self.order):
            return add(a, mul(b, z)), b
        return (
            add(a, mul(b, z), mul(rest, square)),
            add(b, mul(number(2), mul(rest, z)), mul(slope, square)),
        )

    def _rests(self, formula: Expression, k: int, ends: tuple[Expression, Expression]) -> Spans:
        """Bounds of the factor of z² in it, and of the derivative of that."""
        if _is_short(formula, self.order):
            return {}
        found: Spans = {}
        for n, name in enumerate((f"{REST}{k}", f"{REST}{k}.slope"), self.order + 2):
            bounds = enclosure(_derived(formula, n), {PLACE: Bounds(*ends)})
            found[name] = Bounds(*(div(one, number(factorial(n))) for one in bounds))
        return found

    def _both(self, far: Bounds, near: Bounds, place: Bounds) -> Bounds:
        """Bounds that meet two others, of which the first hold where z has a sign."""
        sign = apply(Op.MAX, mul(place.least, place.most), ZERO)
        none = add(div(sign, sign), number(-1))  # no number where z has no sign: none is left out
        return Bounds(
            apply(Op.MAX, add(far.least, none), near.least),
            apply(Op.MIN, add(far.most, none), near.most),
        )


def without_quotients(
    formula: Expression, varying: Collection[str]
) -> tuple[Expression, tuple[Quotient, ...]]:
    """Formula with names for its quotients that have a limit where they are 0/0.

    Parameters
    ----------
    formula : Expression
        The formula.
    varying : collection of str
        Names that change in a run.
    """
    found: dict[Expression, Quotient] = {}

    def build(op: Op, args: tuple[Expression, ...]) -> Expression:
        same = apply(op, *args)
        if same.op is not Op.DIV:
            return same
        return _named(same, {*varying, *(one.name for one in found.values())}, found)

    return rebuilt(formula, build), tuple(found.values())


def _named(
    part: Expression, varying: Collection[str], found: dict[Expression, Quotient]
) -> Expression:
    """Quotient with a name for what has a limit in it, if something has."""
    above, below = ([*_factors(one)] for one in part.args)
    for place in _places(part.args[1], varying):
        own, other = (_apart(one, place, varying) for one in (above, below))
        order = _order(own[0], other[0])
        if order is None:
            continue
        whole = div(own[1], other[1])
        name = found[whole].name if whole in found else f".quotient{len(found)}"
        found.setdefault(whole, Quotient(name, whole, place, own[0], other[0], order))
        return div(mul(own[2], symbol(name)), other[2])
    return part


def _places(below: Expression, varying: Collection[str]) -> Iterator[Expression]:
    """Parts that may be zero where a formula is."""
    for part in reversed(ordered(below)):
        if not set(varying).isdisjoint(names_of(part)):
            yield part


def _factors(part: Expression) -> Iterator[Expression]:
    if part.op is Op.MUL:
        for one in part.args:
            yield from _factors(one)
    else:
        yield part


def _apart(
    factors: list[Expression], place: Expression, varying: Collection[str]
) -> tuple[Expression, Expression, Expression]:
    """Factors that depend on z alone: of z, and as they are; and the others."""
    of_place: list[Expression] = []
    own: list[Expression] = []
    others: list[Expression] = []
    for one in factors:
        same = _of_place(one, place, varying)
        if set(varying).isdisjoint(names_of(same)):
            of_place.append(same)
            own.append(one)
        else:
            others.append(one)
    return mul(*of_place), mul(*own), mul(*others)


def _of_place(formula: Expression, place: Expression, varying: Collection[str]) -> Expression:
    """Formula with z in it, also where z is linear in the only name that varies."""
    same = replaced(formula, place, symbol(PLACE), _value)
    names = [one for one in names_of(place) if one in varying]
    line = polynomial_of(place)
    if set(varying).isdisjoint(names_of(same)) or len(names) != 1 or line is None:
        return same
    if line.variables != (symbol(names[0]),) or max(line.terms, default=(0,)) != (1,):
        return same
    start, slope = (line.terms.get((n,)) for n in range(2))
    assert slope is not None
    value = div(add(symbol(PLACE), number(-(start or 0))), number(slope))
    return replaced(same, symbol(names[0]), value, _value)


def _value(op: Op, args: tuple[Expression, ...]) -> Expression:
    """Function of formulas, also of zero."""
    if args == (ZERO,) and op in AT_ZERO:
        return AT_ZERO[op]
    if op is Op.LOG and args == (ONE,):
        return ZERO
    if op is Op.POW and args[0] == ZERO:
        exponent = args[1].value
        is_positive = exponent is not None and exponent > 0
        return ZERO if is_positive else Expression(op, args)
    if op is Op.DIV and args[1] == ZERO:
        return Expression(op, args)
    return apply(op, *args)


def _order(above: Expression, below: Expression) -> int | None:
    """Power of z that below has, if above has it, too."""
    if below == ONE:
        return None
    pairs = zip(*(coefficients(one, HIGHEST + 3) for one in (above, below)), strict=True)
    order = next((k for k, pair in enumerate(pairs) if pair != (ZERO, ZERO)), 0)
    found = [coefficients(one, order + 2) for one in (above, below)]
    if not 0 < order <= HIGHEST or found[1][order] == ZERO:
        return None
    return order if all(map(_has_value, chain(*found))) else None


def coefficients(formula: Expression, count: int) -> list[Expression]:
    """First factors of powers of z, from the zeroth on."""
    values = (replaced(_derived(formula, n), symbol(PLACE), ZERO, _value) for n in range(count))
    return [div(one, number(factorial(n))) for n, one in enumerate(values)]


def _derived(formula: Expression, count: int) -> Expression:
    for _ in range(count):
        formula = derivative(formula, PLACE)
    return formula


def _is_short(formula: Expression, order: int) -> bool:
    """Whether a formula is a polynomial in z that ends behind the order and one more."""
    return _derived(formula, order + 2) == ZERO


def _has_value(formula: Expression) -> bool:
    """Whether nothing in a formula without z is divided by zero."""
    for part in ordered(formula):
        is_power = part.op in {Op.POW, Op.LOG, Op.SQRT}
        if (is_power and part.args[0] == ZERO) or (part.op is Op.DIV and part.args[1] == ZERO):
            return False
    return True
