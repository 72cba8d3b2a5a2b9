"""Two commits: what is the same is not worse, what is planted is found, what is too old is said."""

import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, ClassVar

import pytest

from kousoku.runtime.toolchain import Toolchain
from tests.benchmarks import __main__ as command
from tests.benchmarks import commit_side, commits
from tests.benchmarks.commit_side import code_size
from tests.benchmarks.commits import Comparison, Count, Time, compare, page_of
from tests.benchmarks.kit import Record, Size
from tests.release import bench_question

ROOT = Path(__file__).parents[2]
SOURCES = ("codegen", "generated", "kousoku", "ledger", "model", "runtime", "symbolic")
NAMES = {"base": "a", "head": "b"}


def time_of(ratios: list[float], same: list[float]) -> Time:
    return Time("a run", 1e-3, 1e-3, ratios, same)


def test_a_count_may_rise_by_three_percent() -> None:
    assert not Count("x", "evaluations", 100, 103).is_worse
    assert Count("x", "evaluations", 100, 104).is_worse
    assert Count("x", "evaluations", 0, 1).is_worse
    assert Count("x", "evaluations", 104, 100).is_better


def test_a_time_is_worse_beyond_what_the_same_code_differs_by() -> None:
    quiet, busy = [1.01, 0.99, 1.005, 0.992], [1.01, 0.8, 1.1, 1.0]
    slower = [1.10, 1.12, 1.09]
    assert time_of(slower, quiet).is_worse
    assert time_of(slower, quiet).spread == pytest.approx(1.02)
    assert not time_of(slower, busy).is_worse
    assert time_of(slower, busy).spread == pytest.approx(1.25)
    assert not time_of([1.0, 1.5, 1.01], quiet).is_worse  # one repeat that was disturbed
    assert time_of([0.9, 0.9, 1.0], quiet).is_better


def test_bytes_of_machine_code_are_those_of_executable_sections(
    compiler: Toolchain, tmp_path: Path
) -> None:
    sizes = []
    for count in (1, 50):
        source, library = tmp_path / f"{count}.c", tmp_path / f"{count}.so"
        functions = (f"double f{k}(double x) {{ return x * x + {k}; }}\n" for k in range(count))
        source.write_text("".join(functions))
        subprocess.run(compiler.compile_command([str(source)], str(library)), check=True)
        sizes.append(code_size(library.read_bytes()))
    if sizes != [0, 0]:  # none of ELF
        assert 0 < sizes[0] < sizes[1] < (tmp_path / "50.so").stat().st_size
    assert code_size(b"MZ" + bytes(100)) == 0


class Scripted:
    """A process that says what a test wants: each side makes so many evaluations, so slowly."""

    evaluations: ClassVar = {"base": 100.0, "head": 100.0}
    seconds: ClassVar = {"base": 1.0, "head": 1.0}
    refused: ClassVar[dict[str, str]] = {}

    def __init__(self, side: str, tree: Path, cache: Path) -> None:
        self.side = side

    def ask(self, **command: Any) -> dict[str, Any]:
        if command["do"] == "time":
            return {"seconds": self.seconds[self.side]}
        if self.side in self.refused:
            return {"cannot": self.refused[self.side]}
        name = command.get("name", command.get("package"))
        counts = {"evaluations": self.evaluations[self.side]} if command["counted"] else {}
        end = [1.0, 2.0] if command["counted"] else []
        return {"runs": [f"{name}: C alone"], "counts": counts, "end": end}

    def cold(self) -> float:
        return self.seconds[self.side]

    def end(self) -> None:
        pass


@pytest.fixture
def scripted(monkeypatch: pytest.MonkeyPatch) -> type[Scripted]:
    class Own(Scripted):
        pass

    monkeypatch.setattr(commits, "Process", Own)
    return Own


def compared(only: str = "pendulum") -> Comparison:
    return compare({"base": ROOT, "head": ROOT}, Size(), [only])


def test_equal_trees_are_equal(scripted: type[Scripted]) -> None:
    found = compared()
    assert len(found.counts) == 1 and len(found.times) == 2
    assert found.worse == found.better == []
    assert page_of(found, NAMES, 60.0).endswith("nothing is worse\n")


def test_an_evaluation_more_and_a_slower_run_are_found(scripted: type[Scripted]) -> None:
    scripted.evaluations = {"base": 100.0, "head": 110.0}
    scripted.seconds = {"base": 1.0, "head": 1.1}
    found = compared()
    assert [str(one).partition(":")[0] for one in found.worse] == [
        *("pendulum", "families/chain_10", "pendulum")
    ]
    page = page_of(found, NAMES, 60.0)
    assert "| pendulum | evaluations | 100 | 110 | +10.0 % |" in page
    assert "**slower**" in page and page.endswith("something is worse\n")


def test_what_a_tree_refuses_is_told_and_is_no_success(scripted: type[Scripted]) -> None:
    scripted.refused = {"base": "older than kousoku.load"}
    found = compared()
    assert found.left_out == {"pendulum": "base: older than kousoku.load"}
    page = page_of(found, NAMES, 60.0)
    assert "Not compared: pendulum: base: older than kousoku.load" in page
    assert page.endswith("nothing can be compared\n")


