"""The glossary: each term has its equation, and equations that are cited are in the ledger."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import kousoku as ks

PAGE = Path(__file__).parents[2] / "docs" / "glossary.md"
ROWS = [
    [cell.strip() for cell in line.strip("|").split("|")]
    for line in PAGE.read_text(encoding="utf-8").splitlines()
    if line.startswith("| ") and not line.startswith("| symbol")
]
#: A key in parentheses, alone or behind the title of its document.
CITED = re.compile(r"(?:[^()*_=]*, )?\(([0-9.]+|[a-z][\w-]*-?\w+)\)(?:, \(([0-9.]+)\))?")


def test_every_term_has_five_cells_and_an_equation() -> None:
    assert len(ROWS) > 70
    for row in ROWS:
        assert len(row) == 5 and all(row[1:4]), row


def test_what_is_cited_is_in_the_ledger() -> None:
    cited = [key for row in ROWS if (found := CITED.fullmatch(row[1])) for key in found.groups()]
    keys = [key for key in cited if key]
    assert len(keys) > 50
    for key in keys:
        ks.ledger.find(key)
    with pytest.raises(ks.KousokuError):
        ks.ledger.find("no-such-key")
