"""The command of the benchmarks: ``make bench``, or ``python -m tests.benchmarks``.

It asks all questions, or those named; writes each contest into a journal as it ends, so that a run
that was cut goes on; prints the page, and writes records, plots and page into ``build/bench``.
"""

from __future__ import annotations

import argparse
import json
import os
import pkgutil
import sys
import tempfile
import time
from collections import Counter
from contextlib import contextmanager
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.progress import Progress

from kousoku.model.files.cache import write_atomically
from kousoku.runtime.lock import locked
from tests import benchmarks
from tests.benchmarks import commits
from tests.benchmarks.kit import BenchmarkTarget, Figures, Question, Record, Size, matches
from tests.benchmarks.machine import machine
from tests.benchmarks.race import MISSING, OURS, Workers, race
from tests.stress.journal import ROOT, digest_of, done_in, is_on, page_in

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

BUILD = ROOT / "build" / "bench"
#: In the order of the page.
ORDER = ("solvers", "methods", "kernels", "first_step", "evaluations")
#: What decides what is measured; pages and plots do not.
SOURCES = (
    "codegen",
    "generated",
    "kousoku",
    "model",
    "runtime",
    "scenes",
    "symbolic",
    "tests/benchmarks",
)
SUFFIXES = {".py", ".c", ".h", ".cpp", ".toml", ".json", ".jinja"}
NOT_MEASURED = {"plots.py", "page.md.jinja", "__main__.py"}
#: How the notes of cases begin that should have run.
FAILED = ("fails", "not set up", "not judged")
#: What a user of the command line does wrong, or the disk; and a run that is cut by hand.
REFUSED, CUT = 2, 130


@dataclass(slots=True)
class Answer:
    """The records of a question, how long they took [s], and on which days."""

    records: list[Record] = field(default_factory=list)
    seconds: float = 0.0
    dates: set[str] = field(default_factory=set)


class BusyError(Exception):
    """Another run measures, and both would be slower than they are."""


def questions() -> dict[str, Question]:
    """Questions by the names of their modules, in the order of the page."""
    names = {module.name for module in pkgutil.iter_modules(benchmarks.__path__)}
    modules = {name: import_module(f"tests.benchmarks.{name}") for name in ORDER if name in names}
    return {name: one.QUESTION for name, one in modules.items() if hasattr(one, "QUESTION")}


def journal_of(size: Size) -> Path:
    """Journal of a run: another one for other sources, and on another machine."""
    run = size, sorted(machine().items())
    return BUILD / f"{digest_of(run, SOURCES, _is_measured)}.jsonl"


def _is_measured(path: Path) -> bool:
    return path.suffix in SUFFIXES and path.name not in NOT_MEASURED


@contextmanager
def alone() -> Iterator[None]:
    """Let no other run of this checkout measure at the same time.

    Raises
    ------
    BusyError
        One does.
    """

    def refuse() -> bool:
        raise BusyError(f"another run measures now, in {BUILD}; both would be slower")

    BUILD.mkdir(parents=True, exist_ok=True)
    with locked(BUILD / "bench.lock", until=refuse):
        yield


def today() -> str:
    """Date as pages have it."""
    return time.strftime("%Y-%m-%d")


def resumed(journal: Path) -> Iterator[tuple[str, str, list[Record], float, str]]:
    """Contests of a journal that would not end otherwise today."""
    for done in done_in(journal):
        try:
            records = [Record.from_dict(one) for one in done["records"]]
            found = done["question"], done["contest"], records, done["seconds"], done["date"]
        except (AttributeError, KeyError, TypeError, ValueError):
            continue  # no contest
        if not any(map(may_end_otherwise, records)):
            yield found


def may_end_otherwise(record: Record) -> bool:
    """Whether a case failed for a reason that may be gone, such as a disk that was full.

    Packages are part of the machine, and have a journal of their own; headers and compilers are
    not. That a peer fails is what it does.
    """
    if record.note.startswith(MISSING):
        return "pip install" not in record.note
    return has_failed(record)


def has_failed(record: Record) -> bool:
    """Whether it is a case of kousoku that should have run."""
    return record.tool == OURS and record.note.startswith(FAILED)


def wanted_of(
    chosen: dict[str, Question], only: Sequence[str], size: Size
) -> list[tuple[str, str]]:
    """Questions and contests; those with one of the words in their names, where there are any."""
    return [
        (name, contest)
        for name, question in chosen.items()
        for contest in question.contests(size)
        if not only or any(matches(word, name, contest) for word in only)
    ]


