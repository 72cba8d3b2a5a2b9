"""The command of the stress suite: ``make stress``, or ``python -m tests.stress``.

It asks all questions, or those named, in as many processes as there are processors; writes each
case into a journal as it ends, so that a run that was cut goes on; prints the figures; and exits
with 1 when something new was found.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import pkgutil
import platform
import re
import shutil
import subprocess
import sys
import tempfile
import time
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial
from importlib import import_module
from itertools import chain
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
from rich.progress import Progress

from kousoku.model.errors import CompilerError
from kousoku.model.files.cache import write_atomically
from kousoku.runtime.toolchain import find_toolchain
from tests import stress
from tests.stress import smaller
from tests.stress.journal import digest_of, done_in, is_on, page_in
from tests.stress.kit import BUILD, ROOT, Finding, Outcome, Question, Size, Worst
from tests.stress.workers import Answered, StoppedError, processor, run_case, run_cases

NO_QUESTIONS = {"__main__", "journal", "kit", "workers"}
SOURCES = (
    *(
        "codegen",
        "generated",
        "kousoku",
        "ledger",
        "model",
        "runtime",
        "scenes",
        "symbolic",
        "tests",
    ),
)
OPTIONS = ("FULL", "N", "ONLY", "PAGE", "SEED")
"""What the environment says in place of options."""


@dataclass(slots=True)
class Answer:
    """What all cases of a question measured, counted and found."""

    outcome: Outcome = field(default_factory=Outcome)
    cases: int = 0
    seconds: float = 0.0
    slowest: tuple[float, str] = (0.0, "")

    def add(self, case: str, outcome: Outcome, seconds: float, command: str = "") -> None:
        """Add a case; what it found without a command of its own, this one shows.

        So are places of its tables: of so many rows each has a case instead.
        """
        own = [replace(one, command=one.command or command) for one in outcome.findings]
        self.outcome.add(replace(outcome, findings=own, tables={}))
        for table, row, column, worst in outcome.cells():
            self.outcome.tabulate(table, row, column, worst.value, case if command else worst.place)
        self.cases += 1
        self.seconds += seconds
        self.slowest = max(self.slowest, (seconds, case))


def questions() -> dict[str, Question]:
    """Questions by the names of their modules."""
    names = sorted(module.name for module in pkgutil.iter_modules(stress.__path__))
    modules = {
        name: import_module(f"tests.stress.{name}") for name in names if name not in NO_QUESTIONS
    }
    return {name: one.QUESTION for name, one in modules.items() if hasattr(one, "QUESTION")}


def journal_of(size: Size) -> Path:
    """Journal of a run: another one for other sources."""
    run = size.is_full, size.seed, machine()
    return BUILD / f"{digest_of(run, SOURCES, _is_source)}.jsonl"


def _is_source(path: Path) -> bool:
    # What is said of results changes none: a run that took hours is kept when they are answered.
    is_said = path.name in {"mutants_answered.py", "page.md.jinja"}
    return "__pycache__" not in path.parts and not is_said


def command_of(name: str, case: str) -> str:
    """Command that asks a case alone."""
    return f"python -m tests.stress {name} --case '{case}'"


def stopped(error: StoppedError, case: str) -> Outcome:
    """Outcome of a case that did not end by itself: that is a finding."""
    return Outcome(findings=[Finding(f"case {case}: {error}")])


def ask(
    chosen: dict[str, Question], size: Size, journal: Path, processes: int
) -> tuple[dict[str, Answer], float]:
    """Run the cases of questions that the journal does not have.

    Returns
    -------
    answers : dict of Answer
        Of all cases.
    seconds : float
        What these cases took on the clock, in this run and those that it goes on from [s].
    """
    start, before = time.monotonic(), 0.0
    last = start  # when the case before ended: times between them add up to that of the run
    answers: dict[str, Answer] = {name: Answer() for name in chosen}
    cases = [(name, case) for name, question in chosen.items() for case in question.cases(size)]
    left = dict.fromkeys(cases)
    for done in done_in(journal):
        name, case = done["question"], done["case"]
        if (name, case) in left:
            del left[name, case]
            before += done["clock"]
            outcome = Outcome.from_dict(done["outcome"])
            answers[name].add(case, outcome, done["seconds"], command_of(name, case))
    print(f"seed {size.seed}: {len(cases)} cases, {len(cases) - len(left)} of them asked before")
    journal.parent.mkdir(parents=True, exist_ok=True)
    longest = {name: question.seconds for name, question in chosen.items()}
    with journal.open("a", encoding="utf-8") as written, Progress() as progress:
        written.write("\n")  # ends a line that was cut; an empty one is no case
        bar = progress.add_task("stress", total=len(cases), completed=len(cases) - len(left))
        for (name, case), answered in run_cases(left, longest, processes):
            if isinstance(answered, StoppedError):  # tried again when the run goes on
                answers[name].add(case, stopped(answered, case), 0.0, command_of(name, case))
            else:
                outcome, took = answered
                answers[name].add(case, outcome, took, command_of(name, case))
                now = time.monotonic()
                done = {"question": name, "case": case, "outcome": outcome.as_dict()}
                written.write(json.dumps(done | {"seconds": took, "clock": now - last}) + "\n")
                written.flush()
                last = now
            progress.update(bar, advance=1, description=f"{name} {case}"[:40])
    return answers, before + time.monotonic() - start


def machine() -> str:
    """Machine and what kousoku runs on there, in words."""
    return (
        f"{processor()}, {os.cpu_count()} processors, {platform.system()},"
        f" Python {platform.python_version()}, NumPy {np.__version__}, {compiler()}"
    )


def compiler() -> str:
    """Version of the compiler that kousoku takes here, if it takes one."""
    try:
        return find_toolchain().name
    except CompilerError:
        return "no compiler"


def commit() -> str:
    """Commit of the checkout, "with changes" where files differ from it; "" where git knows none.

    A repository that the checkout merely lies in is not asked.
    """
    ceiling = {"GIT_CEILING_DIRECTORIES": str(ROOT.resolve().parent)}
    words = ("describe", "--always", "--exclude=*", "--abbrev=10", "--dirty= with changes")
    try:
        done = subprocess.run(
            ["git", *words],
            cwd=ROOT,
            env={**os.environ, **ceiling},
            capture_output=True,
            text=True,
            check=True,
        )
    except (OSError, subprocess.CalledProcessError):
        return ""
    return done.stdout.strip()


def page_of(
    chosen: dict[str, Question], answers: dict[str, Answer], size: Size, seconds: float
) -> str:
    """Page of a run, which took so long on the clock, in Markdown."""
    parts = []
    for name, answer in answers.items():
        question, outcome = chosen[name], answer.outcome
        rows = ((key, f"{worst.value:.3g}", worst.place) for key, worst in outcome.figures.items())
        tables = (table_of(*one) for one in sorted(outcome.tables.items()))
        found = {finding.title: finding for finding in reversed(outcome.findings)}
        parts.append(
            {
                "name": name,
                "asks": question.asks,
                "in_full": question.in_full,
                "cases": answer.cases,
                "slowest": f"{answer.slowest[1]} in {answer.slowest[0]:.1f} s",
                "figures": sorted(rows),
                "tables": [*tables],
                "counts": sorted(outcome.counts.items()),
                "findings": [(one, question.reason_of(one)) for one in found.values()],
                "faults": [fault.about for fault in question.faults],
            }
        )
    took = sum(answer.seconds for answer in answers.values())
    return page_in(Path(__file__).parent).render(
        date=time.strftime("%Y-%m-%d"),
        machine=machine(),
        commit=commit(),
        seed=size.seed,
        size="full" if size.is_full else "quick",
        took=f"{took / 60:.1f} min",
        clock=f"{seconds / 60:.1f} min",
        parts=parts,
    )


def table_of(title: str, rows: dict[str, dict[str, Worst]]) -> dict[str, Any]:
    """Table as the page has it, with the place of the largest value of each row behind it."""
    columns = sorted({column for cells in rows.values() for column in cells})
    lines = []
    for row, cells in sorted(rows.items()):
        shown = (f"{cells[one].value:.3g}" if one in cells else "" for one in columns)
        known = (cells[one] for one in columns if one in cells)
        lines.append((row, *shown, max(known, key=lambda worst: worst.value).place))
    return {"head": (title, *columns, "largest at"), "rows": lines}


def forget(name: str) -> None:
    """Remove what runs before kept of a question's findings."""
    for folder in (BUILD / "findings").glob(f"{name}-*"):
        shutil.rmtree(folder)


