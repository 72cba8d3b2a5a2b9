"""Journals of long runs and templates of their pages, of the stress suite and the benchmarks."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import jinja2

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

ROOT = Path(__file__).parents[2]


def digest_of(run: object, folders: Iterable[str], counts: Callable[[Path], bool]) -> str:
    """Digest of a run's options and sources."""
    digest = hashlib.sha256(repr(run).encode())
    for folder in folders:
        for path in sorted(Path(ROOT, folder).rglob("*")):
            if path.is_file() and counts(path):
                digest.update(path.relative_to(ROOT).as_posix().encode())
                digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def done_in(journal: Path) -> Iterator[dict[str, Any]]:
    """Records of a journal; a line that was cut is left out."""
    for line in journal.read_text(encoding="utf-8").splitlines() if journal.exists() else ():
        try:
            yield json.loads(line)
        except ValueError:
            continue


def page_in(folder: Path) -> jinja2.Template:
    """Template of the page that lies in a folder: Markdown."""
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(folder),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        autoescape=False,  # Markdown
    )
    return environment.get_template("page.md.jinja")
