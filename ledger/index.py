"""The index of all statements: document, key, and a digest of the printed text.

It is the repository's own list of what the documents display, apart from the entries, so that an
entry that is lost or a printed form that is edited shows. ``python -m kousoku.ledger.index`` writes
it anew from the entries.
"""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.ledger.entry import Entry

PATH = Path(__file__).with_name("index.json")


def normalised(text: str) -> str:
    """Text with every run of white space as one space."""
    return " ".join(text.split())


def digest(printed: str) -> str:
    """SHA-256 of a printed text, whatever its line breaks and indentation."""
    return hashlib.sha256(normalised(printed).encode()).hexdigest()


def index_of(entries: Sequence[Entry]) -> list[dict[str, str]]:
    """Index of entries, in their order."""
    return [
        {"document": e.document.file, "equation": e.equation, "digest": digest(e.printed)}
        for e in entries
    ]


def print_index(index: Sequence[dict[str, str]]) -> str:
    """Index as its file holds it: one statement on each line."""
    lines = ",\n".join(f" {json.dumps(row, ensure_ascii=False)}" for row in index)
    return f"[\n{lines}\n]\n"


def main() -> None:
    """Write the index anew from the entries."""
    from kousoku.ledger import entries

    PATH.write_text(print_index(index_of(entries())), encoding="utf-8", newline="\n")


if __name__ == "__main__":
    main()
