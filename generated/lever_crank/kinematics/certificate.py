"""Certificate of a step: that the position it leads to is on the branch it came from.

Along a step, s from 0 to 1, coordinates are taken to go by cubics x̂(s): value and two derivatives
as where it began, value as where it ended. The equations of links leave little there, and bounds of
their derivatives are known exactly, so that the theorem of Newton and Kantorovich (Krawczyk's form
of it, with the inverse Jacobian of where the step ended) can tell that in a tube around x̂, at
every s, there is one solution and no singular Jacobian. Its solutions are the way from the one end
to the other; no assembly but the one that was followed is reached by it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from .status import MOST_TILT

if TYPE_CHECKING:
    from collections.abc import Sequence

    from .block_equations import BlockEquations
    from .tables import Array, Block, LinkageTables

#: Of s³ − s⁴ the most in [0, 1]; s³ − s^(3 + m) is at most m times as much.
CUBIC_END = 27 / 256
#: Of s − s² and s − s³ the most in [0, 1].
SQUARE_BOW, CUBIC_BOW = 0.25, 0.385


class CubicTube(NamedTuple):
    """Tube around coordinates along a step, x(0) + first s + second s² + third s³.

    Parameters
    ----------
    first, second, third : (places,) array
        Of inputs and, after them, unknowns, in their units.
    radius : (places,) array
        How far from there they are at most, in their units; found block after block.
    """

    first: Array
    second: Array
    third: Array
    radius: Array


class Certifier:
    """The curved equations of a block.

    Parameters
    ----------
    mechanism : LinkageTables
        The tables.
    block : Block
        The block.
    """

    def __init__(self, mechanism: LinkageTables, block: Block) -> None:
        inputs, part, curves = len(mechanism.inputs), block.unknowns, block.curves
        places = inputs + len(mechanism.unknowns)
        self._unknowns = slice(inputs + part.start, inputs + part.stop)
        self._scale = np.array([unknown.scale for unknown in mechanism.unknowns[part]])
        self._row = [curve.row for curve in curves]
        self._length = np.array([curve.length for curve in curves])
        self._is_arm = np.array([curve.is_arm for curve in curves])
        self._x = _slopes([curve.x for curve in curves], places)
        self._y = _slopes([curve.y for curve in curves], places)
        self._angle = _slopes([curve.angle for curve in curves], places)

    def condition(self, block: BlockEquations) -> float:
        """Largest motion of an unknown by residuals of 1 [-], as lengths, with factors at hand.

        That is maxᵢ Σⱼ |scaleᵢ (D⁻¹)ᵢⱼ|, the norm ‖·‖∞ of D⁻¹ with unknowns as lengths.
        """
        return float(np.max(self._inverse(block).sum(axis=1)))

    def _inverse(self, block: BlockEquations) -> Array:
        inverse = block.solve(np.eye(len(self._scale)))
        lengths: Array = np.abs(inverse) * self._scale[:, np.newaxis]
        return lengths

    def tilt(self, block: BlockEquations, tube: CubicTube, residual: float) -> float:
        """Turn of the Jacobian in the tube, relative to itself; its radius is written.

        Parameters
        ----------
        block : BlockEquations
            With the factors of where the step ended.
        tube : CubicTube
            The step; the radii of what is known are there, those of the block get theirs.
        residual : float
            What is left of the equations at both ends, in the unit of the mechanism.
        """
        n, scale = len(self._scale), self._scale
        distance, slope = self._distances(tube)
        bends = np.where(self._is_arm, self._arms(tube), distance)
        rows, change = np.zeros((n, 3)), np.zeros((n, n))
        rows[:, 0] = residual
        np.add.at(rows, self._row, bends.T)
        np.add.at(change, self._row, np.where(self._is_arm, 0.0, slope).T)
        sums = self._inverse(block) @ rows
        sums[:, 1] += (np.abs(block.solve(change)) * scale[:, np.newaxis] / scale).sum(axis=1)
        error, turn, more = map(float, np.max(sums, axis=0))
        tilt = turn + more * error / (1.0 - MOST_TILT)
        tube.radius[self._unknowns] = error / (1.0 - tilt) / scale
        return tilt

    def _along(self, tube: CubicTube, slopes: Array) -> tuple[Array, ...]:
        """Sums of coordinates along a step, (curves,) each.

        Returns
        -------
        first, second, third, off, reach : (curves,) array
            Coefficients, how far the sum is off by what is known, and how far unknowns of the
            block move it that are off by a length of 1.
        """
        known, size = tube.radius.copy(), np.abs(slopes)
        known[self._unknowns] = 0.0
        return (
            *(rates @ slopes for rates in tube[:3]),
            known @ size,
            1 / self._scale @ size[self._unknowns],
        )

    def _distances(self, tube: CubicTube) -> tuple[Array, Array]:
        """Bends and slope of equations |d| = l.

        As (|d|² - l²)/2l, which is a polynomial of s: what it has of s³ to s⁶ vanishes together at
        the end.

        Returns
        -------
        bends : (3, curves) array
            What the cubics leave, how the Jacobian turns beyond its turning from one end to the
            other, and how much more for each length that unknowns are off, at most.
        slope : (n, curves) array
            How the Jacobian turns from one end to the other.
        """
        (ax, bx, cx, *x), (ay, by, cy, *y) = self._along(tube, self._x), self._along(tube, self._y)
        off, reach = np.hypot(x, y)
        fourth = np.abs(bx * bx + by * by + 2 * (ax * cx + ay * cy))
        fifth, sixth = np.abs(2 * (bx * cx + by * cy)), cx * cx + cy * cy
        residual = 0.5 * CUBIC_END * (fourth + 2 * fifth + 3 * sixth) / self._length
        bow = SQUARE_BOW * np.hypot(bx, by) + CUBIC_BOW * np.hypot(cx, cy) + off
        error = residual + off * (1 + (residual + off) / self._length)
        slope = self._x[self._unknowns] * (ax + bx + cx) + self._y[self._unknowns] * (ay + by + cy)
        bends = np.stack((error, bow * reach / self._length, reach * reach / self._length))
        return bends, slope / self._length

    def _arms(self, tube: CubicTube) -> Array:
        """Bends of equations d = l (cos β, sin β), (3, curves).

        By the fourth derivative of the direction.
        """
        a, b, c, turned_off, reach = self._along(tube, self._angle)
        swept = np.abs(a + b + c) + SQUARE_BOW * np.abs(b) + CUBIC_BOW * np.abs(c)
        a, b, c = np.abs(a), np.abs(b), np.abs(c)
        rate, bend, jerk = a + 2 * b + 3 * c, 2 * b + 6 * c, 6 * c
        fourth = (rate * rate) ** 2 + 6 * rate * rate * bend + 3 * bend * bend + 4 * rate * jerk
        off = np.hypot(self._along(tube, self._x)[3], self._along(tube, self._y)[3])
        error = self._length * (fourth * (CUBIC_END / 24) + turned_off) + off
        return np.stack((error, self._length * reach * swept, self._length * reach * reach))


def _slopes(sums: list[Sequence[tuple[int, float]]], places: int) -> Array:
    """Derivatives of sums by coordinates, (places, sums)."""
    slopes = np.zeros((places, len(sums)))
    for k, terms in enumerate(sums):
        for place, factor in terms:
            slopes[place, k] += factor
    return slopes
