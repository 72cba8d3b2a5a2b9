"""A run of a solver of bodies: it stops and goes on, and keeps what was computed."""

from __future__ import annotations

import sys
from contextlib import suppress
from dataclasses import replace
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np

from kousoku.model.errors import MotionError, SolveError
from kousoku.runtime.design import loops_that_open, not_closed, parameters_text, with_parameters
from kousoku.runtime.dynamics_targets import Memory
from kousoku.runtime.error_estimate import error_estimate, second_options, second_times
from kousoku.runtime.integrate.assembled_start import assembled_start
from kousoku.runtime.integrate.events import (
    EventLog,
    add_row,
    bends,
    infinite,
    without_direction,
    without_value,
)
from kousoku.runtime.integrate.initial_values import initial_of, parameters_of
from kousoku.runtime.integrate.motion import Motion
from kousoku.runtime.integrate.nearly_dependent import nearly_dependent
from kousoku.runtime.integrate.run_arguments import require_callable, require_numbers, require_room
from kousoku.runtime.integrate.settings import CLEARLY, KINEMATICS, MESSAGES, Status
from kousoku.runtime.messages import MOST_PARTS_SHOWN, listed
from kousoku.runtime.options import is_given_anew, require_unmoved, with_values
from kousoku.runtime.run_ledger import ledger_of
from kousoku.runtime.run_stop import joints_at_stop, joints_of_bodies
from kousoku.runtime.saved import SavedRun

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from kousoku.runtime.dynamics import DynamicsSolver
    from kousoku.runtime.error_estimate import ErrorEstimate
    from kousoku.runtime.integrate.arithmetic import Array
    from kousoku.runtime.integrate.start_evaluation import Evaluate
    from kousoku.runtime.options import Options

#: Message in place of that of ``NOT_PROJECTED``, where the step is fixed.
TOO_LONG = (
    "the constraints cannot be met inside of a step of {step:g} s, which is too long, or their rows"
    " are dependent; try a smaller step"
)
#: Part of the note on bodies without a degree of freedom.
STILL = "nothing can move"
#: Bodies are where they fit, though events may have no value there.
PLACED = (Status.GOOD, Status.NO_VALUE)
#: Statuses after which a run goes on.
GOES_ON = (Status.BUFFER_FULL, Status.PAUSED, Status.EVENT)
#: Statuses whose messages name joints already.
OF_PARAMETERS = (Status.NOT_CLOSED, Status.DEPENDENT)
#: Statuses with which an event returns.
EVENTS = (Status.EVENT, Status.STOPPED)
#: Message in place of that of ``STEP_TOO_SMALL``, where drivers determine the motion.
NO_FURTHER = (
    "no step can be taken: drivers lead no further, as at a dead centre, or the motion is not"
    " determined from here on"
)
#: Numbers of the state that are read often.
PLACES = ("time", "next_row", "steps", "event", "bent", "limit", "behind", "pole")
#: Rows of a call, and steps of the first one.
BUFFER, STEPS = 4096, 16
#: Between calls a run can be interrupted; they take about this long [s].
PULSE = 0.1


class Interrupted(KeyboardInterrupt):
    """The user stopped a run; ``result`` has what was computed, ``run`` can go on.

    It is a ``KeyboardInterrupt``: a script stops, unless it asks for it.
    """

    def __init__(self, run: Run) -> None:
        self.run = run
        self.result = run.motion()
        rows = f"{len(self.result)} row{'s' * (len(self.result) != 1)}"
        super().__init__(f"stopped at t = {run.time:.9g} s with {rows}")


