"""``kousoku simulate``: load a scene, let it move in time, tell the cost."""

from enum import StrEnum
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from kousoku.cli.console import AsJson, TargetChoice
from kousoku.cli.moving import (
    Columns,
    InitialOption,
    KindsOption,
    Of,
    OfLinkages,
    Out,
    Plot,
    SceneFile,
    Set,
    Wish,
    move,
    numbers_of,
)

if TYPE_CHECKING:
    from kousoku.mechanism import Mechanism
    from kousoku.runtime.integrate.result import Result


#: How the motion is found.
MethodName = Literal["dopri5", "dop853", "kinematics", OfLinkages]


class OutputChoice(StrEnum):
    """Outputs beside positions and velocities."""

    ACCELERATIONS = "accelerations"
    COORDINATES = "coordinates"
    REACTIONS = "reactions"
    ENERGIES = "energies"
    VELOCITIES = "velocities"
    ANGLES = "angles"


def simulate(
    scene_file: SceneFile,
    *,
    end: Annotated[
        float | None,
        typer.Option(help="The last time, in seconds; the duration of the scene when left out."),
    ] = None,
    samples: Annotated[
        int, typer.Option(help="How many times to write, from 0 to the end.")
    ] = 1001,
    tolerance: Annotated[
        float | None, typer.Option(help="Local error of a step, relative; 1e-9 when left out.")
    ] = None,
    method: Annotated[
        MethodName | None,
        typer.Option(
            help="Of order 5 or 8, by the tolerance when left out; kinematics where drivers"
            " determine the motion; newton or paper for linkages of nodes."
        ),
    ] = None,
    step: Annotated[
        float | None,
        typer.Option(help="Make all steps so long, in seconds, without control of the error."),
    ] = None,
    largest_step: Annotated[
        float | None, typer.Option(help="No step is longer, in seconds.")
    ] = None,
    most_steps: Annotated[
        int | None, typer.Option(help="A run that needs more steps is stopped; 1000000.")
    ] = None,
    strict: Annotated[
        bool,
        typer.Option("--strict", help="Refuse a start that assembly moved, turned or sped up."),
    ] = False,
    estimate_error: Annotated[
        bool,
        typer.Option(
            "--estimate-error",
            help="Make a second run by another method, and say how far its rows are away.",
        ),
    ] = False,
    given: Set = None,
    initial: InitialOption = None,
    kind: KindsOption = None,
    output: Annotated[
        list[OutputChoice] | None,
        typer.Option(help="What to compute, once for each; what the scene says when left out."),
    ] = None,
    column: Columns = None,
    of: Of = None,
    out: Out = None,
    plot: Plot = None,
    target: Annotated[TargetChoice, typer.Option(help="What computes.")] = TargetChoice.AUTO,
    as_json: AsJson = False,
) -> None:
    """Move a mechanism in time: bodies are integrated, a linkage follows its inputs.

    When the motion cannot go on, or Ctrl-C is pressed, what was computed before is written; the
    exit code is 3, or 130. It is 3, too, when energy, drift or rows tell that the result is not to
    be trusted.
    """
    options: dict[str, Any] = {
        "tolerance": tolerance,
        "method": method,
        "step": step,
        "largest_step": largest_step,
        "most_steps": most_steps,
        "strict": strict or None,
        "estimate_error": estimate_error or None,
        "parameters": numbers_of("--set", given) or None,
        "initial": numbers_of("--initial", initial) or None,
    }
    options = {name: value for name, value in options.items() if value is not None}

    def how(mechanism: "Mechanism", progress: Any) -> "Result":
        return mechanism.simulate(end, samples=samples, progress=progress, **options)

    outputs = [choice.value for choice in output] if output else None
    move(Wish(scene_file, target, outputs, column, of, out, plot, as_json, kind), how)
