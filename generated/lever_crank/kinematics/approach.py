"""Approach: from the inputs of the scene, where it is assembled, to those of the first row."""

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


def approach(path: Continuation, residual: float) -> float:
    """Go to where the run begins.

    Whole turns are made with it, for they need not lead back; so many as do are made once.

    Parameters
    ----------
    path : Continuation
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
    run, home = path.run, path.position.x
    target, _ = run.laws_at(0.0)
    distance = target[0] - path.position.alpha[0]
    turn = math.copysign(math.tau, distance)
    turns = distance / turn if len(target) == 1 and run.is_periodic else 0.0
    if turns >= MOST_TRIES:
        raise StopError(AnalysisStatus.TOO_FAR)
    made, remaining = 0, int(turns)
    while remaining:
        residual = _walk(path, path.position.alpha + turn, residual)
        made, remaining = made + 1, remaining - 1
        if path.is_at(home):
            alpha, x = path.position
            path.position = LinkageCoordinates(alpha + turn * (remaining - remaining % made), x)
            remaining %= made
    return _walk_on(path, target, residual)


def _walk_on(path: Continuation, target: Array, residual: float) -> float:
    """Go straight to other inputs, in pieces of at most a turn, or of what moves a length as far.

    The shortest steps are a part of a piece.
    """
    start, span = path.position.alpha, target - path.position.alpha
    pieces = math.ceil(largest(span * path.input_scale / path.newton.length) / math.tau)
    if pieces >= MOST_TRIES:
        raise StopError(AnalysisStatus.TOO_FAR)
    for k in range(1, pieces):
        residual = _walk(path, start + span * (k / pieces), residual)
    return _walk(path, target, residual)


def _walk(path: Continuation, target: Array, residual: float) -> float:
    """Go straight to other inputs, on the branch; return the residual there."""
    span = target - path.position.alpha
    if not span.any():
        return residual
    run, division = path.run, path.division
    # One division, which ends at division 0: these inputs to the last digit.
    inputs = {"origin": target.tolist(), "span": span.tolist(), "turns": [0] * len(target)}
    path.run = replace(run, **inputs, divisions=1, times=None)
    try:
        path.motion_at(0)
        return path.advance(0, residual).residual
    finally:
        path.run, path.division, path.step = run, division, math.inf
