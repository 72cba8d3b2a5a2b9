"""Every statement of the documents is proved, and the committed pages show these proofs."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from kousoku.ledger import entries, find, prove
from kousoku.ledger.page import latex_page, markdown_page
from kousoku.ledger.printing import count_lines

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.ledger.entry import Entry
    from kousoku.ledger.proof import Proof

DOCS = Path(__file__).parents[2] / "docs"
#: Every tenth entry is proved with all other tests, and every one for a release.
MARKED = [
    entry if place % 10 == 0 else pytest.param(entry, marks=pytest.mark.release)
    for place, entry in enumerate(entries())
]


@cache
def proved(equation: str) -> Proof:
    """Proof of an entry, once for all tests."""
    return prove(find(equation))


@pytest.mark.parametrize("entry", MARKED, ids=lambda entry: entry.equation)
def test_the_proof_of_an_entry_runs(entry: Entry) -> None:
    lines = proved(entry.equation).lines
    assert lines
    assert all(line.statement and line.result for line in lines)


@pytest.mark.release
@pytest.mark.parametrize(
    ("name", "page"), [("ledger.tex", latex_page), ("ledger.md", markdown_page)]
)
def test_the_committed_pages_are_up_to_date(name: str, page: Callable[..., str]) -> None:
    option = "--latex" if name == "ledger.tex" else "--markdown"
    committed = (DOCS / name).read_text(encoding="utf-8")
    proofs = {entry.equation: proved(entry.equation) for entry in entries()}
    assert committed == page(entries(), proofs), f"run kousoku ledger {option} > docs/{name}"


def test_the_count_of_each_verdict_is_as_committed(golden: Callable[[str], None]) -> None:
    golden("\n".join([*count_lines(entries()), ""]))


@pytest.mark.parametrize("entry", entries(), ids=lambda entry: entry.equation)
def test_an_entry_that_corrects_gives_a_reason(entry: Entry) -> None:
    assert bool(entry.corrected) == (entry.verdict != "holds")
    assert entry.reason or not entry.corrected
