"""Exact derivatives of formulas, by the rules."""

from __future__ import annotations

from dataclasses import fields
from fractions import Fraction
from functools import partial
from typing import TYPE_CHECKING

from kousoku.model.expressions.polynomials import root_of_even_power
from kousoku.model.operations.arithmetic import FormulaArithmetic
from kousoku.model.operations.differentials import DIFFERENTIALS
from kousoku.model.operations.expression import (
    ONE,
    ZERO,
    add,
    apply,
    number,
    ordered,
    power,
)
from kousoku.model.operations.graph import Op

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.model.operations.expression import Expression


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
