"""Move a scene of bodies with the package that was generated from it."""

from __future__ import annotations

import ctypes
import json
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from kousoku.model.errors import LoadError, MotionError, SolveError
from kousoku.runtime.library import read_files, read_manifest
from kousoku.runtime.motion import BodyPlaces, Motion, RunLedger, by_body

if TYPE_CHECKING:
    from collections.abc import Sequence

    import numpy.typing as npt

    Array = npt.NDArray[np.float64]

#: What a scene's folder tells about its bodies.
MOTION_FILE = "motion.json"
METHODS = ("dopri5", "dop853")
#: The numbers at the start of the state, in the order of the solver's text; counts follow.
STATE = ("time", "next step", "error", "next row", "time before")
GOOD, BUFFER_FULL, PAUSED = 0, 1, 2
MESSAGES = {
    -1: "no step can be taken: from here on the motion is not determined, or too fast",
    -2: "the constraints cannot be met between two steps",
    -3: "the start cannot be brought onto the constraints",
    -4: "an argument is out of range",
}
#: Rows of a call: between calls a run can be interrupted.
BUFFER = 4096
#: Steps of a call.
STEPS = 1000


class Settings(ctypes.Structure):
    """The record of ``solver.h``."""

    _fields_ = (
        ("tolerance", ctypes.c_double),
        ("largest_step", ctypes.c_double),
        ("method", ctypes.c_int),
    )


def method_for(tolerance: float) -> str:
    """Return the method that costs least for a tolerance."""
    return "dopri5" if tolerance > 1e-5 else "dop853"


@dataclass(frozen=True, slots=True)
class DynamicsSolver:
    """A loaded scene of bodies.

    Parameters
    ----------
    name : str
        The scene.
    unit : float [m]
        Its unit of length.
    bodies : tuple of BodyPlaces
        In the order of the scene.
    q, v : array
        Coordinates and velocities at the start.
    library : ctypes.CDLL
        The compiled solver.
    """

    name: str
    unit: float
    bodies: tuple[BodyPlaces, ...]
    q: Array
    v: Array
    library: ctypes.CDLL

    def simulate(
        self,
        end: float | None = None,
        *,
        times: Sequence[float] | Array | None = None,
        samples: int = 1001,
        tolerance: float = 1e-9,
        method: str | None = None,
        largest_step: float = np.inf,
    ) -> Motion:
        """Integrate the motion from time 0.

        Parameters
        ----------
        end : float [s]
            The last time; ``samples`` times from 0 on are written, equally far apart.
        times : sequence of float [s], optional
            The times to write, ascending, instead of ``end`` and ``samples``.
        samples : int
            How many times.
        tolerance : float
            Local error of a step, relative to a length of the scene and to the state.
        method : {"dopri5", "dop853"}, optional
            Of order 5 or 8; by the tolerance unless given.
        largest_step : float [s]
            No step is longer.

        Raises
        ------
        MotionError
            The motion cannot go on; the error has what was computed.
        SolveError
            An option is not possible.
        """
        chosen = self._times(end, times, samples)
        name = method_for(tolerance) if method is None else method
        if name not in METHODS:
            raise SolveError(f"{self.name}: method {name!r}; wanted one of {', '.join(METHODS)}")
        if not (1e-15 <= tolerance < 1.0 and largest_step > 0.0):
            raise SolveError(
                f"{self.name}: tolerance {tolerance!r}, largest step {largest_step!r}; wanted a"
                " tolerance from 1e-15 to 1 and a step above 0"
            )
        settings = Settings(tolerance, min(largest_step, 1e300), METHODS.index(name))
        return Run(self, chosen, settings).finish()

    def _times(self, end: float | None, times: Any, samples: int) -> Array:
        if (end is None) == (times is None):
            raise SolveError(f"{self.name}: give either end or times")
        if times is None:
            if end is None or not (0.0 < end < np.inf and samples >= 2):
                raise SolveError(
                    f"{self.name}: end {end!r} with {samples} samples; wanted an end above 0 and"
                    " 2 samples or more"
                )
            return np.linspace(0.0, end, samples)
        chosen = np.ascontiguousarray(times, dtype=np.float64)
        is_good = chosen.ndim == 1 and chosen.size and bool(np.isfinite(chosen).all())
        if not is_good or chosen[0] < 0.0 or bool((np.diff(chosen) < 0.0).any()):
            raise SolveError(f"{self.name}: times must ascend from 0 or later, one row of numbers")
        return chosen


