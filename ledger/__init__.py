"""The ledger: every equation of the documents, as printed, as it should read, and proved.

The entries are data, ``documents/*.toml``. Listing them runs no proof; :func:`prove` runs that of
one entry.
"""

from __future__ import annotations

from difflib import get_close_matches
from functools import cache
from typing import TYPE_CHECKING

from kousoku.model.errors import LedgerError

if TYPE_CHECKING:
    from kousoku.ledger.entry import Entry
    from kousoku.ledger.proof import Proof

__all__ = ["entries", "find", "keys", "prove"]


@cache
def entries() -> tuple[Entry, ...]:
    """Entries of all documents, one after the other, in the order of reading."""
    from kousoku.ledger.documents import (
        lecture_7_1,
        lecture_8_2,
        link_element,
        link_examples,
        link_method,
        mass_points,
    )
    from kousoku.ledger.reading import read

    modules = (lecture_7_1, lecture_8_2, link_element, link_method, link_examples, mass_points)
    return tuple(entry for module in modules for entry in read(module))


@cache
def keys() -> dict[str, Entry]:
    """Entry of each key: the equation's number or slug, and its aliases.

    Raises
    ------
    LedgerError
        Two entries share a key.
    """
    by_key: dict[str, Entry] = {}
    for entry in entries():
        for key in (entry.equation, *entry.aliases):
            other = by_key.setdefault(key, entry)
            if other is not entry:
                titles = " and ".join(f"{e.document.title} ({e.equation})" for e in (other, entry))
                raise LedgerError(f"{titles} share the key {key!r}; give one of them another")
    return by_key


def find(key: str) -> Entry:
    """Entry of a key, e.g. ``8.11``, ``(15)`` or ``cross-identity``.

    Raises
    ------
    LedgerError
        There is none; the message names keys that are near.
    """
    plain = str(key).strip().removeprefix("(").removesuffix(")")
    by_key = keys()
    if plain in by_key:
        return by_key[plain]
    near = get_close_matches(plain, by_key, n=6, cutoff=0.5)
    hint = f"near it are {', '.join(near)}" if near else "kousoku ledger lists them"
    raise LedgerError(f"no equation {key!r} in the ledger; {hint}")


def prove(entry: Entry) -> Proof:
    """Run the proof of an entry.

    Raises
    ------
    LedgerError
        Something is not as the entry claims; the message names the entry and the statement.
    """
    from kousoku.ledger import proof

    return proof.prove(entry)
