"""A run of a solver of bodies: it stops and goes on, and keeps what was computed."""

from __future__ import annotations

import sys
import time
from dataclasses import replace
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from kousoku.model.errors import MotionError, SolveError
from kousoku.runtime.design import require_closed, told, with_parameters
from kousoku.runtime.dynamics_targets import Memory
from kousoku.runtime.given import require_callable, require_numbers, require_room
from kousoku.runtime.integrate.settings import (
    BAD_ARGUMENT,
    BUFFER_FULL,
    GOOD,
    NOT_ASSEMBLED,
    NOT_PROJECTED,
    PAUSED,
    STEP_TOO_SMALL,
    WRONG_STATE,
)
from kousoku.runtime.motion import motion_of
from kousoku.runtime.options import KINEMATICS
from kousoku.runtime.run_ledger import ledger_of
from kousoku.runtime.run_stop import joints_at_stop, joints_of_bodies
from kousoku.runtime.saved import SavedRun

if TYPE_CHECKING:
    from collections.abc import Callable

    import numpy.typing as npt

    from kousoku.runtime.dynamics import DynamicsSolver
    from kousoku.runtime.motion import Motion
    from kousoku.runtime.options import Options

    Array = npt.NDArray[np.float64]

MESSAGES = {
    STEP_TOO_SMALL: "no step can be taken: from here on the motion is not determined, it is too"
    " fast, or the tolerance is too tight for doubles",
    NOT_PROJECTED: "the constraints cannot be met inside of a step, as where their rows are"
    " dependent; steps of other lengths may pass such a place",
    NOT_ASSEMBLED: "the start cannot be brought onto the constraints, or they do not determine the"
    " motion there, or a formula of a force has no finite value there",
    BAD_ARGUMENT: "a number is not finite, or an argument is out of range",
    WRONG_STATE: "the state belongs to another solver, or was damaged",
}
#: Instead of the first of them, where drivers determine the motion.
NO_FURTHER = (
    "no step can be taken: drivers lead no further, as at a dead centre, or the motion is not"
    " determined from here on"
)
#: Rows of a call, and steps of the first one.
BUFFER, STEPS = 4096, 16
#: Between calls a run can be interrupted; they take about this long [s].
PULSE = 0.1


class Interrupted(KeyboardInterrupt):
    """The user stopped a run; ``motion`` has what was computed, ``run`` can go on.

    It is a ``KeyboardInterrupt``: a script stops, unless it asks for it.
    """

    def __init__(self, run: Run) -> None:
        self.run = run
        self.motion = run.motion()
        super().__init__(f"stopped at t = {run.time:.9g} s with {len(self.motion)} rows")


