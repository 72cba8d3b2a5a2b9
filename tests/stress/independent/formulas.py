"""Formulas of scenes, read by Python's own grammar of expressions, of which a little is allowed."""

from __future__ import annotations

import ast
import math
import operator
import re
from typing import TYPE_CHECKING, Any

from tests.stress.independent import numbers

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    Number = Any

OPERATIONS: dict[type[ast.AST], Callable[..., Number]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
    ast.USub: operator.neg,
    ast.UAdd: operator.pos,
}
FUNCTIONS: dict[str, Callable[..., Number]] = {
    name: getattr(numbers, name)
    for name in ("sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sqrt", "exp", "log", "sign")
} | {"abs": numbers.absolute, "min": numbers.least, "max": numbers.largest}


class Reader:
    """What reads numbers and formulas.

    Parameters
    ----------
    real : callable
        ``float``, or ``mpmath.mp.mpf``: makes a number of a number or of its digits.
    parameters : mapping of str to number
        What all formulas may name.
    """

    def __init__(self, real: Callable[[Any], Number] = float, parameters: Any = ()) -> None:
        self.real = real
        self.pi: Number = getattr(real(1), "context", math).pi + real(0)
        self.parameters: dict[str, Number] = {}
        self.parameters = {name: self.number(x) for name, x in dict(parameters).items()}

    def number(self, given: float | str, names: Mapping[str, Number] | None = None) -> Number:
        """Value of a number or of a formula, with more names than the parameters."""
        if not isinstance(given, str):
            return self.real(given)
        text = re.sub(r"(?<=[0-9.])\s*deg\b", "*deg", given.strip()).replace("^", "**")
        known = {"pi": self.pi, "deg": self.pi / 180, **self.parameters, **(names or {})}
        return self._value(ast.parse(text, mode="eval").body, text, known)

    def vector(self, given: Any, names: Mapping[str, Number] | None = None) -> list[Number]:
        """List of numbers and formulas as numbers."""
        return [self.number(x, names) for x in given]

    def _value(self, node: ast.expr, text: str, names: Mapping[str, Number]) -> Number:
        def value(part: ast.expr) -> Number:
            return self._value(part, text, names)

        match node:
            case ast.Constant(value=int() | float()):
                return self.real(ast.get_source_segment(text, node))
            case ast.Name(id=name) if name in names:
                return names[name]
            case ast.BinOp(left=left, op=op, right=right) if type(op) in OPERATIONS:
                return OPERATIONS[type(op)](value(left), value(right))
            case ast.UnaryOp(op=op, operand=operand) if type(op) in OPERATIONS:
                return OPERATIONS[type(op)](value(operand))
            case ast.Call(func=ast.Name(id=name), args=args, keywords=[]) if name in FUNCTIONS:
                return FUNCTIONS[name](*map(value, args))
            case _:
                raise ValueError(f"{ast.unparse(node)} is no part of a formula")
