"""Solve a linkage with the package that was generated from its scene."""

from __future__ import annotations

import ctypes
import json
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from kousoku.model.errors import LoadError
from kousoku.runtime.choice import choose
from kousoku.runtime.dynamics import LINKAGE_LIBRARY, MOTION_FILE
from kousoku.runtime.dynamics_numpy import NUMPY_SOURCE
from kousoku.runtime.dynamics_targets import C_SOURCE
from kousoku.runtime.given import folder_of
from kousoku.runtime.importing import import_source
from kousoku.runtime.kinematics.moving import Linkage
from kousoku.runtime.kinematics.rows import RUN, empty_rows
from kousoku.runtime.kinematics.solve import Solver
from kousoku.runtime.kinematics.trajectory import Trajectory
from kousoku.runtime.library import compiled, read_files, read_manifest, require_digest
from kousoku.runtime.notice import say_once
from kousoku.runtime.sources import Sources

if TYPE_CHECKING:
    from collections.abc import Collection
    from pathlib import Path

    from kousoku.runtime.choice import Target
    from kousoku.runtime.kinematics.mechanism import Array
    from kousoku.runtime.kinematics.rows import Rows, Run

__all__ = ["LinkageSolver", "Trajectory", "load_scene", "solve"]

#: The types of numbers of ``solver.h``; all others point at numbers.
_TYPES: dict[str, Any] = {
    "int": ctypes.c_int,
    "double": ctypes.c_double,
    "long long": ctypes.c_longlong,
    "size_t": ctypes.c_size_t,
}


