"""Formulas: numbers, names, and operations on formulas; the builders fold numbers that meet.

Nothing here evaluates text: :mod:`kousoku.model.expressions.parser` reads a formula into these
nodes, and the code that is generated from them computes it. Numbers are exact.
"""

from __future__ import annotations

from fractions import Fraction
from hashlib import blake2b
from typing import TYPE_CHECKING, TypeVar

from kousoku.model.operations.arithmetic import OPERATORS
from kousoku.model.operations.graph import Op, OperationNode

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

T = TypeVar("T")

LARGEST_BITS = 4096
"""Bits of the largest numerator or denominator: a longer number is left as a formula."""


class Expression(OperationNode["Expression"]):
    """A formula, of which operators make others: a number, a name, or an operation on formulas.

    Operands are formulas where those of a graph are ids. A graph moves signs, orders operands and
    keeps all that it was given; a formula stays as it is written, but for numbers that meet, and
    lasts as long as somebody holds it. Parts may be shared: it is walked with :func:`ordered`,
    never by recursion, and compared by its key, as a tree may have many times as many parts.
    """

    __slots__ = ("_key",)

    _key: str

    @property
    def name(self) -> str:
        """Name of a quantity that changes, such as ``t``; empty of other expressions."""
        return self.symbol[0] if self.symbol else ""

    @property
    def key(self) -> str:
        """Structural key, which only equal formulas share; computed when it is first asked for."""
        stack = [] if hasattr(self, "_key") else [self]
        while stack:
            args = stack[-1].args
            missing = [arg for arg in args if not hasattr(arg, "_key")]
            stack.extend(missing)
            if not missing:
                part = stack.pop()
                text = " ".join((*part._own_key(), *(arg._key for arg in args)))
                part._key = blake2b(text.encode(), digest_size=16).hexdigest()
        return self._key

    def _own_key(self) -> tuple[str, ...]:
        """Key that tells a formula from others, but for its operands."""
        if self.value is not None:
            return "number", *(f"{part:x}" for part in self.value.as_integer_ratio())
        return ("name", self.name) if self.symbol else (self.op.value,)

    def __eq__(self, other: object) -> bool:
        if self is other or not isinstance(other, Expression) or self.op is not other.op:
            return self is other
        if self.args:
            return self.key == other.key
        return self.value == other.value and self.symbol == other.symbol

    def __hash__(self) -> int:
        return hash(self.key)

    def __add__(self, other: Operand) -> Expression:
        return add(self, _term(other))

    def __radd__(self, other: Operand) -> Expression:
        return add(_term(other), self)

    def __sub__(self, other: Operand) -> Expression:
        return add(self, neg(_term(other)))

    def __rsub__(self, other: Operand) -> Expression:
        return add(_term(other), neg(self))

    def __mul__(self, other: Operand) -> Expression:
        return mul(self, _term(other))

    def __rmul__(self, other: Operand) -> Expression:
        return mul(_term(other), self)

    def __truediv__(self, other: Operand) -> Expression:
        return div(self, _term(other))

    def __rtruediv__(self, other: Operand) -> Expression:
        return div(_term(other), self)

    def __neg__(self) -> Expression:
        return neg(self)


Operand = Expression | Fraction | int


def number(value: Fraction | int) -> Expression:
    """Formula of an exact number."""
    return Expression(Op.CONST, value=Fraction(value))


def symbol(name: str) -> Expression:
    """Formula of a quantity that changes."""
    return Expression(Op.INPUT, symbol=(name, 0))


ZERO, ONE = number(0), number(1)


def add(*terms: Expression) -> Expression:
    """Sum of formulas; zeros are left out, and numbers that meet are added."""
    kept: list[Expression] = []
    for term in terms:
        if kept and (sum_ := _folded(kept[-1], term, Op.ADD)) is not None:
            kept[-1] = sum_
        else:
            kept.append(term)
    kept = [term for term in kept if term != ZERO]
    if not kept:
        return ZERO
    return kept[0] if len(kept) == 1 else Expression(Op.ADD, tuple(kept))


def mul(*factors: Expression) -> Expression:
    """Product of formulas, from left to right; zeros and ones fold away."""
    product: Expression = ONE
    for factor in factors:
        if ZERO in (product, factor):
            return ZERO
        if ONE in (product, factor):
            product = factor if product == ONE else product
        else:
            folded = _folded(product, factor, Op.MUL)
            product = Expression(Op.MUL, (product, factor)) if folded is None else folded
    return product


