"""The solver of a scene of bodies in NumPy: called as the compiled one, with its loop in Python."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

from kousoku.runtime.dynamics_targets import numpy_module, open_same
from kousoku.runtime.notice import say_once

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.runtime.dynamics_targets import Memory
    from kousoku.runtime.integrate.arithmetic import Array
    from kousoku.runtime.integrate.scene_solver import SceneSolver
    from kousoku.runtime.integrate.settings import Settings
    from kousoku.runtime.sources import Sources

#: Scenes with more coordinates than three bodies have are slow.
SLOW = 21


class NumpySolver:
    """What ``solver.py`` has, with the methods of :class:`CompiledSolver`.

    Parameters
    ----------
    solver : SceneSolver
        That of the imported ``solver.py``, with the integrator of its folder.
    """

    name = "numpy"

    def __init__(self, solver: SceneSolver, sources: Sources) -> None:
        self.solver = solver
        self.sources = sources
        self.state_size = solver.scene.state_size
        self.work_size = solver.scene.work_size
        self.row_size = solver.scene.row_size

    def __reduce__(self) -> tuple[Any, ...]:
        return open_same, (self.sources, self.name)

    def starter(
        self, time: float, q: Array, v: Array, parameters: Array, memory: Memory
    ) -> Callable[[], int]:
        """Start of a run: takes a position and velocity, and projects them onto the constraints."""
        return partial(self.solver.start, time, q, v, parameters, memory.state, memory.work)

    def runner(
        self, settings: Settings, times: Array, memory: Memory
    ) -> Callable[[int, Array], int]:
        """Runner: moves on by at most some steps, and writes as many rows as there are."""
        return lambda max_steps, rows: self.run(settings, times, max_steps, memory, rows)

    def run(
        self, settings: Settings, times: Array, max_steps: int, memory: Memory, rows: Array
    ) -> int:
        """Move on, and write rows.

        An interrupt can come anywhere: what the call had done is undone then, so that the state
        is one from which a run goes on.
        """
        before = memory.state.copy()
        given = (settings, times, max_steps, memory.state, memory.work, rows)
        try:
            status, _ = self.solver.run(*given)
        except BaseException:
            memory.state[:] = before
            raise
        return int(status)

    def evaluate(self, time: float, q: Array, v: Array, parameters: Array, work: Array) -> int:
        """Compute all that the scene has at a state as it is; it is left in the work."""
        return int(self.solver.evaluate(time, q, v, parameters, work))

    def residuals(self, memory: Memory, found: Array) -> None:
        """Write what is left of the constraints where they were evaluated last."""
        self.solver.residuals(memory.work, found)

    def pivots(self, memory: Memory, found: Array) -> int:
        """Write the pivots of the factors at the state."""
        return int(self.solver.pivots(memory.state, memory.work, found))


def load_numpy(sources: Sources, reason: Exception | None = None) -> NumpySolver:
    """Load the solver in NumPy, and say in one line what that means.

    Parameters
    ----------
    sources : Sources
        The files of the scene's folder.
    reason : Exception, optional
        Why there is no compiled solver.

    Raises
    ------
    LoadError
        The module is not the manifest's.
    """
    solver: SceneSolver = numpy_module(sources).SOLVER
    is_slow = solver.scene.nq > SLOW
    if reason is not None:
        cost = ", which takes 100 to 200 times as long" if is_slow else ""
        say_once(f"kousoku uses the NumPy solver{cost}: {reason}")
    elif is_slow:
        say_once(
            f"{sources.folder.name}: the NumPy solver takes 100 to 200 times as long as the"
            " compiled one"
        )
    return NumpySolver(solver, sources)