class LinkageSolver(Linkage):
    """A loaded linkage.

    Parameters
    ----------
    sources : Sources
        The generated files.
    solver : Solver
        That of ``solver.py``, with the analysis of the folder.
    library : ctypes.CDLL, optional
        The compiled solver.
    """

    def __init__(
        self, sources: Sources, solver: Solver, library: ctypes.CDLL | None = None
    ) -> None:
        data = json.loads(sources.files[MOTION_FILE])
        super().__init__(data, solver)
        self.sources = sources
        self._library = library
        self._segments: list[str] = data["segments"]

    def __repr__(self) -> str:
        return f"<LinkageSolver {self.name}; in {self.target}>"

    def __reduce__(self) -> tuple[Any, ...]:
        return _open_same, (self.sources, self.target)

    @property
    def target(self) -> str:
        """What computes, ``c`` or ``numpy``."""
        return "numpy" if self._library is None else "c"

    def rows(self, run: Run) -> Rows:
        """Return what :meth:`solve` starts from, for a run."""
        return super().rows(run) if self._library is None else self._run_c(run)

    def evaluate(self, segment: str, given: dict[str, Array]) -> dict[str, Array]:
        """Return the workspace after a segment, region by region.

        Parameters
        ----------
        segment : str
            As in the mechanism: ``position_1`` … ``nodes``.
        given : dict of str to array
            What stands in regions before.
        """
        mechanism = self.mechanism
        slots = np.zeros(mechanism.work_size)
        places = {name: slice(base, base + n) for name, (base, n) in mechanism.regions.items()}
        for name, values in given.items():
            slots[places[name]] = values
        if self._library is None:
            mechanism.segments[segment](slots)
        else:
            number = ctypes.c_size_t(self._segments.index(segment))
            self._function("evaluate", None)(number, slots.ctypes.data_as(ctypes.c_void_p))
        return {name: slots[place] for name, place in places.items()}

    def _run_c(self, run: Run) -> Rows:
        """Run the whole turn in one call of the compiled library."""
        rows = empty_rows(self.mechanism, run.rows)
        record = record_of(run, rows)
        sizes = [self._function(f"{name}_size", ctypes.c_size_t)() for name in ("run", "workspace")]
        if sizes[0] != ctypes.sizeof(record):
            raise LoadError(f"{self.name}: its run is not as in this version of kousoku")
        workspace = (ctypes.c_double * -(-sizes[1] // 8))()
        rows.status = self._function("solve")(ctypes.byref(record), workspace)
        rows.done, rows.block = int(record.done), int(record.block)
        rows.reached = np.array(record.reached[:])
        return rows

    def _function(self, name: str, result: Any = ctypes.c_int) -> Any:
        assert self._library is not None
        function = self._library[f"kousoku_{self.name}_{name}"]
        function.restype = result
        return function


def load_scene(
    folder: str | Path, *, target: Literal["auto", "c", "numpy"] = "auto"
) -> LinkageSolver:
    """Load the folder that was generated from a scene.

    Parameters
    ----------
    folder : path
        As ``kousoku.codegen.linkage.generate.generate_scene`` made it.
    target : {"auto", "c", "numpy"}
        As of :func:`kousoku.runtime.load`.

    Raises
    ------
    LoadError
        It is not such a folder, or a file of it was edited.
    """
    folder = folder_of(folder)
    manifest = read_manifest(folder)
    return open_linkage(Sources(folder, manifest, read_files(folder, manifest)), target)


def is_linkage(files: Collection[str]) -> bool:
    """Whether files are those of the solver of a linkage, by their names."""
    is_scene = MOTION_FILE in files
    return is_scene and any(name.startswith(f"{LINKAGE_LIBRARY}/") for name in files)


def open_linkage(sources: Sources, target: Target) -> LinkageSolver:
    """Return the solver of files that were read.

    Raises
    ------
    LoadError
        They have no solver of a linkage, or are of two packages.
    """
    folder, manifest, files = sources.folder, sources.manifest, sources.files
    if not is_linkage(files):
        raise LoadError(
            f"{folder} is not made from a linkage of nodes: it has no {LINKAGE_LIBRARY}"
        )

    def in_c() -> LinkageSolver:
        from kousoku.runtime.toolchain import find_toolchain

        library, _ = compiled(manifest, files, find_toolchain())
        return LinkageSolver(sources, Solver(), library)

    def in_numpy(reason: Exception | None) -> LinkageSolver:
        if reason is not None:
            say_once(f"kousoku uses the NumPy solver: {reason}")
        module = import_source(folder, files, NUMPY_SOURCE)
        require_digest(folder, manifest, NUMPY_SOURCE, module.DIGEST)
        return LinkageSolver(sources, module.SOLVER)

    return choose(target, folder, files, (C_SOURCE, in_c), (NUMPY_SOURCE, in_numpy))


def _open_same(sources: Sources, target: Target) -> LinkageSolver:
    """Open the target that another process had; NumPy, and say so, where there is no compiler."""
    placed = Sources(sources.place(), sources.manifest, sources.files)
    return open_linkage(placed, target if target == "numpy" else "auto")


def solve(
    folder: str | Path, *, target: Literal["auto", "c", "numpy"] = "auto", **options: Any
) -> Trajectory:
    """Load a scene's folder and solve it; options as of :meth:`LinkageSolver.solve`."""
    return load_scene(folder, target=target).solve(**options)


def record_of(run: Run, rows: Rows) -> Any:
    """Return the record of ``solver.h`` that asks for a run and points at room for its rows."""
    record = _run_type(len(run.origin))()
    for field in RUN:
        value = getattr(run if hasattr(run, field.name) else rows, field.name)
        if field.is_pointer:
            has_room = value is not None and value.size
            setattr(record, field.name, value.ctypes.data if has_room else None)
        elif field.is_by_input:
            getattr(record, field.name)[:] = value
        else:
            setattr(record, field.name, value)
    return record


def _run_type(inputs: int) -> type[ctypes.Structure]:
    """Return the record of ``solver.h``."""

    class Record(ctypes.Structure):
        _fields_ = tuple(
            (one.name, _TYPES[one.type] * inputs if one.is_by_input else _type_of(one.type))
            for one in RUN
        )

    return Record


def _type_of(declared: str) -> Any:
    return _TYPES.get(declared, ctypes.c_void_p)
