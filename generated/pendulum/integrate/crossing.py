"""Crossing: steps end where events are and where formulas of the state have a kink or a jump.

This is event location: a step that was tried is searched before it is kept. Its polynomial, the
dense output, gives at some times what formulas read: coordinates, lengths of springs, their rates.
Bounds of these between the times bound the functions and their rates, as of switching functions of
time. Values that are nearer to zero than the error of a step count as zero: a function crosses when
it is beyond on the other side. Where bounds show that one crosses once, its time is bisected. Then
the step is made again, to end there. Parts of formulas that vary with the state beyond polynomials
are bounded likewise: where samples do not show how, the step is made shorter.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from .arithmetic import larger, smaller
from .dense_output import add_dense_rows, combine, hermite_cubic, interpolate
from .pivot_monitor import scale_by_distance
from .settings import ACTIONS, Status

if TYPE_CHECKING:
    import numpy.typing as npt

    from .arithmetic import Array
    from .methods import RungeKuttaMethod
    from .scene_tables import Work, Workspace
    from .settings import Settings
    from .state import State

    Flags = npt.NDArray[np.bool_]

#: Smallest step, relative to the time, and rounding of values, relative to their size.
SMALLEST = 1e-15
#: A step, or an interval of one, that comes within 1e-7 of its length to the last time ends there:
#: no sliver is left.
STRETCH_TO_END = 1.0000001
#: Shortest step to a cut, and shortest first trial of a step, in smallest steps.
ONWARD = 8.0
#: Smallest number of intervals in which a step is searched.
CELLS = 4
#: Largest number of intervals that are looked at in one search.
MOST_NODES = 512
#: Second derivatives of what formulas read are taken to lie within this many times their rise in
#: the cubic polynomial, above and below their mean.
DOUBT = 2.0
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
#: Largest distance of an event that is located again from the cut, relative to the step.
SMALL = 1e-3
#: Ratio of two distances from a crossing at which a function is compared.
FURTHER = 8.0
#: A function passes zero if it is at least this many times as large at the larger of these
#: distances; one that jumps there, or is infinite, is not.
LARGER_THERE = 1.5
#: Smallest of these distances, in roundings of the time.
ROUNDINGS = 64.0
#: A step ends where a function that was near to zero takes a side, if that is within this part of
#: the step.
SOON = 0.1
#: Loosest tolerance to which values are known in a search, and loosest tolerance of steps from a
#: switch to the next: forces that switch again soon are narrow, and estimates are blind to what
#: acts for a stage or two. It also applies to each step from a kink where no force jumps: friction
#: that holds switches all the time.
LOOSEST_AT_SWITCH = 1e-5
#: Speed that is added to rates to scale their errors, in lengths of the scene or radians over the
#: longest step so far: in a short step the rates of what moves are no better known, and no worse.
SLOW = 1e-4
#: A part of a force is infinite at a place if it grows by more than this factor each time one comes
#: FURTHER times nearer: 1/x grows by FURTHER.
STEEP = 7.0
#: Two such growth factors in succession differ by at most this ratio where a part is infinite.
EVENLY = 1.5
#: A step that leads over a pole of a force is made again, over this part of the way to the pole.
CLOSER = 0.9
#: A run ends where the way to a pole is at most this part of its longest step. An event that is
#: back at zero within this part of it may have been thrown back.
NO_WAY = 1e-6
#: A function is near to zero at a node where it is less than this many times its noise; the noise
#: at other nodes tells nothing of how near it comes to zero between them.
BANDS = 16.0
#: Time of a look back at an event that is back at zero, in units of the time since it passed zero:
#: one that has gone evenly through a narrow window was outside of it then.
EARLIER = 1.5
#: Times of a second look back and of one ahead, in the same unit: such an event was in the window
#: then, and will be outside again.
HALF = 0.5
#: A zero is transversal if at its speed the value leaves this many times its noise, within the
#: longest step so far and before it comes to rest; the same holds for a rate, which changes as fast
#: as it does. Such values are known to rounding.
PASSING = 16.0
#: A stage with weight at the end of a step is searched for a contact if its accelerations change
#: speeds by more than this part in the step: for less the error tells enough.
PUSHED = 0.1


def largest(a: Array, b: Array) -> Array:
    """Larger of each two numbers (n,), the second if the first is a NaN."""
    return np.where(a > b, a, b)


def smallest(a: Array, b: Array) -> Array:
    """Smaller of each two numbers (n,), the second if the first is a NaN."""
    return np.where(a < b, a, b)


def stays_positive(a: Array, b: Array, falls: Array, rises: Array, h: float) -> Flags:
    """Whether functions (n,) of values a and b at the ends of h [s] are positive in between.

    None is less than lines from both ends as steep as it falls and rises (n,) at most, per second.
    """
    are_positive: Flags = a * rises - b * falls + falls * rises * h > 0.0
    return are_positive


def note_unresolved(time: float, state: State) -> None:
    """Note a step from a time on over which bounds do not tell how formulas vary."""
    state.unresolved += 1
    state.unresolved_time = time


@dataclass(slots=True)
class TimeNode:
    """Node of the search, at a time of a step.

    Parameters
    ----------
    time : float [s]
        Time of the node.
    read : (n, 2) array
        Values that formulas read, and their rates.
    least, most : (functions,) array
        Bounds of each function.
    """

    time: float
    read: Array
    least: Array
    most: Array


@dataclass(slots=True)
class Search:
    """Search for crossings in a step, whose polynomial is in the state.

    Parameters
    ----------
    state, work : State, Work
        Of the run.
    cut : float [s]
        Time at which the step was cut.
    m, start, h : RungeKuttaMethod, float [s], float [s]
        How it was made: its method, start and length.
    least_part : float
        Earliest part of the step at which it may be cut.
    tolerance : float [-]
        Of the run.
    slack : float [s]
        Time within which crossings count as one.
    noise, rounding : (n, 2) array
        Errors of each number that is read and of its rate: in the motion, and in its polynomial.
    sizes : (n,) array
        Sizes of the terms that each number read is made of: its rounding is relative to these,
        however small the number is.
    second_mean, second_rise, second_bound : (n,) array
        Second derivatives of what is read: their mean, rise above it at the end, and bound.
    rate_noise : (n,) array
        Errors of rates by which it is decided whether they pass by: at most what rates have been.
    crosses, was_crossing : array of bool
        Whether each function crosses in the step, and crossed where the step was cut.
    is_short : array of bool
        Whether each event has been noted by an earlier step that ended a little before its zero.
    is_unresolved : bool
        Whether samples do not resolve how parts vary with the state somewhere in the step.
    is_coarse : bool
        Whether samples are few for how such a part varies in the step.
    has_error : bool
        Whether formulas switch and the error decides how long the step is.
    is_kept : bool
        Whether the error of the step is within the tolerance.
    undefined : int
        1-based index of the event without a value right behind the start; 0: none.
    pole : int
        1-based index of the function that is zero where a force is infinite; 0: none.
    pole_time : float [s]
        Time at which this function is zero.
    place_cuts : int
        Number of times that the step was cut for distances and jumps.
    place_cut, place : float [s]
        End of the last such cut, and the time of the distance or jump that it was made for.
    is_over : bool
        Whether a step to this cut only leads over the distance or jump.
    breaks : array [s]
        Upper bounds of the first crossing of each function at which a force jumps, or infinite.
    """

    state: State
    work: Work
    cut: float
    m: RungeKuttaMethod = field(init=False)
    start: float = 0.0
    h: float = 0.0
    least_part: float = 0.0
    tolerance: float = 0.0
    slack: float = 0.0
    noise: Array = field(init=False)
    rounding: Array = field(init=False)
    sizes: Array = field(init=False)
    second_mean: Array = field(init=False)
    second_rise: Array = field(init=False)
    second_bound: Array = field(init=False)
    rate_noise: Array = field(init=False)
    crosses: Flags = field(init=False)
    was_crossing: Flags = field(init=False)
    is_short: Flags = field(init=False)
    is_unresolved: bool = False
    is_coarse: bool = False
    has_error: bool = False
    is_kept: bool = True
    undefined: int = 0
    pole: int = 0
    pole_time: float = 0.0
    place_cuts: int = 0
    place_cut: float = math.inf
    place: float = math.inf
    is_over: bool = False
    breaks: Array = field(init=False)


def side_at(node: TimeNode) -> Array:
    """Side of zero of each function (functions,), 1 or -1, 0 where that is not known."""
    return np.where(node.least > 0.0, 1.0, np.where(node.most < 0.0, -1.0, 0.0))


def middle(node: TimeNode) -> Array:
    """Middle of each function's bounds (functions,)."""
    return np.multiply(0.5, node.least + node.most)


