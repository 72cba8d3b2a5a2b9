"""Every statement of the documents is proved, and so many hold, lost notation, are misprinted."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from kousoku.ledger import entries, prove
from kousoku.ledger.printing import count_lines

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.ledger.entry import Entry


#: Every tenth entry is proved with all other tests, and every one for a release.
MARKED = [
    entry if place % 10 == 0 else pytest.param(entry, marks=pytest.mark.release)
    for place, entry in enumerate(entries())
]


@pytest.mark.parametrize("entry", MARKED, ids=lambda entry: entry.equation)
def test_the_proof_of_an_entry_runs(entry: Entry) -> None:
    lines = prove(entry).lines
    assert lines
    assert all(line.statement and line.result for line in lines)


def test_the_count_of_each_verdict_is_as_committed(golden: Callable[[str], None]) -> None:
    golden("\n".join([*count_lines(entries()), ""]))


@pytest.mark.parametrize("entry", entries(), ids=lambda entry: entry.equation)
def test_an_entry_that_corrects_gives_a_reason(entry: Entry) -> None:
    assert bool(entry.corrected) == (entry.verdict != "holds")
    assert entry.reason or not entry.corrected
