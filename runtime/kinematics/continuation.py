"""Continuation: from one position to the next, by predictor and corrector."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from .equations import Coordinates, differentiate
from .newton import Convergence, Newton, largest
from .status import SETTLED, SMALLEST_STEP, Status, StopError

if TYPE_CHECKING:
    from .equations import Kernels
    from .mechanism import Array, Mechanism
    from .rows import Run


class Continuation:
    """A position on its way along the inputs.

    Parameters
    ----------
    mechanism : Mechanism
        The tables.
    kernels : Kernels
        The kernels of its blocks.
    run : Run
        Inputs, method and limits.

    Attributes
    ----------
    position : Coordinates
        Where it is.
    x1, x2 : (unknowns,) array
        First and second derivatives of the unknowns along one division.
    """

    def __init__(self, mechanism: Mechanism, kernels: Kernels, run: Run) -> None:
        self.run = run
        self.newton = Newton(mechanism, kernels, run)
        alpha, _ = run.inputs_of(0)
        x = np.array([unknown.start for unknown in mechanism.unknowns])
        self.position = Coordinates(alpha, x)
        self.x1, self.x2 = np.zeros_like(x), np.zeros_like(x)
        self._is_angle = np.array([unknown.is_angle for unknown in mechanism.unknowns])
        self._input_scale = np.array([given.scale for given in mechanism.inputs])

    def motion_at(self, delta: Array) -> tuple[Array, Array]:
        """Differentiate along a division, for the next prediction, and in time.

        Parameters
        ----------
        delta : (inputs,) array
            How far one division goes.

        Returns
        -------
        x_dot, x_ddot : (unknowns,) array
            Time derivatives of the unknowns.
        """
        rate, rate_dot = np.asarray(self.run.rate), np.asarray(self.run.rate_dot)
        none = np.zeros_like(delta)
        if len(delta) > 1:
            self.x1, self.x2 = self._derivatives(delta, none)
            return self._derivatives(rate, rate_dot)
        # One input: both follow from the derivatives by it.
        first, second = self._derivatives(np.ones(1), none)
        self.x1, self.x2 = first * delta, second * (delta * delta)
        return first * rate, second * rate * rate + first * rate_dot

    def advance(self, target: Array, delta: Array) -> Convergence:
        """Step the inputs: predict by (26), correct, and halve the step where that fails.

        Parameters
        ----------
        target : (inputs,) array
            Where the step ends.
        delta : (inputs,) array
            The whole step.

        Raises
        ------
        StopError
            A position on the way is not found.
        """
        left, step, iterations, residual = 1.0, 1.0, 0, 0.0
        tries = 0
        while left > 0:
            step, tries = min(step, left), tries + 1
            alpha = target - (left - step) * delta
            predicted = self.position.x + step * (self.x1 + 0.5 * step * self.x2)
            trial = predicted.copy()
            status = Status.DEAD_CENTRE
            try:
                count, residual = self._correct(alpha, trial)
                iterations += count
                is_good = self._is_near(predicted, trial, step * delta)
            except StopError as stop:
                status, is_good = stop.status, False
            if not is_good:
                step *= 0.5
                if step < SMALLEST_STEP or tries > 1000:
                    raise StopError(status)
                continue
            left -= step
            step *= 2
            self._accept(alpha, trial)
            if left > 0:
                self.x1, self.x2 = self._derivatives(delta, np.zeros_like(delta))
        return Convergence(iterations, residual)

    def _correct(self, alpha: Array, trial: Array) -> Convergence:
        if self.run.method:
            return self.newton.modified(alpha, trial, self.position)
        return self.newton.full(alpha, trial)

    def _accept(self, alpha: Array, trial: Array) -> None:
        """Be at a corrected position, angles next to zero."""
        turns = np.where(self._is_angle, np.rint(trial / math.tau), 0.0)
        self.position = Coordinates(alpha, trial - math.tau * turns)

    def _derivatives(self, alpha_dot: Array, alpha_ddot: Array) -> tuple[Array, Array]:
        return differentiate(self.newton.blocks, self.position, alpha_dot, alpha_ddot)

    def _is_near(self, predicted: Array, trial: Array, moved: Array) -> bool:
        """Whether corrections stayed small beside the motion: else another branch may be near."""
        scale = self.newton.scale
        driven = largest(moved * self._input_scale)
        most = max(driven, largest((predicted - self.position.x) * scale))
        corrected = largest((trial - predicted) * scale)
        return corrected <= 0.25 * most + SETTLED * self.newton.length
