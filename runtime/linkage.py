"""Solve a linkage with the package that was generated from its scene."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from kousoku.model.errors import AssemblyError, LoadError, MotionError, SolveError
from kousoku.runtime.importing import import_source
from kousoku.runtime.integrate.given import require_numbers, require_options, times_of
from kousoku.runtime.integrate.result import shown
from kousoku.runtime.kinematics.rows import empty_rows
from kousoku.runtime.kinematics.status import Status
from kousoku.runtime.kinematics.trajectory import Trajectory, trajectory_of
from kousoku.runtime.library import Library, load, read_files

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence
    from pathlib import Path
    from types import ModuleType

    import numpy.typing as npt

    from kousoku.runtime.kinematics.mechanism import Mechanism
    from kousoku.runtime.kinematics.rows import Rows, Run

__all__ = ["LinkageSolver", "Trajectory", "load_scene", "solve"]

SOLVER = "solver.py"
#: Room for the results, in the order of the fields of ``kernels.h``.
RESULTS = ("alpha", "position", "velocity", "acceleration")
ANGLES = ("angle", "angle_dot", "angle_ddot")
#: Options of a call that are counts, and all of them.
COUNTS = ("divisions", "turns", "first_turn", "from_turn")
OPTIONS = ("method", *COUNTS, "limit")
#: What to do where a linkage cannot be moved on.
ADVICE = {
    Status.DEAD_CENTRE: "shorten the way of the input, or drive another link",
    Status.LIMIT_TOO_SMALL: "give a larger residual limit",
    Status.NOT_FINITE: "check lengths, positions and inputs",
    Status.TOO_FAR: "ask for more rows between",
}
#: Divisions that are counted without rounding.
MOST_ROWS = 2**53


@dataclass(frozen=True, slots=True)
class LinkageSolver:
    """A loaded scene.

    Parameters
    ----------
    library : Library
        The kernels, and in C the solver.
    module : module
        The folder's ``solver.py``: the mechanism, and its analysis in NumPy.
    """

    library: Library
    module: ModuleType

    def __reduce__(self) -> tuple[Any, ...]:
        return solver_of, (self.library,)

    @property
    def mechanism(self) -> Mechanism:
        """Nodes, links, inputs, unknowns and blocks."""
        mechanism: Mechanism = self.module.MECHANISM
        return mechanism

    @property
    def target(self) -> str:
        """What computes, ``c`` or ``numpy``."""
        return self.library.target

    def solve(self, **options: Any) -> Trajectory:
        """Return the motion of the scene.

        Parameters
        ----------
        method : {"newton", "paper"}, optional
            Full Newton, or the iteration of the paper, (27) and (28); as in the scene by default.
        divisions : int, optional
            Divisions of a turn; as in the scene by default.
        turns : int
            How many turns to write, one by default: ``turns * divisions + 1`` rows.
        first_turn : int
            The first turn that is written, counted from 0.
        from_turn : int, optional
            The turn at whose start the linkage is as in the scene, 0 by default: whole turns need
            not lead back, and all from there on are made.
        limit : float, optional
            Largest residual, in the unit of the scene.

        Raises
        ------
        AssemblyError
            The linkage does not fit together near the positions of the scene.
        MotionError
            It cannot be moved on; the error has the trajectory up to there.
        SolveError
            An option is not possible, or a residual limit is below rounding.
        """
        return self._moved(options)

    def simulate(
        self,
        end: float | None = None,
        *,
        times: Sequence[float] | npt.NDArray[np.float64] | None = None,
        samples: int = 1001,
        method: Literal["newton", "paper"] | None = None,
        limit: float | None = None,
    ) -> Trajectory:
        """Return the motion in time, with all inputs at from + rate t + ½ acceleration t².

        Where :meth:`solve` keeps the divisions and one rate at all of them, here the rates grow
        with the accelerations, and inputs go on by their laws until the end, also beyond ``to``
        and ``turns``. Between times they go at most a division of the scene in one step, and halt
        where they turn back, so that no dead centre on the way is passed over.

        Parameters
        ----------
        end : float [s]
            The last time; ``samples`` times from 0 on are written, equally far apart.
        times : sequence of float [s], optional
            The times to write, ascending, instead of ``end`` and ``samples``.
        samples : int
            How many times.
        method, limit
            As of :meth:`solve`.

        Raises
        ------
        AssemblyError, MotionError, SolveError
            As of :meth:`solve`.
        """
        chosen = times_of(self.library.manifest.package, end, times, samples)
        return self._moved({"method": method, "limit": limit}, chosen)

    def _moved(
        self, options: dict[str, Any], times: npt.NDArray[np.float64] | None = None
    ) -> Trajectory:
        run, rows = self._rows(options, times)
        good = self._trajectory(run, rows)
        if rows.status != Status.GOOD:
            raise self._error(run, rows, good)
        return good

    def request(self, **options: Any) -> Run:
        """Return the run that options ask for, those of :meth:`solve`.

        Raises
        ------
        ValueError, TypeError
            They are not such options.
        """
        run: Run = self.module.request(**options)
        return run

    def rows(self, run: Run) -> Rows:
        """Return what :meth:`solve` starts from, for a run."""
        if self.target == "c":
            return self._run_c(run)
        rows: Rows = self.module.solve(self.library, run)
        return rows

    def _rows(
        self, options: dict[str, Any], times: npt.NDArray[np.float64] | None
    ) -> tuple[Run, Rows]:
        self._check(options)
        try:
            run = self.request(**options)
        except (ValueError, TypeError) as error:
            raise SolveError(f"{self.library.manifest.package}: {error}") from None
        if times is not None:
            run = replace(run, times=times, rows=len(times))
        try:
            if run.first + run.rows > MOST_ROWS:
                raise MemoryError
            return run, self.rows(run)
        except MemoryError:
            raise SolveError(
                f"{self.library.manifest.package}: no room for {shown(run.rows)} rows from division"
                f" {shown(run.first)} on; ask for fewer turns or divisions"
            ) from None

    def _check(self, options: Mapping[str, Any]) -> None:
        """Refuse options that there are not, or that are no numbers where these are wanted."""
        name = self.library.manifest.package
        require_options(name, options, OPTIONS)
        counts = {key: options[key] for key in COUNTS if options.get(key) is not None}
        require_numbers(name, is_whole=True, **counts)
        if options.get("limit") is not None:
            require_numbers(name, limit=options["limit"])

    def _run_c(self, run: Run) -> Rows:
        """Run the whole turn in one call of the compiled library."""
        prefix = f"kousoku_{self.library.manifest.package}"
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

    def _trajectory(self, run: Run, rows: Rows) -> Trajectory:
        """Return the good rows."""
        name = self.library.manifest.package
        return trajectory_of(self.mechanism, run, rows, name=name, target=self.target)

    def _error(self, run: Run, rows: Rows, good: Trajectory) -> SolveError:
        """Say what went wrong, where, and what to do."""
        mechanism, name = self.mechanism, self.library.manifest.package
        block, status = mechanism.blocks[rows.block], Status(rows.status)
        unknowns = mechanism.unknowns[block.unknowns]
        nodes = ", ".join(dict.fromkeys(unknown.name.partition(".")[0] for unknown in unknowns))
        held = f"{nodes}, held by {', '.join(block.links)}"
        known = {link.name for link in mechanism.links}
        named = [f"links.{link}" for link in block.links if link in known]
        keys = ", ".join(named)
        driven = ", ".join(f"inputs.{given.name}" for given in mechanism.inputs)
        where = ", ".join(
            f"{given.name} = {value:.9g} {given.unit}"
            for given, value in zip(mechanism.inputs, rows.reached, strict=True)
        )
        why = status.message
        if status == Status.NOT_ASSEMBLED:
            misfit = self._misfit(rows.position[0], block.links)
            return AssemblyError(f"{name}: {keys}: {why}: {held}, at {where}: {misfit}", named)
        if status in {Status.ON_DEAD_CENTRE, Status.OTHER_SIDE}:
            return AssemblyError(
                f"{name}: {keys}: {why}: {held}, at {where}; move the positions of these nodes to"
                " the side that is wanted",
                named,
            )
        advice = ADVICE.get(status, "check the options")
        return MotionError(
            f"{name}: {driven}: {why}: {held}, at {where}, after {rows.done} good positions of"
            f" {run.rows}; {advice}",
            good,
        )

    def _misfit(self, position: npt.NDArray[np.float64], links: Iterable[str]) -> str:
        """Say by how much links are violated where the assembly stopped."""
        mechanism, parts = self.mechanism, []
        place = dict(zip(mechanism.nodes, position, strict=True))
        for name, first, second, length in mechanism.links:
            gap = float(np.hypot(*(place[second] - place[first]))) - length
            if name in links and abs(gap) > 1e-9 * mechanism.length:
                parts.append(
                    f"{name} would have to be {abs(gap):.6g} {mechanism.unit}"
                    f" {'longer' if gap > 0 else 'shorter'} to reach from {first} to {second}"
                )
        fits = "no link is violated much, but they cannot all be met"
        return f"{', '.join(parts) or fits}; change lengths or positions"


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
