"""Speed of the solvers of scenes: python benchmarks/solvers.py [--check] [--json].

One run, everything on one thread, the programs of a contest in turn and the median of several
rounds; beside each time the error that it bought. A peer that is not installed is named, and what
does not need it is measured all the same. Exit status: 0; 1 with --check if a target is missed or
could not be measured.
"""

from __future__ import annotations

import argparse
import json
import statistics
import sys
import tempfile
import time
from contextlib import suppress
from dataclasses import asdict, dataclass
from importlib.metadata import PackageNotFoundError, version
from itertools import chain
from pathlib import Path

import aba
import chains
import first_step
import four_bars
from peers import MissingPeerError

from kousoku.runtime.toolchain import find_toolchain

ROUNDS = 15
#: Seconds that each program runs in a round.
SLICE = 0.02
FOUR_BAR_ROUNDS, FOUR_BAR_REPEATS = 3, 5
CHAINS = (10, 100)
#: Pinocchio's data hold tensors with the third power of this, 32 GB: its recursion stands for it.
LONG_CHAIN = 1000
#: Bars, and the most seconds from the scene to the first step.
FIRST_STEPS = {10: 3.0, 100: 6.0, 1000: 20.0}
GROWTH = 1.5
START_ROUNDS, STEP_ROUNDS = 3, 7
FOUR_BAR_RATIO = 1 / 60
EQUAL = 1e-9
BY_LOOP, BY_CALL = "Pinocchio, C++ loop", "Pinocchio, from Python"


@dataclass(frozen=True, slots=True)
class Row:
    """One line of the table.

    Parameters
    ----------
    contest, program : str
        What ran.
    time : str
        What it took, with its unit.
    error : str
        What that bought.
    """

    contest: str
    program: str
    time: str
    error: str


@dataclass(frozen=True, slots=True)
class Target:
    """What ``--check`` judges.

    Parameters
    ----------
    contest, quantity : str
        What was measured.
    value, limit : float
        What came out, and the most it may be; ``value`` is None where it could not be measured.
    """

    contest: str
    quantity: str
    value: float | None
    limit: float

    @property
    def is_met(self) -> bool:
        """Whether it was measured and is small enough."""
        return self.value is not None and self.value <= self.limit

    def __str__(self) -> str:
        got = "not measured" if self.value is None else f"{self.value:.3g}"
        return f"{self.contest}: {self.quantity} is {got}, wanted at most {self.limit:.3g}"


class Benchmark:
    """Collects the rows of the table, the targets, and what was missing."""

    def __init__(self) -> None:
        self.rows: list[Row] = []
        self.targets: list[Target] = []
        self.missing: list[str] = []

    def row(self, contest: str, program: str, time: str, error: str) -> None:
        """Add a line to the table."""
        self.rows.append(Row(contest, program, time, error))

    def judge(self, contest: str, quantity: str, value: float | None, limit: float) -> None:
        """Add a target."""
        self.targets.append(Target(contest, quantity, value, limit))


