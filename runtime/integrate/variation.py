"""Variation: whether samples of a step tell how forces vary with the state.

Parts of formulas that vary with the state beyond polynomials are bounded between samples: where
these do not show how such a part varies, the step is made shorter.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .arithmetic import larger, smaller
from .search import (
    CELLS,
    MOST_NODES,
    Search,
    bound_functions,
    half_width,
    largest,
    middle,
    node_at,
    node_with_noise,
    side_at,
    smallest,
)

if TYPE_CHECKING:
    from .arithmetic import Array

#: Samples resolve a part if the sum over all cells of the width of its rate bounds, times the
#: length of the cell, is at most this many times the range of the samples.
EXPLAINED = 2.0
#: Where formulas switch and an error is known, samples also resolve a part if the sum over all
#: cells of the width of its value bounds is at most this many times their range: a hill between two
#: samples goes up and down, and would make it twice.
SHOWN = 1.5
#: Samples are few for a part if the sum that EXPLAINED bounds is more than this many times their
#: range.
SMOOTH = 0.25
#: Negligible variation of a part, relative to its size.
NEGLIGIBLE_VARIATION = 1e-12
#: Negligible variation of a force: it moves the lightest body by this part of the tolerance, in
#: lengths of the scene.
NEGLIGIBLE_MOTION = 1e-3
#: A part needs no samples in an interval where its bounds differ by less than this part of its
#: size.
STEADY = 0.5
#: Bounds count as evenly loose if no cell has more than this part of all by which they exceed the
#: change of samples: a hill between two samples makes one cell stand out.
UNEVEN = 0.35
#: How well samples tell how parts vary.
UNRESOLVED, COARSE, RESOLVED = 0, 1, 2
#: Shortest interval in which the variation of a part is looked at, relative to the step: narrower
#: ones have no bounds.
FINEST = 1e-9


def negligible_variation(
    size: Array, scales: Array, tolerance: float, start: float, end: float
) -> Array:
    """Negligible variations (n,) of parts between two times [s], in units of their formulas.

    A force that acts as long moves a body on meanwhile, and then in as much time as has passed
    since 0.

    Parameters
    ----------
    size : (n,) array
        Their sizes.
    scales : (n, 2) array
        As of a scene: what they are compared with, and whether that is over the square of times.
    tolerance : float [-]
        Of the run.
    start, end : float [s]
        The times.
    """
    span = larger(abs(start), abs(end))
    always = NEGLIGIBLE_VARIATION * largest(size, scales[:, 0])
    forces = NEGLIGIBLE_MOTION * tolerance * (scales[:, 0] / ((end - start) * span))
    negligible = largest(NEGLIGIBLE_VARIATION * size, forces)
    return np.asarray(np.where(scales[:, 1] == 0.0, always, negligible))


class VariationBounds:
    """Variation of parts between two times, as samples and bounds of the cells between them tell.

    Parameters
    ----------
    sample : (n,) array
        Values of the parts at the first time, in units of their formulas.
    """

    def __init__(self, sample: Array) -> None:
        self.last = self.least = self.most = self.low = self.high = sample
        self.reach = self.change = self.hidden = self.most_hidden = np.zeros(len(sample))


def begin_variation(sample: Array) -> VariationBounds:
    """Variation of parts (n,) from a first sample on."""
    return VariationBounds(sample)


def add_cell(h: float, sample: Array, bounds: Array, variation: VariationBounds) -> None:
    """Add a cell of length h [s]: the sample (n,) at its end, and bounds (4, n) in it.

    These are the least and largest values, and the least and largest rates.
    """
    below, above, slowest, fastest = bounds
    v, width = variation, above - below
    hidden = width - np.abs(sample - v.last)
    v.least, v.most = smallest(sample, v.least), largest(sample, v.most)
    v.low, v.high = smallest(below, v.low), largest(above, v.high)
    v.reach, v.change = v.reach + width, v.change + h * (fastest - slowest)
    v.hidden, v.most_hidden = v.hidden + hidden, largest(hidden, v.most_hidden)
    v.last = sample


def sampling_of(v: VariationBounds, steady: Array, nothing: Array, *, has_error: bool) -> int:
    """How well samples tell how all parts vary, but for what counts as nothing.

    Samples resolve a part in one of three ways: its rate bounds are narrow beside the range of the
    samples (``EXPLAINED``); its bounds are steady (``STEADY``) and no looser in one cell, where a
    hill may hide, than in the others (``UNEVEN``); or, where formulas switch and an error is known,
    its value bounds exceed the samples by little (``SHOWN``), as of a root, at whose end no rate is
    bounded.
    """
    shown = v.most - v.least
    is_even = v.most_hidden <= UNEVEN * v.hidden + nothing
    is_steady = is_even & (v.high - v.low <= steady + nothing)
    is_shown = (v.reach <= SHOWN * shown + nothing) & has_error
    if not np.all(is_steady | is_shown | (v.change <= EXPLAINED * shown + nothing)):
        return UNRESOLVED
    return RESOLVED if np.all(is_steady | (v.change <= SMOOTH * shown + nothing)) else COARSE


def are_narrow_resolved(start: float, end: float, search: Search) -> bool:
    """Whether samples between two times tell how parts vary with the state.

    Whether they are few for that is noted.
    """
    h, first = (end - start) / CELLS, len(search.state.sides)
    n = slice(first, first + len(search.work.w.narrow) // 4)
    a = node_at(start, search)
    variation, band = begin_variation(middle(a)[n]), half_width(a)[n]
    for cell in range(1, CELLS + 1):
        b = node_at(start + cell * h, search)
        add_cell(h, middle(b)[n], bound_functions(a, b, search)[:, n], variation)
        band, a = largest(half_width(b)[n], band), b
    size, scales = largest(-variation.least, variation.most), search.work.scene.narrow_scales
    nothing = band + negligible_variation(size, scales, search.tolerance, start, end)
    # no error tells of what works miss along drivers
    steady = (0.0 if search.work.scene.is_driven else STEADY) * size
    sampling = sampling_of(variation, steady, nothing, has_error=search.has_error)
    search.is_coarse = search.is_coarse or sampling == COARSE
    return sampling != UNRESOLVED


def is_at_pole(first: float, last: float, search: Search, *, in_between: bool) -> bool:
    """Whether a function of a pole is near to zero at both times, or may be in between.

    A force may be infinite there: no bound tells how it varies, and of what is narrow the energy
    does.
    """
    n, count = len(search.state.sides), search.work.scene.n_poles
    if count == 0:
        return False
    a, b = (
        side_at(node_with_noise(search.noise, time, search))[n - count : n]
        for time in (first, last)
    )
    is_there = (a == 0.0) & (b == 0.0)
    return bool((is_there | (in_between & (a * b != 1.0))).any())


def resolved_end(end: float, search: Search) -> float:
    """Time [s] at which a step to an end must end so that samples tell how parts vary.

    What they do not tell in the finest intervals either is gone over, and noted.
    """
    start = first = search.start
    span = allowed = width = end - start
    count = 0
    while first < smaller(start + allowed, end):  # the sum may be rounded up, beyond the end
        if count == MOST_NODES:
            search.is_unresolved = search.is_unresolved or not is_at_pole(
                first, end, search, in_between=True
            )
            break
        count += 1
        last = smaller(first + width, end)
        is_there = is_at_pole(first, last, search, in_between=False)
        is_good = not is_there and are_narrow_resolved(first, last, search)
        if not (is_good or is_there) and width > FINEST * search.h:
            width = 0.5 * width
            continue
        if is_good:
            allowed = smaller(allowed, larger(first - start, last - first))
        elif not is_at_pole(first, last, search, in_between=True):
            search.is_unresolved = True
        first = last
        width = 2.0 * width
    return start + allowed if allowed < span else end
