"""``kousoku list``: the elements of scenes; or the generated packages, and their kernels."""

from pathlib import Path
from typing import Annotated, Any

import typer

from kousoku.cli.console import AsJson, generated_packages, print_json, print_table
from kousoku.model.files.manifest import MANIFEST_FILE, Manifest
from kousoku.symbolic import KINDS


def list_names(
    section: Annotated[
        str | None,
        typer.Argument(help="kinds, joints, forces, drivers, coordinates, events or bodies."),
    ] = None,
    name: Annotated[str | None, typer.Argument(help="One of them: its keys are listed.")] = None,
    *,
    as_json: AsJson = False,
) -> None:
    """List what a scene may have, such as joints; the generated packages when left out."""
    if section is not None:
        _list_section(section, name, as_json=as_json)
        return
    rows = [_row(folder) for folder in generated_packages()]
    if as_json:
        print_json({"packages": rows})
        return
    print_table(
        ("name", "what", "other names", "kernels"),
        [(r["name"], r["title"], ", ".join(r["aliases"]), ", ".join(r["kernels"])) for r in rows],
    )


def _list_section(section: str, name: str | None, *, as_json: bool) -> None:
    """List a section of the catalog, or the keys of an entry."""
    from kousoku.cataloging import catalog

    table = catalog()[section]
    entries = list(table.values()) if name is None else [table[name]]
    if as_json:
        data = [
            {"name": x.name, "title": x.title, "aliases": list(x.aliases), "keys": dict(x.keys)}
            for x in entries
        ]
        print_json({"section": section, "entries": data})
        return
    typer.echo(repr(table if name is None else entries[0]))


def _row(folder: Path) -> dict[str, Any]:
    manifest = Manifest.from_json((folder / MANIFEST_FILE).read_text(encoding="utf-8"))
    kinds = [(name, kind) for name, kind in KINDS.items() if manifest.package == name]
    is_kind = folder.parent.name == "kinds" and bool(kinds)
    return {
        "name": manifest.package,
        "kind": kinds[0][0] if is_kind else None,
        "title": manifest.title,
        "aliases": list(kinds[0][1].aliases) if is_kind else [],
        "kernels": [kernel.name for kernel in manifest.kernels],
    }
