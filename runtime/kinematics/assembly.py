"""Assembly: the first position, from the approximate one of the scene."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from .newton import largest
from .status import SETTLED, SINGULAR, SMALLEST_STEP, Status, StopError

if TYPE_CHECKING:
    from .equations import Coordinates
    from .mechanism import Array
    from .newton import Newton


def assemble(newton: Newton, position: Coordinates) -> float:
    """Find the first position by damped Newton, block after block, in ``position.x``.

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
    for number, block in enumerate(newton.blocks):
        newton.at = number
        given, size = _approach(newton, number, position)
        try:
            _, residual = newton.solve_block(number, *position)
        except StopError as stop:
            if stop.status != Status.DEAD_CENTRE:
                raise
            near = size <= SETTLED * newton.length
            raise StopError(Status.ON_DEAD_CENTRE if near else Status.NOT_ASSEMBLED) from None
        _, pivot = block.evaluate(position)
        newton.orientation[number] = pivot
        worst = max(worst, residual)
        if abs(given) > 0.01 and given * pivot < 0:
            raise StopError(Status.OTHER_SIDE)
    return worst


def _approach(newton: Newton, number: int, position: Coordinates) -> tuple[float, float]:
    """Come near the first position of a block.

    Returns
    -------
    given : float
        The smallest pivot where the scene places the block.
    residual : float
        The largest residual that is left.
    """
    block = newton.blocks[number]
    epsilon, pivot = block.evaluate(position)
    given, residual = pivot, largest(epsilon)
    for k in range(200):
        if residual <= SETTLED * newton.length:
            break
        if not math.isfinite(residual):
            raise StopError(Status.NOT_FINITE)
        if not abs(pivot) > SINGULAR:
            raise StopError(Status.NOT_ASSEMBLED if k else Status.ON_DEAD_CENTRE)
        _damped_step(newton, number, position, epsilon)
        epsilon, pivot = block.evaluate(position)
        residual = largest(epsilon)
    return given, residual


def _damped_step(newton: Newton, number: int, position: Coordinates, epsilon: Array) -> None:
    """Move a block by a Newton step, halved until the residual falls enough."""
    block = newton.blocks[number]
    correction, residual = block.solve(epsilon), largest(epsilon)
    before, part = position.x[block.part].copy(), 1.0
    while part >= SMALLEST_STEP:
        position.x[block.part] = before - part * correction
        if largest(block.residuals(position)) <= (1 - 0.25 * part) * residual:
            return
        part *= 0.5
    raise StopError(Status.NOT_ASSEMBLED)
