"""Newton's method: full, block after block, and with the Jacobian of a reference position.

Numbers in parentheses are equations of M. Yamada and S. Tatsumi (1981).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from .block_equations import Equations, LinkageCoordinates
from .status import ROUNDING_OF_POSITIONS, SETTLED, SINGULAR, AnalysisStatus, StopError

if TYPE_CHECKING:
    from .rows import RunRequest
    from .tables import Array, LinkageTables


class Convergence(NamedTuple):
    """Convergence of positions: the most of all blocks.

    Parameters
    ----------
    iterations : int
        Corrections.
    residual : float
        Largest residual, in the unit of the mechanism.
    """

    iterations: int
    residual: float


def largest(values: Array) -> float:
    """Largest magnitude max |xᵢ| of values of any shape, at least one, in the unit of these."""
    return float(np.max(np.abs(values)))


def is_dead_centre(pivot: float, orientation: float) -> bool:
    """Whether the Jacobian is singular, or its determinant that of another assembly mode."""
    return not abs(pivot) > SINGULAR or pivot * orientation < 0


class Newton:
    """Newton's method on the equations of a mechanism.

    Parameters
    ----------
    mechanism : LinkageTables
        The tables and segments.
    run : RunRequest
        Limit of the residual and of the iterations.

    Attributes
    ----------
    orientation : list of float
        The assembly mode of each block: its smallest pivot at the position of the scene, with the
        sign of the determinant; 0 while either side is good.
    at : int
        The block that was worked on last.
    """

    def __init__(self, mechanism: LinkageTables, run: RunRequest) -> None:
        self.equations = Equations(mechanism)
        self.blocks = self.equations.blocks
        self.scale = np.array([unknown.scale for unknown in mechanism.unknowns])
        self.length = mechanism.length
        self.run = run
        self.orientation = [0.0 for _ in self.blocks]
        self.at = 0

    def iterate(self, number: int) -> Convergence:
        """Improve the unknowns of one block, where it is looked at, by full Newton.

        Raises
        ------
        StopError
            It does not converge to the residual limit on this side of a dead centre.
        """
        block, last = self.blocks[number], math.inf
        for k in range(self.run.max_iterations + 1):
            epsilon, pivot = block.evaluate()
            residual = largest(epsilon)
            if not math.isfinite(residual):
                raise StopError(AnalysisStatus.NOT_FINITE)
            if is_dead_centre(pivot, self.orientation[number]):
                raise StopError(AnalysisStatus.DEAD_CENTRE)
            correction = block.solve(epsilon)
            step = largest(correction * block.scale)
            is_settled, is_stalled = last <= SETTLED * self.length, step >= 0.5 * last
            if residual <= self.run.limit and (is_settled or is_stalled):
                return Convergence(k, residual)
            if is_settled and is_stalled:
                raise StopError(AnalysisStatus.LIMIT_TOO_SMALL)
            # Corrections may grow while it is far from a solution, but no more after three.
            if k > 2 and step >= 2 * last:
                raise StopError(AnalysisStatus.DEAD_CENTRE)
            block.x -= correction
            last = step
        raise StopError(AnalysisStatus.DEAD_CENTRE)

    def full(self, alpha: Array, trial: Array) -> Convergence:
        """Improve all unknowns in ``trial`` by full Newton, x − D(x)⁻¹ ε(x), block after block.

        Parameters
        ----------
        alpha : (inputs,) array
            The inputs, in their units.
        trial : (unknowns,) array
            Approximate unknowns, which are overwritten.
        """
        iterations, residual = 0, 0.0
        self.equations.place(LinkageCoordinates(alpha, trial))
        for number in range(len(self.blocks)):
            self.at = number
            convergence = self.iterate(number)
            iterations = max(iterations, convergence.iterations)
            residual = max(residual, convergence.residual)
        trial[:] = self.equations.region("x")
        return Convergence(iterations, residual)

    def modified(self, alpha: Array, trial: Array, reference: LinkageCoordinates) -> Convergence:
        """Improve all unknowns in ``trial`` by the iteration of the paper, (27) and (28).

        A modified Newton method, x − D(x_ref)⁻¹ ε(x): the Jacobian stays that of the reference
        position, which ``trial`` was predicted from.

        Parameters
        ----------
        alpha : (inputs,) array
            The inputs, in their units.
        trial : (unknowns,) array
            Predicted unknowns, which are overwritten.
        reference : LinkageCoordinates
            The position of the Jacobian.
        """
        self.equations.place(reference)
        for block in self.blocks:
            block.evaluate()
        last, k = math.inf, 0
        while True:
            correction = np.empty_like(trial)
            self.equations.place(LinkageCoordinates(alpha, trial))
            for block in self.blocks:
                correction[block.part] = block.residuals()
            residual = largest(correction)
            if residual <= self.run.limit:
                break
            if not math.isfinite(residual):
                raise StopError(AnalysisStatus.NOT_FINITE)
            self._correct_from(reference, correction)
            step = largest(correction * self.scale)
            if step >= last and last <= ROUNDING_OF_POSITIONS * self.length:
                raise StopError(AnalysisStatus.LIMIT_TOO_SMALL)
            # As above, corrections grow no more after three.
            if k >= self.run.max_iterations or (k > 2 and step >= 2 * last):
                raise StopError(AnalysisStatus.DEAD_CENTRE)
            trial -= correction
            last, k = step, k + 1
        for number, block in enumerate(self.blocks):
            self.at = number
            _, pivot = block.evaluate()
            if is_dead_centre(pivot, self.orientation[number]):
                raise StopError(AnalysisStatus.DEAD_CENTRE)
        return Convergence(k, residual)

    def _correct_from(self, reference: LinkageCoordinates, correction: Array) -> None:
        """Make corrections of residuals, in place, with the Jacobian of the reference."""
        self.equations.place(reference)
        self.equations.place(LinkageCoordinates(np.zeros_like(reference.alpha), correction), "_dot")
        corrected = self.equations.region("x_dot")
        for block in self.blocks:
            # What the corrections of the blocks before add to this one.
            coupling = block.velocity_side()
            corrected[block.part] = block.solve(correction[block.part] + coupling)
        correction[:] = corrected