def measure(entries: list[chains.Accelerations]) -> dict[str, list[float]]:
    """Return the seconds of one state in each round of each program, the programs in turn."""
    times: dict[str, list[float]] = {entry.program: [] for entry in entries}
    repeats = {}
    for entry in entries:
        entry.run(1)
        quickest = min(_seconds(entry, 1) for _ in range(5))
        repeats[entry.program] = max(1, int(SLICE / quickest))
    for _ in range(ROUNDS):
        for entry in entries:
            count = repeats[entry.program]
            entry.run(count // 4 + 1)  # its own data are in the caches again
            times[entry.program].append(_seconds(entry, count) / count / chains.STATES)
    return times


def _seconds(entry: chains.Accelerations, count: int) -> float:
    start = time.perf_counter()
    entry.run(count)
    return time.perf_counter() - start


def accelerations(benchmark: Benchmark, folder: Path, peers: Peers) -> None:
    """Accelerations of the chains at 16 states in turn; all programs get the same states."""
    single = measure([aba.called(1)]) if peers.has_pinocchio else {}
    for count in CHAINS:
        contest = f"accelerations of a chain of {count}"
        place = folder / f"chain_{count}"
        place.mkdir()
        entries = [chains.kousoku_accelerations(count, place)]
        if peers.loop is not None:
            entries.append(aba.looped(count, peers.loop))
        if peers.has_pinocchio:
            entries.append(aba.called(count))
        times = measure(entries)
        wanted = chains.reference(count)
        for entry in entries:
            per_bar = statistics.median(times[entry.program]) / count * 1e9
            error = chains.difference(entry.results(), wanted)
            benchmark.row(contest, entry.program, f"{per_bar:.0f} ns a bar", f"{error:.1e}")
        benchmark.judge(contest, "time over Pinocchio's", _ratio(times, single, count), 1.0)
        peer = chains.difference(entries[0].results(), entries[-1].results())
        found = peer if len(entries) > 1 else None
        benchmark.judge(contest, "relative difference from Pinocchio", found, EQUAL)


def long_chain(benchmark: Benchmark, folder: Path) -> None:
    """Compare the accelerations of a long chain with Featherstone's recursion."""
    place = folder / f"chain_{LONG_CHAIN}"
    place.mkdir()
    entry = chains.kousoku_accelerations(LONG_CHAIN, place)
    entry.run(1)
    theta, rate = chains.joint_states(LONG_CHAIN)
    found = chains.bars(theta, rate, chains.recursive(theta, rate))
    error = chains.difference(entry.results(), (found.a, found.alpha_b))
    contest = f"accelerations of a chain of {LONG_CHAIN}"
    benchmark.judge(contest, "relative difference from the recursion", error, EQUAL)


def _ratio(
    times: dict[str, list[float]], single: dict[str, list[float]], count: int
) -> float | None:
    """Return kousoku's time over Pinocchio's, median of the rounds.

    Without the loop a call from Python stands for it; what the call itself takes is not counted:
    it is what a chain of one bar takes, less one of the bars of the long chain.
    """
    ours = times["kousoku"]
    if BY_LOOP in times:
        return statistics.median(a / b for a, b in zip(ours, times[BY_LOOP], strict=True))
    if BY_CALL not in times:
        return None
    alone = statistics.median(single[BY_CALL])
    bars = count / (count - 1)
    pairs = zip(ours, times[BY_CALL], strict=True)
    return statistics.median(a / ((b - alone) * bars) for a, b in pairs)


def bars_of_40(benchmark: Benchmark, folder: Path, peers: Peers) -> None:
    """Run the N-four-bar over 10 s: where each program ends, and how long it takes."""
    contest = f"N-four-bar, N = {four_bars.COUNT}, 10 s"
    solver = four_bars.load(folder)
    chosen = four_bars.cheapest(solver)
    if chosen is None:
        benchmark.judge(contest, "time over Exudyn's", None, FOUR_BAR_RATIO)
        return
    tolerance, method = chosen
    ratios: list[float] = []
    runs: dict[str, list[four_bars.Reached]] = {}
    for _ in range(FOUR_BAR_ROUNDS):
        peer = peers.exudyn.run() if peers.exudyn else None
        if peer:
            runs.setdefault("Exudyn, 10,000 steps", []).append(peer)
        for rows in (2, four_bars.ROWS):
            program = f"kousoku, {method}, tolerance {tolerance:.0e}, {rows} rows"
            for _ in range(FOUR_BAR_REPEATS):
                ours = four_bars.kousoku_run(solver, tolerance, method, rows)
                runs.setdefault(program, []).append(ours)
                if peer and rows == 2:
                    ratios.append(ours.seconds / peer.seconds)
    for program, found in runs.items():
        seconds = statistics.median(one.seconds for one in found)
        last = found[-1]
        error = f"{last.position:.1e} m, {last.energy:.1e} J"
        benchmark.row(contest, program, f"{seconds * 1e3:.1f} ms", error)
    value = statistics.median(ratios) if ratios else None
    benchmark.judge(contest, "time over Exudyn's", value, FOUR_BAR_RATIO)


def first_steps(benchmark: Benchmark) -> None:
    """From the scene to the first step, with an empty cache; then the time of a step, in turn."""
    starts = [[first_step.started(count) for count in FIRST_STEPS] for _ in range(START_ROUNDS)]
    rounds = [[one.per_bar() for one in starts[-1]] for _ in range(STEP_ROUNDS)]
    for one in chain.from_iterable(starts):
        one.end()
    seconds = [statistics.median(one.seconds for one in same) for same in zip(*starts, strict=True)]
    per_bar = (statistics.median(times) for times in zip(*rounds, strict=True))
    for (count, limit), first, step in zip(FIRST_STEPS.items(), seconds, per_bar, strict=True):
        contest = f"chain of {count}"
        told = f"{first:.2f} s to the first step"
        benchmark.row(contest, "kousoku", told, f"{step * 1e6:.2f} µs a step and bar")
        benchmark.judge(contest, "seconds from scene to first step", first, limit)
    growth = statistics.median(max(times) / min(times) for times in rounds)
    benchmark.judge("chains", "spread of the time of a step and bar", growth, GROWTH)


@dataclass(frozen=True, slots=True)
class Peers:
    """What there is to compare with.

    Parameters
    ----------
    has_pinocchio : bool
        Whether it is installed.
    loop : Path or None
        The library of the loop over its algorithm, where that compiles.
    exudyn : four_bars.Exudyn or None
        The set-up of its model, where it is installed.
    """

    has_pinocchio: bool
    loop: Path | None
    exudyn: four_bars.Exudyn | None


def find_peers(benchmark: Benchmark, folder: Path) -> Peers:
    """Find what is installed, and note what is not."""
    has_pinocchio, loop, exudyn = False, None, None
    try:
        aba.called(1)
        has_pinocchio = True
        loop = aba.build_loop(folder)
    except MissingPeerError as error:
        benchmark.missing.append(str(error))
    try:
        exudyn = four_bars.Exudyn()
    except MissingPeerError as error:
        benchmark.missing.append(str(error))
    return Peers(has_pinocchio, loop, exudyn)


def run_all() -> Benchmark:
    """Run every contest."""
    benchmark = Benchmark()
    first_steps(benchmark)  # each a process: before this one fills memory with peers
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        peers = find_peers(benchmark, folder)
        accelerations(benchmark, folder, peers)
        long_chain(benchmark, folder)
        place = folder / "four_bars"
        place.mkdir()
        bars_of_40(benchmark, place, peers)
    return benchmark


def described() -> list[str]:
    """Say what ran and where."""
    programs = []
    for name in ("kousoku", "numpy", "pin", "exudyn"):
        with suppress(PackageNotFoundError):
            programs.append(f"{name} {version(name)}")
    return [", ".join(programs), find_toolchain().name]


def report(benchmark: Benchmark, *, as_json: bool) -> None:
    """Print the table, and what was missed."""
    if as_json:
        data = {
            "programs": described(),
            "rows": [asdict(row) for row in benchmark.rows],
            "targets": [asdict(one) | {"is_met": one.is_met} for one in benchmark.targets],
            "missing": benchmark.missing,
        }
        print(json.dumps(data, indent=2))
        return
    print("\n".join(described()))
    for row in benchmark.rows:
        print(f"{row.contest:32} {row.program:45} {row.time:>26}   {row.error}")
    for target in benchmark.targets:
        print(f"{'met   ' if target.is_met else 'MISSED'} {target}")


def main() -> int:
    """Run the benchmark and return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n", maxsplit=1)[0])
    parser.add_argument("--check", action="store_true", help="exit 1 if a target is missed")
    parser.add_argument("--json", action="store_true", help="print JSON")
    options = parser.parse_args()
    benchmark = run_all()
    report(benchmark, as_json=options.json)
    for reason in benchmark.missing:
        print(f"left out: {reason}", file=sys.stderr)
    missed = [target for target in benchmark.targets if not target.is_met]
    if options.check:
        for target in missed:
            print(target, file=sys.stderr)
    return int(options.check and bool(missed))


if __name__ == "__main__":
    sys.exit(main())
