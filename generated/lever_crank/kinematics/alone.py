"""Results by name, for a folder that is copied to where kousoku is not installed."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from .rows import METHODS
from .solve import solve
from .status import Status

if TYPE_CHECKING:
    from collections.abc import Sequence

    import numpy.typing as npt

    from .equations import Kernels
    from .mechanism import Array, Mechanism
    from .rows import Run


@dataclass(frozen=True, slots=True)
class Trajectory:
    """Motion of a mechanism, in its unit of length, radians and seconds.

    Parameters
    ----------
    unit, method : str
        The unit of length, and how positions were found.
    alpha : (rows,) or (rows, inputs) array
        The inputs.
    positions, velocities, accelerations : dict of str to (rows, 2) array
        Of each node, in frame O; empty where not wanted.
    angles : dict of str to (rows,) array
        Of each link from +x, where they are wanted.
    iterations : (rows,) array of int
        Corrections in the step that led to each row.
    residual_max : float
        Largest residual.
    time : (rows,) array, optional
        Where the inputs were followed in time.
    """

    unit: str
    method: str
    alpha: Array
    positions: dict[str, Array]
    velocities: dict[str, Array]
    accelerations: dict[str, Array]
    angles: dict[str, Array]
    iterations: npt.NDArray[np.intc]
    residual_max: float
    time: Array | None


def solve_alone(mechanism: Mechanism, kernels: Kernels, run: Run) -> Trajectory:
    """Return the motion that is asked for.

    Raises
    ------
    ArithmeticError
        The mechanism cannot be assembled, or not be moved on.
    """
    rows = solve(mechanism, kernels, run)
    inputs = [given.name for given in mechanism.inputs]
    if rows.status != Status.GOOD:
        block = mechanism.blocks[rows.block]
        names = [unknown.name for unknown in mechanism.unknowns[block.unknowns]]
        raise ArithmeticError(
            f"{Status(rows.status).message}: {', '.join(names)} held by {', '.join(block.links)}, "
            f"at {', '.join(inputs)} = {rows.reached.tolist()}"
        )
    wanted = {"positions", *mechanism.outputs}

    def by_node(motion: Array, kind: str) -> dict[str, Array]:
        return {node: motion[:, k] for k, node in enumerate(mechanism.nodes) if kind in wanted}

    angles = zip(mechanism.links, rows.angle.T, strict=False)  # no angles where none are wanted
    return Trajectory(
        unit=mechanism.unit,
        method=METHODS[run.method],
        alpha=rows.alpha[:, 0] if len(inputs) == 1 else rows.alpha,
        positions=by_node(rows.position, "positions"),
        velocities=by_node(rows.velocity, "velocities"),
        accelerations=by_node(rows.acceleration, "accelerations"),
        angles={link.name: angle for link, angle in angles},
        iterations=rows.iterations,
        residual_max=float(rows.residual.max()),
        time=run.times,
    )


def simulate_alone(
    mechanism: Mechanism,
    kernels: Kernels,
    run: Run,
    end: float | None,
    *,
    times: Sequence[float] | Array | None = None,
    samples: int = 1001,
) -> Trajectory:
    """Return the motion in time: at given times, or at samples from 0 to an end [s].

    Raises
    ------
    ArithmeticError
        The mechanism cannot be assembled, or not be moved on.
    ValueError
        There is an end, and there are times; or neither.
    """
    if (end is None) == (times is None):
        raise ValueError("give either end or times")
    chosen = np.array(times if end is None else np.linspace(0.0, end, samples), float)
    return solve_alone(mechanism, kernels, replace(run, times=chosen, rows=len(chosen)))