def half_width(node: TimeNode) -> Array:
    """Half of the distance between each function's bounds (functions,)."""
    return np.multiply(0.5, node.most - node.least)


def read_of(time: float, y: Array, w: Workspace) -> Array:
    """Values and rates (n, 2) that formulas read of y (ny,) at a time [s]; rates per second."""
    w.place(time, y)
    w.run("measure")
    measures: Array = w.measures.reshape(-1, 2).copy()
    return measures


def read_at(time: float, search: Search) -> Array:
    """Values and rates (n, 2) that formulas read at a time [s] of the step; rates per second."""
    interpolate(search.m, (time - search.start) / search.h, search.state, search.work.scratch)
    return read_of(time, search.work.scratch, search.work.w)


def node_at(time: float, search: Search) -> TimeNode:
    """Node at a time of the motion.

    Values and rates that pass by are taken from the polynomial, with its rounding, however far off
    it may be, so that nothing narrower than the noise is passed over. All others have the noise,
    and so have all where a force may be infinite.
    """
    read, n, n_poles = read_at(time, search), len(search.state.sides), search.work.scene.n_poles
    if n_poles:
        node = evaluate_node(read, search.noise, time, search.work.w)
        if not side_at(node)[n - n_poles : n].all():
            return node
    return evaluate_node(read, noise_at(time, read, search), time, search.work.w)


