"""Targets of a kernel: the emitted NumPy function, or the compiled library by ctypes."""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING, Any

import numpy as np

from kousoku.model.errors import CacheError, LoadError
from kousoku.runtime.lanes import from_lanes, to_lanes

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from pathlib import Path

    from kousoku.model.files.manifest import KernelManifest, Manifest
    from kousoku.runtime.arguments import CheckedArguments, Floats

#: Lanes of a block where no processor decides it.
NUMPY_WIDTH = 8
_DOUBLE = np.dtype(np.float64)


class NumpyTarget:
    """A function of an emitted ``kernels.py``.

    Parameters
    ----------
    function : callable
        It broadcasts over leading batch axes and writes into ``out``.
    manifest : KernelManifest
        Its signature.
    """

    __slots__ = ("_function", "_names", "_shapes", "width")

    def __init__(self, function: Callable[..., Any], manifest: KernelManifest) -> None:
        self._function = function
        self._shapes = tuple(q.shape for q in manifest.inputs)
        self._names = tuple(q.name for q in manifest.outputs)
        self.width = NUMPY_WIDTH

    def call(self, inputs: tuple[Any, ...], out: Any, mask: int) -> tuple[Floats, ...] | None:
        """Evaluate once if nothing needs to be converted or checked, else return None."""
        if out is not None or len(inputs) != len(self._shapes):
            return None
        for array, shape in zip(inputs, self._shapes, strict=True):
            if type(array) is not np.ndarray or array.dtype is not _DOUBLE or array.shape != shape:
                return None
        names = tuple(name for k, name in enumerate(self._names) if mask >> k & 1)
        results: tuple[Floats, ...] = self._function(*inputs, outputs=names)
        return results

    def run(self, call: CheckedArguments) -> None:
        """Evaluate once, or a batch."""
        self._function(*call.inputs, out=call.out)

    def run_lanes(self, call: CheckedArguments) -> None:
        """Evaluate blocks: unpacked, as one batch, and packed again."""
        inputs = [from_lanes(array) for array in call.inputs]
        shapes = [None if a is None else (call.n, *a.shape[1:-1], self.width) for a in call.out]
        rows = tuple(None if s is None else np.empty((s[0] * s[-1], *s[1:-1])) for s in shapes)
        self._function(*inputs, out=rows)
        for blocks, row in zip(call.out, rows, strict=True):
            if blocks is not None and row is not None:
                blocks[...] = to_lanes(row, self.width)


class CTarget:
    """A kernel of a compiled library, called through ctypes.

    Parameters
    ----------
    library : ctypes.CDLL
        The loaded library.
    prefix : str
        ``kousoku_<package>_<kernel>``.
    manifest : KernelManifest
        The kernel's signature, already compared with the library's.
    width : int
        Lanes of a block.
    """

    __slots__ = ("_batch", "_lanes", "_single", "_sizes", "addresses", "width")

    def __init__(
        self, library: ctypes.CDLL, prefix: str, manifest: KernelManifest, width: int
    ) -> None:
        self._single, self._batch, self._lanes = _functions(library, prefix)
        for function in (self._single, self._batch, self._lanes):
            function.restype = None
        self._sizes = tuple(q.size for q in manifest.inputs)
        self.addresses = tuple(
            ctypes.cast(function, ctypes.c_void_p).value or 0
            for function in (self._single, self._batch)
        )
        self.width = width

    def run(self, call: CheckedArguments) -> None:
        """Evaluate once, or a batch."""
        inputs, outputs = _pointers(call.inputs), _pointers(call.out)
        if call.n is None:
            self._single(inputs, outputs)
            return
        steps = (0 if s else size for s, size in zip(call.is_shared, self._sizes, strict=True))
        strides = (ctypes.c_size_t * len(self._sizes))(*steps)
        self._batch(ctypes.c_size_t(call.n), inputs, strides, outputs)

    def run_lanes(self, call: CheckedArguments) -> None:
        """Evaluate blocks of ``width`` lanes."""
        n = ctypes.c_size_t(call.n or 0)
        self._lanes(n, _pointers(call.inputs), _pointers(call.out))


def _functions(library: ctypes.CDLL, prefix: str) -> list[Any]:
    """Functions of a kernel: one evaluation, a batch, blocks of lanes; none may be missing."""
    return [library[f"{prefix}_{name}"] for name in ("call", "batch", "lanes")]


def _pointers(arrays: Sequence[Floats | None]) -> ctypes.Array[ctypes.c_void_p]:
    addresses = (None if array is None else array.ctypes.data for array in arrays)
    return (ctypes.c_void_p * len(arrays))(*addresses)


def open_library(path: Path, manifest: Manifest) -> ctypes.CDLL:
    """Load a shared library and compare what it exports with the manifest.

    Raises
    ------
    CacheError
        The system does not load it, for instance from a file system mounted without execution.
    LoadError
        It is not the library of this package: stale or foreign.
    """
    try:
        library = ctypes.CDLL(str(path))
    except OSError as error:
        raise CacheError(f"the system cannot load {path}: {error}") from None
    problem = _problem(library, manifest)
    if problem:
        raise LoadError(
            f"{path} is not the library of the package {manifest.package!r}: {problem}. "
            "It is stale or foreign; remove its folder, and the next load builds it again"
        )
    return library


def _problem(library: ctypes.CDLL, manifest: Manifest) -> str:
    """Difference of a library from its manifest, ``""`` if there is none."""
    prefix = f"kousoku_{manifest.package}"
    try:
        digest = _text(library, f"{prefix}_digest")
        if digest != manifest.digest:
            return f"it exports the digest {digest}, the manifest wants {manifest.digest}"
        return _difference(library, prefix, manifest.kernels)
    except AttributeError as error:  # ctypes names the symbol that it did not find
        return str(error)


def lane_width(library: ctypes.CDLL, package: str) -> int:
    """Count of lanes of a block in a library."""
    function = library[f"kousoku_{package}_lanes"]
    function.restype = ctypes.c_size_t
    function.argtypes = ()
    return int(function())


def _difference(library: ctypes.CDLL, package: str, kernels: Sequence[KernelManifest]) -> str:
    """Difference of exported kernels from the manifest's, ``""`` if there is none."""
    for kernel in kernels:
        _functions(library, f"{package}_{kernel.name}")
        exported = _text(library, f"{package}_{kernel.name}_signature")
        if exported != kernel.signature:
            return (
                f"{kernel.name} has the signature {exported}, the manifest wants {kernel.signature}"
            )
    return ""


def _text(library: ctypes.CDLL, name: str) -> str:
    function = library[name]
    function.restype = ctypes.c_char_p
    function.argtypes = ()
    return (function() or b"").decode(errors="replace")
