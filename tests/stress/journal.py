"""Journals of long runs and templates of their pages, of the stress suite and the benchmarks."""

from __future__ import annotations

import hashlib
import json
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import jinja2

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

ROOT = Path(__file__).parents[2]
#: What the environment may say of a switch.
ON, OFF = {"1", "yes", "true", "on"}, {"", "0", "no", "false", "off"}


def digest_of(run: object, folders: Iterable[str], counts: Callable[[Path], bool]) -> str:
    """Digest of a run's options and sources."""
    digest = hashlib.sha256(repr(run).encode())
    for folder in folders:
        for path in sorted(Path(ROOT, folder).rglob("*")):
            if path.is_file() and counts(path):
                digest.update(path.relative_to(ROOT).as_posix().encode())
                digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def is_on(name: str) -> bool:
    """Whether the environment turns a switch on, as ``make bench FULL=1`` does.

    Raises
    ------
    ValueError
        It is neither on nor off.
    """
    word = os.environ.get(name, "").strip().lower()
    if word in ON or word in OFF:
        return word in ON
    raise ValueError(f"{name} is {word!r}, and neither 1 nor 0")


def done_in(journal: Path) -> Iterator[dict[str, Any]]:
    """Records of a journal; a line that was cut, or is none of a journal, is left out."""
    for line in journal.read_bytes().splitlines() if journal.exists() else ():
        try:
            done = json.loads(line)
        except ValueError:
            continue
        if isinstance(done, dict):
            yield done


def page_in(folder: Path) -> jinja2.Template:
    """Template of the page that lies in a folder: Markdown."""
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(folder),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        autoescape=False,  # Markdown
    )
    return environment.get_template("page.md.jinja")
