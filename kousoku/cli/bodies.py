"""What ``simulate`` and ``solve`` do with scenes of bodies: generate, move, write, draw, print."""

from __future__ import annotations

import sys
import time
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from math import isfinite
from typing import TYPE_CHECKING, Any

import typer

from kousoku.cli.console import at_one_glance, print_json, print_table
from kousoku.model.errors import AssemblyError, SceneError, SolveError
from kousoku.model.read import located

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence
    from pathlib import Path

    from kousoku.cli.console import Target
    from kousoku.model.scene import Scene
    from kousoku.runtime.motion import Motion


@dataclass(frozen=True, slots=True)
class Wish:
    """What a command asks for.

    Parameters
    ----------
    file : Path
        The scene file.
    target : Target
        What computes.
    outputs : list of str, optional
        What to compute; what the scene says unless given.
    body : str, optional
        The body to print and to draw.
    out, plot : Path, optional
        File for all rows, folder for plots.
    as_json : bool
        Print JSON.
    options : dict
        Of :meth:`kousoku.runtime.dynamics.DynamicsSolver.simulate`.
    """

    file: Path
    target: Target
    outputs: Sequence[str] | None
    body: str | None
    out: Path | None
    plot: Path | None
    as_json: bool
    options: dict[str, Any] = field(default_factory=dict)


def move(scene: Scene, wish: Wish) -> None:
    """Move the bodies of a scene, and print what came of it.

    Raises
    ------
    SceneError
        The scene asks for what cannot be; the message names the file.
    SolveError
        The motion cannot go on, or an option is not possible; rows before that are written.
    """
    from kousoku.cli.motion import check_destinations
    from kousoku.cli.scenes import dynamics_of
    from kousoku.model.validate_unused import output_problem
    from kousoku.runtime.run import Interrupted

    check_destinations(wish.out, wish.plot)
    if wish.body is not None and wish.body not in scene.bodies:
        raise SolveError(f"--body {wish.body}: the scene has {', '.join(scene.bodies)}")
    for output in wish.outputs or ():
        if problem := output_problem(scene, output):
            raise SolveError(f"--output {output}: {problem}")
    try:
        solver, seconds = dynamics_of(scene, wish.target, wish.outputs)
        with _progress() as show:
            motion = solver.simulate(**wish.options, progress=show)
    except (SceneError, AssemblyError) as error:
        raise located(error, wish.file) from None
    except SolveError as error:
        kept = _save_partial(getattr(error, "trajectory", None), wish.out)
        raise SolveError(f"{wish.file}: {error}{kept}") from None
    except Interrupted as stop:
        typer.echo(f"{wish.file}: {stop}{_save_partial(stop.motion, wish.out)}", err=True)
        raise typer.Exit(130) from None
    begin = time.perf_counter()
    files = _write(motion, scene, wish)
    seconds |= dict(motion.ledger.seconds)
    if files:
        seconds["files"] = time.perf_counter() - begin
    ledger = replace(motion.ledger, seconds=seconds)
    _show(motion.with_ledger(ledger), scene, wish, files)


def solve_bodies(
    scene: Scene, wish: Wish, divisions: int | None, given: Sequence[str] | None
) -> None:
    """Solve a scene of bodies whose inputs determine its motion, at their divisions.

    Raises
    ------
    SolveError
        The scene has no inputs, they never take their values, or the motion cannot go on.
    """
    import msgspec

    from kousoku.model.drivers import times_of

    scene = scene if divisions is None else msgspec.structs.replace(scene, divisions=divisions)
    times = times_of(scene)
    if times is None:
        raise SolveError(
            f"{wish.file}: has no inputs, whose divisions say at which times to solve; where"
            " drivers are formulas of time: kousoku simulate SCENE --end …"
        )
    if not all(map(isfinite, times)):
        raise SolveError(
            f"{wish.file}: inputs.{next(iter(scene.inputs))} never reaches the end of its way: its"
            " rate and acceleration lead elsewhere"
        )
    options = {"times": times, "method": "kinematics", "parameters": parameters_of(given)}
    move(scene, replace(wish, options=options))


def _write(motion: Motion, scene: Scene, wish: Wish) -> list[Path]:
    """Write rows and plots where they are asked for, and return the files: the plots last."""
    files = []
    if wish.out is not None:
        motion.save(wish.out)
        files.append(wish.out)
    if wish.plot is None:
        return files
    from kousoku.motion_plots import draw_bodies

    return files + draw_bodies(motion, scene.unit, wish.plot, wish.body)


def _show(motion: Motion, scene: Scene, wish: Wish, files: Sequence[Path]) -> None:
    """Print rows, ledger and files."""
    if wish.as_json:
        plots = [str(path) for path in files if path != wish.out]
        print_json({**motion.summary(), "plots": plots})
        return
    _print_rows(motion, wish.body or list(scene.bodies)[-1])
    if motion.note():
        typer.echo(motion.note())
    typer.echo(str(motion.ledger))
    for path in files:
        typer.echo(f"wrote {path}")


def _save_partial(motion: object, out: Path | None) -> str:
    """Write what was computed before the motion stopped, if there is a file to write to."""
    from kousoku.runtime.motion import Motion

    if out is None or not isinstance(motion, Motion):
        return ""
    motion.save(out)
    return f"; what was computed before is in {out}"


@contextmanager
def _progress() -> Iterator[Callable[[float, float], None] | None]:
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


def _print_rows(motion: Motion, body: str) -> None:
    """Print the motion of one body, thinned to a table that is read at one glance."""
    columns = motion.columns()
    names = ["time", *(name for name in columns if name.startswith(f"{body}."))][:8]
    rows = [[f"{columns[name][k]:z.9f}" for name in names] for k in at_one_glance(len(motion))]
    print_table(names, rows, title=f"{motion.name}: {body}", numbers=True)


def parameters_of(given: Sequence[str] | None) -> dict[str, float]:
    """Return the values of ``--set NAME=VALUE``.

    Raises
    ------
    SolveError
        One is not a name, ``=`` and a number.
    """
    values: dict[str, float] = {}
    for text in given or ():
        name, _, number = text.partition("=")
        try:
            values[name.strip()] = float(number)
        except ValueError:
            raise SolveError(f"--set {text}: wanted a name, = and a number: k=3.0") from None
    return values
