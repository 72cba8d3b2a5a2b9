"""The derivatives of operations by their arguments, over whatever has + − × ÷ and the functions."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from kousoku.model.arithmetic import Arithmetic

    #: Takes the value of an operation, its arguments, and what they are computed with.
    Slopes = Callable[[Any, Sequence[Any], Arithmetic[Any]], tuple[Any, ...]]


def _of_arc(x: Any, numbers: Arithmetic[Any]) -> Any:
    """Return √(1 − x²), as a product that keeps its digits near ±1."""
    return numbers.sqrt((1 - x) * (1 + x))


def _of_angle(_: Any, args: Sequence[Any], __: Arithmetic[Any]) -> tuple[Any, ...]:
    y, x = args
    square = x * x + y * y
    return x / square, -y / square


#: By the name of an operation. At a kink they are those of one side: of the first argument of
#: ``max`` where both are equal, and of a rising ``abs`` at 0.
SLOPES: dict[str, Slopes] = {
    "add": lambda *_: (1, 1),
    "sub": lambda *_: (1, -1),
    "mul": lambda _, x, __: (x[1], x[0]),
    "div": lambda z, x, _: (1 / x[1], -z / x[1]),
    "neg": lambda *_: (-1,),
    "sqrt": lambda z, *_: (1 / (2 * z),),
    "sin": lambda _, x, numbers: (numbers.cos(x[0]),),
    "cos": lambda _, x, numbers: (-numbers.sin(x[0]),),
    "tan": lambda z, *_: (1 + z * z,),
    "asin": lambda _, x, numbers: (1 / _of_arc(x[0], numbers),),
    "acos": lambda _, x, numbers: (-1 / _of_arc(x[0], numbers),),
    "atan": lambda _, x, __: (1 / (1 + x[0] * x[0]),),
    "atan2": _of_angle,
    "exp": lambda z, *_: (z,),
    "log": lambda _, x, __: (1 / x[0],),
    "abs": lambda _, x, __: (1 if x[0] >= 0 else -1,),
    "max": lambda _, x, __: (1, 0) if x[0] >= x[1] else (0, 1),
}
