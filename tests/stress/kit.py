"""The kit of the stress suite: questions, their cases, and what a case measured and found.

A question is a module beside this one that names one :class:`Question` ``QUESTION``. Its cases are
named by texts, and the same name always does the same, so that a run can be cut and resumed, and a
case that found something is repeated by one command.
"""

from __future__ import annotations

import math
import time
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import hypothesis
from hypothesis import HealthCheck, Phase, settings

from tests.stress import smaller

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator
    from contextlib import AbstractContextManager

    from hypothesis.strategies import SearchStrategy

T = TypeVar("T")

ROOT = Path(__file__).parents[2]
BUILD = ROOT / "build" / "stress"
"""Journals, findings and the page of a run."""


class Disagreement(AssertionError):
    """What a check raises when kousoku and what it is compared with do not agree."""


@dataclass(frozen=True, slots=True)
class Size:
    """How much of a question is asked.

    Parameters
    ----------
    is_full : bool
        Some hours instead of two minutes for all questions together.
    seed : int
        The seed of all that is random.
    count : int, optional
        How many random examples, instead of the question's own choice (``N=``).
    """

    is_full: bool = False
    seed: int = 1
    count: int | None = None

    def examples(self, quick: int, full: int) -> int:
        """Number of random examples: what was asked for, or the question's own."""
        if self.count is not None:
            return self.count
        return self.fixed(quick, full)

    def fixed(self, quick: int, full: int) -> int:
        """Number that is the question's own, such as that of steps of a motion."""
        return full if self.is_full else quick


@dataclass(slots=True)
class Worst:
    """The largest value of a figure, and where it was measured."""

    value: float
    place: str


def keep_worst(
    known: dict[str, Worst], name: str, value: float, place: str, *, of: str = ""
) -> None:
    """Keep the larger one of the value that is known under a name and another one."""
    if not (of or name).endswith(")"):
        raise ValueError(f"the figure {of or name!r} has no unit in parentheses")
    key = math.inf if math.isnan(value) else value
    if name not in known or key > known[name].value:
        known[name] = Worst(key, place)


@dataclass(slots=True)
class Finding:
    """Something that must not be: wrong, lost, silent, or worse than the page allows.

    Parameters
    ----------
    title : str
        What is wrong, in a line; the same words for the same fault, which is told once.
    details : str
        Where and by how much.
    command : str
        A command that shows it, in the folder of the finding.
    files : dict of str
        The texts of files that the command needs, by their names: a minimal scene.
    """

    title: str
    details: str = ""
    command: str = ""
    files: dict[str, str] = field(default_factory=dict)


@dataclass(slots=True)
class Outcome:
    """What a case measured, counted and found."""

    figures: dict[str, Worst] = field(default_factory=dict)
    counts: dict[str, int] = field(default_factory=dict)
    findings: list[Finding] = field(default_factory=list)
    tables: dict[str, dict[str, dict[str, Worst]]] = field(default_factory=dict)

    def measure(self, figure: str, value: float, place: str, limit: float = math.inf) -> None:
        """Keep the largest value of a figure; one beyond its limit is a finding.

        Parameters
        ----------
        figure : str
            What is measured, with its unit in parentheses at the end: a row of the page.
        value : float
            The value. NaN is larger than every number.
        place : str
            Where it was measured: the point, the scene, the seed.
        limit : float
            The largest value that is right.

        Raises
        ------
        ValueError
            The figure has no unit.
        """
        keep_worst(self.figures, figure, value, place)
        if not value <= limit:
            self.find(f"{figure} is above {limit:g}", f"{value:.3g}; {place}")

    def tabulate(self, table: str, row: str, column: str, value: float, place: str) -> None:
        """Keep the largest value of a cell of a table.

        Parameters
        ----------
        table : str
            What is measured, with its unit in parentheses at the end: a table of the page.
        row, column : str
            Of the cell; the page has both in the order of their texts.
        value : float
            The value. NaN is larger than every number.
        place : str
            Where it was measured; the page of a run of many cases has the case instead.

        Raises
        ------
        ValueError
            The table has no unit.
        """
        cells = self.tables.setdefault(table, {}).setdefault(row, {})
        keep_worst(cells, column, value, place, of=table)

    def count(self, what: str, number: int = 1) -> None:
        """Add to a count: a row of the page."""
        self.counts[what] = self.counts.get(what, 0) + number

    def find(self, title: str, details: str = "", command: str = "", **files: str) -> None:
        """Add a finding; a dot in the name of a file is written as two underscores."""
        named = {name.replace("__", "."): text for name, text in files.items()}
        self.findings.append(Finding(title, details, command, named))

    def add(self, other: Outcome) -> None:
        """Add what another case measured, counted and found."""
        for figure, worst in other.figures.items():
            self.measure(figure, worst.value, worst.place)
        for table, row, column, worst in other.cells():
            self.tabulate(table, row, column, worst.value, worst.place)
        for what, number in other.counts.items():
            self.count(what, number)
        self.findings += other.findings

    def cells(self) -> Iterator[tuple[str, str, str, Worst]]:
        """Cells of all tables: the table, the row, the column, and what stands there."""
        for table, rows in self.tables.items():
            for row, cells in rows.items():
                for column, worst in cells.items():
                    yield table, row, column, worst

    def as_dict(self) -> dict[str, Any]:
        """Outcome as JSON has it."""
        return asdict(self)

    @classmethod
    def from_dict(cls, data: dict[str, Any]) -> Outcome:
        """Outcome that :meth:`as_dict` wrote."""
        return cls(
            {figure: Worst(**worst) for figure, worst in data["figures"].items()},
            data["counts"],
            [Finding(**finding) for finding in data["findings"]],
            {
                table: {
                    row: {c: Worst(**x) for c, x in cells.items()} for row, cells in rows.items()
                }
                for table, rows in data["tables"].items()
            },
        )


