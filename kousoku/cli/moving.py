"""Parts that ``simulate``, ``solve`` and ``animate`` share: load, move, write, draw, print."""

from __future__ import annotations

import math
import time
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple, cast

import typer

from kousoku.cli.completing import files
from kousoku.cli.console import (
    INTERRUPTED,
    STOPPED,
    TargetChoice,
    at_one_glance,
    print_json,
    print_table,
)
from kousoku.cli.wording import as_typed
from kousoku.model.errors import ExpressionError, MotionError, NotInResultError, SolveError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence

    from kousoku.mechanism import Mechanism
    from kousoku.model.records.scene import Output
    from kousoku.runtime.integrate.result import Result

#: Columns of the table on the screen.
MOST_COLUMNS = 8
#: Formats of a plot that is one file.
PICTURES = (".png", ".svg", ".pdf")

#: How positions of linkages of nodes are found.
OfLinkages = Literal["newton", "paper"]
SceneFile = Annotated[
    Path,
    typer.Argument(metavar="SCENE", help="A scene file, *.toml.", autocompletion=files(".toml")),
]
Set = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="NAME=VALUE",
        help="A parameter of the scene, for each; formulas too, as 2*pi/3 or 30deg.",
    ),
]
InitialOption = Annotated[
    list[str] | None,
    typer.Option(
        "--initial",
        metavar="NAME=VALUE",
        help="Where to start: a coordinate, or its rate NAME_dot, for each; formulas too, as pi/6"
        " or 30deg.",
    ),
]
Out = Annotated[
    Path | None, typer.Option(help="Write all rows to a file, *.csv, *.npz or *.parquet.")
]
Plot = Annotated[
    Path | None,
    typer.Option(help="Draw into a file, *.png or *.svg, or several plots into a folder."),
]
Columns = Annotated[
    list[str] | None,
    typer.Option("--column", metavar="NAME", help="What to print and to draw, for each."),
]
KindsOption = Annotated[
    list[Path] | None,
    typer.Option(
        "--kind",
        metavar="FOLDER",
        help="Kernels of a kind of your own, a type of joints of the scene; once for each.",
    ),
]
Of = Annotated[
    str | None, typer.Option("--body", "--node", help="The body or node to print and to draw.")
]


@dataclass(frozen=True, slots=True)
class Wish:
    """Request of a command.

    Parameters
    ----------
    file : Path
        The scene file.
    target : TargetChoice
        What computes.
    outputs : list of str, optional
        What to compute; what the scene says unless given.
    columns : sequence of str, optional
        Columns to print and to draw.
    of : str, optional
        The body or node to print and to draw.
    out, plot : Path, optional
        Where all rows go, and plots.
    as_json : bool
        Print JSON.
    kinds : sequence of Path, optional
        Folders of kinds of one's own.
    """

    file: Path
    target: TargetChoice = TargetChoice.AUTO
    outputs: Sequence[str] | None = None
    columns: Sequence[str] | None = None
    of: str | None = None
    out: Path | None = None
    plot: Path | None = None
    as_json: bool = False
    kinds: Sequence[Path] | None = None


def move(
    wish: Wish,
    how: Callable[[Mechanism, Any], Result],
    compare: Callable[[Mechanism, Result], Mapping[str, float] | None] | None = None,
) -> None:
    """Load a scene, move it, and print, write and draw the result.

    Parameters
    ----------
    wish : Wish
        What is asked for.
    how : callable
        Moves the mechanism; also takes what shows how far it is.
    compare : callable, optional
        Gives the largest differences from a closed form, where there is one.

    Raises
    ------
    SceneError
        The scene is not valid; the message names the file.
    SolveError
        An option is not possible, or the start is not.
    typer.Exit
        The motion stopped, rows before that are written; or its ledger says why it is not to be
        trusted.
    """
    check_destinations(wish)
    begin = time.perf_counter()
    mechanism = loaded(wish)
    seconds = {"load": time.perf_counter() - begin}
    if wish.of is not None:
        _require_part(mechanism, wish.of)
    result, stop = moved(wish.file, mechanism, how)
    wish = replace(wish, columns=_columns(result, wish.columns))
    begin = time.perf_counter()
    files = _write(result, wish)
    seconds |= getattr(result.ledger, "seconds", {})
    if files:
        seconds["files"] = time.perf_counter() - begin
    errors = compare(mechanism, result) if compare and not stop else None
    if stop:
        saved = f"; what was computed before is in {wish.out}" if wish.out else ""
        typer.echo(f"kousoku: {wish.file}: {stop.why}{saved}", err=True)
        if wish.as_json:
            _show(result, wish, files, seconds, errors)
        raise typer.Exit(stop.code)
    _show(result, wish, files, seconds, errors)
    require_trust(wish.file, result)


