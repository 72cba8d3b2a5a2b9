"""``kousoku solve``: generate a scene's solver, run it, say how good the result is."""

from collections.abc import Mapping
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from kousoku.cli.console import AsJson, Target, at_one_glance, print_json, print_table
from kousoku.model.errors import AssemblyError, MotionError, SolveError

if TYPE_CHECKING:
    from kousoku.runtime.linkage import Trajectory


class Method(StrEnum):
    """How positions are found."""

    NEWTON = "newton"
    PAPER = "paper"


def solve(
    scene_file: Annotated[Path, typer.Argument(metavar="SCENE", help="A scene file, *.toml.")],
    *,
    method: Annotated[
        Method | None, typer.Option(help="Full Newton, or the iteration of the 1981 paper.")
    ] = None,
    divisions: Annotated[int | None, typer.Option(min=1, help="Steps over the input.")] = None,
    turns: Annotated[int | None, typer.Option(min=1, help="Turns to compute.")] = None,
    first_turn: Annotated[
        int | None, typer.Option(min=0, help="The first turn to write, counted from 0.")
    ] = None,
    from_turn: Annotated[
        int | None, typer.Option(min=0, help="The turn to begin in; the first one written.")
    ] = None,
    target: Annotated[Target, typer.Option(help="What computes.")] = Target.AUTO,
    out: Annotated[
        Path | None, typer.Option(help="Write all rows to a file, *.csv or *.npz.")
    ] = None,
    plot: Annotated[Path | None, typer.Option(help="Draw plots into this folder.")] = None,
    node: Annotated[
        str | None, typer.Option(help="The node to print and to draw, of a linkage.")
    ] = None,
    body: Annotated[
        str | None, typer.Option(help="The body to print and to draw, of a scene of bodies.")
    ] = None,
    given: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="NAME=VALUE", help="A parameter of a scene of bodies."),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Solve a scene whose inputs are prescribed: positions, velocities and accelerations.

    A linkage in the plane, or bodies. When it cannot be moved on, the good positions before that
    are written, and the exit code is 2.
    """
    from kousoku.cli.bodies import Wish, solve_bodies
    from kousoku.cli.motion import check_destinations, draw, errors_of, node_to_show
    from kousoku.cli.scenes import solver_of
    from kousoku.model.read import located, read_scene

    scene = read_scene(scene_file)
    of_linkages = {
        "method": method.value if method else None,
        "turns": turns,
        "first_turn": first_turn,
        "from_turn": from_turn,
    }
    if scene.is_spatial:
        _refuse("linkages in the plane; this scene has bodies", **of_linkages, node=node)
        wish = Wish(scene_file, target, None, body, out, plot, as_json)
        solve_bodies(scene, wish, divisions, given)
        return
    _refuse("scenes of bodies; this one is a linkage", body=body, set=given)
    check_destinations(out, plot)
    shown = node_to_show(scene, node)
    options = {**of_linkages, "divisions": divisions}
    solver = solver_of(scene, target)
    try:
        motion = solver.solve(**{key: value for key, value in options.items() if value is not None})
    except AssemblyError as error:
        raise located(error, scene_file) from None
    except SolveError as error:
        kept = "" if out is None else _save_partial(error, out)
        raise SolveError(f"{scene_file}: {error}{kept}") from None
    if out is not None:
        motion.save(out)
    pictures = [] if plot is None else draw(motion, shown, plot)
    errors = errors_of(scene, motion)
    if as_json:
        print_json({**motion.summary(), "errors": errors, "plots": [str(p) for p in pictures]})
        return
    _print_rows(motion, shown)
    _print_summary(motion, errors)
    for path in (*([out] if out else []), *pictures):
        typer.echo(f"wrote {path}")


def _refuse(others: str, **options: object) -> None:
    """Refuse options that the scene has no use for."""
    for name, value in options.items():
        if value is not None:
            raise SolveError(f"--{name.replace('_', '-')} is for {others}")


def _save_partial(error: SolveError, out: Path) -> str:
    """Write the positions before a dead centre, if there are any, and say so."""
    from kousoku.runtime.linkage import Trajectory

    if not isinstance(error, MotionError) or not isinstance(error.trajectory, Trajectory):
        return ""
    error.trajectory.save(out)
    return f"; the good positions are in {out}"


def _print_rows(motion: "Trajectory", node: str) -> None:
    """Print the motion of one node, thinned to a table that is read at one glance."""
    columns = motion.columns()
    inputs = list(columns)[: len(motion.inputs)]
    names = inputs + [name for name in columns if name.startswith(f"{node}.")]
    rows = [[f"{columns[name][k]:z.9f}" for name in names] for k in at_one_glance(len(motion))]
    title = f"{motion.name}: {node}, {motion.unit}, rad and s"
    print_table(names, rows, title=title, numbers=True)


def _print_summary(motion: "Trajectory", errors: Mapping[str, Any] | None) -> None:
    summary = motion.summary()
    count = summary["iterations"]
    typer.echo(
        f"{summary['method']} by {summary['target']}: {summary['rows']} positions,"
        f" {count['min']} to {count['max']} iterations a step, {count['total']} in all,"
        f" residual at most {summary['residual_max']:.1e} {motion.unit}"
    )
    if errors is not None:
        parts = ", ".join(f"{name} {value:.1e}" for name, value in errors.items())
        typer.echo(f"largest difference from the closed form: {parts}")
