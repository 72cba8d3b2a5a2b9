"""Nodes of the graph for the formulas of a scene."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING

from kousoku.model.errors import FreezeError
from kousoku.model.numbers.real import SMALLEST_SUBNORMAL
from kousoku.model.operations.expression import bits_of, evaluated
from kousoku.model.operations.graph import Op

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from kousoku.model.operations.expression import Expression
    from kousoku.model.operations.graph import Graph

LARGEST_EXPONENT = 2**64
"""Whole and half exponents up to it become products: exp and log have no value of negative numbers.
A product of squares loses no more digits than rounding of its base does."""

LARGEST_BITS = 8192
"""Bits of the largest exact constant; one with more is rounded to a double."""


def to_graph(expression: Expression, graph: Graph, leaves: Mapping[str, int]) -> int:
    """Node of a formula.

    Parameters
    ----------
    expression : Expression
        The formula.
    graph : Graph
        Graph that its operations are added to.
    leaves : mapping of str to int
        The node of each name that it depends on.

    Raises
    ------
    FreezeError
        A name has no node, or a constant is no double.
    """

    def number(value: Fraction) -> int:
        return _bounded(graph, graph.const(value))

    def apply(op: Op, args: Sequence[int]) -> int:
        return _bounded(graph, _apply(graph, op, args))

    try:
        return evaluated(expression, number, leaves, apply)
    except KeyError as name:
        known = ", ".join(leaves) or "none"
        raise FreezeError(f"the name {name.args[0]} has no node; there are {known}") from None


def _apply(graph: Graph, op: Op, args: Sequence[int]) -> int:
    """Node of a function; operations that the graph does not have are composed."""
    match op:
        case Op.ADD:
            return graph.sum(args)
        case Op.POW:
            return _power(graph, *args)
        case Op.MIN:
            return graph.neg(graph.max(*(graph.neg(arg) for arg in args)))
        case Op.MUL | Op.DIV | Op.ATAN2 | Op.MAX:
            return int(getattr(graph, op.value)(*args))
        case _:
            return _unary(graph, op, args[0])


def _unary(graph: Graph, op: Op, x: int) -> int:
    one = graph.const(1)
    match op:
        case Op.TAN:
            return graph.div(graph.sin(x), graph.cos(x))
        case Op.ASIN:
            return graph.atan2(x, _arc(graph, x))
        case Op.ACOS:
            return graph.atan2(_arc(graph, x), x)
        case Op.ATAN:
            return graph.atan2(x, one)
        case Op.SIGN:
            # Exactly ±1, and 0 at 0: no double but zero is smaller than the one it divides by.
            smallest = graph.const(SMALLEST_SUBNORMAL)
            return graph.div(x, graph.max(graph.abs(x), smallest))
        case _:
            return int(getattr(graph, op.value)(x))


def _arc(graph: Graph, x: int) -> int:
    """Root √(1 − x²), as a product that keeps its digits near ±1."""
    one = graph.const(1)
    return graph.sqrt(graph.mul(graph.sub(one, x), graph.add(one, x)))


def _power(graph: Graph, a: int, b: int) -> int:
    exponent = graph.value(b)
    if exponent is None or exponent.denominator > 2 or abs(exponent) > LARGEST_EXPONENT:
        return graph.exp(graph.mul(b, graph.log(a)))
    root = graph.const(1) if exponent.denominator == 1 else graph.sqrt(a)
    product = graph.mul(_repeated(graph, a, int(abs(exponent))), root)
    return product if exponent > 0 else graph.div(graph.const(1), product)


def _repeated(graph: Graph, a: int, count: int) -> int:
    """Product of `count` equal factors, by squaring."""
    product = graph.const(1)
    while count:
        if count % 2:
            product = graph.mul(product, a)
        count //= 2
        if count:
            a = _bounded(graph, graph.mul(a, a))
    return product


def _bounded(graph: Graph, node: int) -> int:
    """Node, rounded to a double if it is a constant of very many digits."""
    value = graph.value(node)
    if value is None or bits_of(value) <= LARGEST_BITS:
        return node
    try:
        return graph.const(Fraction(float(value)))
    except OverflowError:
        raise FreezeError("a constant in a formula is too large for a double") from None
