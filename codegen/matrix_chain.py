"""Order in which a product of matrices is multiplied out."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING

from kousoku.symbolic.matrices import mul, transpose
from kousoku.symbolic.sympy_types import SymbolicMatrix

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from kousoku.model.operations.graph import Graph

Cells = tuple[tuple[int, ...], ...]
MatrixFactors = tuple[SymbolicMatrix, ...]
ElementPattern = tuple[
    tuple[int, ...], ...
]  # of each element: 0 zero, 1 plus or minus one, 2 anything


def flip(factors: MatrixFactors) -> tuple[int, MatrixFactors]:
    """Transposed product as a sign and its factors: (X ṽ)ᵀ = −ṽ Xᵀ."""
    sign, flipped = 1, []
    for factor in reversed(factors):
        transposed = transpose(factor)
        if mul(-1, transposed) == factor:  # a skew matrix
            sign, transposed = -sign, factor
        flipped.append(transposed)
    return sign, tuple(flipped)


class Association:
    """Association of products: the cheapest splits, with known zeros and known products."""

    def __init__(self, graph: Graph) -> None:
        self._graph = graph
        self._known: dict[MatrixFactors, Cells] = {}
        self._uses: dict[MatrixFactors, int] = {}

    def expect(self, products: Iterable[MatrixFactors]) -> None:
        """Count the coming products that each partial product is a part of."""
        for factors in products:
            partial_products: dict[MatrixFactors, None] = {}
            for start in range(len(factors)):
                for stop in range(start + 2, len(factors) + 1):
                    partial_products[factors[start:stop]] = None
            for partial in partial_products:
                self._uses[partial] = self._uses.get(partial, 0) + 1
                flipped = flip(partial)[1]
                if flipped != partial:
                    self._uses[flipped] = self._uses.get(flipped, 0) + 1

    def known(self, factors: MatrixFactors) -> Cells | None:
        """Elements of a product that was multiplied out before, or of its transpose."""
        cells = self._known.get(factors)
        if cells is not None:
            return cells
        sign, flipped = flip(factors)
        cells = self._known.get(flipped)
        if cells is None:
            return None
        return tuple(
            tuple(cell if sign > 0 else self._graph.neg(cell) for cell in row)
            for row in zip(*cells, strict=True)
        )

    def keep(self, factors: MatrixFactors, cells: Cells) -> None:
        """Remember a product that is multiplied out."""
        self._known[factors] = cells

    def best(self, factors: MatrixFactors, operands: Sequence[Cells]) -> int:
        """Index of the last multiplication in the cheapest order.

        A partial product costs its operations divided by the number of products that it is a part
        of; a known one costs nothing.
        """
        n = len(factors)
        cost: dict[tuple[int, int], Fraction] = {}
        pattern: dict[tuple[int, int], ElementPattern] = {}
        splits: dict[tuple[int, int], int] = {}
        for k, cells in enumerate(operands):
            cost[k, k + 1], pattern[k, k + 1] = Fraction(0), self._pattern(cells)
        for length in range(2, n + 1):
            for start in range(n - length + 1):
                stop = start + length
                partial = factors[start:stop]
                choices = []
                for middle in range(start + 1, stop):
                    operations, result = _multiply(pattern[start, middle], pattern[middle, stop])
                    total = cost[start, middle] + cost[middle, stop] + operations
                    choices.append((total, middle, result))
                total, splits[start, stop], pattern[start, stop] = min(choices)
                shared = total / max(1, self._uses.get(partial, 1))
                cost[start, stop] = Fraction(0) if self.known(partial) else shared
        return splits[0, n]

    def _pattern(self, cells: Cells) -> ElementPattern:
        def kind(cell: int) -> int:
            value = self._graph.value(cell)
            return 2 if value is None or abs(value) not in {0, 1} else int(abs(value))

        return tuple(tuple(kind(cell) for cell in row) for row in cells)


def _multiply(left: ElementPattern, right: ElementPattern) -> tuple[int, ElementPattern]:
    """Operations of a product, and the pattern of its result."""
    operations, rows = 0, []
    for row in left:
        line = []
        for column in zip(*right, strict=True):
            kinds = [max(a, b) for a, b in zip(row, column, strict=True) if a and b]
            products = sum(a == b == 2 for a, b in zip(row, column, strict=True))
            operations += products + max(0, len(kinds) - 1)
            line.append(0 if not kinds else kinds[0] if len(kinds) == 1 else 2)
        rows.append(tuple(line))
    return operations, tuple(rows)
