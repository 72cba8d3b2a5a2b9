"""The command of the benchmarks: ``make bench``, or ``python -m benchmarks``.

It asks all questions, or those named; writes each contest into a journal as it ends, so that a run
that was cut goes on; prints the page, and writes records, plots and page into ``build/bench``.
"""

from __future__ import annotations

import argparse
import json
import os
import pkgutil
import sys
import time
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.progress import Progress

import benchmarks
from benchmarks import commits
from benchmarks.kit import Figures, Question, Record, Size, Target
from benchmarks.machine import machine
from benchmarks.race import MISSING, Workers, race
from kousoku.model.cache import write_atomically
from tests.stress.journal import ROOT, digest_of, done_in, page_in

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

BUILD = ROOT / "build" / "bench"
#: In the order of the page.
ORDER = ("solvers", "methods", "kernels", "first_step", "evaluations")
#: What decides what is measured; pages and plots do not.
SOURCES = (
    "benchmarks",
    "codegen",
    "generated",
    "kousoku",
    "model",
    "runtime",
    "scenes",
    "symbolic",
)
SUFFIXES = {".py", ".c", ".h", ".cpp", ".toml", ".json", ".jinja"}
NOT_MEASURED = {"plots.py", "page.md.jinja", "__main__.py"}


@dataclass(slots=True)
class Answer:
    """The records of a question, and how long they took [s]."""

    records: list[Record] = field(default_factory=list)
    seconds: float = 0.0


def questions() -> dict[str, Question]:
    """Questions by the names of their modules, in the order of the page."""
    names = {module.name for module in pkgutil.iter_modules(benchmarks.__path__)}
    modules = {name: import_module(f"benchmarks.{name}") for name in ORDER if name in names}
    return {name: one.QUESTION for name, one in modules.items() if hasattr(one, "QUESTION")}


def journal_of(size: Size) -> Path:
    """Journal of a run: another one for other sources, and on another machine."""
    run = size, sorted(machine().items())
    return BUILD / f"{digest_of(run, SOURCES, _is_measured)}.jsonl"


def _is_measured(path: Path) -> bool:
    return path.suffix in SUFFIXES and path.name not in NOT_MEASURED


def resumed(journal: Path) -> Iterator[tuple[str, str, list[Record], float]]:
    """Contests of a journal."""
    for done in done_in(journal):
        records = [Record.from_dict(one) for one in done["records"]]
        yield done["question"], done["contest"], records, done["seconds"]


def ask(
    chosen: dict[str, Question], only: Sequence[str], size: Size, journal: Path
) -> dict[str, Answer]:
    """Run the contests that the journal does not have, and return all answers."""
    answers = {name: Answer() for name in chosen}
    wanted = [
        (name, contest)
        for name, question in chosen.items()
        for contest in question.contests(size)
        if not only or any(word in contest for word in only)
    ]
    left = dict.fromkeys(wanted)
    found: dict[tuple[str, str], tuple[list[Record], float]] = {}
    for name, contest, records, took in resumed(journal):
        if (name, contest) in left:
            del left[name, contest]
            found[name, contest] = records, took
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
            found[name, contest] = records, took
            done = {"question": name, "contest": contest, "seconds": took}
            done["records"] = [record.as_dict() for record in records]
            written.write(json.dumps(done) + "\n")
            written.flush()
            progress.advance(bar)
    for name, contest in wanted:
        records, took = found[name, contest]
        answers[name].records += records
        answers[name].seconds += took
    return answers


def run(name: str, question: Question, contest: str, size: Size, tell: Any) -> list[Record]:
    """Records of a contest."""
    workers = Workers(f"benchmarks.{name}", size)
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


def targets_of(chosen: dict[str, Question], answers: dict[str, Answer]) -> list[Target]:
    """Targets that the page promises, judged."""
    return [
        target
        for name, answer in answers.items()
        for target in chosen[name].targets(answer.records)
    ]


def missing_of(answers: dict[str, Answer]) -> list[str]:
    """Tools that are not installed, each with what to install."""
    notes = [record.note for answer in answers.values() for record in answer.records]
    return sorted({note.removeprefix(MISSING) for note in notes if note.startswith(MISSING)})


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
            "targets": chosen[name].targets(answer.records),
        }
        for name, answer in answers.items()
        if answer.records
    ]
    took = sum(answer.seconds for answer in answers.values())
    words = [chosen[name].words(answer.records) for name, answer in answers.items()]
    return page_in(Path(__file__).parent).render(
        words="\n\n".join(filter(None, words)),
        date=time.strftime("%Y-%m-%d"),
        machine=about,
        size="full" if size.is_full else "quick",
        took=f"{took / 60:.1f} min",
        missing=missing_of(answers),
        parts=parts,
    )


def arguments_of(words: list[str] | None) -> argparse.Namespace:
    """Arguments of the command line; the environment is what ``make bench FULL=1`` sets."""
    given, known = os.environ, questions()
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    named = [word for word in given.get("ONLY", "").split(",") if word]
    parser.add_argument("questions", nargs="*", metavar="QUESTION", help=", ".join(known))
    parser.add_argument("--full", action="store_true", default=bool(given.get("FULL")))
    parser.add_argument("--only", action="append", help="contests whose names have this word")
    parser.add_argument("--page", type=Path, default=given.get("PAGE") or None)
    parser.add_argument(
        "--base", default=given.get("BASE"), help="compare with this commit instead"
    )
    parser.add_argument("--check", action="store_true", default=bool(given.get("CHECK")))
    arguments = parser.parse_args(words)
    arguments.questions = arguments.questions or [word for word in named if word in known]
    arguments.only = arguments.only or [word for word in named if word not in known]
    for name in arguments.questions:
        if name not in known:
            parser.error(f"there is no question {name!r}; there are {', '.join(known)}")
    arguments.known = {
        name: question
        for name, question in known.items()
        if name in arguments.questions or not arguments.questions
    }
    return arguments


def main(words: list[str] | None = None) -> int:
    """Measure, and return the exit status: 1 where a target is missed that was to be checked."""
    given = arguments_of(words)
    size = Size(given.full)
    if given.base:
        return commits.main(given.base, size, given.only, BUILD)
    os.environ.setdefault("KOUSOKU_CACHE", str(BUILD / "cache"))
    about = machine()
    answers = ask(given.known, given.only, size, journal_of(size))
    data = {
        "date": time.strftime("%Y-%m-%d"),
        "machine": about,
        "is_full": size.is_full,
        "records": {name: [one.as_dict() for one in a.records] for name, a in answers.items()},
    }
    BUILD.mkdir(parents=True, exist_ok=True)
    write_atomically(BUILD / "results.json", json.dumps(data, indent=0).encode())
    page = ""
    for path in filter(None, (given.page, BUILD / "bench.md")):
        figures = Figures(path.parent / path.stem, path.stem)
        page = page_of(given.known, answers, size, figures, about)
        path.parent.mkdir(parents=True, exist_ok=True)
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
