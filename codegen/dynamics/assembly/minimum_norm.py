"""Minimum-norm displacements for given changes of rows, also where rows depend on each other."""

from __future__ import annotations

from copy import copy
from typing import TYPE_CHECKING

import numpy as np

from kousoku.codegen.dynamics.assembly.block_factors import BlockFactors, Pattern
from kousoku.codegen.dynamics.operations.characteristic_length import extent
from kousoku.codegen.dynamics.operations.mechanics import COLUMNS, lengths_of
from kousoku.model.errors import AssemblyError
from kousoku.model.numbers import precise
from kousoku.runtime.integrate.assembled_start import THIN

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.codegen.dynamics.assembly.jacobian import PreciseJacobian
    from kousoku.codegen.dynamics.assembly.residuals import Residuals
    from kousoku.model.mechanics.multibody import Instance, MovingBody, RelativeCoordinate, System
    from kousoku.model.numbers.precise import High
    from kousoku.model.numbers.real import Array

SQUARED_RANK_TOLERANCE = 1e-11
"""Square of a relative singular value of C_q, in lengths, up to which rows depend on others: S has
these squares, and in doubles the smaller ones are rounding of the largest."""

MOST_DENSE_ROWS = 2000
"""Rows at most that may depend on each other: S is dense then."""

PASSES = 6
"""Passes of iterative refinement; each adds five digits at least."""

ENOUGH = 1e-35
"""Residual after the passes, as a part of the wanted change."""

THINNEST = 1e-12
"""Least moment of inertia in the weights of velocities, as a part of the largest of the body: as in
a run, moments count as they are."""


class Metric:
    """Weights of a displacement d = (δr, δθ′): masses and moments, relative to the system's.

    W (n,) is m/m̄ [-] of δr [m] in frame O, I/m̄ [m²] of δθ′ [rad] in the principal frame, m̄ the
    mean mass.

    Parameters
    ----------
    system : System
        Its bodies give the masses, its constraints the length that compares metres with radians.
    thin : float
        Least moment of inertia, as a part of the largest of the body.
    """

    def __init__(self, system: System, thin: float = THIN) -> None:
        masses = [body.mass for body in system.bodies if body.mass > 0]
        mass = sum(masses) / len(masses) if masses else 1.0
        #: A length of the system [m].
        self.size = _size(system)
        weights = [
            value / mass
            for body in system.bodies
            for value in _weights(body, mass, self.size, thin)
        ]
        #: Diagonal of W⁻¹ in 50 digits, per column.
        self.inverse = [1 / precise.number(weight) for weight in weights]

    def norm(self, step: Sequence[High]) -> High:
        """Norm √(dᵀ W d), a length [m]."""
        terms = (x * x / w for x, w in zip(step, self.inverse, strict=True))
        return precise.sqrt(sum(terms, precise.ZERO[0]))

    def lengths(self, residuals: Residuals) -> list[High]:
        """Factors (m,) that make rows lengths, one for each: 1, or the size [m] for an angle.

        Rows that combine coordinates count by the largest of their ratios.
        """
        sizes = np.where(residuals.in_metres, 1.0, self.size) / residuals.ratios(self.size)
        return [precise.number(x) for x in sizes.tolist()]


def _weights(body: MovingBody, mass: float, size: float, thin: float) -> list[float]:
    """Six weights of a body; masses and moments that it lacks are taken from the system."""
    m = body.mass if body.mass > 0 else mass
    largest = max(body.inertia) or m * size**2 / 10
    return [m] * 3 + [max(moment, thin * largest) for moment in body.inertia]


def _size(system: System) -> float:
    """Largest distance of a joint from a centre of mass, or between two points."""
    lengths: list[tuple[float, ...]] = []
    terms = dict.fromkeys(term.coordinate for c in system.constraints for term in c.terms)
    sources: list[Instance | RelativeCoordinate] = [*system.constraints]
    for source in (*sources, *(system.coordinates[k] for k in terms)):
        bodies = {"i": source.i, "j": source.j}
        lengths += [values for end, values in lengths_of(source) if bodies.get(end, 0) >= 0]
    return max((abs(x) for values in lengths for x in values), default=0.0) or extent(system)


