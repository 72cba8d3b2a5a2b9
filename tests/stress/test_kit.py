"""The kit of the stress suite: workers end with all that they started, the page says what was."""

from __future__ import annotations

import json
import math
import os
import re
import select
import shutil
import subprocess
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import TYPE_CHECKING

import pytest

from tests.stress import __main__ as command
from tests.stress import workers
from tests.stress.kit import Finding, Outcome, Question, Size
from tests.stress.workers import ASKED, NOT_ASKED, Answered, StoppedError, Worker, run_case

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator
    from pathlib import Path

#: What they look at is no part of kousoku.
pytestmark = pytest.mark.release

#: A question whose cases start a process that holds a pipe open, and then do not end well.
STARTING = """
import os, subprocess, sys, time
from tests.stress.kit import Question

def run(case):
    how, place = case.split(" ", 1)
    with open(place, "wb") as pipe:
        sleeping = "import time; print('started', flush=True); time.sleep(600)"
        subprocess.Popen([sys.executable, "-c", sleeping], stdout=pipe)
    if how == "ends":
        time.sleep(1)
        os._exit(3)
    time.sleep(600)

QUESTION = Question("", lambda size: (), run, ())
"""


@pytest.mark.skipif(not hasattr(os, "setpgid"), reason="no groups of processes")
@pytest.mark.parametrize(
    ("how", "said"), [("ends", "exit status 3"), ("sleeps", "takes longer than")]
)
def test_a_worker_that_is_stopped_leaves_no_process(
    how: str, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "tests" / "stress").mkdir(parents=True)
    (tmp_path / "tests" / "stress" / "starting.py").write_text(STARTING, encoding="utf-8")
    monkeypatch.syspath_prepend(str(tmp_path))
    os.mkfifo(tmp_path / "pipe")
    pipe = os.open(tmp_path / "pipe", os.O_RDONLY | os.O_NONBLOCK)
    worker = Worker(run_case)
    try:
        for seconds in (3.0, 60.0):  # once more where the machine has more to do
            with pytest.raises(StoppedError, match=said):
                worker.run("starting", f"{how} {tmp_path / 'pipe'}", seconds)
            if select.select([pipe], [], [], 0.0)[0] and os.read(pipe, 8) == b"started\n":
                break
        # The end of the pipe comes when nobody holds it any more.
        assert select.select([pipe], [], [], 60.0)[0]
        assert os.read(pipe, 1) == b""
    finally:
        worker.stop()
        os.close(pipe)


def wait_long(name: str, case: str) -> None:
    """Wait as a case that takes long does."""
    time.sleep(600)


def test_a_worker_that_is_stopped_while_it_runs_a_case_is_not_replaced() -> None:
    worker = Worker(wait_long)
    with ThreadPoolExecutor(1) as threads:
        running = threads.submit(worker.run, "any", "case", 600.0)
        time.sleep(1.0)
        worker.stop()
        with pytest.raises(StoppedError):
            running.result(60.0)
    assert not workers.SPAWN.active_children()


def test_a_worker_ends_when_nobody_waits_for_its_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    ours, other = workers.SPAWN.Pipe()
    monkeypatch.setattr(workers, "HAS_GROUPS", False)
    ours.send(("any", "case"))
    workers._serve(other, lambda *_: ours.close())


def test_a_figure_has_a_unit() -> None:
    outcome = Outcome()
    outcome.measure("how far (m)", 1.0, "there")
    with pytest.raises(ValueError, match="has no unit"):
        outcome.measure("how far", 1.0, "there")


def asked_of(found: Outcome) -> Question:
    return Question("are there any?", lambda _: ["one"], lambda _: found, ())


