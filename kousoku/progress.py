"""What takes long is told while it lasts: on a terminal and in a notebook, silently elsewhere."""

from __future__ import annotations

import sys
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

#: Characters of a line in a notebook, which the next one covers.
WIDTH = 72


def is_watched() -> bool:
    """Return whether somebody sees what is shown: standard error is a terminal, or a notebook."""
    shell = sys.modules.get("IPython")
    if shell is not None and "ZMQ" in type(shell.get_ipython()).__name__:
        return True
    return sys.stderr is not None and sys.stderr.isatty()


@contextmanager
def told() -> Iterator[Callable[[str], object]]:
    """Give what shows a line, such as ``generating loop``, until the next one or the end."""
    if not is_watched():
        yield lambda text: None
        return
    if not sys.stderr.isatty():  # a notebook, where rich wants widgets and leaves empty outputs
        try:
            yield lambda text: sys.stderr.write(f"\r{text:<{WIDTH}}")
        finally:
            sys.stderr.write(f"\r{'':<{WIDTH}}\r")
        return
    from rich.console import Console

    console = Console(stderr=True)
    with console.status("") as status:
        yield status.update
