"""Progress of long computations, on a terminal and in a notebook, silently elsewhere."""

from __future__ import annotations

import sys
from contextlib import contextmanager
from html import escape
from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator


def is_watched() -> bool:
    """Whether somebody watches: standard error is a terminal, or a notebook."""
    return _is_notebook() or (sys.stderr is not None and sys.stderr.isatty())


def _is_notebook() -> bool:
    shell = sys.modules.get("IPython")
    return shell is not None and "ZMQ" in type(shell.get_ipython()).__name__


@contextmanager
def status_line() -> Iterator[Callable[[str], object]]:
    """Display of a line, such as ``generating loop``, until the next one or the end."""
    if not is_watched():
        yield lambda text: None
        return
    if _is_notebook():
        with _shown_in_a_cell() as show:
            yield show
        return
    from rich.console import Console

    console = Console(stderr=True)
    with console.status("") as status:
        yield status.update


@contextmanager
def _shown_in_a_cell() -> Iterator[Callable[[str], object]]:
    """Display of a line below a cell, taken away at the end.

    Rich wants widgets there, and what is written to standard error stays, on red ground, in
    notebooks that are saved.
    """
    display = import_module("IPython.display").display
    shown: list[Any] = []

    def show(text: str) -> None:
        line = f"<pre>{escape(text)}</pre>" if text else ""
        data = {"text/plain": text, "text/html": line}
        if shown:
            shown[0].update(data, raw=True)
        else:
            shown.append(display(data, raw=True, display_id=True))

    try:
        yield show
    finally:
        if shown:
            show("")
