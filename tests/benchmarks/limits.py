"""Limits of this machine: operations on doubles, and bytes that are read and written."""

from __future__ import annotations

import ctypes
import math
import subprocess
import tempfile
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from kousoku.runtime.library import LANES
from kousoku.runtime.toolchain import EXTENSION, find_toolchain
from tests.benchmarks.kit import Record, fastest_and_median, rounds_of, seconds_of, slice_of

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

CONTEST = "limits"
SOURCE = Path(__file__).with_name("limits.c")
#: Flags that make three programs of the source: one number at a time, a vector, and products with
#: sums in one operation, which the flags of kernels rule out.
UNITS = {
    "scalar": ("-DKOUSOKU_LANES=1",),
    "vector": (),
    "vector, fused": ("-ffp-contract=fast",),
}
#: Bytes that are read and written in turn, from the first cache to memory.
BYTES = tuple(16384 << k for k in range(0, 15, 2))
QUICK_BYTES = BYTES[1::3]
THREADS = (1, 2)
#: Operations on each vector in a call, and bytes: a few milliseconds, much beside what handing over
#: to threads takes.
ROUNDS_OF_OPERATIONS, MOVED = 500_000, 256 << 20


@cache
def threads() -> ThreadPoolExecutor:
    """Threads that share work."""
    return ThreadPoolExecutor(max(THREADS))


def together(runs: Sequence[Callable[[], object]]) -> Callable[[], object]:
    """Function that does all at once, each in a thread; C that is called through ctypes runs so."""
    if len(runs) == 1:
        return runs[0]
    return lambda: [one.result() for one in [threads().submit(run) for run in runs]]


def timed(run: Callable[[], object]) -> list[float]:
    """Seconds of a call in several rounds; of its trial where it is long."""
    about = min(seconds_of(run) for _ in range(2))
    return [slice_of(run, about) for _ in range(rounds_of(about))] or [about]


def measured(
    contest: str, names: tuple[str, str, str], run: Callable[[], object], count: int
) -> Record:
    """Record of a call that makes so many evaluations."""
    times = timed(run)
    fastest, median = fastest_and_median(times, count)
    return Record(contest, *names, fastest=fastest, median=median, rounds=len(times))


def room(shape: tuple[int, ...]) -> np.ndarray:
    """Array without values, row-major, that begins at a multiple of 64 bytes."""
    size = math.prod(shape)
    memory = np.empty(size + 8)
    start = -memory.ctypes.data // 8 % 8
    return memory[start : start + size].reshape(shape)


def aligned(values: np.ndarray) -> np.ndarray:
    """Copy that begins at a multiple of 64 bytes."""
    array = room(values.shape)
    array[...] = values
    return array


def repeated(values: np.ndarray, n: int) -> np.ndarray:
    """So many rows, the same ones over again."""
    array = room((n, *values.shape[1:]))
    for start in range(0, n, len(values)):
        array[start : start + len(values)] = values[: n - start]
    return array


def _library(folder: Path, unit: str) -> ctypes.CDLL:
    path = folder / f"{unit.replace(', ', '_')}{EXTENSION}"
    include = f"-I{LANES.parent}"
    command = find_toolchain().compile_command([str(SOURCE)], str(path), [include, *UNITS[unit]])
    subprocess.run(command, check=True, capture_output=True)
    library = ctypes.CDLL(str(path))
    library.operations.restype = library.width.restype = ctypes.c_size_t
    return library


def measure(*, is_full: bool) -> list[Record]:
    """Records of all limits: seconds per operation, and per byte."""
    found: list[Record] = []
    with tempfile.TemporaryDirectory() as name:
        for unit in UNITS:
            library = _library(Path(name), unit)
            found += [_operations(library, unit, count) for count in THREADS]
            if unit == "vector":
                for size in BYTES if is_full else QUICK_BYTES:
                    found += [_bytes(library, size, count) for count in THREADS]
    return found


