"""Errors in the words of the command line: options where Python has arguments."""

from __future__ import annotations

import re
from difflib import get_close_matches
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from typer import BadParameter

#: Options of arguments whose names are not those of their options.
FLAGS = {"parameters": "--set"}


def flag(match: re.Match[str]) -> str:
    """Option of an argument that a pattern found."""
    name = match[1]
    return FLAGS.get(name, f"--{name.replace('_', '-')}")


#: Nouns for texts that the library of the command line cannot read, by its errors.
NUMBERS = {"float_parsing": "number", "int_parsing": "whole number"}

#: Words of messages to users of Python, and those of the command line.
WORDS = (
    (r"simulate wants a last time in seconds, as in simulate\(2\), or times",
     "a last time is wanted: --end SECONDS"),
    (r": simulate\(end\)$", ": kousoku simulate"),
    (r'; load\(\.\.\., outputs=\[\.\.\., ("\w+")\]\)', r"; the scene wants outputs = [..., \1]"),
    (r", whose options are \w+ and \w+$", ""),
    (r"\b(\w+)(?= is an option of)", flag),
    (r"(?<![\w.'-])(most_steps|largest_step|estimate_error)(?!\w)", flag),
)  # fmt: skip


def as_typed(text: str) -> str:
    """Message with options as they are typed: ``--most-steps`` for ``most_steps``."""
    for pattern, words in WORDS:
        text = re.sub(pattern, words, text)
    return text


def refused(error: BadParameter) -> str:
    """Problem of an argument in words of the command line, not of its library.

    An error of which the library keeps no details, as older ones do, keeps its words.
    """
    details = getattr(error.__cause__, "errors", None)
    first = details()[0] if details else {}
    text, number = repr(first.get("input")), NUMBERS.get(first.get("type", ""))
    if number:
        return f"{text} is no {number}."
    if first.get("type") == "greater_than_equal":
        return f"{text}; wanted at least {first['ctx']['ge']}."
    message = error.message.removeprefix("Value error, ")
    choices = re.findall("'(.+?)'", message.partition(" is not one of ")[2])
    near = get_close_matches(str(first.get("input")), choices, n=1)
    return f"{message} Did you mean {near[0]!r}?" if near else message
