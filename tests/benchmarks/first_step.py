"""From scene to first step: what each stage takes, how it grows, and what peers need to set up."""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from kousoku.model.reading.families import chain
from kousoku.model.reading.write import to_toml
from kousoku.runtime.toolchain import EXTENSION
from tests.benchmarks.kit import (
    BenchmarkTarget,
    Case,
    Figures,
    Kind,
    Question,
    Record,
    Size,
    bullet_list,
    duration,
    fastest_and_median,
    table,
)
from tests.benchmarks.limits import size_text
from tests.benchmarks.loops import started
from tests.benchmarks.plots import ToolLine, growth
from tests.benchmarks.race import CAP, MISSING, TOO_LONG
from tests.benchmarks.stages import ORDER, PEERS, WARMED

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from contextlib import AbstractContextManager

    from tests.benchmarks.race import Workers

ROOT = Path(__file__).parents[2]
BARS, QUICK_BARS = (1, 3, 10, 30, 100, 300, 1000, 3000, 10_000), (1, 10, 100)
#: How often: a chain of many bars once, since it is long.
ROUNDS, FEW, MANY = 3, 1, 1000
SETTINGS = {"empty": "empty caches", "warm": "warm process", "found": "found by content"}
MODEL = "model and first evaluation"
#: Pinocchio's data hold tensors with the third power of this.
MOST_JOINTS = 300
#: Bars, and the most seconds from the scene to the first step with empty caches.
FIRST_STEPS = {10: 3.0, 100: 6.0, 1000: 20.0}
#: The contest of steps, which of its chains may cost more per bar, and how often they are timed.
STEPS, GROWTH, STEP_ROUNDS = "steps of chains", 1.5, 7
TOTAL = "total"


def contests(size: Size) -> list[str]:
    """Contest for each chain; in the full run steps of three of them, too."""
    names = [name_of(count) for count in (BARS if size.is_full else QUICK_BARS)]
    return [*names, STEPS] if size.is_full else names


def name_of(count: int) -> str:
    """Contest of a chain."""
    return f"chain of {count}"


def bars_of(contest: str) -> int:
    """Bars of a contest."""
    return int(contest.rpartition(" ")[2])


def cases(_contest: str, _size: Size) -> list[Case]:
    """Nothing: each measurement is a process of its own."""
    return []


def run(contest: str, size: Size, _workers: Workers) -> list[Record]:
    """Measure a chain, all programs in turn."""
    if contest == STEPS:
        return steps()
    count = bars_of(contest)
    rounds = ROUNDS if size.is_full and count < MANY else FEW
    with tempfile.TemporaryDirectory() as name:
        place = Path(name)
        file = scene_file(place, count)
        scene_file(place, WARMED)
        found: dict[tuple[str, str], list[ProcessAnswer]] = {}
        for k in range(rounds):
            cache = place / f"cache_{k}"
            for how, setting in SETTINGS.items():
                if how == "warm" and not size.is_full:
                    continue
                own = place / f"warm_{k}" if how == "warm" else cache
                answer = ask(how, count, file, own)
                if how == "empty":
                    answer.sizes["bytes of the library"] = library_size(own)
                found.setdefault(("kousoku", setting), []).append(answer)
                if answer.note:  # what it would find is not there, and a second one is as late
                    break
            for peer in PEERS:
                found.setdefault((peer, MODEL), []).append(ask(peer, count, file, cache))
    return [
        record
        for (tool, line), answers in found.items()
        for record in records_of(contest, tool, line, answers)
    ]


@dataclass(slots=True)
class ProcessAnswer:
    """Answer of a process.

    Parameters
    ----------
    seconds : dict of float
        By stage.
    sizes : dict of float
        Bytes of memory and code.
    note : str
        Why there is nothing: it was late, or failed.
    """

    seconds: dict[str, float]
    sizes: dict[str, float]
    note: str = ""


