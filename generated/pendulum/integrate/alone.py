"""Runs of a generated folder where kousoku is not installed, with NumPy and nothing else."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..messages import StoppedError, unknown
from .assembled_start import assembled_start
from .events import (
    EventLog,
    add_row,
    bends,
    infinite,
    without_direction,
    without_value,
)
from .initial_values import initial_of, parameters_of
from .methods import METHODS
from .motion import Layout, Motion
from .run_arguments import require_options, require_steps, times_of, values_of
from .scene_tables import state_of
from .settings import KINEMATICS, MESSAGES, MOST_STEPS, OPTIONS, Settings, Status, method_for
from .state import fields
from .trust import CheckedRows, trust_of

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from .arithmetic import Array
    from .initial_values import InitialValues
    from .scene_solver import SceneSolver
    from .start_evaluation import Evaluate


class Alone:
    """The scene of a folder: its functions are those of a solver of kousoku.

    Parameters
    ----------
    solver : SceneSolver
        The solver of the folder.
    data : mapping
        What its ``motion.json`` holds.
    """

    def __init__(self, solver: SceneSolver, data: Mapping[str, Any]) -> None:
        self.solver = solver
        self.data = data
        self.layout = Layout.from_data(data)

    def simulate(
        self, end: float | None = None, *, times: Any = None, samples: int = 1001, **options: Any
    ) -> Motion:
        """Move the scene from time 0: to an end with some samples, or to the last of the times.

        Raises
        ------
        StoppedError
            The motion cannot go on; an ``ArithmeticError`` with what was computed as ``result``.
        ValueError
            An option is not possible.
        TypeError
            There is no such option.
        """
        require_options(self.layout.name, options, OPTIONS, "end", "times", "samples")
        if end is None and times is None:
            end = self.layout.duration
        size = self.solver.scene.row_size
        chosen = times_of(self.layout.name, end, times, samples, size)
        return RunAlone(self, chosen, **options).finish()

    def begin(self, times: Sequence[float] | Array, **options: Any) -> RunAlone:
        """Run at time 0 that can be stopped and go on, with ascending times (n,) [s] to write."""
        require_options(self.layout.name, options, OPTIONS, "times")
        return RunAlone(self, times_of(self.layout.name, None, times, 0), **options)


class RunAlone:
    """A run that can be stopped and go on.

    Parameters
    ----------
    scene : Alone
        The scene.
    times : (n,) array [s]
        The times to write, ascending.
    tolerance, method, step, largest_step, checks, most_steps, parameters, initial, q0, v0
        As of ``kousoku.runtime.options.options_of``.
    """

    def __init__(
        self,
        scene: Alone,
        times: Array,
        *,
        tolerance: float = 1e-9,
        method: str | None = None,
        step: float | None = None,
        largest_step: float = np.inf,
        checks: bool = True,
        most_steps: int = MOST_STEPS,
        parameters: Mapping[str, float | str] | None = None,
        initial: Mapping[str, float | str] | None = None,
        q0: Sequence[float] | Array | None = None,
        v0: Sequence[float] | Array | None = None,
    ) -> None:
        self._scene, self.times, self.most_steps = scene, times, most_steps
        name, solver = scene.layout.name, scene.solver
        values = values_of(name, dict(scene.data["parameters"]), parameters_of(parameters, q0))
        require_steps(name, tolerance, step, largest_step, most_steps)
        initial_values = initial_of(scene.layout, initial, q0, v0)
        methods = [*(tableau.name for tableau in METHODS), *[KINEMATICS] * solver.scene.is_driven]
        chosen = method or method_for(tolerance, is_driven=solver.scene.is_driven)
        if chosen not in methods:
            raise ValueError(f"{name}: {unknown('method', chosen, methods)}")
        self.method, longest = chosen, min(largest_step, 1e300)
        number = methods.index(chosen)
        self._settings = Settings(tolerance, longest, step or 0.0, int(checks), number)
        self.state, self._work = np.zeros(solver.scene.state_size), np.zeros(solver.scene.work_size)
        self._rows, self._layout = np.empty((len(times), solver.scene.row_size)), scene.layout
        self._parameters = values
        self._event_rows: list[Array] = []
        start = np.array([*scene.data["q"], *scene.data["v"]], float)
        nq, numbers = solver.scene.nq, np.array(list(values.values()), float)
        if solver.scene.has_design:
            if solver.evaluate(0.0, start[:nq], start[nq:], numbers, self._work) != Status.GOOD:
                raise ValueError(
                    f"{name}: parameters {values}: wanted such that masses, moments and lengths are"
                    " positive, and no moment is larger than the two others together"
                )
            design = scene.data["design"]
            base, size = design["place"]
            design_values = self._work[base : base + size].copy()
            for slot, index in design["start"]:
                start[slot] = design_values[index]
            self._layout = scene.layout.at(design_values)
        status = solver.start(0.0, start[:nq], start[nq:], numbers, self.state, self._work)
        is_assembled_anew = bool(self._layout.given) and (numbers != solver.scene.parameters).any()
        has_initial = any(initial_values)
        self._require(status, may_lack_values=is_assembled_anew or has_initial)
        if is_assembled_anew:
            y = state_of(solver.scene, self.state).y
            q, v, self._layout, _ = assembled_start(
                self._layout, self._evaluate(numbers), y, is_told=not initial_values.q0
            )
            status = solver.start(0.0, q, v, numbers, self.state, self._work)
            self._require(status, may_lack_values=has_initial)
        if has_initial:
            led_start = self._initial_start(initial_values, numbers)
            self._require(solver.start(0.0, *led_start, numbers, self.state, self._work))

    def __repr__(self) -> str:
        state = state_of(self._scene.solver.scene, self.state)
        rows = f"{int(state.next_row)} of {len(self.times)} rows"
        at = f"at {self.time:.6g} s, {int(state.steps)} steps"
        return f"<Run of {self._scene.layout.name}: {at}, {rows}>"

    def _initial_start(self, initial: InitialValues, parameters: Array) -> tuple[Array, Array]:
        """Coordinates q and velocities v with initial values, given the start of the scene."""
        from .initial_poses import started

        data, scene = self._scene.data, self._scene.solver.scene
        rows = [tuple(row) for part in ("rows", "left_out", "satisfied") for row in data[part]]
        y = state_of(scene, self.state).y.copy()
        return started(self._layout, rows, self._evaluate(parameters), y, initial)

    def _evaluate(self, parameters: Array) -> Evaluate:
        """Evaluation of the scene at time 0, with the parameters of the run."""
        from .start_evaluation import evaluated

        solver, places = self._scene.solver, self._scene.data["places"]
        return evaluated(solver.evaluate, parameters, solver.scene.work_size, places)

    @property
    def time(self) -> float:
        """The time reached [s]."""
        return float(state_of(self._scene.solver.scene, self.state).time)

    def advance(self, max_steps: int = 16) -> int:
        """Go on for some steps; return 0 at the end, else why it returned, as in ``settings``."""
        solver, state = self._scene.solver, state_of(self._scene.solver.scene, self.state)
        last = state.steps + max_steps
        while True:
            rows, remaining = self._rows[int(state.next_row) :], int(last - state.steps)
            status, written = solver.run(
                self._settings, self.times, remaining, self.state, self._work, rows
            )
            if status in {Status.EVENT, Status.STOPPED}:
                add_row(self._event_rows, state.event, rows[written])
            if status != Status.EVENT:
                return status

    def finish(self) -> Motion:
        """Go on to the last time.

        Raises
        ------
        StoppedError
            The motion cannot go on.
        """
        made = int(state_of(self._scene.solver.scene, self.state).steps)
        status = self.advance(max(0, self.most_steps - made))
        if status not in {Status.GOOD, Status.STOPPED}:
            raise StoppedError(self._why(status), self.motion())
        return self.motion()

    def motion(self) -> Motion:
        """Motion as far as it was computed."""
        written = int(state_of(self._scene.solver.scene, self.state).next_row)
        data, scene = self._scene.data, self._scene.solver.scene
        checked = ([tuple(row) for row in data[part]] for part in CheckedRows._fields)
        trust = trust_of(
            {field.name: field.view(self.state) for field in fields(scene.state_sizes)},
            CheckedRows(*checked),
            self._layout,
            self._settings,
            has_masses=data["has_masses"],
            is_driven=data["is_driven"],
        )
        rows, is_complete = self._rows[:written], written == len(self.times)
        counts = state_of(scene, self.state).counts.tolist()
        events = np.array(self._event_rows).reshape(-1, 1 + rows.shape[1])
        if len(events) and self._layout.events[int(events[-1, 0])][1] == "stop":
            rows = np.vstack((rows, events[-1:, 1:]))
        return Motion(
            self._layout,
            rows,
            target="numpy",
            method=self.method,
            parameters=self._parameters,
            is_complete=is_complete,
            trust=trust,
            told=EventLog(tuple(map(int, counts)), events),
        )

    def _require(self, status: int, *, may_lack_values: bool = False) -> None:
        """Require that a run has started, or stands where initial values lead it away from."""
        if status == Status.NO_VALUE and may_lack_values:
            return
        if status != Status.GOOD:
            raise ArithmeticError(self._why(status))

    def _why(self, status: int) -> str:
        state = state_of(self._scene.solver.scene, self.state)
        if status == Status.BENDS:
            why = bends(self._layout, state.bent, state.limit, state.behind)
            return f"{self._scene.layout.name}: {why}, at t = {self.time:.9g} s"
        if status == Status.NO_DIRECTION:
            why = without_direction(self._layout, state.bent)
            return f"{self._scene.layout.name}: {why}, at t = {self.time:.9g} s"
        if status == Status.DEPENDENT:
            from .nearly_dependent import nearly_dependent  # other scenes do not have it

            data, layout = self._scene.data, self._layout
            rows = [row for part in CheckedRows._fields for row in data[part]]
            message: str = nearly_dependent(
                layout.name, rows, data["places"], self._work, layout.closure_tolerance
            )
            return message
        if status == Status.INFINITE:
            why = infinite(self._layout, state.pole)
            return f"{self._scene.layout.name}: {why}, at t = {self.time:.9g} s"
        if status == Status.NO_VALUE:
            where = (
                f"at t = {self.time:.9g} s" if state.key < 0.0 else f"behind t = {self.time:.9g} s"
            )
            return f"{self._scene.layout.name}: {without_value(self._layout, state.event, where)}"
        return f"{self._scene.layout.name}: {MESSAGES[status]}, at t = {self.time:.9g} s"
