"""Operations as text: one table for each target, and one function that reads them.

The text fixes the order of evaluation, so that targets agree bit for bit: every operand that is
not an atom stands in parentheses unless both languages read it from left to right anyway.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import TYPE_CHECKING, NamedTuple

from kousoku.model.errors import EmitError
from kousoku.model.operations.graph import Op, literal

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from fractions import Fraction


class Precedence(IntEnum):
    """Precedence of the outermost operation of a text."""

    SUM = 1
    PRODUCT = 2
    SIGN = 3
    ATOM = 4


class Text(NamedTuple):
    """Printed expression.

    Parameters
    ----------
    text : str
        The expression.
    precedence : Precedence
        Precedence of its outermost operation.
    is_number : bool
        Whether it is a constant.
    """

    text: str
    precedence: Precedence = Precedence.ATOM
    is_number: bool = False

    def within(self, least: Precedence) -> str:
        """Text, in parentheses if it binds less tightly than ``least``."""
        return self.text if self.precedence >= least else f"({self.text})"


@dataclass(frozen=True, slots=True)
class Printer:
    """Printer of operations for one target.

    Parameters
    ----------
    operators : mapping of Op to (str, Precedence)
        Sign and precedence of operators, which stand between or before operands.
    functions : mapping of Op to str
        Names of functions.
    """

    operators: Mapping[Op, tuple[str, Precedence]]
    functions: Mapping[Op, str]

    def constant(self, value: Fraction) -> Text:
        """Text of a number, the same in every target."""
        try:
            text = literal(value)
        except OverflowError as error:
            raise EmitError(f"a constant is no double ({error}); scale the formula") from error
        level = Precedence.SIGN if text.startswith("-") else Precedence.ATOM
        return Text(text, level, is_number=True)

    def apply(self, op: Op, args: Sequence[Text]) -> Text:
        """Text of ``op`` with printed operands."""
        if op in self.functions:
            return Text(f"{self.functions[op]}({', '.join(arg.text for arg in args)})")
        if op not in self.operators:
            raise EmitError(f"the operation {op.value} has no entry in this target's table")
        sign, level = self.operators[op]
        tighter = _TIGHTER[level]
        if len(args) == 1:
            return Text(f"{sign}{args[0].within(tighter)}", level)
        left, right = args
        is_chain = right.precedence == level != left.precedence
        is_factor = op is Op.MUL and right.is_number
        if op in _COMMUTATIVE and (is_chain or is_factor):
            left, right = right, left
        return Text(f"{left.within(level)} {sign} {right.within(tighter)}", level)


_COMMUTATIVE = frozenset({Op.ADD, Op.MUL})
_TIGHTER = {level: Precedence(level + 1) for level in Precedence if level < Precedence.ATOM}

_OPERATORS = {
    Op.ADD: ("+", Precedence.SUM),
    Op.SUB: ("-", Precedence.SUM),
    Op.MUL: ("*", Precedence.PRODUCT),
    Op.DIV: ("/", Precedence.PRODUCT),
    Op.NEG: ("-", Precedence.SIGN),
}

#: One lane or many: in C a vector is written as a number is, and functions are statements.
C = Printer(
    _OPERATORS,
    {
        Op.SQRT: "sqrt",
        Op.SIN: "sin",
        Op.COS: "cos",
        Op.ATAN2: "atan2",
        Op.EXP: "exp",
        Op.LOG: "log",
        Op.ABS: "fabs",
        Op.MAX: "fmax",
    },
)

NUMPY = Printer(
    _OPERATORS,
    {
        Op.SQRT: "np.sqrt",
        Op.SIN: "np.sin",
        Op.COS: "np.cos",
        Op.ATAN2: "np.arctan2",
        Op.EXP: "np.exp",
        Op.LOG: "np.log",
        Op.ABS: "np.abs",
        Op.MAX: "np.fmax",
    },
)

#: The operations that every target calls by name.
FUNCTIONS = frozenset(C.functions)
