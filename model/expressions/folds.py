"""Folds of a formula: functions that undo each other but for a kink or a jump, written with these.

Bounds of ``asin(sin(x))`` tell nothing where the argument of ``asin`` comes to its end, nor do
those of ``a/abs(a)`` beside zero.
"""

from __future__ import annotations

from fractions import Fraction
from math import pi
from typing import TYPE_CHECKING

from kousoku.model.expressions.polynomials import root_of_even_power
from kousoku.model.expressions.powers import without_quotient
from kousoku.model.expressions.switching import may_be_zero
from kousoku.model.operations.expression import (
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
    rebuilt,
)
from kousoku.model.operations.graph import Op

if TYPE_CHECKING:
    from collections.abc import Set

OTHER = {Op.SIN: Op.COS, Op.COS: Op.SIN}
"""The function whose sign tells the branch of the inverse of another."""

SIZES = frozenset({Op.ABS, Op.LOG})
"""Functions, beside roots of even powers, of which quotients are jumps: logarithms in exponents."""


def without_folds(
    formula: Expression, constant: Set[str] | None = None
) -> tuple[Expression, dict[Expression, Expression]]:
    """Formula with ``abs`` and ``sign`` in place of its folds, and the fold that each replaces.

    ``asin(sin(x))`` is ``atan2(sin(x), abs(cos(x)))``, ``a/abs(a)`` is ``sign(a)``, and
    ``atan(1/b)`` is ``pi/2*sign(b) - atan(b)``.

    Parameters
    ----------
    formula : Expression
        The formula.
    constant : set of str, optional
        Names in it that do not vary; without these arcs of quotients stay.
    """
    folds: dict[Expression, Expression] = {}

    def build(op: Op, args: tuple[Expression, ...]) -> Expression:
        part = Expression(op, args)
        if op in {Op.ASIN, Op.ACOS} and args[0].op in OTHER:
            size = apply(Op.ABS, apply(OTHER[args[0].op], *args[0].args))
            folds[size] = part
            return apply(Op.ATAN2, *((args[0], size) if op is Op.ASIN else (size, args[0])))
        if constant is not None and op is Op.ATAN and args[0].op is Op.DIV:
            numerator, denominator = args[0].args
            is_fixed = set(names_of(numerator)) <= constant and numerator != ZERO
            if is_fixed and may_be_zero(denominator):
                jump = apply(Op.SIGN, mul(numerator, denominator))
                folds[jump] = part
                smooth = apply(Op.ATAN, div(denominator, numerator))
                return add(mul(number(Fraction(pi / 2)), jump), neg(smooth))
        return part

    signed, signs = with_signs(formula)
    unfolded = rebuilt(signed, build)
    return (unfolded if folds else signed), folds | signs


def with_signs(formula: Expression) -> tuple[Expression, dict[Expression, Expression]]:
    """Formula with ``sign(a)`` in place of quotients like ``a/abs(a)``, and what each replaces."""
    signs: dict[Expression, Expression] = {}
    if not any(part.op in SIZES or root_of_even_power(part) for part in ordered(formula)):
        return formula, signs

    def build(op: Op, args: tuple[Expression, ...]) -> Expression:
        part = Expression(op, args)
        cancelled = without_quotient(part) if op in {Op.MUL, Op.DIV} else None
        if cancelled is None:
            return part
        signs.update({sign: part for sign in ordered(cancelled) if sign.op in {Op.SIGN, Op.ABS}})
        return cancelled

    unfolded = rebuilt(formula, build)
    return (formula if unfolded == formula else unfolded), signs
