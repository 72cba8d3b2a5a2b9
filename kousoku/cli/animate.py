"""``kousoku animate``: a page, or a picture, that shows a mechanism moving."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from kousoku.cli.completing import files
from kousoku.cli.console import TargetChoice
from kousoku.cli.moving import (
    InitialOption,
    KindsOption,
    Set,
    Stop,
    Wish,
    loaded,
    moved,
    numbers_of,
    require_place,
    require_trust,
)
from kousoku.model.errors import SolveError

if TYPE_CHECKING:
    from kousoku.mechanism import Mechanism
    from kousoku.runtime.integrate.result import Result

#: Rows for a second of motion, and how many there are at least and at most.
RATE, LEAST, MOST = 500, 1001, 20001


def animate(
    file: Annotated[
        Path,
        typer.Argument(
            metavar="SCENE",
            help="A scene file, *.toml, or a run, *.npz.",
            autocompletion=files(".toml", ".npz"),
        ),
    ],
    *,
    out: Annotated[
        Path | None,
        typer.Option(help="The page, *.html, or a picture that moves, *.svg; SCENE.html if not."),
    ] = None,
    end: Annotated[
        float | None,
        typer.Option(help="The last time, in seconds; inputs and durations have their own."),
    ] = None,
    speed: Annotated[
        float | None, typer.Option(help="Seconds of motion in a second of showing.")
    ] = None,
    path_of: Annotated[
        list[str] | None,
        typer.Option(help="A joint, node or body whose path is drawn, once for each."),
    ] = None,
    given: Set = None,
    initial: InitialOption = None,
    kind: KindsOption = None,
    target: Annotated[TargetChoice, typer.Option(help="What computes.")] = TargetChoice.AUTO,
) -> None:
    """Show a mechanism that moves: one page that needs nothing beside itself.

    Open it in a browser. Forces of joints are shown where the scene asks for reactions. When the
    motion stops before its end, or Ctrl-C is pressed, what there is is shown, and the exit code is
    3, or 130. It is 3, too, where the motion cannot be trusted.
    """
    from kousoku.saved import open_run

    destination = Path(f"{file.stem}.html") if out is None else out
    require_place("--out", destination, (".html", ".svg"))
    stop: Stop | None = None
    if file.suffix == ".npz":
        if end is not None or given or initial or kind:
            raise SolveError(
                f"{file}: --end, --set, --initial and --kind are for scenes; this run is over"
            )
        result = open_run(file)
    else:
        options = {
            "parameters": numbers_of("--set", given),
            "initial": numbers_of("--initial", initial),
        }
        result, stop = _moved(
            Wish(file, target, kinds=kind),
            end,
            {name: value for name, value in options.items() if value},
            {"paths_of": path_of, "speed": speed},
        )
    if len(result) or not stop:
        result.animate(destination, speed=speed, paths_of=path_of)
        typer.echo(f"wrote {destination}, {destination.stat().st_size / 1000:.0f} kB")
    if stop:
        typer.echo(f"kousoku: {file}: {stop.why}", err=True)
        raise typer.Exit(stop.code)
    require_trust(file, result)


def _moved(
    wish: Wish, end: float | None, options: dict[str, Any], display: dict[str, Any]
) -> "tuple[Result, Stop | None]":
    """Motion of a scene as far as it came, and why it stopped if it did."""
    from kousoku.view.picture import require_showable

    mechanism = loaded(wish)
    scene = mechanism.scene
    require_showable(scene, **display)
    if scene.inputs and "initial" in options:
        raise SolveError(f"{wish.file}: inputs say where a linkage starts; --initial is for bodies")
    duration = scene.duration if end is None else end

    def how(mechanism: "Mechanism", progress: Any) -> "Result":
        if duration is None and scene.inputs:
            return mechanism.solve(**options)
        samples = int(min(max((duration or 0.0) * RATE, LEAST), MOST))
        return mechanism.simulate(duration, samples=samples, progress=progress, **options)

    return moved(wish.file, mechanism, how)
