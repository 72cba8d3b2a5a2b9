"""What computes the motion of a scene of bodies: the compiled solver, or the one in NumPy."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol, get_type_hints

from kousoku.runtime.choice import choose
from kousoku.runtime.integrate.settings import Settings

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    import numpy as np
    import numpy.typing as npt

    from kousoku.model.manifest import Manifest
    from kousoku.runtime.choice import Target

    Array = npt.NDArray[np.float64]

C_SOURCE = "solver.c"


@dataclass(frozen=True, slots=True)
class Memory:
    """What the caller owns.

    Parameters
    ----------
    state : array
        All that lasts from call to call.
    work : array
        Memory for work.
    """

    state: Array
    work: Array


class SolverTarget(Protocol):
    """The functions of ``solver.h`` on arrays; the caller owns all of them.

    Parameters
    ----------
    name : {"c", "numpy"}
        What computes.
    state_size, work_size, row_size : int
        Counts of numbers in a state, in the memory for work, and in a row of results.
    """

    name: str
    state_size: int
    work_size: int
    row_size: int

    def start(self, time: float, q: Array, v: Array, parameters: Array, memory: Memory) -> int:
        """Take a position and velocity, and project them onto the constraints."""

    def run(
        self, settings: Settings, times: Array, max_steps: int, memory: Memory, rows: Array
    ) -> int:
        """Move on to the last of the times, and write a row for each, as many as there are."""

    def evaluate(self, time: float, q: Array, v: Array, parameters: Array, work: Array) -> int:
        """Compute all that the scene has at a state as it is; it is left in the work."""

    def residuals(self, memory: Memory, found: Array) -> None:
        """Write what is left of the constraints where they were evaluated last."""

    def pivots(self, memory: Memory, found: Array) -> int:
        """Write the pivots of the factors at the state."""


#: The types of C for those of Python.
_TYPES: dict[type, type[ctypes.c_double | ctypes.c_int]] = {
    float: ctypes.c_double,
    int: ctypes.c_int,
}


class _Settings(ctypes.Structure):
    """The record ``settings`` of ``solver.h``, field by field as in Python."""

    _fields_ = tuple((name, _TYPES[kind]) for name, kind in get_type_hints(Settings).items())


class CompiledSolver:
    """A scene's compiled solver, called through ctypes.

    Parameters
    ----------
    library : ctypes.CDLL
        The loaded library.
    scene : str
        Its functions begin with ``kousoku_<scene>``.
    """

    name = "c"

    def __init__(self, library: ctypes.CDLL, scene: str) -> None:
        self._library = library
        self._prefix = f"kousoku_{scene}_"
        self.state_size, self.work_size, self.row_size = (
            self._function(f"{part}_size", ctypes.c_size_t)() for part in ("state", "work", "row")
        )

    def _function(self, name: str, result: Any = ctypes.c_int) -> Any:
        function = self._library[self._prefix + name]
        function.restype = result
        return function

    def start(self, time: float, q: Array, v: Array, parameters: Array, memory: Memory) -> int:
        """Take a position and velocity, and project them onto the constraints."""
        arrays = map(_address, (q, v, parameters, memory.state, memory.work))
        return int(self._function("start")(ctypes.c_double(time), *arrays))

    def run(
        self, settings: Settings, times: Array, max_steps: int, memory: Memory, rows: Array
    ) -> int:
        """Move on to the last of the times, and write a row for each, as many as there are."""
        status = self._function("run")(
            ctypes.byref(_Settings(*settings)),
            _address(times),
            *map(ctypes.c_size_t, (len(times), max_steps, len(rows))),
            *map(_address, (memory.state, memory.work, rows)),
            ctypes.byref(ctypes.c_size_t()),
        )
        return int(status)

    def evaluate(self, time: float, q: Array, v: Array, parameters: Array, work: Array) -> int:
        """Compute all that the scene has at a state as it is; it is left in the work."""
        arrays = map(_address, (q, v, parameters, work))
        return int(self._function("evaluate")(ctypes.c_double(time), *arrays))

    def residuals(self, memory: Memory, found: Array) -> None:
        """Write what is left of the constraints where they were evaluated last."""
        self._function("residuals", None)(_address(memory.work), _address(found))

    def pivots(self, memory: Memory, found: Array) -> int:
        """Write the pivots of the factors at the state."""
        arrays = map(_address, (memory.state, memory.work, found))
        return int(self._function("pivots")(*arrays))


def _address(array: Array) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)


def open_solver(
    folder: Path,
    manifest: Manifest,
    files: Mapping[str, bytes],
    target: Target,
) -> SolverTarget:
    """Return what computes.

    Parameters
    ----------
    folder : Path
        Where the files lie.
    manifest : Manifest
        What the folder promises.
    files : mapping of str to bytes
        Name and content, compared with the manifest.
    target : {"auto", "c", "numpy"}
        ``"auto"`` takes C where a compiler and a cache can be had, and else NumPy after saying why
        in one line on the logger ``kousoku``.

    Raises
    ------
    TargetError
        The folder was generated without this target.
    CompilerError
        The compiler refuses the source; with ``target="c"`` also if there is none.
    CacheError
        With ``target="c"``: the library cannot be kept.
    """
    from kousoku.runtime.dynamics_numpy import NUMPY_SOURCE, load_numpy

    return choose(
        target,
        folder,
        files,
        (C_SOURCE, lambda: _compiled(manifest, files)),
        (NUMPY_SOURCE, lambda reason: load_numpy(folder, manifest, files, reason)),
    )


def _compiled(manifest: Manifest, files: Mapping[str, bytes]) -> SolverTarget:
    from kousoku.runtime.library import compiled
    from kousoku.runtime.toolchain import find_toolchain

    return CompiledSolver(compiled(manifest, files, find_toolchain())[0], manifest.package)
