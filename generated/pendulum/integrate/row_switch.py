"""The row switch-over: where the rows that are kept lose rank.

Some rows of the constraints depend on others and are left out. Where those that are kept are nearly
dependent, the rows that were left out take over: all rows are solved for, as many as are
independent, in the order of the largest pivots. A column of C_q is the rate of the rows at a unit
velocity less their rate at rest, −ν, which drivers cause. No row of a driver depends on others: its
multiplier is the same whichever rows are solved for.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from .arithmetic import larger, smaller
from .pivot_monitor import pivot_ratio

if TYPE_CHECKING:
    import numpy.typing as npt

    from .arithmetic import Array
    from .scene_tables import RowSwitch, Work
    from .settings import Settings
    from .state import State

#: Pivot ratio of the rows that are kept, relative to the largest so far, below which rows that were
#: left out may take over.
FALL_BACK = 1e-2
#: Smallest factor by which all rows must have the larger pivot ratio to take over: else the choice
#: of rows is not to blame.
HELPS = 10.0
#: Value in place of the largest pivot ratio so far that asks for all rows to be solved for,
#: whatever the pivots of those that are kept.
ALL_OF_THEM = -1.0


def inverse_masses(work: Work) -> Array:
    """Diagonal (nv,) of M⁻¹ [1/kg, 1/(kg m²)] with the parameters of the run."""
    fixed, index = work.scene.inverse_masses, work.scene.mass_places
    return np.where(index < 0, fixed, work.w.design[index]) if len(index) else fixed


def write_jacobian(all_rows: RowSwitch, work: Work) -> None:
    """Write C_q of all rows, row by row; v stays what it is."""
    w = work.w
    kept = w.v.copy()
    w.v[:] = 0.0
    if work.scene.has_drivers:
        w.run("check")
        all_rows.rates[:] = w.C_dot
    for k in range(work.scene.nv):
        w.v[k] = 1.0
        w.run("check")
        w.v[k] = 0.0
        all_rows.rows[:, k] = w.C_dot - all_rows.rates if work.scene.has_drivers else w.C_dot
    w.v[:] = kept


def exchange(a: npt.NDArray[Any], i: int, j: int) -> None:
    """Exchange two rows of a (n, m), or two numbers of a (n,)."""
    a[[i, j]] = a[[j, i]]


def comparable_pivot(all_rows: RowSwitch, work: Work) -> Array:
    """Pivots (rows,) of all rows in their order, as inverses of masses [1/kg]."""
    pivots: Array = np.diagonal(all_rows.matrix) / work.scene.inverse_pivot_factors[all_rows.order]
    return pivots


def factorise_rows(all_rows: RowSwitch, work: Work, known: float) -> float:
    """Make L D Lᵀ of nc rows of C_q M⁻¹ C_qᵀ, those of drivers and those with the largest pivots.

    Returns the smallest pivot relative to the largest one of these rows and of all steps, 0 if one
    is not positive. ``known`` is the inverse of the largest pivot of all steps, 0 if there is none.
    """
    scene, a, order = work.scene, all_rows.matrix, all_rows.order
    first = scene.drivers[:, 0].tolist()  # their multipliers are wanted whatever happens
    order[:] = first + [row for row in range(len(order)) if row not in first]
    rows, weights = all_rows.rows[order], inverse_masses(work)
    a[:] = 0.0
    for k in range(scene.nv):
        a += np.outer(rows[:, k] * weights[k], rows[:, k])
    least, most = math.inf, 1.0 / known if known > 0.0 else 0.0
    for r in range(scene.nc):
        best = r
        if r >= len(first):
            best += int(np.argmax(comparable_pivot(all_rows, work)[r:]))
        exchange(order, r, best)
        exchange(a, r, best)
        exchange(a.T, r, best)
        if not a[r, r] > 0.0:
            return 0.0
        pivot = float(comparable_pivot(all_rows, work)[r])
        least, most = smaller(least, pivot), larger(most, pivot)
        a[r + 1 :, r] /= a[r, r]
        a[r + 1 :, r + 1 :] -= np.outer(a[r + 1 :, r], a[r, r + 1 :])
    return least / most


def solve_rows(right: Array, all_rows: RowSwitch, work: Work, u: Array) -> Array:
    """Set u (nv,) = −M⁻¹ C_qᵀ λ, where C_q M⁻¹ C_qᵀ λ is the right-hand side of all rows (rows,).

    Returns λ (nc,), in the order in which rows are solved for. In the units of the right, u is a
    correction of q [m, rad], of v, or of v̇.
    """
    a, count = all_rows.matrix, work.scene.nc
    order = all_rows.order[:count]
    x: Array = right[order]
    for r in range(count):
        x[r + 1 :] -= a[r + 1 : count, r] * x[r]
    x /= np.diagonal(a)[:count]
    for r in reversed(range(count)):
        x[:r] -= a[r, :r] * x[r]
    u[:] = 0.0
    for r in range(count):
        u += all_rows.rows[order[r]] * x[r]
    u *= -inverse_masses(work)
    return x


def drive(all_rows: RowSwitch, work: Work) -> None:
    """Find the power of drivers with the multipliers of all rows."""
    q_dot, drivers = work.w.q_dot, work.scene.drivers
    for _, work_index in drivers:
        q_dot[work_index] = 0.0
    for row, work_index in drivers:
        q_dot[work_index] += all_rows.rates[row] * all_rows.lam[row]


def null_multipliers(n: int, all_rows: RowSwitch, count: int) -> Array:
    """Multipliers (rows,) that move no body, that of the n-th row that was not solved for being 1.

    Parameters
    ----------
    n : int
        Which one.
    all_rows : RowSwitch
        Their factors.
    count : int
        How many rows are solved for.
    """
    a, order = all_rows.matrix, all_rows.order
    x = a[count + n, :count].copy()
    for r in reversed(range(count)):
        x[:r] -= a[r, :r] * x[r]
    lam = np.zeros(len(order))
    lam[order[:count]] = -x
    lam[order[count + n]] = 1.0
    return lam


def inner_product(a: Array, b: Array) -> float:
    """Inner product of a and b (n,), added up in the order of C."""
    return float(np.cumsum(a * b)[-1])


def eliminate(square: Array, right: Array) -> None:
    """Solve square (n, n) x = right (n,) by elimination; both are used up, and x is in right."""
    count = len(right)
    for r in range(count):
        factors = square[r + 1 :, r] / square[r, r]
        square[r + 1 :, r + 1 :] -= np.outer(factors, square[r, r + 1 :])
        right[r + 1 :] -= factors * right[r]
    for r in reversed(range(count)):
        right[r] /= square[r, r]
        right[:r] -= square[:r, r] * right[r]


def least_norm_reactions(all_rows: RowSwitch, work: Work) -> None:
    """Find the forces of joints of least norm.

    Of all multipliers that move the bodies as those that were found do, they are those with the
    least forces and torques, as where the rows that are kept are independent.
    """
    w, count = work.w, work.scene.nc
    null_space, wrenches = [], []
    for n in range(len(all_rows.order) - count):
        null_space.append(null_multipliers(n, all_rows, count))
        w.all_lam[:] = null_space[n]
        w.run("wrench")
        wrenches.append(w.wrenches.copy())
    w.all_lam[:] = all_rows.lam
    w.run("wrench")
    square = np.array([[inner_product(first, second) for second in wrenches] for first in wrenches])
    mu = np.array([-inner_product(first, w.wrenches) for first in wrenches])
    eliminate(square, mu)
    for multipliers, factor in zip(null_space, mu, strict=True):
        w.all_lam += factor * multipliers
    w.run("wrench")


def take_multipliers(all_rows: RowSwitch, work: Work) -> None:
    """Take the multipliers of the rows that are kept for those of all rows.

    The factors that are found tell which others there are; without these no force is known.
    """
    count = work.scene.nc
    all_rows.lam[:count], all_rows.lam[count:] = work.w.lam, 0.0
    write_jacobian(all_rows, work)
    if not factorise_rows(all_rows, work, 0.0) > 0.0:
        all_rows.lam[:count] = math.nan


def refine_all_rows(all_rows: RowSwitch, work: Work) -> None:
    """Correct v̇, and the multipliers of all rows, by what is left of C_q v̇ = γ."""
    work.w.run("check")
    change = np.empty(work.scene.nv)
    x = solve_rows(work.w.C_ddot, all_rows, work, change)
    work.w.v_dot += change
    all_rows.lam[all_rows.order[: len(x)]] += x


def accelerate_all_rows(all_rows: RowSwitch, work: Work) -> None:
    """Find q_dot, v_dot and the multipliers of all rows."""
    kept = work.w.pivots.copy()  # others may read a number that is equal to one
    work.w.pivots[:] = 0.0  # without them no row has a force: then all get theirs
    all_rows.lam[:] = 0.0
    work.w.run("acceleration")
    work.w.pivots[:] = kept
    refine_all_rows(all_rows, work)


def forget_trials(work: Work) -> None:
    """Forget where all rows were tried in vain: nothing depends on what was asked before."""
    if work.row_switch is not None:
        work.row_switch.tried = 0.0


def are_all_rows_better(ratio: float, all_rows: RowSwitch, work: Work, state: State) -> bool:
    """Whether all rows are better than those kept.

    Where they are not, as where drivers or bars stand in line, they are tried again only when the
    pivot ratio of the rows kept has changed by the factor ``HELPS``.
    """
    if ratio < HELPS * all_rows.tried and all_rows.tried < HELPS * ratio:
        return False
    write_jacobian(all_rows, work)
    all_rows.ratio = factorise_rows(all_rows, work, state.least_inverse_pivot)
    is_better = all_rows.ratio > HELPS * ratio
    all_rows.tried = 0.0 if is_better else ratio
    return is_better


def check_misses(s: Settings, work: Work) -> None:
    """Check what rows that are left out miss at the position in the workspace."""
    if s.checks and len(work.missed) > 0:
        work.w.run("check")
        work.missed[:] = np.abs(work.w.all_C[work.scene.nc :])


def note_misses(s: Settings, work: Work, state: State) -> None:
    """Note the misses of rows that are left out, at a position that is kept."""
    worst = state.violations[0, work.scene.nc :]
    if s.checks and len(work.missed) > 0:
        np.fmax(worst, work.missed, out=worst)


def find_geometry(work: Work, state: State) -> None:
    """Find the geometry of q, and the factors of all rows where those kept are nearly dependent."""
    work.w.run("geometry")
    if work.row_switch is None:
        return
    work.row_switch.is_active = False
    if state.largest_pivot_ratio == ALL_OF_THEM:
        write_jacobian(work.row_switch, work)
        work.row_switch.ratio = factorise_rows(work.row_switch, work, 0.0)
        work.row_switch.is_active = work.row_switch.ratio > 0.0
        return
    ratio = pivot_ratio(work, state)
    if ratio < FALL_BACK * state.largest_pivot_ratio and are_all_rows_better(
        ratio, work.row_switch, work, state
    ):
        work.row_switch.is_active = True
        state.fallbacks += 1
        state.fallback_time = work.w.t[0]


def note_first_pivot_ratio(all_rows: RowSwitch, work: Work, state: State) -> None:
    """Keep the usual pivot ratio where a run begins.

    If rows that are kept are nearly dependent there, it is that of all rows.
    """
    work.w.place(state.time, state.y)
    work.w.dq[:] = 0.0
    work.w.displace(None)
    work.w.run("geometry")
    all_rows.is_active = False
    forget_trials(work)
    ratio = pivot_ratio(work, state)
    write_jacobian(all_rows, work)
    ratio_of_all = factorise_rows(all_rows, work, state.least_inverse_pivot)
    state.largest_pivot_ratio = ratio_of_all if ratio < FALL_BACK * ratio_of_all else ratio
