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

    from kousoku.ledger.registry import Evidence, Names


def read(part: ModuleType) -> tuple[Entry, ...]:
    """Entries of the TOML file that stands beside a module, with its names.

    Raises
    ------
    LedgerError
        The file cannot be read, or an entry has a key, a name or an argument that there is not.
    """
    path = Path(str(part.__file__)).with_suffix(".toml")
    try:
        data = _joined(tomllib.loads(path.read_text(encoding="utf-8")))
    except tomllib.TOMLDecodeError as problem:
        raise LedgerError(f"{path.name}: {problem}") from None
    (document,) = (d for d in DOCUMENTS if d.title == data["document"])
    return tuple(entry_of(table, document, part.NAMES, data["words"]) for table in data["entry"])


def _joined(data: Any) -> Any:
    """Data with the lines of its texts joined where they go on."""
    match data:
        case str():
            return re.sub(r"\n +", " ", data).strip(" ")
        case list():
            return [_joined(item) for item in data]
        case dict():
            return {key: _joined(value) for key, value in data.items()}
    return data


def entry_of(table: dict[str, Any], document: Document, names: Names, words: str) -> Entry:
    """Entry that a table of the file says.

    Parameters
    ----------
    table : dict
        The fields of :class:`Entry` by their names. One that has ``words`` is a formula, which is
        read with them; one that has none is a sentence.
    document : Document
        Where it stands.
    names : Names
        The words and proofs that it may name.
    words : str
        The words of the proofs of a sentence.
    """
    fields = dict(table)
    key = fields.get("equation", "an entry without an equation")
    try:
        entry_words = fields.pop("words", "")
        vocabulary = names.vocabulary(entry_words) if entry_words else None
        tables = {kind: fields.pop(kind, []) for kind in ("refutation", "checks")}
        fields["aliases"] = tuple(fields.get("aliases", ()))
        entry = Entry(document, **fields, vocabulary=vocabulary, is_sentence=vocabulary is None)
        if entry.verdict not in get_args(Verdict):
            raise LedgerError(f"no verdict {entry.verdict!r}")
        refutation, checks = (
            tuple(_check(check, entry, names, entry_words or words) for check in tables[kind])
            for kind in ("refutation", "checks")
        )
        return replace(entry, refutation=refutation, checks=checks)
    except (TypeError, LedgerError) as problem:
        raise LedgerError(f"{key} ({document.title}): {problem}") from None


def _check(table: dict[str, Any], entry: Entry, names: Names, words: str) -> Check:
    """Check that a table says: the proof that it names, with its arguments.

    ``words`` are by default the entry's. So is the ``formula``, in the form that is true, or as
    ``of`` says; ``side`` means one side of it.
    """
    arguments = dict(table)
    method = names.method(arguments.pop("proof", ""))
    statement = arguments.pop("statement", "")
    parameters = signature(method.function)
    if "words" in parameters.parameters:
        arguments["words"] = names.vocabulary(arguments.get("words", words))
    if "formula" in parameters.parameters and "formula" not in arguments:
        form = _form(entry, arguments.pop("of", ""))
        is_whole = "side" in parameters.parameters or "side" not in arguments
        arguments["formula"] = form if is_whole else Side(form, arguments.pop("side"))
    parameters.bind(**arguments)
    statement = statement or method.statement.format(**arguments)
    if not statement:
        raise LedgerError(f"the proof {table['proof']!r} has no statement")
    return Check(statement, partial(_seen, method.function, arguments))


def _form(entry: Entry, name: str) -> str:
    forms = {"": entry.true_form, "printed": entry.printed, "corrected": entry.corrected}
    if not forms.get(name):
        raise LedgerError(f"the entry has no form {name!r}")
    return forms[name]


def _seen(function: Callable[..., Evidence], arguments: Mapping[str, Any]) -> str:
    """Run a proof, and return its findings; of statements all must be true."""
    findings = function(**arguments)
    if isinstance(findings, str):
        return findings
    false = [statement for statement, is_true in findings.items() if not is_true]
    if false:
        raise LedgerError(f"it is not true that {', '.join(false)}")
    return "; ".join(findings)
