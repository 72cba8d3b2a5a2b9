"""The value of a formula, in doubles."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from kousoku.model.terms import Apply, Function, Name, Number, ordered

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from kousoku.model.terms import Expression

_CALLS: dict[Function, Callable[..., float]] = {
    Function.ADD: lambda *terms: math.fsum(terms),
    Function.MUL: lambda a, b: a * b,
    Function.DIV: lambda a, b: a / b,
    Function.NEG: lambda a: -a,
    Function.POW: pow,
    Function.SIN: math.sin,
    Function.COS: math.cos,
    Function.TAN: math.tan,
    Function.ASIN: math.asin,
    Function.ACOS: math.acos,
    Function.ATAN: math.atan,
    Function.ATAN2: math.atan2,
    Function.SQRT: math.sqrt,
    Function.EXP: math.exp,
    Function.LOG: math.log,
    Function.ABS: abs,
    Function.SIGN: lambda a: float((a > 0) - (a < 0)),
    Function.MIN: min,
    Function.MAX: max,
}


def value_of(expression: Expression, values: Mapping[str, float]) -> float:
    """Return the value of a formula; not a number where it has none that is real and finite.

    Parameters
    ----------
    expression : Expression
        The formula.
    values : mapping of str to float
        The value of each name in it.
    """
    known: dict[int, float] = {}
    for part in ordered(expression):
        match part:
            case Number():
                known[id(part)] = float(part.value)
            case Name():
                known[id(part)] = values[part.name]
            case Apply():
                known[id(part)] = _applied(part.function, [known[id(arg)] for arg in part.args])
    value = known[id(expression)]
    return value if math.isfinite(value) else math.nan


def _applied(function: Function, values: list[float]) -> float:
    try:
        value = _CALLS[function](*values)
    except OverflowError:  # as in solvers: what is divided by it is zero
        return math.inf if function is Function.EXP else math.nan
    except (ValueError, ZeroDivisionError):
        return math.nan
    return value if isinstance(value, float) else math.nan
