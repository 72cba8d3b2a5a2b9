"""Text for people: tables with aligned columns, counts."""

from __future__ import annotations

from difflib import get_close_matches
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

#: Names with which an unknown one is compared: it takes a millisecond for a hundred of them.
MOST_COMPARED = 1000


def table(
    columns: Sequence[str],
    rows: Sequence[Sequence[str]],
    *,
    title: str = "",
    numbers: bool = False,
) -> str:
    """Table as lines, the same on a terminal and in a pipe; numbers stand to the right."""
    all_rows = [columns, *rows]
    widths = [max(len(row[k]) for row in all_rows) for k in range(len(columns))]
    lines = [title] if title else []
    for row in all_rows:
        cells = [
            cell.rjust(width) if numbers else cell.ljust(width)
            for cell, width in zip(row, widths, strict=True)
        ]
        lines.append("  ".join(cells).rstrip())
    return "\n".join(lines)


def counted(count: int, name: str, plural: str = "") -> str:
    """Count with its noun: ``1 body``, ``2 bodies``."""
    return f"{count} {name if count == 1 else plural or name + 's'}"


def with_a(noun: str) -> str:
    """Noun with its article: ``a hinge``, ``an edge``, ``a universal``."""
    return f"{'an' if noun[:1] in 'aeiou' and not noun.startswith('uni') else 'a'} {noun}"


def in_words(names: Sequence[str], last: str = "and") -> str:
    """Names as a list in words: ``a``, ``a and b``, ``a, b and c``."""
    *most, end = names
    return f"{', '.join(most)} {last} {end}" if most else end


def plain_name(name: object) -> str:
    """Name as names are compared: without case, blanks, hyphens and underscores."""
    return "".join(c for c in str(name).lower() if c not in " -_")


def nearest(name: object, known: Iterable[str]) -> str:
    """Known name that resembles ``name`` most; empty where none does, or too many are known."""
    names = list(known)
    if len(names) > MOST_COMPARED:
        return ""
    return next(iter(get_close_matches(str(name)[:80], names, n=1)), "")


def near_name(name: object, known: Iterable[str]) -> str:
    """End of a message that asks for the known name nearest to one, or nothing."""
    near = nearest(name, known)
    return f"; did you mean {near!r}?" if near else ""
