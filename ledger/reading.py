"""The entries of a part: its TOML file, read with the names that its module gives.

A text of the file may go on in the next line, indented: the break then counts as one blank, as it
does in LaTeX.
"""

from __future__ import annotations

import re
import tomllib
from dataclasses import replace
from functools import partial
from inspect import signature
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args

from kousoku.ledger.entry import DOCUMENTS, Check, Document, Entry, Verdict
from kousoku.ledger.proof import Side
from kousoku.model.errors import LedgerError

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from types import ModuleType

    from kousoku.ledger.names import Names, Seen


def read(part: ModuleType) -> tuple[Entry, ...]:
    """Return the entries of the TOML file that stands beside a module, with its names.

    Raises
    ------
    LedgerError
        An entry has a key, a name or an argument that there is not; the message names it.
    """
    path = Path(str(part.__file__)).with_suffix(".toml")
    data = _joined(tomllib.loads(path.read_text(encoding="utf-8")))
    (document,) = (d for d in DOCUMENTS if d.title == data["document"])
    return tuple(_entry(table, document, part.NAMES, data["words"]) for table in data["entry"])


def _joined(data: Any) -> Any:
    """Return data with the lines of its texts joined where they go on."""
    match data:
        case str():
            return re.sub(r"\n +", " ", data).strip(" ")
        case list():
            return [_joined(item) for item in data]
        case dict():
            return {key: _joined(value) for key, value in data.items()}
    return data


def _entry(table: dict[str, Any], document: Document, names: Names, words: str) -> Entry:
    """Return an entry; the words of its proofs are its own, or those that ``words`` names."""
    try:
        if table["verdict"] not in get_args(Verdict):
            raise LedgerError(f"no verdict {table['verdict']!r}")
        own = table.pop("words", "")
        refutation, checks = (table.pop(kind, []) for kind in ("refutation", "checks"))
        table["aliases"] = tuple(table.get("aliases", ()))
        read = names.vocabulary(own) if own else None
        entry = Entry(document, **table, vocabulary=read, is_sentence=read is None)
        check = partial(_check, entry=entry, names=names, words=own or words)
        return replace(
            entry, refutation=tuple(map(check, refutation)), checks=tuple(map(check, checks))
        )
    except (KeyError, TypeError, LedgerError) as problem:
        key = table.get("equation", "an entry without an equation")
        raise LedgerError(f"{key} ({document.title}): {problem}") from None


def _check(table: dict[str, Any], entry: Entry, names: Names, words: str) -> Check:
    """Return a check: the proof that is named, with its arguments.

    ``words`` are by default the entry's. So is the ``formula``: as it is true, or as ``of`` says;
    ``side`` means one side of it.
    """
    method = names.method(table.pop("proof"))
    statement = table.pop("statement", "") or method.statement.format(**table)
    form = {"printed": entry.printed, "": entry.true_form}[table.pop("of", "")]
    wanted = signature(method.function)
    if "words" in wanted.parameters:
        table["words"] = names.vocabulary(table.get("words", words))
    if "formula" in wanted.parameters and "formula" not in table:
        is_whole = "side" in wanted.parameters or "side" not in table
        table["formula"] = form if is_whole else Side(form, table.pop("side"))
    wanted.bind(**table)
    return Check(statement, partial(_seen, method.function, table))


def _seen(function: Callable[..., Seen], arguments: Mapping[str, Any]) -> str:
    """Run a proof, and return what it saw; of statements all must be true."""
    seen = function(**arguments)
    if isinstance(seen, str):
        return seen
    wrong = [statement for statement, is_true in seen.items() if not is_true]
    if wrong:
        raise LedgerError(f"it is not true that {', '.join(wrong)}")
    return "; ".join(seen)