def noise_at(time: float, read: Array, search: Search) -> Array:
    """Noise (n, 2) of what formulas read (n, 2) at a time [s]: of what passes by only rounding."""
    third = 2.0 * np.abs(search.second_rise) / search.h
    accelerations = np.column_stack((search.second_bound, third))
    speeds = np.column_stack((np.abs(read[:, 1]), second_at(time, search)))
    return np.where(passes_by(speeds, accelerations, search), search.rounding, search.noise)


def passes_by(speeds: Array, accelerations: Array, search: Search) -> Flags:
    """Whether values of such speeds and bounds of accelerations get far beyond their noise.

    Columns (n, 2) are of values, per second and its square, and of rates, one power higher.
    """
    far = PASSING * np.column_stack((search.noise[:, 0], search.rate_noise))
    is_far: Flags = speeds * larger(search.state.stride, search.h) > far
    return is_far & (speeds * speeds > far * accelerations)


def second_at(time: float, search: Search) -> Array:
    """Sizes (n,) of second derivatives at a time [s], less what rounding makes of them."""
    part, h = (time - search.start) / search.h, search.h
    change = np.abs(search.second_mean + (2.0 * part - 1.0) * search.second_rise)
    sizes: Array = change - 2.0 * search.rounding[:, 1] / h
    return sizes


def node_with_noise(noise: Array, time: float, search: Search) -> TimeNode:
    """Node at a time [s], where values and rates are known to a given noise (n, 2)."""
    return evaluate_node(read_at(time, search), noise, time, search.work.w)


def evaluate_node(read: Array, noise: Array, time: float, w: Workspace) -> TimeNode:
    """Node at a time [s] where formulas read values and rates (n, 2), known to a noise (n, 2)."""
    ranges = w.ranges[2:].reshape(-1, 6)
    w.ranges[:2] = time
    ranges[:, [0, 2]], ranges[:, [1, 3]], ranges[:, 4:] = read - noise, read + noise, 0.0
    w.run("crossing")
    least, most = w.functions.reshape(-1, 4).T[:2].copy()
    return TimeNode(time, read, least, most)


def stage_beyond(first: int, seen: float, search: Search) -> float:
    """Time [s] of a stage, from a first one on, beyond a switch that its polynomial does not meet.

    Such a stage is in a contact that the step leads over: the force there makes the polynomial
    useless. If there is none, it is the time up to which the step is seen. A stage with weight at
    the end of the step, where the error tells of it, counts only if it changes speeds; and no such
    stage counts beyond a jump, which throws back what passes it a little.
    """
    m, state, work, scene = search.m, search.state, search.work, search.work.scene
    size_of, n_switching = work.w.size_of, len(state.sides) - scene.n_poles
    slow = PUSHED * size_of(state.y[scene.nq :])
    for k in range(first, m.all):
        time = search.start + m.c[k] * search.h
        if not time < seen:
            continue
        if k <= m.stages and search.h * size_of(work.k[k][scene.nq :]) <= slow:
            continue
        combine(k, m.a[k], state.y, search.h, work.k, work.scratch)
        node = evaluate_node(read_of(time, work.scratch, work.w), search.noise, time, work.w)
        last = n_switching if k > m.stages else n_switching - scene.n_breaks
        switching = slice(len(scene.events), last)
        sides = state.sides[switching]
        if np.any((sides != 0.0) & (side_at(node)[switching] == -sides)):
            return time
    return seen


