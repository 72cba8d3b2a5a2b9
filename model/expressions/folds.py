"""Folds of a formula: functions that undo each other but for a kink or a jump, written with these.

Bounds of ``asin(sin(x))`` tell nothing where the argument of ``asin`` comes to its end, nor do
those of ``a/abs(a)`` beside zero.
"""

from __future__ import annotations

from kousoku.model.expressions.polynomials import root_of_even_power
from kousoku.model.operations.expression import Expression, apply, mul, neg, ordered, rebuilt
from kousoku.model.operations.graph import Op

OTHER = {Op.SIN: Op.COS, Op.COS: Op.SIN}
"""The function whose sign tells on which branch the inverse of one is."""


def without_folds(formula: Expression) -> tuple[Expression, dict[Expression, Expression]]:
    """Formula with ``abs`` and ``sign`` in place of its folds, and which fold each of them was.

    ``asin(sin(x))`` is ``atan2(sin(x), abs(cos(x)))``, and ``a/abs(a)`` is ``sign(a)``.
    """
    folds: dict[Expression, Expression] = {}

    def build(op: Op, args: tuple[Expression, ...]) -> Expression:
        part = Expression(op, args)
        if op in {Op.ASIN, Op.ACOS} and args[0].op in OTHER:
            size = apply(Op.ABS, apply(OTHER[args[0].op], *args[0].args))
            folds[size] = part
            return apply(Op.ATAN2, *((args[0], size) if op is Op.ASIN else (size, args[0])))
        sign = _sign_of(*args) if op is Op.DIV else None
        if sign is None:
            return part
        folds.update({one: part for one in ordered(sign) if one.op is Op.SIGN})
        return sign

    unfolded = rebuilt(formula, build)
    return (unfolded, folds) if folds else (formula, folds)


def _sign_of(a: Expression, b: Expression) -> Expression | None:
    """Quotient of a number and its size, either way and with factors, or None."""
    if (inside := _inside(a)) is not None and inside == b:
        return apply(Op.SIGN, inside)
    inside, factors, is_negative = _inside(b), [a], False
    while factors[-1].op in {Op.MUL, Op.NEG}:
        last = factors.pop()
        is_negative ^= last.op is Op.NEG
        factors += reversed(last.args)
    if inside is None or inside not in factors:
        return None
    factors[factors.index(inside)] = apply(Op.SIGN, inside)
    product = mul(*reversed(factors))
    return neg(product) if is_negative else product


def _inside(size: Expression) -> Expression | None:
    """Number whose size ``abs(a)``, or a root of its square, another one is."""
    if size.op is Op.ABS:
        return size.args[0]
    root = root_of_even_power(size)
    return root[0] if root is not None and root[1] == 1 else None
