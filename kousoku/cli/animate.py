"""``kousoku animate``: move a scene, and write a page, or a picture, that shows it moving."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from kousoku.cli.console import Target
from kousoku.model.errors import SolveError

if TYPE_CHECKING:
    from kousoku.model.scene import Scene
    from kousoku.runtime.linkage import Trajectory
    from kousoku.runtime.motion import Motion

#: Rows for a second of motion, and how many there are at least and at most.
RATE, LEAST, MOST = 500, 1001, 20001


def animate(
    scene_file: Annotated[Path, typer.Argument(metavar="SCENE", help="A scene file, *.toml.")],
    *,
    out: Annotated[
        Path | None,
        typer.Option(help="The page, *.html, or a picture that moves, *.svg; SCENE.html if not."),
    ] = None,
    end: Annotated[
        float | None, typer.Option(help="The last time, in seconds; inputs have their own.")
    ] = None,
    speed: Annotated[
        float | None, typer.Option(help="Seconds of motion in a second of showing.")
    ] = None,
    path_of: Annotated[
        list[str] | None,
        typer.Option(help="A joint, node or body whose path is drawn, once for each."),
    ] = None,
    given: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="NAME=VALUE", help="A parameter of a scene of bodies."),
    ] = None,
    target: Annotated[Target, typer.Option(help="What computes.")] = Target.AUTO,
) -> None:
    """Show a scene that moves: one page that needs nothing beside itself.

    Open it in a browser. Forces of joints are shown where the scene asks for reactions.
    """
    from kousoku.cli.bodies import parameters_of
    from kousoku.cli.motion import check_destinations
    from kousoku.model.read import read_scene
    from kousoku.view import animate as animated

    place = Path(f"{scene_file.stem}.html") if out is None else out
    check_destinations(place, None, (".html", ".svg"))
    scene = read_scene(scene_file)
    parameters = parameters_of(given)
    motion = _moved(scene, scene_file, end, parameters, target)
    animated(motion, scene, place, speed=speed, paths_of=path_of, parameters=parameters)
    typer.echo(f"wrote {place}, {place.stat().st_size / 1000:.0f} kB")


def _moved(
    scene: "Scene", file: Path, end: float | None, parameters: dict[str, float], target: Target
) -> "Motion | Trajectory":
    """Return the motion of a scene."""
    from kousoku.cli.scenes import dynamics_of, naming, solver_of
    from kousoku.model.drivers import times_of

    if not scene.is_spatial:
        if end is not None or parameters:
            raise SolveError(f"{file}: --end and --set are for scenes of bodies; this is a linkage")
        with naming(file):
            return solver_of(scene, target).solve()
    times = times_of(scene) if end is None else None
    if end is None and times is None:
        raise SolveError(f"{file}: has no inputs, which say when they end; wanted --end SECONDS")
    with naming(file):
        solver, _ = dynamics_of(scene, target)
        if end is None:
            return solver.simulate(times=times, parameters=parameters)
        samples = int(min(max(end * RATE, LEAST), MOST))
        return solver.simulate(end, samples=samples, parameters=parameters)
