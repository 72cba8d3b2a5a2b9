"""Scalar operations, and the expression graph: equal ones are one node, in topological order.

Equal sub-expressions are one node by construction. The builder folds exact constants, drops zeros
and ones, and orders the operands of sums and products, so that no later pass has to. Numbers stay
rational until they are printed: a constant is rounded once, by :func:`literal`.
"""

from __future__ import annotations

import enum
from fractions import Fraction
from typing import TYPE_CHECKING, Generic, TypeVar

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence


class Op(enum.Enum):
    """The operations of kernels and formulas.

    ``ADD`` of a formula takes two operands or more. A power whose exponent is a whole number is a
    product, one with a half in it a square root of one; any other is exp(b log a) and wants a
    positive a. ``SIGN`` is −1, 0 or 1. No text has the last two, log(eᵃ + eᵇ) and eˣ/(1 + eˣ):
    bounds of others are made of them. Counts of operations are listed in this order.
    """

    CONST = "const"
    INPUT = "input"
    ADD = "add"
    SUB = "sub"
    MUL = "mul"
    DIV = "div"
    NEG = "neg"
    POW = "pow"
    SQRT = "sqrt"
    SIN = "sin"
    COS = "cos"
    TAN = "tan"
    ASIN = "asin"
    ACOS = "acos"
    ATAN = "atan"
    ATAN2 = "atan2"
    EXP = "exp"
    LOG = "log"
    ABS = "abs"
    SIGN = "sign"
    MIN = "min"
    MAX = "max"
    LOG_SUM = "log_sum"
    SHARE = "share"

    #: There is one object of each, and nodes are looked up by it: that of Enum is slow.
    __hash__ = object.__hash__


#: Operations of formulas only: graphs are made of others that have the same value.
COMPOSED_OPS = frozenset(
    {
        *(Op.POW, Op.TAN, Op.ASIN, Op.ACOS, Op.ATAN),
        *(Op.SIGN, Op.MIN, Op.LOG_SUM, Op.SHARE),
    }
)

#: Operations of graphs: every target can print them.
GRAPH_OPS = frozenset(Op) - COMPOSED_OPS

#: Operations that IEEE 754 rounds correctly: targets agree on them bit for bit.
EXACT_OPS = frozenset({Op.ADD, Op.SUB, Op.MUL, Op.DIV, Op.NEG, Op.SQRT, Op.ABS})

#: Operations of two operands.
BINARY_OPS = frozenset(
    {
        *(Op.ADD, Op.SUB, Op.MUL, Op.DIV, Op.POW),
        *(Op.ATAN2, Op.MIN, Op.MAX, Op.LOG_SUM),
    }
)


Arg = TypeVar("Arg")


class OperationNode(Generic[Arg]):
    """One scalar operation, of a graph or of a formula.

    Parameters
    ----------
    op : Op
        What is computed.
    args : tuple
        The operands. In a graph, and in a kernel, these are ids, each smaller than the node's own
        id; those of a formula are formulas,
        :class:`~kousoku.model.operations.expression.Expression`.
    value : Fraction, optional
        The exact number of a ``CONST``.
    symbol : tuple of (str, int), optional
        Array name and flat row-major index of an ``INPUT``.
    """

    # No frozen dataclass: graphs are made of very many, and it takes twice as long to make one.
    __slots__ = ("args", "op", "symbol", "value")
    __match_args__ = ("op", "args", "value", "symbol")

    def __init__(
        self,
        op: Op,
        args: tuple[Arg, ...] = (),
        value: Fraction | None = None,
        symbol: tuple[str, int] | None = None,
    ) -> None:
        self.op, self.args, self.value, self.symbol = op, args, value, symbol

    def _fields(self) -> tuple[object, ...]:
        return self.op, self.args, self.value, self.symbol

    def __repr__(self) -> str:
        fields = zip(self.__match_args__, self._fields(), strict=True)
        return f"{type(self).__name__}({', '.join(f'{name}={value!r}' for name, value in fields)})"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, OperationNode) and self._fields() == other._fields()

    def __hash__(self) -> int:
        return hash(self._fields())

    def with_args(self, args: tuple[Arg, ...]) -> OperationNode[Arg]:
        """Node of the same operation with other operands."""
        return OperationNode(self.op, args, self.value, self.symbol)


