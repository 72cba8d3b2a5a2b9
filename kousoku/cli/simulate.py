"""``kousoku simulate``: generate the solver of a scene of bodies, let it move, say what it cost."""

import sys
import time
from contextlib import contextmanager
from dataclasses import replace
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from kousoku.cli.console import AsJson, Target, print_json, print_table
from kousoku.model.errors import SolveError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from kousoku.runtime.motion import Motion

#: Rows of the table for people; a file holds all of them.
SHOWN = 13


class Method(StrEnum):
    """How the motion is integrated."""

    DOPRI5 = "dopri5"
    DOP853 = "dop853"


class Output(StrEnum):
    """What can be computed beside positions and velocities."""

    ACCELERATIONS = "accelerations"
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
        Method | None, typer.Option(help="Order 5 or 8; by the tolerance when left out.")
    ] = None,
    body: Annotated[str | None, typer.Option(help="The body to print.")] = None,
    out: Annotated[
        Path | None, typer.Option(help="Write all rows to a file, *.csv or *.npz.")
    ] = None,
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
    from kousoku.cli.motion import check_destinations
    from kousoku.cli.scenes import dynamics_of, read_spatial_scene
    from kousoku.runtime.run import Interrupted

    scene = read_spatial_scene(scene_file)
    check_destinations(out, None)
    if body is not None and body not in scene.bodies:
        raise SolveError(f"--body {body}: the scene has {', '.join(scene.bodies)}")
    begin = time.perf_counter()
    try:
        solver = dynamics_of(scene, target, output and [one.value for one in output])
        seconds = {"generate and compile": time.perf_counter() - begin}
        with _progress() as show:
            motion = solver.simulate(
                end,
                samples=samples,
                tolerance=tolerance,
                method=method.value if method else None,
                progress=show,
            )
    except SolveError as error:
        kept = _save_partial(getattr(error, "trajectory", None), out)
        raise SolveError(f"{scene_file}: {error}{kept}") from None
    except Interrupted as stop:
        typer.echo(f"{scene_file}: {stop}{_save_partial(stop.motion, out)}", err=True)
        raise typer.Exit(130) from None
    ledger = replace(motion.ledger, seconds=seconds | dict(motion.ledger.seconds))
    motion = replace(motion, ledger=ledger)
    if out is not None:
        motion.save(out)
    if as_json:
        print_json(motion.summary())
        return
    _print_rows(motion, body or list(scene.bodies)[-1])
    typer.echo(str(motion.ledger))
    if out is not None:
        typer.echo(f"wrote {out}")


def _save_partial(motion: object, out: Path | None) -> str:
    """Write what was computed before the motion stopped, if there is a file to write to."""
    from kousoku.runtime.motion import Motion

    if out is None or not isinstance(motion, Motion):
        return ""
    motion.save(out)
    return f"; what was computed before is in {out}"


@contextmanager
def _progress() -> "Iterator[Callable[[float, float], None] | None]":
    """Give what shows the time reached on a terminal, and wipe it at the end."""
    if not sys.stderr.isatty():
        yield None
        return

    def show(reached: float, end: float) -> None:
        sys.stderr.write(f"\r{reached:.6g} s of {end:.6g} s")
        sys.stderr.flush()

    try:
        yield show
    finally:
        sys.stderr.write("\r\033[K")


def _print_rows(motion: "Motion", body: str) -> None:
    """Print the motion of one body, thinned to a table that is read at one glance."""
    columns = motion.columns()
    names = ["time", *(name for name in columns if name.startswith(f"{body}."))][:8]
    step = max(1, -(-(len(motion) - 1) // (SHOWN - 1)))
    rows = [[f"{columns[name][k]:z.9f}" for name in names] for k in range(0, len(motion), step)]
    print_table(names, rows, title=f"{motion.name}: {body}", numbers=True)