def scene_file(folder: Path, count: int) -> Path:
    """Write the scene of a chain, and return its file."""
    file = folder / f"chain_{count}.toml"
    file.write_text(to_toml(chain(count)), encoding="utf-8")
    return file


def process(
    how: str, count: int, file: Path, cache: Path
) -> AbstractContextManager[subprocess.Popen[str]]:
    """Process of :mod:`tests.benchmarks.stages`, which is ended with all that it started."""
    command = [sys.executable, "-m", "tests.benchmarks.stages", how, str(count), str(time.time())]
    environment = {**os.environ, "KOUSOKU_CACHE": str(cache)}
    return started([*command, str(file)], cwd=ROOT, env=environment, stdin=subprocess.PIPE)


def ask(how: str, count: int, file: Path, cache: Path) -> ProcessAnswer:
    """Times of a process from its begin to the first step."""
    if how == "Pinocchio" and count > MOST_JOINTS:
        return ProcessAnswer({}, {}, f"not run: its data hold {count}³ numbers")
    with process(how, count, file, cache) as own:
        try:
            said, complained = own.communicate(timeout=CAP)
        except subprocess.TimeoutExpired:
            return ProcessAnswer({}, {}, TOO_LONG)
    if own.returncode:
        reason = (complained.strip().splitlines() or [f"exit status {own.returncode}"])[-1]
        return ProcessAnswer({}, {}, f"fails: {reason[:120]}")
    data: dict[str, Any] = json.loads(said.splitlines()[-1])
    if "missing" in data:
        return ProcessAnswer({}, {}, f"{MISSING}{data['missing']}")
    return ProcessAnswer(data["seconds"], data["sizes"])


def library_size(cache: Path) -> float:
    """Bytes of the library that the compiler made."""
    return float(sum(path.stat().st_size for path in cache.glob(f"lib/chain_*/*{EXTENSION}")))


def records_of(
    contest: str, tool: str, line: str, answers: Sequence[ProcessAnswer]
) -> Iterator[Record]:
    """Record of the whole way, then one for each stage."""
    good = [one for one in answers if not one.note]
    kind: Kind = "kousoku" if tool == "kousoku" else "scene"
    if not good:
        yield Record(contest, tool, line, TOTAL, kind, note=answers[0].note)
        return
    stages: dict[str, list[float]] = {TOTAL: [sum(one.seconds.values()) for one in good]}
    for stage in dict.fromkeys(name for one in good for name in one.seconds):
        stages[stage] = [one.seconds.get(stage, 0.0) for one in good]
    for stage, times in stages.items():
        fastest, median = fastest_and_median(times)
        sizes = good[-1].sizes if stage == TOTAL else {}
        yield Record(contest, tool, line, stage, kind, fastest, median, len(times), extra=sizes)


def steps() -> list[Record]:
    """Cost of a step per bar, of chains that run in turn."""
    found: dict[int, list[float]] = {count: [] for count in FIRST_STEPS}
    with tempfile.TemporaryDirectory() as name, ExitStack() as stack:
        place = Path(name)
        running = {
            count: stack.enter_context(
                process("steps", count, scene_file(place, count), place / "cache")
            )
            for count in FIRST_STEPS
        }
        for one in running.values():
            _line(one)  # it has made its first step
        for _ in range(STEP_ROUNDS):
            for count, one in running.items():
                print(file=one.stdin, flush=True)
                found[count].append(float(_line(one)))
    rounds = zip(*found.values(), strict=True)
    spread = statistics.median(max(times) / min(times) for times in rounds)
    more = {"spread": spread}
    return [
        Record(
            STEPS,
            "kousoku",
            name_of(count),
            "a step and bar",
            "kousoku",
            *fastest_and_median(times),
            len(times),
            extra=more,
        )
        for count, times in found.items()
    ]


def _line(running: subprocess.Popen[str]) -> str:
    """Next line that a process prints."""
    assert running.stdout is not None
    said = running.stdout.readline()
    if not said:
        raise RuntimeError(f"the process of a chain ended: {running.communicate()[1][-500:]}")
    return said


