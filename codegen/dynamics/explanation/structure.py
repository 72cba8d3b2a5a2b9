"""Structure of a program: elements that are not zero, in C_q and in the factors of S."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from kousoku.codegen.dynamics.assembly.residuals import Residuals
from kousoku.codegen.dynamics.disjoint_sets import DisjointSets
from kousoku.codegen.dynamics.operations.elimination_order import minimum_degree
from kousoku.codegen.dynamics.operations.mechanics import COLUMNS
from kousoku.model.lowering.parametric import fixed_system
from kousoku.model.mechanics.multibody import GROUND_INDEX

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from kousoku.codegen.dynamics.recording.program import CoordinatePlace, Program
    from kousoku.model.mechanics.multibody import System

#: Elements that are smaller at a position without a pattern are zero everywhere.
NEGLIGIBLE_ENTRY = 1e-13
#: Multiples of it, less whole numbers, have no pattern: none is 0 or 1, and no two are equal.
GOLDEN = 0.6180339887498949


@dataclass(frozen=True, slots=True)
class Structure:
    """Structure of the equations that remain of a scene.

    Parameters
    ----------
    positions, velocities, rows : int
        Coordinates of bodies, velocities, and rows of C_q that are kept.
    dependent : int
        Velocities that follow from the others by joints with the ground, or from drivers of these.
    elements : int
        Elements of C_q that are not structurally zero; of C_q R where velocities are R u.
    dense : int
        Elements of the blocks of C_q, with six columns for each body.
    schur : int
        Elements of the lower triangle of S = C_q M⁻¹ C_qᵀ, by blocks of joints.
    fill_in : int
        Further elements of its factors.
    parts : int
        Parts of the scene that share no moving body: no element of S couples them.
    """

    positions: int
    velocities: int
    dependent: int
    rows: int
    elements: int
    dense: int
    schur: int
    fill_in: int
    parts: int


def structure_of(system: System, program: Program) -> Structure:
    """Structure of a program."""
    free = _free(system, program)
    ends, sizes = _joints(system, program)
    pairs = _coupled(ends, free)
    schur = sum(n * (n + 1) // 2 for n in sizes) + sum(sizes[a] * sizes[b] for a, b in pairs)
    factors = sum(
        sizes[pivot.joint] * (sizes[pivot.joint] + 1) // 2
        + sum(sizes[pivot.joint] * sizes[other] for other in pivot.neighbours)
        for pivot in minimum_degree(len(sizes), pairs)
    )
    return Structure(
        positions=program.region("q").size - len(program.auxiliary),
        velocities=program.region("v").size,
        dependent=len(program.satisfied),
        rows=len(program.rows),
        elements=_elements(system, program, free),
        dense=sum(
            6 * size * sum(body != GROUND_INDEX for body in bodies)
            for size, bodies in zip(sizes, ends, strict=True)
        ),
        schur=schur,
        fill_in=factors - schur,
        parts=_parts(len(system.bodies), ends),
    )


def _joints(system: System, program: Program) -> tuple[list[tuple[int, ...]], list[int]]:
    """Bodies and number of rows of each joint that keeps rows."""
    sizes: dict[tuple[str, tuple[int, ...]], int] = {}
    for row in program.rows:
        instance = system.constraints[row.instance]
        key = (instance.joint, tuple(sorted(instance.bodies)))
        sizes[key] = sizes.get(key, 0) + 1
    return [bodies for _, bodies in sizes], list(sizes.values())


def _free(system: System, program: Program) -> dict[int, int]:
    """Number of velocities, by body, of bodies in coordinates of a joint with the ground."""
    free: dict[int, int] = {}
    for row in program.satisfied:
        body = max(system.constraints[row.instance].bodies)
        coordinates = program.bodies[body]
        free.setdefault(body, sum(x.slot >= 0 for x in (*coordinates.v, *coordinates.omega_b)))
        free[body] -= 1
    return free


def _coupled(ends: Sequence[tuple[int, ...]], free: Mapping[int, int]) -> list[tuple[int, int]]:
    """Pairs of joints that share a body whose motion is not prescribed."""
    by_body: dict[int, list[int]] = {}
    pairs: dict[tuple[int, int], None] = {}
    for k, bodies in enumerate(ends):
        for body in bodies:
            if body != GROUND_INDEX and free.get(body) != 0:
                pairs.update(((k, other), None) for other in by_body.get(body, ()))
        for body in bodies:
            by_body.setdefault(body, []).append(k)
    return list(pairs)


def _parts(count: int, ends: Sequence[tuple[int, ...]]) -> int:
    """Number of groups of bodies that joints make, the ground aside."""
    groups = DisjointSets(range(count))
    for bodies in ends:
        first, *others = [body for body in bodies if body != GROUND_INDEX] or [GROUND_INDEX]
        for other in others:
            groups.join(first, other)
    return len(groups.sets())


def _columns(program: Program) -> list[int]:
    """Columns of velocities that vary, of six columns for each body."""
    places = (place for body in program.bodies for place in (*body.v, *body.omega_b))
    return [k for k, place in enumerate(places) if place.slot >= 0]


def _elements(system: System, program: Program, free: Mapping[int, int]) -> int:
    """Count of elements that are not zero at a position without a pattern.

    A body in coordinates of a joint has an element per velocity in each row that has any.
    """
    fixed = fixed_system(system)
    residuals = Residuals.of(fixed, fixed.constraints)
    numbers = iter(range(1, 7 * len(program.bodies) + 1))

    def generic(coordinates: Sequence[CoordinatePlace]) -> list[float]:
        return [
            place.value if place.slot < 0 else 0.25 + number * GOLDEN % 1.0
            for place, number in zip(coordinates, numbers, strict=False)
        ]

    r = [generic(body.r) for body in program.bodies]
    p = [generic(body.p) for body in program.bodies]
    ground = [0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]
    _, rows, columns, values = residuals.elements(
        np.array([*r, ground[0]]), np.array([*p, ground[1]])
    )
    kept_rows = np.zeros(residuals.rows, bool)
    for row in program.rows:
        kept_rows[residuals.first[row.instance] + row.row] = True
    kept_columns = np.zeros(residuals.columns, bool)
    kept_columns[_columns(program)] = True
    kept = kept_rows[rows] & kept_columns[columns] & (np.abs(values) > NEGLIGIBLE_ENTRY)
    elements = np.unique(rows[kept] * residuals.columns + columns[kept])  # bodies may be shared
    blocks, counts = np.unique(elements // COLUMNS, return_counts=True)
    bodies = (blocks % (residuals.columns // COLUMNS)).tolist()
    return sum(free.get(k, n) for k, n in zip(bodies, counts.tolist(), strict=True))
