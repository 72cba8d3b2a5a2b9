"""Kernels: what an evaluation costs and how exact it is, beside what others emit, and at most.

``python -m tests.benchmarks kernels`` runs it. The peers get the formula of p2, see
:mod:`tests.benchmarks.p2`; all kinds are measured in all ways in which they can be called.
"""

from __future__ import annotations

import ctypes
import subprocess
import tempfile
from dataclasses import dataclass, replace
from functools import cache, partial
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from kousoku import runtime
from kousoku.runtime.importing import import_source
from kousoku.runtime.toolchain import EXTENSION, find_toolchain
from kousoku.runtime.verify import LIMIT, Row, verify
from kousoku.symbolic import KINDS
from tests.benchmarks import limits
from tests.benchmarks.kernel_peers import heyoka_functions, lambdified, stacked
from tests.benchmarks.kit import (
    BenchmarkTarget,
    Call,
    Case,
    Figures,
    Judged,
    Question,
    Record,
    Size,
    bullet_list,
    table,
)
from tests.benchmarks.limits import Limits, aligned, measured, repeated, size_text, together
from tests.benchmarks.loops import Batch, casadi_loop, kousoku_loop, symforce_loop, sympy_loop
from tests.benchmarks.p2 import N_OUT, SAMPLE, Judge, inputs
from tests.benchmarks.plots import ToolLine, growth
from tests.benchmarks.race import race

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence
    from types import ModuleType

    from kousoku.runtime.kernel import Kernel
    from kousoku.runtime.library import Library
    from tests.benchmarks.race import Workers

    Results = tuple[np.ndarray, np.ndarray]

SINGLE, FLOATS, CALLS = "p2, single calls in C", "p2, Python's floats", "p2, calls from Python"
BATCHES, ARRAYS = (1000, 4000, 4104, 16008), (4096, 65536)
#: Its power-of-two stride hurts column layouts; printed, not judged.
EXTRA_BATCH = 4096
#: Rows that single calls go through.
LOOP = 512
#: What a program may take of its peer's time.
OF_CASADI, OF_HEYOKA, ROWS_OF_HEYOKA, OF_ARRAYS, OF_FLOATS = 0.7, 0.9, 2.0, 0.7, 1.1
#: Microseconds that a call from Python may take.
MICROSECONDS = {"call with out=": 2.0, "bound call": 0.6}
#: Evaluations at once, and as many threads; most bytes of a batch.
SIZES, FEW_SIZES, QUICK_SIZES = tuple(10**k for k in range(7)), (1, 100, 10_000, 10**6), (10_000,)
LEAST_SHARED, MOST_BYTES = 1000, 1 << 29
#: Kinds of the quick run, and the kernel that is measured at all sizes.
QUICK_KINDS, AT_ALL_SIZES = ("p2", "spring_damper"), ("p2", "constraint_z")
CALL, BOUND, NUMPY = "C, one call", "C, from Python", "NumPy, from Python"
LANES, ROWS, ARRAY = "C, lanes", "C, row-major", "NumPy, batch"
#: NumPy gains nothing from a second thread where all goes through memory.
MOST_SHARED = {ARRAY: 100_000}
#: The ways of ``kousoku verify`` that tell the error of each.
VERIFIED = {
    **{CALL: "C", BOUND: "C", NUMPY: "NumPy"},
    **{LANES: "C lanes", ROWS: "C batch", ARRAY: "NumPy batch"},
}
#: The evaluation that the table of all kinds shows.
BATCH_SHOWN = 10_000


def folder_of(package: str) -> Path:
    """Folder of a committed kind."""
    return Path(str(files("kousoku.generated"))) / "kinds" / package


def batch_name(n: int) -> str:
    """Contest of a batch."""
    return f"p2, batch of {n}"


def arrays_name(n: int) -> str:
    """Contest of NumPy on arrays."""
    return f"p2, NumPy on {n}"


