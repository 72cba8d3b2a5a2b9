"""``kousoku schema``: the JSON schema of scene files, or of the answer of a command."""

import json
import sys
from pathlib import Path
from typing import Annotated

import typer

from kousoku.model.errors import LoadError


def schema(
    out: Annotated[
        Path | None, typer.Option(help="Write it to a file, such as scene.schema.json.")
    ] = None,
    command: Annotated[
        str | None,
        typer.Option(
            "--json", metavar="COMMAND", help="The schema of what a command prints with --json."
        ),
    ] = None,
) -> None:
    """Print the JSON schema of scene files.

    Editors with TOML support (Even Better TOML, taplo) complete and check keys of a scene whose
    first line is "#:schema ./scene.schema.json", with that file beside the scene.
    """
    from kousoku.model.files.cache import write_atomically
    from kousoku.runtime.messages import require_folder

    text = _scene_schema() if command is None else _answer_schema(command)
    if out is None:
        sys.stdout.write(text)
        return
    require_folder(out)
    write_atomically(out, text.encode())
    typer.echo(f"wrote {out}")


def _scene_schema() -> str:
    from kousoku.model.reading.schema import schema_text

    return schema_text()


def _answer_schema(command: str) -> str:
    from kousoku.cli.answers import ANSWERS, answer_schema
    from kousoku.runtime.messages import unknown

    if command not in ANSWERS:
        raise LoadError(unknown("command with --json", command, [*ANSWERS]))
    return json.dumps(answer_schema(command), indent=1, ensure_ascii=False) + "\n"
