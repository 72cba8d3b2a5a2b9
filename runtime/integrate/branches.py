"""Branches: whether a step stays on its branch of the motion where another one meets it, or nearly.

Roots of pivot ratios go with the distance from a place where branches meet. Where they do meet the
way leads straight on: it is smooth, and rows hold all along, as near to the place as one looks.
Where they miss each other by little, rows do not hold on the way from one to the other, the less
the nearer to the place: ways over there bend sharply, and end elsewhere.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from .pivot_monitor import pivot_ratio
from .projection import correct_position, project_position, ratio_at
from .row_switch import forget_trials
from .scene import larger, smaller

if TYPE_CHECKING:
    import numpy.typing as npt

    from .scene import Work
    from .state import State

    Array = npt.NDArray[np.float64]

#: What rows may be off a smooth way, in lengths and radians. A gap between branches of as much as
#: that, times the distance at which it is looked for, is none: about 1e-12.
OFF_WAY = 1e-9
#: How far beside the place where branches meet that is seen, in a step; how much nearer each time.
BESIDE = 0.03
NEARER = 0.1
#: What rows may be off, of the distance from such a place, where that is not in a step.
AWAY = 1e-2
#: Coefficients of a polynomial through a step; memory.h has it, too.
WAY = 12


class Way:
    """Newton's polynomial through coordinates at parts of a step.

    Parameters
    ----------
    h : float [s]
        Length of the step.
    y_before, f_before, y, f : (ny,) array
        The states at its ends and their derivatives: a cubic leads through these.
    work : Work
        Memory for work.
    state : State
        Counts what is evaluated.
    """

    def __init__(
        self,
        h: float,
        y_before: Array,
        f_before: Array,
        y: Array,
        f: Array,
        work: Work,
        state: State,
    ) -> None:
        q = slice(work.scene.nq)
        step, first = y[q] - y_before[q], h * f_before[q]
        bend = step - first
        self.h = h
        self.parts = [0.0, 0.0, 1.0, 1.0]
        self.coefficients = [y_before[q].copy(), first, bend, h * f[q] - step - bend]
        self.work = work
        self.state = state

    def at(self, part: float) -> Array:
        """Return the coordinates at a part of the step."""
        q = self.coefficients[-1]
        for x, coefficient in zip(self.parts[-2::-1], self.coefficients[-2::-1], strict=True):
            q = q * (part - x) + coefficient
        return q

    def bend(self, part: float) -> tuple[float, float]:
        """Bring the place at a part of the step onto the constraints, and lead through it.

        Returns
        -------
        off : float
            How far off it was, negative where it cannot be brought.
        ratio : float
            The pivot ratio there.
        """
        work, state, w = self.work, self.state, self.work.w
        q = self.at(part)
        w.t[0] = state.time + part * self.h
        ratio = ratio_at(q, work, state)
        correct_position(work)
        state.factorisations += 1
        state.corrections += 1
        off = w.size_of(w.dq)
        if not off <= OFF_WAY:  # else that changes neither the way nor the ratio
            w.displace(None)
            if not project_position(OFF_WAY * OFF_WAY, work, None, state) >= 0.0:
                return -1.0, 0.0
            ratio = pivot_ratio(work, state)
        product = 1.0
        for x in self.parts:
            product *= part - x
        self.coefficients.append((w.q - q) / product)
        self.parts.append(part)
        return off, ratio


def stays_on_branch(
    h: float, y: Array, f: Array, part: float, slope: float, work: Work, state: State
) -> bool:
    """Return whether a step of length h to y and f stays on its branch.

    About at a part of it, with a slope of the roots of pivot ratios, branches meet, or nearly.
    """
    forget_trials(work)
    way, beside = Way(h, state.y, state.f, y, f, work, state), BESIDE
    farthest, nearest = 0.0, math.inf
    for _ in range(4, WAY, 2):
        roots, worst = [], 0.0
        for side in (-beside, beside):
            off, ratio = way.bend(part + side)
            if not off >= 0.0:
                return False
            roots.append(math.sqrt(ratio))
            worst = larger(worst, off)
            farthest = larger(farthest, off)
            nearest = smaller(nearest, roots[-1])
        total, change = roots[0] + roots[1], roots[1] - roots[0]
        usual = 2.0 * beside * slope
        is_between = total > 0.0 and abs(total - usual) <= abs(abs(change) - usual)
        above, below = (change, total) if is_between else (total, change)
        part -= float(np.divide(beside * above, below))
        is_inside = 0.0 < part < 1.0
        if not is_between and is_inside:
            continue  # the place is farther away
        if worst <= OFF_WAY:
            return is_between or farthest <= AWAY * nearest
        if is_between:
            slope = total / (2.0 * beside)
        if not is_inside:
            part = 1.0 if part > 0.5 else 0.0
        beside *= NEARER
    return False
