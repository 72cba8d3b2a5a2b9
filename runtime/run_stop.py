"""Reasons why a run cannot go on: joints that are open, and those whose rows depend on others."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from kousoku.runtime.messages import MOST_PARTS_SHOWN, scene_key

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.runtime.integrate.arithmetic import Array

#: A joint is open when its residual is larger, in metres or radians.
OPEN = 1e-9
#: Below this pivot ratio the rows of joints count as dependent.
NEARLY_DEPENDENT_PIVOT_RATIO = 1e-10
#: Pivots up to this multiple of the smallest are named with it.
SMALL_PIVOT_FACTOR = 100.0


def joints_at_stop(rows: Sequence[tuple[str, str]], residuals: Array, pivots: Array) -> str:
    """End of a message: the joints that are open, and those whose rows are dependent.

    Parameters
    ----------
    rows : sequence of (str, str)
        Joint and unit of each constraint.
    residuals : array
        Residual of each where they were evaluated last.
    pivots : array
        Pivots of the factorisation at the last good state, no numbers after one that is zero.
    """
    if not rows:
        return ""
    texts = []
    sizes = np.abs(residuals)
    open_rows = [k for k in np.argsort(-sizes).tolist() if sizes[k] > OPEN]
    if open_rows:
        worst = {rows[k][0]: k for k in reversed(open_rows)}
        largest = sorted(worst.items(), key=lambda item: -sizes[item[1]])[:MOST_PARTS_SHOWN]
        gaps = [f"{scene_key(name)} by {sizes[k]:.3g} {rows[k][1]}" for name, k in largest]
        texts.append(f"open: {', '.join(gaps)}")
    finite = np.where(np.isfinite(pivots), pivots, np.inf)
    most = pivots.max(where=np.isfinite(pivots), initial=0.0)
    ratio = finite.min() / most if most > 0.0 else 0.0
    order = np.argsort(finite).tolist()
    limit = max(SMALL_PIVOT_FACTOR * finite.min(), 0.0)
    weak = dict.fromkeys(rows[k][0] for k in order if finite[k] <= limit)
    names = ", ".join(map(scene_key, list(weak)[:MOST_PARTS_SHOWN]))
    is_dependent = ratio < NEARLY_DEPENDENT_PIVOT_RATIO
    dependent = "rows are nearly dependent" if is_dependent else "the smallest pivots are"
    return f"; {'; '.join([*texts, f'{dependent} at {names} (pivot ratio {ratio:.1e})'])}"


def joints_of_bodies(
    rows: Sequence[tuple[str, str]], satisfied: Sequence[tuple[str, str]], *, is_driven: bool
) -> str:
    """End of a message: the drivers that lead bodies, or the joints that they are on.

    Parameters
    ----------
    rows, satisfied : sequence of (str, str)
        Joint and unit of each constraint that is solved for, and of those of joints that bodies are
        put onto.
    is_driven : bool
        Whether drivers determine the motion.
    """
    names = dict.fromkeys(name for name, _ in satisfied)
    drivers = [name for name in names if "." in name]
    if is_driven and drivers:
        return f"; {', '.join(drivers[:MOST_PARTS_SHOWN])} cannot lead on"
    if names and not rows:
        return f"; bodies move on {', '.join(map(scene_key, list(names)[:MOST_PARTS_SHOWN]))}"
    return ""