class Stop(NamedTuple):
    """Why a motion stopped before its end, and the exit code."""

    code: int
    why: str


def moved(
    file: Path, mechanism: Mechanism, how: Callable[[Mechanism, Any], Result]
) -> tuple[Result, Stop | None]:
    """Motion of a mechanism as far as it came, and why it stopped if it did.

    Raises
    ------
    SceneError
        The scene is not valid; the message names the file.
    SolveError
        An option is not possible, or the start is not.
    """
    from kousoku.loading import naming
    from kousoku.runtime.run import Interrupted

    try:
        with naming(file), shown_progress() as show:
            return how(mechanism, show), None
    except MotionError as error:
        return mechanism.result_of(error.result), Stop(STOPPED, as_typed(str(error)))
    except Interrupted as error:
        return mechanism.result_of(error.result), Stop(INTERRUPTED, str(error))
    except SolveError as error:
        raise (SolveError(f"{file}: {error}") if str(file) not in str(error) else error) from None


def require_trust(file: Path, result: Result) -> None:
    """End with 3 where a motion cannot be trusted, and say why."""
    trust = getattr(result.ledger, "trust", None)
    if trust is not None and not trust.is_trusted:
        typer.echo(f"kousoku: {file}: not trusted: {as_typed(trust.why)}", err=True)
        raise typer.Exit(STOPPED)


def loaded(wish: Wish) -> Mechanism:
    """Load the mechanism of a scene file."""
    from kousoku.loading import load

    outputs = cast("Sequence[Output] | None", wish.outputs)
    return load(wish.file, outputs=outputs, target=wish.target.value, kinds=wish.kinds)


def check_destinations(wish: Wish) -> None:
    """Refuse places where nothing can be written, before anything is computed.

    Raises
    ------
    SolveError
        A suffix is unknown, a folder is missing, or a package that writes there is.
    """
    from kousoku.runtime.integrate.result import SUFFIXES

    out, plot = wish.out, wish.plot
    if out is not None:
        require_place("--out", out, SUFFIXES)
        if out.suffix == ".parquet":
            _require_packages("--out *.parquet", ("pandas", "pyarrow"), "table")
    if plot is not None:
        _require_packages("--plot", ("matplotlib",), "plot")
        if plot.suffix in PICTURES:
            require_place("--plot", plot, PICTURES)
        elif not plot.is_dir() and (plot.exists() or plot.suffix):
            advice = f"wanted a folder, or a name that ends in {' or '.join(PICTURES)}"
            raise SolveError(f"--plot {plot}: {'is a file; ' * plot.exists()}{advice}")


def _require_packages(option: str, names: Sequence[str], extra: str) -> None:
    """Refuse what needs packages that are not installed."""
    missing = [name for name in names if find_spec(name) is None]
    if missing:
        raise SolveError(f"{option} needs {' and '.join(missing)}: pip install kousoku[{extra}]")


def require_place(option: str, path: Path, suffixes: Sequence[str]) -> None:
    """Refuse a file that cannot be there.

    Raises
    ------
    SolveError
        Its suffix is unknown, it is a folder, or its folder is missing.
    """
    if path.suffix not in suffixes:
        raise SolveError(f"{option} {path}: the name must end in {' or '.join(suffixes)}")
    if path.is_dir():
        raise SolveError(f"{option} {path}: is a folder, wanted a file")
    if not path.absolute().parent.is_dir():
        raise SolveError(f"{option} {path}: there is no folder {path.parent}; make it first")


def _require_part(mechanism: Mechanism, name: str) -> None:
    """Refuse a body or node that the scene has not."""
    scene = mechanism.scene
    names = [*(scene.bodies if scene.is_spatial else scene.nodes)]
    if name not in names:
        from kousoku.runtime.messages import unknown

        part = "body" if scene.is_spatial else "node"
        raise SolveError(f"{scene.name}: {unknown(part, name, names)}")


