"""NumPy kernels called once or over leading axes; beside a ``kernels.py`` lies a copy.

Only the kinds that kousoku ships take it from here.

A generated folder works when it alone is copied out, so that this file imports NumPy only.
"""

from __future__ import annotations

import math
from functools import cache
from operator import itemgetter
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from typing import TypeAlias

    import numpy.typing as npt

    Array: TypeAlias = npt.NDArray[np.float64]
    Body: TypeAlias = Callable[..., tuple[list[Any], ...]]
    Call: TypeAlias = tuple[np.ufunc, tuple[Any, ...], "_Symbol"]
    Inputs: TypeAlias = Sequence[tuple[Array, tuple[int, ...]]]
    Out: TypeAlias = Sequence[Array | None] | None
    Results: TypeAlias = Sequence[Array | None]  # None where an output is not wanted

#: Evaluations at a time.
BLOCK = 2048


class NumpyKernel(NamedTuple):
    """Signature and code of a kernel.

    Parameters
    ----------
    name, inputs, outputs : str, mapping of str to tuple of int, the same
        Its name, for messages; names and shapes of what it takes and gives.
    body : callable
        Takes the elements of all inputs, floats or arrays alike, and gives those of all outputs.
    alone : mapping of str to (callable, sequence of int)
        For outputs that alone cost at most half: their body, and which inputs it reads.
    is_polynomial : bool
        Whether Python's floats give what arrays give.
    """

    name: str
    inputs: Mapping[str, tuple[int, ...]]
    outputs: Mapping[str, tuple[int, ...]]
    body: Body
    alone: Mapping[str, tuple[Body, Sequence[int]]]
    is_polynomial: bool


def evaluate(
    kernel: NumpyKernel, arguments: Sequence[npt.ArrayLike], out: Out, outputs: Sequence[str] | None
) -> tuple[Array, ...]:
    """Evaluate a kernel once, or over all leading axes, broadcast; only what is asked for.

    Parameters
    ----------
    kernel, arguments : NumpyKernel, sequence of (*batch, *shape) array_like
        What is evaluated, and its inputs, in the units of the kernel.
    out, outputs : sequence of array or None, sequence of str, optional
        For each output the array to write, None where it is not wanted; or the names of those that
        are. All outputs unless given.
    """
    inputs = [np.asarray(argument, dtype=np.float64) for argument in arguments]
    batch = _batch(kernel, inputs)
    given = list(zip(inputs, kernel.inputs.values(), strict=True))
    results = _results(kernel, batch, out, outputs)
    fill = _fill_once if not batch and kernel.is_polynomial else _fill_blocks
    if len(results) < len(kernel.outputs) and results.keys() <= kernel.alone.keys():
        for name, array in results.items():
            body, read = kernel.alone[name]
            fill(body, [given[k] for k in read], (array,), batch)
    else:
        fill(kernel.body, given, [results.get(name) for name in kernel.outputs], batch)
    return tuple(results.values())


def _batch(kernel: NumpyKernel, inputs: Sequence[Array]) -> tuple[int, ...]:
    """Check the shapes and return the leading axes."""
    batches = []
    for array, (name, shape) in zip(inputs, kernel.inputs.items(), strict=True):
        split = array.ndim - len(shape)
        if split < 0 or array.shape[split:] != shape:
            raise ValueError(f"{kernel.name}: {name} is {array.shape}, wanted (...) + {shape}")
        batches.append(array.shape[:split])
    return np.broadcast_shapes(*batches) if any(batches) else ()


def _results(
    kernel: NumpyKernel, batch: tuple[int, ...], out: Out, outputs: Sequence[str] | None
) -> dict[str, Array]:
    """Arrays to fill, by name: new ones, or those of ``out`` once they are checked."""
    shapes = {name: batch + shape for name, shape in kernel.outputs.items()}
    if out is None:
        wanted = shapes if outputs is None else outputs
        if unknown := [name for name in wanted if name not in shapes]:
            raise ValueError(f"{kernel.name}: no output {unknown[0]!r}, wanted of {[*shapes]}")
        return {name: np.empty(shape) for name, shape in shapes.items() if name in wanted}
    if len(out) != len(shapes):
        raise ValueError(f"{kernel.name}: out has {len(out)} items, wanted one for {[*shapes]}")
    given = {name: array for name, array in zip(shapes, out, strict=True) if array is not None}
    for name, array in given.items():
        if array.shape != shapes[name] or array.dtype != np.float64:
            got, wanted_ = f"{array.dtype} {array.shape}", f"float64 {shapes[name]}"
            raise ValueError(f"{kernel.name}: out of {name} is {got}, wanted {wanted_}")
    return given


def _fill_once(body: Body, inputs: Inputs, results: Results, _batch: tuple[int, ...]) -> None:
    """Evaluate once: Python's floats are faster than arrays of one number."""
    values = body(*[array.ravel().tolist() for array, _ in inputs])
    for result, elements in zip(results, values, strict=True):
        if result is not None:
            result[...] = np.array(elements).reshape(result.shape)


