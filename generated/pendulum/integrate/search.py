"""Search: what formulas read, and bounds of them, at times inside of a step that was tried.

The polynomial of the step, the dense output, gives at some times, the nodes, what formulas read:
coordinates, lengths of springs, their rates. Bounds of these between the nodes bound the functions
and their rates, as of switching functions of time. Values that are nearer to zero than the error of
the step, the noise, count as zero.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from .arithmetic import larger, smaller
from .dense_output import add_dense_rows, hermite_cubic, interpolate
from .pivot_monitor import scale_by_distance

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
#: Smallest number of intervals in which a step is searched.
CELLS = 4
#: Largest number of intervals that are looked at in one search.
MOST_NODES = 512
#: Second derivatives of what formulas read are taken to lie within this many times their rise in
#: the cubic polynomial, above and below their mean.
DOUBT = 2.0
#: Loosest tolerance to which values are known in a search, and loosest tolerance of steps from a
#: switch to the next: forces that switch again soon are narrow, and estimates are blind to what
#: acts for a stage or two. It also applies to each step from a kink where no force jumps: friction
#: that holds switches all the time.
LOOSEST_AT_SWITCH = 1e-5
#: Speed that is added to rates to scale their errors, in lengths of the scene or radians over the
#: longest step so far: in a short step the rates of what moves are no better known, and no worse.
SLOW = 1e-4
#: A zero is transversal if at its speed the value leaves this many times its noise, within the
#: longest step so far and before it comes to rest; the same holds for a rate, which changes as fast
#: as it does. Such values are known to rounding.
PASSING = 16.0


def largest(a: Array, b: Array) -> Array:
    """Larger of each two numbers (n,), the second if the first is a NaN."""
    return np.where(a > b, a, b)


def smallest(a: Array, b: Array) -> Array:
    """Smaller of each two numbers (n,), the second if the first is a NaN."""
    return np.where(a < b, a, b)


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
        Whether each event has been noted by an earlier step that ended a little before its zero,
        or is zero all along.
    is_at_zero : array of bool
        Whether each event is zero all along the step, as far as it is known.
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
    is_at_zero: Flags = field(init=False)
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

    def __post_init__(self) -> None:
        """Begin without events that are short of zero, or are zero all along."""
        self.is_short = np.zeros(len(self.state.sides), dtype=bool)
        self.is_at_zero = self.is_short


def side_at(node: TimeNode) -> Array:
    """Side of zero of each function (functions,), 1 or -1, 0 where that is not known."""
    return np.where(node.least > 0.0, 1.0, np.where(node.most < 0.0, -1.0, 0.0))


def middle(node: TimeNode) -> Array:
    """Middle of each function's bounds (functions,)."""
    return np.multiply(0.5, node.least + node.most)


def half_width(node: TimeNode) -> Array:
    """Half of the distance between each function's bounds (functions,)."""
    return np.multiply(0.5, node.most - node.least)


def is_flat(node: TimeNode, w: Workspace) -> Flags:
    """Whether functions are zero all about a node, which was evaluated last."""
    are_zero: Flags = (node.least == 0.0) & (node.most == 0.0)
    return are_zero & ~w.functions.reshape(-1, 4)[:, 2:].any(axis=1)


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


def noise_of(k: int, search: Search) -> Array:
    """Noise (n, 2) of values and rates with which the zero of a function is located.

    Events, and functions at whose zero a force is infinite, are located by the polynomial, with its
    rounding; the others are known to the noise of the motion.
    """
    scene = search.work.scene
    is_exact = k < len(scene.events) or k >= len(search.state.sides) - scene.n_poles
    return search.rounding if is_exact else search.noise


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
