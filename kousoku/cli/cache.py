"""``kousoku cache``: solvers that were generated and compiled before, and their removal."""

from typing import Annotated

import typer

from kousoku.cli.console import AsJson, print_json, print_table


def cache(
    clear: Annotated[bool, typer.Option("--clear", help="Remove all of it.")] = False,
    as_json: AsJson = False,
) -> None:
    """Show what the cache holds: solvers of scenes, kernels of kinds, compiled libraries.

    All of it can be made again. It is kept below 2 GiB, or what KOUSOKU_CACHE_SIZE says, such as
    500M or 1GiB; KOUSOKU_CACHE chooses another folder.
    """
    from kousoku.model.files.cache import SHELVES, cache_folder, entries, size_limit
    from kousoku.model.files.cache import clear as cleared
    from kousoku.model.text import counted

    limit = size_limit()
    gone = cleared() if clear else []
    cached = entries()
    if as_json:
        shelves = {
            shelf: {
                "entries": sum(entry.shelf == shelf for entry in cached),
                "bytes": sum(entry.size for entry in cached if entry.shelf == shelf),
            }
            for shelf in SHELVES
        }
        folder = str(cache_folder())
        print_json({"folder": folder, "limit": limit, "removed": len(gone), "shelves": shelves})
        return
    if clear:
        removed = counted(len(gone), "entry", "entries")
        typer.echo(f"removed {removed}, {_size(sum(entry.size for entry in gone))}")
    rows = []
    for shelf in SHELVES:
        sizes = [entry.size for entry in cached if entry.shelf == shelf]
        rows.append((shelf, str(len(sizes)), _size(sum(sizes))))
    rows.append(("all", str(len(cached)), _size(sum(entry.size for entry in cached))))
    title = f"{cache_folder()}, kept below {_size(limit)}"
    print_table(("", "entries", "size"), rows, title=title)


def _size(count: int) -> str:
    """Bytes as people read them."""
    if count >= 1e8:
        return f"{count / 1e9:.2f} GB"
    return f"{count / 1e6:.1f} MB" if count >= 1e5 else f"{count / 1e3:.1f} kB"