def _columns(result: Result, names: Sequence[str] | None) -> list[str]:
    """Columns that names stand for: themselves, or all of a body, joint or node.

    Raises
    ------
    SolveError
        There is no such column.
    """
    try:
        return [column for name in names or () for column in result.columns_of(name)]
    except NotInResultError as error:
        raise SolveError(f"--column: {error}") from None


def _write(result: Result, wish: Wish) -> list[Path]:
    """Write rows and plots where they are asked for, and return the files: the plots last."""
    files = []
    if wish.out is not None:
        result.save(wish.out)
        files.append(wish.out)
    if wish.plot is not None:
        from kousoku.result_plots import draw_into

        files += draw_into(result, wish.plot, columns=wish.columns, of=wish.of)
    return files


def _show(
    result: Result,
    wish: Wish,
    files: Sequence[Path],
    seconds: Mapping[str, float],
    errors: Mapping[str, float] | None,
) -> None:
    """Print rows, ledger and files."""
    if wish.as_json:
        data = {**result.summary(), "seconds": dict(seconds), "errors": errors}
        print_json({**data, "plots": [str(path) for path in files if path != wish.out]})
        return
    _print_rows(result, wish)
    for line in result.notes:
        typer.echo(line)
    typer.echo(as_typed(str(result.ledger)))
    if errors is not None:
        texts = ", ".join(f"{name} {value:.1e}" for name, value in errors.items())
        typer.echo(f"largest difference from the closed form: {texts}")
    typer.echo(f"time: {', '.join(f'{name} {value:.3g} s' for name, value in seconds.items())}")
    for path in files:
        typer.echo(f"wrote {path}")


def _print_rows(result: Result, wish: Wish) -> None:
    """Print the wanted columns, thinned to a table that is read at one glance."""
    names = ["time"] if "time" in result else []
    names = [*dict.fromkeys([*names, *(wish.columns or result.main_columns(wish.of))])]
    names = names[:MOST_COLUMNS]
    units = result.units
    heads = [f"{name} [{units[name]}]" if units[name] else name for name in names]
    rows = [[f"{result[name][k]:z.9f}" for name in names] for k in at_one_glance(len(result))]
    print_table(heads, rows, title=result.name, numbers=True)


@contextmanager
def shown_progress() -> Iterator[Callable[[float, float], None] | None]:
    """Progress of the time reached, where somebody watches."""
    from kousoku.progress import status_line

    with status_line() as tell:

        def show(reached: float, end: float) -> None:
            tell(f"{reached:.6g} s of {end:.6g} s")

        yield show


def numbers_of(option: str, assignments: Sequence[str] | None) -> dict[str, float | str]:
    """Values of options such as ``--set NAME=VALUE``; angles in degrees stay texts.

    Raises
    ------
    SolveError
        One is not a name, ``=`` and a number or a formula of numbers.
    """
    values: dict[str, float | str] = {}
    for text in assignments or ():
        name, _, value = (part.strip() for part in text.partition("="))
        example = "k=3.0, or k=1/3"
        if option == "--initial":
            example = "angle=pi/6, or 'angle=30 deg'; a rate, angle_dot, is per second"
        if not (name and value):
            raise SolveError(f"{option} {text}: wanted a name, = and a number: {example}")
        if name in values:
            raise SolveError(f"{option} {text}: {name} is given twice; give it once")
        try:
            values[name] = _number(value)
        except ExpressionError as error:
            raise SolveError(f"{option} {text}: {error}; wanted a number: {example}") from None
    return values


def _number(text: str) -> float | str:
    """Value of a text: a number, an angle in degrees, or a formula.

    Raises
    ------
    ExpressionError
        It is none of them.
    """
    from kousoku.model.angles import number_of
    from kousoku.model.expressions.parser import parse_expression
    from kousoku.model.expressions.values import value_of

    with suppress(ValueError):
        return float(text)
    with suppress(ValueError):
        value = number_of(text)
        return text if "deg" in text else value
    value = value_of(parse_expression(text, ()), {})
    return f"{math.degrees(value)!r} deg" if "deg" in text and math.isfinite(value) else value
