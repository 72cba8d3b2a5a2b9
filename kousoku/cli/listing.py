"""``kousoku list``: which generated packages there are, and what their kernels compute."""

from typing import Annotated

import typer

from kousoku.cli.console import generated_packages, print_json, print_table
from kousoku.model.manifest import Manifest

#: What other books and programs call a kind; ``docs/notation.md`` says where.
OTHER_NAMES = {
    "n1": "dot-1, PERPENDICULAR",
    "n2": "dot-2, INPLANE",
    "p1": "parallel-1, PARALLEL AXES",
    "p2": "parallel-2, INLINE",
}


def list_names(
    as_json: Annotated[bool, typer.Option("--json", help="Print for a program to read.")] = False,
) -> None:
    """List the generated packages and their kernels."""
    rows = []
    for folder in generated_packages():
        manifest = Manifest.from_json((folder / "manifest.json").read_text(encoding="utf-8"))
        rows.append(
            {
                "name": manifest.package,
                "title": manifest.title,
                "is_kind": folder.parent.name == "kinds",
                "kernels": [kernel.name for kernel in manifest.kernels],
            }
        )
    if as_json:
        print_json(rows)
    else:
        print_table(
            ("name", "what", "kernels"),
            [(str(r["name"]), str(r["title"]), ", ".join(map(str, r["kernels"]))) for r in rows],
        )
