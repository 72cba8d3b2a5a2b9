"""The command ``kousoku``: its sub-commands, and how errors become exit codes."""

import io
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from kousoku.cli.animate import animate
from kousoku.cli.cache import cache
from kousoku.cli.check import check
from kousoku.cli.console import BAD_INPUT, INTERRUPTED, UNREAD
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
from kousoku.cli.wording import as_typed, refused
from kousoku.model.errors import KousokuError
from kousoku.model.version import __version__


def _discard() -> None:
    """Discard the rest of the buffer: it would be written, in vain, when Python ends."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _is_lost() -> bool:
    """Whether output cannot be written: not even the end of a line."""
    try:
        os.write(sys.stdout.fileno(), b"\n")
    except OSError:
        return True
    return False


@contextmanager
def _until_unread() -> Iterator[None]:
    """Leave where a reader has seen enough, as ``head`` does: no disagreement, which 1 would be.

    A disk that is full has no name in its error where what is printed goes there.
    """
    try:
        yield
        sys.stdout.flush()
    except BrokenPipeError:
        _discard()
        raise typer.Exit(UNREAD) from None
    except OSError as error:
        if error.filename is not None or not _is_lost():
            raise
        _discard()
        raise KousokuError(f"standard output: cannot be written: {error.strerror}") from None


class _Commands(TyperGroup):
    def make_context(self, *arguments: Any, **extra: Any) -> Any:
        with _until_unread():  # --help is printed here
            return super().make_context(*arguments, **extra)

    def invoke(self, ctx: Any) -> Any:
        with _until_unread():
            try:
                return super().invoke(ctx)
            except typer.BadParameter as error:
                error.message = refused(error)
                raise


app = typer.Typer(
    name="kousoku",
    cls=_Commands,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)


def _print_version(is_asked: bool) -> None:
    if is_asked:
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
    """Move mechanisms with closed loops; derive, emit and verify the equations that move them.

    Exit codes: 0 all is well, 1 emitted code or a proof disagrees with what was derived, 2 bad
    input, 3 a motion that stopped or cannot be trusted, 130 Ctrl-C, 141 a pipe that was closed.
    """


#: The commands, as a newcomer meets them, with a line each that no terminal cuts off.
COMMANDS: tuple[tuple[str, Callable[..., None], str], ...] = (
    ("new", new, "Write a commented scene that moves, to begin with."),
    ("check", check, "Tell all that is wrong with scene files."),
    ("simulate", simulate, "Move a mechanism in time."),
    ("solve", solve, "Solve a driven mechanism at the divisions of its inputs."),
    ("animate", animate, "Show a mechanism that moves on a page of its own."),
    ("list", list_names, "List what a scene may have; or the generated packages."),
    ("explain", explain, "Say what the solver of a scene leaves out, and saves."),
    ("derive", derive, "Derive a kind of constraints, step by step."),
    ("generate", generate, "Write NumPy and C for kinds and scenes."),
    ("verify", verify, "Check emitted code against values of 50 digits."),
    ("ledger", ledger, "List the equations of the lectures, and what is true."),
    ("schema", schema, "Print the JSON schema of scenes, or of answers."),
    ("cache", cache, "Show or clear what was generated and compiled before."),
)
for _name, _command, _line in COMMANDS:
    app.command(_name, short_help=_line)(_command)


def error_text(error: KousokuError | OSError) -> str:
    """Text of an expected error, which begins with its place: for one of the system, a path."""
    if isinstance(error, OSError) and isinstance(error.filename, str) and error.filename2 is None:
        return f"{error.filename}: {error.strerror}"
    return str(error)


def main(arguments: Sequence[str] | None = None) -> None:
    """Run one command; every expected error is one message on stderr and an exit code."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal without Greek letters still gets text
    try:
        app(args=arguments)
    except (KousokuError, OSError) as error:
        print(f"kousoku: {as_typed(error_text(error))}", file=sys.stderr)
        raise SystemExit(BAD_INPUT) from None
    except KeyboardInterrupt:
        raise SystemExit(INTERRUPTED) from None
