"""Positions along the branch that a loop is assembled on, and its rows there.

From one position to the next all bodies are moved a little by a displacement that changes no row,
and are put back on the rows. Everything is doubles in an order that is ours, and finite rotations
are fractions instead of sines: the same scene gives the same positions on every machine, where
gears do not make it depend on the machine's arctangent.

Drivers do not hold here: the positions are those that joints allow, whatever moves them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from kousoku.codegen.dynamics.assembly.residuals import places_of
from kousoku.codegen.dynamics.operations.mechanics import COLUMNS
from kousoku.codegen.dynamics.redundancy.rank import damped_change, factorise
from kousoku.runtime.integrate.settings import CLEARLY

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from kousoku.codegen.dynamics.assembly.residuals import Residuals
    from kousoku.codegen.dynamics.redundancy.rank import LQFactors
    from kousoku.model.mechanics.multibody import MovingBody
    from kousoku.model.numbers.real import Array

#: How far the fastest body moves from one position to the next, in radians or lengths: far enough
#: to leave what is special of a position, near enough that Newton's method comes back.
BRANCH_STEP = 0.25
#: How often a step that fails is halved.
HALVINGS = 4
#: What holds to this part of the length of the scene, or so many radians, is on the branch, and a
#: row that nothing changes is met: ten times what assembly leaves open, so that the start is.
BRANCH_TOLERANCE = 1e-11
#: Steps back to the branch.
MOST_BRANCH_STEPS, MOST_DAMPED_STEPS = 40, 60
#: The least damping, where rows depend on each other on the branch: without any, what is singular
#: there to rounding would be solved with.
LEAST_BRANCH_DAMPING = 1e-13
#: How many times the limit of what rows miss a pivot must be to count without that: a hinge that is
#: aside and leans has pivots of 1.6 times what it misses in the plane, and of 0.8 times in space.
BEYOND_DOUBT = 2.0
#: A position that came back to less than this part of a step was not left.
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
        How many of the rows are independent beyond doubt.
    pivots : (rows,) [-]
        Of all of them that are not dependent to rounding.
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
        Of all rows and columns of the residuals.
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
        The rows of joints and the columns that are looked at.
    length : float [m]
        What compares metres with radians.
    scales : Scales, optional
        Those of the length unless given.
    tolerance : float
        What rows may miss that others imply, scaled, if that is to be more than rounding.
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
        self._all_by = scales.rows
        self._rows_by = self._all_by[self._rows]
        self._columns_by = scales.columns[self._columns]
        #: What a scaled displacement is in lengths of the scene and radians.
        is_length = np.arange(residuals.columns) % COLUMNS < COLUMNS // 2
        self._all_missed_by = np.where(residuals.in_metres, 1 / length, 1.0) / self._all_by
        self._missed_by = self._all_missed_by[self._rows]
        self._steps_by = self._columns_by / np.where(is_length, length, 1.0)[self._columns]

    def positions(self, bodies: Sequence[MovingBody]) -> Iterator[BranchPosition]:
        """Position of the bodies, and others along the branch, until nothing moves."""
        here = self._position(*self._start(bodies))
        yield here
        direction = _any_direction(len(self._columns))
        while here.factors.rank < len(self._columns):
            direction = self._of_size_one(here.factors.null_part(direction))
            there = self._next(here, direction)
            if there is None:
                return
            yield there
            here = there

    def start(self, bodies: Sequence[MovingBody]) -> tuple[Array, Array]:
        """Residuals C (rows,) [-] and C_q (rows, columns) [-], scaled, where the bodies are."""
        return self._at(*self._start(bodies))

    def _start(self, bodies: Sequence[MovingBody]) -> tuple[Array, Array, Array]:
        r, p = places_of(bodies)
        return r / self.length, p, self._residuals.near

    def rates(self, factors: LQFactors, matrix: Array, rows: Sequence[int]) -> Array:
        """Rates at which rows are missed, per unit of the motion that makes them miss most.

        Of a row a of C_q the motion is x = (I − QᵀQ) aᵀ, at right angles to the rows that it keeps.

        Parameters
        ----------
        factors : LQFactors
            Of the rows that the motion keeps.
        matrix : (rows, columns)
            Rows of C_q, scaled.
        rows : sequence of int
            Which rows of the residuals these are.

        Returns
        -------
        (rows,) array
            In lengths of the scene and radians; that of a motion is the root of the sum of squares
            over all bodies.
        """
        rest = np.array([factors.null_part(row) for row in matrix])
        motions = np.sqrt(((rest * self._steps_by) ** 2).sum(axis=1))
        missed: Array = (rest * rest).sum(axis=1) * self._all_missed_by[list(rows)]
        return missed / np.where(motions > BRANCH_TOLERANCE, motions, np.inf)

    def rate_of_last(self, position: BranchPosition) -> float:
        """Rate at which the row that was taken last is missed, where only those before it hold."""
        _, matrix = self._at(position.r, position.p, position.near)
        before = factorise(matrix, BRANCH_TOLERANCE, position.factors.rank - 1)
        return float(self.rates(before, matrix, self._rows)[position.factors.taken[-1]])

    def _ranks(self, matrix: Array, rows: Sequence[int]) -> tuple[LQFactors, int, Array]:
        """Factors of rows that are not redundant, how many are beyond doubt, all pivots.

        What rows miss per unit of a motion decides, in the units that violations have, where what
        is left of them is small for the arms of their bodies, too.
        """
        if not self.tolerance:
            factors = factorise(matrix)
            return factors, factors.rank, factors.pivots
        every = factorise(matrix, BRANCH_TOLERANCE)
        limits, ranks = (CLEARLY * self.tolerance, self.tolerance), []
        factors = factorise(
            matrix, BRANCH_TOLERANCE, int((every.pivots > BEYOND_DOUBT * limits[0]).sum())
        )
        for limit in limits:
            while factors.rank < every.rank and self.rates(factors, matrix, rows).max() > limit:
                factors = factorise(matrix, BRANCH_TOLERANCE, factors.rank + 1)
            ranks.append(factors.rank)
        return factors, ranks[0], every.pivots

    def is_redundant(self, positions: Sequence[BranchPosition], few: int) -> bool:
        """Whether rows repeat others at all positions; one alone tells it at rank ``few`` only."""
        rank = max(position.factors.rank for position in positions)
        return rank < len(self._rows) and (len(positions) > 1 or rank == few)

    def with_others(self, position: BranchPosition, rows: Sequence[int]) -> LQFactors:
        """Factors at a position of more rows than those that hold there."""
        _, matrix = self._residuals.doubles(position.r * self.length, position.p, position.near)
        chosen = list(rows)
        matrix = matrix[np.ix_(chosen, self._columns)]
        scaled = matrix * self._all_by[chosen][:, None] * self._columns_by
        return self._ranks(scaled, chosen)[0]

    def left_over(self, position: BranchPosition, left: Sequence[int]) -> Array:
        """Norms |(I − QᵀQ) aᵀ| (n,) [-] of rows a of C_q, scaled, beyond Q of all other rows."""
        _, matrix = self._at(position.r, position.p, position.near)
        others = factorise(np.delete(matrix, list(left), axis=0))
        return np.array([float((others.null_part(matrix[k]) ** 2).sum()) ** 0.5 for k in left])

    def is_length(self, place: int) -> bool:
        """Whether a row of joints is a length, or else an angle."""
        return bool(self._residuals.in_metres[self._rows[place]])

    def missed(self, position: BranchPosition) -> Array:
        """Residuals C (rows,) of the rows of joints, in lengths of the scene and radians."""
        return self.in_units(position.c, range(len(self._rows)))

    def in_units(self, scaled: Array, places: Sequence[int]) -> Array:
        """Values (n,) of some rows of joints, given scaled, in lengths of the scene and radians."""
        found: Array = scaled * self._missed_by[list(places)]
        return found

    def reaction_directions(
        self, position: BranchPosition, groups: Sequence[Sequence[int]]
    ) -> list[Array]:
        """Force and torque on each body of rows whose multipliers move nothing.

        Parameters
        ----------
        position : BranchPosition
            Where they are.
        groups : sequence of sequence of int
            The rows of joints that count together, such as those of one joint.

        Returns
        -------
        list of (dependences, bodies, 6) array
            Of each group the force in frame O, times a length of the scene, and torque in the
            principal frame, for each vector of an orthonormal basis of the multipliers that cancel
            each other.
        """
        _, matrix = self._residuals.doubles(position.r * self.length, position.p, position.near)
        dependences = position.factors.dependences() * self._rows_by
        found = []
        for own in map(list, groups):
            factors = dependences[:, own]
            total = (factors[:, :, None] * matrix[[self._rows[k] for k in own]]).sum(axis=1)
            by_body: Array = total.reshape(len(factors), -1, COLUMNS)
            by_body[:, :, :3] *= self.length
            found.append(by_body)
        return found

    def _position(self, r: Array, p: Array, near: Array) -> BranchPosition:
        c, matrix = self._at(r, p, near)
        return BranchPosition(r, p, near, c, *self._ranks(matrix, self._rows))

    def _at(self, r: Array, p: Array, near: Array) -> tuple[Array, Array]:
        c, matrix = self._residuals.doubles(r * self.length, p, near)
        matrix = matrix[np.ix_(self._rows, self._columns)]
        scaled = matrix * self._rows_by[:, None] * self._columns_by
        return c[self._rows] * self._rows_by, scaled

    def _of_size_one(self, x: Array) -> Array:
        scaled: Array = x / np.abs(x * self._steps_by).max()
        return scaled

    def _next(self, here: BranchPosition, direction: Array) -> BranchPosition | None:
        """Position near, in a direction or as near to it as the rows allow."""
        for halvings in range(HALVINGS + 1):
            step = BRANCH_STEP / 2**halvings
            for settle in (self._settled, self._settled_damped):
                found = settle(here, step * direction)
                if found is not None and self._far(here, *found) > MOVED * step:
                    near = self._residuals.angles(found[0] * self.length, found[1], here.near)
                    return self._position(*found, near)
        return None

    @staticmethod
    def _far(here: BranchPosition, r: Array, p: Array) -> float:
        return float(max(np.abs(r - here.r).max(), np.abs(p - here.p).max()))

    def _settled(self, here: BranchPosition, step: Array) -> tuple[Array, Array] | None:
        """Position after a step, back on the rows that were independent before it."""
        r, p = self._moved(here.r, here.p, step)
        before = np.inf
        for _ in range(MOST_BRANCH_STEPS):
            c = self._residuals.residuals(r * self.length, p, here.near)[self._rows]
            c = c * self._rows_by
            size = float(np.abs(c).max(initial=0))
            if size <= BRANCH_TOLERANCE:
                return r, p
            kept = float(np.abs(c[list(here.factors.taken)]).max(initial=0))
            if kept <= BRANCH_TOLERANCE / 10:
                return (r, p) if self._may_miss(here, c, step) else None
            if kept > before:
                return None
            before = kept
            r, p = self._moved(r, p, here.factors.least_change(-c))
        return None

    def _may_miss(self, here: BranchPosition, c: Array, step: Array) -> bool:
        """Whether rows that others imply miss no more after a step than they may.

        From there to here they may miss as much more as the step is a part of the longest: where
        rows are dependent at a position only, what they miss grows with the square of a step.
        """
        c = c * self._missed_by
        more = float(np.abs(c - self.missed(here))[list(here.factors.left)].max(initial=0.0))
        part = float(np.abs(step * self._steps_by).max()) / BRANCH_STEP
        most = CLEARLY * self.tolerance
        return bool(np.abs(c).max() <= most and more <= most * part)

    def _settled_damped(self, here: BranchPosition, step: Array) -> tuple[Array, Array] | None:
        """Position after a step, back on all rows: damped, as their rank may differ."""
        r, p = self._moved(here.r, here.p, step)
        before = np.inf
        for _ in range(MOST_DAMPED_STEPS):
            c, matrix = self._at(r, p, here.near)
            size = float(np.abs(c).max(initial=0))
            if size <= BRANCH_TOLERANCE:
                return r, p
            if size > before:
                return None
            before = size
            r, p = self._moved(r, p, damped_change(matrix, -c, max(size**2, LEAST_BRANCH_DAMPING)))
        return None

    def _moved(self, r: Array, p: Array, step: Array) -> tuple[Array, Array]:
        """Positions after a step of the columns, scaled."""
        full = np.zeros(self._residuals.columns)
        full[self._columns] = step * self._steps_by
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
