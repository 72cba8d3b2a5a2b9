"""Continuation: from one position to the next, by predictor and corrector.

Numbers in parentheses are equations of M. Yamada and S. Tatsumi (1981).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from .block_equations import LinkageCoordinates
from .certificate import Certifier, CubicTube
from .newton import Convergence, Newton, largest
from .status import MOST_TILT, MOST_TRIES, SETTLED, SMALLEST_STEP, AnalysisStatus, StopError

if TYPE_CHECKING:
    from .rows import RunRequest
    from .tables import Array, LinkageTables


class Continuation:
    """A position on its way along the inputs.

    Parameters
    ----------
    mechanism : LinkageTables
        The tables and segments.
    run : RunRequest
        Inputs, method and limits.

    Attributes
    ----------
    position : LinkageCoordinates
        Where it is: at first near where the scene is assembled.
    division : int
        The division, or the row, that its inputs are next to.
    time, rate : float, (inputs,) array
        When, where the inputs follow their laws in time, and their rates.
    x1, x2 : (unknowns,) array
        First and second derivatives of the unknowns along one division, or in time.
    step : float
        The next step to try, in divisions or in time, where a row is not nearer.
    """

    def __init__(self, mechanism: LinkageTables, run: RunRequest) -> None:
        self.run = run
        self.newton = Newton(mechanism, run)
        # Whole turns lead to the same inputs: the first position may be that of any.
        self.division = run.start - run.start % run.divisions if run.is_periodic else 0
        self.time = 0.0
        _, self.rate = run.laws_at(0.0)
        alpha = np.array([coordinate.start for coordinate in mechanism.inputs])
        x = np.array([unknown.start for unknown in mechanism.unknowns])
        self.position = LinkageCoordinates(alpha, x)
        self.x1, self.x2 = np.zeros_like(x), np.zeros_like(x)
        self.step = math.inf
        self._certifiers = [Certifier(mechanism, block) for block in mechanism.blocks]
        self._is_angle = np.array([unknown.is_angle for unknown in mechanism.unknowns])
        self.input_scale = np.array([coordinate.scale for coordinate in mechanism.inputs])

    def motion_at(self, division: int) -> tuple[Array, Array]:
        """Differentiate in time, and along the way for the next prediction: (22) to (25).

        Returns
        -------
        x_dot, x_ddot : (unknowns,) array
            Time derivatives of the unknowns, in their units per s and per s².
        """
        _, delta = self.run.inputs_of(division)
        rate, rate_dot, none = self.rate, np.asarray(self.run.rate_dot), np.zeros_like(delta)
        if len(delta) > 1 or self.run.times is not None:
            self.x1, self.x2 = x_dot, x_ddot = self._derivatives(rate, rate_dot)
            if self.run.times is None:
                self.x1, self.x2 = self._derivatives(delta, none)
            return x_dot, x_ddot
        # One input: both follow from the derivatives by it.
        first, second = self._derivatives(np.ones(1), none)
        self.x1, self.x2 = first * delta, second * (delta * delta)
        return first * rate, second * rate * rate + first * rate_dot

    def advance(self, row: int, residual: float) -> Convergence:
        """Go to a division, or to the time of a row in steps of at most a division.

        Predict x + h x′ + ½ h² x″, (26), correct, and halve the step h where that fails, or where
        no certificate tells that it stays on its branch.

        Parameters
        ----------
        row : int
            The division, or the row.
        residual : float
            What is left where it is.

        Raises
        ------
        StopError
            A position on the way is not found.
        """
        run, iterations, tries = self.run, 0, -1
        target, delta = run.inputs_of(row)
        pace, pace_dot = delta, np.zeros_like(delta)
        if run.times is not None:
            pace, pace_dot = self.rate, np.asarray(run.rate_dot)
        per_division = np.where(delta, delta, self.newton.length / self.input_scale)
        remaining = 1.0 if run.times is None else float(run.times[row]) - self.time
        time = 0.0
        while remaining > 0:
            tries += 1
            step = min(self.step, remaining)
            if run.times is None:
                part = step
                alpha, change = target - (remaining - step) * delta, step * delta
            else:
                end = run.end_of(self.time, float(run.times[row]))
                longest = end - self.time
                step, time = (step, self.time + step) if step < longest else (longest, end)
                alpha, _ = run.laws_at(time)
                change = alpha - self.position.alpha
                part = largest(change / per_division)
            predicted = self.position.x + step * (self.x1 + 0.5 * step * self.x2)
            trial = predicted.copy()
            try:
                if not part <= 1.0:
                    raise StopError(AnalysisStatus.TOO_FAR)
                convergence = self._correct(alpha, trial)
                tube = self._tube(step, pace, pace_dot, trial - predicted)
                tilt = self._tilt(tube, max(residual, convergence.residual))
            except StopError as stop:
                self.step = 0.5 * step
                if 0.5 * part < SMALLEST_STEP or tries > MOST_TRIES:
                    raise StopError(
                        AnalysisStatus.TOO_FAR if tries > MOST_TRIES else stop.status
                    ) from None
                continue
            remaining -= step
            self.step = max(self.step, 2 * step) if 2 * tilt <= MOST_TILT else step
            iterations, residual = iterations + convergence.iterations, convergence.residual
            self._accept(alpha, trial)
            self.division = row
            if run.times is not None:
                _, self.rate = run.laws_at(time)
                self.time, remaining, pace = time, float(run.times[row]) - time, self.rate
            if remaining > 0:
                self.x1, self.x2 = self._derivatives(pace, pace_dot)
        self.division = row
        return Convergence(iterations, residual)

    def _correct(self, alpha: Array, trial: Array) -> Convergence:
        if self.run.method:
            return self.newton.modified(alpha, trial, self.position)
        return self.newton.full(alpha, trial)

    def _accept(self, alpha: Array, trial: Array) -> None:
        """Be at a corrected position, angles next to zero."""
        turns = np.where(self._is_angle, np.rint(trial / math.tau), 0.0)
        self.position = LinkageCoordinates(alpha, trial - math.tau * turns)

    def _derivatives(self, alpha_dot: Array, alpha_ddot: Array) -> tuple[Array, Array]:
        return self.newton.equations.differentiate(self.position, alpha_dot, alpha_ddot)

    def _tube(self, step: float, pace: Array, pace_dot: Array, correction: Array) -> CubicTube:
        """Cubics of a step, (26) and what was corrected."""
        first, second = np.concatenate((pace, self.x1)), np.concatenate((pace_dot, self.x2))
        third = np.concatenate((np.zeros_like(pace), correction))
        return CubicTube(step * first, 0.5 * step * step * second, third, np.zeros_like(third))

    def _tilt(self, tube: CubicTube, residual: float) -> float:
        """Turn of the Jacobians along a step, the most of all blocks.

        Raises
        ------
        StopError
            So far that the step may have left its branch.
        """
        most = 0.0
        for number, certifier in enumerate(self._certifiers):
            self.newton.at = number
            tilt = certifier.tilt(self.newton.blocks[number], tube, residual)
            if not tilt <= MOST_TILT:
                raise StopError(AnalysisStatus.DEAD_CENTRE)
            most = max(most, tilt)
        return most

    @property
    def condition(self) -> float:
        """The most that residuals of 1 move an unknown [-], as lengths, with factors at hand."""
        pairs = zip(self._certifiers, self.newton.blocks, strict=True)
        return max(certifier.condition(block) for certifier, block in pairs)

    @property
    def counted_inputs(self) -> Array:
        """Inputs (inputs,) of the position, in their units, counting on over the turns."""
        is_timed = self.run.times is not None
        return self.position.alpha + (0.0 if is_timed else self.run.whole_turns(self.division))

    def is_at(self, x: Array) -> bool:
        """Whether unknowns (unknowns,) are those of the position, angles [rad] up to turns."""
        difference = self.position.x - x
        difference -= math.tau * np.where(self._is_angle, np.rint(difference / math.tau), 0.0)
        # Two assemblies are not as near as that where pivots are above SINGULAR.
        return largest(difference * self.newton.scale) <= SETTLED * self.newton.length