def begin_search(
    s: Settings,
    m: RungeKuttaMethod,
    h: float,
    y: Array,
    f: Array,
    search: Search,
    *,
    has_stages: bool,
) -> None:
    """Make the polynomial of a step of h [s] from the state to y (ny,), with f = ẏ (ny,) there."""
    state, sizes = search.state, search.work.scene.measure_sizes
    search.m, search.start, search.h = m, state.time, h
    search.tolerance, search.slack = s.tolerance, s.tolerance * h
    search.is_unresolved, search.breaks = False, np.full(search.work.scene.n_breaks, math.inf)
    state.y_before[:] = state.y
    state.dense[:] = 0.0
    hermite_cubic(h, y, state.f, f, state)
    if has_stages:
        add_dense_rows(m, h, state, search.work)
    first, last = read_at(state.time, search), read_at(state.time + h, search)
    most = largest(np.abs(first), np.abs(last))
    search.second_mean = (last[:, 1] - first[:, 1]) / h
    away = scale_by_distance(state.y, search.work.scene)  # y may be thrown off
    search.sizes = sizes * away
    search.second_rise = second_rise_of(search.sizes, first, last, h)
    search.second_bound = np.abs(search.second_mean) + np.abs(search.second_rise)
    fast = most[:, 1] + SLOW * sizes / larger(state.stride, h)
    search.rounding = np.empty_like(most)
    search.rounding[:, 0] = SMALLEST * (search.sizes + most[:, 0])
    search.rounding[:, 1] = SMALLEST * fast
    search.noise = np.empty_like(most)
    place_noise = smaller(s.tolerance, LOOSEST_AT_SWITCH) * sizes + SMALLEST * most[:, 0]
    search.noise[:, 0] = largest(place_noise, search.rounding[:, 0])
    search.noise[:, 1] = s.tolerance * fast
    search.rate_noise = smallest(search.noise[:, 1], most[:, 1] + sizes * state.fastest)


def second_rise_of(sizes: Array, a: Array, b: Array, h: float) -> Array:
    """Rise of second derivatives (n,) at the end of h [s] above their mean, in cubic polynomials.

    From values and rates (n, 2) at both ends, less rounding.
    """
    (x, v), (y, u) = a.T, b.T
    rounding = 6.0 * SMALLEST * (sizes + np.abs(x) + np.abs(y)) / h
    change = 3.0 * (v + u) - 6.0 * (y - x) / h
    rise: Array = np.copysign(largest(np.zeros_like(change), np.abs(change) - rounding) / h, change)
    return rise


def bound_functions(a: TimeNode, b: TimeNode, search: Search) -> Array:
    """Least and most value, slowest and fastest rate (4, functions) between two nodes."""
    w, h = search.work.w, b.time - a.time
    (x, v), (y, u) = a.read.T, b.read.T
    ranges = w.ranges[2:].reshape(-1, 6)
    w.ranges[:2] = a.time, b.time
    mean, rise = (
        (u - v) / h,
        np.abs(second_rise_of(search.sizes, a.read, b.read, h)),
    )
    ranges[:, 4], ranges[:, 5] = mean - DOUBT * rise, mean + DOUBT * rise
    reach_between(v, u, ranges[:, 4], ranges[:, 5], h, ranges[:, 2:4])
    reach_between(x, y, ranges[:, 2], ranges[:, 3], h, ranges[:, :2])
    w.run("crossing")
    return w.functions.reshape(-1, 4).T


def cut_at(end: float, search: Search) -> float:
    """Cut a step where it must end [s], and remember what crosses there."""
    search.was_crossing, search.cut = search.crosses, end
    return end


def reach_between(
    a: Array, b: Array, slowest: Array, fastest: Array, h: float, reach: Array
) -> None:
    """Write least and most (n, 2) between values a and b (n,) at the ends of h [s].

    The slope is bounded by the slowest and the fastest rate (n,), per second.
    """
    is_open = (slowest < 0.0) & (fastest > 0.0)
    spread, curve = fastest - slowest, slowest * fastest * h
    least, most = smallest(a, b), largest(a, b)
    down = smallest(least, (fastest * a - slowest * b + curve) / spread)
    up = largest(most, (fastest * b - slowest * a - curve) / spread)
    reach[:, 0], reach[:, 1] = np.where(is_open, down, least), np.where(is_open, up, most)


def band_at(node: TimeNode, search: Search) -> Array:
    """Half widths (functions,) at a node, by the noise of events that a step starts short of."""
    band = half_width(node)
    if search.is_short.any():
        known = half_width(node_with_noise(search.noise, node.time, search))
        n = len(search.is_short)
        band[:n] = np.where(search.is_short, known[:n], band[:n])
    return band


def is_isolated(sides: Array, a: TimeNode, b: TimeNode, bounds: Array, search: Search) -> Flags:
    """Whether functions cross between two nodes as often as their sides tell: root isolation.

    Sides (functions,) are those before, bounds (4, functions) those of :func:`bound_functions`.
    """
    n, is_down = len(sides), sides < 0.0
    low, high, slowest, fastest = bounds[:, :n]
    sign, least = np.where(is_down, -1.0, 1.0), np.where(is_down, -high, low)
    falls, rises = np.where(is_down, -fastest, slowest), np.where(is_down, -slowest, fastest)
    band_a, band_b = band_at(a, search)[:n], band_at(b, search)[:n]
    first, last = sign * middle(a)[:n], sign * middle(b)[:n]
    near_a = np.where((sides == 0.0) | (first < BANDS * band_a), band_a, 0.0)
    near_b = np.where((sides == 0.0) | (last < BANDS * band_b), band_b, 0.0)
    within = largest(near_a, near_b)
    is_clear = (least > -within) | (falls >= 0.0) | (rises <= 0.0)
    is_positive = stays_positive(first + within, last + within, falls, rises, b.time - a.time)
    stays = is_clear | np.where(sides == 0.0, high < within, is_positive)
    crosses = (sides != 0.0) & (side_at(b)[:n] == -sides)
    crosses &= ~is_still_short(sides, b.time, search)
    are_isolated: Flags = np.where(crosses, rises <= 0.0, stays)
    return are_isolated


