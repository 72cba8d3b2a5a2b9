"""Assembly: the position of the scene, from its approximate one."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from .newton import largest
from .status import SETTLED, SINGULAR, SMALLEST_STEP, AnalysisStatus, StopError

if TYPE_CHECKING:
    from .block_equations import LinkageCoordinates
    from .newton import Newton
    from .tables import Array


def assemble(newton: Newton, position: LinkageCoordinates) -> float:
    """Find the position of the scene by damped Newton, block after block, in ``position.x``.

    Returns
    -------
    float
        The largest residual, in the unit of the mechanism.

    Raises
    ------
    StopError
        The mechanism does not fit together, or only on the other side of a dead centre.
    """
    worst = 0.0
    newton.equations.place(position)
    try:
        for number in range(len(newton.blocks)):
            newton.at = number
            worst = max(worst, _assemble_block(newton, number))
    finally:
        position.x[:] = newton.equations.region("x")
    return worst


def _assemble_block(newton: Newton, number: int) -> float:
    """Find the position of a block, and its assembly mode; return the largest residual."""
    block = newton.blocks[number]
    first_pivot, size = _damped_newton(newton, number)
    try:
        _, residual = newton.iterate(number)
    except StopError as stop:
        if stop.status != AnalysisStatus.DEAD_CENTRE:
            raise
        is_near = size <= SETTLED * newton.length
        raise StopError(
            AnalysisStatus.ON_DEAD_CENTRE if is_near else AnalysisStatus.NOT_ASSEMBLED
        ) from None
    _, pivot = block.evaluate()
    newton.orientation[number] = pivot
    if abs(first_pivot) > 0.01 and first_pivot * pivot < 0:
        raise StopError(AnalysisStatus.OTHER_SIDE)
    return residual


def _damped_newton(newton: Newton, number: int) -> tuple[float, float]:
    """Damped Newton iteration towards the position of a block.

    Returns
    -------
    first_pivot : float
        The smallest pivot where the scene places the block.
    residual : float
        The largest residual that is left.
    """
    block = newton.blocks[number]
    epsilon, pivot = block.evaluate()
    first_pivot, residual = pivot, largest(epsilon)
    for k in range(200):
        if residual <= SETTLED * newton.length:
            break
        if not math.isfinite(residual):
            raise StopError(AnalysisStatus.NOT_FINITE)
        if not abs(pivot) > SINGULAR:
            raise StopError(AnalysisStatus.NOT_ASSEMBLED if k else AnalysisStatus.ON_DEAD_CENTRE)
        _damped_step(newton, number, epsilon)
        epsilon, pivot = block.evaluate()
        residual = largest(epsilon)
    return first_pivot, residual


def _damped_step(newton: Newton, number: int, epsilon: Array) -> None:
    """Move a block by a Newton step, halved until the residual falls enough."""
    block = newton.blocks[number]
    correction, residual = block.solve(epsilon), largest(epsilon)
    before, part = block.x.copy(), 1.0
    while part >= SMALLEST_STEP:
        block.x[:] = before - part * correction
        if largest(block.residuals()) <= (1 - 0.25 * part) * residual:
            return
        part *= 0.5
    raise StopError(AnalysisStatus.NOT_ASSEMBLED)
