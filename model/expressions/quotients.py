"""Bounds of quotients that are 0/0 somewhere and have a limit there, as sin(x)/x.

Intervals tell nothing of a quotient N/D where D may be zero. Where N and D are zero with z, and so
are their derivatives by z before the k-th, both are divided by zᵏ: with Taylor's theorem N/zᵏ is
a + b z + r z², where r is between values of N⁽ᵏ⁺²⁾/(k + 2)! from zero to z, and r' between those of
N⁽ᵏ⁺³⁾/(k + 3)!. So are D/zᵏ and the quotient of both.
"""

from __future__ import annotations

from itertools import chain, islice
from math import factorial
from typing import TYPE_CHECKING, NamedTuple

from kousoku.model.expressions.derivative import derivative
from kousoku.model.expressions.enclosure import Bounds, enclosure, product_of
from kousoku.model.expressions.polynomials import polynomial_of
from kousoku.model.expressions.switching import SWITCHES
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


#: Names of z, of the quotient itself, and of the remainders of both Taylor series.
Z, ITSELF, REMAINDER = ".z", ".itself", ".rest"
#: The highest power of z that cancels.
HIGHEST = 3
#: Values of functions at zero, where these are known.
AT_ZERO = {
    **dict.fromkeys((Op.SIN, Op.TAN, Op.ASIN, Op.ATAN), ZERO),
    Op.COS: ONE,
    Op.EXP: ONE,
}


#: Bounds by name.
Spans = dict[str, Bounds]


class Quotient(NamedTuple):
    """A quotient that is 0/0 where z is zero.

    Parameters
    ----------
    name : str
        What stands for it in formulas; its rate follows that.
    formula : Expression
        As it is written.
    vanishing_argument : Expression
        z.
    numerator, denominator : Expression
        N and D, as functions of :data:`Z`.
    order : int
        k: both are divided by that power of z.
    """

    name: str
    formula: Expression
    vanishing_argument: Expression
    numerator: Expression
    denominator: Expression
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
        place = enclosure(self.vanishing_argument, spans)
        ends = (apply(Op.MIN, place.least, ZERO), apply(Op.MAX, place.most, ZERO))
        near = {
            Z: place,
            **self._remainders(self.numerator, 0, ends),
            **self._remainders(self.denominator, 1, ends),
        }
        a, da = self._series(self.numerator, 0)
        b, db = self._series(self.denominator, 1)
        near[ITSELF] = value = self._intersection(
            enclosure(self.formula, spans), enclosure(div(a, b), near), place
        )
        slope = enclosure(div(add(da, neg(mul(symbol(ITSELF), db))), b), near)
        rate_near = product_of(slope, enclosure(speed, spans))
        far = enclosure(rate, spans)
        return {self.name: value, self.rate: self._intersection(far, rate_near, place)}

    def _series(self, formula: Expression, k: int) -> tuple[Expression, Expression]:
        """Series of N (k = 0) or D (1) over the power of z, and its derivative."""
        a, b = islice(coefficients(formula), self.order, self.order + 2)
        z, rest, slope = symbol(Z), symbol(f"{REMAINDER}{k}"), symbol(f"{REMAINDER}{k}.slope")
        square = power(z, number(2))
        if _is_short(formula, self.order):
            return add(a, mul(b, z)), b
        return (
            add(a, mul(b, z), mul(rest, square)),
            add(b, mul(number(2), mul(rest, z)), mul(slope, square)),
        )

    def _remainders(
        self, formula: Expression, k: int, ends: tuple[Expression, Expression]
    ) -> Spans:
        """Bounds of the factor of z² in such a series, and of the derivative of that factor."""
        if _is_short(formula, self.order):
            return {}
        spans: Spans = {}
        for n, name in enumerate((f"{REMAINDER}{k}", f"{REMAINDER}{k}.slope"), self.order + 2):
            bounds = enclosure(_derivative(formula, n), {Z: Bounds(*ends)})
            spans[name] = Bounds(*(div(bound, number(factorial(n))) for bound in bounds))
        return spans

    def _intersection(self, far: Bounds, near: Bounds, place: Bounds) -> Bounds:
        """Intersection of two bounds, of which the first hold where z keeps its sign only."""
        sign = apply(Op.MAX, mul(place.least, place.most), ZERO)
        none = add(div(sign, sign), number(-1))  # no number where z changes sign: far is left out
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
    quotients: dict[Expression, Quotient] = {}

    def build(op: Op, args: tuple[Expression, ...]) -> Expression:
        operation = apply(op, *args)
        if operation.op is not Op.DIV:
            return operation
        names = (quotient.name for quotient in quotients.values())
        return _named(operation, {*varying, *names}, quotients)

    return rebuilt(formula, build), tuple(quotients.values())