def keep(name: str, finding: Finding) -> str:
    """Write the files of a finding, and return its command with their folder."""
    digest = hashlib.sha256(repr((name, finding.title)).encode()).hexdigest()[:8]
    folder = BUILD / "findings" / f"{name}-{digest}"
    for file, text in (finding.files | {"command.txt": finding.command + "\n"}).items():
        folder.mkdir(parents=True, exist_ok=True)
        write_atomically(folder / file, text.encode())
    is_ours = finding.command.startswith("python -m tests.stress")
    place = Path() if is_ours else folder.relative_to(ROOT)
    return f"(cd {place} && {finding.command})" if finding.command else str(place)


def arguments_of(words: list[str] | None) -> argparse.Namespace:
    """Arguments of the command line; the environment is what ``make stress N=…`` sets."""
    given, known = os.environ, questions()
    parser = argparse.ArgumentParser(prog="python -m tests.stress", description=__doc__)
    only = [name for name in given.get("ONLY", "").split(",") if name]
    parser.add_argument("questions", nargs="*", default=only or [*known], metavar="QUESTION")
    try:
        is_full = is_on("FULL")
    except ValueError as error:
        parser.error(str(error))
    parser.add_argument("--full", action="store_true", default=is_full)
    # what the environment says is read as if it stood behind its option
    seed, count, page = (given.get(name) or None for name in ("SEED", "N", "PAGE"))
    parser.add_argument("--seed", type=partial(whole, "SEED", 0), default=seed or 1)
    parser.add_argument("--count", type=partial(whole, "N", 1), default=count)
    parser.add_argument("--page", type=page_at, default=page)
    number = partial(whole, "the number of processes", 1)
    parser.add_argument("--processes", type=number, default=os.cpu_count())
    parser.add_argument("--case", help="run this case alone, in this process, and show its errors")
    number = partial(whole, "the number of a fault", 0)
    parser.add_argument("--plant", type=number, help="plant the fault of this number first")
    arguments = parser.parse_args(words)
    for name in arguments.questions:
        if name not in known:
            parser.error(f"there is no question {name!r}; there are {', '.join(known)}")
    arguments.known = {name: known[name] for name in arguments.questions}
    if problem := problem_of(arguments):
        parser.error(problem)
    return arguments


