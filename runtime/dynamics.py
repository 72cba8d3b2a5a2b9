"""Move a scene of bodies with the package that was generated from it."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from kousoku.model.errors import LoadError, SolveError
from kousoku.runtime.library import read_files, read_manifest
from kousoku.runtime.motion import BodyPlaces, ReactionPlaces
from kousoku.runtime.run import METHODS, Options, Run, SavedRun

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from typing import Literal

    import numpy.typing as npt

    from kousoku.runtime.dynamics_targets import SolverTarget
    from kousoku.runtime.motion import Motion

    Array = npt.NDArray[np.float64]

#: What a scene's folder tells about its bodies.
MOTION_FILE = "motion.json"
#: A run that needs more steps is stopped, unless it is told otherwise.
MOST_STEPS = 1_000_000


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
    target : SolverTarget
        What computes.
    rows : tuple of (str, str)
        Joint of each constraint, and the unit of its residual: m or rad.
    parts : tuple of (str, int)
        What a row has beyond time, q and v, and how many numbers.
    reactions : tuple of ReactionPlaces
        Where the forces of joints stand.
    is_flat : bool
        Whether all lies in one plane, so that no force leads out of it.
    works : tuple of (str, int)
        Forces and drivers that do work that is no potential energy, and where it stands in q.
    """

    name: str
    unit: float
    bodies: tuple[BodyPlaces, ...]
    q: Array
    v: Array
    target: SolverTarget
    rows: tuple[tuple[str, str], ...]
    parts: tuple[tuple[str, int], ...]
    reactions: tuple[ReactionPlaces, ...]
    is_flat: bool
    works: tuple[tuple[str, int], ...]

    def simulate(
        self,
        end: float | None = None,
        *,
        times: Sequence[float] | Array | None = None,
        samples: int = 1001,
        progress: Callable[[float, float], object] | None = None,
        **options: Any,
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
        progress : callable, optional
            Called now and then with the time reached and the last time.
        **options
            As in :meth:`begin`.

        Raises
        ------
        MotionError
            The motion cannot go on; the error has what was computed.
        SolveError
            An option is not possible, or the start is not.
        Interrupted
            The user pressed Ctrl-C; the exception has what was computed.
        """
        return self.begin(self._times(end, times, samples), **options).finish(progress)

    def begin(
        self,
        times: Sequence[float] | Array,
        *,
        tolerance: float = 1e-9,
        method: str | None = None,
        largest_step: float = np.inf,
        checks: bool = True,
        most_steps: int = MOST_STEPS,
    ) -> Run:
        """Return a run at time 0 that can be stopped and go on.

        Parameters
        ----------
        times : sequence of float [s]
            The times to write, ascending.
        tolerance : float
            Local error of a step, relative to a length of the scene and to the state.
        method : {"dopri5", "dop853"}, optional
            Of order 5 or 8; by the tolerance unless given.
        largest_step : float [s]
            No step is longer.
        checks : bool
            Whether the ledger says what is left of the constraints, and how the energy changes.
        most_steps : int
            A run that needs more is stopped.

        Raises
        ------
        SolveError
            An option is not possible, or the start is not.
        """
        name = method_for(tolerance) if method is None else method
        if name not in METHODS:
            raise SolveError(f"{self.name}: method {name!r}; wanted one of {', '.join(METHODS)}")
        if not (1e-15 <= tolerance < 1.0 and largest_step > 0.0 and most_steps > 0):
            raise SolveError(
                f"{self.name}: tolerance {tolerance!r}, largest step {largest_step!r}, at most"
                f" {most_steps!r} steps; wanted a tolerance from 1e-15 to 1 and the others above 0"
            )
        chosen = self._times(None, times, 0)
        return Run(self, chosen, Options(tolerance, largest_step, checks, name, most_steps))

    def resume(self, saved: SavedRun) -> Run:
        """Return a run that goes on where another one was saved, with the same bits.

        Raises
        ------
        SolveError
            It belongs to another solver.
        """
        return Run(self, saved.times, saved.options, saved)

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


def load_dynamics(
    folder: str | Path, *, target: Literal["auto", "c", "numpy"] = "auto"
) -> DynamicsSolver:
    """Load the folder that was generated from a scene of bodies.

    Parameters
    ----------
    folder : path
        A folder that the generator wrote.
    target : {"auto", "c", "numpy"}
        ``"auto"`` takes C where a compiler and a cache can be had, and else NumPy after saying why
        in one line on the logger ``kousoku``.

    Raises
    ------
    LoadError
        It is not such a folder, or a file of it was edited.
    CompilerError
        The compiler refuses the source; with ``target="c"`` also if there is none.
    CacheError
        With ``target="c"``: the library cannot be kept.
    """
    from kousoku.runtime.dynamics_targets import open_solver

    folder = Path(folder).absolute()
    manifest = read_manifest(folder)
    files = read_files(folder, manifest)
    if MOTION_FILE not in files:
        raise LoadError(f"{folder} is not made from a scene of bodies: it has no {MOTION_FILE}")
    data = json.loads(files[MOTION_FILE])
    return DynamicsSolver(
        name=manifest.package,
        unit=data["unit"],
        bodies=tuple(map(BodyPlaces.from_data, data["bodies"])),
        q=np.array(data["q"], dtype=np.float64),
        v=np.array(data["v"], dtype=np.float64),
        target=open_solver(folder, manifest, files, target),
        rows=tuple((joint, unit) for joint, unit in data["rows"]),
        parts=tuple((part, size) for part, size in data["parts"]),
        reactions=tuple(map(ReactionPlaces.from_data, data["reactions"])),
        is_flat=data["is_flat"],
        works=tuple((name, place) for name, place in data["works"]),
    )