class Run:
    """A run that can be stopped and go on: it owns the state, the workspace and the rows."""

    def __init__(self, solver: DynamicsSolver, times: Array, settings: Settings) -> None:
        self.solver = solver
        self.times = times
        self.settings = settings
        self._state = np.zeros(self._size("state"))
        self._work = np.zeros(self._size("work"))
        self._width = self._size("row")
        self._rows: list[Array] = []
        start = self._function("start")
        status = start(ctypes.c_double(0.0), *map(_address, (solver.q, solver.v)), *self._memory())
        if status != GOOD:
            raise SolveError(f"{solver.name}: {MESSAGES[status]}")

    def _function(self, name: str) -> Any:
        function = self.solver.library[f"kousoku_{self.solver.name}_{name}"]
        function.restype = ctypes.c_int
        return function

    def _size(self, name: str) -> int:
        function = self.solver.library[f"kousoku_{self.solver.name}_{name}_size"]
        function.restype = ctypes.c_size_t
        return int(function())

    def _memory(self) -> tuple[ctypes.c_void_p, ctypes.c_void_p]:
        return _address(self._state), _address(self._work)

    def advance(self, max_steps: int = STEPS, max_rows: int = BUFFER) -> int:
        """Go on for some steps and rows; return 0 at the end, else why it returned.

        Returns
        -------
        int
            ``GOOD``, ``BUFFER_FULL``, ``PAUSED``, or a key of ``MESSAGES``.
        """
        rows = np.empty((max_rows, self._width))
        written = ctypes.c_size_t()
        status: int = self._function("run")(
            ctypes.byref(self.settings),
            _address(self.times),
            *map(ctypes.c_size_t, (len(self.times), max_steps, max_rows)),
            *self._memory(),
            _address(rows),
            ctypes.byref(written),
        )
        self._rows.append(rows[: written.value].copy())
        return status

    def finish(self) -> Motion:
        """Go on to the last time.

        Raises
        ------
        MotionError
            The motion cannot go on; the error has what was computed.
        """
        while (status := self.advance()) in (BUFFER_FULL, PAUSED):
            pass
        motion = self.motion()
        if status != GOOD:
            where = f"at t = {self._state[0]:.9g} s"
            raise MotionError(f"{self.solver.name}: {where}: {MESSAGES[status]}", motion)
        return motion

    def motion(self) -> Motion:
        """Return what was computed so far."""
        rows = np.concatenate(self._rows) if self._rows else np.empty((0, self._width))
        n = len(self.solver.q)
        tables = by_body(self.solver.bodies, rows[:, 1 : 1 + n], rows[:, 1 + n :], self.solver.unit)
        steps, rejected, derivatives, factorisations, drift = self._state[len(STATE) :][:5]
        ledger = RunLedger(
            method=METHODS[self.settings.method],
            tolerance=self.settings.tolerance,
            steps=int(steps),
            rejected=int(rejected),
            derivatives=int(derivatives),
            factorisations=int(factorisations),
            drift=float(drift),
        )
        return Motion(self.solver.name, rows[:, 0], *tables, ledger, "c")


def _address(array: Array) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)


def load_dynamics(folder: str | Path) -> DynamicsSolver:
    """Load the folder that was generated from a scene of bodies.

    Raises
    ------
    LoadError
        It is not such a folder, or a file of it was edited.
    CompilerError
        There is no compiler, or it refuses the source.
    """
    from kousoku.runtime.build import Source, build
    from kousoku.runtime.targets import open_library
    from kousoku.runtime.toolchain import find_toolchain

    folder = Path(folder).absolute()
    manifest = read_manifest(folder)
    files = read_files(folder, manifest)
    if MOTION_FILE not in files:
        raise LoadError(f"{folder} is not made from a scene of bodies: it has no {MOTION_FILE}")
    data = json.loads(files[MOTION_FILE])
    sources = tuple(item for item in files.items() if item[0].endswith((".c", ".h")))
    built = build(Source(manifest.package, sources), find_toolchain())
    return DynamicsSolver(
        name=manifest.package,
        unit=data["unit"],
        bodies=tuple(map(BodyPlaces.from_data, data["bodies"])),
        q=np.array(data["q"], dtype=np.float64),
        v=np.array(data["v"], dtype=np.float64),
        library=open_library(built.path, manifest),
    )
