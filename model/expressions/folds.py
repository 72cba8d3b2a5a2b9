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
"""The function whose sign tells on which branch the inverse of one is."""

SIZES = frozenset({Op.ABS, Op.LOG})
"""Functions, beside roots of even powers, of which quotients are jumps: logarithms in exponents."""


def without_folds(
    formula: Expression, constant: Set[str] | None = None
) -> tuple[Expression, dict[Expression, Expression]]:
    """Formula with ``abs`` and ``sign`` in place of its folds, and which fold each of them was.

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
            above, below = args[0].args
            is_fixed = set(names_of(above)) <= constant and above != ZERO
            if is_fixed and may_be_zero(below):
                jump = apply(Op.SIGN, mul(above, below))
                folds[jump] = part
                smooth = apply(Op.ATAN, div(below, above))
                return add(mul(number(Fraction(pi / 2)), jump), neg(smooth))
        return part

    signed, signs = with_signs(formula)
    unfolded = rebuilt(signed, build)
    return (unfolded if folds else signed), folds | signs


def with_signs(formula: Expression) -> tuple[Expression, dict[Expression, Expression]]:
    """Formula with ``sign(a)`` in place of quotients such as ``a/abs(a)``, and what each was."""
    signs: dict[Expression, Expression] = {}
    if not any(one.op in SIZES or root_of_even_power(one) for one in ordered(formula)):
        return formula, signs

    def build(op: Op, args: tuple[Expression, ...]) -> Expression:
        part = Expression(op, args)
        same = without_quotient(part) if op in {Op.MUL, Op.DIV} else None
        if same is None:
            return part
        signs.update({one: part for one in ordered(same) if one.op in {Op.SIGN, Op.ABS}})
        return same

    unfolded = rebuilt(formula, build)
    return (formula if unfolded == formula else unfolded), signs
