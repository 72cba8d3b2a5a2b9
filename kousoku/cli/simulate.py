"""``kousoku simulate``: generate the solver of a scene of bodies, let it move, say what it cost."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from kousoku.cli.console import AsJson, Target


class Method(StrEnum):
    """How the motion is found."""

    DOPRI5 = "dopri5"
    DOP853 = "dop853"
    KINEMATICS = "kinematics"


class Output(StrEnum):
    """What can be computed beside positions and velocities."""

    ACCELERATIONS = "accelerations"
    COORDINATES = "coordinates"
    REACTIONS = "reactions"
    ENERGIES = "energies"


def simulate(
    scene_file: Annotated[Path, typer.Argument(metavar="SCENE", help="A scene file, *.toml.")],
    *,
    end: Annotated[float, typer.Option(help="The last time, in seconds.")],
    samples: Annotated[
        int, typer.Option(help="How many times to write, from 0 to the end.")
    ] = 1001,
    tolerance: Annotated[float, typer.Option(help="Local error of a step, relative.")] = 1e-9,
    method: Annotated[
        Method | None,
        typer.Option(
            help="Of order 5 or 8, by the tolerance when left out; kinematics where drivers"
            " determine the motion."
        ),
    ] = None,
    step: Annotated[
        float | None,
        typer.Option(help="Make all steps so long, in seconds, without control of the error."),
    ] = None,
    given: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="NAME=VALUE", help="A parameter of the scene, for each."),
    ] = None,
    body: Annotated[str | None, typer.Option(help="The body to print and to draw.")] = None,
    out: Annotated[
        Path | None, typer.Option(help="Write all rows to a file, *.csv or *.npz.")
    ] = None,
    plot: Annotated[Path | None, typer.Option(help="Draw plots into this folder.")] = None,
    output: Annotated[
        list[Output] | None,
        typer.Option(help="What to compute, once for each; what the scene says when left out."),
    ] = None,
    target: Annotated[Target, typer.Option(help="What computes.")] = Target.AUTO,
    as_json: AsJson = False,
) -> None:
    """Integrate the motion of bodies, with joints that hold to rounding.

    When the motion cannot go on, or Ctrl-C is pressed, what was computed before is written; the
    exit code is 2, or 130.
    """
    from kousoku.cli.bodies import Wish, move, parameters_of
    from kousoku.cli.scenes import read_spatial_scene

    options = {
        "end": end,
        "samples": samples,
        "tolerance": tolerance,
        "method": method.value if method else None,
        "step": step,
        "parameters": parameters_of(given),
    }
    outputs = [one.value for one in output] if output else None
    wish = Wish(scene_file, target, outputs, body, out, plot, as_json, options)
    move(read_spatial_scene(scene_file), wish)
