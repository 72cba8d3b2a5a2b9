"""Completion in the shell, after a command: names of files that it takes."""

from collections.abc import Callable
from pathlib import Path


def files(*suffixes: str) -> Callable[[str], list[str]]:
    """Completions of folders and files with such suffixes; a folder alone is looked into."""

    def completed(incomplete: str) -> list[str]:
        folder, _, start = incomplete.rpartition("/")
        head = incomplete[: len(incomplete) - len(start)]
        try:
            paths = sorted((Path(folder) if folder else Path(head or ".")).iterdir())
        except OSError:
            return []
        matches = [path for path in paths if path.name.startswith(start)]
        matches = [path for path in matches if start or not path.name.startswith(".")]
        names = [
            f"{head}{path.name}{'/' if path.is_dir() else ''}"
            for path in matches
            if path.is_dir() or path.suffix in suffixes
        ]
        return completed(names[0]) if len(names) == 1 and names[0].endswith("/") else names

    return completed
