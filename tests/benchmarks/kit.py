"""The kit of the benchmarks: questions, their contests and cases, and what was measured.

A question is a module beside this one that names one :class:`Question` ``QUESTION``. A contest is
named by a text; its cases run in turn, and its records are kept together, so that a run which was
cut goes on with the next contest.
"""

from __future__ import annotations

import math
import os
import signal
import statistics
import time
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from importlib import import_module
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:
    import subprocess
    from collections.abc import Callable, Mapping, Sequence
    from pathlib import Path

    from tests.benchmarks.race import Workers

Kind = Literal["kousoku", "scene", "equations", "reduced"]
"""Who made the equations: kousoku or a peer, from the scene; a person, of index 1 or 3 with all
bodies, or reduced by hand to as few coordinates as there are freedoms."""

#: What is printed beside a line of a tool.
KINDS: dict[Kind, str] = {
    "kousoku": "from the scene",
    "scene": "from the scene",
    "equations": "equations given",
    "reduced": "reduced by hand",
}
#: Seconds that a case runs in a round, most rounds, and the most seconds for all rounds of a case.
SLICE, ROUNDS, SPENT = 0.02, 7, 1.0


class PeerMissingError(Exception):
    """A program to compare with is not installed; the text says what to install."""


def required(name: str, install: str = "pip install 'kousoku[bench]'") -> Any:
    """Import a peer.

    Raises
    ------
    PeerMissingError
        It is not installed.
    """
    try:
        found = import_module(name)
        if getattr(found, "__file__", None) is None:  # what a package that is removed may leave
            raise ImportError(f"{name} is a folder without modules")
    except ImportError as error:
        raise PeerMissingError(f"{name.partition('.')[0]} ({error}); {install}") from error
    return found


@dataclass(frozen=True, slots=True)
class Size:
    """How much is measured.

    Parameters
    ----------
    is_full : bool
        An hour instead of three minutes.
    """

    is_full: bool = False


@dataclass(frozen=True, slots=True)
class Judged:
    """Verdict on the result of a case.

    Parameters
    ----------
    error : float or None
        What the time bought; None where there is nothing to compare with.
    extra : dict of float
        Other columns, such as the error of reactions or the number of steps.
    """

    error: float | None = None
    extra: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Call:
    """A case that is set up.

    Parameters
    ----------
    run : callable
        What is timed: one call, from the start to the end.
    judge : callable
        Says what the result is worth; runs after the trial, is not timed, and may run it again.
    count : int
        How many evaluations, steps or others one call makes: times are divided by it.
    """

    run: Callable[[], object]
    judge: Callable[[], Judged] = Judged
    count: int = 1


@dataclass(frozen=True, slots=True)
class Case:
    """One program at one setting.

    Parameters
    ----------
    tool : str
        Whose program; all cases of a tool share a process.
    line : str
        What the settings vary: one line of a plot.
    setting : str
        The tolerance, the step.
    kind : str
        Who made the equations, see :data:`KINDS`.
    prepare : callable
        Sets it up, in the process of the tool.
    """

    tool: str
    line: str
    setting: str
    kind: Kind
    prepare: Callable[[], Call]


@dataclass(slots=True)
class Record:
    """Record of a case: its time, and its errors.

    Parameters
    ----------
    contest, tool, line, setting, kind : str
        Which case.
    fastest, median : float or None [s]
        Of the rounds, per unit of the call; None where it did not run to its end.
    rounds : int
        How many; 1 where it ran once only, since it is long.
    error : float or None
        What that bought.
    note : str
        Why there is no time: ``"> 30 s"``, what is missing, or how it failed.
    extra : dict of float
        Other columns; ``setup`` [s] is what its preparation took.
    """

    contest: str
    tool: str
    line: str
    setting: str
    kind: Kind = "kousoku"
    fastest: float | None = None
    median: float | None = None
    rounds: int = 0
    error: float | None = None
    note: str = ""
    extra: dict[str, float] = field(default_factory=dict)

    def as_dict(self) -> dict[str, Any]:
        """Record as JSON has it, which knows no infinity: its text instead."""
        return {name: _plain(value) for name, value in asdict(self).items()}

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Record:
        """Record that :meth:`as_dict` wrote."""
        extra = {name: float(value) for name, value in data["extra"].items()}
        error = None if data["error"] is None else float(data["error"])
        return cls(**{**data, "extra": extra, "error": error})


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    return str(value) if isinstance(value, float) and not math.isfinite(value) else value


