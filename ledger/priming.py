"""Whether lost primes alone explain a printed formula: all ways to put them back are tried."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from typing import TYPE_CHECKING

from kousoku.ledger.entry import Check
from kousoku.ledger.formula import (
    Array,
    Call,
    Cross,
    Name,
    Node,
    Number,
    Power,
    Product,
    Quotient,
    Sum,
    Tilde,
    Transposed,
)
from kousoku.ledger.parser import parse
from kousoku.ledger.proof import point
from kousoku.model.errors import LedgerError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from kousoku.ledger.vocabulary import Vocabulary


def readings(node: Node, ways: Callable[[Name], tuple[Name, ...]]) -> Iterator[Node]:
    """Yield a formula with its symbols read in all combinations of ways."""
    match node:
        case Name():
            yield from ways(node)
        case Number():
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
        case Cross() | Quotient() | Power() | Call() | Array():
            raise LedgerError(f"primes are not looked for in {type(node).__name__}")


def only_with(
    count: int,
    printed: str,
    side: int,
    vocabulary: Callable[[], Vocabulary],
    ways: Callable[[Name], tuple[Name, ...]],
) -> Check:
    """Return the check of how many of all ways to put primes make a side equal to the first.

    They are compared at one rational point: a way that fails there fails; the one that is left is
    proved by the entry.

    Parameters
    ----------
    count : int
        How many should be left: 0 where primes explain nothing, 1 where they explain all.
    printed : str
        The formula: one chain.
    side : int
        Which side, 1 being the one behind the first relation.
    vocabulary, ways : callable
        What symbols mean, and how a printed one may be read.
    """

    def run() -> str:
        words = vocabulary()
        ring = words.ring(at=point(words))
        (statement,) = parse(printed)
        wanted = ring.cells(words.value(statement.sides[0]))
        tried = [ring.cells(words.value(x)) for x in readings(statement.sides[side], ways)]
        equal = sum(
            all(ring.is_equal(a, b) for a, b in zip(cells, wanted, strict=True)) for cells in tried
        )
        if equal != count:
            raise LedgerError(f"{equal} of {len(tried)} ways to put primes agree, not {count}")
        return f"{count or 'none'} of {len(tried)} agrees"

    return Check(f"side {side + 1} with primes put back in every possible way", run)
