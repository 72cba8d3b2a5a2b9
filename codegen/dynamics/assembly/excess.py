"""Drivers in excess of the degrees of freedom: the first remark where a scene does not fit."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from kousoku.codegen.dynamics.assembly.minimum_norm import Metric
from kousoku.codegen.dynamics.assembly.newton_double import DoublePose, GaussNewton
from kousoku.codegen.dynamics.assembly.residuals import Residuals
from kousoku.codegen.dynamics.assembly.violations import key_of
from kousoku.codegen.dynamics.operations.mechanics import COLUMNS
from kousoku.runtime.messages import listed

if TYPE_CHECKING:
    from kousoku.codegen.dynamics.assembly.pose import Pose
    from kousoku.model.mechanics.multibody import System

MOST_COUNTED_ROWS = 1000
"""Rows of the largest system whose freedoms are counted here."""

LARGEST_JOINT_GAP = 1e-9
"""Violation of joints that fit, as a part of the size of the system."""

SINGULAR_VALUE_TOLERANCE = 1e-6
"""Relative singular value up to which rows, at joints that fit, depend on each other."""


def excess_of_drivers(system: System, pose: Pose) -> str:
    """Beginning of a message on drivers in excess; empty if there are none.

    Degrees of freedom are those of the joints alone, assembled near the given positions.

    Parameters
    ----------
    system : System
        A scene in numbers.
    pose : Pose
        Positions near which its joints fit.
    """
    drivers = [c for c in system.constraints if c.is_driver]
    rows = Residuals.of(system, [c for c in system.constraints if not c.is_driver])
    if not drivers or rows.rows > MOST_COUNTED_ROWS:
        return ""
    metric = Metric(system)
    search = GaussNewton(rows, metric)
    assembled = search.solve(DoublePose.of(pose))
    residual = search.residual(assembled)
    if float(residual @ residual) ** 0.5 > LARGEST_JOINT_GAP * metric.size:
        return ""
    _, matrix = rows.doubles(assembled.r, assembled.p, assembled.near)
    matrix[:, np.arange(matrix.shape[1]) % COLUMNS > 2] /= metric.size
    matrix /= np.maximum(np.sqrt((matrix * matrix).sum(axis=1, keepdims=True)), 1e-300)
    values = np.linalg.svd(matrix, compute_uv=False) if matrix.size else np.zeros(0)
    free = sum(3 if body.is_point else 6 for body in system.bodies)
    free -= int((values > SINGULAR_VALUE_TOLERANCE * values.max(initial=0.0)).sum())
    counts = [Residuals.of(system, [driver]).rows for driver in drivers]
    if sum(counts) <= free:
        return ""
    names = [*dict.fromkeys(map(key_of, drivers))]
    summary = f"{len(names)} driver{'s' * (len(names) > 1)}"
    if sum(counts) != len(names):
        summary += f", which prescribe {sum(counts)} coordinates,"
    degrees = f"{free} degree{'s' * (free != 1)} of freedom"
    return f"{summary} for {degrees}, {listed(names)}: leave some out; "
