"""``kousoku simulate``: generate the solver of a scene of bodies, let it move, say what it cost."""

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from kousoku.cli.console import AsJson, print_json, print_table
from kousoku.model.errors import MotionError, SolveError

if TYPE_CHECKING:
    from kousoku.runtime.motion import Motion

#: Rows of the table for people; a file holds all of them.
SHOWN = 13


class Method(StrEnum):
    """How the motion is integrated."""

    DOPRI5 = "dopri5"
    DOP853 = "dop853"


def simulate(
    scene_file: Annotated[Path, typer.Argument(metavar="SCENE", help="A scene file, *.toml.")],
    *,
    end: Annotated[float, typer.Option(help="The last time, in seconds.")],
    samples: Annotated[
        int, typer.Option(help="How many times to write, from 0 to the end.")
    ] = 1001,
    tolerance: Annotated[float, typer.Option(help="Local error of a step, relative.")] = 1e-9,
    method: Annotated[
        Method | None, typer.Option(help="Order 5 or 8; by the tolerance when left out.")
    ] = None,
    body: Annotated[str | None, typer.Option(help="The body to print.")] = None,
    out: Annotated[
        Path | None, typer.Option(help="Write all rows to a file, *.csv or *.npz.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Integrate the motion of bodies under gravity, with joints that hold to rounding.

    When the motion cannot go on, what was computed before is written, and the exit code is 2.
    """
    from kousoku.cli.motion import check_destinations
    from kousoku.cli.scenes import dynamics_of, read_spatial_scene

    scene = read_spatial_scene(scene_file)
    check_destinations(out, None)
    if body is not None and body not in scene.bodies:
        raise SolveError(f"--body {body}: the scene has {', '.join(scene.bodies)}")
    try:
        motion = dynamics_of(scene).simulate(
            end, samples=samples, tolerance=tolerance, method=method.value if method else None
        )
    except SolveError as error:
        kept = _save_partial(error, out)
        raise SolveError(f"{scene_file}: {error}{kept}") from None
    if out is not None:
        motion.save(out)
    if as_json:
        print_json(motion.summary())
        return
    _print_rows(motion, body or list(scene.bodies)[-1])
    typer.echo(str(motion.ledger))
    if out is not None:
        typer.echo(f"wrote {out}")


def _save_partial(error: SolveError, out: Path | None) -> str:
    """Write what was computed before the motion stopped, if there is a file to write to."""
    from kousoku.runtime.motion import Motion

    if out is None or not isinstance(error, MotionError):
        return ""
    if not isinstance(error.trajectory, Motion):
        return ""
    error.trajectory.save(out)
    return f"; what was computed before is in {out}"


def _print_rows(motion: "Motion", body: str) -> None:
    """Print the motion of one body, thinned to a table that is read at one glance."""
    columns = motion.columns()
    names = ["time", *(name for name in columns if name.startswith(f"{body}."))][:8]
    step = max(1, -(-(len(motion) - 1) // (SHOWN - 1)))
    rows = [[f"{columns[name][k]:z.9f}" for name in names] for k in range(0, len(motion), step)]
    print_table(names, rows, title=f"{motion.name}: {body}", numbers=True)