def div(a: Expression, b: Expression) -> Expression:
    """Quotient a / b; b is not the number zero."""
    if a == ZERO or b == ONE:
        return a
    quotient = _folded(a, b, Op.DIV)
    return Expression(Op.DIV, (a, b)) if quotient is None else quotient


def neg(a: Expression) -> Expression:
    """Negative −a."""
    if a.value is not None:
        return number(-a.value)
    return a.args[0] if a.op is Op.NEG else Expression(Op.NEG, (a,))


def power(a: Expression, b: Expression) -> Expression:
    """Power aᵇ."""
    if b == ZERO:
        return ONE
    if b == ONE:
        return a
    if a.value and b.value is not None and b.value.denominator == 1:
        exponent = int(b.value)
        if abs(exponent) * bits_of(a.value) <= LARGEST_BITS:
            return number(a.value**exponent)
    return Expression(Op.POW, (a, b))


def apply(op: Op, *args: Expression) -> Expression:
    """Function of formulas, through its builder where it has one."""
    match op:
        case Op.ADD:
            return add(*args)
        case Op.MUL:
            return mul(*args)
        case Op.DIV:
            return div(*args)
        case Op.NEG:
            return neg(*args)
        case Op.POW:
            return power(*args)
        case _:
            return Expression(op, args)


def ordered(expression: Expression) -> tuple[Expression, ...]:
    """Parts of a formula, each once and after its own parts, the formula last.

    Parts are distinguished by identity: a formula that is shared is one part.
    """
    done: dict[int, Expression] = {}
    stack = [expression]
    while stack:
        part = stack[-1]
        missing = [arg for arg in part.args if id(arg) not in done]
        if missing:
            stack.extend(reversed(missing))
        else:
            done[id(stack.pop())] = part
    return tuple(done.values())


def evaluated(
    expression: Expression,
    number: Callable[[Fraction], T],
    names: Mapping[str, T],
    apply: Callable[[Op, Sequence[T]], T],
) -> T:
    """Value of a formula, of whatever its numbers and names are.

    Parameters
    ----------
    expression : Expression
        The formula.
    number : callable
        Gives the value of a number.
    names : mapping of str
        The value of each name.
    apply : callable
        Gives an operation on values.
    """
    known: dict[int, T] = {}
    for part in ordered(expression):
        if part.args:
            known[id(part)] = apply(part.op, [known[id(arg)] for arg in part.args])
        else:
            known[id(part)] = names[part.name] if part.value is None else number(part.value)
    return known[id(expression)]


def names_of(expression: Expression) -> tuple[str, ...]:
    """Names that a formula depends on, in the order of the text."""
    return tuple(dict.fromkeys(part.name for part in ordered(expression) if part.name))


def rebuilt(
    expression: Expression, build: Callable[[Op, tuple[Expression, ...]], Expression]
) -> Expression:
    """Formula with all its operations made anew, from the inside out.

    Parameters
    ----------
    expression : Expression
        The formula.
    build : callable
        Makes an operation on formulas that were made before.
    """
    known: dict[int, Expression] = {}
    for node in ordered(expression):
        args = tuple(known[id(arg)] for arg in node.args)
        known[id(node)] = build(node.op, args) if args else node
    return known[id(expression)]


def replaced(
    expression: Expression,
    part: Expression,
    by: Expression,
    build: Callable[[Op, tuple[Expression, ...]], Expression] = Expression,
) -> Expression:
    """Formula with another in place of a part.

    Parameters
    ----------
    expression, part, by : Expression
        The formula, the part that is replaced wherever it stands, and its replacement.
    build : callable
        Makes a function of its arguments anew; left out, nothing is folded.
    """
    known: dict[int, Expression] = {}
    for node in ordered(expression):
        if node == part:
            known[id(node)] = by
        elif node.args:
            known[id(node)] = build(node.op, tuple(known[id(arg)] for arg in node.args))
        else:
            known[id(node)] = node
    return known[id(expression)]


def _term(operand: Operand) -> Expression:
    return operand if isinstance(operand, Expression) else number(operand)


def _folded(a: Expression, b: Expression, op: Op) -> Expression | None:
    """Number that two numbers make, unless it has too many digits."""
    if a.value is None or b.value is None or bits_of(a.value) + bits_of(b.value) > LARGEST_BITS:
        return None
    return number(OPERATORS[op](a.value, b.value))


def bits_of(value: Fraction) -> int:
    """Bits of the longer of numerator and denominator."""
    return max(value.numerator.bit_length(), value.denominator.bit_length())