def contests(size: Size) -> list[str]:
    """Limits, the contests of p2, and the kinds."""
    if not size.is_full:
        names = [SINGLE, batch_name(BATCHES[1]), CALLS]
        return [limits.CONTEST, *names, *map(_kind_name, QUICK_KINDS)]
    batches = [batch_name(n) for n in (*BATCHES, EXTRA_BATCH)]
    names = [SINGLE, *batches, *map(arrays_name, ARRAYS), FLOATS, CALLS]
    return [limits.CONTEST, *names, *map(_kind_name, KINDS)]


def _kind_name(package: str) -> str:
    return f"kind {package}"


def run(contest: str, size: Size, workers: Workers) -> list[Record]:
    """Measure a contest: limits and kinds here, the contests of p2 in turn."""
    if contest == limits.CONTEST:
        return limits.measure(is_full=size.is_full)
    if contest.startswith("kind "):
        return list(measure_kind(contest.removeprefix("kind "), size))
    return race(contest, cases(contest, size), workers, QUESTION.seconds)


# ---------------------------------------------------------------- p2, beside others


def cases(contest: str, size: Size) -> list[Case]:
    """Programs of a contest of p2."""
    if contest == SINGLE:
        return [
            _case("kousoku", "emitted C", _loop(kousoku_loop, folder_of("p2"), by_column=False)),
            _case("CasADi", "its C", _loop(casadi_loop, cse=False)),
            _case("CasADi", "its C, cse", _loop(casadi_loop, cse=True)),
            _case("SymForce", "its C++", _loop(symforce_loop)),
            _case("SymPy", "codegen", _loop(sympy_loop, cse=False, by_column=False)),
            _case("SymPy", "codegen, cse", _loop(sympy_loop, cse=True, by_column=False)),
        ]
    n = int(contest.rpartition(" ")[2]) if contest[-1].isdigit() else 0
    if contest == batch_name(n):
        return [
            _case("kousoku", "lanes", partial(_lanes, n)),
            _case("kousoku", "row-major", partial(_rows, n)),
            _case("heyoka", "cfunc", partial(_heyoka, n, "cfunc")),
            _case("heyoka", "cfunc, not divided", partial(_heyoka, n, "cfunc, not divided")),
        ]
    if contest == arrays_name(n):
        return [
            _case("kousoku", "emitted NumPy", partial(_emitted_arrays, n)),
            _case("SymPy", "lambdify, stacked", partial(_lambdified_arrays, n)),
        ]
    if contest == FLOATS:
        return [
            _case("kousoku", "emitted Python", _emitted_floats),
            _case("SymPy", "lambdify", _lambdified_floats),
        ]
    names = ("call with out=", "call that allocates", "call for one output", "bound call")
    return [_case("kousoku", name, partial(_called, name)) for name in names]


def _case(tool: str, line: str, prepare: Callable[[], Call]) -> Case:
    return Case(tool, line, "", "kousoku" if tool == "kousoku" else "equations", prepare)


@cache
def _scratch() -> Path:
    """Folder of this process, gone at its end."""
    _scratch_of.append(tempfile.TemporaryDirectory())
    return Path(_scratch_of[-1].name)


_scratch_of: list[tempfile.TemporaryDirectory[str]] = []


@cache
def _judge() -> Judge:
    return Judge()


def _judged(results: Callable[[], Results]) -> Callable[[], Judged]:
    return lambda: Judged(_judge().worst(*results()))


def _loop(build: Any, *given: Any, by_column: bool = True, **options: Any) -> Callable[[], Call]:
    """Statement that sets up single calls in a loop."""

    def prepare() -> Call:
        loop = build(_scratch(), *given, **options)
        rows = inputs(LOOP)
        c, c_q = aligned(np.zeros((LOOP, 2))), aligned(np.zeros((LOOP, 24)))

        def results() -> Results:
            if by_column:
                return c, c_q.reshape(-1, 12, 2).swapaxes(1, 2)
            return c, c_q.reshape(-1, 2, 12)

        return Call(loop.bind(rows, (c, c_q)), _judged(results), LOOP)

    return prepare


@cache
def _batch() -> Batch:
    return Batch(_scratch(), folder_of("p2"))


