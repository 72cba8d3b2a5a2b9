"""Check and convert the arguments of a kernel; the messages are the same for every target."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from kousoku.model.files.quantity import Quantity

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class CheckedArguments:
    """Arguments that a target can take as they are.

    Parameters
    ----------
    n : int or None
        Count of evaluations, or of blocks in the lanes layout; None for a single call.
    inputs : tuple of arrays
        C-contiguous and aligned; of the wanted shape (shared by all evaluations) or with ``n`` in
        front of it.
    is_shared : tuple of bool
        Which inputs have no batch axis.
    out : tuple of arrays or None
        Arrays of the outputs, with ``n`` in front; None for outputs that are not wanted.
    """

    n: int | None
    inputs: tuple[Floats, ...]
    is_shared: tuple[bool, ...]
    out: tuple[Floats | None, ...]


@dataclass(frozen=True, slots=True)
class Signature:
    """The arrays that a kernel takes and gives.

    Parameters
    ----------
    name : str
        Package and kernel, for messages.
    inputs, outputs : tuple of Quantity
        In the order of the arguments.
    """

    name: str
    inputs: tuple[Quantity, ...]
    outputs: tuple[Quantity, ...]

    def order(self, positional: tuple[Any, ...], named: Mapping[str, Any]) -> tuple[Any, ...]:
        """Inputs in kernel order, some of them given by name."""
        names = [q.name for q in self.inputs]
        for name in named:
            if name not in names:
                raise TypeError(f"{self.name}: no input {name!r}; they are {', '.join(names)}")
            if name in names[: len(positional)]:
                raise TypeError(f"{self.name}: input {name} is given twice")
        remaining = names[len(positional) :]
        missing = [name for name in remaining if name not in named]
        if missing or len(positional) > len(names):
            count = len(positional) + len(named)
            raise TypeError(
                f"{self.name}: got {count} inputs, wanted {len(names)}: {', '.join(names)}"
                + (f"; missing: {', '.join(missing)}" if missing else "")
            )
        return (*positional, *(named[name] for name in remaining))

    def select(self, outputs: Iterable[str]) -> tuple[bool, ...]:
        """Outputs that are asked for, by their places."""
        names = [q.name for q in self.outputs]
        chosen = (outputs,) if isinstance(outputs, str) else tuple(outputs)
        for name in chosen:
            if name not in names:
                raise ValueError(
                    f"{self.name}: no output {name!r}; outputs= takes names out of "
                    f"{', '.join(names)}"
                )
        return tuple(name in chosen for name in names)

    def prepare(
        self, inputs: tuple[Any, ...], out: Sequence[Any] | None, wanted: tuple[bool, ...]
    ) -> tuple[CheckedArguments, tuple[Floats, ...]]:
        """Arguments as a target takes them, and the outputs as the caller sees them.

        Parameters
        ----------
        inputs : tuple of (*batch, *shape) array_like
            One for each input, with any leading batch axes.
        out : sequence of (*batch, *shape) arrays or None, optional
            Arrays of the outputs, None for an output that is not wanted.
        wanted : tuple of bool
            The outputs to allocate where ``out`` is not given.

        Raises
        ------
        TypeError, ValueError
            The message names the argument, what was got and what was wanted.
        """
        arrays = [self._floats(k, value) for k, value in enumerate(inputs)]
        batch = self._batch_shape(arrays)
        results = self._results(out, wanted, batch)
        if out is not None:
            arrays = [_apart(array, results) for array in arrays]
        n = None if batch == () else int(np.prod(batch, dtype=np.intp))
        flat = [self._flat(k, array, batch) for k, array in enumerate(arrays)]
        call = CheckedArguments(
            n=n,
            inputs=tuple(flat),
            is_shared=tuple(
                array.ndim == len(q.shape) for array, q in zip(flat, self.inputs, strict=True)
            ),
            out=tuple(
                array if array is None or n is None else array.reshape((n, *q.shape))
                for array, q in zip(results, self.outputs, strict=True)
            ),
        )
        return call, tuple(array for array in results if array is not None)

    def prepare_lanes(
        self,
        inputs: tuple[Any, ...],
        out: Sequence[Any] | None,
        wanted: tuple[bool, ...],
        width: int,
    ) -> tuple[CheckedArguments, tuple[Floats, ...]]:
        """Arguments and outputs as of :meth:`prepare`, in lanes: (n_blocks, *shape, width)."""
        arrays = [self._floats(k, value) for k, value in enumerate(inputs)]
        n = len(arrays[0]) if arrays and arrays[0].ndim else 0
        for array, q in zip(arrays, self.inputs, strict=True):
            if array.shape != (n, *q.shape, width):
                raise ValueError(
                    f"{self.name}: input {q.name}: got shape {array.shape}, wanted "
                    f"{(n, *q.shape, width)}: blocks, then the shape, then {width} lanes"
                )
        results = self._results(out, wanted, (n,), (width,))
        call = CheckedArguments(
            n=n,
            inputs=tuple(_apart(array, results) for array in arrays),
            is_shared=(False,) * len(arrays),
            out=results,
        )
        return call, tuple(array for array in results if array is not None)

    def _floats(self, k: int, value: Any) -> Floats:
        """Input as aligned C-contiguous doubles, copied only where it must be."""
        label = f"{self.name}: input {self.inputs[k].name}"
        try:
            array = np.asarray(value)
        except ValueError as error:
            raise ValueError(f"{label}: cannot be read as an array: {error}") from None
        if array.dtype.kind not in "biuf":
            raise TypeError(
                f"{label}: got dtype {array.dtype}, wanted real numbers that convert to float64"
            )
        floats = np.asarray(array, dtype=np.float64, order="C")
        return floats if floats.flags.aligned else floats.copy()

    def _batch_shape(self, arrays: list[Floats]) -> tuple[int, ...]:
        shapes = []
        for array, q in zip(arrays, self.inputs, strict=True):
            split = array.ndim - len(q.shape)
            if split < 0 or array.shape[split:] != q.shape:
                raise ValueError(
                    f"{self.name}: input {q.name}: got shape {array.shape}, wanted {q.shape} "
                    "after any leading batch axes"
                )
            shapes.append(array.shape[:split])
        if not any(shapes):
            return ()
        try:
            return np.broadcast_shapes(*shapes)
        except ValueError:
            table = ", ".join(
                f"{q.name} {shape}" for q, shape in zip(self.inputs, shapes, strict=True) if shape
            )
            raise ValueError(
                f"{self.name}: the leading batch axes do not broadcast: {table}"
            ) from None

    def _flat(self, k: int, array: Floats, batch: tuple[int, ...]) -> Floats:
        """Input with one batch axis, or with none if all evaluations share it.

        A batch of one keeps its axis: without it nothing would tell it from a single call.
        """
        shape = self.inputs[k].shape
        axes = array.shape[: array.ndim - len(shape)]
        if array.ndim == len(shape):
            return array
        if axes != batch and all(length == 1 for length in axes):
            return array.reshape(shape)
        return np.ascontiguousarray(np.broadcast_to(array, batch + shape)).reshape((-1, *shape))

    def _results(
        self,
        out: Sequence[Any] | None,
        wanted: tuple[bool, ...],
        batch: tuple[int, ...],
        lanes: tuple[int, ...] = (),
    ) -> tuple[Floats | None, ...]:
        """Arrays that the outputs go to: the caller's, checked, or new ones."""
        shapes = [(*batch, *q.shape, *lanes) for q in self.outputs]
        if out is None:
            return tuple(
                np.empty(shape) if is_wanted else None
                for shape, is_wanted in zip(shapes, wanted, strict=True)
            )
        if not isinstance(out, (tuple, list)) or len(out) != len(self.outputs):
            actual = f"{len(out)} entries" if isinstance(out, (tuple, list)) else type(out).__name__
            raise TypeError(
                f"{self.name}: out: got {actual}, wanted a tuple of {len(self.outputs)}: "
                f"{', '.join(q.name for q in self.outputs)} (None for an output not wanted)"
            )
        for q, array, shape in zip(self.outputs, out, shapes, strict=True):
            if array is not None:
                self._check_out(q.name, array, shape)
        self._check_apart(out)
        return tuple(out)

    def _check_out(self, name: str, array: Any, shape: tuple[int, ...]) -> None:
        label = f"{self.name}: out {name}"
        if not isinstance(array, np.ndarray):
            raise TypeError(f"{label}: got {type(array).__name__}, wanted a NumPy array or None")
        if array.dtype != np.float64 or not array.dtype.isnative:
            raise TypeError(f"{label}: got dtype {array.dtype}, wanted float64")
        if array.shape != shape:
            raise ValueError(f"{label}: got shape {array.shape}, wanted {shape}")
        if not (array.flags.c_contiguous and array.flags.aligned):
            raise ValueError(f"{label}: wanted a C-contiguous, aligned array")
        if not array.flags.writeable:
            raise ValueError(f"{label}: the array is read-only")

    def _check_apart(self, out: Sequence[Any]) -> None:
        arrays = [(q.name, a) for q, a in zip(self.outputs, out, strict=True) if a is not None]
        for k, (name, array) in enumerate(arrays):
            for other, earlier in arrays[:k]:
                if np.may_share_memory(array, earlier):
                    raise ValueError(f"{self.name}: out {other} and out {name} share memory")


def _apart(array: Floats, results: Sequence[Floats | None]) -> Floats:
    """Input, copied if an output would overwrite it while it is still read."""
    for result in results:
        if result is not None and np.may_share_memory(array, result):
            return array.copy()
    return array
