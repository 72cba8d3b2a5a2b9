"""Say something to the user once: through `logging`, so that a program can route or silence it."""

from __future__ import annotations

from contextlib import contextmanager
from contextvars import ContextVar
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator

_said: set[str] = set()
_is_silent = ContextVar("_is_silent", default=False)


@contextmanager
def silent() -> Iterator[None]:
    """Suppress notices in this thread: solvers that are loaded are compared, and do not move."""
    token = _is_silent.set(True)
    try:
        yield
    finally:
        _is_silent.reset(token)


def say_once(message: str) -> None:
    """Log a warning to the logger ``kousoku``, at most once a process.

    Without any logging set up, Python prints such a message as it is on stderr. It is not a
    warning of the `warnings` module, because a missing compiler is a condition of the machine and
    must not fail a program that turns warnings into errors.
    """
    if message not in _said and not _is_silent.get():
        _said.add(message)
        import logging

        logging.getLogger("kousoku").warning("%s", message)
