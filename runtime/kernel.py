"""Kernels as Python callables: the same checks and the same signature for every target."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from kousoku.model.files.manifest import KernelManifest
    from kousoku.runtime.arguments import CheckedArguments, Floats, Signature

    #: Takes inputs, ``out`` and a mask of wanted outputs; returns the outputs, or None for
    #: arguments that are not exactly as the C code wants them.
    FastCall = Callable[
        [tuple[Any, ...], Any, int],
        tuple[Floats, ...] | None,
    ]


class KernelTarget(Protocol):
    """Target that runs a kernel whose arguments have been checked."""

    #: Lanes of a block in the blocked layout.
    width: int

    def run(self, call: CheckedArguments) -> None:
        """Evaluate once, or ``call.n`` times with the batch axis first."""
        ...

    def run_lanes(self, call: CheckedArguments) -> None:
        """Evaluate ``call.n`` blocks of ``width`` lanes."""
        ...


class Kernel:
    """A function of float64 arrays, ``kernel(*inputs, out=None, outputs=None)``.

    Each input has the shape that its manifest names, after any leading batch axes, which broadcast
    as in NumPy. Integers, float32 and lists are converted as NumPy does. A call gives the tuple
    of the outputs asked for, in kernel order; the code of the others is not run.

    Parameters
    ----------
    manifest : KernelManifest
        Names, shapes, units and meaning of the arrays.
    signature : Signature
        The checks.
    target : KernelTarget
        Target that computes.
    fast : callable, optional
        Tried first; it takes only arguments that need no conversion.
    """

    __slots__ = ("_everything", "_fast", "_masks", "_signature", "_target", "manifest")

    def __init__(
        self,
        manifest: KernelManifest,
        signature: Signature,
        target: KernelTarget,
        fast: FastCall | None = None,
    ) -> None:
        self.manifest = manifest
        self._signature = signature
        self._target = target
        self._fast = fast
        self._everything = (1 << len(manifest.outputs)) - 1
        self._masks: dict[Any, int] = {}

    def __call__(
        self,
        *inputs: Any,
        out: Sequence[Floats | None] | None = None,
        outputs: Iterable[str] | None = None,
        **named: Any,
    ) -> tuple[Floats, ...]:
        """Evaluate the kernel.

        Parameters
        ----------
        *inputs : array_like
            In kernel order, or by name.
        out : tuple of (array or None), optional
            float64 C-contiguous arrays of the exact shapes, batch axes included; None for an
            output that is not wanted. ``outputs`` is then ignored.
        outputs : iterable of str, optional
            Names of the outputs wanted; all of them by default.

        Returns
        -------
        tuple of ndarray
            The outputs asked for, in kernel order.

        Raises
        ------
        TypeError, ValueError
            The message names the argument, what was got and what was wanted.
        """
        if named:
            inputs = self._signature.order(inputs, named)
        mask = self._everything if outputs is None or out is not None else self._mask(outputs)
        if self._fast is not None:
            results = self._fast(inputs, out, mask)
            if results is not None:
                return results
        return self._careful(inputs, out, mask)

    def bind(
        self,
        *inputs: Floats,
        out: Sequence[Floats | None] | None = None,
        outputs: Iterable[str] | None = None,
        **named: Floats,
    ) -> BoundKernel:
        """Kernel with fixed arrays, to be called with no arguments.

        The arrays are read and written in place at every call, so nothing is converted: each must
        be a float64 C-contiguous array (as for ``out``). Outputs that are not given are allocated
        once.
        """
        arrays = self._signature.order(inputs, named)
        mask = self._everything if outputs is None or out is not None else self._mask(outputs)
        return BoundKernel(self, arrays, out, mask)

    def lanes(
        self,
        *inputs: Any,
        out: Sequence[Floats | None] | None = None,
        outputs: Iterable[str] | None = None,
        **named: Any,
    ) -> tuple[Floats, ...]:
        """Evaluate arrays laid out in blocks of the vector width, (n_blocks, *shape, width).

        `kousoku.runtime.lanes` packs and unpacks such arrays. Arguments and result are as in a
        plain call, but every input has all blocks.
        """
        arrays = self._signature.order(inputs, named)
        wanted = self._flags(self._everything if outputs is None else self._mask(outputs))
        call, results = self._signature.prepare_lanes(arrays, out, wanted, self.lane_width)
        if call.n:
            self._target.run_lanes(call)
        return results

    @property
    def lane_width(self) -> int:
        """Length of the last axis in the lanes layout."""
        return self._target.width

    def __repr__(self) -> str:
        def table(quantities: Iterable[Any]) -> str:
            return ", ".join(f"{q.name} {q.shape} [{q.unit}]" for q in quantities)

        return (
            f"<{self._signature.name}: {table(self.manifest.inputs)}"
            f" -> {table(self.manifest.outputs)}>"
        )

    def _careful(self, inputs: tuple[Any, ...], out: Any, mask: int) -> tuple[Floats, ...]:
        arrays = self._signature.order(inputs, {})
        call, results = self._signature.prepare(arrays, out, self._flags(mask))
        if call.n != 0:
            self._target.run(call)
        return results

    def _mask(self, outputs: Iterable[str]) -> int:
        try:
            return self._masks[outputs]
        except (KeyError, TypeError):  # not seen before, or a list
            key = outputs if isinstance(outputs, str) else tuple(outputs)
        flags = self._signature.select(key)
        self._masks[key] = sum(1 << k for k, is_wanted in enumerate(flags) if is_wanted)
        return self._masks[key]

    def _flags(self, mask: int) -> tuple[bool, ...]:
        return tuple(bool(mask >> k & 1) for k in range(len(self.manifest.outputs)))


class BoundKernel:
    """A kernel with its arrays; calling it reads the inputs and overwrites ``out``.

    Parameters
    ----------
    inputs : tuple of arrays
        The inputs, as given.
    out : tuple of (array or None)
        Arrays of the outputs.
    """

    __slots__ = ("_fast", "_kernel", "_results", "inputs", "out")

    def __init__(
        self,
        kernel: Kernel,
        inputs: tuple[Any, ...],
        out: Sequence[Floats | None] | None,
        mask: int,
    ) -> None:
        self._kernel = kernel
        self._fast = kernel._fast
        self.inputs = inputs
        self._check_inputs()
        call, self._results = kernel._signature.prepare(inputs, out, kernel._flags(mask))
        results = iter(self._results)
        self.out = tuple(None if array is None else next(results) for array in call.out)

    def __call__(self) -> tuple[Floats, ...]:
        """Evaluate and return the outputs asked for, the same arrays every time."""
        # The check runs at every call: an array may have been resized in place since.
        if self._fast is None or self._fast(self.inputs, self.out, 0) is None:
            self._check_inputs()
            self._kernel._careful(self.inputs, self.out, 0)
        return self._results

    def _check_inputs(self) -> None:
        for q, array in zip(self._kernel.manifest.inputs, self.inputs, strict=True):
            if not (
                isinstance(array, np.ndarray)
                and array.dtype == np.float64
                and array.flags.carray | array.flags.c_contiguous & array.flags.aligned
            ):
                raise TypeError(
                    f"{self._kernel._signature.name}: bind reads {q.name} in place, so it must be "
                    "an aligned C-contiguous float64 array"
                )
