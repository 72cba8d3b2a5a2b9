"""Positions along the branch that a loop is assembled on, and its rows there.

From one position to the next all bodies are moved a little by a displacement that changes no row,
and are put back on the rows. Everything is doubles, added in an order fixed here, and finite
rotations are fractions instead of sines: the same scene gives the same positions on every machine,
unless gears need the machine's arctangent.

Drivers do not hold here: the positions are those that joints allow, whatever moves them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from kousoku.codegen.dynamics.assembly.residuals import positions_of
from kousoku.codegen.dynamics.operations.mechanics import COLUMNS
from kousoku.codegen.dynamics.redundancy.rank import damped_change, factorise
from kousoku.runtime.integrate.settings import CLEARLY

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from kousoku.codegen.dynamics.assembly.residuals import Residuals
    from kousoku.codegen.dynamics.redundancy.rank import LQFactors
    from kousoku.model.mechanics.multibody import MovingBody
    from kousoku.model.numbers.real import Array

#: Step of the fastest body from one position to the next, in radians or lengths: far enough to
#: leave a special position, near enough that Newton's method comes back.
BRANCH_STEP = 0.25
#: How often a step that fails is halved.
HALVINGS = 4
#: Residual, in lengths of the scene or radians, up to which a position is on the branch and a row
#: that nothing changes is met: ten times what assembly leaves open, so that the start is.
BRANCH_TOLERANCE = 1e-11
#: Steps back to the branch.
MOST_BRANCH_STEPS, MOST_DAMPED_STEPS = 40, 60
#: The least damping, where rows depend on each other on the branch: an undamped matrix would be
#: singular to rounding there.
LEAST_BRANCH_DAMPING = 1e-13
#: Pivots above this multiple of the limit of a row's rate count without that rate: a hinge that is
#: aside and leans has pivots of 1.6 times its rate in the plane, and of 0.8 times in space.
BEYOND_DOUBT = 2.0
#: A step that ends within this part of its length has not left the position.
MOVED = 0.05


@dataclass(frozen=True, slots=True)
class BranchPosition:
    """Positions of the bodies of a part, and the ranks there.

    Parameters
    ----------
    r, p : (bodies + 1, 3) and (bodies + 1, 4) [-]
        Centres of mass in frame O, in lengths of the scene, and Euler parameters of the principal
        frames, the ground last.
    near : (coordinates,) [rad]
        Angles that count turns.
    c : (rows,) [-]
        Residuals C of the rows of joints, scaled.
    factors : LQFactors
        Of C_q of the rows of joints, scaled.
    clear : int
        Count of rows that are independent beyond doubt.
    pivots : (rows,) [-]
        Pivots of all rows that are not dependent to rounding.
    """

    r: Array
    p: Array
    near: Array
    c: Array
    factors: LQFactors
    clear: int
    pivots: Array


@dataclass(frozen=True, slots=True)
class Scales:
    """Factors that make rows and columns free of units.

    Parameters
    ----------
    rows, columns : (rows,) and (columns,)
        Factors of all rows and columns of the residuals.
    """

    rows: Array
    columns: Array

    @classmethod
    def of_length(cls, residuals: Residuals, length: float) -> Scales:
        """Scales that compare metres with radians by a length [m]."""
        is_length = np.arange(residuals.columns) % COLUMNS < COLUMNS // 2
        by = np.where(residuals.in_metres, 1 / length, 1.0) / residuals.ratios(length)
        return cls(by, np.where(is_length, length, 1.0))


class Branch:
    """The rows of a part as functions of positions, in lengths of the scene and radians.

    Parameters
    ----------
    residuals : Residuals
        The constraints of the part between its bodies.
    rows, columns : sequence of int
        The rows of joints, and the columns of free displacements.
    length : float [m]
        Length that compares metres with radians.
    scales : Scales, optional
        Scales by the length unless given.
    tolerance : float
        Residual up to which rows count as implied by others, scaled; 0 for rounding alone.
    """

    def __init__(
        self,
        residuals: Residuals,
        rows: Sequence[int],
        columns: Sequence[int],
        length: float,
        *,
        scales: Scales | None = None,
        tolerance: float = 0.0,
    ) -> None:
        self._residuals, self.length, self.tolerance = residuals, length, tolerance
        self._rows, self._columns = list(rows), list(columns)
        scales = scales or Scales.of_length(residuals, length)
        self._all_row_scales = scales.rows
        self._row_scales = self._all_row_scales[self._rows]
        self._column_scales = scales.columns[self._columns]
        #: Units of scaled residuals and displacements, in lengths of the scene and radians.
        is_length = np.arange(residuals.columns) % COLUMNS < COLUMNS // 2
        self._all_row_units = np.where(residuals.in_metres, 1 / length, 1.0) / self._all_row_scales
        self._row_units = self._all_row_units[self._rows]
        self._column_units = self._column_scales / np.where(is_length, length, 1.0)[self._columns]

    def positions(self, bodies: Sequence[MovingBody]) -> Iterator[BranchPosition]:
        """Position of the bodies, and further ones along the branch, until nothing moves."""
        position = self._position(*self._start(bodies))
        yield position
        direction = _any_direction(len(self._columns))
        while position.factors.rank < len(self._columns):
            direction = self._of_size_one(position.factors.null_part(direction))
            following = self._next(position, direction)
            if following is None:
                return
            yield following
            position = following

    def start(self, bodies: Sequence[MovingBody]) -> tuple[Array, Array]:
        """Residuals C (rows,) [-] and C_q (rows, columns) [-], scaled, where the bodies are."""
        return self._at(*self._start(bodies))

    def _start(self, bodies: Sequence[MovingBody]) -> tuple[Array, Array, Array]:
        r, p = positions_of(bodies)
        return r / self.length, p, self._residuals.near

    def rates(self, factors: LQFactors, matrix: Array, rows: Sequence[int]) -> Array:
        """Rates of residuals per unit of the motion that violates each row most.

        For a row a of C_q that is x = (I − QᵀQ) aᵀ, at right angles to the rows that it keeps.

        Parameters
        ----------
        factors : LQFactors
            Of the rows that the motion keeps.
        matrix : (rows, columns)
            Rows of C_q, scaled.
        rows : sequence of int
            Their indices among the rows of the residuals.

        Returns
        -------
        (rows,) array
            In lengths of the scene and radians; that of a motion is the root of the sum of squares
            over all bodies.
        """
        free = np.array([factors.null_part(row) for row in matrix])
        motions = np.sqrt(((free * self._column_units) ** 2).sum(axis=1))
        missed: Array = (free * free).sum(axis=1) * self._all_row_units[list(rows)]
        return missed / np.where(motions > BRANCH_TOLERANCE, motions, np.inf)

    def rate_of_last(self, position: BranchPosition) -> float:
        """Rate of the residual of the row taken last, in motions that keep the rows before it."""
        _, matrix = self._at(position.r, position.p, position.near)
        before = factorise(matrix, BRANCH_TOLERANCE, position.factors.rank - 1)
        return float(self.rates(before, matrix, self._rows)[position.factors.taken[-1]])

    def _ranks(self, matrix: Array, rows: Sequence[int]) -> tuple[LQFactors, int, Array]:
        """Factors of rows that are not redundant, count of those beyond doubt, and all pivots.

        Rates of residuals decide, in the units of violations, where pivots are small: these are
        scaled by the arms of bodies.
        """
        if not self.tolerance:
            factors = factorise(matrix)
            return factors, factors.rank, factors.pivots
        full = factorise(matrix, BRANCH_TOLERANCE)
        limits, ranks = (CLEARLY * self.tolerance, self.tolerance), []
        factors = factorise(
            matrix, BRANCH_TOLERANCE, int((full.pivots > BEYOND_DOUBT * limits[0]).sum())
        )
        for limit in limits:
            while factors.rank < full.rank and self.rates(factors, matrix, rows).max() > limit:
                factors = factorise(matrix, BRANCH_TOLERANCE, factors.rank + 1)
            ranks.append(factors.rank)
        return factors, ranks[0], full.pivots

    def is_redundant(self, positions: Sequence[BranchPosition], full_rank: int) -> bool:
        """Whether rows repeat others at all positions; one position shows it at full rank only."""
        rank = max(position.factors.rank for position in positions)
        return rank < len(self._rows) and (len(positions) > 1 or rank == full_rank)

    def factors_of(self, position: BranchPosition, rows: Sequence[int]) -> LQFactors:
        """Factors at a position of rows that need not hold there, such as those of drivers."""
        _, matrix = self._residuals.doubles(position.r * self.length, position.p, position.near)
        indices = list(rows)
        matrix = matrix[np.ix_(indices, self._columns)]
        scaled = matrix * self._all_row_scales[indices][:, None] * self._column_scales
        return self._ranks(scaled, indices)[0]

    def remainders(self, position: BranchPosition, left: Sequence[int]) -> Array:
        """Norms |(I − QᵀQ) aᵀ| (n,) [-] of rows a of C_q, scaled, beyond Q of all other rows."""
        _, matrix = self._at(position.r, position.p, position.near)
        factors = factorise(np.delete(matrix, list(left), axis=0))
        return np.array([float((factors.null_part(matrix[k]) ** 2).sum()) ** 0.5 for k in left])

    def is_length(self, row: int) -> bool:
        """Whether a row of joints is a length, or else an angle."""
        return bool(self._residuals.in_metres[self._rows[row]])

    def missed(self, position: BranchPosition) -> Array:
        """Residuals C (rows,) of the rows of joints, in lengths of the scene and radians."""
        return self.in_units(position.c, range(len(self._rows)))

    def in_units(self, scaled: Array, indices: Sequence[int]) -> Array:
        """Residuals (n,) of some rows of joints, from scaled ones, in lengths and radians."""
        residuals: Array = scaled * self._row_units[list(indices)]
        return residuals

    def reaction_directions(
        self, position: BranchPosition, groups: Sequence[Sequence[int]]
    ) -> list[Array]:
        """Force and torque on each body by multipliers that cancel each other.

        Parameters
        ----------
        position : BranchPosition
            Positions of the bodies.
        groups : sequence of sequence of int
            Rows of joints that act together, such as those of one joint.

        Returns
        -------
        list of (dependences, bodies, 6) array
            Of each group the force in frame O, times a length of the scene, and torque in the
            principal frame, for each vector of an orthonormal basis of the multipliers that cancel
            each other.
        """
        _, matrix = self._residuals.doubles(position.r * self.length, position.p, position.near)
        dependences = position.factors.dependences() * self._row_scales
        wrenches = []
        for group in map(list, groups):
            factors = dependences[:, group]
            total = (factors[:, :, None] * matrix[[self._rows[k] for k in group]]).sum(axis=1)
            by_body: Array = total.reshape(len(factors), -1, COLUMNS)
            by_body[:, :, :3] *= self.length
            wrenches.append(by_body)
        return wrenches

    def _position(self, r: Array, p: Array, near: Array) -> BranchPosition:
        c, matrix = self._at(r, p, near)
        return BranchPosition(r, p, near, c, *self._ranks(matrix, self._rows))

    def _at(self, r: Array, p: Array, near: Array) -> tuple[Array, Array]:
        c, matrix = self._residuals.doubles(r * self.length, p, near)
        matrix = matrix[np.ix_(self._rows, self._columns)]
        scaled = matrix * self._row_scales[:, None] * self._column_scales
        return c[self._rows] * self._row_scales, scaled

    def _of_size_one(self, x: Array) -> Array:
        scaled: Array = x / np.abs(x * self._column_units).max()
        return scaled

    def _next(self, position: BranchPosition, direction: Array) -> BranchPosition | None:
        """Position near, in a direction or as near to it as the rows allow."""
        for halvings in range(HALVINGS + 1):
            step = BRANCH_STEP / 2**halvings
            for settle in (self._settled, self._settled_damped):
                moved = settle(position, step * direction)
                if moved is not None and self._distance(position, *moved) > MOVED * step:
                    near = self._residuals.angles(moved[0] * self.length, moved[1], position.near)
                    return self._position(*moved, near)
        return None

    @staticmethod
    def _distance(position: BranchPosition, r: Array, p: Array) -> float:
        return float(max(np.abs(r - position.r).max(), np.abs(p - position.p).max()))

    def _settled(self, position: BranchPosition, step: Array) -> tuple[Array, Array] | None:
        """Position after a step, back on the rows that were independent before it."""
        r, p = self._moved(position.r, position.p, step)
        last = np.inf
        for _ in range(MOST_BRANCH_STEPS):
            c = self._residuals.residuals(r * self.length, p, position.near)[self._rows]
            c = c * self._row_scales
            size = float(np.abs(c).max(initial=0))
            if size <= BRANCH_TOLERANCE:
                return r, p
            kept = float(np.abs(c[list(position.factors.taken)]).max(initial=0))
            if kept <= BRANCH_TOLERANCE / 10:
                return (r, p) if self._is_within_tolerance(position, c, step) else None
            if kept > last:
                return None
            last = kept
            r, p = self._moved(r, p, position.factors.least_change(-c))
        return None

    def _is_within_tolerance(self, position: BranchPosition, c: Array, step: Array) -> bool:
        """Whether residuals of implied rows stay within the tolerance after a step.

        They may grow in proportion to the step: where rows are dependent at a position only, their
        residuals grow with the square of a step.
        """
        c = c * self._row_units
        growth = float(
            np.abs(c - self.missed(position))[list(position.factors.left)].max(initial=0.0)
        )
        fraction = float(np.abs(step * self._column_units).max()) / BRANCH_STEP
        limit = CLEARLY * self.tolerance
        return bool(np.abs(c).max() <= limit and growth <= limit * fraction)

    def _settled_damped(self, position: BranchPosition, step: Array) -> tuple[Array, Array] | None:
        """Position after a step, back on all rows: damped, as their rank may differ."""
        r, p = self._moved(position.r, position.p, step)
        last = np.inf
        for _ in range(MOST_DAMPED_STEPS):
            c, matrix = self._at(r, p, position.near)
            size = float(np.abs(c).max(initial=0))
            if size <= BRANCH_TOLERANCE:
                return r, p
            if size > last:
                return None
            last = size
            r, p = self._moved(r, p, damped_change(matrix, -c, max(size**2, LEAST_BRANCH_DAMPING)))
        return None

    def _moved(self, r: Array, p: Array, step: Array) -> tuple[Array, Array]:
        """Positions after a step of the columns, scaled."""
        full = np.zeros(self._residuals.columns)
        full[self._columns] = step * self._column_units
        return displaced(r, p, full)


def displaced(r: Array, p: Array, change: Array) -> tuple[Array, Array]:
    """Positions after displacements (δr, δθ′) (columns,): p ∘ (1, δθ′/2), of norm one."""
    by_body = change.reshape(-1, COLUMNS)
    r, p = r.copy(), p.copy()
    r[:-1] += by_body[:, :3]
    w, x, y, z = p[:-1].T
    a, b, c = by_body[:, 3:].T / 2
    # Not ``composed``: it adds in another order, and branches would differ in their last bits.
    product: Any = np.array(
        [
            w - x * a - y * b - z * c,
            x + w * a + y * c - z * b,
            y + w * b + z * a - x * c,
            z + w * c + x * b - y * a,
        ]
    )
    p[:-1] = (product / np.sqrt((product * product).sum(axis=0))).T
    return r, p


def _any_direction(count: int) -> Array:
    """Numbers from −1 to 1 without a pattern: the fractions of k √2 + k² √3."""
    k = np.arange(1.0, count + 1.0)
    numbers = k * 2**0.5 + k * k * 3**0.5
    return 2 * (numbers - np.floor(numbers)) - 1
