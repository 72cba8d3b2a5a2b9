"""Messages: names, lists and values as one line has them, and the errors that carry them.

It needs nothing but the standard library: a copy goes along with each solver that is generated.
"""

from __future__ import annotations

from contextlib import suppress
from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

#: Characters of a value, and names, that a message shows at most.
MOST_CHARACTERS_SHOWN, MOST_NAMES_SHOWN = 60, 6
#: Parts of a scene that a line about a run names at most.
MOST_PARTS_SHOWN = 3


class MissingError(KeyError):
    """A result has no such name, where kousoku is not installed."""

    def __str__(self) -> str:
        return str(self.args[0])


class StoppedError(ArithmeticError):
    """A motion that cannot go on, where kousoku is not installed.

    Parameters
    ----------
    problem : str
        Where it stopped, and why.
    result : Result
        What was computed up to there.
    """

    def __init__(self, problem: str, result: object) -> None:
        self.result = result
        super().__init__(problem)

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (str(self), self.result)  # a pool of processes hands it on


def refusal(
    text: str, kind: str = "SolveError", *more: object, alone: type[Exception] = ValueError
) -> Exception:
    """Error of kousoku, which may take more; where that is not installed another one."""
    try:
        error: Exception = getattr(import_module("kousoku.model.errors"), kind)(text, *more)
    except ModuleNotFoundError:
        return alone(text, *more) if alone is StoppedError else alone(text)
    return error


def missing(text: str) -> Exception:
    """``KeyError`` of a name that there is not."""
    return refusal(text, "NotInResultError", alone=MissingError)


def require_folder(path: Path) -> None:
    """Refuse a file whose folder is missing: a folder that was misspelt is not made.

    Raises
    ------
    kousoku.model.errors.SolveError
        The message names the folder; without ``kousoku`` a ``ValueError``.
    """
    with suppress(OSError):  # a name that is too long is told by who writes
        if not path.absolute().parent.is_dir():
            raise refusal(f"{path}: there is no folder {path.parent}; make it first")


def unknown(what: str, name: object, known: Sequence[str]) -> str:
    """Say that there is no such parameter or option, and which ones there are."""
    of = "its formulas have" if what == "parameter" else "there are"
    if not known:
        return f"no {what} {shown(name)}: {of} none"
    return f"no {what} {shown(name)}: {of} {', '.join(known)}{near(name, known)}"


def near(name: object, known: Sequence[str]) -> str:
    """End of a message that asks for the known name nearest to one, or nothing."""
    from difflib import get_close_matches

    found = get_close_matches(str(name), known, n=1)
    return f"; did you mean {found[0]!r}?" if found else ""


def not_generated(what: str, output: str) -> str:
    """Say which output something comes with that was not generated."""
    return f'no {what}: generated without "{output}"; load(..., outputs=[..., "{output}"])'


def listed(names: Sequence[str], most: int = MOST_NAMES_SHOWN) -> str:
    """Names as a line tells them, not more than so many."""
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return ", ".join(names[:most]) + more


def shown(value: object) -> str:
    """Value as a message shows it: in one line that is not too long."""
    try:
        text = " ".join(repr(value).split())
    except ValueError:  # a whole number of thousands of digits
        text = "a number of very many digits"
    most = MOST_CHARACTERS_SHOWN
    return text if len(text) <= most else f"{text[:most]}…"


def shortly(number: float, digits: int = 1) -> str:
    """Number with so many digits, as in 6e-9."""
    mantissa, e, exponent = f"{number:.{digits}g}".partition("e")
    return f"{mantissa}e{int(exponent)}" if e else mantissa


def scene_key(name: str) -> str:
    """Key in the scene of what rows are named after; that of a driver is its name."""
    return name if "." in name else f"joints.{name}"