@dataclass(frozen=True, slots=True)
class Fault:
    """A mistake that is planted to show that a question finds it.

    Parameters
    ----------
    about : str
        What is made wrong.
    plant : callable
        Returns a context in which this process computes wrongly.
    case : str
        A case that then finds something, and without the fault finds nothing new.
    finds : str
        How the title of what it then finds begins, where only some findings are of the fault.
    """

    about: str
    plant: Callable[[], AbstractContextManager[object]]
    case: str
    finds: str = ""


@dataclass(frozen=True, slots=True)
class Question:
    """One way to look for what breaks kousoku.

    Parameters
    ----------
    asks : str
        What is asked, and what is measured: the first sentence of its part of the page. How much of
        it a run asked its counts say.
    cases : callable
        Returns the names of the cases for a :class:`Size`.
    run : callable
        Runs a case by its name, in a process of its own for cases, with a cache that all share.
    faults : tuple of Fault
        Mistakes that it is shown to find.
    known : dict of str
        Titles of findings, or how they begin, that are known and why they are not mended; they
        stand on the page and do not fail the run.
    seconds : float
        The longest time a case may take; one that takes longer is a finding.
    in_full : str
        What only the full size asks, in words that follow "the full size asks".
    needs_compiler : bool
        Whether its cases are not run, but counted, where no compiler is in reach.
    """

    asks: str
    cases: Callable[[Size], Iterable[str]]
    run: Callable[[str], Outcome]
    faults: tuple[Fault, ...]
    known: dict[str, str] = field(default_factory=dict)
    seconds: float = 600.0
    in_full: str = ""
    needs_compiler: bool = False

    def reason_of(self, finding: Finding) -> str | None:
        """Reason why a finding is known and not mended; None for a new one."""
        found = (why for title, why in self.known.items() if finding.title.startswith(title))
        return next(found, None)


def falsify(
    strategy: SearchStrategy[T], check: Callable[[T], object], *, seed: int, examples: int
) -> tuple[T, Exception] | None:
    """Smallest example that a check refuses, and what it says; None if it takes all.

    It is made smaller for as long as a scene is: later examples count as taken.

    Parameters
    ----------
    strategy : SearchStrategy
        Hypothesis' description of the examples.
    check : callable
        Raises :class:`Disagreement`, or anything that kousoku must not raise.
    seed : int
        The same one gives the same examples in a process that has loaded the same modules:
        Hypothesis draws numbers and texts of theirs, too.
    examples : int
        How many are tried.
    """
    refused: list[tuple[T, Exception]] = []
    last = math.inf

    @hypothesis.seed(seed)
    @settings(
        max_examples=examples,
        database=None,
        deadline=None,
        suppress_health_check=list(HealthCheck),
        phases=(Phase.generate, Phase.shrink),
        print_blob=False,
        report_multiple_bugs=False,
    )
    @hypothesis.given(strategy)
    def every_example_is_taken(example: T) -> None:
        nonlocal last
        if time.monotonic() >= last:
            return
        try:
            check(example)
        except Exception as error:
            refused.append((example, error))
            last = min(last, time.monotonic() + smaller.MOST_SECONDS)
            raise

    try:
        every_example_is_taken()
    except Exception:
        # Hypothesis runs the smallest example last, and is at odds with those that count as taken.
        if not refused:
            raise
        return refused[-1]
    return None
