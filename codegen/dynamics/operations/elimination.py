"""Operations of the block LDLᵀ of the Schur complement; zeros of the structure fold.

A joint that is eliminated has the pivot block L D Lᵀ. For each neighbour n, Y_n = S_n L⁻ᵀ and
X_n = Y_n D⁻¹; the block of two neighbours m and n loses Y_m X_nᵀ.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.recording.matrix import Matrix, square

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.codegen.dynamics.recording.traces import Trace


def _factorise(pivot: Matrix) -> tuple[Matrix, Matrix]:
    """Factor L, unit lower, and the diagonal of D⁻¹ as one row."""
    graph, n = pivot.graph, len(pivot.rows)
    inverse: list[int] = []
    scaled: list[list[int]] = []
    lower: list[list[int]] = []
    for i, row in enumerate(pivot.rows):
        y = _solve_row(row[:i], lower, pivot)
        x = [graph.mul(a, d) for a, d in zip(y, inverse, strict=True)]
        products = graph.sum(graph.mul(a, b) for a, b in zip(y, x, strict=True))
        inverse.append(graph.div(graph.const(1), graph.sub(row[i], products)))
        scaled.append(y)
        lower.append([*x, graph.const(1)])
    full = tuple((*row, *(graph.const(0),) * (n - len(row))) for row in lower)
    return Matrix(graph, full, n), Matrix(graph, (tuple(inverse),), n)


def _solve_row(row: Sequence[int], lower: Sequence[Sequence[int]], like: Matrix) -> list[int]:
    """Solution y of y Lᵀ = row."""
    graph = like.graph
    y: list[int] = []
    for j, value in enumerate(row):
        products = graph.sum(graph.mul(a, b) for a, b in zip(y, lower[j], strict=False))
        y.append(graph.sub(value, products))
    return y


def _panel(coupling: Matrix, lower: Matrix) -> Matrix:
    """Panel Y of a neighbour."""
    rows = tuple(tuple(_solve_row(row, lower.rows, coupling)) for row in coupling.rows)
    return Matrix(coupling.graph, rows, coupling.width)


def _updated(diagonal: Matrix, y: Matrix, x: Matrix) -> Matrix:
    """Diagonal − y xᵀ, which is symmetric: half of it is computed."""
    graph = diagonal.graph
    lower = [
        [
            graph.sub(
                diagonal.rows[i][j],
                graph.sum(graph.mul(a, b) for a, b in zip(y.rows[i], x.rows[j], strict=True)),
            )
            for j in range(i + 1)
        ]
        for i in range(len(diagonal.rows))
    ]
    return square(lower, graph)


@dataclass(frozen=True, slots=True)
class Eliminate:
    """Factors L D Lᵀ of a pivot, which is eliminated from its neighbours: S_mn − Y_m X_nᵀ.

    Blocks: the pivot (n, n); for each neighbour its block (m, n) beside the pivot; for each pair of
    neighbours, (0, 0), (1, 0), (1, 1), (2, 0) …, its block (m, m).

    Parameters
    ----------
    neighbours : int
        How many there are.
    """

    neighbours: int

    @property
    def title(self) -> str:
        """Say how many neighbours there are."""
        return f"eliminate {self.neighbours}"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """L (n, n), D⁻¹ (1, n), X = Y D⁻¹ (m, n) of each neighbour, and the blocks of the pairs."""
        pivot, *others = blocks
        lower, inverse = _factorise(pivot)
        y = [_panel(block, lower) for block in others[: self.neighbours]]
        x = [block.scaled(inverse) for block in y]
        pairs = [(m, n) for m in range(self.neighbours) for n in range(m + 1)]
        updated = [
            _updated(block, y[m], x[n]) if m == n else block - y[m] @ x[n].T
            for (m, n), block in zip(pairs, others[self.neighbours :], strict=True)
        ]
        return lower, inverse, *x, *updated


@dataclass(frozen=True, slots=True)
class Panel:
    """Panel of one neighbour of a pivot. Blocks: L, D⁻¹, the block S (m, n) beside the pivot."""

    title: str = "eliminate, neighbour"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Panels Y = S L⁻ᵀ and X = Y D⁻¹, (m, n)."""
        lower, inverse, coupling = blocks
        y = _panel(coupling, lower)
        return y, y.scaled(inverse)


@dataclass(frozen=True, slots=True)
class Update:
    """Block of two neighbours with their pivot eliminated. Blocks: S_mn, Y_m, X_n.

    Parameters
    ----------
    is_diagonal : bool
        Whether the neighbours are the same.
    """

    is_diagonal: bool
    title: str = "eliminate, pair"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Block S_mn − Y_m X_nᵀ (m, n)."""
        block, y, x = blocks
        return (_updated(block, y, x) if self.is_diagonal else block - y @ x.T,)


@dataclass(frozen=True, slots=True)
class Couple:
    """Coupling of two joints that share a body. Blocks: sum of other bodies, C_q M⁻¹, C_q.

    C_q (n, c) has the columns δr in frame O, δθ′ in the principal frame of that body.
    """

    title: str = "couple"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Block + C_q M⁻¹ C_qᵀ (m, n) of the Schur complement S = C_q M⁻¹ C_qᵀ."""
        block, scaled, jacobian = blocks
        return (block + scaled @ jacobian.T,)


@dataclass(frozen=True, slots=True)
class Gather:
    """Vector minus products. Blocks: the vector (n,), then matrix and vector of each product."""

    title: str = "gather"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Vector − Σ matrix · other (n,)."""
        total, *products = blocks
        for matrix, vector in zip(products[::2], products[1::2], strict=True):
            total -= matrix @ vector
        return (total,)


@dataclass(frozen=True, slots=True)
class Forward:
    """Forward substitution at a pivot. Blocks: L, D⁻¹, right-hand side, and products to subtract.

    It gives D⁻¹ L⁻¹ (b − Σ X z), z = L⁻¹ (…) being gathered by later pivots.
    """

    title: str = "forward"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Solutions z and D⁻¹ z, (n,)."""
        lower, inverse, *rest = blocks
        (total,) = Gather()(trace, *rest)
        graph = trace.graph
        z = _solve_row(total.flat, lower.rows, total)
        return Matrix.of(graph, z), Matrix.of(graph, map(graph.mul, z, inverse.flat))


@dataclass(frozen=True, slots=True)
class Backward:
    """Backward substitution at a pivot. Blocks: L, D⁻¹ z, and products to subtract."""

    title: str = "backward"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Solution λ = L⁻ᵀ (D⁻¹ z − Σ Xᵀ λ), (n,)."""
        lower, *rest = blocks
        (total,) = Gather()(trace, *rest)
        graph, upper = trace.graph, lower.T.rows
        solution: list[int] = []
        for k in reversed(range(len(upper))):
            products = graph.sum(graph.mul(upper[k][-1 - m], x) for m, x in enumerate(solution))
            solution.append(graph.sub(total.flat[k], products))
        return (Matrix.of(graph, reversed(solution)),)