class Graph:
    """A growing graph; nodes are named by their ids, and equal nodes have equal ids."""

    def __init__(self) -> None:
        self._nodes: list[OperationNode[int]] = []
        self._ids: dict[tuple[Op, tuple[int, ...]], int] = {}
        self._inputs: dict[tuple[str, int], int] = {}
        self._numbers: dict[Fraction | int | float, int] = {}

    @property
    def nodes(self) -> Sequence[OperationNode[int]]:
        """The nodes in topological order."""
        return self._nodes

    def _add(self, node: OperationNode[int]) -> int:
        self._nodes.append(node)
        return len(self._nodes) - 1

    def _intern(self, op: Op, *args: int) -> int:
        known = self._ids.get(key := (op, args))
        if known is None:
            known = self._ids[key] = len(self._nodes)
            self._nodes.append(OperationNode(op, args))
        return known

    def const(self, value: Fraction | int | float) -> int:
        """Node of a number; a float stands for its exact binary value."""
        known = self._numbers.get(value)
        if known is None:
            known = self._numbers[value] = self._add(OperationNode(Op.CONST, value=Fraction(value)))
        return known

    def input(self, name: str, index: int) -> int:
        """Node of element ``index`` (flat, row-major) of the input array ``name``."""
        known = self._inputs.get((name, index))
        if known is None:
            known = self._inputs[name, index] = self._add(
                OperationNode(Op.INPUT, symbol=(name, index))
            )
        return known

    def value(self, a: int) -> Fraction | None:
        """Exact number of a constant node, None of any other."""
        return self._nodes[a].value

    def _negated(self, a: int) -> int | None:
        """Operand b where a is −b."""
        node = self._nodes[a]
        return node.args[0] if node.op is Op.NEG else None

    def add(self, a: int, b: int) -> int:
        """Sum a + b."""
        va, vb = self.value(a), self.value(b)
        if va is not None or vb is not None:
            if va is not None and vb is not None:
                return self.const(va + vb)
            if va == 0:
                return b
            if vb == 0:
                return a
        if (minus := self._negated(b)) is not None:
            return self.sub(a, minus)
        if (minus := self._negated(a)) is not None:
            return self.sub(b, minus)
        return self._intern(Op.ADD, min(a, b), max(a, b))

    def sub(self, a: int, b: int) -> int:
        """Difference a − b."""
        va, vb = self.value(a), self.value(b)
        if va is not None or vb is not None:
            if va is not None and vb is not None:
                return self.const(va - vb)
            if vb == 0:
                return a
            if va == 0:
                return self.neg(b)
        if a == b:
            return self.const(0)
        if (minus := self._negated(b)) is not None:
            return self.add(a, minus)
        if (minus := self._negated(a)) is not None:
            return self.neg(self.add(minus, b))
        return self._intern(Op.SUB, a, b)

    def neg(self, a: int) -> int:
        """Negative −a."""
        value, node = self.value(a), self._nodes[a]
        if value is not None:
            return self.const(-value)
        if node.op is Op.NEG:
            return node.args[0]
        if node.op is Op.SUB:
            return self._intern(Op.SUB, node.args[1], node.args[0])
        return self._intern(Op.NEG, a)

    def mul(self, a: int, b: int) -> int:
        """Product a · b."""
        va, vb = self.value(a), self.value(b)
        if va is not None or vb is not None:
            if va is not None and vb is not None:
                return self.const(va * vb)
            value, other = (va, b) if vb is None else (vb, a)
            if value == 0:
                return self.const(0)
            if value == 1:
                return other
            if value == -1:
                return self.neg(other)
        na, nb = self._negated(a), self._negated(b)
        if na is not None or nb is not None:
            product = self.mul(a if na is None else na, b if nb is None else nb)
            return product if na is not None and nb is not None else self.neg(product)
        return self._intern(Op.MUL, min(a, b), max(a, b))

    def div(self, a: int, b: int) -> int:
        """Quotient a / b."""
        va, vb = self.value(a), self.value(b)
        if vb is not None and vb != 0:
            if va is not None:
                return self.const(va / vb)
            if abs(vb) == 1:
                return a if vb == 1 else self.neg(a)
        if va == 0:
            return self.const(0)
        na, nb = self._negated(a), self._negated(b)
        if na is not None or nb is not None:
            quotient = self.div(a if na is None else na, b if nb is None else nb)
            return quotient if na is not None and nb is not None else self.neg(quotient)
        return self._intern(Op.DIV, a, b)

    def sqrt(self, a: int) -> int:
        """Root √a."""
        return self._intern(Op.SQRT, a)

    def sin(self, a: int) -> int:
        """Sine of a, a in radians."""
        if self.value(a) == 0:
            return a
        if (minus := self._negated(a)) is not None:
            return self.neg(self.sin(minus))
        return self._intern(Op.SIN, a)

    def cos(self, a: int) -> int:
        """Cosine of a, a in radians."""
        if self.value(a) == 0:
            return self.const(1)
        if (minus := self._negated(a)) is not None:
            return self.cos(minus)
        return self._intern(Op.COS, a)

    def atan2(self, y: int, x: int) -> int:
        """Angle of the vector (x, y), in (−π, π]."""
        return self._intern(Op.ATAN2, y, x)

    def exp(self, a: int) -> int:
        """Exponential: e to the power a."""
        return self.const(1) if self.value(a) == 0 else self._intern(Op.EXP, a)

    def log(self, a: int) -> int:
        """Natural logarithm of a."""
        return self.const(0) if self.value(a) == 1 else self._intern(Op.LOG, a)

    def abs(self, a: int) -> int:
        """Absolute value |a|."""
        value, node = self.value(a), self._nodes[a]
        if value is not None:
            return self.const(abs(value))
        if node.op is Op.NEG:
            return self.abs(node.args[0])
        return a if node.op is Op.ABS else self._intern(Op.ABS, a)

    def max(self, a: int, b: int) -> int:
        """Larger of a and b, and the other one where one of them is NaN."""
        va, vb = self.value(a), self.value(b)
        if va is not None and vb is not None:
            return self.const(max(va, vb))
        return a if a == b else self._intern(Op.MAX, min(a, b), max(a, b))

    def sum(self, terms: Iterable[int]) -> int:
        """Sum from left to right."""
        total = self.const(0)
        for term in terms:
            total = self.add(total, term)
        return total

    def apply(self, op: Op, args: Sequence[int]) -> int:
        """Node of ``op`` of ``args``: how a walk over another graph rebuilds a node here."""
        return int(getattr(self, _METHODS[op])(*args))


#: Methods of :class:`Graph` by the operation that they build: faster than the values of an Enum.
_METHODS = {op: op.value for op in GRAPH_OPS}


def literal(value: Fraction) -> str:
    """Shortest text that reads back as the double nearest to ``value``."""
    return repr(float(value))
