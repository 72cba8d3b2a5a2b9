"""Speed of a kernel: python benchmarks/kernels.py [--check] [--json].

One run, everything on one thread, the programs of a contest in turn and the median of several
rounds; beside each time the worst error against 50 digits. A peer that is not installed is an
error. Exit status: 0; 1 with --check if a target is missed; 2 if a peer is missing.
"""

from __future__ import annotations

import argparse
import json
import platform
import statistics
import sys
import tempfile
import time
from dataclasses import asdict, dataclass
from functools import partial
from importlib.metadata import version
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from benchmarks.kernel_peers import heyoka_functions, lambdified, stacked
from benchmarks.kit import MissingError
from benchmarks.loops import Batch, casadi_loop, kousoku_loop, symforce_loop
from benchmarks.p2 import N_IN, N_OUT, SAMPLE, Judge, aligned, inputs
from kousoku import runtime
from kousoku.runtime.importing import import_source
from kousoku.runtime.toolchain import find_toolchain

if TYPE_CHECKING:
    from collections.abc import Callable
    from types import ModuleType

ROUNDS = 21
#: Seconds that each program runs in a round.
SLICE = 0.01
BATCHES = (1000, 4000, 4104, 16008)
#: Its power-of-two stride hurts column layouts; printed, not judged.
EXTRA_BATCH = 4096
ARRAYS = (4096, 65536)


@dataclass(frozen=True, slots=True)
class Entry:
    """One program in one contest.

    Parameters
    ----------
    program : str
        Whose code.
    run : callable
        Evaluates all.
    results : callable
        Gives C (n, 2) and C_q (n, 2, 12) afterwards.
    """

    program: str
    run: Callable[[], object]
    results: Callable[[], tuple[np.ndarray, np.ndarray]]


@dataclass(frozen=True, slots=True)
class Row:
    """One line of the table.

    Parameters
    ----------
    contest, program : str
        What ran.
    nanoseconds : float
        Per evaluation, median of the rounds.
    units : float
        Worst error.
    """

    contest: str
    program: str
    nanoseconds: float
    units: float


@dataclass(frozen=True, slots=True)
class Target:
    """What ``--check`` judges.

    Parameters
    ----------
    contest, program, peer : str
        Who against whom.
    ratio : float
        Of their times, median of the rounds.
    limit : float
        The most it may be.
    """

    contest: str
    program: str
    peer: str
    ratio: float
    limit: float

    @property
    def is_met(self) -> bool:
        """Whether the program is as fast as wanted."""
        return self.ratio <= self.limit


