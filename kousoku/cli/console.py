"""Parts that commands share: where generated packages are found, tables, JSON, progress."""

import json
import sys
from collections.abc import Mapping, Sequence
from enum import StrEnum
from math import isfinite
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from kousoku.model.errors import DerivationError, LoadError
from kousoku.model.files.manifest import MANIFEST_FILE
from kousoku.model.text import table
from kousoku.symbolic import KINDS, packages_of

#: Number of the format of what ``--json`` prints, see :mod:`kousoku.cli.answers`.
ANSWER_FORMAT = 1
#: Exit codes: emitted code disagrees with what was derived; bad input; a motion that stopped, or
#: cannot be trusted; Ctrl-C; a reader that closed its pipe, as shells count what SIGPIPE ends.
DISAGREEMENT, BAD_INPUT, STOPPED, INTERRUPTED, UNREAD = 1, 2, 3, 130, 141


class TargetChoice(StrEnum):
    """Target that computes."""

    AUTO = "auto"
    C = "c"
    NUMPY = "numpy"


AsJson = Annotated[bool, typer.Option("--json", help="Print JSON, for a program to read.")]


def generated_folder() -> Path:
    """Folder of the generated packages that came with kousoku."""
    import kousoku.generated

    return Path(str(kousoku.generated.__file__)).resolve().parent  # past the links of a checkout


def checkout() -> Path | None:
    """Root of the checkout that kousoku runs from, None where it is installed."""
    root = generated_folder().parent
    return root if (root / "pyproject.toml").is_file() else None


def generated_packages() -> list[Path]:
    """Folders of all generated packages: the kinds, then the scenes."""
    kinds = sorted(path.parent for path in generated_folder().glob(f"kinds/*/{MANIFEST_FILE}"))
    scenes = sorted(path.parent for path in generated_folder().glob(f"*/{MANIFEST_FILE}"))
    return kinds + scenes


def find_packages(name: str) -> list[Path]:
    """Folders that a name stands for: all of them, a package, a kind, or a folder.

    Raises
    ------
    LoadError
        There is no such package, or the folder holds none.
    """
    folders = {path.name: path for path in generated_packages()}
    if not name:
        return list(folders.values())
    if name in folders:
        return [folders[name]]
    folder = Path(name)
    if (folder / MANIFEST_FILE).is_file():
        return [folder]
    if folder.is_dir():
        inside = sorted(path.parent for path in folder.rglob(MANIFEST_FILE))
        if inside:
            return inside
        raise LoadError(f"{name}: holds no {MANIFEST_FILE}; kousoku did not generate it")
    try:
        packages = packages_of(name)
        return [folders[kind] for kind, entry in KINDS.items() if packages[0] in entry.packages]
    except (DerivationError, KeyError):
        names = ", ".join(folders)
        raise LoadError(f"{name}: no such package, kind or folder; known: {names}") from None


def print_json(data: Mapping[str, Any]) -> None:
    """Print data for a program to read, with the number of its format.

    Numbers that are not finite become texts.
    """
    print(json.dumps(_finite({"format": ANSWER_FORMAT, **data}), indent=1, ensure_ascii=False))


def _finite(data: Any) -> Any:
    match data:
        case dict():
            return {key: _finite(value) for key, value in data.items()}
        case list() | tuple():
            return [_finite(value) for value in data]
        case float() if not isfinite(data):
            return str(data)
        case _:
            return data


def at_one_glance(rows: int) -> list[int]:
    """Indices of at most 13 of so many rows, the last of them too; a file holds all."""
    step = max(1, -(-(rows - 1) // 12))
    return sorted({*range(0, rows, step), *range(rows)[-1:]})


def print_table(
    columns: Sequence[str],
    rows: Sequence[Sequence[str]],
    *,
    title: str = "",
    numbers: bool = False,
) -> None:
    """Print a table, the same on a terminal and in a pipe."""
    typer.echo(table(columns, rows, title=title, numbers=numbers))


def progress() -> Progress:
    """Progress bar on stderr, which leaves nothing behind and is silent in a pipe."""
    console = Console(file=sys.stderr)
    return Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        console=console,
        transient=True,
        disable=not console.is_terminal,
    )