@pytest.fixture
def build(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Let runs write into a folder of the test, and ask in this process."""
    monkeypatch.setattr(command, "BUILD", tmp_path)
    monkeypatch.setattr(command, "ROOT", tmp_path)
    for name in command.OPTIONS:
        monkeypatch.delenv(name, raising=False)
    return tmp_path


WRONG = {
    "N=abc": "N is 'abc'; wanted a whole number from 1 on",
    "N=0": "N is '0'; wanted a whole number from 1 on",
    "N=-3": "N is '-3'; wanted a whole number from 1 on",
    "SEED=x": "SEED is 'x'; wanted a whole number from 0 on",
    "FULL=2": "FULL is '2', and neither 1 nor 0",
    "PAGE=.": "PAGE is '.'; wanted a file, in folders",
    "--processes 0": "the number of processes is '0'; wanted a whole number from 1 on",
    "--case nonsense": "'nonsense' is no case of branches; they begin with near",
    "--plant 9": " faults, 0 to ",
    "invariance --plant 0": "a case and a fault are those of one question; wanted its name",
    "nonsense": "there is no question 'nonsense'; there are branches, compilers, ",
}


@pytest.mark.usefixtures("build")
@pytest.mark.parametrize("said", WRONG)
def test_what_cannot_be_asked_is_told_in_a_line_before_anything_is(
    said: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    name, _, value = said.partition("=")
    words = [] if value else said.split()
    if value:
        monkeypatch.setenv(name, value)
    monkeypatch.setattr(command, "ask", None)
    monkeypatch.setattr(command, "run_here", None)
    with pytest.raises(SystemExit) as ended:
        command.main(["branches", *words])
    assert ended.value.code == 2
    told = capsys.readouterr()
    assert WRONG[said] in told.err.splitlines()[-1]
    assert told.out == ""


def test_findings_of_a_question_that_is_asked_again_go(
    build: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = Outcome(findings=[Finding("one that is mended")])
    monkeypatch.setattr(command, "questions", lambda: {"any": asked_of(found)})
    monkeypatch.setattr(command, "journal_of", lambda _: build / "journal")

    def answered(keys: Iterable[object], *_: object) -> list[tuple[object, Answered]]:
        return [(key, (found, 1.0)) for key in keys]

    monkeypatch.setattr(command, "run_cases", answered)
    assert command.main(["any"]) == 1
    (build / "findings" / "other-12345678").mkdir()
    assert [*(build / "findings").glob("any-*/command.txt")]
    (build / "journal").unlink()
    found.findings.clear()
    assert command.main(["any"]) == 0
    assert [path.name for path in (build / "findings").iterdir()] == ["other-12345678"]


def test_a_run_that_was_cut_goes_on_and_each_finding_has_a_command(
    build: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    found, asked = Outcome(), list[object]()
    found.measure("how far off (m)", 2.0, "there", limit=1.0)
    question = Question("are there any?", lambda _: ["one", "two"], lambda _: found, ())
    monkeypatch.setattr(command, "questions", lambda: {"any": question})
    monkeypatch.setattr(command, "journal_of", lambda _: build / "journal")

    def answered(keys: Iterable[object], *_: object) -> Iterator[tuple[object, Answered]]:
        for key in keys:
            yield key, (found, 1.0)
            asked.append(key)
            if len(asked) == 1:
                raise KeyboardInterrupt

    monkeypatch.setattr(command, "run_cases", answered)
    assert command.main(["any"]) == 130
    told = "interrupted; the same command goes on with the cases that are left\n"
    assert capsys.readouterr().err == told
    assert command.main(["any"]) == 1
    assert asked == [("any", "one"), ("any", "two")]
    commands = [path.read_text("utf-8") for path in build.glob("findings/any-*/command.txt")]
    assert commands == ["python -m tests.stress any --case 'one'\n"]


def test_the_clock_of_some_cases_is_not_that_of_all(
    build: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def answered(keys: Iterable[object], *_: object) -> Iterator[tuple[object, Answered]]:
        for key in keys:
            now[0] += 60.0
            yield key, (Outcome(), 1.0)

    now = [0.0]
    question = Question("", lambda size: map(str, range(size.count or 5)), lambda _: Outcome(), ())
    monkeypatch.setattr(command, "run_cases", answered)
    monkeypatch.setattr("tests.stress.__main__.time.monotonic", lambda: now[0])
    for count, wanted in ((None, 300.0), (None, 300.0), (1, 60.0)):
        size = Size(count=count)
        _, seconds = command.ask({"any": question}, size, build / "journal", 1)
        assert seconds == wanted


def test_the_page_tells_both_times_and_the_compiler(
    build: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(command, "compiler", lambda: "a compiler 1.2")
    monkeypatch.setattr(command, "commit", lambda: "")
    answer = command.Answer()
    answer.add("one", Outcome(counts={"turns": 30}), 90.0)
    page = command.page_of({"any": asked_of(Outcome())}, {"any": answer}, Size(), 48.0)
    assert "a compiler 1.2, seed 1, quick run: 1.5 min of processor time, 0.8 min of wall" in page
    assert re.search(r"\| turns \| 30 \|", page)


@pytest.mark.parametrize("name", [*command.questions()])
def test_every_question_says_that_no_compiler_is_in_reach(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("KOUSOKU_CC", "none")
    question, asked = command.questions()[name], list[str]()

    def run(case: str) -> Outcome:
        asked.append(case)
        return Outcome()

    monkeypatch.setattr(f"tests.stress.{name}.QUESTION", replace(question, run=run))
    outcome, _ = run_case(name, "one")
    needs = name in {"branches", "endurance", "events", "forces", "invariance", "scenes"}
    assert asked == ([] if needs else ["one"])
    assert outcome.counts == {NOT_ASKED if needs else ASKED: 1}


@pytest.mark.skipif(shutil.which("git") is None, reason="no git")
def test_the_page_names_the_commit_that_it_was_measured_on(
    build: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def git(*words: str, cwd: Path = build) -> str:
        who = ("-c", "user.name=anyone", "-c", "user.email=anyone@example.org")
        command = ["git", *who, *words]
        return subprocess.run(command, cwd=cwd, capture_output=True, text=True, check=True).stdout

    monkeypatch.setenv("GIT_CONFIG_GLOBAL", os.devnull)
    assert command.commit() == ""
    git("init")
    (build / "file").write_text("before\n", encoding="utf-8")
    git("add", "file")
    git("commit", "-m", "Add a file")
    named = git("rev-parse", "--short=10", "HEAD").strip()
    assert command.commit() == named
    (build / "file").write_text("after\n", encoding="utf-8")
    assert command.commit() == f"{named} with changes"
    page = command.page_of({}, {}, Size(), 0.0)
    assert f", commit {named} with changes, seed 1, " in page
    # a copy without a history that lies in another repository has no commit of its own
    (build / "copy").mkdir()
    monkeypatch.setattr(command, "ROOT", build / "copy")
    assert command.commit() == ""
    monkeypatch.setenv("PATH", "")
    assert command.commit() == ""


def test_a_table_has_the_largest_values_of_all_cases_and_the_cases_that_repeat_them(
    build: Path,
) -> None:
    answer, alone = command.Answer(), command.Answer()
    for case, values in {"early 1": (1.0, 5.0), "late 1": (3.0, 2.0)}.items():
        outcome = Outcome()
        for column, value in zip(("1e1", "1e2"), values, strict=True):
            outcome.tabulate("drift (m)", "crank", column, value, "r=[1.5]")
        alone.add(case, outcome, 0.0)
        read = Outcome.from_dict(json.loads(json.dumps(outcome.as_dict())))
        answer.add(case, read, 0.0, command.command_of("any", case))
    answer.outcome.tabulate("drift (m)", "wheel", "1e2", math.nan, "late 1")
    page = command.page_of({"any": asked_of(Outcome())}, {"any": answer}, Size(), 0.0)
    assert (
        "\n| drift (m) | 1e1 | 1e2 | largest at |\n|---|---|---|---|\n"
        "| crank | 3 | 5 | early 1 |\n| wheel |  | inf | late 1 |\n" in page
    )
    page = command.page_of({"any": asked_of(Outcome())}, {"any": alone}, Size(), 0.0)
    assert "| crank | 3 | 5 | r=[1.5] |" in page
    with pytest.raises(ValueError, match="has no unit"):
        Outcome().tabulate("drift", "crank", "1e1", 1.0, "")
