"""Read formulas of a scene file: a small grammar, and nothing that could run code.

::

    sum     = product (("+" | "-") product)*
    product = sign (("*" | "/") sign)*
    sign    = ("-" | "+") sign | power
    power   = atom ["^" sign]
    atom    = number ["deg"] | "pi" | "deg" | name | function "(" sum ("," sum)* ")" | "(" sum ")"

A power binds more tightly than a sign before it, and from right to left. A name is an identifier,
or several with dots between them. A number that ``deg`` follows is that many degrees, and ``deg``
alone is one: pi/180. A number of degrees is no divisor and is raised to no power without
parentheses, where it could be read in two ways. A square that is written out in a root is read as
one: ``sqrt(x^2 - 2*x + 1)`` as ``sqrt((x - 1)^2)``.
"""

from __future__ import annotations

import re
from fractions import Fraction
from sys import float_info
from typing import TYPE_CHECKING

from kousoku.model.angles import DEGREE, PI
from kousoku.model.errors import ExpressionError
from kousoku.model.expressions.polynomials import with_squares_apart
from kousoku.model.operations.expression import (
    ZERO,
    add,
    apply,
    div,
    mul,
    neg,
    number,
    ordered,
    power,
    symbol,
)
from kousoku.model.operations.graph import BINARY_OPS, Op
from kousoku.model.records.design import LARGEST
from kousoku.model.records.dotted_keys import unknown

if TYPE_CHECKING:
    from collections.abc import Collection

    from kousoku.model.operations.expression import Expression

LONGEST_FORMULA = 2000
"""Characters of the longest formula."""

LARGEST_DOUBLE = Fraction(float_info.max)
"""What a number in a formula may come to."""

DEEPEST = 60
"""Levels of the deepest formula: parentheses, and operations on results of others."""

ARGUMENTS = {
    op.value: 2 if op in BINARY_OPS else 1
    for op in (
        *(Op.SIN, Op.COS, Op.TAN, Op.ASIN, Op.ACOS, Op.ATAN, Op.ATAN2),
        *(Op.SQRT, Op.EXP, Op.LOG, Op.ABS, Op.SIGN, Op.MIN, Op.MAX),
    )
}
"""The functions that a formula may call, and how many arguments each takes."""

CONSTANTS = {"pi": PI, "deg": DEGREE}
"""The numbers that have a name."""

_TOKEN = re.compile(
    r"(?P<number>(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)"
    r"|(?P<name>[A-Za-z_][A-Za-z0-9_]*(?:\.[A-Za-z_][A-Za-z0-9_]*)*)"
    r"|(?P<mark>[-+*/^(),])"
)
_SPACE = re.compile(r"[ \t\r\n]*")


def parse_expression(
    text: str, names: Collection[str], *, longest: int = LONGEST_FORMULA
) -> Expression:
    """Read a formula.

    Parameters
    ----------
    text : str
        Such as ``"-20 * (a.angle - pi/4) + 0.1 * sin(2*pi*t)"``.
    names : collection of str
        What it may depend on, such as ``t``; dots are part of a name.
    longest : int
        Characters that it may have.

    Raises
    ------
    ExpressionError
        The text is no formula, with the column of what is wrong.
    """
    if len(text) > longest:
        raise ExpressionError(f"has {len(text)} characters; wanted at most {longest}", column=1)
    return _Parser(text, names).formula()


