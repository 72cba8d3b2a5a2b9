"""The segments of a scene in NumPy: kernels that are called one after the other on one workspace.

Few tasks of a kernel run one by one on Python's floats, many of them together on arrays whose last
axis is the task: both give the bits that C gives.
"""

from __future__ import annotations

import math
import re
from operator import itemgetter
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from typing import TypeAlias

    import numpy.typing as npt

    from .arithmetic import Array

    Slots: TypeAlias = npt.NDArray[np.intp]
    Values: TypeAlias = Sequence[Any] | Array
    Function: TypeAlias = Callable[[Values, "Functions"], list[Any]]

#: From so many tasks of a kernel on arrays are faster.
MANY = 16


#: What follows it in a line of a table says what the line belongs to.
COMMENT = re.compile("#.*")


def numbers(text: str) -> list[float]:
    """Numbers (n,) of a table, in its units."""
    return [float(number) for number in COMMENT.sub("", text).split()]


def places(text: str, width: int) -> Slots:
    """Table of places, in rows of a width."""
    return np.array(COMMENT.sub("", text).split(), dtype=np.intp).reshape(-1, width)


class Functions(NamedTuple):
    """Functions that kernels call."""

    sqrt: Callable[[Any], Any]
    sin: Callable[[Any], Any]
    cos: Callable[[Any], Any]
    atan2: Callable[[Any, Any], Any]
    exp: Callable[[Any], Any]
    log: Callable[[Any], Any]
    fabs: Callable[[Any], Any]
    fmax: Callable[[Any, Any], Any]


def fmax(a: float, b: float) -> float:
    """Larger of two numbers; a NaN counts as none."""
    return a if a >= b or math.isnan(b) else b


#: One task: Python's floats are faster than arrays of one number.
OF_FLOATS = Functions(
    math.sqrt, math.sin, math.cos, math.atan2, math.exp, math.log, math.fabs, fmax
)


def of_each(of_one: Callable[..., float], of_all: Callable[..., Any]) -> Callable[..., Any]:
    """Function of arrays with the bits that C has; NumPy's may differ in the last one."""

    def function(*x: Any) -> Any:
        arrays = np.broadcast_arrays(*x)
        try:
            results = [
                of_one(*values)
                for values in zip(*(array.ravel().tolist() for array in arrays), strict=True)
            ]
        except (ArithmeticError, ValueError):
            return of_all(*x)
        return np.array(results).reshape(arrays[0].shape)

    return function


#: Many tasks: an array for each value, with an element for each task.
OF_ARRAYS = Functions(
    np.sqrt,
    of_each(math.sin, np.sin),
    of_each(math.cos, np.cos),
    of_each(math.atan2, np.arctan2),
    of_each(math.exp, np.exp),
    of_each(math.log, np.log),
    np.fabs,
    np.fmax,
)


class TaskKernel(NamedTuple):
    """A kernel, and where its values are.

    Parameters
    ----------
    function : callable
        From a sequence of values, and the functions that it may call, to a list of values.
    runs : int
        How many runs of consecutive slots a task lists: those that it reads, then those that it
        writes.
    reads, writes : (n, 2) array
        Run, and place in it, of each value.
    """

    function: Function
    runs: int
    reads: Slots
    writes: Slots

    @classmethod
    def read(cls, function: Function, runs: int, reads: str, writes: str) -> TaskKernel:
        """Kernel whose places are tables in text."""
        return cls(function, runs, places(reads, 2), places(writes, 2))


class Together(NamedTuple):
    """Many tasks of one kernel that do not need each other; a row of slots for each value."""

    function: Function
    reads: Slots
    writes: Slots


class InTurn(NamedTuple):
    """Tasks one after the other, on a list of floats: what is gathered, then what each gives."""

    gathered: Slots
    tasks: list[tuple[Function, Callable[[Any], Any]]]
    scattered: Slots


Segment = list[Together | InTurn]


def segment_of(kernels: Sequence[TaskKernel], text: str) -> Segment:
    """Tasks of a segment.

    Parameters
    ----------
    kernels : sequence of TaskKernel
        Those of the scene.
    text : str
        A table: the number of a kernel, how many tasks of it follow, and the first slot of each
        run of each task. Tasks of one kernel that follow each other do not need each other.
    """
    table = places(text, 1)[:, 0]
    segment: Segment = []
    few: list[tuple[TaskKernel, list[int], list[int]]] = []
    cursor = 0
    while cursor < len(table):
        kernel, count = kernels[table[cursor]], int(table[cursor + 1])
        end = cursor + 2 + count * kernel.runs
        runs = table[cursor + 2 : end].reshape(count, kernel.runs)
        reads = runs[:, kernel.reads[:, 0]] + kernel.reads[:, 1]
        writes = runs[:, kernel.writes[:, 0]] + kernel.writes[:, 1]
        if count >= MANY:
            segment += _in_turn(few)
            segment.append(Together(kernel.function, reads.T.copy(), writes.T.copy()))
            few = []
        else:
            slots = zip(reads.tolist(), writes.tolist(), strict=True)
            few += [(kernel, read, written) for read, written in slots]
        cursor = end
    return [*segment, *_in_turn(few)]


def _in_turn(tasks: list[tuple[TaskKernel, list[int], list[int]]]) -> list[InTurn]:
    """Tasks in turn: slots that they read, and none of them wrote before, are gathered."""
    if not tasks:
        return []
    gathered: dict[int, int] = {}
    written: dict[int, int] = {}
    for _, reads, writes in tasks:
        for slot in reads:
            if slot not in written:
                gathered.setdefault(slot, len(gathered))
        for slot in writes:
            written[slot] = len(written)
    index = {slot: len(gathered) + k for slot, k in written.items()} | gathered
    steps = [
        (kernel.function, _picker([index[slot] for slot in reads])) for kernel, reads, _ in tasks
    ]
    return [InTurn(np.array([*gathered], np.intp), steps, np.array([*written], np.intp))]


def _picker(indices: list[int]) -> Callable[[Any], Any]:
    """Function that picks elements of a list, as a sequence however few they are."""
    if len(indices) > 1:
        return itemgetter(*indices)
    return itemgetter(slice(indices[0], indices[0] + 1) if indices else slice(0))


def run_tasks(w: Array, segment: Segment) -> None:
    """Run a segment on the workspace w (work_size,), in SI units.

    What its tasks read is gathered, what they give is scattered.
    """
    for tasks in segment:
        if isinstance(tasks, Together):
            for slots, values in zip(
                tasks.writes, tasks.function(w[tasks.reads], OF_ARRAYS), strict=True
            ):
                w[slots] = values
            continue
        count = len(tasks.gathered)
        try:
            values = _evaluated(tasks, w[tasks.gathered].tolist(), OF_FLOATS)
        except (ArithmeticError, ValueError):
            # No number comes out: NumPy's go on with infinities and NaN, as C does.
            values = _evaluated(tasks, list(w[tasks.gathered]), OF_ARRAYS)
        w[tasks.scattered] = values[count:]


def _evaluated(tasks: InTurn, values: list[Any], m: Functions) -> list[Any]:
    """Append what each task gives to the values that were gathered."""
    for function, picked in tasks.tasks:
        values += function(picked(values), m)
    return values