def has_value(node: TimeNode) -> Flags:
    """Whether each function (functions,) has a value at a node."""
    have_values: Flags = ~(np.isnan(node.least) | np.isnan(node.most))
    return have_values


def first_without_value(state: State, work: Work) -> int:
    """First event without a finite value at the state, from 1; 0 where all have one."""
    w, count = work.w, len(work.scene.events)
    if count == 0:
        return 0
    read = read_of(state.time, state.y, w)
    node = evaluate_node(read, np.zeros_like(read), state.time, w)
    is_finite = (np.isfinite(node.least) & np.isfinite(node.most))[:count]
    return 0 if is_finite.all() else int(np.argmin(is_finite)) + 1


def is_undefined(k: int, time: float, search: Search) -> bool:
    """Whether a function has no value at a time, nor right behind it.

    One that is 0/0 there alone has one behind it.
    """
    exact, onward = np.zeros_like(search.noise), ROUNDINGS * SMALLEST * larger(abs(time), search.h)
    if has_value(node_with_noise(exact, time, search))[k]:
        return False
    return not has_value(node_with_noise(exact, time + onward, search))[k]


def domain_end(a: TimeNode, b: TimeNode, search: Search) -> float:
    """Last time [s] between two nodes at which all events have a value.

    Events without a value at the second node count; the first that has none behind that time is
    noted. Infinite where there is none.
    """
    end, exact = math.inf, np.zeros_like(search.noise)
    search.undefined = 0
    for k in np.flatnonzero(~has_value(b)[: len(search.work.scene.events)]).tolist():
        if not is_undefined(k, b.time, search):
            continue
        first, last = a.time, b.time
        while last - first > SMALLEST * larger(abs(first), abs(last)):
            time = 0.5 * (first + last)
            if not first < time < last:
                break
            if has_value(node_with_noise(exact, time, search))[k]:
                first = time
            else:
                last = time
        if first < end:
            end, search.undefined = first, 1 + k
    return end


def noise_of(k: int, search: Search) -> Array:
    """Noise (n, 2) of values and rates with which the zero of a function is located.

    Events, and functions at whose zero a force is infinite, are located by the polynomial, with its
    rounding; the others are known to the noise of the motion.
    """
    scene = search.work.scene
    is_exact = k < len(scene.events) or k >= len(search.state.sides) - scene.n_poles
    return search.rounding if is_exact else search.noise


def time_of(k: int, a: TimeNode, b: TimeNode, search: Search) -> float:
    """Time [s] between two nodes at which a crossing function first does so.

    An event is zero at this time; any other function is beyond zero, so that all that follows is on
    the other side.
    """
    side, first, last = -float(side_at(b)[k]), a.time, b.time
    is_event, noise = k < len(search.work.scene.events), noise_of(k, search).copy()
    is_pole = k >= len(search.state.sides) - search.work.scene.n_poles
    if not (is_event or is_pole):  # rates may be in a window that is narrower
        noise[:, 1] = noise_at(last, b.read, search)[:, 1]
    # by the polynomial it is beyond zero, by less than that
    if side_at(node_with_noise(noise, last, search))[k] != -side:
        noise = search.rounding
    while last - first > SMALLEST * larger(abs(first), abs(last)):
        time = 0.5 * (first + last)
        if not first < time < last:
            break
        node = node_with_noise(noise, time, search)
        if side * middle(node)[k] <= 0.0 if is_event else side_at(node)[k] == -side:
            last = time
        else:
            first = time
    return last


def first_time(a: TimeNode, b: TimeNode, search: Search) -> float:
    """Time [s] of the first crossing; only functions that cross there stay marked.

    What is behind the end of the run does not count, however near it is.
    """
    events = search.work.scene.events
    times = {int(k): time_of(int(k), a, b, search) for k in np.flatnonzero(search.crosses)}
    first = min(times.values())
    together = first + search.slack
    for k, time in times.items():
        if k < len(events) and ACTIONS[events[k, 1]] == "stop" and time <= first + search.slack:
            together = first + 4.0 * SMALLEST * abs(first)
    for k, time in times.items():
        search.crosses[k] = time <= together
    return first


