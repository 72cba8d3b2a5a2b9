"""Solve a linkage with the package that was generated from its scene."""

from __future__ import annotations

import ctypes
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from kousoku.model.errors import LoadError, SolveError
from kousoku.model.files.manifest import LINKAGE_LIBRARY
from kousoku.runtime.dynamics_targets import NUMPY_SOURCE, exported, on_this_machine, open_either
from kousoku.runtime.kinematics.moving import Linkage
from kousoku.runtime.kinematics.rows import RUN, empty_rows
from kousoku.runtime.kinematics.solve import KinematicSolver
from kousoku.runtime.kinematics.trajectory import Trajectory
from kousoku.runtime.notice import say_once
from kousoku.runtime.options import ALL_OPTIONS
from kousoku.runtime.sources import Sources

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from pathlib import Path

    from kousoku.runtime.choice import ChosenTarget, Target
    from kousoku.runtime.dynamics import DynamicsSolver
    from kousoku.runtime.kinematics.rows import Rows, RunRequest
    from kousoku.runtime.kinematics.tables import Array, LinkageTables

__all__ = ["LinkageSolver", "Trajectory", "load_linkage"]

#: The types of numbers of ``solver.h``; all others point at numbers.
_TYPES: dict[str, Any] = {
    "int": ctypes.c_int,
    "double": ctypes.c_double,
    "long long": ctypes.c_longlong,
    "size_t": ctypes.c_size_t,
}


