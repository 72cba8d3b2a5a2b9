"""The benchmark of first steps: each stage is there and counted once, what is late is ended."""

import os
import sys
import time
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace

import pytest

from kousoku.runtime.toolchain import Toolchain
from tests.benchmarks import first_step, stages
from tests.benchmarks.kit import Figures, Record, Size
from tests.benchmarks.race import TOO_LONG, Workers


def test_while_a_stage_runs_inside_of_another_that_one_waits(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    now = 0.0

    def later(seconds: float) -> None:
        nonlocal now
        now += seconds

    monkeypatch.setattr(time, "perf_counter", lambda: now)
    clock, module = stages.Clock(), SimpleNamespace(inner=later)
    clock.watch("inner", module, "inner")
    later(100.0)
    with clock.stage("outer"):
        later(1.0)
        module.inner(2.0)
        with clock.stage("third"):
            module.inner(4.0)
            later(8.0)
        later(16.0)
    later(100.0)
    assert clock.seconds == {"outer": 17.0, "inner": 6.0, "third": 8.0}


def test_every_function_of_a_stage_is_there() -> None:
    for stage, modules in stages.STAGES.items():
        assert stage in stages.ORDER
        for module, names in modules.items():
            for name in names:
                assert callable(getattr(import_module(module), name)), f"{module}.{name}"


def test_a_first_step_has_all_stages_and_what_is_found_is_not_made_again(
    compiler: Toolchain, tmp_path: Path
) -> None:
    ballast = b"x" * (300 << 20)
    file = first_step.scene_file(tmp_path, 3)
    first_step.scene_file(tmp_path, stages.WARMED)
    start = time.monotonic()
    empty = first_step.ask("empty", 3, file, tmp_path / "cache")
    took = time.monotonic() - start
    assert empty.note == ""
    assert set(empty.seconds) == set(stages.ORDER)
    assert all(seconds > 0 for seconds in empty.seconds.values())
    assert sum(empty.seconds.values()) < took
    assert empty.seconds["compile"] > empty.seconds["load"]
    found = first_step.ask("found", 3, file, tmp_path / "cache")
    assert found.note == "" and found.sizes["bytes of C"] == empty.sizes["bytes of C"] > 1e4
    assert not {"read", "analyse", "compose", "print", "compile"} & set(found.seconds)
    assert first_step.library_size(tmp_path / "cache") > 1e4
    if sys.platform == "linux":  # not that of the process that started it
        assert 1e7 < found.sizes["memory"] < len(ballast)
    warm = first_step.ask("warm", 3, file, tmp_path / "warm")
    assert warm.seconds["import"] < empty.seconds["import"]
    assert "start" not in warm.seconds and warm.seconds["compile"] > 0


def test_a_process_that_is_late_is_ended_with_what_it_started(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    file = first_step.scene_file(tmp_path, 3)
    monkeypatch.setattr(first_step, "CAP", 0.2)
    with first_step.process("empty", 3, file, tmp_path / "cache") as own:
        pid = own.pid
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)
    answer = first_step.ask("empty", 3, file, tmp_path / "cache")
    assert answer.note == TOO_LONG and not answer.seconds


def test_a_late_chain_is_not_looked_for_in_the_cache(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    asked: list[str] = []

    def ask(how: str, *_: object) -> first_step.ProcessAnswer:
        asked.append(how)
        return first_step.ProcessAnswer({}, {}, TOO_LONG)

    monkeypatch.setattr(first_step, "ask", ask)
    records = first_step.run(first_step.name_of(3), Size(), Workers("none", Size()))
    assert asked == ["empty", *stages.PEERS]
    assert {one.note for one in records} == {TOO_LONG}
    assert first_step.body(records, Figures(tmp_path, "here")).count(TOO_LONG) > 1


def test_pinocchio_is_not_asked_for_what_takes_all_memory(tmp_path: Path) -> None:
    answer = first_step.ask("Pinocchio", 1000, tmp_path / "none.toml", tmp_path)
    assert answer.note == "not run: its data hold 1000³ numbers"


def test_a_line_has_its_slope_and_a_power_its_exponent() -> None:
    per_bar, _ = first_step.slope([(n, 2.0 + 3.0 * n) for n in (1, 10, 100, 1000)])
    assert per_bar == pytest.approx(3.0)
    _, power = first_step.slope([(n, 1e-6 * n**2) for n in (1, 3, 10, 30, 100)])
    assert power == pytest.approx(2.0)
    assert first_step.slope([(1, 1.0), (10, 2.0)]) == (None, None)


def totals(*counts: int) -> list[Record]:
    empty = first_step.SETTINGS["empty"]
    return [
        Record(first_step.name_of(n), "kousoku", empty, first_step.TOTAL, "kousoku", 3.0, 3.0, 1)
        for n in counts
    ]


def test_targets_judge_three_chains_and_the_growth_of_steps() -> None:
    found = first_step.targets(totals(1, 10, 100, 1000))
    assert [(one.limit, one.is_met) for one in found] == [(3.0, True), (6.0, True), (20.0, True)]
    late = totals(10)
    late[0].median, late[0].note = None, TOO_LONG
    (missed,) = first_step.targets(late)
    assert not missed.is_met
    names = (first_step.STEPS, "kousoku", "chain of 10", "a step and bar")
    (growth,) = first_step.targets([Record(*names, fastest=1e-6, extra={"spread": 1.6})])
    assert growth.limit == 1.5 and not growth.is_met


def test_the_page_tells_stages_sizes_and_peers(tmp_path: Path) -> None:
    records = totals(1, 10, 100)
    records[1].extra = {"bytes of C": 2048.0, "memory": 2.0 * (1 << 20)}
    peer = Record(first_step.name_of(10), "Exudyn", first_step.MODEL, first_step.TOTAL, "scene")
    peer.median = 0.25
    page = first_step.body([*records, peer], Figures(tmp_path, "here"))
    assert "| 10 | 2 kB |  |  | 2 MB |" in page
    assert "250 ms" in page and "here/first_step.svg" in page
    assert (tmp_path / "first_step.svg").exists()


def test_a_contest_that_fails_is_told_and_misses_its_targets(tmp_path: Path) -> None:
    failed = Record(first_step.STEPS, "kousoku", "all", "", note="fails: RuntimeError: ended")
    page = first_step.body([*totals(10), failed], Figures(tmp_path, "here"))
    assert "fails: RuntimeError: ended" in page
    *_, growth = first_step.targets([*totals(10), failed])
    assert growth.value is None and not growth.is_met
