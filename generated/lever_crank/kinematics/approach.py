"""Approach: from the inputs of the scene, where it is assembled, to those where rows begin."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

from .block_equations import LinkageCoordinates
from .newton import largest
from .status import MOST_TRIES, AnalysisStatus, StopError

if TYPE_CHECKING:
    from .continuation import Continuation
    from .tables import Array


def approach(way: Continuation, residual: float) -> float:
    """Go to where the run begins.

    Whole turns are made with it, for they need not lead back; so many as do are made once.

    Parameters
    ----------
    way : Continuation
        At the inputs of the scene.
    residual : float
        What is left there.

    Returns
    -------
    float
        What is left where it ends, in the unit of the mechanism.

    Raises
    ------
    StopError
        A position on the way is not found.
    """
    run, home = way.run, way.position.x
    to, _ = run.laws_at(0.0)
    far = to[0] - way.position.alpha[0]
    turn = math.copysign(math.tau, far)
    turns = far / turn if len(to) == 1 and run.is_periodic else 0.0
    if turns >= MOST_TRIES:
        raise StopError(AnalysisStatus.TOO_FAR)
    gone, left = 0, int(turns)
    while left:
        residual = _walk(way, way.position.alpha + turn, residual)
        gone, left = gone + 1, left - 1
        if way.is_at(home):
            alpha, x = way.position
            way.position = LinkageCoordinates(alpha + turn * (left - left % gone), x)
            left %= gone
    return _walk_on(way, to, residual)


def _walk_on(way: Continuation, to: Array, residual: float) -> float:
    """Go straight to other inputs, by at most a turn at once, or as much as moves a length as far.

    The shortest steps are a part of that.
    """
    start, span = way.position.alpha, to - way.position.alpha
    pieces = math.ceil(largest(span * way.input_scale / way.newton.length) / math.tau)
    if pieces >= MOST_TRIES:
        raise StopError(AnalysisStatus.TOO_FAR)
    for k in range(1, pieces):
        residual = _walk(way, start + span * (k / pieces), residual)
    return _walk(way, to, residual)


def _walk(way: Continuation, to: Array, residual: float) -> float:
    """Go straight to other inputs, on the branch; return the residual there."""
    span = to - way.position.alpha
    if not span.any():
        return residual
    run, division = way.run, way.division
    # One division, which ends at division 0: these inputs to the last digit.
    inputs = {"origin": to.tolist(), "span": span.tolist(), "turns": [0] * len(to)}
    way.run = replace(run, **inputs, divisions=1, times=None)
    try:
        way.motion_at(0)
        return way.advance(0, residual).residual
    finally:
        way.run, way.division, way.step = run, division, math.inf
