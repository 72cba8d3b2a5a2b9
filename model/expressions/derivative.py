"""Exact derivatives of formulas, by the rules."""

from __future__ import annotations

from dataclasses import fields
from fractions import Fraction
from functools import partial
from typing import TYPE_CHECKING

from kousoku.model.expressions.polynomials import polynomial_of, root_of_even_power
from kousoku.model.operations.arithmetic import FormulaArithmetic
from kousoku.model.operations.differentials import DIFFERENTIALS
from kousoku.model.operations.expression import (
    ONE,
    ZERO,
    Expression,
    add,
    apply,
    number,
    ordered,
    power,
    replaced,
    symbol,
)
from kousoku.model.operations.graph import Op

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence

    from kousoku.model.expressions.polynomials import Polynomial


def derivative(expression: Expression, name: str) -> Expression:
    """Partial derivative of a formula; all other names are held fixed.

    At a kink the derivative is the mean of both sides: that of ``abs`` is ``sign``, which is 0 at
    0, and where two arguments of ``max`` are equal their derivatives count half each.

    Parameters
    ----------
    expression : Expression
        The formula.
    name : str
        The name that it is differentiated by.
    """
    known: dict[int, Expression] = {}
    for part in ordered(expression):
        if not part.args:
            known[id(part)] = ONE if part.name == name else ZERO
        elif (smooth := _smooth_root(part)) is not None:
            known[id(part)] = derivative(smooth, name)
        elif (short := _of_quotient(part, known)) is not None:
            known[id(part)] = short
        else:
            derivatives = tuple(known[id(arg)] for arg in part.args)
            is_fixed = all(slope == ZERO for slope in derivatives)
            known[id(part)] = ZERO if is_fixed else _derivative(part, derivatives)
    return known[id(expression)]


def _smooth_root(part: Expression) -> Expression | None:
    """Root of an even power as a power of ``abs(a)`` where that has two derivatives.

    Those of the root, ``(a^2)^1.5``, are 0/0 where a is zero.
    """
    root = root_of_even_power(part)
    if root is None or root[1] < 2:
        return None
    size = root[0] if root[1] % 2 == 0 else apply(Op.ABS, root[0])
    return power(size, number(root[1]))


def _of_quotient(part: Expression, known: Mapping[int, Expression]) -> Expression | None:
    """Derivative N P^-r / P of a quotient a P^-r where terms of N = a′ P - r a P′ cancel.

    Of ``u/sqrt(u^2 + c)`` and of ``t/(t + c)`` only c is left. The two terms of the usual rule are
    nearly equal where u is large, and their bounds tell nothing of the rate there.
    """
    for a, b, base, exponent in _quotients_of(part):
        da, slope = known[id(a)], known[id(base)]
        # quotients of exponentials have forms of their own, in which none overflows
        if ZERO in {da, slope} or any(inner.op is Op.EXP for inner in ordered(part)):
            continue
        terms = da * base, number(-exponent) * a * slope
        # a sum that is a factor stays one: written out it is known to fewer digits
        factors = {*_sums_in_products(a), *_sums_in_products(base)}
        sums = [inner for inner in reversed(ordered(part)) if inner in factors]
        numerator = _cancelled(terms, sums)
        if numerator is not None and part.op is Op.MUL:
            return numerator * b / base
        if numerator is not None:
            return numerator / (power(b, number(2)) if b is base else b * base)
    return None


def _quotients_of(
    part: Expression,
) -> Iterator[tuple[Expression, Expression, Expression, Fraction]]:
    """Quotients a/b, or products a b, that a formula is: a, b, and P and r of b = P^r or n P^-r."""
    match part:
        case Expression(Op.DIV, (a, b)):
            yield a, b, *_power_of(b)
        case Expression(Op.MUL, (x, y)):
            for a, b in ((x, y), (y, x)):
                base, exponent = _power_of(b)
                if exponent < 0:
                    yield a, b, base, -exponent
                elif b.op is Op.DIV and b.args[0].value is not None:
                    yield a, b, *_power_of(b.args[1])


