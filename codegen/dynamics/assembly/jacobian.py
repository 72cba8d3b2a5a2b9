"""C_q of a whole system in 50 digits, before there is a program."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from kousoku.model import precise

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.model.precise import High

    Array = np.ndarray[Any, np.dtype[np.float64]]
    Places = np.ndarray[Any, np.dtype[np.int64]]


class Jacobian:
    """C_q of a system in 50 digits, by its elements that are not zero.

    Parameters
    ----------
    elements : sequence of (int, int, number)
        Row, column (six for each body) and value; those of one place are added.
    shape : (int, int)
        Rows and columns.
    """

    def __init__(self, elements: Sequence[tuple[int, int, High]], shape: tuple[int, int]) -> None:
        self._elements = elements
        self._shape = shape

    def elements(self) -> tuple[Places, Places, Array]:
        """Return rows, columns and values of the elements in doubles; those of one place add up."""
        rows = np.array([row for row, _, _ in self._elements], int)
        columns = np.array([column for _, column, _ in self._elements], int)
        return rows, columns, np.array([float(value) for _, _, value in self._elements])

    def dense(self) -> Array:
        """Return the matrix in doubles."""
        matrix = np.zeros(self._shape)
        rows, columns, values = self.elements()
        np.add.at(matrix, (rows, columns), values)
        return matrix

    def times(self, v: Sequence[High]) -> list[High]:
        """Return C_q v."""
        product = [precise.ZERO[0]] * self._shape[0]
        for row, column, value in self._elements:
            product[row] += value * v[column]
        return product

    def transposed_times(self, lam: Sequence[High]) -> list[High]:
        """Return C_qᵀ λ."""
        product = [precise.ZERO[0]] * self._shape[1]
        for row, column, value in self._elements:
            product[column] += value * lam[row]
        return product
