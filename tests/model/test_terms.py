"""Formulas as terms: what is equal, and what operators make of them."""

from __future__ import annotations

import pickle
from fractions import Fraction
from typing import TYPE_CHECKING

from kousoku.model.expression import parse_expression
from kousoku.model.graph import Op
from kousoku.model.terms import Apply, Name, Number, add, evaluated

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.model.terms import Expression

T, X = Name("t"), Name("x")


def doubled(times: int) -> Expression:
    """Return 2ⁿ t as sums of two equal parts, which are shared."""
    term: Expression = Name("t")
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
    a, b, one = Name("a"), Name("b"), Number(Fraction(1))
    formulas = [
        *(a, Name("number"), Name("1"), one, Number(Fraction(1, 11)), Number(Fraction(11, 1))),
        *(Apply(Op.ADD, (a, b)), Apply(Op.ADD, (b, a)), Apply(Op.MUL, (a, b))),
        *(
            Apply(Op.ADD, (a, b, one)),
            Apply(Op.ADD, (Apply(Op.ADD, (a, b)), one)),
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


def test_a_formula_is_evaluated_over_whatever_its_leaves_are() -> None:
    def text(op: Op, args: Sequence[str]) -> str:
        return f"{op.value}({', '.join(args)})"

    formula = parse_expression("max(t, x) - t", ("t", "x"))
    found = evaluated(formula, lambda leaf: leaf.name if isinstance(leaf, Name) else "?", text)
    assert found == "add(max(t, x), neg(t))"
