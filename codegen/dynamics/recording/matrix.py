"""Small matrices of nodes, in which an operation is written while it is traced."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from kousoku.model.operations.graph import Graph

    Binary = Callable[[int, int], int]


@dataclass(frozen=True, slots=True)
class Matrix:
    """A matrix of nodes of one graph. Zeros and ones fold when it is used.

    Parameters
    ----------
    graph : Graph
        Where the nodes are.
    rows : tuple of tuple of int
        The nodes, row by row.
    width : int
        Count of columns: there may be no row.
    """

    graph: Graph
    rows: tuple[tuple[int, ...], ...]
    width: int

    @classmethod
    def of(cls, graph: Graph, nodes: Iterable[int], width: int = 1) -> Matrix:
        """Matrix of nodes row by row, one column unless it is wider."""
        return cls(graph, tuple(zip(*[iter(nodes)] * width, strict=True)), width)

    @property
    def flat(self) -> tuple[int, ...]:
        """All nodes, row by row."""
        return tuple(node for row in self.rows for node in row)

    @property
    def T(self) -> Matrix:
        """The transpose."""
        rows = tuple(tuple(row[k] for row in self.rows) for k in range(self.width))
        return Matrix(self.graph, rows, len(self.rows))

    def columns(self, kept: Sequence[int]) -> Matrix:
        """Matrix of some of the columns."""
        return Matrix(
            self.graph, tuple(tuple(row[k] for k in kept) for row in self.rows), len(kept)
        )

    def select(self, kept: Sequence[int]) -> Matrix:
        """Matrix of some of the rows."""
        return Matrix(self.graph, tuple(self.rows[k] for k in kept), self.width)

    def __matmul__(self, other: Matrix) -> Matrix:
        graph, columns = self.graph, other.T.rows
        rows = tuple(
            tuple(
                graph.sum(graph.mul(a, b) for a, b in zip(row, column, strict=True))
                for column in columns
            )
            for row in self.rows
        )
        return Matrix(graph, rows, other.width)

    def __add__(self, other: Matrix) -> Matrix:
        return self._entrywise(other, self.graph.add)

    def __sub__(self, other: Matrix) -> Matrix:
        return self._entrywise(other, self.graph.sub)

    def __neg__(self) -> Matrix:
        rows = tuple(tuple(self.graph.neg(a) for a in row) for row in self.rows)
        return Matrix(self.graph, rows, self.width)

    def cross(self, other: Matrix) -> Matrix:
        """Vector product self × other (3, 1) of columns (3, 1) in one frame; its unit is a·b's."""
        graph, a, b = self.graph, self.flat, other.flat
        nodes = []
        for k in range(3):
            m, n = (k + 1) % 3, (k + 2) % 3
            nodes.append(graph.sub(graph.mul(a[m], b[n]), graph.mul(a[n], b[m])))
        return Matrix.of(graph, nodes)

    def scaled(self, factors: Matrix) -> Matrix:
        """Product self · diag(factors); the factors are one row."""
        mul, diagonal = self.graph.mul, factors.flat
        rows = tuple(
            tuple(mul(a, d) for a, d in zip(row, diagonal, strict=True)) for row in self.rows
        )
        return Matrix(self.graph, rows, self.width)

    def _entrywise(self, other: Matrix, apply: Binary) -> Matrix:
        rows = tuple(
            tuple(apply(a, b) for a, b in zip(row, other_row, strict=True))
            for row, other_row in zip(self.rows, other.rows, strict=True)
        )
        return Matrix(self.graph, rows, self.width)


def stack(graph: Graph, parts: Iterable[Matrix], width: int) -> Matrix:
    """Matrix of the rows of all parts, one below the other."""
    return Matrix(graph, tuple(row for part in parts for row in part.rows), width)


def square(lower: Sequence[Sequence[int]], graph: Graph) -> Matrix:
    """Symmetric matrix with the given lower triangle."""
    n = len(lower)
    rows = tuple(tuple(lower[max(i, j)][min(i, j)] for j in range(n)) for i in range(n))
    return Matrix(graph, rows, n)
