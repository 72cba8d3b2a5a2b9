"""The derivatives of operations by their arguments, over whatever has + − × ÷ and the functions."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from kousoku.model.operations.graph import Op

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from kousoku.model.operations.arithmetic import Arithmetic

    #: Takes the value of an operation, its arguments, and what they are computed with.
    Slopes = Callable[[Any, Sequence[Any], Arithmetic[Any]], tuple[Any, ...]]


def _of_arc(x: Any, numbers: Arithmetic[Any]) -> Any:
    """Root √(1 − x²), as a product that keeps its digits near ±1."""
    return numbers.sqrt((1 - x) * (1 + x))


def _of_angle(_: Any, args: Sequence[Any], __: Arithmetic[Any]) -> tuple[Any, ...]:
    y, x = args
    square = x * x + y * y
    return x / square, -y / square


#: By operation. At a kink they are those of one side: of the first argument of ``max`` where both
#: are equal, and of a rising ``abs`` at 0.
SLOPES: dict[Op, Slopes] = {
    Op.ADD: lambda *_: (1, 1),
    Op.SUB: lambda *_: (1, -1),
    Op.MUL: lambda _, x, __: (x[1], x[0]),
    Op.DIV: lambda z, x, _: (1 / x[1], -z / x[1]),
    Op.NEG: lambda *_: (-1,),
    Op.SQRT: lambda z, *_: (1 / (2 * z),),
    Op.SIN: lambda _, x, numbers: (numbers.cos(x[0]),),
    Op.COS: lambda _, x, numbers: (-numbers.sin(x[0]),),
    Op.TAN: lambda z, *_: (1 + z * z,),
    Op.ASIN: lambda _, x, numbers: (1 / _of_arc(x[0], numbers),),
    Op.ACOS: lambda _, x, numbers: (-1 / _of_arc(x[0], numbers),),
    Op.ATAN: lambda _, x, __: (1 / (1 + x[0] * x[0]),),
    Op.ATAN2: _of_angle,
    Op.EXP: lambda z, *_: (z,),
    Op.LOG: lambda _, x, __: (1 / x[0],),
    Op.ABS: lambda _, x, __: (1 if x[0] >= 0 else -1,),
    Op.MAX: lambda _, x, __: (1, 0) if x[0] >= x[1] else (0, 1),
}
