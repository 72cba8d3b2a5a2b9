"""A contest: its cases in turn, each tool in a process of its own that is ended when it is late."""

from __future__ import annotations

import gc
import json
import os
import time
from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING, Any

from tests.benchmarks.kit import (
    Call,
    Case,
    PeerMissingError,
    Record,
    Size,
    fastest_and_median,
    rounds_of,
    seconds_of,
    slice_of,
)
from tests.stress.workers import StoppedError, Worker

if TYPE_CHECKING:
    from collections.abc import Callable

#: The longest time [s] of one call, and of what is not timed: to set it up, and to judge it.
CAP, SET_UP = 30.0, 120.0
#: A call that is shorter [s] is tried three times: the first one finds cold caches.
SHORT_CALL = 0.05
#: How the note of a case begins whose tool is not installed.
MISSING = "missing: "
#: Whose lines run first, and what the first case of another line is taken to cost [s].
OURS, UNKNOWN = "kousoku", 1.0
TOO_LONG = f"> {CAP:g} s"
#: One thread each: a library that divides its work would be measured against one that does not.
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "EXUDYN_NUM_THREADS")

RaceAnswer = dict[str, Any]

_prepared: dict[str, Call] = {}


@cache
def _cases(question: str, contest: str, is_full: bool) -> list[Case]:
    found: list[Case] = import_module(question).QUESTION.cases(contest, Size(is_full))
    return found


def answer(question: str, command: str) -> RaceAnswer:
    """Do a part of a case in the process of its tool: set it up, run it, judge it, or time it."""
    wanted = json.loads(command)
    key = json.dumps([wanted["contest"], wanted["case"], wanted["full"]])
    if wanted["do"] == "forget":
        _prepared.clear()
        _cases.cache_clear()
        gc.collect()
        return {}
    start = time.perf_counter()
    if key not in _prepared:
        case = _cases(question, wanted["contest"], wanted["full"])[wanted["case"]]
        try:
            _prepared[key] = case.prepare()
        except PeerMissingError as error:
            return {"missing": f"{MISSING}{error}"}
    call = _prepared[key]
    if wanted["do"] == "prepare":
        return {"seconds": time.perf_counter() - start}
    if wanted["do"] == "judge":
        judged = call.judge()
        return {"error": judged.error, "extra": judged.extra}
    gc.disable()
    try:
        about = wanted.get("about")
        seconds = _trial(call) if about is None else slice_of(call.run, about)
    finally:
        gc.enable()
    return {"seconds": seconds, "count": call.count}


def _trial(call: Call) -> float:
    """Seconds of a first call, or of the fastest of three where that is short."""
    seconds = seconds_of(call.run)
    if seconds >= SHORT_CALL:
        return seconds
    return min(seconds, *(seconds_of(call.run) for _ in range(2)))


class Workers:
    """The processes of tools; each is started when it is first wanted.

    Parameters
    ----------
    question : str
        The module of their question, such as ``tests.benchmarks.solvers``.
    size : Size
        How much is measured.
    """

    def __init__(self, question: str, size: Size) -> None:
        self.question, self.size = question, size
        self._workers: dict[str, Worker[RaceAnswer]] = {}
        for name in THREADS:
            os.environ.setdefault(name, "1")

    def ask(
        self, tool: str, seconds: float, do: str, contest: str, case: int = 0, **more: Any
    ) -> RaceAnswer:
        """Let the process of a tool do a part of a case.

        Raises
        ------
        StoppedError
            It took longer than so many seconds, failed, or ended its process.
        """
        if tool not in self._workers:
            self._workers[tool] = Worker(answer)
        command = {"do": do, "contest": contest, "case": case, "full": self.size.is_full, **more}
        return self._workers[tool].run(self.question, json.dumps(command), seconds)

    def forget(self, contest: str) -> None:
        """Let all processes forget the cases of a contest."""
        for tool in self._workers:
            self.ask(tool, SET_UP, "forget", contest)

    def stop(self) -> None:
        """End all processes."""
        for worker in self._workers.values():
            worker.stop()
        self._workers.clear()


