"""The differentials of operations, over whatever has + − × ÷ and the functions."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from kousoku.model.operations.graph import Op

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from kousoku.model.operations.arithmetic import Arithmetic

    #: Takes the value of an operation, its arguments, their differentials, and the numbers.
    Differential = Callable[[Any, Sequence[Any], Sequence[Any], Arithmetic[Any]], Any]


def _of_arc(x: Any, numbers: Arithmetic[Any]) -> Any:
    """Root √(1 − x²), as a product that keeps its digits near ±1."""
    return numbers.sqrt((1 - x) * (1 + x))


def _of_angle(_: Any, args: Sequence[Any], changes: Sequence[Any], __: Arithmetic[Any]) -> Any:
    (y, x), (dy, dx) = args, changes
    return (dy * x - y * dx) / (y * y + x * x)


#: By operation. At a kink they are those of one side: of the first argument of ``max`` where both
#: are equal, and of a rising ``abs`` at 0.
DIFFERENTIALS: dict[Op, Differential] = {
    Op.ADD: lambda _, __, d, ___: d[0] + d[1],
    Op.SUB: lambda _, __, d, ___: d[0] - d[1],
    Op.MUL: lambda _, x, d, __: d[0] * x[1] + x[0] * d[1],
    Op.DIV: lambda z, x, d, _: (d[0] - z * d[1]) / x[1],
    Op.NEG: lambda _, __, d, ___: -d[0],
    Op.SQRT: lambda z, _, d, __: 1 / (2 * z) * d[0],
    Op.SIN: lambda _, x, d, numbers: numbers.cos(x[0]) * d[0],
    Op.COS: lambda _, x, d, numbers: -numbers.sin(x[0]) * d[0],
    Op.TAN: lambda z, _, d, __: (1 + z * z) * d[0],
    Op.ASIN: lambda _, x, d, numbers: 1 / _of_arc(x[0], numbers) * d[0],
    Op.ACOS: lambda _, x, d, numbers: -1 / _of_arc(x[0], numbers) * d[0],
    Op.ATAN: lambda _, x, d, __: 1 / (1 + x[0] * x[0]) * d[0],
    Op.ATAN2: _of_angle,
    Op.EXP: lambda z, _, d, __: z * d[0],
    Op.LOG: lambda _, x, d, __: 1 / x[0] * d[0],
    Op.ABS: lambda _, x, d, __: d[0] if x[0] >= 0 else -d[0],
    Op.MAX: lambda _, x, d, __: d[0] if x[0] >= x[1] else d[1],
}


def slopes_of(op: Op, value: Any, args: Sequence[Any], numbers: Arithmetic[Any]) -> tuple[Any, ...]:
    """Partial derivatives of an operation, by each of its arguments.

    Parameters
    ----------
    op : Op
        One of :data:`DIFFERENTIALS`.
    value : number
        Value of the operation.
    args : sequence of number
        Its arguments.
    numbers : Arithmetic
        What they are computed with.
    """
    differential = DIFFERENTIALS[op]
    if len(args) == 1:
        return (differential(value, args, (1,), numbers),)
    return differential(value, args, (1, 0), numbers), differential(value, args, (0, 1), numbers)