def measure(entries: list[Entry]) -> dict[str, list[float]]:
    """Return the seconds of each round of each program, the programs in turn."""
    times: dict[str, list[float]] = {entry.program: [] for entry in entries}
    repeats = {entry.program: max(1, int(SLICE / _quickest(entry.run))) for entry in entries}
    for _ in range(ROUNDS):
        for entry in entries:
            count = repeats[entry.program]
            _seconds(entry.run, count // 4 + 1)  # its own data are in the caches again
            times[entry.program].append(_seconds(entry.run, count) / count)
    return times


def _seconds(run: Callable[[], object], count: int) -> float:
    start = time.perf_counter()
    for _ in range(count):
        run()
    return time.perf_counter() - start


def _quickest(run: Callable[[], object]) -> float:
    return min(_seconds(run, 1) for _ in range(7))


class Benchmark:
    """Collects the rows of the table and the targets."""

    def __init__(self, judge: Judge) -> None:
        self.judge = judge
        self.rows: list[Row] = []
        self.targets: list[Target] = []

    def contest(
        self, name: str, n: int, entries: list[Entry], judged: list[tuple[str, str, float]]
    ) -> None:
        """Run one contest; ``judged`` lists program, peer and limit."""
        times = measure(entries)
        for entry in entries:
            nanoseconds = statistics.median(times[entry.program]) / n * 1e9
            units = self.judge.worst(*entry.results())
            self.rows.append(Row(name, entry.program, nanoseconds, units))
        for program, peer, limit in judged:
            pairs = zip(times[program], times[peer], strict=True)
            ratio = statistics.median(ours / theirs for ours, theirs in pairs)
            self.targets.append(Target(name, program, peer, ratio, limit))


def single(benchmark: Benchmark, folder: Path, package: Path) -> None:
    """Single calls in a loop."""
    n = 512
    rows = inputs(n)
    entries = []
    loops = {
        "kousoku C": kousoku_loop(folder, package),
        "CasADi C": casadi_loop(folder, cse=False),
        "CasADi C, cse": casadi_loop(folder, cse=True),
        "SymForce C++": symforce_loop(folder),
    }
    for program, loop in loops.items():
        c, c_q = aligned(np.zeros((n, 2))), aligned(np.zeros((n, 24)))
        by_column = program != "kousoku C"
        entries.append(Entry(program, loop.bind(rows, (c, c_q)), _reader(c, c_q, by_column)))
    judged = [("kousoku C", peer, 0.7) for peer in ("CasADi C", "CasADi C, cse")]
    benchmark.contest("single call in a loop", n, entries, judged)


def _reader(
    c: np.ndarray, c_q: np.ndarray, by_column: bool
) -> Callable[[], tuple[np.ndarray, np.ndarray]]:
    if by_column:
        return lambda: (c, c_q.reshape(-1, 12, 2).swapaxes(1, 2))
    return lambda: (c, c_q.reshape(-1, 2, 12))


def batch(benchmark: Benchmark, n: int, library: Batch) -> None:
    """Evaluate n points at once, each program in its layout."""
    rows = inputs(n)
    c, c_q = aligned(np.zeros((n, 2))), aligned(np.zeros((n, 2, 12)))
    blocks = [aligned(runtime.to_lanes(array, library.width)) for array in rows]
    out = [aligned(runtime.to_lanes(array, library.width)) for array in (c, c_q)]
    entries = [
        Entry("kousoku C, lanes", library.lanes(blocks, out), lambda: _unpacked(out, n)),
        Entry("kousoku C, row-major", library.rows(rows, (c, c_q)), lambda: (c, c_q)),
    ]
    columns = aligned(np.concatenate(rows, axis=1).T)
    for program, function in heyoka_functions().items():
        entries.append(_heyoka_entry(program, function, columns))
    if n == EXTRA_BATCH:
        benchmark.contest(f"batch of {n}, an extra: this stride hurts columns", n, entries, [])
        return
    judged = [
        ("kousoku C, lanes", "heyoka cfunc", 0.9),
        ("kousoku C, row-major", "heyoka cfunc", 2.0),
    ]
    benchmark.contest(f"batch of {n}", n, entries, judged)


def _heyoka_entry(
    program: str, function: Callable[[np.ndarray, np.ndarray], object], columns: np.ndarray
) -> Entry:
    values = aligned(np.zeros((N_OUT, columns.shape[1])))
    return Entry(
        program,
        lambda: function(columns, values),
        lambda: (values[:2].T, values[2:].T.reshape(-1, 2, 12)),
    )


def _unpacked(out: list[np.ndarray], n: int) -> tuple[np.ndarray, np.ndarray]:
    return runtime.from_lanes(out[0], n), runtime.from_lanes(out[1], n)


def arrays(benchmark: Benchmark, n: int, kernel: runtime.Kernel) -> None:
    """Evaluate n points in NumPy, from the same arrays into the same arrays."""
    rows = inputs(n)
    out, other = [(np.zeros((n, 2)), np.zeros((n, 2, 12))) for _ in range(2)]
    function = lambdified()
    columns = [column for array in rows for column in array.T]
    entries = [
        Entry("kousoku NumPy", lambda: kernel(*rows, out=out), lambda: out),
        Entry(
            "lambdify(cse=True), stacked",
            lambda: stacked(function(*columns), *other),
            lambda: other,
        ),
    ]
    judged = [("kousoku NumPy", "lambdify(cse=True), stacked", 0.7)]
    benchmark.contest(f"NumPy, {n} evaluations", n, entries, judged)


def floats(benchmark: Benchmark, module: Any) -> None:
    """One evaluation on Python's floats; both functions return lists of floats."""
    lists = [[array[k].tolist() for array in inputs(SAMPLE)] for k in range(SAMPLE)]
    flat = [[x for numbers in point for x in numbers] for point in lists]
    function, elements = lambdified(), partial(module.constraint_elements, 2)  # rows of a_z

    def by_function(k: int) -> list[float]:
        return list(function(*flat[k]))

    def by_elements(k: int) -> list[float]:
        c, c_q = elements(*lists[k])
        return [*c, *c_q]

    entries = [
        Entry("kousoku Python", lambda: elements(*lists[0]), lambda: _sampled(by_elements)),
        Entry("lambdify(cse=True)", lambda: function(*flat[0]), lambda: _sampled(by_function)),
    ]
    judged = [("kousoku Python", "lambdify(cse=True)", 1.1)]
    benchmark.contest("unbatched, on Python's floats", 1, entries, judged)


def _sampled(evaluate: Callable[[int], list[float]]) -> tuple[np.ndarray, np.ndarray]:
    values = np.array([evaluate(k) for k in range(SAMPLE)])
    return values[:, :2], values[:, 2:].reshape(-1, 2, 12)


def run_all(package: Path) -> Benchmark:
    """Run every contest on a generated folder.

    Raises
    ------
    MissingError
        A program to compare with is not there.
    """
    numpy_library = runtime.load(package, target="numpy")
    benchmark = Benchmark(Judge())
    # Arrays first: what ran before decides how much freed memory the C library has kept.
    for n in ARRAYS:
        arrays(benchmark, n, numpy_library["constraint_z"])
    floats(benchmark, emitted_module(package))
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        single(benchmark, folder, package)
        library = Batch(folder, package)
        for n in (*BATCHES, EXTRA_BATCH):
            batch(benchmark, n, library)
    return benchmark


def emitted_module(package: Path) -> ModuleType:
    """Import the emitted NumPy kernels of a folder."""
    files = {path.name: path.read_bytes() for path in package.glob("*.py")}
    return import_source(package, files, "kernels.py")


def described() -> list[str]:
    """Return what the numbers belong to: processor, compiler, flags, versions."""
    toolchain = find_toolchain()
    versions = [
        f"{name} {version(name)}" for name in ("numpy", "sympy", "casadi", "heyoka", "symforce")
    ]
    return [
        f"two-row p2, {N_OUT} numbers from {N_IN} arguments; one thread; median of {ROUNDS} rounds",
        f"{_processor()}; {toolchain.name}; {' '.join(toolchain.flags)}",
        f"Python {platform.python_version()}, {', '.join(versions)}",
    ]


def _processor() -> str:
    """Return the processor's name, as far as the system tells."""
    info = Path("/proc/cpuinfo")
    if info.exists():
        for line in info.read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def table(benchmark: Benchmark) -> str:
    """Return the rows as text: nanoseconds an evaluation, and the worst error in units."""
    lines, contest = [*described(), ""], ""
    for row in benchmark.rows:
        if row.contest != contest:
            contest = row.contest
            lines.append(f"{contest:<54}{'ns':>9}{'error':>8}")
        lines.append(f"  {row.program:<52}{row.nanoseconds:>9.2f}{row.units:>8.2f}")
    lines += ["", f"{'ratio of times':<54}{'':>9}{'limit':>8}"]
    for target in benchmark.targets:
        verdict = "" if target.is_met else "  missed"
        name = f"{target.contest}: {target.program} / {target.peer}"
        lines.append(f"  {name:<76}{target.ratio:>6.2f}{target.limit:>6.1f}{verdict}")
    return "\n".join(lines)


def main() -> int:
    """Run the benchmark and return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--check", action="store_true", help="exit 1 if a target is missed")
    parser.add_argument("--json", action="store_true", help="print for machines")
    shipped = Path(str(files("kousoku.generated"))) / "kinds" / "p2"
    parser.add_argument("--folder", type=Path, default=shipped, help="another emitted p2")
    options = parser.parse_args()
    try:
        benchmark = run_all(options.folder)
    except MissingError as error:
        print(error, file=sys.stderr)
        return 2
    if options.json:
        rows = [asdict(row) for row in benchmark.rows]
        targets = [{**asdict(target), "is_met": target.is_met} for target in benchmark.targets]
        print(json.dumps({"about": described(), "rows": rows, "targets": targets}, indent=1))
    else:
        print(table(benchmark))
    missed = [target for target in benchmark.targets if not target.is_met]
    for target in missed if options.check else []:
        print(
            f"missed: {target.contest}: {target.program} takes {target.ratio:.2f} of"
            f" {target.peer}, wanted at most {target.limit}",
            file=sys.stderr,
        )
    return 1 if missed and options.check else 0


if __name__ == "__main__":
    sys.exit(main())