class Run:
    """A run that can be stopped and go on: it owns the state, the workspace and the rows.

    Parameters
    ----------
    solver : DynamicsSolver
        What moves.
    times : array [s]
        The times to write, ascending.
    options : Options
        How.
    saved : SavedRun, optional
        Go on from there; what :func:`kousoku.runtime.saved.checked` returned.
    """

    def __init__(
        self, solver: DynamicsSolver, times: Array, options: Options, saved: SavedRun | None = None
    ) -> None:
        self.solver = solver
        self.times = times
        self.options = options
        self._values = np.array([value for _, value in options.parameters], dtype=np.float64)
        self._there = with_parameters(solver, self._values)
        self.seconds = {"start": 0.0, "run": 0.0}
        self._status = PAUSED
        target = solver.target
        require_room(solver.name, len(times), target.row_size)
        try:
            self._rows = np.empty((len(times), target.row_size))
        except MemoryError:
            raise SolveError(
                f"{solver.name}: no room for {len(times)} rows of {target.row_size} numbers; ask"
                " for fewer times"
            ) from None
        self.state = np.zeros(target.state_size) if saved is None else saved.state.copy()
        self._memory = Memory(self.state, np.zeros(target.work_size))
        if saved is None:
            self._start()
        else:
            if target.pivots(self._memory, self._scratch()) == WRONG_STATE:
                raise SolveError(f"{solver.name}: {MESSAGES[WRONG_STATE]}, or is not started")
            self._rows[: len(saved.rows)] = saved.rows

    def _start(self) -> None:
        begin = time.perf_counter()
        given = (self._there.q, self._there.v, self._values)
        status = self.solver.target.start(0.0, *given, self._memory)
        self.seconds["start"] = time.perf_counter() - begin
        if status != GOOD:
            raise SolveError(f"{self.solver.name}: {self._unmet(status)}{self._where()}")
        require_closed(self.solver, self._values, self.solver.state["y"].view(self.state))

    def _unmet(self, status: int) -> str:
        """Say why the start is not possible."""
        if status != NOT_ASSEMBLED or self.solver.design is None:
            return MESSAGES[status]
        given = told(self.solver, self._values)
        return f"with {given}: {MESSAGES[status]}, or no way of closed joints leads there"

    def _scratch(self) -> Array:
        return np.zeros(len(self.solver.rows) + 1)

    def _residuals(self) -> Array:
        residuals = self._scratch()
        self.solver.target.residuals(self._memory, residuals)
        return residuals[:-1]

    @property
    def time(self) -> float:
        """The time reached [s]: rows up to it are written, or will be in the next call."""
        return self._number("time")

    @property
    def written(self) -> int:
        """How many rows are written."""
        return int(self._number("next_row"))

    @property
    def steps(self) -> int:
        """How many steps were made."""
        return int(self._number("steps"))

    def _number(self, name: str) -> float:
        """Return a number of the state."""
        return float(self.solver.state[name].view(self.state))

    def advance(self, max_steps: int = STEPS, max_rows: int = BUFFER) -> int:
        """Go on for some steps and rows; return 0 at the end, else why it returned.

        However a run is cut into calls, its rows have the same bits.

        Returns
        -------
        int
            ``GOOD``, ``BUFFER_FULL``, ``PAUSED``, or a key of ``MESSAGES``.

        Raises
        ------
        SolveError
            A count is no whole number, or below 1.
        """
        counts = {"max_steps": max_steps, "max_rows": max_rows}
        require_numbers(self.solver.name, is_whole=True, least=1, **counts)
        begin = time.perf_counter()
        settings = self.options.settings()
        place = self._rows[self.written :]
        self._status = self.solver.target.run(
            settings, self.times, min(max_steps, sys.maxsize), self._memory, place[:max_rows]
        )
        self.seconds["run"] += time.perf_counter() - begin
        return self._status

    def finish(self, progress: Callable[[float, float], object] | None = None) -> Motion:
        """Go on to the last time.

        Parameters
        ----------
        progress : callable, optional
            Called now and then with the time reached and the last time.

        Raises
        ------
        MotionError
            The motion cannot go on; the error has what was computed.
        Interrupted
            The user stopped it; so has the interrupt.
        """
        require_callable(self.solver.name, progress)
        steps = STEPS
        try:
            while self.advance(min(steps, self._steps_left())) in (BUFFER_FULL, PAUSED):
                if self._steps_left() <= 0:
                    raise MotionError(self._too_many(), self.motion())
                pulse = self.seconds["run"] / max(self.steps, 1)
                steps = max(1, int(PULSE / pulse)) if pulse else STEPS
                if progress is not None:
                    progress(self.time, float(self.times[-1]))
        except KeyboardInterrupt:
            raise Interrupted(self) from None
        if self._status != GOOD:
            raise MotionError(self._stop(), self.motion())
        return self.motion()

    def _steps_left(self) -> int:
        return max(0, self.options.most_steps - self.steps)

    def _too_many(self) -> str:
        return (
            f"{self.solver.name}: at t = {self.time:.9g} s: {self.steps} steps are made and"
            f" t = {self.times[-1]:.9g} s is not reached; a larger tolerance makes longer steps,"
            " most_steps allows more of them"
        )

    def _stop(self) -> str:
        is_driven = self.options.method == KINEMATICS and self._status == STEP_TOO_SMALL
        reason = NO_FURTHER if is_driven else MESSAGES[self._status]
        return f"{self.solver.name}: at t = {self.time:.9g} s: {reason}{self._where()}"

    def _where(self) -> str:
        """Name the joints that are open, and those whose rows are dependent."""
        residuals, pivots = self._residuals(), self._scratch()
        if self.solver.target.pivots(self._memory, pivots) != GOOD:
            return ""
        text = joints_at_stop(self.solver.rows, residuals, pivots[:-1])
        return text + joints_of_bodies(
            self.solver.rows, self.solver.reduced, is_driven=self.options.method == KINEMATICS
        )

    def motion(self) -> Motion:
        """Return what was computed so far."""
        begin = time.perf_counter()
        solver = self.solver
        ledger = ledger_of(
            {name: field.view(self.state) for name, field in solver.state.items()},
            solver.rows,
            self.options,
            {},
            solver.works,
            left_out=solver.left_out,
            reduced=solver.reduced,
            order=solver.checked,
            kept=solver.kept,
            length=solver.length,
            is_weighed=solver.is_weighed,
        )
        is_complete = self.written == len(self.times)
        rows = self._rows[: self.written]
        motion = motion_of(self._there, rows, ledger, is_complete=is_complete)
        seconds = self.seconds | {"tables": time.perf_counter() - begin}
        return replace(motion, ledger=replace(ledger, seconds=MappingProxyType(seconds)))

    def save(self) -> SavedRun:
        """Return all that is needed to go on, as it is now."""
        rows = self._rows[: self.written].copy()
        return SavedRun(self.options, self.times, self.state.copy(), rows)