def _lanes(n: int) -> Call:
    width = _batch().width
    blocks = [aligned(runtime.to_lanes(array, width)) for array in inputs(n)]
    out = [aligned(runtime.to_lanes(np.zeros((n, *shape)), width)) for shape in ((2,), (2, 12))]

    def results() -> Results:
        c, c_q = (runtime.from_lanes(array, n) for array in out)
        return c, c_q

    return Call(_batch().lanes(blocks, out), _judged(results), n)


def _rows(n: int) -> Call:
    out = aligned(np.zeros((n, 2))), aligned(np.zeros((n, 2, 12)))
    return Call(_batch().rows(inputs(n), out), _judged(lambda: out), n)


def _heyoka(n: int, name: str) -> Call:
    function = heyoka_functions()[name]
    columns = aligned(np.concatenate(inputs(n), axis=1).T)
    values = aligned(np.zeros((N_OUT, n)))
    results = _judged(lambda: (values[:2].T, values[2:].T.reshape(-1, 2, 12)))
    return Call(lambda: function(columns, values), results, n)


def _emitted_arrays(n: int) -> Call:
    rows, out = inputs(n), (np.zeros((n, 2)), np.zeros((n, 2, 12)))
    kernel = runtime.load(folder_of("p2"), target="numpy")["constraint_z"]
    return Call(lambda: kernel(*rows, out=out), _judged(lambda: out), n)


def _lambdified_arrays(n: int) -> Call:
    # the same arrays in, the same arrays out
    columns = [column for array in inputs(n) for column in array.T]
    function, out = lambdified(), (np.zeros((n, 2)), np.zeros((n, 2, 12)))
    return Call(lambda: stacked(function(*columns), *out), _judged(lambda: out), n)


def _points() -> list[list[list[float]]]:
    rows = inputs(SAMPLE)
    return [[array[k].tolist() for array in rows] for k in range(SAMPLE)]


def _of_floats(evaluate: Callable[[int], Sequence[float]]) -> Call:
    """Call on the first point, judged at all."""

    def results() -> Results:
        values = np.array([evaluate(k) for k in range(SAMPLE)])
        return values[:, :2], values[:, 2:].reshape(-1, 2, 12)

    return Call(lambda: evaluate(0), _judged(results))


def _emitted_floats() -> Call:
    points, elements = _points(), emitted_module(folder_of("p2")).constraint_elements

    def evaluate(k: int) -> list[float]:
        c, c_q = elements(2, *points[k])  # rows of a_z
        return [*c, *c_q]

    return _of_floats(evaluate)


def _lambdified_floats() -> Call:
    flat = [[x for numbers in point for x in numbers] for point in _points()]
    function = lambdified()
    return _of_floats(lambda k: function(*flat[k]))


def emitted_module(package: Path) -> ModuleType:
    """Import the emitted NumPy kernels of a folder."""
    sources = {path.name: path.read_bytes() for path in package.glob("*.py")}
    return import_source(package, sources, "kernels.py")


def _called(name: str) -> Call:
    """Call of a kernel from Python, its arguments separate float64 arrays."""
    kernel = runtime.load(folder_of("p2"), target="c").constraint_z
    given = [array[0] for array in inputs(SAMPLE)]
    out = np.empty(2), np.empty((2, 12))
    calls: dict[str, Callable[[], object]] = {
        "call with out=": lambda: kernel(*given, out=out),
        "call that allocates": lambda: kernel(*given),
        "call for one output": lambda: kernel(*given, outputs=("C",)),
        "bound call": kernel.bind(*given, out=out),
    }
    return Call(calls[name])


# ---------------------------------------------------------------- all kinds


_CALLS = """
#include <stddef.h>
/* one call after the other, as a program in C makes them */
void calls(size_t n, void (*call)(const double *const *, double *const *),
    const double *const *in, double *const *out)
{
    for (size_t k = 0; k < n; ++k) call(in, out);
}
"""


@cache
def _calls() -> Any:
    """Loop over calls of any kernel."""
    source, library = _scratch() / "calls.c", _scratch() / f"calls{EXTENSION}"
    source.write_text(_CALLS, encoding="utf-8")
    command = find_toolchain().compile_command([str(source)], str(library))
    subprocess.run(command, check=True, capture_output=True)
    found = ctypes.CDLL(str(library)).calls
    found.restype = None
    return found


