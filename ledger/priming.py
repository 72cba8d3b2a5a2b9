"""Whether lost primes alone explain a printed formula: all ways to put them back are tried."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from typing import TYPE_CHECKING

from kousoku.ledger.formula import (
    Array,
    Cross,
    Division,
    FormulaNode,
    FunctionCall,
    Numeral,
    Power,
    Product,
    Sum,
    SymbolName,
    Tilde,
    Transposed,
)
from kousoku.model.errors import LedgerError
from kousoku.symbolic.prove import rational_point

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from kousoku.ledger.formula import Statement
    from kousoku.ledger.vocabulary import Vocabulary


def readings(
    node: FormulaNode, ways: Callable[[SymbolName], tuple[SymbolName, ...]]
) -> Iterator[FormulaNode]:
    """Formula with its symbols read in all combinations of ways."""
    match node:
        case SymbolName():
            yield from ways(node)
        case Numeral():
            yield node
        case Sum():
            signs = [sign for sign, _ in node.terms]
            for terms in product(*(list(readings(term, ways)) for _, term in node.terms)):
                yield Sum(tuple(zip(signs, terms, strict=True)))
        case Product():
            for factors in product(*(list(readings(factor, ways)) for factor in node.factors)):
                yield Product(factors)
        case Transposed() | Tilde():
            for inner in readings(node.inner, ways):
                yield replace(node, inner=inner)
        case Cross() | Division() | Power() | FunctionCall() | Array():
            raise LedgerError(f"primes are not looked for in {type(node).__name__}")


def ways_that_agree(
    statement: Statement,
    side: int,
    vocabulary: Vocabulary,
    ways: Callable[[SymbolName], tuple[SymbolName, ...]],
) -> tuple[int, int]:
    """Number of ways to read a side that make it equal to the first, and of all ways.

    They are compared at one rational point: a way that fails there fails; the one that is left is
    proved by the entry.

    Parameters
    ----------
    statement : Statement
        One chain.
    side : int
        Which side, 0 being the first.
    vocabulary : Vocabulary
        Meanings of symbols.
    ways : callable
        How a printed one may be read.
    """
    ring = vocabulary.ring(at=rational_point(vocabulary.quantities))
    reference = ring.cells(vocabulary.value(statement.sides[0]))
    tried = [ring.cells(vocabulary.value(x)) for x in readings(statement.sides[side], ways)]
    equal = [
        cells
        for cells in tried
        if all(ring.is_equal(a, b) for a, b in zip(cells, reference, strict=True))
    ]
    return len(equal), len(tried)
