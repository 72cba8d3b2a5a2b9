"""Switching: steps end where formulas of time have a kink or a jump, and miss nothing between.

A scene bounds its switching functions and their rates between any two times. Where these exclude
a root there is none, so that no two roots hide in one step. Parts that vary with time beyond
polynomials are bounded likewise: a step is at most as long as the times between which samples tell
how such a part varies, so that none leaps over a narrow bump.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from .arithmetic import larger, smaller
from .pivot_monitor import scale_by_distance
from .poles import FURTHER
from .projection import project
from .roots import stays_positive
from .row_switch import forget_trials
from .search import (
    SMALLEST,
    evaluate_node,
    half_width,
    largest,
    middle,
    note_unresolved,
    read_of,
    side_at,
)
from .settings import BENT, NO_TIME, Status
from .variation import (
    FINEST,
    UNRESOLVED,
    add_cell,
    begin_variation,
    negligible_variation,
    sampling_of,
)

if TYPE_CHECKING:
    from .arithmetic import Array
    from .scene_tables import Work, Workspace
    from .search import Flags
    from .state import State

#: Largest number of intervals that a search looks at; then the run goes on to where the search
#: came.
MOST_INTERVALS = 4096
#: Number of these intervals after which laws of drivers are no longer looked at: a law whose bounds
#: do not tell by then whether it bends is gone over, and counted.
MOST_BOUNDS = 4000
#: Number of short steps in a row after which samples bound steps no more, until steps are long
#: again.
MOST_SHORT = 1000
#: A step is short if samples bound it below this part of the longest step tried.
SHORT = 1e-4
#: The longest step tried is taken as no more than this many times the longest one made: a span says
#: nothing of how long steps could be.
GROWTH = 10.0
#: Factor by which the longest step tried fades in each step.
FORGETTING = 0.9999
#: Steps are long again from this part of the longest step tried.
LONG = 0.1
#: Larger distance from a switch at which laws of drivers are compared on both sides, relative to
#: the time: no law bends there that goes on smoothly as seen from one of both distances.
FAR_BESIDE = 1e-6
#: Smaller distance at which they are compared.
BESIDE = 1e-7
#: Rounding of laws of drivers, relative to their values.
EQUAL = 1e-12
#: Distance behind a switch up to which forces are tried until they have values, relative to the
#: time: a force may be infinite at the switch itself.
FURTHEST_BEHIND = 1e-12
#: Factor by which the third derivative of a law may exceed those on both sides of a switch.
BENDING = 4.0
#: Ratio of each displacement of bodies to the one before, of which the first is their rounding:
#: three of them tell whether forces are too steep for doubles.
FAR_BY_ROUNDING = 16.0
#: Changes of forces by two such displacements are those of a slope if they deviate from it by at
#: most this part of the larger change.
EVEN_SLOPE = 0.03
#: Their means over both sides are those of a kink if they deviate from it by at most this part.
EVEN_KINK = 0.01
#: A body that is pushed back by more than this many times its displacement until the end of the run
#: swings: once and a half or more often.
SWINGS = 100.0
#: Multiples of this number lie evenly between integers.
GOLDEN_RATIO = 0.6180339887498949
#: Factor of the squares of these multiples that scatters them between integers.
SCATTERING = 997.0
#: Number of pieces of an interval, with a sample at each end of them.
PIECES = 4


def bounds_between(first: float, last: float, w: Workspace) -> tuple[Array, Array]:
    """Bounds (4, n) of switching functions and (4, m) of varying parts between two times [s].

    Least and most value in the unit of the formula, slowest and fastest rate per second.
    """
    w.span[:] = first, last
    w.run("switching")
    return w.switches.reshape(-1, 4).T, w.features.reshape(-1, 4).T


def switches_at(time: float, w: Workspace) -> Array:
    """Values (n,) of switching functions at a time [s], in the units of their formulas."""
    switches, _ = bounds_between(time, time, w)
    values: Array = switches[0].copy()
    return values


def are_rootless(bounds: Array, before: Array, after: Array, h: float) -> bool:
    """Whether switching functions have no root in an interval.

    Those that are zero all along have none, nor have those that rise or fall all along between
    values of one sign. Else each is no less than lines from both ends as steep as its bounds.

    Parameters
    ----------
    bounds : (4, n) array
        As of :func:`bounds_between`.
    before, after : (n,) array
        Values at both ends, in the units of the formulas.
    h : float [s]
        The length of the interval.
    """
    least, most, slowest, fastest = bounds
    is_far = (least > 0.0) | (most < 0.0) | ((least == 0.0) & (most == 0.0))
    # whatever rounding makes of bounds
    is_same = np.sign(before) == np.sign(after)
    is_steady = (slowest >= 0.0) | (fastest <= 0.0)
    down = before < 0.0
    a, b = np.where(down, -before, before), np.where(down, -after, after)
    falls, rises = np.where(down, -fastest, slowest), np.where(down, -slowest, fastest)
    is_near = stays_positive(a, b, falls, rises, h)
    return bool(np.all(is_same & (is_far | is_steady | is_near)))


def bound_laws(first: float, last: float, w: Workspace) -> Array:
    """Bounds (laws, 3, 4) of laws of drivers between two times [s], and of two derivatives.

    Least and most of each, in the unit of the law per s⁰, s¹, s², then of its rate.
    """
    w.law_span[:] = first, last
    w.run("bending")
    return w.laws.reshape(-1, 3, 4)


def are_unbent(first: float, last: float, span: float, w: Workspace) -> bool:
    """Whether rates of laws change evenly within rounding of times, all along between two times.

    The uneven change, from bounds of the third derivative, is at most the part ``BENT`` of the
    rate. If the law is at rest there, it is compared with its rate further away, or with the law
    itself over the whole time.
    """
    no_time, laws = NO_TIME * SMALLEST * span, np.abs(bound_laws(first, last, w))
    fastest = largest(laws[:, 1, 0], laws[:, 1, 1])
    size = largest(fastest, largest(laws[:, 0, 0], laws[:, 0, 1]) / span)
    change = (laws[:, 2, 2] + laws[:, 2, 3]) * no_time * no_time
    if not np.isfinite(change).all():
        return False
    if (change <= BENT * size).all():
        return True
    far = FAR_BESIDE * span
    for time in (first - far, last + far):
        rate = np.abs(bound_laws(time, time, w)[:, 1, 0])
        size = largest(np.where(np.isfinite(rate), rate, 0.0), size)
    return bool(np.all(change <= BENT * size))


def laws_at(time: float, w: Workspace) -> Array:
    """Laws of drivers (laws, 4) at a time [s], each with two derivatives, and a third.

    In the unit of the law per s⁰ to s³.
    """
    bounds = bound_laws(time, time, w)
    return np.column_stack((bounds[:, :, 0], bounds[:, 2, 2]))


def law_rounding(time: float, span: float, w: Workspace) -> Array:
    """Error (laws, 3) that rounding may leave of laws and two derivatives at a time [s].

    They may be differences of much larger terms: bounds within rounding of the time tell it.
    """
    no_time = NO_TIME * SMALLEST * span
    bounds = bound_laws(time - no_time, time + no_time, w)
    width = bounds[:, :, 1] - bounds[:, :, 0]
    return np.where(np.isfinite(width), width, 0.0)


def bent_beside(far: float, first: float, last: float, span: float, w: Workspace) -> int:
    """First law without two derivatives between two times, counted from 1, or 0.

    Values at a distance beside both times tell it: the law and each derivative change by the mean
    of the next derivative on both sides, and the law in between lies between its values, if it has
    one there.
    """
    rounding = law_rounding(first - far, span, w) + law_rounding(last + far, span, w)
    between = laws_at(0.5 * (first + last), w)[:, 0]
    before, after = laws_at(first - far, w), laws_at(last + far, w)
    half = 0.5 * (last - first) + far
    unexplained = after[:, :3] - before[:, :3] - half * (before[:, 1:] + after[:, 1:])
    third = np.abs(before[:, 3:]) + np.abs(after[:, 3:])
    bending = BENDING * third * np.array([half * half * half, half * half, half])
    size = EQUAL * (np.abs(before[:, :3]) + np.abs(after[:, :3])) + rounding
    are_smooth = np.all(np.abs(unexplained) <= size + bending, axis=1)
    second = (np.abs(before[:, 2]) + np.abs(after[:, 2])) * (half * half)
    deviation = np.abs(between - 0.5 * (before[:, 0] + after[:, 0]))
    are_smooth &= ~(deviation > size[:, 0] + second + bending[:, 0])
    return 0 if are_smooth.all() else int(np.argmin(are_smooth)) + 1


def bent_law(first: float, last: float, span: float, work: Work) -> int:
    """First law that bends or jumps between two times that are nearly one, or 0."""
    if not work.scene.has_laws or bent_beside(FAR_BESIDE * span, first, last, span, work.w) == 0:
        return 0
    return bent_beside(BESIDE * span, first, last, span, work.w)


def lost_gap(first: float, last: float, w: Workspace) -> int:
    """First driven distance, a gap, that is none between two times, counted from 1, or 0."""
    if w.gaps.size == 0:
        return 0
    is_none = np.zeros(w.gaps.size // 4, dtype=bool)
    # where one gets on the other side bounds may be above it by rounding
    for time in (first, last):
        bounds_between(time, last, w)
        is_none |= w.gaps.reshape(-1, 4)[:, 0] <= 0.0
    return int(np.argmax(is_none)) + 1 if is_none.any() else 0


def is_even(
    first: float,
    last: float,
    span: float,
    before: Array,
    after: Array,
    work: Work,
    *,
    follows: bool,
) -> bool:
    """Whether there is no root of a switching function between two times [s], nor bends a law.

    Functions have values before and after (n,), in their units. Laws count where they are followed.
    """
    if work.scene.has_switches:
        bounds, _ = bounds_between(first, last, work.w)
        if not are_rootless(bounds, before, after, last - first):
            return False
    if not follows or are_unbent(first, last, span, work.w):
        return True
    # bounds may be infinite at a single time
    return last - first <= SMALLEST * span and bent_law(first, last, span, work) == 0


def find_switch(end: float, state: State, work: Work) -> None:
    """Find the first root of a switching function, or bend of a law: no step goes beyond it."""
    w, first, has_switches = work.w, state.time, work.scene.has_switches
    h, span = end - first, larger(abs(first), abs(end))
    before = after = switches_at(first, w) if has_switches else np.empty(0)
    follows = work.scene.has_laws
    for n in range(MOST_INTERVALS):
        last = first + h if h < end - first else end
        after = switches_at(last, w) if has_switches else after
        if n == MOST_BOUNDS and follows:
            note_unresolved(first, state)
            follows = False
        if is_even(first, last, span, before, after, work, follows=follows):
            first, before = last, after
            if first == end:
                break
            h = 2.0 * h
        elif last - first <= SMALLEST * span:
            state.limit, state.behind = first, last
            return
        else:
            h = 0.5 * (last - first)
    # laws without a bend limit no step
    state.limit = state.behind = math.inf if not has_switches and first == end else first


def is_put_behind(span: float, state: State, work: Work) -> bool:
    """Put bodies behind a switch, and return whether forces have values there.

    If a force is infinite at the switch, as log|t - 5| is, they are put a little further behind it.
    """
    further = SMALLEST
    while further < FURTHEST_BEHIND:
        forget_trials(work)
        if project(state.time, 0.0, state.y, state.low, state.f, work, state) >= 0.0:
            return True
        state.time = state.switched = state.switched + further * span
        further *= FURTHER
    return False


def note_impulse(before: float, acceleration: float, state: State, work: Work) -> None:
    """Note what a force that is infinite at a switch may do while bodies are put behind it.

    Nothing moves there, and rounding hides times that are nearer to the switch. The change of speed
    is estimated as the time between both sides times the accelerations on both: that is its size
    for 1/sqrt|t - 5|, or so large that it tells of a steeper force. Where no force can be infinite
    it is no more than rounding.
    """
    w, scene, n = work.w, work.scene, len(state.sides)
    if scene.n_poles == 0:
        return
    sides = []
    for time in (before, state.time):
        read = read_of(time, state.y, w)
        sides.append(
            side_at(evaluate_node(read, np.zeros_like(read), time, w))[n - scene.n_poles : n]
        )
    if (sides[0] != sides[1]).any():
        total = acceleration + w.size_of(state.f[scene.nq :])
        state.impulse += (state.time - before) * total
        state.impulse_time = state.time


def widths_of(read: Array, noise: Array, time: float, w: Workspace) -> tuple[Array, Array]:
    """Half widths, and sizes, (n,) of parts of forces where formulas read (n, 2), known to a noise.

    These are the parts that vary beyond polynomials.
    """
    node, end = evaluate_node(read, noise, time, w), (len(w.functions) - len(w.infinite)) // 4
    parts = slice(end - len(w.narrow) // 4, end)
    return half_width(node)[parts], np.abs(middle(node)[parts])


def find_steep(read: Array, noise: Array, time: float, w: Workspace) -> Flags:
    """Parts (n,) of forces that change, by rounding of what they read, as none that has a slope.

    Such a part changes by much more than a sixteenth of its change by sixteen times the rounding.
    """
    wider, _ = widths_of(read, FAR_BY_ROUNDING * noise, time, w)
    widths, sizes = widths_of(read, noise, time, w)
    least = largest(EVEN_SLOPE * wider, SMALLEST * sizes)
    return np.asarray(widths - wider / FAR_BY_ROUNDING > least)


def scattered(n: Array) -> Array:
    """Numbers between -1 and 1, different for all n, none a multiple or difference of others."""
    part = np.fmod(n * GOLDEN_RATIO, 1.0)
    return np.asarray(2.0 * np.fmod(SCATTERING * part * part, 1.0) - 1.0)


def displace_by_rounding(times: float, y: Array, f: Array, state: State, work: Work) -> bool:
    """Put bodies elsewhere, y (ny,), and make them faster, by so many roundings.

    Gives the derivative f (ny,) there; returns whether there is one.
    """
    scene, part = work.scene, times * SMALLEST
    length = scene.length * scale_by_distance(state.y, scene)
    y[:] = state.y
    y[scene.shifts[:, 0]] += part * scattered(np.arange(float(len(scene.shifts)))) * length
    for index, _, count in scene.orientations.tolist():
        y[index : index + count] += part * scattered(np.arange(float(index), index + count))
    y[scene.nq :] += part * scattered(np.arange(float(scene.nv))) * (state.fastest * scene.lengths)
    forget_trials(work)
    return project(state.time, 0.0, y, None, f, work, state) >= 0.0


def read_beside(time: float, span: float, y: Array, f: Array, work: Work) -> tuple[Array, Array]:
    """Values and rates (n, 2) that formulas read of y (ny,) at a time [s], and a span [s] ahead.

    The derivative f (ny,) leads there.
    """
    read = read_of(time, y, work.w)
    work.scratch[:] = y + span * f
    return read, read_of(time, work.scratch, work.w)


def change_by_rounding(end: float, state: State, work: Work) -> float:
    """Change [1/s^2] of accelerations by rounding where forces are too steep for doubles.

    Such is that of sqrt(abs(x)) where x is zero but for rounding. Bodies on both sides of a place,
    at three distances, tell what no slope and no kink explains of even and odd parts of forces. Odd
    ones do not count where each steep part pushes a body back, beyond rounding, by what it reads:
    that swings there until the end of a run.
    """
    w, nq, time = work.w, work.scene.nq, state.time
    sizes, span = work.scene.measure_sizes, larger(abs(time), abs(end))
    longest = state.stride if state.stride > 0.0 else span
    away, read = scale_by_distance(state.y, work.scene), read_of(time, state.y, w)
    rounding = SMALLEST * (np.stack((sizes * away, sizes * state.fastest), axis=1) + np.abs(read))
    is_steep = find_steep(read, rounding, time, w)
    if not is_steep.any():
        return 0.0
    displaced, times = [], 1.0
    for n in range(6):
        if not displace_by_rounding(times, work.y, work.k[n], state, work):
            return 0.0
        displaced.append(read_beside(time, longest, work.y, work.k[n], work))
        times = -times if n % 2 == 0 else -FAR_BY_ROUNDING * times
    (above, above_ahead), (below, below_ahead) = displaced[:2]
    first, second = (above_ahead - above)[:, 1], (below_ahead - below)[:, 1]
    is_back = np.zeros_like(is_steep)
    for k, n in np.ndindex(*read.shape):
        moved, faster = 0.5 * (above[k, n] - below[k, n]), 0.5 * (first[k] - second[k])
        back = -faster if moved > 0.0 else faster
        travel = back / longest * span * (1.0 if n == 1 else span)
        is_pushed = back > SMALLEST * sizes[k] * state.fastest
        if is_pushed and travel > SWINGS * abs(moved):
            single = np.zeros_like(read)
            single[k, n] = rounding[k, n]
            is_back |= find_steep(read, single, time, w)
    pairs = work.k[:6, nq:].reshape(3, 2, -1)
    sums, changes = 0.5 * (pairs[:, 0] + pairs[:, 1]), 0.5 * (pairs[:, 0] - pairs[:, 1])
    further, least = sums[2] - sums[1], EVEN_SLOPE * np.abs(changes[1])
    even = 0.5 * np.abs((sums[1] - sums[0]) - further / FAR_BY_ROUNDING)
    odd = np.abs(changes[0] - changes[1] / FAR_BY_ROUNDING)
    change = np.where(even > largest(least, EVEN_KINK * np.abs(further)), even, 0.0)
    if (is_steep & ~is_back).any():
        change += np.where(odd > least, odd, 0.0)
    return w.size_of(change)


def note_steepness(start: float, end: float, state: State, work: Work) -> None:
    """Note what rounding changes where a step towards an end [s] ends that began at a time [s].

    It counts where the step began so steep, too, not where it came to such a place or passed it.
    """
    before, state.steepness = state.steepness, change_by_rounding(end, state, work)
    least = smaller(before, state.steepness)
    if least > 0.0:
        state.impulse += (state.time - start) * least
        state.impulse_time = state.time


def meet_switches(end: float, state: State, work: Work) -> Status:
    """Go over the switch that a step has come to, and find the next one.

    Formulas of each side hold on that side; nothing moves in between. The run ends at the switch if
    the law of a driver bends or jumps there, or a driven distance becomes zero.
    """
    while state.time < end and not state.time < state.limit:
        if state.behind > state.time:
            span = larger(abs(state.time), abs(end))
            lost = lost_gap(state.limit, state.behind, work.w)
            if lost > 0:
                state.bent = float(lost)
                return Status.NO_DIRECTION
            bent = bent_law(state.limit, state.behind, span, work)
            if bent > 0:
                state.bent = float(bent)
                return Status.BENDS
            state.y_before[:] = state.y
            state.dense[:] = 0.0
            state.time_before = state.time
            acceleration = work.w.size_of(state.f[work.scene.nq :])
            state.time = state.switched = smaller(state.behind, end)
            if not is_put_behind(span, state, work):
                return Status.NOT_PROJECTED
            note_impulse(state.time_before, acceleration, state, work)
        else:
            find_switch(end, state, work)
            if state.limit - state.time <= SMALLEST * larger(abs(state.time), abs(end)):
                state.limit = state.time  # too near for a step
    return Status.GOOD


def even_end(h: float, end: float, state: State) -> float:
    """End [s] of a step of length h [s] towards an end: half-way from a switch to the next.

    Of equal steps none is nearly all of the way, where estimates of errors can be blind alike on
    each such way.
    """
    span = end - state.time
    is_between = state.time == state.switched and end == state.limit
    return state.time + 0.5 * span if is_between and h < span < 2.0 * h else end


def sampling_in(tolerance: float, first: float, last: float, w: Workspace) -> int:
    """How well samples of an interval tell how parts vary with time.

    What is not constant is not steady: bounds that are loose beside a place where a quotient is 0/0
    would lead steps there.
    """
    h = (last - first) / PIECES
    variation = begin_variation(bounds_between(first, first, w)[1][0].copy())
    for piece in range(PIECES):
        b = first + (piece + 1) * h
        bounds = bounds_between(first + piece * h, b, w)[1].copy()
        add_cell(h, bounds_between(b, b, w)[1][0].copy(), bounds, variation)
    size, scales = largest(-variation.least, variation.most), w.scene.feature_scales
    nothing = negligible_variation(size, scales, tolerance, first, last)
    return sampling_of(variation, np.zeros_like(size), nothing, has_error=False)


def resolved_step(
    tolerance: float, h: float, part: float, end: float, state: State, work: Work
) -> float:
    """Time [s] at which a step of length h [s] must end, at most at an end.

    No longer than a part of the intervals that are resolved, unless it ends before such a one. What
    keeps steps short for long, such as a quotient that is 0/0 somewhere, is gone over and counted,
    and so is what takes too many intervals.
    """
    if not work.scene.has_features:
        return end
    start = first = state.time
    allowed = length = smaller(h, end - start)
    state.longest = larger(FORGETTING * state.longest, smaller(length, GROWTH * state.stride))
    last_step, width = start - state.time_before, length / part
    is_tired = state.short_steps > MOST_SHORT and last_step < LONG * state.longest
    is_unresolved = False
    for _ in range(MOST_INTERVALS):
        last = first + width
        is_good = sampling_in(tolerance, first, last, work.w) != UNRESOLVED
        if not is_good and width > FINEST * length:
            width = 0.5 * width
            continue
        if is_good:
            allowed = smaller(allowed, larger(first - start, part * width))
        first = last
        if not first < start + allowed:
            break
        width = 2.0 * width
    else:
        is_unresolved = True
    if is_unresolved or (is_tired and allowed < length):
        note_unresolved(start, state)
    if is_tired:
        return end
    if not allowed < SHORT * state.longest:
        state.short_steps = 0
    elif allowed < length:  # others are short by their error
        state.short_steps += 1
    if not allowed < length:
        return end
    # in equal steps: the last one must not be too short
    return start + length / math.ceil(length / allowed)