def _power_of(part: Expression) -> tuple[Expression, Fraction]:
    """Base and exponent of a power or a square root; those of any other formula are it and 1."""
    match part:
        case Expression(Op.SQRT, (base,)):
            return base, Fraction(1, 2)
        case Expression(Op.POW, (base, Expression(value=Fraction() as exponent))):
            return base, exponent
    return part, Fraction(1)


def _cancelled(terms: Sequence[Expression], kept: Sequence[Expression]) -> Expression | None:
    """Sum of two terms, written out but for some parts; None unless products in both cancel."""
    names = {symbol(f".kept{n}"): part for n, part in enumerate(kept)}
    for name, part in names.items():
        terms = [replaced(term, part, name) for term in terms]
    total = polynomial_of(add(*terms))
    first, second, left = map(_products_of, (*map(polynomial_of, terms), total))
    if total is None or not 0 < len(left) < len(first | second):
        return None
    numerator = total.expression()
    for name, part in names.items():
        numerator = replaced(numerator, name, part)
    return numerator


def _sums_in_products(formula: Expression) -> Iterator[Expression]:
    """Sums in a formula that are not added up themselves."""
    stack = [formula]
    while stack:
        part = stack.pop()
        if part.op in {Op.ADD, Op.NEG}:
            stack.extend(part.args)
        else:
            yield from (inner for inner in ordered(part) if inner.op is Op.ADD)


def _products_of(polynomial: Polynomial | None) -> set[frozenset[tuple[Expression, int]]]:
    """Products of powers that a polynomial has as terms, none if there is no polynomial."""
    if polynomial is None:
        return set()
    pairs = (zip(polynomial.variables, powers, strict=True) for powers in polynomial.terms)
    return {frozenset(pair for pair in product if pair[1]) for product in pairs}


def _derivative(part: Expression, derivatives: tuple[Expression, ...]) -> Expression:
    """Derivative of a function of formulas, given those of its arguments."""
    match part.op:
        case Op.ADD:
            return add(*derivatives)
        case Op.POW:
            return _of_power(part, *derivatives)
        case Op.MAX | Op.MIN:
            return _of_extreme(part, *derivatives)
        case Op.ABS:
            return apply(Op.SIGN, *part.args) * derivatives[0]
        case Op.SIGN:
            return ZERO
        case Op.LOG_SUM:
            (a, b), (da, db) = part.args, derivatives
            return apply(Op.SHARE, a - b) * da + apply(Op.SHARE, b - a) * db
        case Op.SHARE:
            return part * apply(Op.SHARE, -part.args[0]) * derivatives[0]
        case _:
            slope: Expression = DIFFERENTIALS[part.op](part, part.args, derivatives, FORMULAS)
            return slope


def _of_power(part: Expression, da: Expression, db: Expression) -> Expression:
    a, b = part.args
    if b.value is not None:
        base = a if b.value > 1 else _where_positive(a)
        return b * power(base, number(b.value - 1)) * da
    return b * power(a, b - 1) * da + part * apply(Op.LOG, a) * db


def _where_positive(a: Expression) -> Expression:
    """a, and of ``max(0, x)`` something that is not zero where x is negative.

    There its derivative is zero, and so are those of its powers, which else are 0 ∞.
    """
    if a.op is not Op.MAX or ZERO not in a.args:
        return a
    x = a.args[a.args[0] == ZERO]
    return a + (ONE - apply(Op.SIGN, x)) / 2


def _of_extreme(part: Expression, da: Expression, db: Expression) -> Expression:
    """Derivative ½ ((1 + s) a′ + (1 − s) b′), s the sign of a − b, or of b − a for ``MIN``."""
    a, b = part.args if part.op is Op.MAX else part.args[::-1]
    sign = apply(Op.SIGN, a - b)
    return ((1 + sign) * da + (1 - sign) * db) / 2


def _builder(op: Op) -> Callable[..., Expression]:
    return partial(apply, op)


#: The arithmetic of formulas: results are formulas.
FORMULAS: FormulaArithmetic[Expression] = FormulaArithmetic(
    number=lambda value: number(Fraction(value)),
    **{field.name: _builder(Op(field.name)) for field in fields(FormulaArithmetic)[1:]},
)
