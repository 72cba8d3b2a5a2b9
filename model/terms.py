"""Formulas as trees: numbers, names, and functions of formulas; the builders fold what is known.

Nothing here evaluates text: :mod:`kousoku.model.expression` reads a formula into these records, and
the code that is generated from them computes it. Numbers are exact.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from fractions import Fraction
from hashlib import blake2b
from typing import TYPE_CHECKING, TypeVar, cast

from kousoku.model.graph import Op

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

T = TypeVar("T")

LARGEST_BITS = 4096
"""Bits of the largest numerator or denominator: a longer number is left as a formula."""


class Term:
    """A formula, of which operators make others.

    Formulas are compared by their keys: parts are shared, and a tree that was compared part by
    part would have many times as many.
    """

    __slots__ = ()

    _key: str

    @property
    def key(self) -> str:
        """That of equal formulas, and of no others; it is found when it is first asked for."""
        stack = [_term(self)] if not self._key else []
        while stack:
            args = stack[-1].args if isinstance(stack[-1], Apply) else ()
            missing = [arg for arg in args if not arg._key]
            stack.extend(missing)
            if not missing:
                part = stack.pop()
                text = " ".join((*part._own(), *(arg._key for arg in args)))
                digest = blake2b(text.encode(), digest_size=16).hexdigest()
                object.__setattr__(part, "_key", digest)
        return self._key

    def _own(self) -> tuple[str, ...]:
        """Return what tells it from others, but for its parts."""
        raise NotImplementedError

    def __eq__(self, other: object) -> bool:
        if self is other:
            return True
        return type(self) is type(other) and self.key == other.key

    def __hash__(self) -> int:
        return hash(self.key)

    def __add__(self, other: Operand) -> Expression:
        return add(_term(self), _term(other))

    def __radd__(self, other: Operand) -> Expression:
        return add(_term(other), _term(self))

    def __sub__(self, other: Operand) -> Expression:
        return add(_term(self), neg(_term(other)))

    def __rsub__(self, other: Operand) -> Expression:
        return add(_term(other), neg(_term(self)))

    def __mul__(self, other: Operand) -> Expression:
        return mul(_term(self), _term(other))

    def __rmul__(self, other: Operand) -> Expression:
        return mul(_term(other), _term(self))

    def __truediv__(self, other: Operand) -> Expression:
        return div(_term(self), _term(other))

    def __rtruediv__(self, other: Operand) -> Expression:
        return div(_term(other), _term(self))

    def __neg__(self) -> Expression:
        return neg(_term(self))


@dataclass(frozen=True, slots=True, eq=False)
class Number(Term):
    """An exact number."""

    value: Fraction
    _key: str = field(default="", init=False, repr=False)

    def _own(self) -> tuple[str, ...]:
        above, below = self.value.as_integer_ratio()
        return "number", f"{above:x}", f"{below:x}"


@dataclass(frozen=True, slots=True, eq=False)
class Name(Term):
    """A quantity that changes, such as ``t``."""

    name: str
    _key: str = field(default="", init=False, repr=False)

    def _own(self) -> tuple[str, ...]:
        return "name", self.name


@dataclass(frozen=True, slots=True, eq=False)
class Apply(Term):
    """A function of formulas.

    Parameters
    ----------
    op : Op
        What is applied.
    args : tuple of Expression
        To what. Parts may be shared: a tree is walked with :func:`ordered`, never by recursion.
    """

    op: Op
    args: tuple[Expression, ...]
    _key: str = field(default="", init=False, repr=False)

    def _own(self) -> tuple[str, ...]:
        return (self.op.value,)


Expression = Number | Name | Apply
Operand = Term | Fraction | int

ZERO, ONE = Number(Fraction(0)), Number(Fraction(1))


def number(value: Fraction | int) -> Number:
    """Return an exact number."""
    return Number(Fraction(value))


def add(*terms: Expression) -> Expression:
    """Return the sum of formulas; zeros are left out, and numbers that meet are added."""
    kept: list[Expression] = []
    for term in terms:
        if kept and (sum_ := _folded(kept[-1], term, "+")) is not None:
            kept[-1] = sum_
        else:
            kept.append(term)
    kept = [term for term in kept if term != ZERO]
    if not kept:
        return ZERO
    return kept[0] if len(kept) == 1 else Apply(Op.ADD, tuple(kept))


def mul(*factors: Expression) -> Expression:
    """Return the product of formulas, from left to right; zeros and ones fold away."""
    product: Expression = ONE
    for factor in factors:
        if ZERO in (product, factor):
            return ZERO
        if ONE in (product, factor):
            product = factor if product == ONE else product
        else:
            folded = _folded(product, factor, "*")
            product = Apply(Op.MUL, (product, factor)) if folded is None else folded
    return product


def div(a: Expression, b: Expression) -> Expression:
    """Return a / b; b is not the number zero."""
    if a == ZERO or b == ONE:
        return a
    quotient = _folded(a, b, "/")
    return Apply(Op.DIV, (a, b)) if quotient is None else quotient


def neg(a: Expression) -> Expression:
    """Return −a."""
    if isinstance(a, Number):
        return Number(-a.value)
    if isinstance(a, Apply) and a.op is Op.NEG:
        return a.args[0]
    return Apply(Op.NEG, (a,))


def power(a: Expression, b: Expression) -> Expression:
    """Return a to the power b."""
    if b == ZERO:
        return ONE
    if b == ONE:
        return a
    if isinstance(a, Number) and isinstance(b, Number) and b.value.denominator == 1 and a.value:
        exponent = int(b.value)
        if abs(exponent) * _bits(a.value) <= LARGEST_BITS:
            return Number(a.value**exponent)
    return Apply(Op.POW, (a, b))


def apply(op: Op, *args: Expression) -> Expression:
    """Return a function of formulas, through its builder where it has one."""
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
            return Apply(op, args)


def ordered(expression: Expression) -> tuple[Expression, ...]:
    """Return all parts of a formula, each once and after its own parts, the formula last.

    Parts are told apart by identity: a formula that is shared is one part.
    """
    done: dict[int, Expression] = {}
    stack = [expression]
    while stack:
        part = stack[-1]
        args: Iterable[Expression] = part.args if isinstance(part, Apply) else ()
        missing = [arg for arg in args if id(arg) not in done]
        if missing:
            stack.extend(reversed(missing))
        else:
            done[id(stack.pop())] = part
    return tuple(done.values())


def evaluated(
    expression: Expression,
    leaf: Callable[[Number | Name], T],
    apply: Callable[[Op, Sequence[T]], T],
) -> T:
    """Return what a formula is, of whatever its numbers and names are.

    Parameters
    ----------
    expression : Expression
        The formula.
    leaf : callable
        Gives the value of a number or a name.
    apply : callable
        Gives a function of values.
    """
    known: dict[int, T] = {}
    for part in ordered(expression):
        if isinstance(part, Apply):
            known[id(part)] = apply(part.op, [known[id(arg)] for arg in part.args])
        else:
            known[id(part)] = leaf(part)
    return known[id(expression)]


def names_of(expression: Expression) -> tuple[str, ...]:
    """Return the names that a formula depends on, in the order of the text."""
    names = (part.name for part in ordered(expression) if isinstance(part, Name))
    return tuple(dict.fromkeys(names))


def replaced(
    expression: Expression,
    part: Expression,
    by: Expression,
    build: Callable[[Op, tuple[Expression, ...]], Expression] = Apply,
) -> Expression:
    """Formula with another in place of a part.

    Parameters
    ----------
    expression, part, by : Expression
        The formula, what is replaced wherever it stands, and what by.
    build : callable
        Makes a function of its arguments anew; left out, nothing is folded.
    """
    known: dict[int, Expression] = {}
    for one in ordered(expression):
        if one == part:
            known[id(one)] = by
        elif isinstance(one, Apply):
            known[id(one)] = build(one.op, tuple(known[id(arg)] for arg in one.args))
        else:
            known[id(one)] = one
    return known[id(expression)]


def _term(given: Operand) -> Expression:
    return cast("Expression", given) if isinstance(given, Term) else number(given)


def _folded(a: Expression, b: Expression, sign: str) -> Number | None:
    """Return the number that two numbers make, unless it has too many digits."""
    if not isinstance(a, Number) or not isinstance(b, Number):
        return None
    if _bits(a.value) + _bits(b.value) > LARGEST_BITS:
        return None
    match sign:
        case "+":
            return Number(a.value + b.value)
        case "*":
            return Number(a.value * b.value)
        case _:
            return Number(a.value / b.value)


def _bits(value: Fraction) -> int:
    return max(value.numerator.bit_length(), value.denominator.bit_length())
