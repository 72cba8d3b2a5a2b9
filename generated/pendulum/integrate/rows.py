"""The rows that are written, at steps and between them, and what the ledger of a run notes."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from .arithmetic import larger
from .dense_output import add_driven_works, differentiate, has_driven_works, interpolate
from .motion_scales import energy_balance, energy_moved
from .pivot_monitor import VAGUE_PIVOT_RATIO, WEAK_PIVOT_RATIO, pivot_ratio
from .projection import accelerate, project, ratio_at
from .row_switch import find_geometry, forget_trials, least_norm_reactions, take_multipliers
from .settings import CLEARLY, Status

if TYPE_CHECKING:
    from .arithmetic import Array
    from .methods import RungeKuttaMethod
    from .scene_tables import SceneTables, Work
    from .settings import Settings
    from .state import State


def are_closed(misses: Array, times: float, scene: SceneTables) -> bool:
    """Whether misses (n,) [m, rad] of rows are at most so many times the closure tolerance.

    Rows that are left out miss by some of it; where these took over, so do the rows that were kept.
    """
    return bool((np.abs(misses) <= times * scene.closure_tolerance * scene.row_lengths).all())


def note_checks(work: Work, state: State) -> None:
    """Note residuals of the constraints, and changes of energy and of momenta."""
    w = work.w
    w.run("check")
    for worst, residuals in zip(state.violations, (w.all_C, w.C_dot, w.C_ddot), strict=True):
        np.fmax(worst, np.abs(residuals), out=worst)
    state.energy_error = larger(state.energy_error, abs(energy_balance(work.w.q, work, state)))
    state.energy_moved = larger(state.energy_moved, energy_moved(work.w.q, work, state))
    w.run("momentum")
    changes = np.abs(w.momenta - state.momenta)
    np.fmax(state.momentum_errors, changes, out=state.momentum_errors)


def interpolate_position(
    m: RungeKuttaMethod, t: float, x: float, y: Array, work: Work, state: State
) -> bool:
    """Put the interpolated state at t [s] into the workspace; return whether rows are dependent.

    x [-] is the part of the step, y (ny,) gets the state. Dependent rows determine neither a
    projection nor the accelerations.
    """
    interpolate(m, x, state, y)
    nq = work.scene.nq
    work.w.t[0] = t
    work.w.v[:] = y[nq:]
    ratio = ratio_at(y[:nq], work, state)
    y[:nq] = work.w.q
    return ratio < WEAK_PIVOT_RATIO * state.largest_pivot_ratio


def interpolate_accelerations(
    m: RungeKuttaMethod, t: float, x: float, h: float, work: Work, state: State
) -> None:
    """Take the accelerations of a row from the polynomial; the forces of joints are unknown."""
    work.w.v_dot[:] = differentiate(m, x, h, state)[work.scene.nq :]
    work.w.lam[:] = math.nan
    state.passed += 1
    state.passed_time = t


def note_not_finite(row: Array, state: State) -> None:
    """Note that a row (row_size,) has numbers that are not finite, and when [s] the first is."""
    if bool(np.isfinite(row).all()):
        return
    if state.not_finite == 0.0:
        state.not_finite_time = float(row[0])
    state.not_finite += 1


def find_reactions(work: Work, *, is_passed: bool) -> None:
    """Find the forces and torques of joints, those of least norm where rows are dependent.

    Scenes with many dependent rows share them out here, others in their own code.
    """
    rows, shares_out = work.row_switch, work.scene.shares_out
    if rows is None or not (shares_out or ("reactions" in work.scene.parts and rows.is_active)):
        work.w.run("reaction")
    elif is_passed and shares_out:
        work.w.all_lam[:] = math.nan
        work.w.run("wrench")
    elif is_passed:
        work.w.run("reaction")
    else:
        if not rows.is_active:
            take_multipliers(rows, work)
        least_norm_reactions(rows, work)


def write_row(
    m: RungeKuttaMethod, s: Settings, t: float, state: State, work: Work, row: Array
) -> Status:
    """Write the state at a time t [s] of the last step, projected onto the constraints.

    ``row`` (row_size,) gets time, q, v and the parts of the scene, in SI units.
    """
    scene, w, y = work.scene, work.w, work.k[0]
    forget_trials(work)
    h, is_passed = state.time - state.time_before, False
    if t == state.time or h == 0.0:
        y[:] = state.y
        w.place(t, y)
        if scene.accelerates or s.checks:
            find_geometry(work, state)
    else:
        x = (t - state.time_before) / h
        interpolate(m, x, state, y)
        if has_driven_works(m, scene) and not s.is_kinematic:
            add_driven_works(x, scene, state, y)
        part = WEAK_PIVOT_RATIO if s.is_kinematic else VAGUE_PIVOT_RATIO
        vague = part * state.largest_pivot_ratio
        drift = project(t, 0.0, y, None, None, work, state)
        is_projected = drift >= 0.0
        is_passed = not is_projected or pivot_ratio(work, state) < vague
        if is_passed and not interpolate_position(m, t, x, y, work, state) and not is_projected:
            return Status.NOT_PROJECTED
        if is_passed:
            interpolate_accelerations(m, t, x, h, work, state)
        else:
            state.row_drift = larger(state.row_drift, drift)
    if (scene.accelerates or s.checks) and not is_passed:
        accelerate(work, state)
    if "energies" in scene.parts or s.checks:
        w.run("energy")
    if s.checks:
        note_checks(work, state)
    watches = s.checks and len(w.C_left_out) > 0
    if watches and not is_passed and not are_closed(w.all_C, CLEARLY, scene):
        return Status.NOT_CLOSED
    find_reactions(work, is_passed=is_passed)
    w.run("coordinate")
    regions = [scene.regions.get(part, (0, 0)) for part in scene.parts]
    row[0] = t
    row[1 : 1 + scene.ny] = y
    row[1 + scene.ny :] = np.concatenate(
        [np.empty(0), *(w.slots[base : base + size] for base, size in regions)]
    )
    if not is_passed:
        note_not_finite(row, state)
    return Status.GOOD