@dataclass(frozen=True, slots=True)
class Measured:
    """A kernel of a kind, and what all ways of calling it have in common.

    Parameters
    ----------
    package, name : str
        The kind and the kernel.
    libraries : dict of Library
        Both targets.
    points : list of array
        Inputs of some evaluations, row-major.
    operations, size : int
        Operations of an evaluation, and bytes that it reads and writes.
    units : dict of (float, float)
        The worst error in each way of ``kousoku verify``, and where it is known to be larger than
        rounding: 0 where that is nowhere.
    """

    package: str
    name: str
    libraries: dict[str, Library]
    points: list[np.ndarray]
    operations: int
    size: int
    units: dict[str, tuple[float, float]]

    def kernel(self, target: str) -> Kernel:
        """Kernel in C or NumPy."""
        return self.libraries[target][self.name]

    def inputs(self, n: int, *, width: int = 0) -> list[np.ndarray]:
        """So many evaluations, the points over again; in blocks of a width if given."""
        if not width:
            return [repeated(array, n) for array in self.points]
        packed = (runtime.to_lanes(array, width) for array in self.points)
        return [repeated(array, -(-n // width)) for array in packed]

    def outputs(self, n: int, *, width: int = 0) -> tuple[np.ndarray, ...]:
        """Arrays for the outputs, in blocks where they have a width."""
        shapes = [q.shape for q in self.kernel("c").manifest.outputs]
        blocks = (-(-n // width),) if width else (n,)
        lanes = (width,) if width else ()
        return tuple(aligned(np.zeros((*blocks, *shape, *lanes))) for shape in shapes)

    def record(
        self, way: str, setting: str, call: Callable[[], object], count: int, **extra: float
    ) -> Record:
        """Record of a way to call it."""
        names = ("kousoku", f"{self.name}: {way}", setting)
        found = measured(_kind_name(self.package), names, call, count)
        worst, known = self.units[VERIFIED[way]]
        own = {"operations": float(self.operations), "bytes": float(self.size), "known": known}
        return replace(found, error=worst, extra=own | extra)


def measure_kind(package: str, size: Size) -> Iterator[Record]:
    """Records of all kernels of a kind; of choices of rows, which are alike, the last."""
    folder = folder_of(package)
    libraries = {name: runtime.load(folder, target=name) for name in ("c", "numpy")}
    report = verify(folder)
    report.check()
    for kernel in libraries["c"].manifest.kernels:
        if kernel.name.endswith(("_x", "_y")):
            continue
        rows = [row for row in report.rows if row.kernel == kernel.name]
        units = {way: _worst(rows, way) for way in VERIFIED.values()}
        shapes = [q.shape for q in (*kernel.inputs, *kernel.outputs)]
        one = Measured(
            package,
            kernel.name,
            libraries,
            _random_points(kernel.inputs),
            sum(count for op, count in kernel.operations if op != "neg"),
            8 * sum(int(np.prod(shape)) for shape in shapes),
            units,
        )
        yield from _alone(one)
        sizes = FEW_SIZES if size.is_full else QUICK_SIZES
        for n in SIZES if size.is_full and (package, kernel.name) == AT_ALL_SIZES else sizes:
            yield from _at_once(one, n)


def _worst(rows: Sequence[Row], way: str) -> tuple[float, float]:
    """Largest errors in units: as rounding, and where they are known to be larger."""
    own = [row for row in rows if row.way == way]
    rounding, known = ([r.worst for r in own if (r.limit == LIMIT) is x] for x in (True, False))
    return max(rounding, default=0.0), max(known, default=0.0)


def _random_points(quantities: Sequence[Any]) -> list[np.ndarray]:
    """Ordinary numbers; of Euler parameters, unit quaternions."""
    rng, found = np.random.default_rng(1981), []
    for q in quantities:
        values = rng.normal(size=(1000, *q.shape))
        if q.shape == (4,) and q.name.startswith("p"):
            values /= np.linalg.norm(values, axis=1, keepdims=True)
        found.append(values)
    return found


def _alone(one: Measured) -> Iterator[Record]:
    """Cost of one call."""
    given, single = ([array[0, ...] for array in x] for x in (one.inputs(1), one.outputs(1)))
    kernel, count = one.kernel("c"), 10_000
    pointers = [(ctypes.c_void_p * len(x))(*(a.ctypes.data for a in x)) for x in (given, single)]
    function = one.libraries["c"].function(f"kousoku_{one.package}_{one.name}_call")
    calls, n = _calls(), ctypes.c_size_t(count)
    yield one.record(CALL, "1 thread", lambda: calls(n, function, *pointers), count)
    yield one.record(BOUND, "1 thread", kernel.bind(*given, out=tuple(single)), 1)
    numpy = one.kernel("numpy")
    yield one.record(NUMPY, "1 thread", lambda: numpy(*given), 1)


def _at_once(one: Measured, n: int) -> Iterator[Record]:
    """Cost of an evaluation of so many at once, by one thread and two."""
    for way in (LANES, ROWS, ARRAY):
        for count in limits.THREADS:
            setting = f"{n}, {count} thread{'s' * (count > 1)}"
            if count > 1 and not LEAST_SHARED <= n <= MOST_SHARED.get(way, n):
                continue
            if n * one.size > MOST_BYTES:
                names = ("kousoku", f"{one.name}: {way}", setting)
                note = f"more than {size_text(MOST_BYTES)}"
                yield Record(_kind_name(one.package), *names, note=note)
                continue
            call = together([_batch_call(one, way, part) for part in _parts(n, count)])
            yield one.record(way, setting, call, n, n=float(n), threads=float(count))


def _parts(n: int, count: int) -> list[int]:
    """Number of evaluations of each thread."""
    return [n // count + (k < n % count) for k in range(count)]


def _batch_call(one: Measured, way: str, n: int) -> Callable[[], object]:
    """Call that makes so many evaluations."""
    kernel = one.kernel("numpy" if way == ARRAY else "c")
    if way != LANES:
        given, out = one.inputs(n), one.outputs(n)
        return lambda: kernel(*given, out=out)
    width = kernel.lane_width
    blocks, packed = one.inputs(n, width=width), one.outputs(n, width=width)
    return lambda: kernel.lanes(*blocks, out=packed)


# ---------------------------------------------------------------- the page


def targets(records: Sequence[Record]) -> list[BenchmarkTarget]:
    """Targets that the page promises of contests that were run."""
    found = []
    for contest in dict.fromkeys(one.contest for one in records):
        own = {(one.tool, one.line): one for one in records if one.contest == contest}
        for (tool, line), peer, limit in _judged_pairs(contest):
            if (tool, line) in own:
                value = _ratio(own[tool, line], own.get(peer))
                found.append(
                    BenchmarkTarget(contest, f"{line} over {' '.join(peer)}", value, limit)
                )
        for line, limit in MICROSECONDS.items() if contest == CALLS else ():
            one = own.get(("kousoku", line))
            value = None if one is None or one.fastest is None else one.fastest * 1e6
            found.append(BenchmarkTarget(contest, f"µs of a {line}", value, limit))
    return found


def _judged_pairs(contest: str) -> list[tuple[tuple[str, str], tuple[str, str], float]]:
    """Pairs that are compared, and the most that kousoku may take."""
    if contest == SINGLE:
        ours = ("kousoku", "emitted C")
        return [(ours, ("CasADi", line), OF_CASADI) for line in ("its C", "its C, cse")]
    if contest in map(batch_name, BATCHES):
        peer = ("heyoka", "cfunc")
        return [
            (("kousoku", "lanes"), peer, OF_HEYOKA),
            (("kousoku", "row-major"), peer, ROWS_OF_HEYOKA),
        ]
    if contest in map(arrays_name, ARRAYS):
        return [(("kousoku", "emitted NumPy"), ("SymPy", "lambdify, stacked"), OF_ARRAYS)]
    if contest == FLOATS:
        return [(("kousoku", "emitted Python"), ("SymPy", "lambdify"), OF_FLOATS)]
    return []


def _ratio(ours: Record, theirs: Record | None) -> float | None:
    if theirs is None or ours.fastest is None or theirs.fastest is None:
        return None
    return ours.fastest / theirs.fastest


def body(records: Sequence[Record], figures: Figures) -> str:
    """Tables: this machine, p2 beside others, all kinds; and p2 at all sizes."""
    known = Limits.of(records)
    parts = [_table_of_limits(records), _table_of_p2(records), _table_of_kinds(records, known)]
    package, kernel = AT_ALL_SIZES
    drawn = _plot(records, package, kernel)
    if drawn:
        what = f"{package} {kernel}: seconds of an evaluation over evaluations at once"
        parts.append(figures.add("kernels", drawn, what))
    return "\n\n".join(filter(None, parts))


def _table_of_limits(records: Sequence[Record]) -> str:
    own = [one for one in records if one.contest == limits.CONTEST and one.fastest]
    if not own:
        return ""
    rows = []
    for line in dict.fromkeys(one.line for one in own if one.line != "bytes"):
        cells = [f"{1e-9 / one.fastest:.3g}" for one in own if one.line == line and one.fastest]
        rows.append([f"10⁹ {line}", *cells])
    for total in sorted({one.extra["bytes"] for one in own if one.line == "bytes"}):
        same = [one for one in own if one.extra.get("bytes") == total]
        cells = [f"{1e-9 / one.fastest:.3g}" for one in same if one.fastest]
        rows.append([f"GB, read and written in {size_text(total)}", *cells])
    return table(("this machine, in a second", "1 thread", "2 threads"), rows)


def _table_of_p2(records: Sequence[Record]) -> str:
    rows = []
    for one in records:
        if not one.contest.startswith("p2, "):
            continue
        time = one.note or f"{(one.fastest or 0) * 1e9:.4g}"
        rows.append([one.contest, f"{one.tool} {one.line}", time, _units(one.error)])
    heads = ("C and C_q of two-row p2", "program", "ns an evaluation", "error [units]")
    return table(heads, rows) if rows else ""


def _units(error: float | None) -> str:
    return "" if error is None else f"{error:.2f}"


def _table_of_kinds(records: Sequence[Record], known: Limits) -> str:
    """Line for each kernel; of batches, time and share of what limits it."""
    found: dict[tuple[str, str], dict[tuple[str, str], Record]] = {}
    for one in records:
        if one.contest.startswith("kind "):
            kernel, _, way = one.line.partition(": ")
            own = found.setdefault((one.contest.removeprefix("kind "), kernel), {})
            own[way, one.setting] = one
    if not found:
        return ""
    rows = []
    for (package, kernel), own in found.items():
        if (CALL, "1 thread") not in own:  # the contest failed
            rows += [[package, one.note, *[""] * 10] for one in own.values()]
            continue
        single = own[CALL, "1 thread"]
        cells = [f"{(own[way, '1 thread'].fastest or 0) * 1e9:.3g}" for way in (BOUND, NUMPY)]
        batches = [own[way, f"{BATCH_SHOWN}, 1 thread"] for way in (LANES, ROWS, ARRAY)]
        largest = max((one for one in own.values() if "n" in one.extra), key=_size_of)
        rows.append(
            [
                f"{package} {kernel}",
                f"{single.extra['operations']:.0f}",
                _with_share(single, known),
                *cells,
                *(_with_share(one, known) for one in batches),
                _with_share(own[LANES, f"{BATCH_SHOWN}, 2 threads"], known),
                f"{_with_share(largest, known)} at {largest.extra['n']:g}",
                _units_of(single),
                _units_of(own[NUMPY, "1 thread"]),
            ]
        )
    heads = ("kernel", "operations", CALL, BOUND, NUMPY, LANES, ROWS, ARRAY)
    more = ("C, lanes, 2 threads", "C, lanes, most, 2 threads", "units, C", "units, NumPy")
    return table((*heads, *more), rows)


def _units_of(one: Record) -> str:
    known = one.extra.get("known")
    return f"{_units(one.error)}, known {known:.3g}" if known else _units(one.error)


def _size_of(one: Record) -> tuple[bool, float, float]:
    return one.line.endswith(LANES), one.extra["n"], one.extra["threads"]


def _with_share(one: Record, known: Limits) -> str:
    """Nanoseconds, and how much of them this machine needs at least, if that was measured."""
    if one.fastest is None:
        return one.note
    if not known.byte:
        return f"{one.fastest * 1e9:.3g}"
    n, count = one.extra.get("n", 1.0), int(one.extra.get("threads", 1))
    unit = "vector" if "n" in one.extra else "scalar"
    operations, size = one.extra["operations"], one.extra["bytes"]
    least, what = known.seconds(operations, size, n * size, unit=unit, count=count)
    return f"{one.fastest * 1e9:.3g} ({100 * least / one.fastest:.0f} % {what[0]})"


def _plot(records: Sequence[Record], package: str, kernel: str) -> str:
    """Plot of a kernel over the evaluations that are made at once."""
    lines = []
    for way in (LANES, ROWS, ARRAY):
        for count in limits.THREADS:
            points = [
                (one.extra["n"], one.fastest)
                for one in records
                if one.contest == _kind_name(package)
                and one.line == f"{kernel}: {way}"
                and one.fastest
                and one.extra["threads"] == count
            ]
            if len(points) > 2:
                label = f"{way}, {count} thread{'s' * (count > 1)}"
                lines.append(ToolLine(label, points, is_bold=way == LANES))
    return growth(f"{package} {kernel}", "evaluations at once", lines) if lines else ""


def words(records: Sequence[Record]) -> str:
    """List of where kousoku's kernels win and lose."""
    ratios: dict[tuple[str, str], list[float]] = {}
    for contest in dict.fromkeys(one.contest for one in records):
        own = [one for one in records if one.contest == contest and one.fastest]
        ours = [one for one in own if one.tool == "kousoku"]
        what = contest.partition(", ")[2].rstrip("0123456789 ")
        what = what.removesuffix(" of").removesuffix(" on")
        for peer in own if ours and contest.startswith("p2, ") else ():
            if peer.tool != "kousoku":
                ratio = _ratio(min(ours, key=lambda one: one.fastest or 0.0), peer)
                found = ratios.setdefault((what, f"{peer.tool} ({peer.line})"), [])
                found += [ratio] if ratio is not None else []
    if not ratios:
        return ""
    parts: dict[str, list[str]] = {}
    for (what, name), found in ratios.items():
        parts.setdefault(what, []).append(f"{_range(found)} of {name}")
    told = [f"{what}: {', '.join(each)}" for what, each in parts.items()]
    return bullet_list("A kernel, p2, takes of the time of others", told)


def _range(found: Sequence[float]) -> str:
    low, high = f"{min(found):.2g}", f"{max(found):.2g}"
    return low if low == high else f"{low} to {high}"


QUESTION = Question(
    title="Kernels",
    asks="""\
What does an evaluation cost, how exact is it, and how much of it does this machine need at least?

p2 with two rows, all of C and C_q: 26 numbers from 23 run-time arguments, nothing folded, zeros
included. Every program gets the same formula (`tests/benchmarks/p2.py`), with what it has in common
written once; every C program is compiled by the same compiler with the same flags (those of
`runtime/toolchain.py`), in compilation units of its own. The error is the worst against 50 digits
in the unit of `kousoku verify`. A batch moves 392 bytes an evaluation and computes 183 operations
on them: from about n = 2,500 on (1 MB of L2) it is the caches that are measured. heyoka runs on one
thread (`set_nthreads(1)`); its call with `batch_parallel=False` also leaves out the division into
tasks. SymPy's `autowrap` calls the same C as `codegen` writes, through Cython.

Of all kinds: nanoseconds, and in brackets the share of them that this machine needs at least, for
arithmetic (a) or to read and write what an evaluation reads and writes (m): measured in the same
run, by twelve independent chains of products and sums, and by the faster of y = x / 2 and y = a + b
/ 2 through as many bytes. One call is made in a loop in C through the library as it ships, and
compared with scalar operations. Threads are Python's; each takes its part of the evaluations. Where
an error is known to be larger than rounding, as `kousoku verify` knows it, it stands beside.""",
    contests=contests,
    cases=cases,
    body=body,
    targets=targets,
    words=words,
    run=run,
)