class Run:
    """A run that can be stopped and go on: it owns the state, the workspace and the rows.

    Parameters
    ----------
    solver : DynamicsSolver
        Solver of the scene that moves.
    times : array [s]
        The times to write, ascending.
    options : Options
        Options of the run.
    saved : SavedRun, optional
        Go on from there; what :func:`kousoku.runtime.saved.checked_run` returned.
    """

    #: Mechanism that moves, where kousoku loaded it; results pass it on.
    mechanism: Any = None

    def __init__(
        self, solver: DynamicsSolver, times: Array, options: Options, saved: SavedRun | None = None
    ) -> None:
        self.solver = solver
        self.times = times
        self.options = options
        self.seconds = {"start": 0.0, "run": 0.0}
        self._status: int = Status.PAUSED
        self._error: ErrorEstimate | None = None
        self._goes_past_stops = False
        target = solver.target
        self._values = np.array([value for _, value in options.parameters], dtype=np.float64)
        self._there = with_parameters(solver, self._values)
        self._q, self._v = self._there.q.copy(), self._there.v.copy()
        self._rows = self._allocated()
        self._told = [] if saved is None else [*saved.events]
        self._is_shown, self._is_elsewhere = False, any(options.initial)
        self._is_as_given = is_given_anew(self._there, options.parameters)
        self.state = np.zeros(target.state_size) if saved is None else saved.state.copy()
        self._memory = Memory(self.state, np.zeros(target.work_size))
        self._begin = target.starter(0.0, self._q, self._v, self._values, self._memory)
        self._go = target.runner(options.settings(), times, self._memory)
        self._places = {name: solver.state[name].place for name in PLACES}
        self._pace = STEPS
        if saved is None:
            self._start()
        else:
            if self._is_as_given:
                with suppress(SolveError):  # for what it changes: it may have begun elsewhere
                    self._start()
                self.state[:] = saved.state
            if target.pivots(self._memory, self._scratch()) == Status.WRONG_STATE:
                raise SolveError(
                    f"{solver.name}: {MESSAGES[Status.WRONG_STATE]}, or is not started"
                )
            self._rows[: len(saved.rows)] = saved.rows

    def __repr__(self) -> str:
        rows = f"{self.written} of {len(self.times)} rows"
        return f"<Run of {self.solver.name}: at {self.time:.6g} s, {self.steps} steps, {rows}>"

    def __reduce__(self) -> tuple[Any, ...]:
        arguments = (self.solver, self.times, self.options, self.save())
        start = self._q, self._v, self._is_as_given, self._is_elsewhere, self.mechanism
        return type(self), arguments, start

    def __setstate__(self, start: tuple[Array, Array, bool, bool, Any]) -> None:
        self._q[:], self._v[:], self._is_as_given, self._is_elsewhere, self.mechanism = start

    def restart(
        self,
        parameters: Mapping[str, float | str] | None = None,
        *,
        initial: Mapping[str, float | str] | None = None,
        q0: Sequence[float] | Array | None = None,
        v0: Sequence[float] | Array | None = None,
    ) -> Run:
        """Start over at time 0 with the same times and options, in the same memory.

        It costs a few microseconds beyond the solver's own work: arguments are not looked up again.
        Results that were taken before stay as they are.

        Parameters
        ----------
        parameters : mapping of str to float or str, optional
            Those that are not as in the scene; as before unless given.
        initial, q0, v0 : optional
            Where to begin, as for :func:`kousoku.runtime.options.options_of`; as before unless
            one is given, or as the scene has it with new parameters.

        Raises
        ------
        SolveError
            A number is not possible, or the start is not.
        """
        parameters = parameters_of(parameters, q0)
        if parameters is not None:
            options = replace(self.options, parameters=with_values(self.solver, parameters))
            values = np.array([value for _, value in options.parameters])
            self._there, self.options = with_parameters(self.solver, values), options
            self._values[:] = values
        is_elsewhere = not (initial is None and q0 is None and v0 is None)
        if is_elsewhere:
            started = initial_of(self.solver.layout, initial, q0, v0)
            self.options = replace(self.options, initial=started)
        if parameters is not None or is_elsewhere:
            self._q[:], self._v[:] = self._there.q, self._there.v
            self._is_as_given = is_given_anew(self._there, self.options.parameters)
            self._is_elsewhere = any(self.options.initial)
        self._start_over()
        return self

    def _start_over(self) -> None:
        """Start from the current q and v, with no rows written."""
        if self._is_shown:
            self._rows, self._is_shown = self._allocated(), False
        self.seconds["run"] = 0.0
        self._status, self._error = Status.PAUSED, None
        self._told = []
        self._start()

    def _allocated(self) -> Array:
        """Array for all rows."""
        size = self.solver.target.row_size
        require_room(self.solver.name, len(self.times), size)
        try:
            return np.empty((len(self.times), size))
        except MemoryError:
            raise SolveError(
                f"{self.solver.name}: no room for {len(self.times)} rows of {size} numbers; ask"
                " for fewer times"
            ) from None

    def _start(self) -> None:
        begin = perf_counter()
        status = self._begin()
        y = self.solver.state["y"].view(self.state)
        if status in PLACED and self._is_as_given:
            self._q[:], self._v[:], layout, changes = assembled_start(
                self._there.layout, self._evaluate(), y, is_told=not self.options.initial.q0
            )
            moved = {change.body: change.sizes for change in changes}
            self._there = replace(self._there, layout=layout, moved=moved)
            if self.options.strict:
                require_unmoved(self._there)
            self._is_as_given = False
            status = self._begin()
        if status in PLACED and self._is_elsewhere:
            self._q[:], self._v[:] = self._with_initial_values(y)
            self._is_elsewhere = False  # to start over leads nowhere again
            status = self._begin()
        self.seconds["start"] = perf_counter() - begin
        if status == Status.NO_VALUE:
            raise SolveError(f"{self.solver.name}: {self._no_value('where the run starts')}")
        if status != Status.GOOD:
            joints = "" if status in OF_PARAMETERS else self._where(self._gaps(y))
            note = "" if status == Status.DEPENDENT else self._still()
            raise SolveError(f"{self.solver.name}: {self._unmet(status)}{joints}{note}")

    def _no_value(self, where: str) -> str:
        """Message: which event has no value."""
        return without_value(self.solver.layout, self.state.item(self._places["event"]), where)

    def _still(self) -> str:
        """Note on bodies without a degree of freedom, empty where there are none."""
        return "".join(f"; {note}" for note in self.solver.layout.notes if STILL in note)

    def _with_initial_values(self, y: Array) -> tuple[Array, Array]:
        """Initial q, v with the initial values of the options, from the start of the scene."""
        from kousoku.runtime.integrate.initial_poses import started

        placed = self._there
        return started(placed.layout, placed.checked, self._evaluate(), y, self.options.initial)

    def _evaluate(self) -> Evaluate:
        """Outputs of the scene at time 0, with the parameters of the run."""
        from kousoku.runtime.integrate.start_evaluation import evaluated

        target = self.solver.target
        return evaluated(target.evaluate, self._values, target.work_size, self._there.places)

    def _gaps(self, y: Array) -> Array:
        """Residuals of the rows where the start arrived, with the parameters of the run.

        On the way there others were tried, of which a small gap was left.
        """
        residuals = self._evaluate()(y[: len(self._q)], y[len(self._q) :])["C"]
        return residuals if np.isfinite(residuals).all() else self._residuals()

    def _unmet(self, status: int) -> str:
        """Message: why the start is not possible."""
        on_parameters = {Status.NOT_ASSEMBLED, *OF_PARAMETERS}
        if status not in on_parameters or not self.solver.parameters:
            return MESSAGES[status]
        values = parameters_text(self.solver, self._values)
        if status == Status.NOT_CLOSED:
            joints = loops_that_open(self.solver, self._values)
            joints = joints or not_closed(self.solver, self._memory.work, 1.0)
            return (
                f"with {values}: joints stay open, or come open by more than closure_tolerance for"
                f" each length or radian that bodies move: {joints}; only with the parameters of"
                " the scene their rows depend on those of other joints: give parameters that fit,"
                " or generate the solver with them"
            )
        if status == Status.DEPENDENT:
            tolerance, places = self.solver.layout.closure_tolerance, self.solver.places
            rows, work = self.solver.checked, self._memory.work
            return nearly_dependent(f"with {values}", rows, places, work, tolerance)
        if self.solver.design is None:
            return MESSAGES[status]
        return f"with {values}: {MESSAGES[status]}, or no way of closed joints leads there"

    def _scratch(self) -> Array:
        return np.zeros(len(self.solver.rows) + 1)

    def _residuals(self) -> Array:
        residuals = self._scratch()
        self.solver.target.residuals(self._memory, residuals)
        return residuals[:-1]

    @property
    def time(self) -> float:
        """The time reached [s]: rows up to it are written, or will be in the next call."""
        return self.state.item(self._places["time"])

    @property
    def written(self) -> int:
        """Number of rows that are written."""
        return int(self.state.item(self._places["next_row"]))

    @property
    def steps(self) -> int:
        """Number of steps that were made."""
        return int(self.state.item(self._places["steps"]))

    def advance(self, max_steps: int = STEPS, max_rows: int = BUFFER) -> int:
        """Go on for some steps and rows; return 0 at the end, else why it returned.

        However a run is cut into calls, its rows have the same bits.

        Returns
        -------
        int
            A `Status`: ``GOOD``, ``BUFFER_FULL``, ``PAUSED``, ``EVENT`` where an event was told,
            ``STOPPED`` where one ended the run, or a key of ``MESSAGES``.

        Raises
        ------
        SolveError
            A count is no whole number, or below 1.
        """
        counts = {"max_steps": max_steps, "max_rows": max_rows}
        require_numbers(self.solver.name, is_whole=True, least=1, **counts)
        return self._advance(min(max_steps, sys.maxsize), max_rows)

    def _advance(self, max_steps: int, max_rows: int) -> int:
        begin, first = perf_counter(), self.written
        self._status = self._go(max_steps, self._rows[first : first + max_rows])
        self.seconds["run"] += perf_counter() - begin
        if self._status in EVENTS:
            event = self.state.item(self._places["event"])
            add_row(self._told, event, self._rows[self.written])
        if self._status == Status.STOPPED and self._goes_past_stops:
            self.solver.state["fired"].view(self.state)[:] = 0.0
            self._status = Status.EVENT
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
        try:
            while self._advance(min(self._pace, self._steps_left()), BUFFER) in GOES_ON:
                if self._status == Status.PAUSED and self._steps_left() <= 0:
                    raise MotionError(self._too_many(), self.motion())
                pulse = self.seconds["run"] / max(self.steps, 1)
                self._pace = max(1, int(PULSE / pulse)) if pulse else STEPS
                if progress is not None:
                    progress(self.time, float(self.times[-1]))
        except KeyboardInterrupt:
            raise Interrupted(self) from None
        if self._status not in {Status.GOOD, Status.STOPPED}:
            raise MotionError(self._stop(), self.motion())
        if self.options.estimate_error and self._error is None:
            self._error = self._estimate(progress)
        return self.motion()

    def _estimate(self, progress: Callable[[float, float], object] | None) -> ErrorEstimate:
        """Error of all rows, from a second run by another method."""
        begin, first = perf_counter(), self.motion()
        times, options = second_times(first.time.copy(), self.options), second_options(self.options)
        again = Run(self.solver, times, options)
        again._goes_past_stops = True  # to where the first one ended, be its own a little before
        stop = ""
        try:
            second = again.finish(progress)
        except MotionError as error:
            second, stop = again.motion(), str(error)
        every = 2 if len(times) > len(first) else 1
        second = Motion(second.layout, second.rows[::every], target="", method=second.method)
        self.seconds["error"] = perf_counter() - begin
        return error_estimate(first, second, self.solver.length / self.solver.unit, stop)

    def _steps_left(self) -> int:
        return max(0, self.options.most_steps - self.steps)

    def _too_many(self) -> str:
        return (
            f"{self.solver.name}: at t = {self.time:.9g} s: {self.steps} steps are made and"
            f" t = {self.times[-1]:.9g} s is not reached; a larger tolerance makes longer steps,"
            f" most_steps allows more of them{self._jumps()}"
        )

    def _jumps(self) -> str:
        """Name the forces that jump: around a jump no step is short enough."""
        jumps = self.solver.layout.jumps
        if not jumps:
            return ""
        return (
            f"; the sign in {listed(jumps, MOST_PARTS_SHOWN)} jumps, and where what it is taken of"
            " stays near 0 steps become tiny: take x/sqrt(x^2 + 1e-6) instead of sign(x)"
        )

    def _poles(self) -> str:
        """Name the forces that may be infinite: near such a place no step is short enough."""
        poles = tuple(dict.fromkeys(self.solver.layout.poles))
        if not poles:
            return ""
        verb = "is" if len(poles) == 1 else "are"
        named = listed(poles, MOST_PARTS_SHOWN)
        return f"; {named} {verb} infinite where what it is divided by is 0"

    def _stop(self) -> str:
        if self._status == Status.NO_VALUE:
            return f"{self.solver.name}: at t = {self.time:.9g} s: {self._no_value('from here on')}"
        if self._status == Status.BENDS:
            bent = [self.state.item(self._places[name]) for name in ("bent", "limit", "behind")]
            why = bends(self.solver.layout, *bent)
            return f"{self.solver.name}: at t = {self.time:.9g} s: {why}"
        if self._status == Status.NO_DIRECTION:
            why = without_direction(self.solver.layout, self.state.item(self._places["bent"]))
            return f"{self.solver.name}: at t = {self.time:.9g} s: {why}"
        if self._status == Status.INFINITE:
            why = infinite(self.solver.layout, self.state.item(self._places["pole"]))
            return f"{self.solver.name}: at t = {self.time:.9g} s: {why}"
        if self._status == Status.NOT_CLOSED:
            joints = not_closed(self.solver, self._memory.work, CLEARLY)
            time = f"before t = {self.times[self.written]:.9g} s"
            return f"{self.solver.name}: {time}: {MESSAGES[self._status]}: {joints}"
        is_driven = self.options.method == KINEMATICS and self._status == Status.STEP_TOO_SMALL
        reason = NO_FURTHER if is_driven else MESSAGES[self._status]
        if self.options.step is not None and self._status == Status.NOT_PROJECTED:
            reason = TOO_LONG.format(step=self.options.step)
        details = self._where(self._residuals()) + self._still() + self._poles()
        return f"{self.solver.name}: at t = {self.time:.9g} s: {reason}{details}"

    def _where(self, residuals: Array) -> str:
        """Name the joints that are open, and those whose rows are dependent."""
        pivots = self._scratch()
        if self.solver.target.pivots(self._memory, pivots) != Status.GOOD:
            return ""
        text = joints_at_stop(self.solver.rows, residuals, pivots[:-1])
        return text + joints_of_bodies(
            self.solver.rows, self.solver.satisfied, is_driven=self.options.method == KINEMATICS
        )

    def motion(self) -> Motion:
        """Motion that was computed so far."""
        rows = self._rows[: self.written]
        is_complete = len(rows) == len(self.times)
        if self._status == Status.STOPPED:  # the state there stands at the end
            rows = np.vstack((rows, self._told[-1][1:]))
        rows.flags.writeable = False
        self._is_shown = True  # its rows are not written over
        options, state, seconds = self.options, self.state.copy(), dict(self.seconds)
        solver = replace(self.solver, moved=self._there.moved)
        error, events = self._error, tuple(self._told)
        motion = Motion(
            self._there.layout,
            rows,
            target=solver.target.name,
            method=options.method,
            ledger=lambda: ledger_of(solver, state, options, seconds, error),
            parameters=dict(options.parameters),
            is_complete=is_complete,
            told=lambda: EventLog(
                tuple(map(int, solver.state["counts"].view(state))), self._events(events)
            ),
        )
        motion.mechanism = self.mechanism
        return motion

    def _events(self, rows: Sequence[Array]) -> Array:
        """Rows of events, as of :class:`EventLog`."""
        return np.array(rows).reshape(-1, 1 + self.solver.target.row_size)

    def save(self) -> SavedRun:
        """Saved run: all that is needed to go on, as it is now."""
        rows = self._rows[: self.written].copy()
        events = self._events(self._told)
        return SavedRun(self.options, self.times, self.state.copy(), rows, events).sealed()