class _Parser:
    """Reader of the remaining text of a formula, one token ahead."""

    def __init__(self, text: str, names: Collection[str]) -> None:
        self.text = text
        self.names = names
        self.depths: dict[int, int] = {}
        self.kept: list[Expression] = []
        self.nesting = 0
        self.degrees_at = -1  # of the last number of degrees
        self.kind, self.token, self.start, self.end = "", "", 0, 0
        self.advance()

    def formula(self) -> Expression:
        expression = self.sum()
        if self.kind:
            is_factor = self.kind in {"name", "number"} or self.token == "("
            after = "; write the multiplication sign" if is_factor else ""
            raise self.error(f"{self.token[:40]!r} stands where an operator is wanted{after}")
        numbers = (part.value for part in ordered(expression) if part.value is not None)
        if any(abs(value) > LARGEST_DOUBLE for value in numbers):
            raise self.error(f"has a number beyond {float_info.max:.1e}, the largest double", 0)
        return expression

    def error(self, problem: str, start: int | None = None) -> ExpressionError:
        return ExpressionError(problem, column=(self.start if start is None else start) + 1)

    def advance(self) -> None:
        space = _SPACE.match(self.text, self.end)
        self.start = space.end() if space else self.end
        if self.start == len(self.text):
            self.kind, self.token, self.end = "", "", self.start
            return
        match = _TOKEN.match(self.text, self.start)
        if match is None:
            raise self.error(f"{self.text[self.start]!r} belongs to no formula")
        self.kind, self.token, self.end = match.lastgroup or "", match.group(), match.end()

    def takes(self, *marks: str) -> str:
        """Read one of some marks if it comes next; return it, or nothing."""
        if self.kind != "mark" or self.token not in marks:
            return ""
        mark = self.token
        self.advance()
        return mark

    def sum(self) -> Expression:
        start = self.start
        terms = [self.product()]
        while mark := self.takes("+", "-"):
            term = self.product()
            terms.append(term if mark == "+" else self.settled(neg(term), start))
        return self.settled(add(*terms), start)

    def product(self) -> Expression:
        start = self.start
        value = self.sign()
        while mark := self.takes("*", "/"):
            at = self.start
            if self.text.startswith("**", at - 1):
                raise self.error("'**' is no operator; wanted ^ for a power", at - 1)
            factor = self.sign()
            if mark == "/" and self.is_degrees(at):
                raise self.error("a division by degrees; wanted parentheses, or '*deg'", at)
            if mark == "/" and factor == ZERO:
                raise self.error("a division by zero", at)
            value = self.settled((mul if mark == "*" else div)(value, factor), start)
        return value

    def sign(self) -> Expression:
        start = self.start
        mark = self.takes("+", "-")
        if not mark:
            return self.power()
        self.nest(start)
        value = self.sign()
        self.nesting -= 1
        return self.settled(neg(value), start) if mark == "-" else value

    def power(self) -> Expression:
        start = self.start
        base = self.atom()
        if not self.takes("^"):
            return base
        at = self.start
        is_counted = self.is_degrees(start)
        self.nest(start)
        exponent = self.sign()
        self.nesting -= 1
        if is_counted or self.is_degrees(at):
            raise self.error("a power of degrees; wanted parentheses, or '*deg'", start)
        is_whole = exponent.value is not None and exponent.value.denominator == 1
        if base.value is not None and base.value < 0 and not is_whole:
            raise self.error("a negative number to a power that is not whole", start)
        if base == ZERO and (exponent.value is None or exponent.value < 0):
            raise self.error("zero to a power that is not a positive number", start)
        return self.settled(with_squares_apart(power(base, exponent)), start)

    def atom(self) -> Expression:
        start = self.start
        if self.takes("("):
            self.nest(start)
            inner = self.sum()
            self.nesting -= 1
            self.close(start)
            return inner
        kind, token = self.kind, self.token
        if kind not in {"name", "number"}:
            culprit = f"{token!r} stands" if kind else "the formula ends"
            raise self.error(f"{culprit} where a number, a name or a '(' is wanted")
        self.advance()
        if kind == "number":
            value = self.number(token, start)
            if self.token != "deg":
                return number(value)
            self.degrees_at = start
            self.advance()
            return number(value * DEGREE)
        if token in self.names:
            return symbol(token)
        if token in ARGUMENTS:
            return self.call(token, start)
        if token in CONSTANTS:
            return number(CONSTANTS[token])
        known = (*sorted(self.names), *ARGUMENTS, *CONSTANTS)
        raise self.error(unknown(f"name {token[:40]!r}", token, known), start)

    def is_degrees(self, start: int) -> bool:
        """Whether the text that was read since then begins with a number of degrees."""
        return start <= self.degrees_at and not self.text[start : self.degrees_at].strip(
            "+- \t\r\n"
        )

    def number(self, token: str, start: int) -> Fraction:
        digits, _, exponent = token.lower().partition("e")
        if len(digits) > 40 or len(exponent.lstrip("+-")) > 2 or float(token) > LARGEST:
            raise self.error(
                f"{token[:40]!r} is too long, too large or too small a number; wanted at most 40 "
                f"digits, at most {LARGEST:g}, and an exponent of two digits",
                start,
            )
        return Fraction(token)

    def call(self, token: str, start: int) -> Expression:
        count = ARGUMENTS[token]
        opened = self.start
        if not self.takes("("):
            raise self.error(f"'(' is missing: {token} is a function")
        self.nest(start)
        args = [self.sum()]
        while self.takes(","):
            args.append(self.sum())
        self.nesting -= 1
        self.close(opened)
        is_open = token in {"min", "max"}
        if len(args) != count and not (is_open and len(args) > count):
            wanted = f"{count} or more" if is_open else str(count)
            raise self.error(f"{token} of {len(args)} arguments; wanted {wanted}", start)
        op = Op(token)
        if count == 1:
            return self.settled(with_squares_apart(apply(op, *args)), start)
        value = args[0]
        for arg in args[1:]:
            value = self.settled(apply(op, value, arg), start)
        return value

    def close(self, opened: int) -> None:
        if not self.takes(")"):
            culprit = f"{self.token[:40]!r} stands" if self.kind else "the formula ends"
            raise self.error(f"{culprit} before the '(' of column {opened + 1} is closed")

    def nest(self, start: int) -> None:
        self.nesting += 1
        if self.nesting > DEEPEST:
            raise self.error(f"is nested more than {DEEPEST} deep", start)

    def settled(self, value: Expression, start: int) -> Expression:
        """Count the levels of a formula; return it."""
        if value.args and id(value) not in self.depths:
            depth = 1 + max(self.depths.get(id(arg), 0) for arg in value.args)
            if depth > DEEPEST:
                raise self.error(f"is more than {DEEPEST} operations deep", start)
            self.depths[id(value)] = depth
            self.kept.append(value)
        return value
