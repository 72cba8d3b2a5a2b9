"""The errors that a user can meet, one class for each stage."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from typing import Self

MOST_SHOWN = 20
"""Problems of a scene that a message shows; all are in the error."""

MOST_FOUND = 200
"""Problems after which the checks of a scene end."""


class KousokuError(Exception):
    """Base of all errors that kousoku raises on purpose; the message says what to do."""


@dataclass(frozen=True, slots=True)
class Problem:
    """One thing that is wrong with a scene.

    Parameters
    ----------
    problem : str
        What is wrong, what was wanted, and what to do.
    key : str
        The dotted key, such as ``links.l1.length``; empty where the file as a whole is meant.
    line : int
        The line of the file, 0 where there is none.
    place : str
        The dotted key whose line is meant, where it is not `key`.
    """

    problem: str
    key: str = ""
    line: int = 0
    place: str = ""


class SceneError(KousokuError):
    """A scene file or a built scene is not valid; the message has a line for each problem.

    Parameters
    ----------
    problem : str
        What is wrong first, what was wanted, and what to do.
    file : str, optional
        The scene file.
    key : str, optional
        The dotted key of the first problem, such as ``links.l1.length``.
    problems : sequence of Problem, optional
        All of them, the first included.
    """

    def __init__(
        self, problem: str, *, file: str = "", key: str = "", problems: Sequence[Problem] = ()
    ) -> None:
        self.problem = problem
        self.file = file
        self.key = key
        self.problems = tuple(problems) or (Problem(problem, key),)
        shown = [self._line(entry) for entry in self.problems[:MOST_SHOWN]]
        n_hidden = len(self.problems) - len(shown)
        if n_hidden:
            count = f"{n_hidden} more problem{'s' * (n_hidden > 1)}"
            is_full = len(self.problems) >= MOST_FOUND
            shown.append(self._line(Problem(f"and {'at least ' * is_full}{count}")))
        super().__init__("\n".join(shown))

    @classmethod
    def of(cls, problems: Sequence[Problem], *, file: str = "") -> Self:
        """Error of one problem or more."""
        return cls(problems[0].problem, file=file, key=problems[0].key, problems=problems)

    def problems_beside(self, broken: Callable[[str], Sequence[str]]) -> Sequence[Problem]:
        """Problems of the error, which may depend on the elements that cannot be used.

        Parameters
        ----------
        broken : callable
            Returns the names of those elements of a table.
        """
        del broken  # a class of errors may depend on it
        return self.problems

    def _line(self, problem: Problem) -> str:
        where = self.file
        if problem.line:
            where = f"{self.file}:{problem.line}" if self.file else f"line {problem.line}"
        return printable(": ".join(part for part in (where, problem.key, problem.problem) if part))


def printable(text: str) -> str:
    """Text as one line: marks that cannot be printed, such as in names, are escaped."""
    return "".join(mark if mark.isprintable() else repr(mark)[1:-1] for mark in text)


class ExpressionError(KousokuError):
    """A formula cannot be read.

    Parameters
    ----------
    problem : str
        What is wrong, and what was wanted.
    column : int
        Where in the formula, counted from 1.
    """

    def __init__(self, problem: str, *, column: int) -> None:
        self.problem = problem
        self.column = column
        super().__init__(f"column {column}: {problem}")


class DerivationError(KousokuError):
    """A kind is unknown, or its derivation does not end in a linear form."""


class FreezeError(KousokuError):
    """An expression holds something that the graph cannot represent."""


class EmitError(KousokuError):
    """A program cannot be emitted for a target."""


class LoadError(KousokuError):
    """A generated folder or its compiled library cannot be loaded."""


class CompilerError(LoadError):
    """The C compiler is missing or refused the source; its own output is part of the message."""


class NoCompilerError(CompilerError):
    """There is no C compiler that works, or ``KOUSOKU_CC=none``; the NumPy kernels need none."""


class TargetError(LoadError):
    """There is no such target, or the folder was generated without it."""


class CacheError(LoadError):
    """The cache of compiled libraries cannot be written: it is full, read-only or not ours."""


class VerifyError(KousokuError):
    """Emitted code does not compute what was derived."""


class SolveError(KousokuError):
    """A scene cannot be assembled or moved; what was computed is kept by the caller."""


class AssemblyError(SolveError):
    """A mechanism does not fit together; the message names its joints or links, and by how much.

    Parameters
    ----------
    problem : str
        What does not fit, by how much, and what to do.
    keys : sequence of str, optional
        The dotted keys of the joints and drivers that it names, the worst first.
    """

    def __init__(self, problem: str, keys: Sequence[str] = ()) -> None:
        self.problem = problem
        self.keys = tuple(keys)
        super().__init__(problem)

    def at(self, file: str, lines: Mapping[str, int]) -> AssemblyError:
        """Error with the file, the line of the worst joint, and the line of each key behind it.

        Parameters
        ----------
        file : str
            The scene file.
        lines : mapping of str to int
            The lines of keys.
        """
        text = self.problem
        for key in self.keys:
            if key in lines:
                text = re.sub(
                    rf"(?<![\w.]){re.escape(key)}(?![\w.])",
                    rf"\g<0> (line {lines[key]})",
                    text,
                    count=1,
                )
        first = next((f":{lines[key]}" for key in self.keys if key in lines), "")
        return AssemblyError(f"{file}{first}: {text}", self.keys)


class MotionError(SolveError):
    """A motion cannot be continued.

    Parameters
    ----------
    problem : str
        Where it stopped, what holds it, and what to do.
    result : kousoku.runtime.integrate.result.Result
        All good rows up to there.
    """

    def __init__(self, problem: str, result: Any) -> None:
        self.result = result
        super().__init__(problem)

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (str(self), self.result)  # a pool of processes hands it on


class NotInResultError(KousokuError, KeyError):
    """There is no such name; the message says which there are, or how to get it."""

    def __str__(self) -> str:
        return str(self.args[0])


class LedgerError(KousokuError):
    """A statement of the ledger is not what its entry claims, or there is no such entry."""


class FormulaError(LedgerError):
    """A printed formula cannot be read, or what it says cannot be formed."""