# ---------------------------------------------------------------- the page


def targets(records: Sequence[Record]) -> list[BenchmarkTarget]:
    """Targets that the page promises of chains that were run."""
    found = []
    for one in records:
        if one.setting == TOTAL and one.line == SETTINGS["empty"]:
            limit = FIRST_STEPS.get(bars_of(one.contest))
            if limit is not None:
                quantity = "seconds from scene to first step"
                found.append(BenchmarkTarget(one.contest, quantity, one.median, limit))
    timed = [one for one in records if one.contest == STEPS]
    if timed:
        spread = timed[0].extra.get("spread")
        found.append(
            BenchmarkTarget(STEPS, "largest over smallest time of a step and bar", spread, GROWTH)
        )
    return found


def body(records: Sequence[Record], figures: Figures) -> str:
    """Tables: stages, how they grow, sizes, peers; and a plot of all totals."""
    own = [one for one in records if one.contest != STEPS]
    if not own:
        return _of_steps(records)
    counts = sorted({bars_of(one.contest) for one in own})
    by = {(bars_of(one.contest), one.tool, one.line, one.setting): one for one in own}
    parts = [_stages(by, counts), _sizes(by, counts), _peers(by, counts), _of_steps(records)]
    lines = []
    for tool, line in dict.fromkeys((one.tool, one.line) for one in own):
        points = [
            (float(n), one.median)
            for n in counts
            if (one := by.get((n, tool, line, TOTAL))) and one.median
        ]
        label = f"{tool}, {line}" if tool == "kousoku" else tool
        lines.append(ToolLine(label, points, is_bold=tool == "kousoku"))
    drawn = growth("from scene to first step", "bars of a chain", lines)
    if drawn:
        parts.append(figures.add("first_step", drawn, "seconds to the first step over bars"))
    return "\n\n".join(filter(None, parts))


By = dict[tuple[int, str, str, str], Record]


def _cell(one: Record | None) -> str:
    if one is None:
        return ""
    return one.note or duration(one.median)


def _stages(by: By, counts: Sequence[int]) -> str:
    """Time of each stage, a line a chain, and how it grows."""
    heads = ["bars", *(x for x in ORDER), *(f"**{setting}**" for setting in SETTINGS.values())]
    rows = []
    for n in counts:
        stages = [_cell(by.get((n, "kousoku", SETTINGS["empty"], stage))) for stage in ORDER]
        totals = [_cell(by.get((n, "kousoku", line, TOTAL))) for line in SETTINGS.values()]
        rows.append([str(n), *stages, *totals])
    columns = [(SETTINGS["empty"], stage) for stage in ORDER]
    columns += [(line, TOTAL) for line in SETTINGS.values()]
    slopes = [_slope(by, counts, *column) for column in columns]
    rows.append(["a bar more", *(duration(per_bar) if per_bar else "" for per_bar, _ in slopes)])
    rows.append(["~ bars ^", *(f"{power:.2f}" if power else "" for _, power in slopes)])
    return table(heads, rows)


def _slope(
    by: By, counts: Sequence[int], line: str, stage: str
) -> tuple[float | None, float | None]:
    """Seconds of a bar more, and the power that the time of long chains grows with."""
    points = [
        (n, one.median)
        for n in counts
        if (one := by.get((n, "kousoku", line, stage))) and one.median
    ]
    return slope(points)


def slope(points: Sequence[tuple[int, float]]) -> tuple[float | None, float | None]:
    """Slope of a line through all points, and the power through the longer half.

    The line is as near as possible relative to each time; what does not grow has no power.
    """
    if len(points) < 3:
        return None, None
    n, t = np.array(points, dtype=float).T
    per_bar = float(np.polyfit(n, t, 1, w=1 / t)[0])
    long = n >= np.sqrt(n[-1] * n[0])
    power = float(np.polyfit(np.log(n[long]), np.log(t[long]), 1)[0])
    return max(per_bar, 0.0), power