@dataclass(frozen=True, slots=True)
class BenchmarkTarget:
    """Target that ``--check`` judges and the page states.

    Parameters
    ----------
    contest, quantity : str
        What was measured.
    value : float or None
        What came out; None where it could not be measured, which misses the target.
    limit : float
        The most it may be.
    """

    contest: str
    quantity: str
    value: float | None
    limit: float

    @property
    def is_met(self) -> bool:
        """Whether it was measured and is small enough."""
        return self.value is not None and self.value <= self.limit

    def __str__(self) -> str:
        got = "not measured" if self.value is None else f"{self.value:.3g}"
        return f"{self.contest}: {self.quantity} is {got}, wanted at most {self.limit:.3g}"


@dataclass(frozen=True, slots=True)
class Figures:
    """Where the plots of a page go.

    Parameters
    ----------
    folder : Path
        Of the files.
    link : str
        The folder as the page names it.
    """

    folder: Path
    link: str

    def add(self, name: str, svg: str, caption: str) -> str:
        """Write a plot and return the Markdown that shows it."""
        self.folder.mkdir(parents=True, exist_ok=True)
        (self.folder / f"{name}.svg").write_text(svg, encoding="utf-8")
        return f"![{caption}]({self.link}/{name}.svg)"


@dataclass(frozen=True, slots=True)
class Question:
    """One thing to measure.

    Parameters
    ----------
    title, asks : str
        The heading of its part of the page, and what stands below: what is measured, and how.
    contests : callable
        Returns the names of the contests for a :class:`Size`.
    cases : callable
        Returns the cases of a contest, always the same ones; it is called in every process that
        runs one, and imports no peer. Cases of one line stand in the order of their cost.
    body : callable
        Returns the tables and plots of all records as Markdown.
    targets : callable
        Returns what the page promises, judged by all records.
    words : callable
        Returns sentences or lists for the head of the page: where kousoku wins and loses.
    run : callable, optional
        Measures a contest in another way than by a race of its cases.
    seconds : float
        The longest time of a contest; cases that have not begun by then are left out and say so.
    """

    title: str
    asks: str
    contests: Callable[[Size], Sequence[str]]
    cases: Callable[[str, Size], list[Case]]
    body: Callable[[Sequence[Record], Figures], str]
    targets: Callable[[Sequence[Record]], list[BenchmarkTarget]] = lambda _: []
    words: Callable[[Sequence[Record]], str] = lambda _: ""
    run: Callable[[str, Size, Workers], list[Record]] | None = None
    seconds: float = 150.0


def matches(word: str, *names: str) -> bool:
    """Whether one of the names has a word."""
    return any(word.casefold() in name.casefold() for name in names)


def end_group(process: subprocess.Popen[str]) -> None:
    """End a process that has a session of its own, and all that it started."""
    if process.poll() is None and os.name == "posix":
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
    process.kill()
    process.communicate()


def seconds_of(run: Callable[[], object], count: int = 1) -> float:
    """Seconds of so many calls."""
    start = time.perf_counter()
    for _ in range(count):
        run()
    return time.perf_counter() - start


def rounds_of(seconds: float) -> int:
    """Number of rounds of a case that takes so long: none where its trial has to do."""
    return min(ROUNDS, int(SPENT / max(seconds, SLICE)))


def slice_of(run: Callable[[], object], seconds: float) -> float:
    """Seconds of a call in one round, where a call takes about so long."""
    count = max(1, int(SLICE / max(seconds, 1e-9)))
    if count > 1:
        seconds_of(run, count // 4 + 1)  # its own data are in the caches again
    return seconds_of(run, count) / count


def interleave(
    runs: Mapping[str, Callable[[], object]], rounds: int = ROUNDS
) -> dict[str, list[float]]:
    """Seconds of a call in each round of each program, the programs in turn.

    It is for programs that share this process; :func:`tests.benchmarks.race.race` runs others in
    turn.
    """
    about = {name: min(seconds_of(run) for _ in range(3)) for name, run in runs.items()}
    times: dict[str, list[float]] = {name: [] for name in runs}
    for _ in range(rounds):
        for name, run in runs.items():
            times[name].append(slice_of(run, about[name]))
    return times


def fastest_and_median(times: Sequence[float], count: int = 1) -> tuple[float, float]:
    """Both per unit of a call."""
    return min(times) / count, statistics.median(times) / count


def number(value: float | None, digits: int = 2) -> str:
    """Number as tables have it."""
    if value is None or math.isnan(value):
        return "–"
    return f"{value:.{digits - 1}e}" if value and not 1e-3 <= abs(value) < 1e4 else f"{value:.3g}"


def duration(seconds: float | None) -> str:
    """Time with its unit, of three digits."""
    if seconds is None:
        return "–"
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("µs", 1e-6)):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds * 1e9:.3g} ns"


def bullet_list(lead: str, items: Sequence[str]) -> str:
    """Paragraph in Markdown: one sentence, its parts as a list."""
    return f"{lead}\n- " + ";\n- ".join(items) + "."


def table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Table in Markdown."""
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join(f"| {' | '.join(cell.replace('|', ', ') for cell in row)} |" for row in lines)
