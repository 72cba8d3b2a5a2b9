"""The kit of the benchmarks: what runs in turn, what is late, fails or is missing, and the page."""

import json
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from xml.etree import ElementTree

import pytest

from tests.benchmarks import __main__ as command
from tests.benchmarks import race, solvers
from tests.benchmarks.kit import (
    ROUNDS,
    BenchmarkTarget,
    Figures,
    PeerMissingError,
    Question,
    Record,
    Size,
    fastest_and_median,
    interleave,
    required,
    rounds_of,
)
from tests.benchmarks.plots import LogAxis, ToolLine, work_precision
from tests.benchmarks.race import TOO_LONG, Workers
from tests.release import bench_question

MODULE = "tests.release.bench_question"


@pytest.fixture
def workers() -> Iterator[Workers]:
    found = Workers(MODULE, Size())
    yield found
    found.stop()


def raced(contest: str, workers: Workers, seconds: float = 60.0) -> list[Record]:
    return race.race(contest, bench_question.cases(contest, Size()), workers, seconds)


def test_programs_run_in_turn() -> None:
    order: list[str] = []
    times = interleave({"a": lambda: order.append("a"), "b": lambda: order.append("b")}, rounds=3)
    assert {name: len(found) for name, found in times.items()} == {"a": 3, "b": 3}
    changes = [x for k, x in enumerate(order) if k == 0 or x != order[k - 1]]
    assert changes == ["a", "b"] * 4


def test_a_long_case_gets_fewer_rounds() -> None:
    assert rounds_of(1e-6) == ROUNDS
    assert 1 <= rounds_of(0.5) < ROUNDS
    assert rounds_of(20.0) == 0


def test_times_are_those_of_a_unit() -> None:
    assert fastest_and_median([4.0, 2.0, 9.0], count=2) == (1.0, 2.0)


def test_a_short_case_is_timed_in_rounds_by_its_unit(workers: Workers) -> None:
    first, second = raced("quick", workers)
    assert (first.tool, second.tool) == ("a", "b")
    assert first.rounds == second.rounds == ROUNDS
    assert first.fastest is not None and first.median is not None
    assert 0 < first.fastest <= first.median < 1e-4
    assert first.error == 1e-7 and first.extra["steps"] == 3
    assert "count" not in first.extra and first.extra["setup"] >= 0


