"""Error of the rows of a run: their distance from a second run by another method."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from kousoku.runtime.integrate.run_arguments import LEAST_TOLERANCE
from kousoku.runtime.integrate.settings import KINEMATICS
from kousoku.runtime.messages import shortly

if TYPE_CHECKING:
    from kousoku.runtime.integrate.arithmetic import Array
    from kousoku.runtime.integrate.motion import Motion
    from kousoku.runtime.options import Options

#: The second run is made with a tolerance, or a fixed step, that is this part of the first one's;
#: with a tenth errors of both methods have been seen that were nearly the same.
STRICTER, SHORTER = 0.01, 0.4
#: Difference, in lengths of the scene or radians, from which two runs are no estimate of errors.
APART = 0.1


@dataclass(frozen=True, slots=True)
class ErrorEstimate:
    """Error of the rows of a run: the largest difference from a second one.

    Parameters
    ----------
    length : float [unit of the scene]
        Largest difference of the position of a body.
    angle : float [rad]
        Largest difference of the orientation of a body.
    unit : str
        The unit of the scene.
    method : str
        Method of the second run.
    unknown_from : float or None [s]
        The last row before the runs are apart by a tenth of a length of the scene, or of a radian,
        as where a motion is chaotic, or before the second one has stopped: the estimate is of the
        rows up to it.
    stop : str
        Why the second run has stopped there; "" where it has not.
    """

    length: float
    angle: float
    unit: str
    method: str
    unknown_from: float | None
    stop: str = ""

    def as_data(self) -> dict[str, object]:
        """Estimate as data, ready for JSON."""
        return {name: getattr(self, name) for name in self.__slots__}

    @property
    def unknown(self) -> str:
        """From when on nothing is known."""
        begin = f"from t = {self.unknown_from:.6g} s on nothing is known: {self.method}"
        if self.stop:
            return f"{begin}, which the run is compared with, stops: {self.stop}"
        return (
            f"{begin} goes elsewhere, as where a motion is chaotic; try a smaller tolerance or"
            " step, or a shorter time"
        )

    def __str__(self) -> str:
        until = "" if self.unknown_from is None else f" up to t = {self.unknown_from:.6g} s"
        return f"error {shortly(self.length)} {self.unit}, {shortly(self.angle)} rad{until}"


def second_options(options: Options) -> Options:
    """Options of a second run: another method, with other ends of its steps.

    Of fixed steps, those of order 5 would tell too little of those of order 8.
    """
    again = replace(options, estimate_error=False, checks=False)
    if options.method == KINEMATICS:
        return again  # its rows make other steps
    if options.step is not None:
        return replace(again, method="dop853", step=SHORTER * options.step)
    method = "dopri5" if options.method == "dop853" else "dop853"
    return replace(
        again, method=method, tolerance=max(STRICTER * options.tolerance, LEAST_TOLERANCE)
    )


def second_times(times: Array, options: Options) -> Array:
    """Times (m,) [s] that a second run is asked for, of which every second one is compared.

    Where drivers lead from row to row, rows between them make other steps: m = 2 n − 1 for times
    (n,), else they are the same.
    """
    if options.method != KINEMATICS or len(times) < 2:
        return times
    between = times[:-1] + (np.sqrt(5.0) - 1.0) / 2.0 * np.diff(times)
    return np.insert(times, np.arange(1, len(times)), between)


def error_estimate(first: Motion, second: Motion, size: float, stop: str = "") -> ErrorEstimate:
    """Error of the first of two runs: the largest |r₁ − r₂| and 4 arcsin(½ |p₁ ∓ p₂|) of bodies.

    Positions r (n, 3) [unit of the scene] are in frame O, p (n, 4) [-] are Euler parameters; of ∓
    that which gives the smaller angle.

    Parameters
    ----------
    first, second : Motion
        Rows at the same times; the second one may have fewer.
    size : float [unit of the scene]
        A length of the scene.
    stop : str
        Why the second one has fewer.
    """
    count = min(len(first), len(second))
    lengths, angles = np.zeros(count), np.zeros(count)
    for name, position in first.position.items():
        offset = position[:count] - second.position[name][:count]
        lengths = np.fmax(lengths, np.sqrt(np.einsum("ij,ij->i", offset, offset)))
    for name, p in first.orientation.items():
        offsets = [p[:count] + sign * second.orientation[name][:count] for sign in (-1.0, 1.0)]
        chord = np.sqrt(np.minimum(*(np.einsum("ij,ij->i", offset, offset) for offset in offsets)))
        angles = np.fmax(angles, 4.0 * np.arcsin(np.minimum(0.5 * chord, 1.0)))
    apart = np.flatnonzero(~((lengths <= APART * size) & (angles <= APART)))
    comparable = int(apart[0]) if len(apart) else count
    unknown_from = float(first.time[max(comparable - 1, 0)]) if comparable < len(first) else None
    length, angle = (float(errors[:comparable].max(initial=0.0)) for errors in (lengths, angles))
    reason = stop if comparable == count < len(first) else ""
    return ErrorEstimate(length, angle, first.unit, second.method, unknown_from, reason)
