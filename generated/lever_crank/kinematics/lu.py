"""LU factorisation P A = L U with row exchanges."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from .tables import Array


class LU:
    """LU factors of a Jacobian.

    Written out, not LAPACK's: the pivots tell how far the block is from a dead centre, and on
    which side.

    Parameters
    ----------
    matrix : (n, n) array
        The Jacobian; it is overwritten.
    scale : (n,) array
        The length that a change of each unknown by 1 moves.

    Attributes
    ----------
    pivot : float
        The smallest pivot, of columns scaled to lengths, with the sign of the determinant: 0 is a
        dead centre, the sign is the side of it.
    """

    def __init__(self, matrix: Array, scale: Array) -> None:
        n = len(matrix)
        side, weakest = 1.0, math.inf
        self.matrix = matrix
        self.order = np.arange(n)
        self.pivot = 0.0
        for k in range(n):
            best = k + int(np.argmax(np.abs(matrix[k:, k])))
            if best != k:
                matrix[[k, best]] = matrix[[best, k]]
                self.order[[k, best]] = self.order[[best, k]]
                side = -side
            size = abs(float(matrix[k, k])) / float(scale[k])
            if not size > 0:
                return
            side = -side if matrix[k, k] < 0 else side
            weakest = min(weakest, size)
            matrix[k + 1 :, k] /= matrix[k, k]
            matrix[k + 1 :, k + 1 :] -= np.outer(matrix[k + 1 :, k], matrix[k, k + 1 :])
        self.pivot = side * weakest

    def solve(self, right: Array) -> Array:
        """Solution A⁻¹ right (n,) or (n, m), of right-hand sides in columns, in any units.

        Forward with L, then backward with U; ``right`` stays what it is.
        """
        b = right[self.order]
        n = len(b)
        for i in range(1, n):
            b[i] -= self.matrix[i, :i] @ b[:i]
        for i in reversed(range(n)):
            b[i] = (b[i] - self.matrix[i, i + 1 :] @ b[i + 1 :]) / self.matrix[i, i]
        return b
