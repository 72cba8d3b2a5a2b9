"""The command ``kousoku``: its sub-commands, and how errors become exit codes."""

import io
import sys
from collections.abc import Sequence
from typing import Annotated

import typer

from kousoku import __version__
from kousoku.cli.animate import animate
from kousoku.cli.cache import cache
from kousoku.cli.check import check
from kousoku.cli.console import BAD_INPUT, INTERRUPTED
from kousoku.cli.derive import derive
from kousoku.cli.explain import explain
from kousoku.cli.generate import generate
from kousoku.cli.ledger import ledger
from kousoku.cli.listing import list_names
from kousoku.cli.new import new
from kousoku.cli.schema import schema
from kousoku.cli.simulate import simulate
from kousoku.cli.solve import solve
from kousoku.cli.verify import verify
from kousoku.cli.wording import as_typed
from kousoku.model.errors import KousokuError

app = typer.Typer(
    name="kousoku",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)


def _print_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"kousoku {__version__}")
        raise typer.Exit


@app.callback()
def _kousoku(
    version: Annotated[
        bool,
        typer.Option(
            "--version", callback=_print_version, is_eager=True, help="Print the version."
        ),
    ] = False,
) -> None:
    """Derive constraint equations, emit them as NumPy and C, verify what was emitted, solve.

    Exit codes: 0 all is well, 1 emitted code or a proof disagrees with what was derived, 2 bad
    input, 3 a motion that stopped or cannot be trusted, 130 Ctrl-C.
    """


app.command("derive")(derive)
app.command("generate")(generate)
app.command("verify")(verify)
app.command("new")(new)
app.command("check")(check)
app.command("schema")(schema)
app.command("explain")(explain)
app.command("solve")(solve)
app.command("simulate")(simulate)
app.command("animate")(animate)
app.command("ledger")(ledger)
app.command("list")(list_names)
app.command("cache")(cache)


def main(arguments: Sequence[str] | None = None) -> None:
    """Run one command; every expected error is one message on stderr and an exit code."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal without Greek letters still gets text
    try:
        app(args=arguments)
    except (KousokuError, OSError) as error:
        print(f"kousoku: {as_typed(str(error))}", file=sys.stderr)
        raise SystemExit(BAD_INPUT) from None
    except KeyboardInterrupt:
        raise SystemExit(INTERRUPTED) from None
