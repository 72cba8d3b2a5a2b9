"""Positions at which rows hold, to the digits of doubles: where the search in 50 digits starts.

All bodies are moved at once, and all instances of a kind are evaluated at once. The search in 50
digits forgets how a position was found here.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from kousoku.codegen.dynamics.assembly.block_factors import BlockFactors, Pattern
from kousoku.codegen.dynamics.assembly.fixed_points import AndersonAcceleration
from kousoku.codegen.dynamics.assembly.pose import Pose, normalised
from kousoku.codegen.dynamics.operations.mechanics import COLUMNS
from kousoku.model.numbers import precise
from kousoku.model.numbers.precise import IDENTITY, ZERO
from kousoku.runtime.integrate.euler_parameters import composed

if TYPE_CHECKING:
    from kousoku.codegen.dynamics.assembly.jacobian import Indices
    from kousoku.codegen.dynamics.assembly.minimum_norm import Metric
    from kousoku.codegen.dynamics.assembly.residuals import Residuals
    from kousoku.model.numbers.real import Array

FIRST_DAMPING, LEAST_DAMPING = 1e-3, 1e-12
"""Damping of the first step, and the least one, which is as good as none."""

SLOW, PATIENCE = 0.9, 15
"""Part of the residual that a slow step leaves at least, and slow steps at most in a row."""

LARGEST_TURN = 0.5
"""The largest turn of a body in one step, about each axis, in radians: its sine, which rows are
linear in, still is the angle to 4 %."""

CLOSE = 1e-12
"""Residual, as a part of the size of the system, at which the search in doubles ends."""

MOST_DOUBLE_STEPS = 60
"""Most steps on the way to the nearest positions."""

HOPELESS = 1e3
"""A step of so many sizes of the system means divergence."""

SMALL_TURN = 1e-3
"""Below it 1/6 stands for (|w| − sin|w|)/|w|³: with |w|² that is right to 10⁻¹⁴."""

DIFFERENCE, RIGHT = 1e-6, 1e-5
"""Displacement by which the step is differentiated, and relative tolerance of the result."""


@dataclass(frozen=True, slots=True)
class DoublePose:
    """Positions of all bodies in doubles, the ground last, as of a pose: points are at r + A(p) s′.

    Parameters
    ----------
    r, p : (bodies + 1, 3) [m] and (bodies + 1, 4)
        Centres of mass in frame O and Euler parameters of the principal frames; p of norm one.
    near : (coordinates,)
        Coordinates that angles are counted from, to within half a turn.
    """

    r: Array
    p: Array
    near: Array

    @classmethod
    def of(cls, pose: Pose) -> DoublePose:
        """Pose in doubles."""
        r, p = (np.array([[float(x) for x in v] for v in vectors]) for vectors in (pose.r, pose.p))
        return cls(r, p, np.array([float(x) for x in pose.near]))

    def pose(self) -> Pose:
        """Pose in 50 digits."""
        r = [precise.triple(values) for values in self.r[:-1].tolist()]
        p = [normalised(values) for values in self.p[:-1].tolist()]
        near = tuple(precise.number(x) for x in self.near.tolist())
        return Pose((*r, ZERO), (*p, IDENTITY), near)

    def moved(self, step: Array) -> DoublePose:
        """Positions after a displacement (δr, δθ′) of each body: p ∘ (cos θ/2, δθ′ sin(θ/2)/θ)."""
        by_body = step.reshape(-1, COLUMNS)
        r, p = self.r.copy(), self.p.copy()
        r[:-1] += by_body[:, :3]
        half = by_body[:, 3:] / 2
        size = np.sqrt((half * half).sum(axis=1, keepdims=True))
        turn = np.hstack((np.cos(size), half * np.sinc(size / np.pi)))
        moved = composed(p[:-1].T, turn.T).T
        p[:-1] = moved / np.sqrt((moved * moved).sum(axis=1, keepdims=True))
        return DoublePose(r, p, self.near)

    def since(self, start: DoublePose) -> Array:
        """Displacement (δr, δθ′) (6 bodies,) from ``start`` to here; p̄ ∘ p is the turn by δθ′."""
        back = start.p[:-1] * (1.0, -1.0, -1.0, -1.0)
        relative = composed(back.T, self.p[:-1].T).T
        relative = np.where(relative[:, :1] < 0, -relative, relative)
        sine = np.sqrt((relative[:, 1:] ** 2).sum(axis=1, keepdims=True))
        angle = 2 * np.arctan2(sine, relative[:, :1])
        turn = relative[:, 1:] * np.where(sine > 0, angle / np.where(sine > 0, sine, 1.0), 2.0)
        return np.hstack((self.r[:-1] - start.r[:-1], turn)).ravel()


class GaussNewton:
    """Steps of least norm towards positions at which rows have wanted values, C + C_q d = wanted.

    d (n,) is δr [m] in frame O and δθ′ [rad] in the principal frame of each body.

    Parameters
    ----------
    rows : Residuals
        All rows.
    metric : Metric
        Weights of displacements.
    """

    def __init__(self, rows: Residuals, metric: Metric) -> None:
        self._rows, self._size, self._pattern = rows, metric.size, Pattern(rows)
        self._lengths = np.where(rows.in_metres, 1.0, metric.size) / rows.ratios(metric.size)
        self._roots = np.sqrt(np.array([float(x) for x in metric.inverse]))

    def residual(self, pose: DoublePose, wanted: Array | float = 0.0) -> Array:
        """Residual wanted − C (m,), as lengths [m]."""
        residual: Array = wanted - self._rows.residuals(pose.r, pose.p, pose.near)
        return residual * self._lengths

    def solve(
        self,
        pose: DoublePose,
        wanted: Array | float = 0.0,
        until: float = CLOSE,
        least: float = LEAST_DAMPING,
    ) -> DoublePose:
        """Positions near a pose at which rows have wanted values, or as nearly as possible.

        Gauss-Newton steps of least norm, damped while they overshoot (Levenberg and Marquardt),
        because rows may depend on each other.
        """
        damping, slow = FIRST_DAMPING, 0
        residual = self.residual(pose, wanted)
        size = _norm(residual)
        while size > until * self._size and slow < PATIENCE:
            moved = pose.moved(_shortened(self._step(pose, residual, damping)))
            moved_residual = self.residual(moved, wanted)
            moved_size = _norm(moved_residual)
            slow = slow + 1 if not moved_size <= SLOW * size else 0
            if not moved_size < size:
                damping = max(10 * damping, least)
                continue
            pose, residual, size = self._counted(moved), moved_residual, moved_size
            damping = max(damping / 100, least)
        return pose

    def project_nearest(self, start: DoublePose, pose: DoublePose) -> DoublePose | None:
        """Positions nearest to ``start`` on the branch of a pose that fits.

        None where d ← W⁻¹ C_dᵀ λ with S λ = C_d d − C does not settle, C_d = C_q ∂q/∂d.
        """
        moved, d = pose, pose.since(start)
        accelerated = AndersonAcceleration(1 / self._roots)
        for _ in range(MOST_DOUBLE_STEPS):
            nearest = self._projected(moved, d)
            size = self._weighted_norm(nearest - d)
            if size <= CLOSE * self._size:
                return moved
            if not size < HOPELESS * self._size:
                return None
            d = accelerated.next(d, nearest)
            moved = self._counted(DoublePose(start.r, start.p, moved.near).moved(d))
        return None

    def implicit_correction(self, start: DoublePose, pose: DoublePose, change: Array) -> Array:
        """Correction of d that solves x = change + g′ x, where one more step would be ``change``.

        g′ is the derivative of the step g, a difference of doubles: some digits of x are right, and
        the caller goes on from there.
        """
        d = pose.since(start)
        projected = self._projected(pose, d)
        size = self._weighted_norm(change)
        scale = DIFFERENCE * self._size / (size or 1.0)
        accelerated = AndersonAcceleration(1 / self._roots)
        x = change
        for _ in range(MOST_DOUBLE_STEPS):
            moved = DoublePose(start.r, start.p, pose.near).moved(d + scale * x)
            value = change + (self._projected(moved, d + scale * x) - projected) / scale
            error = self._weighted_norm(value - x)
            if error <= RIGHT * size or not error < HOPELESS * size:
                break
            x = accelerated.next(x, value)
        return x

    def _projected(self, pose: DoublePose, d: Array) -> Array:
        """Step g(d) = W⁻¹ C_dᵀ λ with S λ = C_d d − C."""
        c, rows, columns, values = self._rows.elements(pose.r, pose.p, pose.near)
        rows, columns, values = _of_displacement(rows, columns, values, d)
        rates = np.bincount(rows, values * d[columns], self._rows.rows)
        residual = (rates - c) * self._lengths
        return self._minimum_norm((rows, columns, values), residual, LEAST_DAMPING)

    def _weighted_norm(self, change: Array) -> float:
        return _norm(change / self._roots)

    def _counted(self, pose: DoublePose) -> DoublePose:
        return DoublePose(pose.r, pose.p, self._rows.angles(pose.r, pose.p, pose.near))

    def _step(self, pose: DoublePose, residual: Array, damping: float) -> Array:
        """Displacement that changes the rows, as lengths, about as wanted, damped."""
        _, rows, columns, values = self._rows.elements(pose.r, pose.p, pose.near)
        return self._minimum_norm((rows, columns, values), residual, damping)

    def _minimum_norm(
        self, elements: tuple[Indices, Indices, Array], residual: Array, damping: float
    ) -> Array:
        """Minimum-norm displacement for a Jacobian by its rows, columns and values."""
        rows, columns, values = elements
        scaled = values * self._lengths[rows] * self._roots[columns]
        factors = BlockFactors(self._pattern, (rows, columns, scaled), damping)
        multipliers = factors.solve(residual)
        size = len(self._roots)
        step: Array = self._roots * np.bincount(columns, scaled * multipliers[rows], size)
        return step


def _of_displacement(
    rows: Indices, columns: Indices, values: Array, d: Array
) -> tuple[Indices, Indices, Array]:
    """Elements of the derivative by a displacement, from those of the Jacobian by δθ′."""
    rates = _rates_of_turns(d.reshape(-1, COLUMNS)[:, 3:])
    axis = columns % COLUMNS - 3
    turns = axis >= 0
    body, axis = columns[turns] // COLUMNS, axis[turns]
    products = values[turns, None] * rates[body, axis]
    first = np.repeat(body * COLUMNS + 3, 3) + np.tile((0, 1, 2), len(body))
    return (
        np.concatenate((rows[~turns], np.repeat(rows[turns], 3))),
        np.concatenate((columns[~turns], first)),
        np.concatenate((values[~turns], products.ravel())),
    )


def _rates_of_turns(w: Array) -> Array:
    """Matrix T with δθ′ = T dw of each rotation vector w, (n, 3, 3).

    It is :func:`~kousoku.codegen.dynamics.assembly.pose.rates_of_turn` of all bodies at once, in
    doubles.
    """
    x, y, z = w.T
    zero = np.zeros_like(x)
    tilde = np.array([[zero, -z, y], [z, zero, -x], [-y, x, zero]]).transpose(2, 0, 1)
    angle = np.sqrt((w * w).sum(axis=1))[:, None, None]
    safe = np.where(angle > SMALL_TURN, angle, 1.0)
    a = 0.5 * np.sinc(angle / (2 * np.pi)) ** 2
    b = np.where(angle > SMALL_TURN, (safe - np.sin(safe)) / safe**3, 1 / 6)
    rates: Array = np.eye(3) - a * tilde + b * (tilde @ tilde)
    return rates


def _norm(x: Array) -> float:
    return float(np.sqrt((x * x).sum()))


def _shortened(step: Array) -> Array:
    """Displacement scaled so that no body turns by more than :data:`LARGEST_TURN`."""
    largest = float(np.abs(step.reshape(-1, COLUMNS)[:, 3:]).max(initial=0.0))
    return step * (LARGEST_TURN / largest) if largest > LARGEST_TURN else step
