"""Formulas as terms: what is equal, and what operators make of them."""

from __future__ import annotations

import pickle
from fractions import Fraction
from typing import TYPE_CHECKING

from kousoku.model.expressions.parser import parse_expression
from kousoku.model.operations.expression import Expression, add, evaluated, number, symbol
from kousoku.model.operations.graph import Graph, Op, OperationNode

if TYPE_CHECKING:
    from collections.abc import Sequence


T, X = symbol("t"), symbol("x")


def doubled(times: int) -> Expression:
    """Formula 2ⁿ t as sums of two equal parts, which are shared."""
    term: Expression = symbol("t")
    for _ in range(times):
        term = add(term, term)
    return term


def test_formulas_that_share_their_parts_are_compared_at_once() -> None:
    """As trees they have 2¹⁰⁰⁰ parts."""
    one, same, other = doubled(1000), doubled(1000), doubled(999)
    assert one is not same
    assert one == same and hash(one) == hash(same)
    assert one != other
    assert len({one, same, other}) == 2


def test_what_is_written_differently_differs() -> None:
    a, b, one = symbol("a"), symbol("b"), number(Fraction(1))
    formulas = [
        *(a, symbol("number"), symbol("1"), one, number(Fraction(1, 11)), number(Fraction(11, 1))),
        *(Expression(Op.ADD, (a, b)), Expression(Op.ADD, (b, a)), Expression(Op.MUL, (a, b))),
        *(
            Expression(Op.ADD, (a, b, one)),
            Expression(Op.ADD, (Expression(Op.ADD, (a, b)), one)),
        ),
    ]
    assert len(set(formulas)) == len(formulas)
    assert T != "t"


def test_operators_make_the_formulas_that_texts_are_read_as() -> None:
    made = 2 * T - X / (1 - T) + -(X * T) + Fraction(1, 2)
    assert made == parse_expression("((2*t - x/(1 - t)) + -(x*t)) + 0.5", ("t", "x"))


def test_a_formula_that_was_pickled_is_the_same() -> None:
    formula = parse_expression("sin(2*t) + x", ("t", "x"))
    again = pickle.loads(pickle.dumps(formula))
    assert again == formula and again.key == formula.key


def test_a_formula_is_made_of_the_nodes_of_graphs() -> None:
    """The operations, numbers and names are those that a kernel has; only operands are nodes."""
    graph = Graph()
    x = graph.input("x", 0)
    node = graph.nodes[graph.div(graph.sin(x), graph.const(3))]
    formula = parse_expression("sin(x)/3", ("x",))
    assert isinstance(formula, OperationNode) and formula.op is node.op
    inner = [graph.nodes[arg] for arg in node.args]
    assert [part.op for part in formula.args] == [part.op for part in inner]
    assert formula.args[1].value == inner[1].value == 3
    assert formula.args[0].args[0].symbol == graph.nodes[x].symbol


def test_a_formula_is_evaluated_over_whatever_its_leaves_are() -> None:
    def text(op: Op, args: Sequence[str]) -> str:
        return f"{op.value}({', '.join(args)})"

    formula = parse_expression("max(t, x) - t", ("t", "x"))
    found = evaluated(formula, str, {"t": "t", "x": "x"}, text)
    assert found == "add(max(t, x), neg(t))"
