"""Ranks of matrices, dependences of their rows, and rows that can be left out.

Everything here is sums and products of doubles in an order fixed here: no library that may add up
in another order decides which rows a solver keeps. Of rows that are equally good up to rounding the
first is taken.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.model.numbers.real import Array

#: Largest remainder of a row that depends on others, as a part of the largest row: rows are looked
#: at where they hold to 1e-11, and elimination in a large part costs three digits.
DEPENDENT_REMAINDER = 1e-8
#: Least component by which a row takes part in the unit vector of a dependence: ten times its
#: rounding.
TAKES_PART = 1e-7
#: Rows whose squared norms differ by less are equally good: rounding shall not choose among them.
EQUAL = 1e-6


@dataclass(frozen=True, slots=True)
class LQFactors:
    """Factors A = L Q of the rows taken, and the remaining rows in the basis Q.

    Parameters
    ----------
    taken, left : tuple of int
        Independent rows in the order in which they were taken, and the remaining rows.
    lower : (rank, rank)
        L.
    basis : (columns, rank)
        Qᵀ: the space of the rows.
    dependent : (rows − rank, rank)
        The remaining rows in this basis.
    """

    taken: tuple[int, ...]
    left: tuple[int, ...]
    lower: Array
    basis: Array
    dependent: Array

    @property
    def rank(self) -> int:
        """Count of independent rows."""
        return len(self.taken)

    @property
    def pivots(self) -> Array:
        """Diagonal of L (rank,): the norm of the remainder of each row when it was taken."""
        diagonal: Array = np.diagonal(self.lower)
        return diagonal

    def least_change(self, wanted: Array) -> Array:
        """Minimum-norm x = Qᵀ L⁻¹ b (columns,) with A x = b, the rows taken of wanted (rows,)."""
        right = wanted[list(self.taken)].copy()
        for k in range(self.rank):
            right[k] /= self.lower[k, k]
            right[k + 1 :] -= self.lower[k + 1 :, k] * right[k]
        return _combined(self.basis.T, right)

    def null_part(self, x: Array) -> Array:
        """Part (I − QᵀQ) x (columns,) of x that changes no row."""
        for _ in range(2):
            x = x - _combined(self.basis.T, _combined(self.basis, x))
        return x

    def combinations(self) -> Array:
        """Matrix B (rows − rank, rank) with left rows = B · taken rows."""
        combined = self.dependent.copy()
        for k in reversed(range(self.rank)):
            combined[:, k] /= self.lower[k, k]
            combined[:, :k] -= combined[:, k : k + 1] * self.lower[k, :k]
        return combined

    def dependences(self) -> Array:
        """Orthonormal basis (rows − rank, rows), row by row, of the y with yᵀA = 0."""
        count = len(self.left)
        rows = np.zeros((count, self.rank + count))
        rows[:, list(self.taken)] = -self.combinations()
        rows[range(count), list(self.left)] = 1.0
        return factorise(rows).basis.T if count else rows


def factorise(matrix: Array, least: float | None = None, most: int | None = None) -> LQFactors:
    """LQ factors of a matrix by the modified method of Gram and Schmidt, with pivoting of rows.

    The largest row is taken again and again, and removed from all others.

    Parameters
    ----------
    matrix : (rows, columns)
        A.
    least : float, optional
        Largest remainder of dependent rows; relative to the largest row unless given.
    most : int, optional
        Count of rows at most that are taken.
    """
    remainders = np.ascontiguousarray(matrix.T)
    columns, rows = remainders.shape
    most = columns if most is None else min(columns, most)
    coefficients, basis = np.zeros((rows, 0)), np.zeros((columns, 0))
    largest = 0.0
    taken: list[int] = []
    columns_of_l: list[Array] = []
    directions: list[Array] = []
    while True:
        squares = (remainders * remainders).sum(axis=0) if columns else np.zeros(rows)
        best = float(squares.max(initial=0.0))
        size = best**0.5
        largest = largest or size
        limit = DEPENDENT_REMAINDER * largest if least is None else least
        if size <= limit or len(taken) == most:
            break
        row = int(np.argmax(squares >= (1 - EQUAL) * best))
        size = float(squares[row]) ** 0.5
        direction = remainders[:, row] / size
        components = _combined(remainders, direction)
        remainders -= direction[:, None] * components
        remainders[:, row] = 0.0
        taken.append(row)
        columns_of_l.append(components)
        directions.append(direction)
    if taken:
        coefficients, basis = np.array(columns_of_l).T, np.array(directions).T
    left = tuple(sorted(set(range(rows)).difference(taken)))
    lower = np.tril(coefficients[taken])
    return LQFactors(tuple(taken), left, lower, basis, coefficients[list(left)])


def rows_to_leave(dependences: Sequence[Array]) -> tuple[tuple[int, ...], float]:
    """Rows that can be left out at all positions, and the smallest pivot in leaving them out.

    Parameters
    ----------
    dependences : sequence of (count, rows)
        Orthonormal bases of the y with yᵀ C_q = 0, one for each position. Rows can be left out
        where their columns of these bases are far from singular.

    Returns
    -------
    tuple of int
        As many rows as there are dependences, in increasing order.
    float
        The smallest pivot: 1 is best, 0 means that the remaining rows lose rank somewhere.
    """
    bases = list(dependences)
    chosen: list[int] = []
    worst = 1.0
    for _ in range(len(bases[0])):
        squares = np.min([(basis * basis).sum(axis=0) for basis in bases], axis=0)
        squares[chosen] = -1.0
        best = float(squares.max())
        row = int(np.argmax(squares >= (1 - EQUAL) * best))
        worst = min(worst, max(best, 0.0) ** 0.5)
        chosen.append(row)
        bases = [_without(basis, row) for basis in bases]
    return tuple(sorted(chosen)), worst


def _without(basis: Array, row: int) -> Array:
    """Basis with the direction of one of its columns removed from all of them."""
    column = basis[:, row]
    size = float((column * column).sum()) ** 0.5
    if not size:
        return basis
    column = column / size
    projected: Array = basis - column[:, None] * _combined(basis, column)
    return projected


def damped_change(matrix: Array, wanted: Array, damping: float) -> Array:
    """Damped minimum-norm change Aᵀ (A Aᵀ + damping I)⁻¹ b (columns,) of b = wanted (rows,)."""
    rows = len(matrix)
    square = np.zeros((rows, rows))
    for column in matrix.T:
        square += column[:, None] * column
    square[range(rows), range(rows)] += damping
    right = wanted.copy()
    for k in range(rows):
        below = square[k + 1 :, k] / square[k, k]
        square[k + 1 :, k + 1 :] -= below[:, None] * square[k, k + 1 :]
        right[k + 1 :] -= below * right[k]
    for k in reversed(range(rows)):
        right[k] /= square[k, k]
        right[:k] -= square[:k, k] * right[k]
    return _combined(matrix, right)


def _combined(rows: Array, factors: Array) -> Array:
    """Sum of rows times factors, Aᵀ x (columns,), added up in an order fixed here."""
    total: Array = (rows * factors[:, None]).sum(axis=0)
    return total
