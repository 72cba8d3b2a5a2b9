"""Rows of kinds of one's own that seem to be implied by others: whether they really are.

C = 1 − cos θ is zero only at θ = 0, where its Jacobian vanishes. No number at positions where it
holds tells that from a row that others imply; but small motions that the others allow violate it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from kousoku.codegen.dynamics.assembly.residuals import Residuals, positions_of
from kousoku.codegen.dynamics.operations.characteristic_length import characteristic_length
from kousoku.codegen.dynamics.operations.mechanics import COLUMNS
from kousoku.codegen.dynamics.redundancy.branch import displaced
from kousoku.codegen.dynamics.simplification.planarity import OUT
from kousoku.codegen.sha256_random import Sha256Random
from kousoku.model.errors import SceneError
from kousoku.model.records.own_kind import is_own, kind_name
from kousoku.runtime.integrate.settings import CLEARLY

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from kousoku.codegen.dynamics.recording.program import RowIndex
    from kousoku.codegen.dynamics.redundancy.freedom import Mobility
    from kousoku.model.mechanics.multibody import System
    from kousoku.model.numbers.real import Array

#: Size of trial motions, in lengths of the scene and radians, and count of their directions.
TRIAL_MOVE, DIRECTIONS = 0.1, 3
#: Residual after the move, as a part of the square of the step, above which others do not imply a
#: row: that of 1 − cos θ is half of it, that of an implied row what is left of the others.
MISSED = 1e-3
#: Singular values that are zero, as parts of the largest.
ROW_RANK_TOLERANCE = 1e-9
#: Steps back onto the other rows at most, and their residual then.
MOST_RETURN_STEPS, RETURN_TOLERANCE = 20, 1e-12


def require_own_rows_implied(system: System, mobility: Mobility, *, is_planar: bool) -> None:
    """Refuse rows of kinds of one's own that would be left out, though others do not imply them.

    Parameters
    ----------
    system : System
        The scene, assembled, its numbers fixed.
    mobility : Mobility
        Its rows that depend on others.
    is_planar : bool
        Whether all bodies stay in planes parallel to the xy-plane.

    Raises
    ------
    SceneError
        The message names the joint.
    """
    own_rows = [row for row in mobility.dropped if is_own(system.constraints[row.instance].kind)]
    if not own_rows:
        return
    tolerance = CLEARLY * system.closure_tolerance * TRIAL_MOVE if mobility.closed else 0.0
    rows = Residuals.of(system, system.constraints)
    length = characteristic_length(system)
    index = {
        (row.instance, row.row): rows.first[row.instance] + row.row for row in mobility.dropped
    }
    columns = [k for k in _columns(system) if not (is_planar and k % COLUMNS in OUT)]
    moves = _Moves(system, rows, sorted(index.values()), columns, length)
    for missed in moves.missed():
        worst = max(own_rows, key=lambda row: missed[index[row.instance, row.row]])
        if not missed[index[worst.instance, worst.row]] <= max(MISSED * TRIAL_MOVE**2, tolerance):
            kind = kind_name(system.constraints[worst.instance].kind)
            raise SceneError(
                f"C of {kind} has no Jacobian of its own where the scene starts: no force can hold"
                " it there, and other joints do not imply it; wanted a C whose Jacobian keeps its"
                " rank where C = 0, or another start",
                key=f"joints.{worst.joint}",
            )


def repeated_rows(system: System, mobility: Mobility) -> tuple[RowIndex, ...]:
    """Rows left out that other rows of the same joint, of a kind of one's own, imply.

    The reaction of the joint does not depend on their multipliers: they carry nothing.
    """
    repeated: list[RowIndex] = []
    for index, instance in enumerate(system.constraints):
        dropped = [row for row in mobility.dropped if row.instance == index]
        if not dropped or not is_own(instance.kind):
            continue
        _, matrix = Residuals.of(system, [instance]).doubles(*positions_of(system.bodies))
        taken = [k for k in range(len(matrix)) if k not in {row.row for row in dropped}]
        for row in dropped:
            ranks = [_rank(matrix[[*taken, *added]]) for added in ((), (row.row,))]
            if ranks[0] == ranks[1]:
                repeated.append(row)
            else:
                taken.append(row.row)
    return tuple(repeated)


def _rank(matrix: Array) -> int:
    values = np.linalg.svd(matrix, compute_uv=False)
    return int((values > ROW_RANK_TOLERANCE * values.max(initial=0.0)).sum())


class _Moves:
    """Small motions that the kept rows allow."""

    def __init__(
        self,
        system: System,
        rows: Residuals,
        dropped: Sequence[int],
        columns: Sequence[int],
        length: float,
    ) -> None:
        self._rows, self._columns = rows, list(columns)
        self._kept = [k for k in range(rows.rows) if k not in set(dropped)]
        self._row_scales = np.where(rows.in_metres, 1 / length, 1.0)
        is_length = np.arange(rows.columns) % COLUMNS < COLUMNS // 2
        self._column_scales = np.where(is_length, length, 1.0)[self._columns]
        self._start = positions_of(system.bodies)
        self._stream = Sha256Random(f"own rows of {system.name}")

    def missed(self) -> Iterator[Array]:
        """Residuals of all rows after a motion, in lengths of the scene and radians."""
        for _ in range(DIRECTIONS):
            pairs = [(self._stream.sign(), self._stream.magnitude()) for _ in self._columns]
            trial = np.array([sign * size for sign, size in pairs])
            _, kept = self._at(*self._start)
            change = trial - np.linalg.pinv(kept, rcond=ROW_RANK_TOLERANCE) @ (kept @ trial)
            largest = np.abs(change).max(initial=0.0)
            if largest < TRIAL_MOVE**2:
                return
            pose = self._moved(*self._start, TRIAL_MOVE * change / largest)
            for _ in range(MOST_RETURN_STEPS):
                c, kept = self._at(*pose)
                if np.abs(c[self._kept]).max(initial=0.0) <= RETURN_TOLERANCE:
                    yield np.abs(c)
                    break
                back = np.linalg.pinv(kept, rcond=ROW_RANK_TOLERANCE) @ c[self._kept]
                pose = self._moved(*pose, -back)

    def _at(self, r: Array, p: Array) -> tuple[Array, Array]:
        """Residuals of all rows, and the Jacobian of those that are kept, scaled."""
        c, matrix = self._rows.doubles(r, p)
        kept = matrix[np.ix_(self._kept, self._columns)]
        return c * self._row_scales, kept * self._row_scales[self._kept, None] * self._column_scales

    def _moved(self, r: Array, p: Array, change: Array) -> tuple[Array, Array]:
        """Positions after a change of the columns, scaled."""
        full = np.zeros(self._rows.columns)
        full[self._columns] = change * self._column_scales
        return displaced(r, p, full)


def _columns(system: System) -> list[int]:
    """Columns that are coordinates: points do not turn."""
    return [
        COLUMNS * k + n
        for k, body in enumerate(system.bodies)
        for n in range(COLUMNS // 2 if body.is_point else COLUMNS)
    ]
