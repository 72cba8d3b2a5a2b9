"""The value of a formula in 50 digits."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.model import precise
from kousoku.model.precise import CONTEXT
from kousoku.model.terms import Apply, Function, Name, Number, ordered

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from kousoku.model.precise import High
    from kousoku.model.terms import Expression

_CALLS: dict[Function, Callable[..., High]] = {
    Function.ADD: lambda *terms: CONTEXT.fsum(terms),
    Function.MUL: lambda a, b: a * b,
    Function.DIV: lambda a, b: a / b,
    Function.NEG: lambda a: -a,
    Function.POW: CONTEXT.power,
    Function.SIN: CONTEXT.sin,
    Function.COS: CONTEXT.cos,
    Function.TAN: CONTEXT.tan,
    Function.ASIN: CONTEXT.asin,
    Function.ACOS: CONTEXT.acos,
    Function.ATAN: CONTEXT.atan,
    Function.ATAN2: CONTEXT.atan2,
    Function.SQRT: CONTEXT.sqrt,
    Function.EXP: CONTEXT.exp,
    Function.LOG: CONTEXT.log,
    Function.ABS: abs,
    Function.SIGN: CONTEXT.sign,
    Function.MIN: min,
    Function.MAX: max,
}


def value_of(expression: Expression, values: Mapping[str, High]) -> High:
    """Return the value of a formula; not a number where it has none that is real and finite.

    Parameters
    ----------
    expression : Expression
        The formula.
    values : mapping of str to number
        The value of each name in it.
    """
    known: dict[int, High] = {}
    for part in ordered(expression):
        match part:
            case Number():
                known[id(part)] = precise.number(part.value)
            case Name():
                known[id(part)] = values[part.name]
            case Apply():
                known[id(part)] = _applied(part.function, [known[id(arg)] for arg in part.args])
    return known[id(expression)]


def _applied(function: Function, values: list[High]) -> High:
    try:
        value = _CALLS[function](*values)
    except (ValueError, ZeroDivisionError, OverflowError):
        return CONTEXT.nan
    is_number = isinstance(value, CONTEXT.mpf) and CONTEXT.isfinite(value)
    return value if is_number else CONTEXT.nan
