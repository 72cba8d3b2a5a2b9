"""Certificate of a step: that the position it leads to is on the branch it came from.

Along a step, s from 0 to 1, coordinates are taken to go by cubics x̂(s): value and two derivatives
as where it began, value as where it ended. The equations of links leave little there, and bounds of
their derivatives are known exactly, so that the theorem of Newton and Kantorovich (Krawczyk's form
of it, with the inverse Jacobian of where the step ended) can tell that in a tube around x̂, at
every s, there is one solution and no singular Jacobian. Its solutions are the way from the one end
to the other; no assembly but the one that was followed is reached by it.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from .status import MOST_TILT

if TYPE_CHECKING:
    from .equations import BlockEquations
    from .mechanism import Array, Block, Curve, Mechanism

#: Of s³ − s⁴ the most in [0, 1]; s³ − s^(3 + m) is at most m times as much.
CUBIC_END = 27 / 256
#: Of s − s² and s − s³ the most in [0, 1].
SQUARE_BOW, CUBIC_BOW = 0.25, 0.385


class Way(NamedTuple):
    """Where coordinates go along a step: x(0) + first s + second s² + third s³, and how nearly.

    Parameters
    ----------
    first, second, third : (places,) array
        Of inputs and, after them, unknowns.
    radius : (places,) array
        How far from there they are at most; found block after block.
    """

    first: Array
    second: Array
    third: Array
    radius: Array


class Certifier:
    """The curved equations of a block.

    Parameters
    ----------
    mechanism : Mechanism
        The tables.
    block : Block
        The block.
    """

    def __init__(self, mechanism: Mechanism, block: Block) -> None:
        inputs, part = len(mechanism.inputs), block.unknowns
        curves = block.curves
        self.own = slice(inputs + part.start, inputs + part.stop)
        self.scale = np.array([unknown.scale for unknown in mechanism.unknowns[part]])
        self._row = np.array([curve.row for curve in curves])
        self._length = np.array([curve.length for curve in curves])
        self._is_arm = np.array([curve.is_arm for curve in curves])
        self._x, self._y, self._angle = _slopes(curves, inputs + len(mechanism.unknowns))

    def gain(self, block: BlockEquations) -> float:
        """Return the most that residuals of 1 move unknowns, as lengths."""
        inverse = block.solve(np.eye(len(self.scale)))
        return _most(np.abs(inverse * self.scale[:, np.newaxis]).sum(axis=1))

    def tilt(self, block: BlockEquations, way: Way, residual: float) -> float:
        """Return how far the Jacobian turns in the tube, relative to itself; write its radius.

        Parameters
        ----------
        block : BlockEquations
            With the factors of where the step ended.
        way : Way
            The step; the radii of what is known are there, those of the block get theirs.
        residual : float
            What is left of the equations at both ends.
        """
        n, length, own = len(self.scale), self._length, self.own
        (ax, bx, cx), (ay, by, cy) = ([rates @ x for rates in way[:3]] for x in (self._x, self._y))
        a, b, c = (rates @ self._angle for rates in way[:3])
        swept = np.abs(a + b + c) + SQUARE_BOW * np.abs(b) + CUBIC_BOW * np.abs(c)
        a, b, c = np.abs(a), np.abs(b), np.abs(c)
        known = way.radius.copy()
        known[own] = 0.0
        off = np.hypot(known @ np.abs(self._x), known @ np.abs(self._y))
        size = 1.0 / self.scale
        reach = np.hypot(size @ np.abs(self._x[own]), size @ np.abs(self._y[own]))
        swing = size @ np.abs(self._angle[own])
        # Distances: (|d|² − l²)/2l is a polynomial of s, whose s³ to s⁶ vanish together at s = 1.
        fourth = np.abs(bx * bx + by * by + 2 * (ax * cx + ay * cy))
        fifth, sixth = np.abs(2 * (bx * cx + by * cy)), cx * cx + cy * cy
        left = 0.5 * CUBIC_END * (fourth + 2 * fifth + 3 * sixth) / length
        bow = SQUARE_BOW * np.hypot(bx, by) + CUBIC_BOW * np.hypot(cx, cy) + off
        # Arms: d − l (cos β, sin β), by the fourth derivative of the direction.
        rate, bend, jerk = a + 2 * b + 3 * c, 2 * b + 6 * c, 6 * c
        fourth = rate**4 + 6 * rate * rate * bend + 3 * bend * bend + 4 * rate * jerk
        arm = length * fourth * (CUBIC_END / 24) + off + length * (known @ np.abs(self._angle))
        distance = left + off * (1 + (left + off) / length)
        error = np.where(self._is_arm, arm, distance)
        turn = np.where(self._is_arm, length * swing * swept, bow * reach / length)
        more = np.where(self._is_arm, length * swing * swing, reach * reach / length)
        ends = np.where(self._is_arm, 0.0, 1.0 / length)
        chord = (self._x[own] * (ax + bx + cx) + self._y[own] * (ay + by + cy)) * ends
        slope = np.zeros((n, n))
        np.add.at(slope, self._row, chord.T)
        sides = np.full((n, 3), residual) * (1.0, 0.0, 0.0)
        np.add.at(sides, self._row, np.stack((error, turn, more), axis=1))
        inverse = np.abs(block.solve(np.eye(n))) * self.scale[:, np.newaxis]
        sums = inverse @ sides
        turned = np.abs(block.solve(slope)) * self.scale[:, np.newaxis] * size
        error_most = _most(sums[:, 0])
        tilt = _most(turned.sum(axis=1) + sums[:, 1])
        tilt += _most(sums[:, 2]) * error_most / (1.0 - MOST_TILT)
        way.radius[own] = error_most / (1.0 - tilt) * size
        return tilt if math.isfinite(tilt) else math.inf


def _slopes(curves: tuple[Curve, ...], places: int) -> tuple[Array, Array, Array]:
    """Return x and y of the links, and their angles, by the coordinates: (places, curves) each."""
    x, y, angle = (np.zeros((places, len(curves))) for _ in range(3))
    for k, curve in enumerate(curves):
        for place, factor in curve.x:
            x[place, k] += factor
        for place, factor in curve.y:
            y[place, k] += factor
        for place, factor in curve.angle:
            angle[place, k] += factor
    return x, y, angle


def _most(values: Array) -> float:
    """Return the largest of sizes; NaN where one is."""
    return float(np.max(values))
