"""Projection onto the constraints, by Newton's method, and the accelerations there."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from .arithmetic import larger, rounding_of_sum
from .pivot_monitor import blur_of, pivot_ratio
from .row_switch import accelerate_all_rows, drive, find_geometry, refine_all_rows, solve_rows

if TYPE_CHECKING:
    from .arithmetic import Array
    from .scene_tables import SceneTables, Work
    from .state import State

#: A correction this small, relative to a length of the scene, is rounding.
ROUNDING_CORRECTION = 4e-16
#: Newton squares a correction this small away.
QUADRATIC_CORRECTION = 1e-9
#: At a pivot ratio this much smaller than the largest so far accelerations are refined.
REFINED_PIVOT_RATIO = 1e-4
#: So are they all along where the first of them are wrong by more than this part.
MOST_ACCELERATION_ERROR = 2e-12
#: The same of any accelerations, which are larger along directions in which nothing acts.
MOST_TEST_ERROR = 2e-11
#: Where a run begins with more than this part of that much, more may be lost on the way: there they
#: are looked at where steps end.
WATCHED_ERROR_PART = 2e-2
LOOKED_AT = 0.5
#: Corrections in Newton's method, and steps of refinement.
MOST_CORRECTIONS = 20
MOST_REFINEMENTS = 4


def correct_position(work: Work) -> None:
    """Find the correction dq = −M⁻¹C_qᵀ (C_q M⁻¹C_qᵀ)⁻¹ C (nv,) [m, rad] of q."""
    if work.row_switch is not None and work.row_switch.is_active:
        solve_rows(work.w.all_C, work.row_switch, work, work.w.dq)
    else:
        work.w.run("position")


def correct_velocity(work: Work) -> None:
    """Find the correction dv = −M⁻¹C_qᵀ (C_q M⁻¹C_qᵀ)⁻¹ (C_q v − ν) (nv,) [m/s, rad/s] of v."""
    if work.row_switch is not None and work.row_switch.is_active:
        work.w.run("check")
        solve_rows(work.w.C_dot, work.row_switch, work, work.w.dv)
    else:
        work.w.run("velocity")


def refine(work: Work) -> None:
    """Refine accelerations with the factors in the workspace until corrections are rounding.

    v̇ − M⁻¹C_qᵀ (C_q M⁻¹C_qᵀ)⁻¹ (C_q v̇ − γ), again and again.
    """
    w, before = work.w, math.inf
    for _ in range(MOST_REFINEMENTS):
        w.run("refinement")
        size = w.size_of(w.dv)
        if not size < 0.5 * before:
            return
        w.v_dot += w.dv
        w.lam += w.more_lam
        w.q_dot[work.scene.nq - len(w.more_power) :] += w.more_power
        if size <= ROUNDING_CORRECTION * w.size_of(w.v_dot):
            return
        before = size


def lost_part(work: Work) -> float:
    """Relative error [-] of accelerations in the workspace: their correction onto C_q v̇ = γ."""
    w = work.w
    w.run("refinement")
    return float(np.divide(w.size_of(w.dv), w.size_of(w.v_dot)))


def begin_refining(f: Array, work: Work, state: State) -> None:
    """Have accelerations refined all along from here on, and those in the workspace.

    Their derivative ẏ = (q̇, v̇) goes to f (ny,).
    """
    state.is_refined = 1.0
    accelerate(work, state)
    f[: work.scene.nq] = work.w.q_dot
    f[work.scene.nq :] = work.w.v_dot


def note_lost_digits(work: Work, state: State) -> None:
    """Note whether accelerations lose digits where a run begins, as between very unequal masses.

    Then they are refined all along, or where few are lost looked at where steps end. Pivots tell of
    digits that are lost in addition. At rest, or without a load, nothing is lost yet: so any
    accelerations are brought onto the rows, too.
    """
    if not work.scene.has_refinement or (work.row_switch is not None and work.row_switch.is_active):
        return
    w, nq = work.w, work.scene.nq
    lost = lost_part(work) / MOST_ACCELERATION_ERROR
    if not lost > 1.0:
        w.v_dot[:] = (np.arange(len(w.v_dot)) * 5 % 7 - 3) * work.scene.lengths
        w.run("refinement")
        w.v_dot += w.dv
        lost = larger(lost, lost_part(work) / MOST_TEST_ERROR)
        w.v_dot[:] = state.f[nq:]
    state.is_refined = LOOKED_AT if lost > WATCHED_ERROR_PART else 0.0
    if lost > 1.0:
        begin_refining(state.f, work, state)


def check_digits(f: Array, work: Work, state: State) -> None:
    """Check accelerations in the workspace, where some digits were lost before.

    Better ones go to f (ny,), the derivative of y per second.
    """
    if not work.scene.has_refinement or state.is_refined != LOOKED_AT:
        return
    if work.row_switch is not None and work.row_switch.is_active:
        return
    if lost_part(work) > MOST_ACCELERATION_ERROR:
        begin_refining(f, work, state)


def accelerate(work: Work, state: State) -> None:
    """Find q_dot (nq,), v_dot (nv,) [m/s², rad/s²] and the multipliers (nc,).

    M v̇ + C_qᵀλ = f and C_q v̇ = γ. Where many digits were lost, they are refined by the residual
    of the latter: S = C_q M⁻¹ C_qᵀ squares the condition of C_q, which this takes back.
    """
    all_rows = (
        work.row_switch if work.row_switch is not None and work.row_switch.is_active else None
    )
    if all_rows is None:
        work.w.run("acceleration")
    else:
        accelerate_all_rows(all_rows, work)
    if not work.scene.has_refinement:
        return
    state.pivot_ratio = pivot_ratio(work, state)
    if (
        state.is_refined == 1.0
        or state.pivot_ratio < REFINED_PIVOT_RATIO * state.largest_pivot_ratio
    ):
        state.refinements += 1
        if all_rows is None:
            refine(work)
        else:
            refine_all_rows(all_rows, work)
    if all_rows is not None:
        drive(all_rows, work)


def last_ratio(work: Work, state: State) -> float:
    """Pivot ratio where accelerations were found last."""
    return state.pivot_ratio if work.scene.has_refinement else pivot_ratio(work, state)


def project_position(tolerance: float, work: Work, low: Array | None, state: State) -> float:
    """Newton's method on C(q) = 0, from q in the workspace, until corrections are small enough.

    One that is left is the square of the one before. The geometry in the workspace is then that
    of q.

    Parameters
    ----------
    tolerance : float [-]
        A correction that may be left, lengths relative to that of the scene.
    work : Work
        Memory for work, with t and q.
    low : (ny,) array or None
        What rounding leaves over is added to it.
    state : State
        Counts what is evaluated.

    Returns
    -------
    float [-]
        The first correction, lengths relative to that of the scene; negative if it does not
        converge.
    """
    w, first, before = work.w, 0.0, math.inf
    w.dq[:] = 0.0
    w.displace(low)
    for attempt in range(MOST_CORRECTIONS):
        find_geometry(work, state)
        if work.scene.nc == 0:
            return 0.0
        state.factorisations += 1
        if before * before <= tolerance:
            return first
        correct_position(work)
        state.corrections += 1
        size = w.size_of(w.dq)
        if not size < math.inf:
            return -1.0
        if attempt == 0:
            first = size
        if size <= ROUNDING_CORRECTION:
            return first
        if size >= 0.5 * before and (size <= QUADRATIC_CORRECTION or size <= blur_of(work, state)):
            return first
        w.displace(low)
        before = size
    return -1.0


def project(
    t: float,
    tolerance: float,
    y: Array,
    low: Array | None,
    f: Array | None,
    work: Work,
    state: State,
) -> float:
    """Bring y to the manifold, or near enough to it, and give its derivative if f is not None.

    Then C(q) = 0 and C_q v = ν, and f has q̇ and the v̇ with C_q v̇ = γ.

    Parameters
    ----------
    t : float [s]
        Time.
    tolerance : float [-]
        A correction that may be left, relative to a length of the scene.
    y : (ny,) array
        Coordinates and velocities, in SI units.
    low : (ny,) array or None
        What rounding leaves over is added to it.
    f : (ny,) array or None
        Gets the time derivative of y.
    work : Work
        Memory for work.
    state : State
        Counts what is evaluated.

    Returns
    -------
    float [-]
        The first correction, relative to a length of the scene, negative where that is impossible.
    """
    w, nq = work.w, work.scene.nq
    w.place(t, y)
    first = project_position(tolerance, work, low, state)
    if not first >= 0.0:
        return -1.0
    if work.scene.nc > 0 or work.scene.has_joint_coordinates:
        correct_velocity(work)
        v = w.v.copy()
        w.v[:] = v + w.dv
        if low is not None:
            low[nq:] += rounding_of_sum(v, w.dv, w.v)
    y[:nq] = w.q
    y[nq:] = w.v
    if f is not None:
        accelerate(work, state)
        state.derivatives += 1
        f[:nq] = w.q_dot
        f[nq:] = w.v_dot
        if not np.isfinite(f).all():
            return -1.0
    return first


def take_normal_part(part: float, v: Array, work: Work, u: Array) -> None:
    """Subtract a part of the normal component from u (nv,), a displacement or change of v.

    It is normal at the geometry in the workspace, M⁻¹C_qᵀ (C_q M⁻¹C_qᵀ)⁻¹ C_q u; without all of it
    u is in the tangent space. Where drivers lead it is added to v (nv,) [m/s, rad/s] as large as v
    is, so that it is not lost in the rounding of fast motions.
    """
    scene, w = work.scene, work.w
    if scene.nc == 0 and not scene.has_joint_coordinates:
        return
    factor = larger(1.0, w.size_of(v)) if scene.has_drivers else 1.0
    w.v[:] = v + factor * u if scene.has_drivers else u
    correct_velocity(work)
    u += part * (w.dv / factor)


def displacement_of(scene: SceneTables, q: Array, dq: Array, u: Array) -> None:
    """Write the displacements u (nv,) [m, rad] that belong to a small change dq (nq,) of q."""
    u[scene.shifts[:, 1]] = dq[scene.shifts[:, 0]]
    for index, turn, count in scene.orientations.tolist():
        p, d = q[index : index + count].tolist(), dq[index : index + count].tolist()
        if count == 2:  # in a plane
            u[turn] = 2.0 * (p[0] * d[1] - p[1] * d[0])
        else:  # twice the vector part of the conjugate of p times dp
            u[turn] = 2.0 * (p[0] * d[1] - p[1] * d[0] - p[2] * d[3] + p[3] * d[2])
            u[turn + 1] = 2.0 * (p[0] * d[2] - p[2] * d[0] - p[3] * d[1] + p[1] * d[3])
            u[turn + 2] = 2.0 * (p[0] * d[3] - p[3] * d[0] - p[1] * d[2] + p[2] * d[1])


def ratio_at(q: Array, work: Work, state: State) -> float:
    """Pivot ratio [-] at a q (nq,) that need not be on the constraints.

    The workspace gets its geometry.
    """
    work.w.q[:] = q
    work.w.dq[:] = 0.0
    work.w.displace(None)
    find_geometry(work, state)
    return pivot_ratio(work, state)