class MinimumNormSolver:
    """S = C_q W⁻¹ C_qᵀ (m, m) in doubles, and its solutions of least norm d = W⁻¹ C_qᵀ λ.

    d (n,) is δr [m] in frame O and δθ′ [rad] in the principal frame of each body.

    Parameters
    ----------
    jacobian : PreciseJacobian
        C_q.
    metric : Metric
        W.
    rows : Residuals
        The rows.

    Raises
    ------
    AssemblyError
        Rows depend on each other, and they are too many for a dense solution.
    """

    def __init__(self, jacobian: PreciseJacobian, metric: Metric, rows: Residuals) -> None:
        self._factors = np.array([float(x) for x in metric.lengths(rows)])
        self._roots = np.sqrt(np.array([float(x) for x in metric.inverse]))
        self._jacobian, self._metric = jacobian, metric
        at, columns, values = jacobian.elements()
        scaled = values * self._factors[at] * self._roots[columns]
        self._blocks = BlockFactors(Pattern(rows), (at, columns, scaled))
        self._eigenpairs: tuple[Array, Array] | None = None

    def with_jacobian(self, jacobian: PreciseJacobian) -> MinimumNormSolver:
        """Solver for a C_q that is nearly the same: each pass adds fewer digits."""
        other = copy(self)
        other._jacobian = jacobian
        return other

    def step(self, wanted: Sequence[High], damping: float) -> list[High]:
        """Displacement d (n,) that changes the rows about as wanted, damped."""
        return self._displacement(self._multipliers(wanted, damping))

    def displacement(self, wanted: Sequence[High]) -> list[High]:
        """Minimum-norm d (n,) with C_q d = wanted, in 50 digits as far as the rows allow it."""
        lam = [precise.ZERO[0]] * len(wanted)
        d, residual = self._displacement(lam), wanted
        tolerance = ENOUGH * max(map(abs, wanted), default=0)
        for _ in range(PASSES):
            if max(map(abs, residual), default=0) <= tolerance:
                break
            lam = [x + y for x, y in zip(lam, self._multipliers(residual), strict=True)]
            d = self._displacement(lam)
            reached = self._jacobian.times(d)
            residual = [x - y for x, y in zip(wanted, reached, strict=True)]
        return d

    def _multipliers(self, wanted: Sequence[High], damping: float = 0.0) -> list[High]:
        """Minimum-norm λ with S λ = wanted, or damped by a part of the largest S."""
        right = self._factors * np.array([float(x) for x in wanted])
        if self._blocks.is_regular and not damping:
            solution = self._blocks.solve(right)
        else:
            values, vectors = self._eigen()
            solution = vectors @ (vectors.T @ right / (values + damping * values.max(initial=0.0)))
        return [precise.number(x) for x in (self._factors * solution).tolist()]

    def _eigen(self) -> tuple[Array, Array]:
        """Eigenvalues of S, the largest first, and vectors: those of independent rows.

        Rows depend on each other whatever the masses are: their rank is taken in lengths alone.
        Singular values of C_q W^{-1/2} have the digits that S, with their squares, has lost.
        """
        if len(self._factors) > MOST_DENSE_ROWS:
            raise AssemblyError(
                f"{len(self._factors)} rows are put together, and some depend on others; at most"
                f" {MOST_DENSE_ROWS} can: give positions and velocities that fit, or leave out"
                " joints that repeat others"
            )
        if self._eigenpairs is None:
            rows = self._factors[:, None] * self._jacobian.dense()
            lengths = np.tile([1.0] * 3 + [self._metric.size] * 3, len(self._roots) // COLUMNS)
            vectors, sizes, _ = np.linalg.svd(rows / lengths, full_matrices=False)
            basis = vectors[:, sizes**2 > SQUARED_RANK_TOLERANCE * sizes.max(initial=0.0) ** 2]
            left, sizes, _ = np.linalg.svd(basis.T @ (rows * self._roots), full_matrices=False)
            self._eigenpairs = sizes**2, basis @ left
        return self._eigenpairs

    def _displacement(self, lam: Sequence[High]) -> list[High]:
        """Displacement W⁻¹ C_qᵀ λ."""
        products = self._jacobian.transposed_times(lam)
        return [w * x for w, x in zip(self._metric.inverse, products, strict=True)]