def test_a_case_that_lasts_is_ended_and_its_line_too(
    workers: Workers, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(race, "CAP", 0.3)
    late, later, other = raced("unending", workers)
    assert late.note == later.note == TOO_LONG
    assert late.fastest is None and later.fastest is None
    assert other.fastest is not None and not other.note


def test_a_case_that_fails_or_ends_its_process_says_so_and_the_rest_runs(workers: Workers) -> None:
    wrong, deadly, other = raced("failing", workers)
    assert wrong.note == "fails: ZeroDivisionError: division by zero"
    assert "ended its process, exit status 7" in deadly.note
    assert other.fastest is not None


def test_a_missing_peer_is_named_with_what_to_install_and_the_rest_runs(workers: Workers) -> None:
    first, second, other = raced("missing", workers)
    assert first.note == second.note
    assert first.note.startswith("missing: no_such_peer (")
    assert "pip install 'kousoku[bench]'" in first.note
    assert other.fastest is not None
    with pytest.raises(PeerMissingError, match="no_such_peer"):
        required("no_such_peer.part")


def test_a_folder_that_a_removed_peer_leaves_is_no_peer(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    (tmp_path / "removed_peer" / "plugins").mkdir(parents=True)
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(PeerMissingError, match=r"removed_peer \(.*\); pip install"):
        required("removed_peer")


def test_what_the_time_is_over_for_is_left_out_and_says_so(workers: Workers) -> None:
    assert {record.note for record in raced("quick", workers, seconds=-1.0)} == {
        "not run: the time of the contest was over"
    }


@pytest.fixture
def one_question(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Let the command know one question, and write to a folder of the test."""
    monkeypatch.setattr(command, "BUILD", tmp_path)
    monkeypatch.setattr(command, "journal_of", lambda _: tmp_path / "journal")
    monkeypatch.setattr(command, "questions", lambda: {"bench_question": bench_question.QUESTION})


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Let contests be answered at once; the list tells which ones ran."""
    ran: list[str] = []

    def run(name: str, question: Question, contest: str, *_: object) -> list[Record]:
        ran.append(contest)
        return [Record(contest, "kousoku", "auto", "1", fastest=1e-3, error=float("inf"))]

    monkeypatch.setattr(command, "run", run)
    return ran


def test_a_run_that_was_cut_goes_on(asked: list[str], tmp_path: Path) -> None:
    journal = tmp_path / "bench.jsonl"
    chosen = {"bench_question": bench_question.QUESTION}
    first = command.ask(chosen, [], Size(), journal)
    journal.write_text(journal.read_text() + '{"question": "bench_q', encoding="utf-8")
    both = command.ask(chosen, [], Size(is_full=True), journal)
    again = command.ask(chosen, [], Size(is_full=True), journal)
    assert asked == ["quick", "missing"]
    assert len(first["bench_question"].records) == 1
    assert [one.contest for one in both["bench_question"].records] == ["quick", "missing"]
    assert both["bench_question"].records == again["bench_question"].records


def test_only_the_contests_that_are_named_run(asked: list[str], tmp_path: Path) -> None:
    chosen = {"bench_question": bench_question.QUESTION}
    command.ask(chosen, ["miss"], Size(is_full=True), tmp_path / "journal")
    assert asked == ["missing"]


def test_a_word_that_is_in_no_contest_is_refused_before_anything_is_written(
    asked: list[str],
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
) -> None:
    monkeypatch.setattr(command, "BUILD", tmp_path)
    monkeypatch.setenv("ONLY", "pendulum,no_such_word")
    with pytest.raises(SystemExit) as stopped:
        command.main([])
    assert stopped.value.code == 2
    said = capsys.readouterr().err
    assert "the quick run has no contest or question with 'no_such_word'" in said
    assert "andrews" in said
    assert not asked and not list(tmp_path.iterdir())


def test_a_word_may_be_in_the_name_of_a_question_or_of_a_contest(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("ONLY", "kernel, ANDREWS")
    given = command.arguments_of([])
    wanted = command.wanted_of(given.known, given.only, Size())
    assert ("solvers", "andrews") in wanted and ("kernels", "limits") in wanted
    assert not any(contest == "pendulum" for _, contest in wanted)


@pytest.mark.parametrize("name", ["FULL", "CHECK"])
def test_a_switch_may_be_turned_off(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    for word, is_on in (("0", False), ("no", False), ("", False), ("1", True), ("yes", True)):
        monkeypatch.setenv(name, word)
        assert getattr(command.arguments_of([]), name.lower()) is is_on
    monkeypatch.setenv(name, "perhaps")
    with pytest.raises(SystemExit) as stopped:
        command.arguments_of([])
    assert stopped.value.code == 2


@pytest.mark.parametrize("place", ["1", "folder.md", "file/page.md", "/proc/page.md"])
def test_a_page_that_cannot_be_written_is_refused_before_anything_is_measured(
    place: str,
    asked: list[str],
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
) -> None:
    (tmp_path / "folder.md").mkdir()
    (tmp_path / "file").write_text("", encoding="utf-8")
    monkeypatch.setattr(command, "BUILD", tmp_path / "build")
    monkeypatch.setenv("PAGE", str(tmp_path / place))
    with pytest.raises(SystemExit) as stopped:
        command.main([])
    assert stopped.value.code == 2 and "PAGE" in capsys.readouterr().err
    assert not asked


def test_a_page_may_go_into_a_folder_that_is_not_there(tmp_path: Path) -> None:
    assert command.page_at(str(tmp_path / "a" / "b.md")) == tmp_path / "a" / "b.md"
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("line", [b"{}", b"[1]", b"null", b"7", b"\xff\xfe", b'{"question": 1}'])
def test_a_line_that_is_no_contest_is_measured_anew(
    line: bytes, asked: list[str], tmp_path: Path
) -> None:
    journal = tmp_path / "bench.jsonl"
    journal.write_bytes(line + b"\n")
    chosen = {"bench_question": bench_question.QUESTION}
    found = command.ask(chosen, [], Size(), journal)
    assert asked == ["quick"] and len(found["bench_question"].records) == 1


@pytest.mark.parametrize(
    ("tool", "note", "is_again"),
    [
        ("kousoku", "fails: OSError: no space left", True),
        ("SymForce", "missing: headers of Eigen are missing; apt-get install libeigen3-dev", True),
        ("no_such_peer", "missing: no_such_peer (none); pip install 'kousoku[bench]'", False),
        ("Exudyn", "fails: SolverError: it diverges", False),
        ("kousoku", TOO_LONG, False),
    ],
)
def test_what_may_end_otherwise_is_asked_again(
    tool: str,
    note: str,
    is_again: bool,
    asked: list[str],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
) -> None:
    def run(name: str, question: Question, contest: str, *_: object) -> list[Record]:
        asked.append(contest)
        return [Record(contest, tool, "a line", "1", note=note)]

    monkeypatch.setattr(command, "run", run)
    chosen = {"bench_question": bench_question.QUESTION}
    for _ in range(2):
        command.ask(chosen, [], Size(), tmp_path / "journal")
    assert asked == ["quick"] * (1 + is_again)


@pytest.mark.usefixtures("one_question")
def test_times_that_a_journal_has_keep_their_date_and_are_told(
    asked: list[str],
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
) -> None:
    monkeypatch.setattr(command, "today", lambda: "2026-11-20")
    assert command.main([]) == 0
    assert "was measured" not in capsys.readouterr().err
    monkeypatch.setattr(command, "today", lambda: "2026-11-26")
    assert command.main(["--full"]) == 0
    said = capsys.readouterr()
    assert "1 of 2 contests was measured before, 2026-11-20" in said.err
    assert str(tmp_path / "journal") in said.err
    assert "Measured 2026-11-20 to 2026-11-26, full run" in said.out
    assert json.loads((tmp_path / "results.json").read_text())["date"] == "2026-11-20 to 2026-11-26"


@pytest.mark.usefixtures("one_question")
def test_a_second_run_at_the_same_time_is_refused(
    asked: list[str],
    capsys: pytest.CaptureFixture[str],
) -> None:
    with command.alone():
        assert command.main([]) == 2
    assert "another run" in capsys.readouterr().err and not asked
    assert command.main([]) == 0


@pytest.mark.usefixtures("one_question")
def test_a_run_that_is_cut_by_hand_says_in_a_line_that_it_goes_on(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def run(*_: object) -> list[Record]:
        raise KeyboardInterrupt

    monkeypatch.setattr(command, "run", run)
    assert command.main([]) == 130
    assert "goes on" in capsys.readouterr().err


@pytest.mark.usefixtures("one_question")
def test_a_disk_that_is_full_is_one_line(
    asked: list[str],
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def full(path: Path, data: bytes) -> None:
        raise OSError(28, "No space left on device", str(path))

    monkeypatch.setattr(command, "write_atomically", full)
    assert command.main([]) == 2
    said = capsys.readouterr().err
    assert "No space left on device" in said and "results.json" in said


@pytest.mark.parametrize("is_full", [False, True])
@pytest.mark.parametrize("name", [*command.questions()])
def test_contests_that_fail_as_a_whole_leave_a_page_and_miss_its_targets(
    name: str, is_full: bool, tmp_path: Path
) -> None:
    size, question = Size(is_full), command.questions()[name]
    records = [
        Record(contest, "kousoku", "all", "", note="fails: CompilerError: none")
        for contest in question.contests(size)
    ]
    answers, chosen = {name: command.Answer(records)}, {name: question}
    page = command.page_of(chosen, answers, size, Figures(tmp_path, "plots"), {})
    missed = [one for one in command.targets_of(chosen, answers) if not one.is_met]
    assert {one.contest for one in missed} >= set(question.contests(size))
    assert "fails: CompilerError: none" in page


def test_the_journal_is_another_one_for_another_size() -> None:
    assert command.journal_of(Size()) == command.journal_of(Size())
    assert command.journal_of(Size()) != command.journal_of(Size(is_full=True))


CANNED = [
    *(
        Record("pendulum", "kousoku", "auto", f"tolerance {error:.0e}", "kousoku", *times, error)
        for error, times in ((1e-6, (2e-3, 3e-3, 7)), (1e-11, (4e-3, 4e-3, 7)))
    ),
    Record("pendulum", "SciPy", "DOP853, index 1", "", "equations", 8e-3, 9e-3, 7, 1e-7),
    Record("pendulum", "heyoka", "Taylor, reduced", "", "reduced", 1e-3, 1e-3, 7, 1e-12),
    Record("pendulum", "MuJoCo", "RK4", "", "scene", note=TOO_LONG),
    Record("pendulum", "CasADi", "IDAS", "", "equations", note="missing: casadi (none); get it"),
]


def test_the_page_says_in_words_where_it_wins(tmp_path: Path) -> None:
    answers = {"solvers": command.Answer(CANNED, 60.0)}
    chosen = {"solvers": solvers.QUESTION}
    figures = Figures(tmp_path / "plots", "plots")
    page = command.page_of(chosen, answers, Size(), figures, {"processor": "a machine"})
    beside = "beside the best tool that gets all bodies, kousoku"
    by_hand = "times as long as with equations that a person reduced by hand first."
    assert page.split("\n\n")[1:3] == [
        f"To an error of 1e-06, {beside}\n- is faster on Pendulum A01, 10 s (4 times);\n"
        f"- takes 2 to 2 {by_hand}",
        f"To an error of 1e-10, {beside}\n- is the only one of these to reach it on Pendulum A01,"
        f" 10 s;\n- takes 4 to 4 {by_hand}",
    ]
    assert "processor: a machine." in page and "Left out: casadi (none); get it." in page
    assert TOO_LONG in page
    assert "![Time against error: Pendulum A01, 10 s](plots/solvers_pendulum.svg)" in page
    root = ElementTree.parse(tmp_path / "plots" / "solvers_pendulum.svg").getroot()
    texts = ["".join(one.itertext()) for one in root.iter("{http://www.w3.org/2000/svg}text")]
    assert {"kousoku auto", "SciPy DOP853, index 1", "heyoka Taylor, reduced"} <= set(texts)


def test_the_targets_of_the_solvers_are_judged_by_the_records() -> None:
    found = {target.quantity: target for target in solvers.targets(CANNED)}
    beside = found["time over the best with all bodies, error 1e-06"]
    assert beside.value == pytest.approx(0.25) and beside.is_met
    slow = [replace(one, fastest=1.0) if one.tool == "kousoku" else one for one in CANNED]
    assert not all(target.is_met for target in solvers.targets(slow))
    tight = [replace(one, setting=solvers.TIGHT) for one in CANNED if one.tool == "kousoku"]
    (promise,) = solvers.targets(tight)
    assert promise.value == 1e-6 and not promise.is_met


@pytest.mark.parametrize(("value", "status"), [(0.5, 0), (1.5, 1), (None, 1)])
def test_check_fails_and_names_the_target_that_is_missed(
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    asked: list[str],
    tmp_path: Path,
    value: float | None,
    status: int,
) -> None:
    judged = [BenchmarkTarget("a contest", "time over a peer's", value, 1.0)]
    question = replace(bench_question.QUESTION, targets=lambda _: judged)
    monkeypatch.setattr(command, "questions", lambda: {"bench_question": question})
    monkeypatch.setattr(command, "BUILD", tmp_path)
    monkeypatch.setattr(command, "journal_of", lambda _: tmp_path / "journal")
    assert command.main(["--check"]) == status
    printed = capsys.readouterr()
    assert ("missed: a contest: time over a peer's" in printed.err) is bool(status)
    data = json.loads((tmp_path / "results.json").read_text())
    assert {"date", "machine", "is_full", "records"} == set(data)
    assert data["records"]["bench_question"][0]["error"] == "inf"
    assert command.main([]) == 0


def test_an_unknown_question_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        command.main(["no_such_question"])
    assert "there is no question 'no_such_question'" in capsys.readouterr().err


def test_an_axis_is_logarithmic_and_may_fall() -> None:
    axis = LogAxis.of([1e-3, 2e1], 0.0, 500.0)
    assert (axis.at(1e-3), axis.at(1e2)) == pytest.approx((0, 500))
    assert axis.at(1e-2) == pytest.approx(100)
    falling = LogAxis.of([1e-3, 2e1], 0.0, 500.0, falls=True)
    assert falling.at(1e2) == pytest.approx(0) and falling.at(1e-3) == pytest.approx(500)


def test_lines_of_a_plot_differ_without_colour_and_labels_do_not_cover_each_other() -> None:
    lines = [ToolLine(f"tool {k}", [(1e-3, 1.0), (1e-6, 2.0 + k / 100)]) for k in range(6)]
    svg = work_precision("A plot", "error", lines)
    root = ElementTree.fromstring(svg)
    named = [
        one
        for one in root.iter("{http://www.w3.org/2000/svg}text")
        if (one.text or "").startswith("tool")
    ]
    heights = sorted(float(one.attrib["y"]) for one in named)
    assert len(heights) == 6
    assert min(b - a for a, b in pairwise(heights)) > 12
    paths = [one.attrib for one in root.iter("{http://www.w3.org/2000/svg}path")]
    drawn = [one["stroke-dasharray"] for one in paths if "stroke-dasharray" in one]
    marks = [one["d"] for one in paths if one.get("fill") == "white"]
    shapes = [mark.split("M")[1].partition("m")[2] for mark in marks]
    assert len(set(zip(drawn, shapes, strict=True))) == 6
