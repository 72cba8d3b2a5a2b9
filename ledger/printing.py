"""The ledger as a table, one entry as text, and entries as data for a program."""

from __future__ import annotations

import re
from collections import Counter
from typing import TYPE_CHECKING, Any, get_args

from kousoku.ledger.entry import DOCUMENTS, Verdict

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.ledger.entry import Document, Entry
    from kousoku.ledger.proof import Proof

VERDICTS: tuple[str, ...] = get_args(Verdict)
COLUMNS = ("document", "equation", "verdict", "begins")

#: What the first words of a formula leave out: fonts, alignment, environments, wide spaces.
_FONTS = re.compile(r"\\(?:mathbf|boldsymbol|mathrm|mathit)\{([^{}]*)\}")
_LAYOUT = re.compile(r"\\(?:begin|end)\{\w+\}(?:\{\w+\})?|\\(?:left|right|q?quad)\b|\\\\|&")


def row(entry: Entry) -> tuple[str, str, str, str]:
    """Row of an entry in the table, with its first words."""
    words = first_words(entry.printed, 56)
    return entry.document.title, entry.equation, entry.verdict, words


def first_words(printed: str, width: int) -> str:
    """Printed form on one line, its beginning, without fonts and layout."""
    plain = re.sub(r"([a-z])(?=\\(?:math|bold))", r"\1 ", printed)
    plain = _LAYOUT.sub(" ", _FONTS.sub(r"\1", plain))
    plain = " ".join(plain.split())
    return plain if len(plain) <= width else plain[: width - 1].rstrip() + "…"


def counts(entries: Sequence[Entry], document: Document | None = None) -> dict[str, int]:
    """Number of entries of each verdict, of one document or of all."""
    numbers: Counter[str] = Counter(e.verdict for e in entries if document in {None, e.document})
    return {verdict: numbers[verdict] for verdict in VERDICTS}


def count_lines(entries: Sequence[Entry]) -> list[str]:
    """Lines of counts: one for each document, and one for all."""
    lines = [_counted(document.title, counts(entries, document)) for document in DOCUMENTS]
    return [*lines, _counted("in all", counts(entries))]


def _counted(name: str, numbers: dict[str, int]) -> str:
    parts = ", ".join(f"{number} {verdict}" for verdict, number in numbers.items())
    return f"{name}: {sum(numbers.values())} entries, {parts}"


def as_text(entry: Entry, proof: Proof | None) -> str:
    """Entry, for a person to read, with its proof where that did not fail."""
    parts = [f"{cited(entry)}: {entry.verdict}", "", *_labelled("printed", entry.printed)]
    if entry.corrected:
        parts += _labelled("corrected", entry.corrected)
    if entry.reason:
        parts += _labelled("reason", entry.reason)
    if entry.aliases:
        parts += _labelled("also", ", ".join(entry.aliases))
    parts += ["", "proof"]
    for number, line in enumerate(proof.lines if proof else (), 1):
        parts += [f"  {number}. {line.statement}", f"     {line.result}"]
    return "\n".join([*parts, *(["  FAILED"] if proof is None else [])])


def cited(entry: Entry) -> str:
    """Citation of an entry, e.g. ``lecture 8.2, (8.11)``."""
    return f"{entry.document.title}, ({entry.equation})"


def _labelled(label: str, text: str) -> list[str]:
    lines = text.strip().splitlines()
    return [f"{label:<11}{lines[0]}", *(" " * 11 + line for line in lines[1:])]


def as_data(entry: Entry, proof: Proof | None) -> dict[str, Any]:
    """Entry for a program to read; its proof is empty where it failed."""
    return {
        "document": entry.document.file,
        "title": entry.document.title,
        "equation": entry.equation,
        "aliases": list(entry.aliases),
        "kind": "sentence" if entry.is_sentence else "equation",
        "verdict": entry.verdict,
        "printed": entry.printed,
        "corrected": entry.corrected,
        "reason": entry.reason,
        "proof": str(proof) if proof else "",
    }
