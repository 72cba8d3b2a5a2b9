"""Kinks of a formula of time: whether two derivatives go through them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from kousoku.model.expressions.derivative import derivative
from kousoku.model.expressions.folds import without_folds
from kousoku.model.expressions.switching import SMOOTH, even_root, may_be_zero
from kousoku.model.operations.expression import (
    Expression,
    add,
    apply,
    names_of,
    neg,
    number,
    ordered,
    power,
    rebuilt,
    replaced,
)
from kousoku.model.operations.graph import Op

if TYPE_CHECKING:
    from collections.abc import Mapping


KINKS = (Op.ABS, Op.SIGN, Op.MIN, Op.MAX)
"""Functions that do not have two derivatives everywhere."""

DEEPEST = 6
"""Kinks in the arguments of one, at most: each doubles the branches that are compared."""

DIGITS = 1e-30
"""Parts of their size by which both sides of a kink may differ: of 50 digits, and of π."""

PARAMETER_FACTORS = ("1", "1.0625", "0.921875")
"""Factors of the parameters, one power more for each: a run may change them."""


def kink_of(law: Expression, time: str, parameters: Mapping[str, float]) -> Expression | None:
    """First part of a formula at which its first two derivatives may jump.

    Both sides of a kink are looked at in 50 digits where its arguments are equal. It must be known
    when that is: their difference is linear in time.

    Parameters
    ----------
    law : Expression
        A formula of time and parameters.
    time : str
        The name of time.
    parameters : mapping of str to float
        Those of the scene; others near them are looked at, too.
    """
    law, folds = without_folds(law)
    law, roots = _without_roots(law)
    roots = folds | roots
    parts = [part for part in ordered(law) if part.op in KINKS]
    if not parts:
        return None
    from kousoku.model.numbers.digits import CONTEXT  # noqa: PLC0415 (mpmath is for kinks only)

    for part in parts:
        if time not in names_of(part):
            continue
        sides = (*part.args, neg(part.args[0]))[:2]
        for factor in PARAMETER_FACTORS:
            values: dict[str, Any] = {
                name: CONTEXT.mpf(value) * CONTEXT.mpf(factor) ** exponent
                for exponent, (name, value) in enumerate(parameters.items(), 1)
            }
            if (
                part.op is Op.SIGN
                or _count(part) > DEEPEST
                or not _is_smooth(law, part, sides, time, values)
            ):
                return roots.get(part, part)
    return None


def _without_roots(law: Expression) -> tuple[Expression, dict[Expression, Expression]]:
    """Formula with ``abs(a)`` in its roots of even powers, and the root that each replaces.

    ``sqrt(a^2)`` is ``abs(a)``, and ``(a^2)^0.75`` is ``abs(a)^1.5``.
    """
    roots: dict[Expression, Expression] = {}

    def build(op: Op, args: tuple[Expression, ...]) -> Expression:
        operation = Expression(op, args)
        root = even_root(operation)
        if root is None or not 0 < root[1] < SMOOTH or not may_be_zero(root[0]):
            return operation
        size = Expression(Op.ABS, (root[0],))
        roots[size] = operation
        return power(size, number(root[1]))

    return rebuilt(law, build), roots


def _is_smooth(
    law: Expression,
    part: Expression,
    sides: tuple[Expression, ...],
    time: str,
    values: Mapping[str, Any],
) -> bool:
    """Whether both sides have the same value and derivatives where they meet."""
    from kousoku.model.numbers.digits import CONTEXT  # noqa: PLC0415
    from kousoku.model.numbers.traced import traced  # noqa: PLC0415

    def at(expression: Expression, when: Any) -> Any:
        return traced(expression, {**values, time: when})

    gap = add(sides[0], neg(sides[1]))
    meetings = []
    for branch in _branches(gap):
        start, first, second = (at(branch, CONTEXT.mpf(k)) for k in range(3))
        rate, size = first - start, abs(start) + abs(first) + abs(second)
        if not abs(second - first - rate) <= DIGITS * size or (rate == 0 and start == 0):
            return False
        if rate != 0 and abs(at(gap, -start / rate)) <= DIGITS * size:
            meetings.append(-start / rate)
    left, right = (replaced(law, part, side) for side in sides)
    size = CONTEXT.mpf(0)
    for _ in range(3):
        for meeting in meetings:
            a, b = at(left, meeting), at(right, meeting)
            size = max(size, *(abs(at(_sizes(side), meeting)) for side in (left, right)))
            if not abs(a - b) <= DIGITS * size:
                return False
        left, right = derivative(left, time), derivative(right, time)
    return True


def _count(expression: Expression) -> int:
    return sum(part.op in KINKS for part in ordered(expression))


def _branches(gap: Expression) -> list[Expression]:
    """Branches of a formula, with either side of each kink in it."""
    for part in ordered(gap):
        if part.op in KINKS:
            sides = (*part.args, neg(part.args[0]))[:2]
            return [branch for side in sides for branch in _branches(replaced(gap, part, side))]
    return [gap]


def _sizes(expression: Expression) -> Expression:
    """Formula with all its sums over absolute values: the size of its terms."""

    def build(op: Op, args: tuple[Expression, ...]) -> Expression:
        is_sum = op is Op.ADD
        return add(*(apply(Op.ABS, arg) for arg in args)) if is_sum else Expression(op, args)

    return rebuilt(expression, build)
