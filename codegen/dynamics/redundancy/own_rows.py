"""Rows of kinds of one's own that look as if others implied them: whether these really do.

C = 1 − cos θ is zero only at θ = 0, where its Jacobian vanishes. No number at positions where it
holds tells that from a row that others imply; but small motions that the others allow violate it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from kousoku.codegen.dynamics.assembly.residuals import Residuals
from kousoku.codegen.dynamics.composition.length import characteristic_length
from kousoku.codegen.dynamics.operations.mechanics import COLUMNS
from kousoku.codegen.dynamics.redundancy.branch import places_of
from kousoku.codegen.stream import Stream
from kousoku.model.errors import SceneError
from kousoku.model.own_kind import is_own, kind_name
from kousoku.runtime.integrate.settings import CLEARLY

if TYPE_CHECKING:
    from collections.abc import Iterator

    import numpy.typing as npt

    from kousoku.codegen.dynamics.redundancy.freedom import Freedom
    from kousoku.model.mechanism import System

    Array = npt.NDArray[np.float64]

#: How far bodies are moved, in lengths of the scene and radians, and in how many directions.
STEP, DIRECTIONS = 0.1, 3
#: What a row misses then that others do not imply, as a part of the square of the step.
MISSED = 1e-3
#: Singular values that are zero, as parts of the largest.
ZERO = 1e-9
#: Steps back onto the other rows at most, and what is left of them then.
MOST_STEPS, CLOSED = 20, 1e-12


def require_own_rows_implied(system: System, freedom: Freedom) -> None:
    """Refuse rows of kinds of one's own that would be left out, though others do not imply them.

    Parameters
    ----------
    system : System
        The scene, assembled, its numbers fixed.
    freedom : Freedom
        Which rows depend on others.

    Raises
    ------
    SceneError
        The message names the joint.
    """
    left = [row for row in freedom.dropped if is_own(system.constraints[row.instance].kind)]
    if not left:
        return
    nearly = CLEARLY * system.closure_tolerance * STEP if freedom.closed else 0.0
    rows = Residuals.of(system, system.constraints)
    length = characteristic_length(system)
    place = {(row.instance, row.row): rows.first[row.instance] + row.row for row in freedom.dropped}
    by = np.where(rows.in_metres, 1 / length, 1.0)
    for missed in _missed(system, rows, sorted(place.values()), by, length):
        worst = max(left, key=lambda row: missed[place[row.instance, row.row]])
        if not missed[place[worst.instance, worst.row]] <= max(MISSED * STEP**2, nearly):
            kind = kind_name(system.constraints[worst.instance].kind)
            raise SceneError(
                f"C of {kind} has no Jacobian of its own where the scene starts: no force can hold"
                " it there, and other joints do not imply it; wanted a C whose Jacobian keeps its"
                " rank where C = 0, or another start",
                key=f"joints.{worst.joint}",
            )


def _missed(
    system: System, rows: Residuals, left: list[int], by: Array, length: float
) -> Iterator[Array]:
    """Yield what all rows miss after small motions that those allow which are kept."""
    stream = Stream(f"own rows of {system.name}")
    kept = [k for k in range(rows.rows) if k not in set(left)]
    sizes = np.where(np.arange(rows.columns) % COLUMNS < COLUMNS // 2, length, 1.0)
    start = places_of(system.bodies)
    for _ in range(DIRECTIONS):
        wish = np.array([stream.sign() * stream.magnitude() for _ in range(rows.columns)])
        _, matrix = rows.doubles(*start)
        scaled = matrix[kept] * by[kept, None] * sizes
        change = wish - np.linalg.pinv(scaled, rcond=ZERO) @ (scaled @ wish)
        change[~_moving(system)] = 0.0
        largest = np.abs(change).max(initial=0.0)
        if largest < STEP**2:
            return
        r, p = _moved(*start, STEP * change / largest * sizes)
        for _ in range(MOST_STEPS):
            c, matrix = rows.doubles(r, p)
            if np.abs(c[kept] * by[kept]).max(initial=0.0) <= CLOSED:
                yield np.abs(c * by)
                break
            scaled = matrix[kept] * by[kept, None] * sizes
            back = np.linalg.pinv(scaled, rcond=ZERO) @ (c[kept] * by[kept])
            r, p = _moved(r, p, -back * sizes)


def _moving(system: System) -> npt.NDArray[np.bool_]:
    """Return which columns are coordinates: points do not turn."""
    return np.array(
        [
            not (body.is_point and k >= COLUMNS // 2)
            for body in system.bodies
            for k in range(COLUMNS)
        ]
    )


def _moved(r: Array, p: Array, change: Array) -> tuple[Array, Array]:
    """Return positions after displacements (δr, δθ′): p ∘ (1, δθ′/2), of norm one."""
    by_body = change.reshape(-1, COLUMNS)
    r, p = r.copy(), p.copy()
    r[:-1] += by_body[:, :3]
    w, v, half = p[:-1, :1], p[:-1, 1:], by_body[:, 3:] / 2
    turned = np.hstack(
        [w - (v * half).sum(axis=1, keepdims=True), v + w * half + np.cross(v, half)]
    )
    p[:-1] = turned / np.sqrt((turned * turned).sum(axis=1, keepdims=True))
    return r, p
