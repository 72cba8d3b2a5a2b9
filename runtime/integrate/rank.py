"""The rank of rows with the parameters of a run.

Rows that are independent at nominal parameters may become redundant within the closure tolerance at
others, and then constrain motions that should be free. The rank is determined as where a scene is
generated: by pivots of C_q without masses, with rotations scaled by the arms of their body, and by
how far rows are violated per length and radian that bodies move.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .continuation import SMALLEST_DIRECTION, follow_design, set_parameters, step_along
from .projection import project
from .settings import CLEARLY
from .state import SINGLE
from .tasks import numbers

if TYPE_CHECKING:
    from .arithmetic import Array
    from .scene_tables import SceneTables, Work
    from .state import State

#: Remainder of a scaled row up to which it depends on others but for rounding.
HARDLY = 1e-11
#: Smallest arm of a body, relative to the longest: a body with a smaller one has none.
NO_ARM = 1e-9
#: Distance, in lengths of the scene or radians, up to which a position is still the start.
NOT_LEFT = 5e-4


class Rank:
    """Scaled rows whose rank is determined.

    Parameters
    ----------
    scene : SceneTables
        What they belong to.
    """

    def __init__(self, scene: SceneTables) -> None:
        self.places, self.are_left_out = scene.rank_rows.T
        count = len(self.places)
        self.rows = np.zeros((count, scene.nv))  # C_q, then a basis of the rows that were taken
        self.columns_by, self.rows_by = np.ones(scene.nv), np.ones(count)
        self.rates = np.zeros(count)  # what rows miss; negative of those that were taken
        self.lengths, self.row_lengths = scene.lengths, scene.row_lengths[self.places]
        self.moves = np.array(numbers(scene.tables["is_length"])) > 0.0
        are_lengths = np.array(numbers(scene.tables["row_is_length"])) > 0.0
        self.are_lengths = are_lengths[self.places]


def write_scaled_rows(rank: Rank, work: Work) -> None:
    """Write C_q, scaled: turns by the arms of their body, rows by their largest element."""
    w, scene, by = work.w, work.scene, rank.columns_by
    w.v[:] = 0.0
    for k in range(scene.nv):
        w.v[k] = 1.0
        w.run("check")
        w.v[k] = 0.0
        rank.rows[:, k] = w.C_dot[rank.places]
    by[:] = 0.0
    in_lengths = np.abs(rank.rows[rank.are_lengths])
    for _, first, count in scene.orientations.tolist():
        columns = slice(first, first + (3 if count == 4 else 1))
        by[columns] = in_lengths[:, columns].max(initial=0.0)
    longest = float(by.max(initial=0.0))
    by[:] = np.where(by > NO_ARM * longest, by, longest)
    by[:] = np.where(rank.moves | (longest == 0.0), 1.0, 1.0 / by)
    rank.rows *= by
    rank.rows_by[:] = np.abs(rank.rows).max(axis=1)
    rank.rows /= np.where(rank.rows_by > 0.0, rank.rows_by, 1.0)[:, None]


def rate_of_row(rank: Rank) -> tuple[Array, Array]:
    """Rates (n,) [-] at which rows miss, per unit of the motion that the rows taken so far allow.

    |x|² b / (l |u|) of a row x (nv,), with its scale b, the length or radian l that its residual is
    compared with, and its motion u in lengths of the scene and radians. Also returns the square of
    the remainder of each row, |x|² (n,).
    """
    squares, motions = np.zeros((2, len(rank.rows)))
    for k in range(rank.rows.shape[1]):
        x = rank.rows[:, k]
        moved = x * rank.columns_by[k] / rank.lengths[k]
        squares += x * x
        motions += moved * moved
    motions = np.sqrt(motions)
    rates = squares * rank.rows_by / rank.row_lengths / motions
    return np.where(motions > HARDLY, rates, 0.0), squares


def rank_here(rank: Rank, work: Work) -> int:
    """Number of rows that are independent beyond doubt at the geometry in the workspace.

    They become a basis, and their rates negative; those of the others are their misses.
    """
    limit, count = CLEARLY * work.scene.closure_tolerance, 0
    write_scaled_rows(rank, work)
    rank.rates[:] = 0.0
    while True:
        rates, squares = rate_of_row(rank)
        others = rank.rates >= 0.0
        rank.rates[others] = rates[others]
        squares = np.where(others, squares, 0.0)
        size = float(np.sqrt(squares.max()))
        if not (size > HARDLY and (size > limit or rank.rates.max() > limit)):
            return count
        best = int(np.argmax(squares))
        rank.rates[best] = -1.0
        others[best] = False
        basis = rank.rows[best]
        basis /= size
        projections = np.zeros(len(rank.rows))
        for k in range(len(basis)):
            projections += rank.rows[:, k] * basis[k]
        rank.rows[others] -= np.outer(projections[others], basis)
        count += 1


def is_regular_beside(wanted: int, rank: Rank, state: State, work: Work) -> bool:
    """Whether the wanted number of rows is independent beside the start, which is singular."""
    y, nq = work.k[0], work.scene.nq
    for back in range(2):
        y[:] = state.y
        if project(state.time, 0.0, y, None, None, work, state) < 0.0:
            return False
        rank_here(rank, work)
        x = 0.6180339887498949 * np.arange(1.0, work.scene.nv + 1.0)
        u = np.floor(x) + 0.5 - x if back else x - np.floor(x) - 0.5  # no special direction
        for row in rank.rows[rank.rates < 0.0]:
            u -= np.cumsum(row * u)[-1] * row
        u *= rank.columns_by
        size = work.w.size_of(u)
        if not size > SMALLEST_DIRECTION:
            return False
        u /= size
        if not step_along(u, y, work, state):
            continue
        moved = (np.abs(y[:nq] - state.y[:nq]) / work.scene.floors).max()
        if moved > NOT_LEFT and rank_here(rank, work) >= wanted:
            return True
    return False


def keep_rank(state: State, work: Work) -> bool:
    """Whether rows that are independent with the parameters of the scene are so in the run.

    The former rank is that at the start of the scene. If the rank drops, residuals are replaced by
    the misses of dependent rows, and by 0 for independent ones. The state stays as it is.
    """
    w, y, rank = work.w, work.k[0], Rank(work.scene)
    counts = state.numbers[:SINGLE].copy()
    y[:] = state.y
    if project(state.time, 0.0, y, None, None, work, state) < 0.0:
        return True
    count = rank_here(rank, work)
    wanted = int((rank.are_left_out == 0).sum())
    if count < wanted:
        y[:] = state.y
        set_parameters(state.parameters, 0.0, w)
        follow_design(y, w)
        if project(state.time, 0.0, y, None, None, work, state) >= 0.0:
            wanted = rank_here(rank, work)
        set_parameters(state.parameters, 1.0, w)
        w.run("setup")
    is_kept = count >= wanted or is_regular_beside(wanted, rank, state, work)
    if not is_kept:
        y[:] = state.y
        project(state.time, 0.0, y, None, None, work, state)
        rank_here(rank, work)
        w.all_C[:] = 0.0
        missed = np.fmax(rank.rates, HARDLY * HARDLY) * rank.row_lengths
        w.all_C[rank.places] = np.where(rank.rates < 0.0, 0.0, missed)
    state.numbers[:SINGLE] = counts
    return is_kept
