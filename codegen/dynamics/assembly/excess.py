"""More drivers than joints leave free: said first where a scene does not fit together."""

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
"""Joints fit when they are open by less than this part of the size of the system."""

SINGULAR_VALUE_TOLERANCE = 1e-6
"""Rows that differ by less from a sum of others, at joints that fit, depend on them."""


def excess_of_drivers(system: System, pose: Pose) -> str:
    """Message on drivers that are too many, its beginning; empty if they are not.

    The freedoms are those of the joints alone, put together near the positions that are given.

    Parameters
    ----------
    system : System
        A scene in numbers.
    pose : Pose
        Positions near which its joints fit.
    """
    drivers = [one for one in system.constraints if one.is_driver]
    rows = Residuals.of(system, [one for one in system.constraints if not one.is_driver])
    if not drivers or rows.rows > MOST_COUNTED_ROWS:
        return ""
    metric = Metric(system)
    search = GaussNewton(rows, metric)
    place = search.solve(DoublePose.of(pose))
    missing = search.missing(place)
    if float(missing @ missing) ** 0.5 > LARGEST_JOINT_GAP * metric.size:
        return ""
    _, matrix = rows.doubles(place.r, place.p, place.near)
    matrix[:, np.arange(matrix.shape[1]) % COLUMNS > 2] /= metric.size
    matrix /= np.maximum(np.sqrt((matrix * matrix).sum(axis=1, keepdims=True)), 1e-300)
    sizes = np.linalg.svd(matrix, compute_uv=False) if matrix.size else np.zeros(0)
    free = sum(3 if body.is_point else 6 for body in system.bodies)
    free -= int((sizes > SINGULAR_VALUE_TOLERANCE * sizes.max(initial=0.0)).sum())
    counts = [Residuals.of(system, [one]).rows for one in drivers]
    if sum(counts) <= free:
        return ""
    names = [*dict.fromkeys(map(key_of, drivers))]
    what = f"{len(names)} driver{'s' * (len(names) > 1)}"
    if sum(counts) != len(names):
        what += f", which prescribe {sum(counts)} coordinates,"
    degrees = f"{free} degree{'s' * (free != 1)} of freedom"
    return f"{what} for {degrees}, {listed(names)}: leave some out; "
