"""C_q of a whole system in 50 digits, before a program is composed."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from kousoku.codegen.dynamics.assembly.pose import rates_of_turn
from kousoku.codegen.dynamics.operations.mechanics import COLUMNS
from kousoku.model.numbers import precise

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.model.numbers.precise import High
    from kousoku.model.numbers.real import Array

    Indices = np.ndarray[Any, np.dtype[np.int64]]


class PreciseJacobian:
    """C_q of a system in 50 digits, by its elements that are not zero: δC = C_q (δr, δθ′).

    δr [m] is in frame O, δθ′ [rad] in the principal frame of each body.

    Parameters
    ----------
    elements : sequence of (int, int, number)
        Row, column (six for each body) and value; duplicates are summed.
    shape : (int, int)
        Rows and columns.
    """

    def __init__(self, elements: Sequence[tuple[int, int, High]], shape: tuple[int, int]) -> None:
        self._elements = elements
        self._shape = shape

    def elements(self) -> tuple[Indices, Indices, Array]:
        """Rows, columns and values (n,) of the elements in doubles; duplicates are to be summed."""
        rows = np.array([row for row, _, _ in self._elements], int)
        columns = np.array([column for _, column, _ in self._elements], int)
        return rows, columns, np.array([float(value) for _, _, value in self._elements])

    def of_displacement(self, d: Sequence[High]) -> PreciseJacobian:
        """Derivative C_d = C_q T (m, n) by a displacement d so far, its turns rotation vectors.

        δθ′ = T dw, by :func:`~kousoku.codegen.dynamics.assembly.pose.rates_of_turn`.
        """
        turns = range(3, len(d), COLUMNS)
        rates = {k: rates_of_turn((d[k], d[k + 1], d[k + 2])) for k in turns}
        elements: list[tuple[int, int, High]] = []
        for row, column, value in self._elements:
            axis = column % COLUMNS - 3
            if axis < 0:
                elements.append((row, column, value))
                continue
            first = column - axis
            row_of_t = enumerate(rates[first][axis])
            elements += ((row, first + k, value * rate) for k, rate in row_of_t)
        return PreciseJacobian(elements, self._shape)

    def dense(self) -> Array:
        """Matrix (m, n) in doubles."""
        matrix = np.zeros(self._shape)
        rows, columns, values = self.elements()
        np.add.at(matrix, (rows, columns), values)
        return matrix

    def times(self, v: Sequence[High]) -> list[High]:
        """C_q v (m,)."""
        product = [precise.ZERO[0]] * self._shape[0]
        for row, column, value in self._elements:
            product[row] += value * v[column]
        return product

    def transposed_times(self, lam: Sequence[High]) -> list[High]:
        """Forces C_qᵀ λ (n,) [N, N m]."""
        product = [precise.ZERO[0]] * self._shape[1]
        for row, column, value in self._elements:
            product[column] += value * lam[row]
        return product
