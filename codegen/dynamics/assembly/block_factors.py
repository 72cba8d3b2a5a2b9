"""Factors of S = A Aᵀ with a sparse A, by blocks of joints: linear time for chains."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from kousoku.codegen.dynamics.operations.elimination_order import minimum_degree
from kousoku.codegen.dynamics.operations.mechanics import COLUMNS

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.codegen.dynamics.assembly.jacobian import Indices
    from kousoku.codegen.dynamics.assembly.residuals import Residuals
    from kousoku.model.numbers.real import Array

#: Rows are independent where no pivot is below this part of the largest element.
REGULAR = 1e-9


class Pattern:
    """Blocks of rows, pairs of them that share a body, and the order in which they are eliminated.

    Parameters
    ----------
    rows : Residuals
        Joint by joint.
    """

    def __init__(self, rows: Residuals) -> None:
        keys = [(c.joint, c.bodies) for c in rows.constraints]
        starts = [k for k in range(len(keys)) if k == 0 or keys[k] != keys[k - 1]]
        #: The first row of each block, and the count of rows at the end.
        self.first = [*(rows.first[k] for k in starts), rows.rows]
        self.sizes = np.diff(self.first)
        self.block_of = np.repeat(np.arange(len(starts)), self.sizes)
        self.bodies = rows.columns // COLUMNS
        touching: list[list[int]] = [[] for _ in range(self.bodies)]
        for block, (start, end) in enumerate(pairwise([*starts, len(keys)])):
            connected = dict.fromkeys(b for c in rows.constraints[start:end] for b in c.bodies)
            for body in connected:
                if body >= 0:
                    touching[body].append(block)
        #: For each body the blocks that have columns of it.
        self.touching = touching
        pairs = dict.fromkeys(
            (a, b) for blocks in touching for k, b in enumerate(blocks) for a in blocks[:k]
        )
        self.order = minimum_degree(len(starts), pairs)


class BlockFactors:
    """L D Lᵀ of A Aᵀ + damping (m, m).

    Parameters
    ----------
    pattern : Pattern
        Of the rows.
    elements : (rows, columns, values)
        A, by its elements; duplicates are summed.
    damping : float
        Added to the diagonal, as a part of its largest element.
    left_out : sequence of int
        Rows without elements, which get a diagonal element of their own.
    """

    def __init__(
        self,
        pattern: Pattern,
        elements: tuple[Indices, Indices, Array],
        damping: float = 0.0,
        left_out: Sequence[int] = (),
    ) -> None:
        self._pattern = pattern
        diagonal, below = _products(pattern, elements)
        self._largest = max(
            (float(block.diagonal().max(initial=0.0)) for block in diagonal), default=0
        )
        for row in left_out:
            k = int(pattern.block_of[row])
            index = row - pattern.first[k]
            diagonal[k][index, index] = self._largest
        self._inverses: dict[int, Array] = {}
        self._panels: dict[int, list[tuple[int, Array]]] = {}
        self._smallest = np.inf
        for block in diagonal:
            block[np.diag_indices_from(block)] += damping * self._largest
        for pivot in pattern.order:
            k = pivot.joint
            self._inverses[k] = self._inverted(diagonal[k])
            blocks = [(a, below.pop((a, k), None)) for a in pivot.neighbours]
            below_pivot = [(a, block) for a, block in blocks if block is not None]
            panels = [(a, block @ self._inverses[k]) for a, block in below_pivot]
            self._panels[k] = panels
            for i, (a, panel) in enumerate(panels):
                diagonal[a] -= panel @ below_pivot[i][1].T
                for b, block in below_pivot[i + 1 :]:
                    # b is eliminated after a
                    below[b, a] = below.get((b, a), 0.0) - block @ panel.T

    @property
    def is_regular(self) -> bool:
        """Whether no row depends on others, as far as the pivots tell."""
        return self._smallest > REGULAR * self._largest

    def solve(self, right: Array) -> Array:
        """Solution x (m,) of (A Aᵀ + damping) x = right."""
        first = self._pattern.first
        x = [right[a:b].copy() for a, b in pairwise(first)]
        for pivot in self._pattern.order:
            for a, panel in self._panels[pivot.joint]:
                x[a] -= panel @ x[pivot.joint]
        for pivot in reversed(self._pattern.order):
            k = pivot.joint
            x[k] = self._inverses[k] @ x[k]
            for a, panel in self._panels[k]:
                x[k] -= panel.T @ x[a]
        return np.concatenate(x) if x else right

    def _inverted(self, block: Array) -> Array:
        values, vectors = np.linalg.eigh(block)
        self._smallest = min(self._smallest, float(values[0]))
        values = np.where(values > 0, values, np.inf)
        inverse: Array = (vectors / values) @ vectors.T
        return inverse


def _products(
    pattern: Pattern, elements: tuple[Indices, Indices, Array]
) -> tuple[list[Array], dict[tuple[int, int], Array]]:
    """Blocks of A Aᵀ on the diagonal, and those below it by (later, earlier)."""
    rows, columns, values = elements
    order = {pivot.joint: k for k, pivot in enumerate(pattern.order)}
    index = {
        (block, body): k
        for k, (block, body) in enumerate(
            (block, body) for body, touching in enumerate(pattern.touching) for block in touching
        )
    }
    widest = int(pattern.sizes.max(initial=0))
    dense = np.zeros((len(index), widest, COLUMNS))
    blocks, bodies = pattern.block_of[rows], columns // COLUMNS
    slots = np.array(
        [index[a, b] for a, b in zip(blocks.tolist(), bodies.tolist(), strict=True)], int
    )
    np.add.at(dense, (slots, rows - np.array(pattern.first)[blocks], columns % COLUMNS), values)
    diagonal = [np.zeros((size, size)) for size in pattern.sizes.tolist()]
    below: dict[tuple[int, int], Array] = {}
    for body, touching in enumerate(pattern.touching):
        blocks_of = [(a, dense[index[a, body], : pattern.sizes[a]]) for a in touching]
        for k, (a, block_a) in enumerate(blocks_of):
            diagonal[a] += block_a @ block_a.T
            for b, block_b in blocks_of[:k]:
                (first, x), (last, y) = sorted(
                    ((a, block_a), (b, block_b)), key=lambda pair: order[pair[0]]
                )
                below[last, first] = below.get((last, first), 0.0) + y @ x.T
    return diagonal, below
