"""Checks that the entries which are still Python are made of."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.ledger.entry import Check
from kousoku.ledger.proof import difference, equality, value_of
from kousoku.model.errors import FormulaError, LedgerError

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.ledger.vocabulary import Value, Vocabulary


def equal(
    statement: str,
    vocabulary: Callable[[], Vocabulary],
    left: str | Callable[[], Value],
    right: str | Callable[[], Value],
) -> Check:
    """Return the check that two values are equal; a text is read as a formula."""

    def run() -> str:
        words = vocabulary()
        return equality(words, *(_valued(words, side) for side in (left, right)))

    return Check(statement, run)


def different(
    statement: str,
    vocabulary: Callable[[], Vocabulary],
    left: str | Callable[[], Value],
    right: str | Callable[[], Value],
) -> Check:
    """Return the check that two values differ somewhere, or cannot be compared."""

    def run() -> str:
        words = vocabulary()
        try:
            witness = difference(words, *(_valued(words, side) for side in (left, right)))
        except FormulaError as problem:
            return f"cannot be formed: {problem}"
        if not witness:
            raise LedgerError("no difference is seen")
        return witness

    return Check(statement, run)


def _valued(vocabulary: Vocabulary, side: str | Callable[[], Value]) -> Value:
    return value_of(side, vocabulary) if isinstance(side, str) else side()