def ask(
    chosen: dict[str, Question], only: Sequence[str], size: Size, journal: Path
) -> dict[str, Answer]:
    """Run the contests that the journal does not have, and return all answers."""
    answers = {name: Answer() for name in chosen}
    wanted = wanted_of(chosen, only, size)
    left = dict.fromkeys(wanted)
    found: dict[tuple[str, str], tuple[list[Record], float, str]] = {}
    for name, contest, records, took, date in resumed(journal):
        if (name, contest) in left:
            del left[name, contest]
            found[name, contest] = records, took, date
    if found:
        print(
            f"{len(found)} of {len(wanted)} contests {'was' if len(found) == 1 else 'were'}"
            f" measured before, {period(date for _, _, date in found.values())}; to measure"
            f" all anew remove {journal}",
            file=sys.stderr,
        )
    journal.parent.mkdir(parents=True, exist_ok=True)
    with journal.open("a", encoding="utf-8") as written, Progress() as progress:
        written.write("\n")  # ends a line that was cut; an empty one is no contest
        bar = progress.add_task("bench", total=len(wanted), completed=len(found))
        for name, contest in left:

            def tell(text: str) -> None:
                progress.update(bar, description=text[:60].ljust(60))

            start = time.monotonic()
            records = run(name, chosen[name], contest, size, tell)
            took = time.monotonic() - start
            found[name, contest] = records, took, today()
            done = {"question": name, "contest": contest, "seconds": took, "date": today()}
            done["records"] = [record.as_dict() for record in records]
            written.write(json.dumps(done) + "\n")
            written.flush()
            progress.advance(bar)
    for name, contest in wanted:
        records, took, date = found[name, contest]
        answers[name].records += records
        answers[name].seconds += took
        answers[name].dates.add(date)
    return answers


def period(dates: Iterable[str]) -> str:
    """First and last of some days, or the only one."""
    ordered = sorted(set(dates))
    return " to ".join(dict.fromkeys((ordered[0], ordered[-1])))


def measured(answers: dict[str, Answer]) -> str:
    """Days on which contests were measured, not those on which their page is written."""
    return period(date for answer in answers.values() for date in answer.dates or {today()})


def run(name: str, question: Question, contest: str, size: Size, tell: Any) -> list[Record]:
    """Records of a contest."""
    workers = Workers(f"tests.benchmarks.{name}", size)
    try:
        if question.run is not None:
            try:
                return question.run(contest, size, workers)
            except Exception as error:  # the rest runs
                note = f"fails: {type(error).__name__}: {error}".partition("\n")[0]
                return [Record(contest, "kousoku", "all", "", note=note)]
        return race(contest, question.cases(contest, size), workers, question.seconds, tell)
    finally:
        workers.stop()


def targets_of(chosen: dict[str, Question], answers: dict[str, Answer]) -> list[BenchmarkTarget]:
    """Targets that the page promises, judged."""
    return [target for name, answer in answers.items() for target in judged(chosen[name], answer)]


def judged(question: Question, answer: Answer) -> list[BenchmarkTarget]:
    """Targets of a question; what failed has none of its own, and misses that nothing fails."""
    failed = Counter(one.contest for one in answer.records if has_failed(one))
    return [
        *question.targets(answer.records),
        *(
            BenchmarkTarget(name, "cases that fail", float(count), 0.0)
            for name, count in failed.items()
        ),
    ]


def missing_of(answers: dict[str, Answer]) -> list[str]:
    """Tools that are not installed, each with what to install."""
    notes = [record.note for answer in answers.values() for record in answer.records]
    return sorted({note.removeprefix(MISSING) for note in notes if note.startswith(MISSING)})


def failed_of(records: Sequence[Record]) -> list[str]:
    """Contests of which kousoku does not run a part that it should, and why."""
    told = (f"{one.contest}: {one.note}" for one in records if has_failed(one))
    return list(dict.fromkeys(told))


def page_of(
    chosen: dict[str, Question],
    answers: dict[str, Answer],
    size: Size,
    figures: Figures,
    about: dict[str, str],
) -> str:
    """Page of a run in Markdown; its plots are written beside it."""
    parts = [
        {
            "name": name,
            "title": chosen[name].title,
            "asks": chosen[name].asks,
            "body": chosen[name].body(answer.records, figures),
            "targets": judged(chosen[name], answer),
            "failed": failed_of(answer.records),
        }
        for name, answer in answers.items()
        if answer.records
    ]
    took = sum(answer.seconds for answer in answers.values())
    words = [chosen[name].words(answer.records) for name, answer in answers.items()]
    return page_in(Path(__file__).parent).render(
        words="\n\n".join(filter(None, words)),
        date=measured(answers),
        machine=about,
        size="full" if size.is_full else "quick",
        took=f"{took / 60:.1f} min",
        missing=missing_of(answers),
        parts=parts,
    )