def test_a_comparison_that_is_cut_leaves_no_tree_behind() -> None:
    """Cut twice: the second time while it puts the repository in order."""
    script = (
        "import os, signal\n"
        "from tests.benchmarks import commits\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"  # ignored in the background
        "git = commits.git\n"
        "def cut(*words):\n"
        "    if words[:2] == ('worktree', 'remove'):\n"
        "        os.kill(os.getpid(), signal.SIGINT)\n"
        "    return git(*words)\n"
        "commits.git = cut\n"
        "try:\n"
        "    with commits.checked_out('HEAD') as tree:\n"
        "        os.kill(os.getpid(), signal.SIGINT)\n"
        "except KeyboardInterrupt:\n"
        "    print(tree, tree.exists())\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], cwd=ROOT, capture_output=True, text=True, check=True
    )
    tree, exists = done.stdout.split()
    assert exists == "False"
    assert tree not in commits.git("worktree", "list")


def test_a_run_that_a_tree_refuses_is_told_and_the_rest_is_compared(
    scripted: type[Scripted], monkeypatch: pytest.MonkeyPatch
) -> None:
    answered = scripted.ask

    def refusing(self: Scripted, **command: Any) -> dict[str, Any]:
        if command["do"] == "time" and self.side == "base" and "pendulum" in command["what"]:
            return {"cannot": "TypeError: no such option"}
        return answered(self, **command)

    monkeypatch.setattr(scripted, "ask", refusing)
    found = compare({"base": ROOT, "head": ROOT}, Size(), ["pendulum", "bricard"])
    assert found.left_out == {"pendulum: C alone": "base: TypeError: no such option"}
    assert [one.what for one in found.times] == [
        *("families/chain_10: from empty caches", "bricard: C alone")
    ]


def test_a_commit_that_is_not_there_ends_with_another_status_than_a_worse_one(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(command, "BUILD", tmp_path)
    for commit in ("no-such-commit", "--help"):
        monkeypatch.setenv("BASE", commit)
        assert command.main([]) == command.REFUSED
        assert f"bad revision '{commit}'" in capsys.readouterr().err


def test_an_old_commit_without_texts_has_the_counts_that_it_has(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("KOUSOKU_CACHE", str(tmp_path))
    side = object.__new__(commit_side.LoadedTree)
    assert side._sizes("a", SimpleNamespace()) == {}
    texts = {"solver.c": "abc", "solver.h": "d", "manifest.json": "{}"}
    assert side._sizes("a", SimpleNamespace(files=texts)) == {"bytes in C": 4.0}


def test_every_scene_of_the_quick_run_is_committed() -> None:
    known = commits.scenes(Size(is_full=True))
    assert set(commits.QUICK_SCENES) <= set(known) and commits.COLD in known
    assert set(commits.ENDS) <= set(known)
    assert set(commits.QUICK_KINDS) <= set(commits.kinds(Size(is_full=True)))


def test_a_commit_that_is_not_there_is_one_line() -> None:
    with pytest.raises(commits.CommitError, match="git log: fatal"):
        commits.git("log", "-1", "no-such-commit", "--")


def test_make_bench_compares_where_a_base_is_given(monkeypatch: pytest.MonkeyPatch) -> None:
    given: list[object] = []

    def main(*arguments: object) -> int:
        given.extend(arguments)
        return 1

    monkeypatch.setattr(commits, "main", main)
    monkeypatch.setenv("BASE", "HEAD~1")
    monkeypatch.setenv("ONLY", "bricard")
    assert command.main([]) == 1
    assert given == ["HEAD~1", Size(), ["bricard"], command.BUILD]


def test_a_question_that_fails_says_so_and_the_rest_runs() -> None:
    def fail(*_: object) -> list[Record]:
        raise ValueError("a line\nand another")

    question = replace(bench_question.QUESTION, run=fail)
    (found,) = command.run("bench_question", question, "quick", Size(), print)
    assert found.contest == "quick" and found.note == "fails: ValueError: a line"


def test_a_planted_correction_is_found_and_the_rest_is_the_same(
    compiler: Toolchain, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With real processes of a tree in which stages are brought nearer to the constraints."""
    tree = tmp_path / "tree"
    for name in SOURCES:
        shutil.copytree(ROOT / name, tree / name, symlinks=True)
    trial = tree / "runtime" / "integrate" / "trial.h"
    text = trial.read_text(encoding="utf-8")
    assert text.count("#define STAGE_RESIDUAL 1e-3") == 1
    trial.write_text(
        text.replace("#define STAGE_RESIDUAL 1e-3", "#define STAGE_RESIDUAL 1e-7"), encoding="utf-8"
    )
    monkeypatch.setattr(commits, "QUICK_REPEATS", 1)
    monkeypatch.setattr(commits, "ROUNDS", 2)
    found = compare({"base": ROOT, "head": tree}, Size(), ["bricard", "rigid_body"])
    worse = {one.what for one in found.counts if one.is_worse}
    assert worse == {"factorisations", "corrections"}
    same = {one.what for one in found.counts if one.base == one.head}
    assert {"evaluations", "steps", "operations", "operations of newton_euler"} <= same
    assert 0 < found.moved["bricard"] < 1e-6
    assert found.left_out == {}
    whats = {one.what for one in found.times}
    assert {"bricard: C alone", "rigid_body newton_euler: lanes"} <= whats