def _sizes(by: By, counts: Sequence[int]) -> str:
    """Sizes of code, and memory of generating and running."""
    rows = []
    for n in counts:
        empty = by.get((n, "kousoku", SETTINGS["empty"], TOTAL))
        if empty is not None and empty.note:
            rows.append([str(n), empty.note, *[""] * 6])
            continue
        found = by.get((n, "kousoku", SETTINGS["found"], TOTAL))
        cells = [
            _size(empty, "bytes of C"),
            _size(empty, "bytes of the library"),
            _size(empty, "bytes of a run"),
            _size(empty, "memory"),
            _size(empty, "memory of the compiler"),
            _size(found, "memory"),
            _size(found, "memory before"),
        ]
        rows.append([str(n), *cells])
    heads = ["bars", "text in C", "library", "state and workspace", "generating: most memory"]
    return table([*heads, "compiler", "running: most memory", "of that before"], rows)


def _size(one: Record | None, name: str) -> str:
    if one is None or name not in one.extra:
        return "" if one is None else one.note
    return size_text(one.extra[name])


def _peers(by: By, counts: Sequence[int]) -> str:
    """Times of peers from their model to the first evaluation."""
    rows = []
    for n in counts:
        cells = []
        for peer in PEERS:
            whole = by.get((n, peer, MODEL, TOTAL))
            stages = [
                duration(one.median)
                for stage in ("import", "build", "first step")
                if (one := by.get((n, peer, MODEL, stage)))
            ]
            memory = f", {_size(whole, 'memory')}" if whole and not whole.note else ""
            told = f"{_cell(whole)} ({' + '.join(stages)}{memory})" if stages else _cell(whole)
            cells.append(told)
        rows.append([str(n), *cells])
    heads = [f"{peer}: all (import + build + first evaluation, memory)" for peer in PEERS]
    return table(["bars", *heads], rows)


def _of_steps(records: Sequence[Record]) -> str:
    rows = [[one.line, _cell(one)] for one in records if one.contest == STEPS]
    return table(("", "a step and bar"), rows) if rows else ""


def words(records: Sequence[Record]) -> str:
    """List of how long it takes from a scene to its first step."""
    told = []
    for one in records:
        if one.setting == TOTAL and one.line == SETTINGS["empty"] and one.contest != STEPS:
            same = [other for other in records if other.contest == one.contest]
            found = [x for x in same if x.setting == TOTAL and x.line == SETTINGS["found"]]
            peers = [x for x in same if x.setting == TOTAL and x.line == MODEL and x.median]
            best = min(peers, key=lambda x: x.median or 0.0, default=None)
            if one.median and found and best and bars_of(one.contest) in FIRST_STEPS:
                told.append(
                    f"{_cell(one)} for {bars_of(one.contest)} bars, {_cell(found[0])} when it is"
                    f" found by its content, {_cell(best)} with {best.tool}"
                )
    return bullet_list("From a scene to its first step it takes", told) if told else ""


QUESTION = Question(
    title="From scene to first step",
    asks="""\
How long does it take from a scene file to the first step, and what does it need?

Chains of bars on hinges, each measurement in a process of its own: with empty caches; in a process
that has loaded a chain of two bars before; and with the caches that the first one filled. Stages
with empty caches: `start` of Python, `import` of all modules, `look up` in the cache, `read` and
check the scene, `analyse` its freedoms and dependent rows, `compose` its program, `print` and write
its files, `compile` them with the flags that ship, `load`, and the first step of 1e-6 s. A case
ends after 30 s. Slopes: a line through all chains, and the power of n through the longer half of
them (on a logarithmic scale). Memory is the most that a process had; "before" is after the imports.

Peers build the same chain with their own functions (Exudyn a kinematic tree, MuJoCo body by body,
Pinocchio joint by joint) and evaluate it once.""",
    contests=contests,
    cases=cases,
    body=body,
    targets=targets,
    words=words,
    run=run,
)