def page_at(text: str) -> Path:
    """File of a page, if it can be written.

    Raises
    ------
    ArgumentTypeError
        It cannot, which is said before anything is measured.
    """
    path = Path(text)
    folder = next(one for one in path.absolute().parents if os.path.lexists(one))
    if path.suffix != ".md" or path.is_dir():
        raise argparse.ArgumentTypeError(f"PAGE is {text!r}, and not a file such as page.md")
    try:
        with tempfile.TemporaryFile(dir=folder):
            return path
    except OSError as error:
        raise argparse.ArgumentTypeError(f"PAGE is {text!r}: {error}") from error


def arguments_of(words: list[str] | None) -> argparse.Namespace:
    """Arguments of the command line; the environment is what ``make bench FULL=1`` sets."""
    given, known = os.environ, questions()
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks", description=__doc__)
    named = [word.strip() for word in given.get("ONLY", "").split(",") if word.strip()]
    try:
        switches = {name: is_on(name) for name in ("FULL", "CHECK")}
    except ValueError as error:
        parser.error(str(error))
    parser.add_argument("questions", nargs="*", metavar="QUESTION", help=", ".join(known))
    parser.add_argument("--full", action="store_true", default=switches["FULL"])
    parser.add_argument(
        "--only", action="append", help="contests, or questions, whose names have this word"
    )
    parser.add_argument("--page", type=page_at, default=given.get("PAGE") or None)
    parser.add_argument(
        "--base", default=given.get("BASE"), help="compare with this commit instead"
    )
    parser.add_argument("--check", action="store_true", default=switches["CHECK"])
    arguments = parser.parse_args(words)
    arguments.only = arguments.only or named
    for name in arguments.questions:
        if name not in known:
            parser.error(f"there is no question {name!r}; there are {', '.join(known)}")
    arguments.known = {
        name: question
        for name, question in known.items()
        if name in arguments.questions or not arguments.questions
    }
    size = Size(arguments.full)
    has = commits.names(size) if arguments.base else names(arguments.known, size)
    for word in arguments.only:
        if not any(matches(word, name) for name in has):
            what = "scene or kind" if arguments.base else "contest or question"
            run = "full" if size.is_full else "quick"
            parser.error(f"the {run} run has no {what} with {word!r}: it has {'; '.join(has)}")
    if arguments.base and arguments.page:
        parser.error(f"BASE writes {BUILD / 'commits.md'}, and no PAGE")
    return arguments


def names(chosen: dict[str, Question], size: Size) -> list[str]:
    """Names of questions and of their contests."""
    return list(dict.fromkeys(name for pair in wanted_of(chosen, [], size) for name in pair))


def main(words: list[str] | None = None) -> int:
    """Measure, and return the exit status: 1 where a target is missed that was to be checked."""
    given = arguments_of(words)
    try:
        with alone():
            return measure(given)
    except (BusyError, commits.CommitError, OSError) as error:
        print(f"bench: {error}", file=sys.stderr)
        return REFUSED
    except KeyboardInterrupt:
        more = "" if given.base else "; the same command goes on after the last contest"
        print(f"bench: cut{more}", file=sys.stderr)
        return CUT


def measure(given: argparse.Namespace) -> int:
    """Do what the arguments say, and return the exit status."""
    size = Size(given.full)
    if given.base:
        return commits.main(given.base, size, given.only, BUILD)
    os.environ.setdefault("KOUSOKU_CACHE", str(BUILD / "cache"))
    about = machine()
    answers = ask(given.known, given.only, size, journal_of(size))
    data = {
        "date": measured(answers),
        "machine": about,
        "is_full": size.is_full,
        "records": {name: [one.as_dict() for one in a.records] for name, a in answers.items()},
    }
    write_atomically(BUILD / "results.json", json.dumps(data, indent=0).encode())
    page = ""
    for path in filter(None, (given.page, BUILD / "bench.md")):
        figures = Figures(path.parent / path.stem, path.stem)
        page = page_of(given.known, answers, size, figures, about)
        write_atomically(path, page.encode())
    print(page)
    for text in missing_of(answers):
        print(f"left out: {text}", file=sys.stderr)
    missed = [target for target in targets_of(given.known, answers) if not target.is_met]
    for target in missed if given.check else ():
        print(f"missed: {target}", file=sys.stderr)
    return int(bool(missed) and given.check)


if __name__ == "__main__":
    sys.exit(main())