def whole(name: str, least: int, text: str) -> int:
    """Whole number that an option says."""
    with suppress(ValueError):
        if (number := int(text)) >= least:
            return number
    raise argparse.ArgumentTypeError(f"{name} is {text!r}; wanted a whole number from {least} on")


def page_at(text: str) -> Path:
    """Place of a file that a page can be written to."""
    path = Path(text)
    if path.is_dir() or any(one.is_file() for one in path.parents):
        raise argparse.ArgumentTypeError(f"PAGE is {text!r}; wanted a file, in folders")
    return path


def problem_of(arguments: argparse.Namespace) -> str:
    """Reason why a case or a fault cannot be asked; "" for none."""
    if arguments.case is None and arguments.plant is None:
        return ""
    if len(arguments.questions) != 1:
        return "a case and a fault are those of one question; wanted its name"
    ((name, question),) = arguments.known.items()
    if arguments.plant is not None and arguments.plant >= len(question.faults):
        return f"{name} has {len(question.faults)} faults, 0 to {len(question.faults) - 1}"
    sizes = (Size(is_full, arguments.seed) for is_full in (False, True))
    every = chain(*map(question.cases, sizes), (fault.case for fault in question.faults))
    sorts = dict[str, None]()
    for one in every:
        if arguments.case is None or sort_of(one) == sort_of(arguments.case):
            return ""
        sorts[sort_of(one)] = None
    return f"{arguments.case!r} is no case of {name}; they begin with {', '.join(sorts)}"


def sort_of(case: str) -> str:
    """First word of the name of a case."""
    return re.split(r"[ |,]", case)[0]


def run_here(name: str, question: Question, case: str | None, plant: int | None) -> Answered:
    """Run one case in this process, with a fault when asked for."""
    if plant is None:
        return run_case(name, case or "")
    fault = question.faults[plant]
    with patch.object(smaller, "MOST_SECONDS", smaller.PLANTED_SECONDS), fault.plant():
        return run_case(name, case or fault.case)


def main(words: list[str] | None = None) -> int:
    """Ask questions, and return the exit status."""
    given = arguments_of(words)
    try:
        return answer(given)
    except KeyboardInterrupt:
        is_whole = given.case is None and given.plant is None
        told = "; the same command goes on with the cases that are left" if is_whole else ""
        print(f"interrupted{told}", file=sys.stderr)
        return 130


def answer(given: argparse.Namespace) -> int:
    """Ask the questions that arguments name, and return the exit status."""
    size, seconds = Size(given.full, given.seed, given.count), 0.0
    is_whole = given.case is None and given.plant is None
    with tempfile.TemporaryDirectory(prefix="kousoku-stress-") as cache:
        os.environ.setdefault("KOUSOKU_CACHE", cache)
        # Each processor has a process: more threads for the products of its matrices only wait.
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
        if is_whole:
            answers, seconds = ask(given.known, size, journal_of(size), given.processes)
        else:
            start, answers = time.monotonic(), {name: Answer() for name in given.questions[:1]}
            for name, answer in answers.items():
                outcome, took = run_here(name, given.known[name], given.case, given.plant)
                answer.add(given.case or "", outcome, took)
            seconds = time.monotonic() - start
    page = page_of({name: given.known[name] for name in answers}, answers, size, seconds)
    print(page)
    if is_whole:
        for path in filter(None, (BUILD / "stress.md", given.page)):
            path.parent.mkdir(parents=True, exist_ok=True)
            write_atomically(path, page.encode())
        for name in answers:
            forget(name)
    new = {
        (name, finding.title): finding
        for name, answer in answers.items()
        for finding in reversed(answer.outcome.findings)
        if given.known[name].reason_of(finding) is None
    }
    for (name, title), finding in new.items():
        place = keep(name, finding) if given.plant is None else "planted"
        print(f"FOUND {name}: {title}: {finding.details}\n  {place}")
    return 1 if new else 0


if __name__ == "__main__":
    sys.exit(main())
