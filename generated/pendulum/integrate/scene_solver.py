"""The solver of a scene in NumPy: the functions of ``solver.h``, with the same states and rows."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from .arithmetic import larger, smaller
from .continuation import continue_parameters, is_possible, stay_closed
from .dense_output import add_driven_rows, has_driven_works, prepare_dense
from .methods import METHODS
from .motion_scales import energy_balance, note_extent
from .pivot_monitor import branch_ratio, note_largest_pivot, pivot_ratio
from .poles import first_without_value
from .projection import note_lost_digits, project
from .row_switch import note_first_pivot_ratio
from .rows import find_reactions, write_row
from .run_arguments import LEAST_TOLERANCE
from .scene_tables import Work, Workspace, state_of
from .settings import ACTIONS, Status
from .stepper import first_step, step
from .switching import (
    change_by_rounding,
    even_end,
    meet_switches,
    note_steepness,
    resolved_step,
)

if TYPE_CHECKING:
    from .arithmetic import Array
    from .methods import RungeKuttaMethod
    from .scene_tables import SceneTables
    from .settings import Settings
    from .state import State

#: The segments of an evaluation, in order: before the forces of joints, and behind.
FOUND_FIRST = ("geometry", "position", "move", "velocity", "acceleration")
FOUND_LAST = ("coordinate", "energy", "momentum", "check", "measure")


class SceneSolver:
    """The solver of a scene; the caller owns states, workspaces and rows.

    Parameters
    ----------
    scene : SceneTables
        What moves.
    """

    def __init__(self, scene: SceneTables) -> None:
        self.scene = scene

    def start(
        self,
        time: float,
        q: Array,
        v: Array,
        parameters: Array | None,
        state: Array,
        workspace: Array,
    ) -> Status:
        """Take a position and velocity, and project them onto the constraints.

        Parameters
        ----------
        time : float [s]
            Where the motion begins.
        q, v : (nq,), (nv,) array
            Coordinates and velocities, in SI units.
        parameters : (n,) array or None
            None for those of the scene.
        state : (state_size,) array
            Where the run goes on from: written here, then by :meth:`run` alone.
        workspace : (work_size,) array
            Scratch.

        Returns
        -------
        Status
            ``GOOD``, ``NOT_ASSEMBLED``, ``NOT_CLOSED``, ``DEPENDENT``, ``NO_VALUE`` or
            ``BAD_ARGUMENT``.
        """
        state[:] = 0.0
        values = self.scene.parameters if parameters is None else parameters
        if not _are_numbers(time, q, v, values):
            return Status.BAD_ARGUMENT
        with np.errstate(all="ignore"):
            s, work = state_of(self.scene, state), Work(self.scene, workspace)
            s.parameters[:] = values
            work.w.prepare(s.parameters)
            if self.scene.has_design and not is_possible(work.w):
                return Status.BAD_ARGUMENT
            s.y[:] = np.concatenate((q, v))
            return self._start(time, s, work)

    def _start(self, time: float, s: State, work: Work) -> Status:
        s.key = -self.scene.key  # not started
        s.time = s.time_before = s.least_pivot_ratio_time = time
        s.error = 1e-4
        if self.scene.has_switches or self.scene.has_laws:
            s.limit = s.behind = time
        s.crossed[:] = -math.inf
        if work.row_switch is not None:
            note_first_pivot_ratio(work.row_switch, work, s)
        if self.scene.has_continuation and not continue_parameters(s, work):
            return Status.NOT_ASSEMBLED
        if project(time, 0.0, s.y, s.low, s.f, work, s) < 0.0:
            return Status.NOT_ASSEMBLED
        note_lost_digits(work, s)
        note_largest_pivot(work, s)
        s.least_pivot_ratio = pivot_ratio(work, s)
        s.position_ratio = s.usual_ratio = branch_ratio(work, s)
        s.largest_pivot_ratio = larger(s.largest_pivot_ratio, s.least_pivot_ratio)
        work.w.run("energy")
        s.energy = energy_balance(work.w.q, work, s)
        s.potential, s.moved = work.w.energies[1], work.w.energies[0]
        work.w.run("momentum")
        s.momenta[:] = work.w.momenta
        work.w.run("coordinate")
        s.lowest[:], s.highest[:] = math.inf, -math.inf
        note_extent(s.y, work, s)
        are_changed = bool((s.parameters != self.scene.parameters).any())
        if len(work.w.C_left_out) > 0 and are_changed and not stay_closed(s, work):
            return Status.NOT_CLOSED
        if len(self.scene.rank_rows) > 0 and are_changed:
            from .rank import keep_rank  # other scenes do not have it

            if not keep_rank(s, work):
                return Status.DEPENDENT
        s.event = float(first_without_value(s, work))
        if s.event > 0.0:
            return Status.NO_VALUE
        s.key = self.scene.key
        return Status.GOOD

    def run(
        self,
        settings: Settings,
        times: Array,
        max_steps: int,
        state: Array,
        workspace: Array,
        rows: Array,
    ) -> tuple[Status, int]:
        """Move on to the last of the times, and write a row for each of them.

        Returns early when rows are full, max_steps are made, or an event is told; a run that was
        stopped goes on from where it is, with the same bits.

        Parameters
        ----------
        settings : Settings
            Method and tolerance.
        times : (n,) array [s]
            Ascending, the same in each call.
        max_steps : int
            How many steps.
        state, workspace : (state_size,), (work_size,) array
            As :meth:`start` left them.
        rows : (n, row_size) array
            Where the rows go: time, q, v, parts.

        Returns
        -------
        status : Status
            ``GOOD``, ``BUFFER_FULL``, ``PAUSED``, ``EVENT``, ``STOPPED``, or why the motion cannot
            go on.
        n_rows : int
            How many rows were written.
        """
        s = state_of(self.scene, state)
        if s.key != self.scene.key or not _is_sound(s, len(times)):
            return Status.WRONG_STATE, 0
        if not self._are_possible(settings, s):
            return Status.BAD_ARGUMENT, 0
        with np.errstate(all="ignore"):
            work = Work(self.scene, workspace)
            work.w.prepare(s.parameters)
            return self._run(settings, times, max_steps, s, work, rows)

    def _are_possible(self, settings: Settings, s: State) -> bool:
        """Whether settings are possible, and the method is that with which the run began."""
        is_kinematic = self.scene.is_driven and settings.is_kinematic
        if not (LEAST_TOLERANCE <= settings.tolerance < 1.0 and settings.largest_step > 0.0):
            return False
        if not 0.0 <= settings.fixed_step <= settings.largest_step:
            return False
        if not math.isfinite(settings.fixed_step) or (is_kinematic and settings.fixed_step > 0.0):
            return False
        if not 0 <= settings.method < len(METHODS) + self.scene.is_driven:
            return False
        return s.method in {0.0, 1.0 + settings.method}

    def _run(
        self, settings: Settings, times: Array, max_steps: int, s: State, work: Work, rows: Array
    ) -> tuple[Status, int]:
        """Step and write in turn."""
        m = METHODS[settings.method % len(METHODS)]
        end = float(times[-1]) if len(times) else s.time
        n_rows = steps = 0
        while int(s.next_row) < len(times):
            t = float(times[int(s.next_row)])
            if not s.time_before <= t <= end < math.inf:
                return Status.BAD_ARGUMENT, n_rows
            if t <= s.time:
                if n_rows == len(rows):
                    return Status.BUFFER_FULL, n_rows
                status = write_row(m, settings, t, s, work, rows[n_rows])
                if status != Status.GOOD:
                    return status, n_rows
                n_rows += 1
                s.next_row += 1
            else:
                status = self._report_event(m, settings, s, work, rows[n_rows : n_rows + 1])
                if status != Status.GOOD:
                    return status, n_rows
                if steps == max_steps:
                    return Status.PAUSED, n_rows
                status = self._advance(m, settings, t, end, s, work)
                if status != Status.GOOD:
                    return status, n_rows
                steps += 1
        return Status.GOOD, n_rows

    def _report_event(
        self, m: RungeKuttaMethod, settings: Settings, s: State, work: Work, rows: Array
    ) -> Status:
        """Write the row of an event that is still to be told, behind those of times.

        Those that end the run are told last, and of these the first ends it.
        """
        fired = np.flatnonzero(s.fired).tolist()
        if not fired:
            return Status.GOOD
        if len(rows) == 0:
            return Status.BUFFER_FULL
        status = write_row(m, settings, s.time, s, work, rows[0])
        if status != Status.GOOD:
            return status
        is_stop = {k: ACTIONS[self.scene.events[k, 1]] == "stop" for k in fired}
        event = next((k for k in fired if not is_stop[k]), fired[-1])
        s.event = 1.0 + event
        if len(fired) == 1 and is_stop[event]:
            return Status.STOPPED
        s.fired[event] = 0.0
        return Status.EVENT

    def _advance(
        self,
        m: RungeKuttaMethod,
        settings: Settings,
        asked: float,
        end: float,
        s: State,
        work: Work,
    ) -> Status:
        """Make one step towards the time that is asked for."""
        status, target = Status.GOOD, end
        s.method = 1.0 + settings.method
        if self.scene.has_switches or self.scene.has_laws:
            status = meet_switches(end, s, work)
            if status != Status.GOOD or asked <= s.time:
                return status
            target = smaller(s.limit, end)
        if self.scene.is_driven and settings.is_kinematic:
            from .kinematics import driven_step  # other scenes do not have it

            h = settings.largest_step
            if s.step_size > 0.0:
                h = smaller(s.step_size, h)
            to = smaller(asked, target)
            return Status(
                driven_step(
                    settings, resolved_step(settings.tolerance, h, 0.5, to, s, work), s, work
                )
            )
        is_fixed = settings.fixed_step > 0.0
        if s.step_size == 0.0 and not is_fixed:
            status = first_step(m, settings, end, s, work)
        if status == Status.GOOD:
            h = settings.fixed_step if is_fixed else smaller(s.step_size, settings.largest_step)
            to = target if is_fixed else even_end(h, target, s)
            target = resolved_step(settings.tolerance, h, 1.0, to, s, work)
        start, has_narrow = s.time, self.scene.has_narrow
        if has_narrow and s.steps == 0.0:
            s.steepness = change_by_rounding(end, s, work)
        if status == Status.GOOD:
            status = step(m, settings, asked, target, s, work)
        if status != Status.GOOD:
            return status
        if asked < s.time:
            prepare_dense(m, work, s)
            if has_driven_works(m, self.scene):
                add_driven_rows(m, s, work)
        if has_narrow:
            note_steepness(start, end, s, work)
        return Status.GOOD

    def evaluate(
        self, time: float, q: Array, v: Array, parameters: Array | None, workspace: Array
    ) -> Status:
        """Compute all that the scene has at a state as it is, not projected.

        It is left in the workspace (work_size,): what is where stands in ``motion.json``. Arguments
        as of :meth:`start`, q (nq,) and v (nv,) in SI units, the time in [s].
        """
        values = self.scene.parameters if parameters is None else parameters
        if not _are_numbers(time, q, v, values):
            return Status.BAD_ARGUMENT
        work = Work(self.scene, workspace)
        w = work.w
        with np.errstate(all="ignore"):
            w.prepare(values)
            if self.scene.has_design and not is_possible(w):
                return Status.BAD_ARGUMENT
            w.place(time, np.concatenate((q, v)))
            w.dq[:] = 0.0  # where there are no rows no segment writes it
            for segment in FOUND_FIRST:
                w.run(segment)
            find_reactions(work, is_passed=False)
            for segment in FOUND_LAST:
                w.run(segment)
        return Status.GOOD

    def residuals(self, workspace: Array, left: Array) -> None:
        """Write C(q) to ``left`` (nc,) [m, rad] where it was evaluated last, in the workspace."""
        left[: self.scene.nc] = Workspace(self.scene, workspace).C

    def pivots(self, state: Array, workspace: Array, found: Array) -> Status:
        """Write D (nc,), C_q M⁻¹C_qᵀ = L D Lᵀ, at the state: small where rows are nearly dependent.

        All in 1/kg: those of angles are taken at the length of the scene.
        """
        s, w = state_of(self.scene, state), Workspace(self.scene, workspace)
        if abs(s.key) != self.scene.key:
            return Status.WRONG_STATE
        with np.errstate(all="ignore"):
            w.prepare(s.parameters)
            w.t[0] = s.time
            w.q[:] = s.y[: self.scene.nq]
            w.run("geometry")
            factors = self.scene.inverse_pivot_factors[: self.scene.nc]
            found[: self.scene.nc] = 1.0 / (w.pivots * factors)
        return Status.GOOD


def _is_sound(s: State, n_times: int) -> bool:
    """Whether a state is one that a run goes on from: none that was cut or damaged."""
    if not 0.0 <= s.next_row <= n_times or s.next_row != math.floor(s.next_row):
        return False
    if not s.time_before <= s.time or not math.isfinite(s.step_size):
        return False
    return _are_numbers(s.time_before, s.y, s.low, s.f, s.parameters) and math.isfinite(s.time)


def _are_numbers(time: float, *arrays: Array) -> bool:
    """Whether time and arrays are finite."""
    return math.isfinite(time) and all(np.isfinite(array).all() for array in arrays)
