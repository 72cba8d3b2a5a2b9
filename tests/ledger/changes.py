"""Mistakes in formulas, each of which a proof has to see."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable

    from kousoku.ledger.entry import Entry


def forms_near(form: str, changes: Iterable[tuple[str, str]], start: int = 0) -> list[str]:
    """Formula with one thing in it changed, in all ways and places from ``start`` on."""
    return [
        form[:place] + new + form[place + len(old) :]
        for old, new in changes
        for place in range(start, len(form))
        if form.startswith(old, place)
    ]


def with_form(entry: Entry, text: str) -> Entry:
    """Entry whose true form is another one."""
    return replace(entry, corrected=text) if entry.corrected else replace(entry, printed=text)
