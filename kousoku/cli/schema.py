"""``kousoku schema``: the JSON schema of scene files, for editors and other programs."""

import sys
from pathlib import Path
from typing import Annotated

import typer


def schema(
    out: Annotated[
        Path | None, typer.Option(help="Write it to a file, such as scene.schema.json.")
    ] = None,
) -> None:
    """Print the JSON schema of scene files.

    Editors with TOML support (Even Better TOML, taplo) complete and check keys of a scene whose
    first line is "#:schema ./scene.schema.json", with that file beside the scene.
    """
    from kousoku.model.cache import write_atomically
    from kousoku.model.schema import schema_text

    if out is None:
        sys.stdout.write(schema_text())
        return
    write_atomically(out, schema_text().encode())
    typer.echo(f"wrote {out}")