def is_short_of(k: int, a: TimeNode, search: Search) -> bool:
    """Whether a step begins where a function that has crossed is on the side that it left.

    A step may end so, within its errors. Formulas are then those of the side that was left, and the
    error estimate of a method can be blind to its first stage.
    """
    if a.time != search.start:
        return False
    return bool(
        side_at(node_with_noise(search.rounding, a.time, search))[k] != search.state.sides[k]
    )


def first_departure(a: TimeNode, b: TimeNode, search: Search) -> float:
    """First time [s] at which a function that was near to zero, but no event, is on a side.

    Values of formulas at zero, where they may jump, tell nothing of what follows; values near to
    zero on the side that is taken do.
    """
    first, sides, now, before = math.inf, search.state.sides, side_at(b), middle(a)
    for k in range(len(search.work.scene.events), len(sides) - search.work.scene.n_poles):
        if now[k] == 0.0 or now[k] * before[k] > 0.0:
            continue
        if sides[k] == 0.0 or (sides[k] == now[k] and is_short_of(k, a, search)):
            first = smaller(first, time_of(k, a, b, search))
    return first


def note_sides(a: TimeNode, search: Search) -> None:
    """Note on which side functions are where a step starts, which the noise had left open.

    Rates are known to rounding where they pass by, places to the noise. Events, which are looked
    for until they are exact, and poles stay.
    """
    noise, sides = search.noise.copy(), search.state.sides
    noise[:, 1] = noise_at(a.time, a.read, search)[:, 1]
    events, n = len(search.work.scene.events), len(sides) - search.work.scene.n_poles
    now = side_at(evaluate_node(a.read, noise, a.time, search.work.w))[events:n]
    sides[events:n] = np.where(now == -sides[events:n], now, sides[events:n])


def is_still_short(sides: Array, time: float, search: Search) -> Flags:
    """Whether events that a step starts short of are no further from zero than the noise.

    That is at a time [s], beyond zero as seen from sides (functions,). An earlier step ended for
    these events and noted them: they do not cross back.
    """
    if not search.is_short.any():
        return search.is_short
    known = side_at(node_with_noise(search.noise, time, search))[: len(sides)]
    are_short: Flags = search.is_short & (known != -sides)
    return are_short


def are_crossed(sides: Array, b: TimeNode, search: Search) -> Flags:
    """Whether functions that were on sides (functions,) are beyond zero at a node."""
    crosses: Flags = (sides != 0.0) & (side_at(b)[: len(sides)] == -sides)
    return crosses & ~is_still_short(sides, b.time, search)


def crossing_end(end: float, search: Search) -> float:
    """Time [s] at which a step must end: of its first crossing, or as far as it was searched."""
    sides = search.state.sides
    n, start = len(sides), search.start
    is_pole = np.arange(n) >= n - search.work.scene.n_poles
    passed = np.zeros(n, dtype=bool)
    search.pole = 0
    tiny = SMALLEST * larger(abs(start), abs(end))
    nearest = start + larger(ONWARD * tiny, search.least_part * search.h)
    soon = start + larger(ONWARD * tiny, search.slack)
    widest = search.h / CELLS
    width, a = widest, node_at(start, search)
    domain_end(a, a, search)
    if search.undefined:
        return end
    note_sides(a, search)
    search.is_short = (np.arange(n) < len(search.work.scene.events)) & (sides != 0.0)
    search.is_short &= side_at(a)[:n] == -sides
    for _ in range(MOST_NODES):
        if not a.time < end:
            break
        b = node_at(a.time + width if a.time + STRETCH_TO_END * width < end else end, search)
        sides[:] = np.where(sides == 0.0, side_at(a)[:n], sides)
        now = np.where(passed, -sides, sides)
        search.crosses = are_crossed(now, b, search)
        passes = search.crosses & is_pole
        search.crosses &= ~is_pole
        valued, is_lost = domain_end(a, b, search), np.zeros(n, dtype=bool)
        if search.undefined:
            first = first_time(a, b, search) if search.crosses.any() else math.inf
            if first <= valued + search.slack:
                search.undefined = 0
                return smaller(larger(first, nearest), end)
            if search.is_kept and valued <= soon:
                return end
            search.undefined = 0
            # at the end, where it was cut for that, or by rounding
            if not end - valued <= (SMALL * search.h if end == search.cut else ONWARD * tiny):
                search.crosses[:] = False
                return smaller(larger(valued, nearest), end)
            is_lost = ~has_value(b)[:n]  # it ends where that has no value
        bounds = bound_functions(a, b, search)
        is_known = bool((is_lost | is_isolated(now, a, b, bounds, search)).all())
        departure = larger(first_departure(a, b, search), start + ONWARD * tiny)
        if departure - start < SOON * (end - start):
            search.crosses[:] = False
            return departure
        if not is_known and b.time - a.time > tiny:
            width = 0.5 * (b.time - a.time)
            continue
        if passes.any() and search.is_kept:
            find_pole(passes, a, b, search)
            if search.pole:
                return end
        passed ^= passes
        if search.crosses.any():
            search.breaks = np.where(search.crosses[search.work.scene.breaks], b.time, math.inf)
            return smaller(larger(first_time(a, b, search), nearest), end)
        a, width = b, smaller(2.0 * width, widest)
    search.is_unresolved = a.time < end and not a.time > nearest
    return a.time if nearest < a.time < end else end


