"""The builder shares equal nodes, folds exact constants, and never changes a value."""

import math
from fractions import Fraction

import pytest

from kousoku.model.operations.graph import BINARY_OPS, GRAPH_OPS, Graph, Op, literal


@pytest.fixture
def graph() -> Graph:
    return Graph()


def test_equal_expressions_are_one_node(graph: Graph) -> None:
    x, y = graph.input("x", 0), graph.input("y", 0)
    assert graph.mul(x, y) == graph.mul(y, x)
    assert graph.add(x, y) == graph.add(y, x)
    assert graph.sub(x, y) != graph.sub(y, x)


def test_zero_and_one_fold_away(graph: Graph) -> None:
    x, zero, one = graph.input("x", 0), graph.const(0), graph.const(1)
    assert graph.add(x, zero) == graph.sub(x, zero) == graph.mul(one, x) == graph.div(x, one) == x
    assert graph.mul(x, zero) == graph.sub(x, x) == zero
    assert graph.mul(x, graph.const(-1)) == graph.neg(x)
    assert graph.sin(zero) == zero
    assert graph.cos(zero) == one


def test_absolute_values_and_extremes_fold(graph: Graph) -> None:
    x, y, minus = graph.input("x", 0), graph.input("y", 0), graph.const(-3)
    assert graph.abs(graph.neg(x)) == graph.abs(x) == graph.abs(graph.abs(x))
    assert graph.value(graph.abs(minus)) == 3
    assert graph.max(x, y) == graph.max(y, x)
    assert graph.max(x, x) == x
    assert graph.value(graph.max(minus, graph.const(2))) == 2
    assert graph.value(graph.exp(graph.const(0))) == 1
    assert graph.value(graph.log(graph.const(1))) == 0


def test_constants_fold_exactly_and_round_once(graph: Graph) -> None:
    tenth, fifth = graph.const(Fraction(1, 10)), graph.const(Fraction(1, 5))
    assert graph.value(graph.add(tenth, fifth)) == Fraction(3, 10)
    assert literal(Fraction(3, 10)) == "0.3"
    assert graph.value(graph.const(0.1)) == Fraction(0.1) != Fraction(1, 10)


def test_signs_move_outwards(graph: Graph) -> None:
    x, y = graph.input("x", 0), graph.input("y", 0)
    assert graph.mul(graph.neg(x), graph.neg(y)) == graph.mul(x, y)
    assert graph.mul(graph.neg(x), y) == graph.neg(graph.mul(x, y))
    assert graph.add(x, graph.neg(y)) == graph.sub(x, y) == graph.neg(graph.sub(y, x))
    assert graph.sub(graph.neg(x), y) == graph.neg(graph.add(x, y))
    assert graph.div(graph.neg(x), graph.neg(y)) == graph.div(x, y)
    assert graph.sin(graph.neg(x)) == graph.neg(graph.sin(x))
    assert graph.cos(graph.neg(x)) == graph.cos(x)


def test_operands_stand_before_their_node(graph: Graph) -> None:
    x, y = graph.input("x", 0), graph.input("y", 0)
    graph.atan2(graph.sqrt(graph.sum([x, y, graph.mul(x, y)])), graph.cos(y))
    assert all(arg < k for k, node in enumerate(graph.nodes) for arg in node.args)


def test_every_operation_can_be_rebuilt_by_name(graph: Graph) -> None:
    x, y = graph.input("x", 0), graph.input("y", 0)
    for op in GRAPH_OPS - {Op.CONST, Op.INPUT}:
        args = (x, y) if op in BINARY_OPS else (x,)
        assert graph.nodes[graph.apply(op, args)].op is op


@pytest.mark.parametrize("value", [0.1 + 0.2, 1e-300, 5e-324, math.pi, -1.0 / 3.0, 1e22])
def test_literals_read_back_as_the_same_double(value: float) -> None:
    assert float(literal(Fraction(value))) == value
