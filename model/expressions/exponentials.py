"""Exponentials that cancel: quotients of their sums, written so that none overflows."""

from __future__ import annotations

from dataclasses import dataclass
from functools import reduce
from typing import TYPE_CHECKING

from kousoku.model.expressions.derivative import derivative
from kousoku.model.expressions.enclosure import composed
from kousoku.model.expressions.formulas import TIME
from kousoku.model.operations.expression import (
    ONE,
    ZERO,
    Expression,
    add,
    apply,
    div,
    mul,
    neg,
    ordered,
    rebuilt,
)
from kousoku.model.operations.graph import Op

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence


@dataclass(frozen=True, slots=True)
class Form:
    """A formula as it is written anew, and as factor × exp(exponent).

    Parameters
    ----------
    formula, factor, exponent : Expression
        The formula and its parts.
    logarithm : Expression or None
        None where the numbers and exponentials in it do not tell that it is positive.
    is_sum : bool
        Whether it is positive and exponentials are added in it: these may overflow.
    is_rewritten : bool
        Whether the exponent has the logarithm of such a sum.
    terms : tuple of Form
        Terms that it is the sum of.
    """

    formula: Expression
    factor: Expression
    exponent: Expression = ZERO
    logarithm: Expression | None = None
    is_sum: bool = False
    is_rewritten: bool = False
    terms: tuple[Form, ...] = ()


def without_overflow(formula: Expression) -> Expression:
    """Formula that is divided by no exponential, and by no sum of such.

    1/(eᵃ + eᵇ) is exp(−l) with the logarithm l of the sum, of which there are bounds everywhere:
    those of the first are 0/0 and ∞/∞ far from where a and b are equal, and those of 1/eᵃ are ∞/∞.
    """
    known: dict[int, Form] = {}
    for part in ordered(formula):
        args = [known[id(arg)] for arg in part.args]
        known[id(part)] = _form(part, args)
    return known[id(formula)].formula


def rate_of(law: Expression, order: int) -> Expression:
    """Derivative of a formula by the time, in functions that texts have.

    That of 1/(1 + eᵃ) is 0 ∞/∞ where eᵃ is infinite, unless it is written anew.
    """
    if order == 0:
        return law
    rate = without_overflow(law)
    for _ in range(order):
        rate = derivative(rate, TIME)
    return rebuilt(rate, lambda op, args: composed(op, *args))


def _form(part: Expression, args: Sequence[Form]) -> Form:
    """Form of a formula, given those of its parts."""
    if not part.args:
        is_positive = part.value is not None and part.value > 0
        return Form(part, part, logarithm=_logarithm(part) if is_positive else None)
    is_same = all(form.formula is arg for form, arg in zip(args, part.args, strict=True))
    formula = part if is_same else apply(part.op, *(form.formula for form in args))
    a, b = args[0], args[-1]
    match part.op:
        case Op.EXP:
            return Form(formula, ONE, a.formula, a.formula)
        case Op.NEG:
            return _product(formula, neg(a.factor), a.exponent, None, args)
        case Op.ADD:
            logarithm = _combined_logarithms(_log_of_sum, args)
            is_sum = logarithm is not None and any(form.exponent != ZERO for form in args)
            return Form(formula, formula, ZERO, logarithm, is_sum, terms=tuple(args))
        case Op.MUL:
            exponent, logarithm = add(a.exponent, b.exponent), _combined_logarithms(add, args)
            return _product(formula, mul(a.factor, b.factor), exponent, logarithm, args)
        case Op.DIV if b.is_sum or b.exponent != ZERO:
            return _quotient(a, b)
        case Op.DIV:
            logarithm = _combined_logarithms(lambda x, y: add(x, neg(y)), args)
            return _product(formula, div(a.factor, b.formula), a.exponent, logarithm, [a])
        case Op.POW if a.is_sum and a.logarithm is not None and b.formula.value is not None:
            logarithm = mul(b.formula, a.logarithm)
            if b.formula.value > 0:
                return Form(formula, formula, ZERO, logarithm, is_sum=True)
            return Form(apply(Op.EXP, logarithm), ONE, logarithm, logarithm, is_rewritten=True)
        case _:
            return Form(formula, formula)


def _product(
    formula: Expression,
    factor: Expression,
    exponent: Expression,
    logarithm: Expression | None,
    args: Sequence[Form],
) -> Form:
    """Product: its exponentials become one where there are several, or one was a quotient."""
    are_several = sum(form.exponent != ZERO for form in args) > 1
    is_rewritten = are_several or any(form.is_rewritten for form in args)
    formula = mul(factor, apply(Op.EXP, exponent)) if is_rewritten else formula
    is_sum = logarithm is not None and any(form.is_sum for form in args)
    return Form(formula, factor, exponent, logarithm, is_sum, is_rewritten)


def _quotient(a: Form, b: Form) -> Form:
    """Quotient a / b, each term of a by itself where exponentials are among them."""
    logarithm = _combined_logarithms(lambda x, y: add(x, neg(y)), [a, b])
    if any(term.exponent != ZERO for term in a.terms):
        terms = tuple(_quotient(term, b) for term in a.terms)
        formula = add(*(term.formula for term in terms))
        is_sum = logarithm is not None and a.is_sum
        return Form(formula, formula, ZERO, logarithm, is_sum, terms=terms)
    divisor, subtracted = (ONE, b.logarithm) if b.is_sum else (b.factor, b.exponent)
    assert subtracted is not None
    factor, exponent = div(a.factor, divisor), add(a.exponent, neg(subtracted))
    formula = mul(factor, apply(Op.EXP, exponent))
    return Form(formula, factor, exponent, logarithm, is_rewritten=True)


def _combined_logarithms(
    combine: Callable[[Expression, Expression], Expression], args: Sequence[Form]
) -> Expression | None:
    """Combined logarithms, if all are known."""
    logarithms = [form.logarithm for form in args]
    known = [logarithm for logarithm in logarithms if logarithm is not None]
    return reduce(combine, known) if len(known) == len(logarithms) else None


def _log_of_sum(a: Expression, b: Expression) -> Expression:
    """Logarithm log(eᵃ + eᵇ)."""
    return apply(Op.LOG_SUM, a, b)


def _logarithm(positive: Expression) -> Expression:
    return ZERO if positive == ONE else apply(Op.LOG, positive)