def _operations(library: ctypes.CDLL, unit: str, count: int) -> Record:
    states = [aligned(np.array([0.5, 1.0, 2.0] + [0.0] * 21)) for _ in range(count)]
    rounds = ctypes.c_size_t(ROUNDS_OF_OPERATIONS)
    done = library.operations(rounds, _address(states[0]))
    runs = [lambda x=state: library.operations(rounds, _address(x)) for state in states]
    names = ("machine", f"operations, {unit}", _threads(count))
    return measured(CONTEST, names, together(runs), done * count)


def _bytes(library: ctypes.CDLL, size: int, count: int) -> Record:
    """Time of the faster of two loops; all threads together have so many bytes."""
    width = library.width()
    found = []
    for name, arrays in (("scale", 2), ("triad", 3)):
        blocks = max(1, size // (8 * width * arrays * count))
        runs = []
        for _ in range(count):
            own = [aligned(np.ones(blocks * width)) for _ in range(arrays)]
            # Small arrays are gone through again and again, or the call would be measured.
            runs.append(_passes(library, name, blocks, own))
        passes = runs[0].passes
        names = ("machine", "bytes", f"{size}, {_threads(count)}")
        moved = passes * blocks * width * 8 * arrays * count
        found.append(measured(CONTEST, names, together(runs), moved))
    best = min(found, key=lambda one: one.fastest or np.inf)
    best.extra = {"bytes": float(size), "threads": float(count)}
    return best


@dataclass(frozen=True, slots=True)
class _Passes:
    """A loop over its arrays, so often that a call is long enough."""

    call: Callable[..., object]
    passes: int
    arguments: tuple[object, ...]
    arrays: Sequence[np.ndarray]

    def __call__(self) -> None:
        self.call(*self.arguments)


def _passes(library: ctypes.CDLL, name: str, blocks: int, arrays: Sequence[np.ndarray]) -> _Passes:
    passes = max(1, MOVED // sum(array.nbytes for array in arrays))
    addresses = tuple(_address(array) for array in arrays)
    arguments = (ctypes.c_size_t(passes), ctypes.c_size_t(blocks), *addresses)
    return _Passes(library[name], passes, arguments, arrays)


def size_text(number: float) -> str:
    """Number of bytes with its unit, of three digits."""
    for unit, size in (("GB", 1 << 30), ("MB", 1 << 20)):
        if number >= size:
            return f"{number / size:.3g} {unit}"
    return f"{number / 1024:.3g} kB"


def _threads(count: int) -> str:
    return "1 thread" if count == 1 else f"{count} threads"


def _address(array: np.ndarray) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)


@dataclass(frozen=True, slots=True)
class Limits:
    """The least time that this machine needs.

    Parameters
    ----------
    operation : dict of (str, int) to float [s]
        Of an operation, by unit of :data:`UNITS` and count of threads.
    byte : dict of int to list of (float, float) [s]
        Bytes that are gone through, and seconds of each, by count of threads.
    """

    operation: dict[tuple[str, int], float]
    byte: dict[int, list[tuple[float, float]]]

    @classmethod
    def of(cls, records: Iterable[Record]) -> Limits:
        """Limits that a run measured."""
        found = cls({}, {})
        for one in records:
            if one.contest != CONTEST or one.fastest is None:
                continue
            count = int(one.extra.get("threads", one.setting.split()[0]))
            if one.line == "bytes":
                found.byte.setdefault(count, []).append((one.extra["bytes"], one.fastest))
            else:
                unit = one.line.removeprefix("operations, ")
                found.operation[unit, count] = one.fastest
        return found

    def seconds(
        self, operations: float, size: float, total: float, *, unit: str, count: int = 1
    ) -> tuple[float, str]:
        """Least time of an evaluation, and what limits it.

        Parameters
        ----------
        operations, size : float
            Operations of an evaluation, and bytes that it reads and writes.
        total : float
            Bytes of all evaluations: where they lie, in a cache or in memory.
        unit : str
            Of :data:`UNITS`.
        count : int
            Threads.
        """
        known = sorted(self.byte[count])
        byte = np.interp(np.log(total), np.log([x for x, _ in known]), [y for _, y in known])
        arithmetic, memory = operations * self.operation[unit, count], float(size * byte)
        return max((arithmetic, "arithmetic"), (memory, "memory"))