def _named(
    part: Expression, varying: Collection[str], quotients: dict[Expression, Quotient]
) -> Expression:
    """Quotient with a name for the factor of it that has a limit, if there is one."""
    above, below = ([*_factors(side)] for side in part.args)
    for place in _varying_parts(part.args[1], varying):
        numerator, written_above, factor = _split_by_z(above, place, varying)
        denominator, written_below, divisor = _split_by_z(below, place, varying)
        order = _order(numerator, denominator)
        if order is None:
            continue
        whole = div(written_above, written_below)
        name = quotients[whole].name if whole in quotients else f".quotient{len(quotients)}"
        quotients.setdefault(whole, Quotient(name, whole, place, numerator, denominator, order))
        return div(mul(factor, symbol(name)), divisor)
    return part


def _varying_parts(divisor: Expression, varying: Collection[str]) -> Iterator[Expression]:
    """Parts of a divisor that vary, the largest first: candidates for z."""
    for part in reversed(ordered(divisor)):
        if not set(varying).isdisjoint(names_of(part)):
            yield part


def _factors(part: Expression) -> Iterator[Expression]:
    if part.op is Op.MUL:
        for arg in part.args:
            yield from _factors(arg)
    else:
        yield part


def _split_by_z(
    factors: list[Expression], place: Expression, varying: Collection[str]
) -> tuple[Expression, Expression, Expression]:
    """Product of smooth factors that depend on z alone, in z and as written, and of the others.

    Taylor's theorem does not hold where derivatives jump.
    """
    functions_of_z: list[Expression] = []
    written: list[Expression] = []
    others: list[Expression] = []
    for factor in factors:
        in_z = _in_z(factor, place, varying)
        if set(varying).isdisjoint(names_of(in_z)) and not _has_kink(in_z):
            functions_of_z.append(in_z)
            written.append(factor)
        else:
            others.append(factor)
    return mul(*functions_of_z), mul(*written), mul(*others)


def _has_kink(in_z: Expression) -> bool:
    return any(part.op in SWITCHES and Z in names_of(part) for part in ordered(in_z))


def _in_z(formula: Expression, place: Expression, varying: Collection[str]) -> Expression:
    """Formula with z in it, also where z is linear in the only name that varies."""
    in_z = replaced(formula, place, symbol(Z), _applied)
    names = [name for name in names_of(place) if name in varying]
    line = polynomial_of(place)
    if set(varying).isdisjoint(names_of(in_z)) or len(names) != 1 or line is None:
        return in_z
    if line.variables != (symbol(names[0]),) or max(line.terms, default=(0,)) != (1,):
        return in_z
    start, slope = (line.terms.get((n,)) for n in range(2))
    assert slope is not None
    value = div(add(symbol(Z), number(-(start or 0))), number(slope))
    return replaced(in_z, symbol(names[0]), value, _applied)


def _applied(op: Op, args: tuple[Expression, ...]) -> Expression:
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


def _order(numerator: Expression, denominator: Expression) -> int | None:
    """Order of the zero of a denominator, if the numerator has one of it, too."""
    sides = (numerator, denominator)
    pairs = islice(zip(*map(coefficients, sides), strict=True), HIGHEST + 1)
    order = next((k for k, pair in enumerate(pairs) if pair != (ZERO, ZERO)), 0)
    if not order:
        return None
    series = [tuple(islice(coefficients(side), order + 2)) for side in sides]
    has_limit = series[1][order] != ZERO and all(map(_has_value, chain(*series)))
    return order if has_limit else None


def coefficients(formula: Expression) -> Iterator[Expression]:
    """Taylor coefficients in z, from the zeroth on."""
    for n, part in enumerate(_derivatives(formula)):
        yield div(replaced(part, symbol(Z), ZERO, _applied), number(factorial(n)))


def _derivatives(formula: Expression) -> Iterator[Expression]:
    """Derivatives by z, each when it is asked for; the zeroth is the formula."""
    while True:
        yield formula
        formula = derivative(formula, Z)


def _derivative(formula: Expression, order: int) -> Expression:
    return next(islice(_derivatives(formula), order, None))


def _is_short(formula: Expression, order: int) -> bool:
    """Whether a formula is a polynomial in z that ends behind the order and one more."""
    return _derivative(formula, order + 2) == ZERO


def _has_value(formula: Expression) -> bool:
    """Whether nothing in a formula without z is divided by zero."""
    for part in ordered(formula):
        is_power = part.op in {Op.POW, Op.LOG, Op.SQRT}
        if (is_power and part.args[0] == ZERO) or (part.op is Op.DIV and part.args[1] == ZERO):
            return False
    return True
