"""``kousoku list``: which generated packages there are, and what their kernels compute."""

from pathlib import Path
from typing import Any

from kousoku.cli.console import AsJson, generated_packages, print_json, print_table
from kousoku.model.manifest import Manifest
from kousoku.symbolic import KINDS


def list_names(as_json: AsJson = False) -> None:
    """List the generated packages and their kernels."""
    rows = [_row(folder) for folder in generated_packages()]
    if as_json:
        print_json({"packages": rows})
        return
    print_table(
        ("name", "what", "other names", "kernels"),
        [(r["name"], r["title"], ", ".join(r["aliases"]), ", ".join(r["kernels"])) for r in rows],
    )


def _row(folder: Path) -> dict[str, Any]:
    manifest = Manifest.from_json((folder / "manifest.json").read_text(encoding="utf-8"))
    kinds = [(name, kind) for name, kind in KINDS.items() if manifest.package == name]
    is_kind = folder.parent.name == "kinds" and bool(kinds)
    return {
        "name": manifest.package,
        "kind": kinds[0][0] if is_kind else None,
        "title": manifest.title,
        "aliases": list(kinds[0][1].aliases) if is_kind else [],
        "kernels": [kernel.name for kernel in manifest.kernels],
    }
