"""Say something to the user once: through `logging`, so that a program can route or silence it."""

from __future__ import annotations

_said: set[str] = set()


def say_once(message: str) -> None:
    """Log a warning to the logger ``kousoku``, at most once a process.

    Without any logging set up, Python prints such a message as it is on stderr. It is not a
    warning of the `warnings` module, because a missing compiler is a condition of the machine and
    must not fail a program that turns warnings into errors.
    """
    if message not in _said:
        _said.add(message)
        import logging

        logging.getLogger("kousoku").warning("%s", message)
