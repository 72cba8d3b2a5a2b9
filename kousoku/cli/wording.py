"""What went wrong, in the words of the command line: options where Python has arguments."""

from __future__ import annotations

import re

#: What an argument of the door is called here, where that is not its own name.
FLAGS = {"parameters": "--set"}


def flag(match: re.Match[str]) -> str:
    """Return the option of an argument that a pattern found."""
    name = match[1]
    return FLAGS.get(name, f"--{name.replace('_', '-')}")


#: Words of messages for who writes Python, and what stands for them.
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
    """Return a message with options as they are typed: ``--most-steps`` for ``most_steps``."""
    for pattern, words in WORDS:
        text = re.sub(pattern, words, text)
    return text
