"""Problems of texts that are no TOML, in other words where those of the parser do not help."""

from __future__ import annotations

import re

from kousoku.model.errors import Problem
from kousoku.model.reading.lines import twice_given
from kousoku.model.records.dotted_keys import dotted

LONGEST_SHOWN_VALUE = 60
"""Marks of a value that a message shows."""

_AT = re.compile(r"\(at line ([0-9]+), column ([0-9]+)\)")
_DUPLICATES = ("Cannot overwrite", "Cannot declare", "Cannot mutate", "Duplicate inline table key")
_VALUE = re.compile(r"[^,\]}#]*")
_BARE = re.compile(r"[-+]?\.[0-9]+([eE][-+]?[0-9]+)?")
_FORMULA = re.compile(r"[-+(A-Za-z0-9_.][-+*/^().A-Za-z0-9_ ]*")


def toml_problem(error: ValueError, text: str) -> Problem:
    """Problem that a parser found in a scene file, with its line and, where known, the correction.

    Parameters
    ----------
    error : ValueError
        The error of the parser.
    text : str
        The file.
    """
    message = str(error)
    position = _AT.search(message)
    if position is None:  # at the end of the file
        return Problem(f"is not valid TOML: {message}")
    line, column = int(position[1]), int(position[2])
    if message.startswith(_DUPLICATES) and (twice := twice_given(text)) is not None:
        path, first, second = twice
        where = "twice in this line" if first == second else f"in line {first}, too"
        return Problem(f"stands {where}; give each key once", dotted(path), second)
    hint = _value_hint(text.splitlines()[line - 1] if line <= text.count("\n") + 1 else "", column)
    return Problem(f"is not valid TOML: {message}{hint}", line=line)


def _value_hint(line: str, column: int) -> str:
    """Correction of the value around a column, where it is a text without quotes."""
    before = line[: column - 1]
    start = max(before.rfind(mark) for mark in "=[,") + 1
    if not start:
        return ""
    match = _VALUE.match(line, start)
    value = match.group().strip() if match else ""
    if _BARE.fullmatch(value):
        return f"; write {value.replace('.', '0.', 1)}: a number has a digit before its point"
    if value.lower() in {"true", "false"}:
        return f"; wanted {value.lower()}, in small letters"
    if not _FORMULA.fullmatch(value) or not re.search("[A-Za-z*/^(]", value):
        return ""
    shown = value if len(value) <= LONGEST_SHOWN_VALUE else f"{value[:LONGEST_SHOWN_VALUE]}…"
    return f'; a formula, and a name, stands in quotes: "{shown}"'
