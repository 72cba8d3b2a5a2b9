"""The pivot monitor: small pivots of C_q M⁻¹ C_qᵀ tell that rows are nearly dependent."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from .arithmetic import larger, smaller

if TYPE_CHECKING:
    from .arithmetic import Array
    from .scene_tables import SceneTables, Work
    from .state import State

#: A pivot ratio this much smaller than the largest so far: rows are nearly dependent.
WEAK_PIVOT_RATIO = 1e-6
#: One this much smaller: small errors of positions decide about velocities and accelerations.
VAGUE_PIVOT_RATIO = 1e-8
#: Rounding of a position, times the root of the branch ratio: branches that miss each other by less
#: meet in double precision.
BRANCH_ROUNDING = 1e-14
#: Bodies that are so many lengths of the scene from the origin of frame O are far: rounding of
#: their positions counts.
FAR_AWAY = 100.0


def inverse_pivots(work: Work) -> tuple[float, float] | None:
    """Smallest and largest element of D⁻¹ (nc,) [kg], where C_q M⁻¹ C_qᵀ = L D Lᵀ.

    None unless all are positive and finite.
    """
    inverses = work.w.pivots * work.scene.inverse_pivot_factors[: work.scene.nc]
    least, most = float(inverses.min()), float(inverses.max())
    return (least, most) if least > 0.0 and most < math.inf else None


def pivot_ratio(work: Work, state: State) -> float:
    """Smallest pivot of the factors in the workspace relative to the largest [-].

    The largest is that of them and of all steps. 0 if one is not positive; it tends to 0 where rows
    become dependent.
    """
    if work.row_switch is not None and work.row_switch.is_active:
        return work.row_switch.ratio
    if work.scene.nc == 0:
        return 1.0
    inverses = inverse_pivots(work)
    if inverses is None:
        return 0.0
    least, most = inverses
    known = state.least_inverse_pivot
    return (smaller(least, known) if known > 0.0 else least) / most


def note_largest_pivot(work: Work, state: State) -> None:
    """Keep the largest pivot of all steps: alone it would tell nothing of a single row.

    Where drivers lead the first ones of all rows are kept.
    """
    inverses = inverse_pivots(work) if work.scene.nc > 0 else None
    if inverses is None:
        return
    known = state.least_inverse_pivot
    state.least_inverse_pivot = smaller(inverses[0], known) if known > 0.0 else inverses[0]
    usual = state.usual_pivots[: work.scene.nc]
    if work.scene.is_driven and usual[0] == 0.0:
        usual[:] = 1.0 / work.w.pivots


def branch_ratio(work: Work, state: State) -> float:
    """Ratio [-] that goes with the square of the distance from a place where branches meet.

    That is the pivot ratio. Where drivers lead C_q is square, and all pivots together, Π dₖ/d₀ₖ,
    tell the square of its determinant, beside that at the start: a smooth number that is zero
    there, and tells of it from afar, where the smallest pivot may be another one.
    """
    usual = state.usual_pivots[: work.scene.nc]
    is_square = work.scene.is_driven and len(usual) > 0 and usual[0] > 0.0
    if not is_square or (work.row_switch is not None and work.row_switch.is_active):
        return pivot_ratio(work, state)
    if inverse_pivots(work) is None:
        return 0.0
    return 1.0 / float(np.cumprod(work.w.pivots * usual)[-1])


def scale_by_distance(y: Array, scene: SceneTables) -> float:
    """Factor [-] by which rounding of positions exceeds that of a length of the scene.

    It is 1 if no body is far from the origin of frame O. Joints bring that into angles and
    distances, too.
    """
    farthest = float(np.max(np.abs(y[scene.shifts[:, 0]]), initial=0.0))
    return farthest / scene.length if farthest > FAR_AWAY * scene.length else 1.0


def blur_of(work: Work, state: State) -> float:
    """Error [-] that rounding may leave of a position, in lengths of the scene and radians."""
    ratio = larger(pivot_ratio(work, state), branch_ratio(work, state))
    away = scale_by_distance(state.y, work.scene)
    return away * BRANCH_ROUNDING / math.sqrt(larger(ratio, BRANCH_ROUNDING))


def usual_ratio(work: Work, state: State) -> float:
    """Largest branch ratio so far."""
    return state.usual_ratio if work.scene.is_driven else state.largest_pivot_ratio


def note_pivot_ratio(ratio: float, t: float, state: State) -> None:
    """Keep the smallest pivot ratio, and when that was."""
    if ratio < state.least_pivot_ratio:
        state.least_pivot_ratio = ratio
        state.least_pivot_ratio_time = t