class CompiledLinkage(KinematicSolver):
    """The compiled solver of a linkage.

    Parameters
    ----------
    library : ctypes.CDLL
        The loaded library.
    sources : Sources
        Its sources.
    """

    name = "c"

    def __init__(self, library: ctypes.CDLL, sources: Sources) -> None:
        super().__init__()
        self._function = partial(exported, library, sources)
        self._package = sources.manifest.package
        self.segments = {
            name: partial(self._run, number) for number, name in enumerate(sources.data["segments"])
        }

    def solve(self, mechanism: LinkageTables, run: RunRequest) -> Rows:
        """Run the whole turn in one call of the compiled library."""
        rows = empty_rows(mechanism, run.rows)
        record = record_of(run, rows)
        sizes = [self._function(f"{name}_size", ctypes.c_size_t)() for name in ("run", "workspace")]
        if sizes[0] != ctypes.sizeof(record):
            raise LoadError(f"{self._package}: its run is not as in this version of kousoku")
        workspace = (ctypes.c_double * -(-sizes[1] // 8))()
        rows.status = self._function("solve")(ctypes.byref(record), workspace)
        rows.done, rows.block = int(record.done), int(record.block)
        rows.reached = np.array(record.reached[:])
        return rows

    def _run(self, segment: int, slots: Array) -> None:
        """Run a segment on the workspace."""
        address = slots.ctypes.data_as(ctypes.c_void_p)
        self._function("evaluate", None)(ctypes.c_size_t(segment), address)


class LinkageSolver(Linkage):
    """A loaded linkage.

    Parameters
    ----------
    target : KinematicSolver
        Target that computes: the compiled library, or the analysis of the folder.
    sources : Sources
        The generated files.
    """

    #: Parameters that a run may change: none.
    parameters: tuple[tuple[str, float], ...] = ()

    def __init__(self, target: KinematicSolver, sources: Sources) -> None:
        super().__init__(target, sources.data)
        self.sources = sources

    def __repr__(self) -> str:
        return f"<LinkageSolver {self.name}; in {self.target.name}>"

    def __reduce__(self) -> tuple[Any, ...]:
        return _open_same, (self.sources, self.target.name)

    @property
    def counts(self) -> tuple[tuple[int, str, str], ...]:
        """Counts of nodes, links and inputs: number, noun, and its plural."""
        mechanism, nouns = self.mechanism, ("node", "link", "input")
        numbers = map(len, (mechanism.nodes, mechanism.links, mechanism.inputs))
        return tuple((n, noun, f"{noun}s") for n, noun in zip(numbers, nouns, strict=True))

    def of_bodies(self, what: str) -> DynamicsSolver:
        """Refuse what bodies alone have.

        Raises
        ------
        SolveError
            Always: this is a linkage of nodes.
        """
        raise SolveError(
            f"{self.name}: {what}: of scenes of bodies; this one is a linkage of nodes, which"
            " solve() and simulate(end) move"
        )

    def in_time(
        self, *, progress: Callable[[float, float], object] | None = None, **options: Any
    ) -> Trajectory:
        """Motion in time, see :meth:`Linkage.simulate`; done at once, it tells no progress."""
        for name in options:
            if name in ALL_OPTIONS and name != "method":
                raise SolveError(
                    f"{self.name}: {name} is an option of scenes of bodies; this one is a linkage"
                    " of nodes, whose options are method and limit"
                )
        return self.simulate(**options)

    def along_inputs(
        self, times: Callable[[int | None], Sequence[float]], options: Mapping[str, Any]
    ) -> Trajectory:
        """Motion at the divisions of the inputs, which the folder knows; see :meth:`solve`."""
        if "parameters" in options:
            raise SolveError(f"{self.name}: a linkage has no parameters; build one in a loop")
        return self.solve(**options)

    def evaluate(self, segment: str, given: dict[str, Array]) -> dict[str, Array]:
        """Workspace after a segment, region by region.

        Parameters
        ----------
        segment : str
            As in the mechanism: ``position_1`` … ``nodes``.
        given : dict of str to (size,) array
            Values of regions before, lengths in the unit of the scene.

        Returns
        -------
        dict of str to (size,) array
            All regions.
        """
        mechanism = self.mechanism
        slots = np.zeros(mechanism.work_size)
        slices = {name: slice(base, base + n) for name, (base, n) in mechanism.regions.items()}
        for name, values in given.items():
            slots[slices[name]] = values
        mechanism.segments[segment](slots)
        return {name: slots[region] for name, region in slices.items()}


def load_linkage(folder: str | Path, *, target: Target = "auto") -> LinkageSolver:
    """Load the folder that was generated from a linkage of nodes.

    Parameters
    ----------
    folder : path
        As ``kousoku.codegen.linkage.generate.generate_linkage`` made it.
    target : {"auto", "c", "numpy"}
        As of :func:`kousoku.runtime.load`.

    Raises
    ------
    LoadError
        It is not such a folder, or a file of it was edited.
    """
    return open_linkage(Sources.read(folder), target)


def open_linkage(sources: Sources, target: Target) -> LinkageSolver:
    """Solver of files that were read.

    Raises
    ------
    LoadError
        They have no solver of a linkage, or are of two packages.
    """
    if not sources.is_linkage:
        raise LoadError(
            f"{sources.folder} is not made from a linkage of nodes: it has no {LINKAGE_LIBRARY}"
        )

    return LinkageSolver(open_either(sources, target, CompiledLinkage, _numpy), sources)


def _numpy(sources: Sources, reason: Exception | None) -> KinematicSolver:
    if reason is not None:
        say_once(f"kousoku uses the NumPy solver: {reason}")
    solver: KinematicSolver = sources.module(NUMPY_SOURCE).SOLVER
    return solver


def _open_same(sources: Sources, target: ChosenTarget) -> LinkageSolver:
    return open_linkage(*on_this_machine(sources, target))


def record_of(run: RunRequest, rows: Rows) -> Any:
    """Record of ``solver.h`` that asks for a run and points at the memory of its rows."""
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
    """Record of ``solver.h``."""

    class RunRecord(ctypes.Structure):
        _fields_ = tuple(
            (field.name, _TYPES[field.type] * inputs if field.is_by_input else _type_of(field.type))
            for field in RUN
        )

    return RunRecord


def _type_of(declared: str) -> Any:
    return _TYPES.get(declared, ctypes.c_void_p)
