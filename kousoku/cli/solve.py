"""``kousoku solve``: a scene whose inputs are prescribed, at their divisions."""

from typing import TYPE_CHECKING, Annotated, Any

import typer

from kousoku.cli.console import AsJson, TargetChoice
from kousoku.cli.moving import (
    Columns,
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


def solve(
    scene_file: SceneFile,
    *,
    method: Annotated[
        OfLinkages | None,
        typer.Option(help="Of linkages: full Newton, or the iteration of the 1981 paper."),
    ] = None,
    divisions: Annotated[int | None, typer.Option(min=1, help="Steps over the input.")] = None,
    turns: Annotated[int | None, typer.Option(min=1, help="Of linkages: turns to compute.")] = None,
    first_turn: Annotated[
        int | None,
        typer.Option(min=0, help="Of linkages: the first turn to write, counted from 0."),
    ] = None,
    from_turn: Annotated[
        int | None,
        typer.Option(min=0, help="Of linkages: the turn that begins as the scene says; 0."),
    ] = None,
    given: Set = None,
    kind: KindsOption = None,
    column: Columns = None,
    of: Of = None,
    out: Out = None,
    plot: Plot = None,
    target: Annotated[TargetChoice, typer.Option(help="What computes.")] = TargetChoice.AUTO,
    as_json: AsJson = False,
) -> None:
    """Solve a scene whose inputs are prescribed: positions, velocities and accelerations.

    A linkage of nodes, or bodies. When it cannot be moved on, the good positions before that are
    written, and the exit code is 3.
    """
    options: dict[str, Any] = {
        "method": method,
        "divisions": divisions,
        "turns": turns,
        "first_turn": first_turn,
        "from_turn": from_turn,
        "parameters": numbers_of("--set", given) or None,
    }

    def how(mechanism: "Mechanism", progress: Any) -> "Result":
        del progress  # a turn takes a millisecond
        return mechanism.solve(
            **{name: value for name, value in options.items() if value is not None}
        )

    wish = Wish(scene_file, target, None, column, of, out, plot, as_json, kind)
    move(wish, how, _errors)


def _errors(mechanism: "Mechanism", result: "Result") -> dict[str, float] | None:
    """Largest distances from the closed form, None where there is none."""
    from kousoku.closed_form import errors_of

    return None if mechanism.scene.is_spatial else errors_of(mechanism.scene, result)