def _fill_blocks(body: Body, inputs: Inputs, results: Results, batch: tuple[int, ...]) -> None:
    """Evaluate in blocks: each operation once a block, in rows that stay in the cache."""
    n = math.prod(batch)
    sizes = tuple(math.prod(shape) for _, shape in inputs)
    tape = _recorded(body, sizes, tuple(result is not None for result in results))
    columns = [column for array, shape in inputs for column in _rows(array, shape, batch).T]
    wanted = [result for result in results if result is not None]
    whole = [array if array.flags.c_contiguous else np.empty(array.shape) for array in wanted]
    flat = [array.reshape(n, math.prod(array.shape[len(batch) :])) for array in whole]
    targets = [column for array in flat for column in array.T]
    rows = [np.empty(min(n, BLOCK)) for _ in range(tape.n_rows)]
    with np.errstate(all="ignore"):
        for start in range(0, n, BLOCK):
            block = slice(start, start + BLOCK)
            if n - start < BLOCK:
                rows = [row[: n - start] for row in rows]
            for row, column in zip(rows, columns, strict=False):
                np.copyto(row, column[block] if len(column) == n else column)
            values: list[Any] = [*[target[block] for target in targets], *tape.constants, *rows]
            for function, operands in tape.steps:
                function(*operands(values))
            for target, source in tape.copies:
                values[target][...] = values[source]
    for array, result in zip(whole, wanted, strict=True):
        if array is not result:
            result[...] = array


def _rows(array: Array, shape: tuple[int, ...], batch: tuple[int, ...]) -> Array:
    """Rows, one for each evaluation, or the one row that all evaluations share."""
    if array.ndim == len(shape):
        return array.reshape(1, math.prod(shape))
    rows = np.broadcast_to(array, batch + shape)
    return rows.reshape(math.prod(batch), math.prod(shape))


class _Tape(NamedTuple):
    """A body as array operations on a list of places: results, then constants, then rows.

    The first rows hold the inputs. A step is a function and what picks its operands and its
    result from the list; a copy is the place of a result and the place that it repeats.
    """

    steps: Sequence[tuple[np.ufunc, Callable[[list[Any]], Any]]]
    copies: list[tuple[int, int]]
    constants: list[float]
    n_rows: int


class _Symbol(NDArrayOperatorsMixin):
    """Stands for a number while a body is recorded."""

    def __init__(self, calls: list[Call]) -> None:
        self.calls = calls
        self.place = -1
        self.uses = 0

    def __array_ufunc__(self, function: np.ufunc, _method: str, *operands: Any) -> _Symbol:
        result = _Symbol(self.calls)
        self.calls.append((function, operands, result))
        return result


def _needed(calls: Sequence[Call], results: Sequence[Any]) -> list[Call]:
    """Operations that some results need; the uses of each symbol by them are counted."""
    needed: list[Call] = []
    for value in results:
        if isinstance(value, _Symbol):
            value.uses += 1
    for call in reversed(calls):
        if call[2].uses:
            needed.append(call)
            for value in call[1]:
                if isinstance(value, _Symbol):
                    value.uses += 1
    return needed[::-1]


@cache
def _recorded(body: Body, sizes: tuple[int, ...], is_wanted: tuple[bool, ...]) -> _Tape:
    """Run a body once on symbols, and keep the operations that the wanted outputs need.

    A row is free again after the last use of what it holds.
    """
    calls: list[Call] = []
    inputs = [_Symbol(calls) for _ in range(sum(sizes))]
    symbols = iter(inputs)
    outputs = body(*[[next(symbols) for _ in range(size)] for size in sizes])
    wanted = [output for output, is_one in zip(outputs, is_wanted, strict=True) if is_one]
    results = [value for output in wanted for value in output]
    kept = _needed(calls, results)
    used = [*results, *(value for _, operands, _ in kept for value in operands)]
    constants = [*dict.fromkeys(float(x) for x in used if not isinstance(x, _Symbol))]
    numbers = {value: len(results) + k for k, value in enumerate(constants)}
    first = end = len(results) + len(constants)
    for symbol in inputs:
        symbol.place, end = end, end + 1
    for place, value in enumerate(results):
        if isinstance(value, _Symbol) and value.place < 0 and value.uses == 1:
            value.place = place
    steps, free = [], []
    for function, operands, result in kept:
        picked = [x.place if isinstance(x, _Symbol) else numbers[float(x)] for x in operands]
        for x in operands:
            if isinstance(x, _Symbol):
                x.uses -= 1
                free += [x.place] if x.uses == 0 else []
        if result.place < 0:
            result.place, end = (free.pop(), end) if free else (end, end + 1)
        steps.append((function, itemgetter(*picked, result.place)))
    ends = [x.place if isinstance(x, _Symbol) else numbers[float(x)] for x in results]
    copies = [(to, place) for to, place in enumerate(ends) if place != to]
    return _Tape(steps, copies, constants, end - first)