def race(
    contest: str,
    cases: list[Case],
    workers: Workers,
    seconds: float,
    tell: Callable[[str], object] = lambda _: None,
) -> list[Record]:
    """Records of all cases, which run in turn.

    First each case is set up, runs once and is judged; those that are short enough then run in
    rounds, all in turn, so that a busy moment of the machine meets all alike. A line ends where
    one of its cases takes longer than the cap, and a tool that is missing is tried once.

    Parameters
    ----------
    contest : str
        Its name.
    cases : list of Case
        As the question gives them.
    workers : Workers
        The processes of tools.
    seconds : float
        Cases that have not begun by then are left out, and say so; what it takes to set kousoku
        up does not count.
    tell : callable
        Is called with what runs now.
    """
    records = [Record(contest, case.tool, case.line, case.setting, case.kind) for case in cases]
    late = time.monotonic() + seconds
    missing: dict[str, str] = {}
    waiting: dict[tuple[str, str], list[int]] = {}
    for k, case in enumerate(cases):
        waiting.setdefault((case.tool, case.line), []).append(k)
    # What a line cost last. Those that are cheap run to their ends first, and kousoku's before all:
    # what there is no time left for is the slowest.
    cost = {line: 0.0 if line[0] == OURS else UNKNOWN for line in waiting}
    while cost:
        line = min(cost, key=lambda one: cost[one])
        record = records[k := waiting[line].pop(0)]
        tell(f"{contest}: {record.tool} {record.line} {record.setting}")
        start = time.monotonic()
        if record.tool in missing:
            record.note = missing[record.tool]
        elif start > late:
            record.note = "not run: the time of the contest was over"
        else:
            _try(record, k, workers)
            if record.tool == OURS:  # a large solver is generated and compiled once
                late += record.extra.get("setup", 0.0)
            cost[line] = 0.0 if record.tool == OURS else time.monotonic() - start
            if record.note.startswith(MISSING):
                missing[record.tool] = record.note
            if record.note == TOO_LONG:
                for after in waiting[line]:
                    records[after].note = TOO_LONG
                waiting[line].clear()
        if not waiting[line]:
            del cost[line]
    _time_in_turn(contest, records, workers, late, tell)
    workers.forget(contest)
    return records


def _time_in_turn(
    contest: str,
    records: list[Record],
    workers: Workers,
    late: float,
    tell: Callable[[str], object],
) -> None:
    """Run the cases that are short enough in rounds, and tell the fastest and the median.

    When it is late one round is made, so that times of one contest are of one kind.
    """
    times: dict[int, list[float]] = {k: [] for k, one in enumerate(records) if one.fastest}
    most = {k: rounds_of(records[k].fastest or 0.0) for k in times}
    for r in range(max(most.values(), default=0)):
        if r and time.monotonic() > late:
            break
        tell(f"{contest}: round {r + 1}")
        for k, found in times.items():
            if r < most[k]:
                _time(records[k], k, found, workers)
    for k, found in times.items():
        record = records[k]
        all_times = found or [record.fastest or 0.0]  # a long one ran once
        record.rounds = len(all_times)
        count = int(record.extra.pop("count", 1))
        record.fastest, record.median = fastest_and_median(all_times, count)


def _try(record: Record, k: int, workers: Workers) -> None:
    """Set a case up, run it once, and judge it."""
    try:
        ready = workers.ask(record.tool, SET_UP, "prepare", record.contest, k)
        if "missing" in ready:
            record.note = ready["missing"]
            return
        record.extra["setup"] = ready["seconds"]
    except StoppedError as error:
        record.note = f"not set up: {error}"
        return
    try:
        ran = workers.ask(record.tool, CAP, "run", record.contest, k)
    except StoppedError as error:
        record.note = TOO_LONG if "takes longer" in str(error) else f"fails: {error}"
        return
    record.fastest = ran["seconds"]
    record.extra["count"] = float(ran["count"])
    try:
        judged = workers.ask(record.tool, SET_UP, "judge", record.contest, k)
        record.error = judged["error"]
        record.extra |= judged["extra"]
    except StoppedError as error:
        record.note = f"not judged: {error}"


def _time(record: Record, k: int, times: list[float], workers: Workers) -> None:
    """Run a case for one round."""
    try:
        ran = workers.ask(
            record.tool, CAP + SET_UP, "time", record.contest, k, about=record.fastest
        )
        times.append(ran["seconds"])
    except StoppedError as error:
        record.note = record.note or f"fails in rounds: {error}"
