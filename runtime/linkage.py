"""Solve a linkage with the package that was generated from its scene."""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from kousoku.model.errors import LoadError
from kousoku.runtime.importing import import_source
from kousoku.runtime.kinematics.moving import Linkage
from kousoku.runtime.kinematics.rows import empty_rows
from kousoku.runtime.kinematics.trajectory import Trajectory
from kousoku.runtime.library import Library, load, read_files

if TYPE_CHECKING:
    from pathlib import Path
    from types import ModuleType

    from kousoku.runtime.kinematics.rows import Rows, Run

__all__ = ["LinkageSolver", "Trajectory", "load_scene", "solve"]

SOLVER = "solver.py"
#: Room for the results, in the order of the fields of ``kernels.h``.
RESULTS = ("alpha", "position", "velocity", "acceleration")
ANGLES = ("angle", "angle_dot", "angle_ddot")


class LinkageSolver(Linkage):
    """A loaded scene.

    Parameters
    ----------
    library : Library
        The kernels, and in C the solver.
    module : module
        The folder's ``solver.py``.
    """

    def __init__(self, library: Library, module: ModuleType) -> None:
        super().__init__(library.manifest.package, module, library)
        self.library = library

    def __repr__(self) -> str:
        return f"<LinkageSolver {self.name}; in {self.target}>"

    def __reduce__(self) -> tuple[Any, ...]:
        return solver_of, (self.library,)

    @property
    def target(self) -> str:
        """What computes, ``c`` or ``numpy``."""
        return self.library.target

    def rows(self, run: Run) -> Rows:
        """Return what :meth:`solve` starts from, for a run."""
        return self._run_c(run) if self.target == "c" else super().rows(run)

    def _run_c(self, run: Run) -> Rows:
        """Run the whole turn in one call of the compiled library."""
        prefix = f"kousoku_{self.name}"
        rows = empty_rows(self.mechanism, run.rows)
        record = record_of(run, rows)
        sizes = [self._size(f"{prefix}_{name}_size") for name in ("run", "workspace")]
        if sizes[0] != ctypes.sizeof(record):
            raise LoadError(f"{self.library.path}: its run is not as in this version of kousoku")
        function = self.library.function(f"{prefix}_solve")
        function.restype = ctypes.c_int
        workspace = (ctypes.c_double * -(-sizes[1] // 8))()
        rows.status = function(ctypes.byref(record), workspace)
        rows.done, rows.block = int(record.done), int(record.block)
        rows.reached = np.array(record.reached[:])
        return rows

    def _size(self, name: str) -> int:
        function = self.library.function(name)
        function.restype = ctypes.c_size_t
        return int(function())


def load_scene(
    folder: str | Path, *, target: Literal["auto", "c", "numpy"] = "auto"
) -> LinkageSolver:
    """Load the folder that was generated from a scene.

    Parameters
    ----------
    folder : path
        As ``kousoku.codegen.linkage.generate_scene`` made it.
    target : {"auto", "c", "numpy"}
        As of :func:`kousoku.runtime.load`.

    Raises
    ------
    LoadError
        It is not such a folder, or a file of it was edited.
    """
    return solver_of(load(folder, target=target))


def solver_of(library: Library) -> LinkageSolver:
    """Return the solver of a loaded package.

    Raises
    ------
    LoadError
        It has kernels only, or a file of it was edited.
    """
    folder = library.folder
    files = read_files(folder, library.manifest)
    if SOLVER not in files:
        raise LoadError(f"{folder} has kernels, but no solver: it is not made from a scene")
    return LinkageSolver(library, import_source(folder, files, SOLVER))


def solve(
    folder: str | Path, *, target: Literal["auto", "c", "numpy"] = "auto", **options: Any
) -> Trajectory:
    """Load a scene's folder and solve it; options as of :meth:`LinkageSolver.solve`."""
    return load_scene(folder, target=target).solve(**options)


def record_of(run: Run, rows: Rows) -> Any:
    """Return the record of ``kernels.h`` that asks for a run and points at room for its rows."""
    record = _run_type(len(run.origin))()
    for name in ("method", "max_iterations", "limit", "divisions", "start", "first", "rows"):
        setattr(record, name, getattr(run, name))
    for name in ("origin", "span", "turns", "rate", "rate_dot"):
        getattr(record, name)[:] = getattr(run, name)
    if run.times is not None:
        record.times = run.times.ctypes.data
    for name in (*RESULTS, *ANGLES, "iterations", "residual", "condition"):
        array = getattr(rows, name)
        setattr(record, name, array.ctypes.data if array.size else None)
    return record


def _run_type(inputs: int) -> type[ctypes.Structure]:
    """Return the record of ``kernels.h``."""
    numbers = ctypes.c_double * inputs
    whole = ctypes.c_longlong

    class Run(ctypes.Structure):
        _fields_ = (
            ("method", ctypes.c_int),
            ("max_iterations", ctypes.c_int),
            ("limit", ctypes.c_double),
            *((name, whole) for name in ("divisions", "start", "first")),
            ("rows", ctypes.c_size_t),
            ("origin", numbers),
            ("span", numbers),
            ("turns", whole * inputs),
            ("rate", numbers),
            ("rate_dot", numbers),
            ("times", ctypes.c_void_p),
            *((name, ctypes.c_void_p) for name in (*RESULTS, *ANGLES)),
            ("iterations", ctypes.c_void_p),
            ("residual", ctypes.c_void_p),
            ("condition", ctypes.c_void_p),
            ("done", ctypes.c_size_t),
            ("block", ctypes.c_size_t),
            ("reached", numbers),
        )

    return Run
