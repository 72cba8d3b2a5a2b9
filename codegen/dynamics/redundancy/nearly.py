"""Rows that others imply within the closure tolerance, before a scene is assembled.

Where joints nearly repeat each other, all rows hold only where the scene is stiff by a hair, if
anywhere. So positions are sought at which the rows hold that are independent beyond it.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from kousoku.codegen.dynamics.assembly.assemble import MOST_ASSEMBLED_ROWS, assemble
from kousoku.codegen.dynamics.assembly.minimum_norm import Metric
from kousoku.codegen.dynamics.assembly.near_origin import brought_near
from kousoku.codegen.dynamics.assembly.newton_double import CLOSE, DoublePose, GaussNewton
from kousoku.codegen.dynamics.assembly.pose import Pose
from kousoku.codegen.dynamics.assembly.residuals import Residuals
from kousoku.codegen.dynamics.assembly.unwrap import wound_as_driven
from kousoku.codegen.dynamics.operations.mechanics import COLUMNS
from kousoku.codegen.dynamics.redundancy.branch import BRANCH_TOLERANCE
from kousoku.codegen.dynamics.redundancy.closure import is_near, near_branch
from kousoku.codegen.dynamics.redundancy.freedom import (
    MOST_SEARCHED_ROWS,
    mobility_of,
    part_residuals,
)
from kousoku.codegen.dynamics.redundancy.loops import loops_of
from kousoku.codegen.dynamics.simplification.outline import outline_of
from kousoku.codegen.dynamics.simplification.planarity import plane_of
from kousoku.model.errors import AssemblyError
from kousoku.model.lowering.held import without_held
from kousoku.model.lowering.parametric import fixed_system
from kousoku.runtime.integrate.settings import CLEARLY

if TYPE_CHECKING:
    from collections.abc import Iterator

    from kousoku.codegen.dynamics.redundancy.loops import LoopPart
    from kousoku.model.mechanics.multibody import System


def with_consistent_start(written: System) -> System:
    """Scene at positions and velocities that its joints and drivers allow.

    Rows that others imply within the closure tolerance need not hold there, if they are redundant
    along the motion, too.

    Parameters
    ----------
    written : System
        A scene as it is written.

    Raises
    ------
    AssemblyError, SceneError
        There are none near; rows are neither redundant nor independent.
    """
    left_out = nearly_implied(written)
    placed: System | None = None
    if left_out:
        with suppress(AssemblyError):
            placed = assemble(written, left_out)
            fixed = without_held(fixed_system(placed))
            if mobility_of(fixed, outline_of(fixed, plane_of(fixed))).closed:
                return placed
    try:
        return assemble(written)
    except AssemblyError:
        if placed is None or not _holds(fixed_system(placed)):
            raise
        return placed


def _holds(system: System) -> bool:
    """Whether all rows hold to the tolerance of positions at which ranks are taken."""
    rows = Residuals.of(system, system.constraints + system.held)
    c, _ = rows.at_start(system.bodies)
    lengths = np.where(rows.in_metres, Metric(system).size, 1.0)
    return bool((np.abs(c) <= BRANCH_TOLERANCE * lengths).all())


def nearly_implied(system: System) -> tuple[tuple[int, int], ...]:
    """Rows that others imply within the closure tolerance, but not to rounding.

    Parameters
    ----------
    system : System
        A scene as it is written.

    Returns
    -------
    tuple of (int, int)
        Indices of constraints and of their rows, among them rows of the same loops that are
        redundant to rounding.
    """
    system = wound_as_driven(fixed_system(system))
    if not (parts := loops_of(system)):
        return ()
    metric = Metric(system)
    system, _ = brought_near(system, metric.size)
    rows = Residuals.of(system, system.constraints + system.held)
    if rows.rows > MOST_ASSEMBLED_ROWS:
        return ()
    damping = system.closure_tolerance**2  # bodies do not move along less stiff directions
    start = DoublePose.of(Pose.of(system.bodies, system.coordinates))
    search = GaussNewton(rows, metric)
    pose = search.solve(start, least=damping)
    bodies = [
        replace(body, r=tuple(r), p=tuple(p))
        for body, r, p in zip(system.bodies, pose.r.tolist(), pose.p.tolist(), strict=False)
    ]
    coordinates = [replace(c, near=x) for c, x in zip(system.coordinates, pose.near, strict=True)]
    system = replace(system, bodies=tuple(bodies), coordinates=tuple(coordinates))
    residual = search.residual(pose)
    is_open = float(residual @ residual) ** 0.5 > CLOSE * metric.size
    return tuple(row for part in parts for row in _nearly_implied_in(system, part, is_open=is_open))


def _nearly_implied_in(
    system: System, part: LoopPart, *, is_open: bool
) -> Iterator[tuple[int, int]]:
    """Nearly implied rows of a part; none where all rows fit and none nearly depends on others."""
    residuals, first = part_residuals(system, part)
    if residuals.rows > MOST_SEARCHED_ROWS:
        return
    rows = [
        (index, row)
        for index in part.instances
        if not system.constraints[index].is_driver
        for row in range(residuals.count(system.constraints[index]))
    ]
    bodies = [system.bodies[k] for k in part.bodies]
    columns = [
        COLUMNS * k + c
        for k, body in enumerate(bodies)
        if k or part.is_grounded
        for c in range(COLUMNS // 2 if body.is_point else COLUMNS)
    ]
    branch = near_branch(
        residuals,
        [first[index] + row for index, row in rows],
        columns,
        bodies=bodies,
        system=system,
    )
    if not (is_open or is_near(branch, bodies)):
        return
    position = next(branch.positions(bodies))
    if float(np.abs(branch.missed(position)).max()) <= CLEARLY * system.closure_tolerance:
        yield from (rows[k] for k in position.factors.left)
