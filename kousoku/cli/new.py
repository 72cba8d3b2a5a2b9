"""``kousoku new``: a scene with comments, to begin with."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

#: The schema beside a scene, which editors read where the first line says so.
SCHEMA = "scene.schema.json"


class Sort(StrEnum):
    """Scenes to begin with."""

    PENDULUM = "pendulum"
    FOUR_BAR = "four-bar"
    SLIDER_CRANK = "slider-crank"
    LINKAGE = "linkage"
    SPATIAL_LOOP = "spatial-loop"


def new(
    sort: Annotated[
        Sort,
        typer.Argument(
            help="pendulum: a bar on a hinge; four-bar: driven, in a plane; slider-crank: runs by"
            " forces, lengths are parameters; linkage: nodes and links, without masses;"
            " spatial-loop: a closed loop in space."
        ),
    ],
    file: Annotated[
        Path | None,
        typer.Argument(help="The file to write; when left out the sort's, four_bar.toml."),
    ] = None,
    *,
    schema: Annotated[
        bool,
        typer.Option(
            "--schema",
            help=f"Write {SCHEMA} beside it, and a first line that lets editors complete keys.",
        ),
    ] = False,
) -> None:
    """Write a commented scene that moves, to begin with; no file is overwritten."""
    from kousoku.model.errors import SceneError
    from kousoku.model.files.cache import write_atomically
    from kousoku.model.reading.schema import schema_text
    from kousoku.model.validation.names import scene_name_problem
    from kousoku.runtime.messages import require_folder

    path = Path(f"{sort.value.replace('-', '_')}.toml") if file is None else file
    if path.suffix != ".toml":
        raise SceneError("a scene file ends in .toml; choose another name", file=str(path))
    name = path.stem.replace("-", "_")  # four-bar.toml is what one calls it
    if problem := scene_name_problem(name):
        raise SceneError(f"names the scene, too: {problem}", file=str(path))
    if path.exists():
        raise SceneError("is there already; choose another name", file=str(path))
    require_folder(path)
    text = template(sort, name)
    if schema:
        beside = path.parent / SCHEMA
        write_atomically(beside, schema_text().encode())
        text = f"#:schema ./{SCHEMA}\n{text}"
    write_atomically(path, text.encode())
    typer.echo(f"wrote {path}; move it: kousoku simulate {path}")


def template(sort: Sort, name: str) -> str:
    """Text of a scene to begin with, under a name."""
    from importlib.resources import files

    stem = sort.value.replace("-", "_")
    text = (files("kousoku") / "templates" / f"{stem}.toml").read_text(encoding="utf-8")
    return text.replace(f'name = "{stem}"\n', f'name = "{name}"\n', 1)