def find_pole(passes: Flags, a: TimeNode, b: TimeNode, search: Search) -> None:
    """Find the first pole of a force between two nodes, if nothing crosses before it.

    Functions (functions,) pass zero there, where forces may be infinite.
    """
    crossed, first = search.crosses.copy(), math.inf
    if crossed.any():
        first = first_time(a, b, search)
        search.crosses = crossed
    for k in np.flatnonzero(passes).tolist():
        side = side_at(b)[k]
        time = a.time if side_at(a)[k] == side else time_of(k, a, b, search)
        if time <= first and is_infinite(k, float(side), time, search):
            first = search.pole_time = time
            search.pole = 1 + k - len(passes) + search.work.scene.n_poles


def node_beside(offset: float, time: float, read: Array, noise: Array, search: Search) -> TimeNode:
    """Node at an offset [s] from a time [s] where formulas read (n, 2) and go on evenly."""
    beside = read.copy()
    beside[:, 0] += offset * read[:, 1]
    beside[:, 1] += offset * search.second_mean
    return evaluate_node(beside, noise, time + offset, search.work.w)


def sizes_beside(offset: float, time: float, read: Array, search: Search) -> Array:
    """Sizes of parts of forces that may be infinite, at an offset [s] from a time [s].

    Formulas read values and rates (n, 2) at the time.
    """
    node = node_beside(offset, time, read, np.zeros_like(read), search)
    return np.abs(middle(node)[len(node.least) - len(search.work.w.infinite) // 4 :])


def is_infinite(k: int, side: float, time: float, search: Search) -> bool:
    """Whether a force is infinite where a function gets on a side of zero at a time.

    No motion leads through such a place: the force grows as 1/x or faster on a side. A force that
    is 0/0 there, or jumps, does not grow, and one that grows less, as 1/sqrt(x), has a finite
    integral.
    """
    read, far = read_at(time, search), ROUNDINGS * SMALLEST * larger(abs(time), search.h)
    while (
        side_at(node_beside(-far, time, read, search.rounding, search))[k] != -side
        or side_at(node_beside(far, time, read, search.rounding, search))[k] != side
    ):
        far *= FURTHER
        if not far < search.state.stride:
            return True  # rounding hides that
    is_pole = np.zeros(len(search.work.w.infinite) // 4, dtype=bool)
    for offset in (-far, far):
        near = sizes_beside(FURTHER * FURTHER * offset, time, read, search)
        there = sizes_beside(FURTHER * FURTHER * FURTHER * offset, time, read, search)
        away = sizes_beside(FURTHER * FURTHER * FURTHER * FURTHER * offset, time, read, search)
        grows = (near > STEEP * there) & (there > STEEP * away)
        product, square = near * away, there * there
        grows &= (product <= EVENLY * square) & (square <= EVENLY * product)
        is_pole |= grows | np.isinf(near)
    return bool(is_pole.any())


def end_before_pole(search: Search) -> float:
    """End [s] of a step before a pole that is found in it: its start if that is near."""
    span = search.pole_time - search.start
    return search.start + CLOSER * span if span > NO_WAY * search.state.stride else search.start


def why_stopped(seen: float, search: Search) -> Status:
    """Reason why a run leads no further, where a step would end there; GOOD where it does."""
    state = search.state
    if search.undefined:
        state.event = float(search.undefined)
        return Status.NO_VALUE
    if search.pole and not seen > state.time:
        state.pole = float(search.pole)
        return Status.INFINITE
    return Status.GOOD


def gap_across(
    k: int, side: float, time: float, far: float, search: Search, *, is_beyond: bool
) -> float:
    """Difference of a function from one side of a time to the other, so far away.

    Both values are in the polynomial, or beyond it. The difference is 0 where they are not surely
    on different sides of zero, and negative where the function goes to the opposite side.
    """
    if is_beyond:
        read = read_at(time, search)
        a = node_beside(-far, time, read, search.rounding, search)
        b = node_beside(far, time, read, search.rounding, search)
    else:
        a = node_with_noise(search.rounding, time - far, search)
        b = node_with_noise(search.rounding, time + far, search)
    if side_at(a)[k] != -side or side_at(b)[k] != side:
        return -1.0 if side_at(a)[k] == side and side_at(b)[k] == -side else 0.0
    return float(b.least[k] - a.most[k] if side > 0.0 else a.least[k] - b.most[k])


def passes_zero(k: int, side: float, end: float, search: Search) -> bool:
    """Whether an event that gets on a side of zero in a step to an end is zero there.

    Else it jumps, or goes through infinity: right beside the place it is then as large as further
    away, or larger. Where rounding hides the difference it counts as zero. Distances may exceed a
    short step, beyond which its polynomial tells nothing: values and rates at its end are then
    continued. If the event goes to the opposite side, rounding brought it back over a jump that was
    passed.
    """
    if search.work.scene.events[k, 2] == 0:
        return True
    first, last = search.start, end
    if side_at(node_with_noise(search.rounding, end, search))[k] != side:
        last = end + SMALL * search.h
    while last - first > SMALLEST * larger(abs(first), abs(last)):
        time = 0.5 * (first + last)
        if not first < time < last:
            break
        if side_at(node_with_noise(search.rounding, time, search))[k] == side:
            last = time
        else:
            first = time
    far = ROUNDINGS * SMALLEST * larger(abs(last), search.h)
    while far < larger(search.h, search.state.stride) / FURTHER:
        is_beyond = not far < search.h / FURTHER
        gap = gap_across(k, side, last, far, search, is_beyond=is_beyond)
        if gap != 0.0:
            further = gap_across(k, side, last, FURTHER * far, search, is_beyond=is_beyond)
            return gap > 0.0 and further >= LARGER_THERE * gap
        far *= FURTHER
    return True


def polished_cut(search: Search) -> float:
    """Time [s] of an event that a step was cut for, by the step that ends near it."""
    reach, cut = SMALL * search.h, search.cut
    sides = search.state.sides
    candidates = np.flatnonzero(search.was_crossing[: len(search.work.scene.events)]).tolist()
    event = next((k for k in candidates if passes_zero(k, -sides[k], cut, search)), None)
    if event is None:
        return cut

    def value(time: float) -> float:
        return float(middle(node_with_noise(noise_of(event, search), time, search))[event])

    previous, current = cut - reach, cut
    a, b = value(previous), value(current)
    for _ in range(4):
        if a == b:
            break
        time = current - b / ((b - a) / (current - previous))
        if not abs(time - cut) <= reach or time == current:
            break
        a, previous, current = b, current, time
        b = value(current)
    return current


def is_thrown_back(k: int, end: float, search: Search) -> bool:
    """Whether an event that passed zero is back there, where a jump of a force threw it back.

    Dry friction that holds a body at rest does that all the time. It is so if nothing has moved
    since the event passed zero by more than its noise, unless the event goes evenly through a
    narrow window: then it was on the side that it leaves half of this time ago, and is on the
    other one before and soon. An event that was held once is not asked again.
    """
    state, elapsed, read = search.state, end - search.state.crossed[k], read_at(end, search)
    speeds, known = np.column_stack((read[:, 1], search.second_mean)), search.noise[:, 0]
    is_there = len(read) > 0 and elapsed <= NO_WAY * state.stride
    if is_there:
        bounds = np.column_stack((known, known * state.fastest))
        is_there = bool((np.abs(speeds) * elapsed <= bounds).all())
    if not is_there:
        state.held[k] = 0.0
    elif state.held[k] == 0.0:
        offsets = (-EARLIER * elapsed, -HALF * elapsed, HALF * elapsed)
        nodes = (node_beside(offset, end, read, search.rounding, search) for offset in offsets)
        before, between, behind = (side_at(node)[k] * state.sides[k] for node in nodes)
        state.held[k] = float(not (before < 0.0 and between > 0.0 and behind < 0.0))
    return bool(state.held[k] > 0.0)


def note_crossings(end: float, search: Search) -> None:
    """Note crossings of a step that is kept; of one that was cut, also zeros at its end."""
    state, events = search.state, search.work.scene.events
    sides, now = state.sides.copy(), side_at(node_at(end, search))
    is_near = (now == 0.0) | (side_at(node_with_noise(search.noise, end, search)) == 0.0)
    is_back = (now[: len(sides)] == -sides) & ~is_still_short(sides, end, search)
    for k, side in enumerate(sides.tolist()):
        is_there = is_near[k] and end == search.cut and search.was_crossing[k]
        if side == 0.0 or not (is_back[k] or is_there):
            continue
        is_same = k < len(events) and is_thrown_back(k, end, search)
        state.sides[k] = -side
        if k >= len(events):
            continue
        state.crossed[k] = end
        if is_same or events[k, 0] not in {0, -side} or not passes_zero(k, -side, end, search):
            continue
        state.counts[k] += 1.0
        if ACTIONS[events[k, 1]] != "count":
            state.fired[k] = 1.0


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
    while first < start + allowed:
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
