"""Crossing: steps end where events are and where formulas of the state have a kink or a jump.

A step that was tried is looked at before it is kept. Its polynomial tells at some times what
formulas read: coordinates, lengths of springs, their rates. That bounds them between these times,
and they bound the functions and their rates, as of switching functions of time. What is nearer to
zero than the error of a step may be counts as zero: a function crosses when it is beyond on the
other side. Then the step is made again, to end there. Parts of formulas that vary with the state
beyond polynomials are bounded likewise: where samples do not tell how, the step is made shorter.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from .arithmetic import larger, smaller
from .dense_output import add_dense_rows, combine, hermite_cubic, interpolate
from .settings import ACTIONS, Status

if TYPE_CHECKING:
    import numpy.typing as npt

    from .arithmetic import Array
    from .methods import RungeKuttaMethod
    from .scene_tables import Work, Workspace
    from .settings import Settings
    from .state import State

    Flags = npt.NDArray[np.bool_]

#: The smallest step, relative to the time.
SMALLEST = 1e-15
#: How many smallest steps a cut is behind the start at least.
ONWARD = 8.0
#: In how many parts a step is looked at, and how often at most.
CELLS = 4
MOST_LOOKS = 512
#: Second derivatives may be so much further from those of a cubic polynomial as it is from a
#: parabola.
DOUBT = 2.0
#: How much bounds may exceed what samples tell.
EXPLAINED = 2.0
#: How much the variation of a part may, as its bounds tell, of what samples show: a hill between
#: them goes up and down, and has twice of it.
SHOWN = 1.5
#: What always may be left, by the size of a part.
NOTHING = 1e-12
#: A part that changes by less than this part of it in an interval needs no samples.
STEADY = 0.5
#: The shortest interval in which a part is looked at, in a step: what is narrower has no bounds.
FINEST = 1e-9
#: The part of a step by which an event may be off where the step was cut, to be found again.
SMALL = 1e-3
#: A function that passes zero is so much larger this much further away from it; where it jumps it
#: is not, nor where it is infinite. It is looked at from so many roundings of time on.
FURTHER = 8.0
LARGER_THERE = 1.5
ROUNDINGS = 64.0
#: A step in which what was near to zero gets on a side within this part of it ends there.
SOON = 0.1
#: What rates are known to of a length in the longest step so far, in units of the tolerance: in a
#: short one rates of what does move are no better known, and no worse.
SLOW = 1e-4
#: Where it is infinite a part of a force is so much larger that much nearer to the place: 1/x is
#: FURTHER times as large. From one distance to the next that factor changes by no more than this.
STEEP = 7.0
EVENLY = 1.5
#: A step that leads over such a place is made again, over this part of the way there; a run ends
#: where the way is this part of its longest step.
CLOSER = 0.9
NO_WAY = 1e-6
#: A function is near to zero where it is less than so many times what it is known to; what that is
#: further away tells nothing of how near it comes between.
BANDS = 16.0
#: An event that goes through a narrow window was on the other side this many times as long ago as
#: it passed zero, and has been in the window this many times as long.
EARLIER = 1.5
HALF = 0.5
#: What gets further than so many times what it is known to passes by, as fast as it is at a time:
#: in the longest step, and before it comes to rest. So it is with rates, as fast as they change.
PASSING = 16.0


def largest(a: Array, b: Array) -> Array:
    """Larger of each two numbers, the second if the first is a NaN."""
    return np.where(a > b, a, b)


def smallest(a: Array, b: Array) -> Array:
    """Smaller of each two numbers, the second if the first is a NaN."""
    return np.where(a < b, a, b)


def stays_positive(a: Array, b: Array, falls: Array, rises: Array, h: float) -> Flags:
    """Whether what is a at the start of h and b at its end is positive between.

    It is no less than lines from both ends as steep as it falls and rises at most.
    """
    found: Flags = a * rises - b * falls + falls * rises * h > 0.0
    return found


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
        When.
    read : (n, 2) array
        What formulas read, and its rate.
    least, most : array
        Between what each function is.
    """

    time: float
    read: Array
    least: Array
    most: Array


@dataclass(slots=True)
class Look:
    """A step that is looked at, whose polynomial is in the state.

    Parameters
    ----------
    state, work : State, Work
        Of the run.
    cut : float [s]
        Where it was cut.
    m, start, h : RungeKuttaMethod, float [s], float [s]
        How it was made.
    least_part : float
        At which part of it at least it may be cut.
    slack : float [s]
        What crosses within it crosses together.
    noise, rounding : (n, 2) array
        What values are known to, in the motion and in its polynomial.
    bend : (n,) array
        By what rates change in it, in the mean.
    lean : (n,) array
        By how much more they do at its end than in the mean.
    pull : (n,) array
        By what they do at most.
    known : (n,) array
        What rates are known to: to no more than they have been.
    crosses, was_crossing : array of bool
        Which functions cross, and crossed where it was cut.
    is_short : array of bool
        Of which events it starts short of zero, where an earlier step ended for them.
    is_untold : bool
        Whether samples leave open how narrow parts vary somewhere in it.
    has_error : bool
        Whether an error tells how much of it is missed.
    is_kept : bool
        Whether it is kept if nothing cuts it.
    lost : int
        The event without a value right behind its start, counted from 1, 0 where all have one.
    pole : int
        The function that is zero in it where a force is infinite, counted from 1; 0: none.
    pole_time : float [s]
        When that is.
    turned, turning, place : int, float [s], float [s]
        How often it was cut for distances and jumps, where last, and the place that did so.
    is_over : bool
        Whether it only leads over that.
    breaks : array [s]
        Until when functions first cross in it at which a force jumps; infinite where they do not.
    """

    state: State
    work: Work
    cut: float
    m: RungeKuttaMethod = field(init=False)
    start: float = 0.0
    h: float = 0.0
    least_part: float = 0.0
    slack: float = 0.0
    noise: Array = field(init=False)
    rounding: Array = field(init=False)
    bend: Array = field(init=False)
    lean: Array = field(init=False)
    pull: Array = field(init=False)
    known: Array = field(init=False)
    crosses: Flags = field(init=False)
    was_crossing: Flags = field(init=False)
    is_short: Flags = field(init=False)
    is_untold: bool = False
    has_error: bool = False
    is_kept: bool = True
    lost: int = 0
    pole: int = 0
    pole_time: float = 0.0
    turned: int = 0
    turning: float = math.inf
    place: float = math.inf
    is_over: bool = False
    breaks: Array = field(init=False)


def side_at(node: TimeNode) -> Array:
    """Side of zero of each function, 1 or -1, 0 where that is not known."""
    return np.where(node.least > 0.0, 1.0, np.where(node.most < 0.0, -1.0, 0.0))


def middle(node: TimeNode) -> Array:
    """Middle of each function's bounds."""
    return np.multiply(0.5, node.least + node.most)


def half_width(node: TimeNode) -> Array:
    """Half of the distance between each function's bounds."""
    return np.multiply(0.5, node.most - node.least)


def read_of(time: float, y: Array, w: Workspace) -> Array:
    """Values that formulas read of y at a time."""
    w.place(time, y)
    w.run("measure")
    found: Array = w.measures.reshape(-1, 2).copy()
    return found


def read_at(time: float, look: Look) -> Array:
    """Values that formulas read at a time."""
    interpolate(look.m, (time - look.start) / look.h, look.state, look.work.scratch)
    return read_of(time, look.work.scratch, look.work.w)


def look_at(time: float, look: Look) -> TimeNode:
    """Node at a time of the motion.

    Of what passes by there its polynomial tells where it is, however far off that may be, and of a
    rate that does what it is, so that nothing that is narrower is passed over. Where a force may be
    infinite places are known to the noise.
    """
    read, n, n_poles = read_at(time, look), len(look.state.sides), look.work.scene.n_poles
    if n_poles:
        node = see_at(read, look.noise, time, look.work.w)
        if not side_at(node)[n - n_poles : n].all():
            return node
    return see_at(read, noise_at(time, read, look), time, look.work.w)


def noise_at(time: float, read: Array, look: Look) -> Array:
    """Noise of what formulas read at a time: of what passes by there only rounding."""
    jolt = 2.0 * np.abs(look.lean) / look.h
    pulls = np.column_stack((look.pull, jolt))
    speeds = np.column_stack((np.abs(read[:, 1]), change_at(time, look)))
    return np.where(passes_by(speeds, pulls, look), look.rounding, look.noise)


def passes_by(speeds: Array, pulls: Array, look: Look) -> Flags:
    """Whether what is as fast, and is pulled at most so much, gets further than it is known to."""
    far = PASSING * np.column_stack((look.noise[:, 0], look.known))
    found: Flags = speeds * larger(look.state.stride, look.h) > far
    return found & (speeds * speeds > far * pulls)


def change_at(time: float, look: Look) -> Array:
    """How fast rates change at a time of a step, but for what rounding makes of it."""
    part, h = (time - look.start) / look.h, look.h
    change = np.abs(look.bend + (2.0 * part - 1.0) * look.lean)
    known: Array = change - 2.0 * look.rounding[:, 1] / h
    return known


def look_closely(noise: Array, time: float, look: Look) -> TimeNode:
    """Node at a time, where values are known to a noise."""
    return see_at(read_at(time, look), noise, time, look.work.w)


def see_at(read: Array, noise: Array, time: float, w: Workspace) -> TimeNode:
    """Node at a time where formulas read this, known to a noise."""
    own = w.ranges[2:].reshape(-1, 6)
    w.ranges[:2] = time
    own[:, [0, 2]], own[:, [1, 3]], own[:, 4:] = read - noise, read + noise, 0.0
    w.run("crossing")
    least, most = w.seen.reshape(-1, 4).T[:2].copy()
    return TimeNode(time, read, least, most)


def stage_beyond(seen: float, look: Look) -> float:
    """Time of a stage of the polynomial alone that is beyond a switch that this one does not meet.

    So it is in a contact that all stages of the step passed by: what acts there has thrown the
    polynomial off, and it tells nothing. If none is, that is until when it was seen.
    """
    m, state, work, n_poles = look.m, look.state, look.work, look.work.scene.n_poles
    n = len(state.sides) - n_poles
    for k in range(m.stages + 1, m.all):
        time = look.start + m.c[k] * look.h
        if not time < seen:
            continue
        combine(k, m.a[k], state.y, look.h, work.k, work.scratch)
        node = see_at(read_of(time, work.scratch, work.w), look.noise, time, work.w)
        sides = state.sides[:n]
        if np.any((sides != 0.0) & (side_at(node)[:n] == -sides)):
            return time
    return seen


def look_into(
    s: Settings, m: RungeKuttaMethod, h: float, y: Array, f: Array, look: Look, *, has_stages: bool
) -> None:
    """Make the polynomial of a step from the state to y, where the derivative is f."""
    state, sizes = look.state, look.work.scene.measure_sizes
    look.m, look.start, look.h, look.slack = m, state.time, h, s.tolerance * h
    look.is_untold, look.breaks = False, np.full(look.work.scene.n_breaks, math.inf)
    state.y_before[:] = state.y
    state.dense[:] = 0.0
    hermite_cubic(h, y, state.f, f, state)
    if has_stages:
        add_dense_rows(m, h, state, look.work)
    first, last = read_at(state.time, look), read_at(state.time + h, look)
    most = largest(np.abs(first), np.abs(last))
    look.bend = (last[:, 1] - first[:, 1]) / h
    look.lean = bend_of(sizes, first, last, h)
    look.pull = np.abs(look.bend) + np.abs(look.lean)
    fast = most[:, 1] + SLOW * sizes / larger(state.stride, h)
    look.noise = np.empty_like(most)
    look.noise[:, 0] = s.tolerance * sizes + SMALLEST * most[:, 0]
    look.noise[:, 1] = s.tolerance * fast
    look.rounding = np.empty_like(most)
    look.rounding[:, 0] = SMALLEST * (sizes + most[:, 0])
    look.rounding[:, 1] = SMALLEST * fast
    look.known = smallest(look.noise[:, 1], most[:, 1] + sizes * state.fastest)


def bend_of(sizes: Array, a: Array, b: Array, h: float) -> Array:
    """By how much second derivatives at the end of h are above their mean, as those of cubics.

    Values and rates at both ends tell. What reads a coordinate are numbers as large as its
    size, however small it is.
    """
    (x, v), (y, u) = a.T, b.T
    rounding = 6.0 * SMALLEST * (sizes + np.abs(x) + np.abs(y)) / h
    off = 3.0 * (v + u) - 6.0 * (y - x) / h
    found: Array = np.copysign(largest(np.zeros_like(off), np.abs(off) - rounding) / h, off)
    return found


def bound_seen(a: TimeNode, b: TimeNode, look: Look) -> Array:
    """Least and most value, slowest and fastest rate of the functions between two nodes."""
    w, h = look.work.w, b.time - a.time
    (x, v), (y, u) = a.read.T, b.read.T
    own = w.ranges[2:].reshape(-1, 6)
    w.ranges[:2] = a.time, b.time
    mean, bend = (u - v) / h, np.abs(bend_of(look.work.scene.measure_sizes, a.read, b.read, h))
    own[:, 4], own[:, 5] = mean - DOUBT * bend, mean + DOUBT * bend
    reach_between(v, u, own[:, 4], own[:, 5], h, own[:, 2:4])
    reach_between(x, y, own[:, 2], own[:, 3], h, own[:, :2])
    w.run("crossing")
    return w.seen.reshape(-1, 4).T


def cut_at(end: float, look: Look) -> float:
    """Cut a step where it must end, and remember what crosses there."""
    look.was_crossing, look.cut = look.crosses, end
    return end


def reach_between(
    a: Array, b: Array, slowest: Array, fastest: Array, h: float, found: Array
) -> None:
    """Write least and most between values a and b at the ends of h, where a slope is bounded."""
    is_open = (slowest < 0.0) & (fastest > 0.0)
    every, bend = fastest - slowest, slowest * fastest * h
    least, most = smallest(a, b), largest(a, b)
    down = smallest(least, (fastest * a - slowest * b + bend) / every)
    up = largest(most, (fastest * b - slowest * a - bend) / every)
    found[:, 0], found[:, 1] = np.where(is_open, down, least), np.where(is_open, up, most)


def band_at(node: TimeNode, look: Look) -> Array:
    """Band of functions at a node: of an event that it starts short of no more."""
    found = half_width(node)
    if look.is_short.any():
        known = half_width(look_closely(look.noise, node.time, look))
        n = len(look.is_short)
        found[:n] = np.where(look.is_short, known[:n], found[:n])
    return found


def is_told(sides: Array, a: TimeNode, b: TimeNode, bounds: Array, look: Look) -> Flags:
    """Whether functions cross between two nodes as often as their sides tell."""
    n, is_down = len(sides), sides < 0.0
    low, high, slowest, fastest = bounds[:, :n]
    sign, least = np.where(is_down, -1.0, 1.0), np.where(is_down, -high, low)
    falls, rises = np.where(is_down, -fastest, slowest), np.where(is_down, -slowest, fastest)
    band_a, band_b = band_at(a, look)[:n], band_at(b, look)[:n]
    first, last = sign * middle(a)[:n], sign * middle(b)[:n]
    near_a = np.where((sides == 0.0) | (first < BANDS * band_a), band_a, 0.0)
    near_b = np.where((sides == 0.0) | (last < BANDS * band_b), band_b, 0.0)
    within = largest(near_a, near_b)
    is_clear = (least > -within) | (falls >= 0.0) | (rises <= 0.0)
    is_positive = stays_positive(first + within, last + within, falls, rises, b.time - a.time)
    stays = is_clear | np.where(sides == 0.0, high < within, is_positive)
    crosses = (sides != 0.0) & (side_at(b)[:n] == -sides)
    crosses &= ~is_still_short(sides, b.time, look)
    told: Flags = np.where(crosses, rises <= 0.0, stays)
    return told


def has_value(node: TimeNode) -> Flags:
    """Whether each function has a value at a node."""
    found: Flags = ~(np.isnan(node.least) | np.isnan(node.most))
    return found


def first_without_value(state: State, work: Work) -> int:
    """First event without a finite value at the state, from 1; 0 where all have one."""
    w, count = work.w, len(work.scene.events)
    if count == 0:
        return 0
    read = read_of(state.time, state.y, w)
    node = see_at(read, np.zeros_like(read), state.time, w)
    is_finite = (np.isfinite(node.least) & np.isfinite(node.most))[:count]
    return 0 if is_finite.all() else int(np.argmin(is_finite)) + 1


def lacks_value(k: int, time: float, look: Look) -> bool:
    """Whether a function has no value at a time, nor right behind it.

    One that is 0/0 there alone has one behind it.
    """
    exact, onward = np.zeros_like(look.noise), ROUNDINGS * SMALLEST * larger(abs(time), look.h)
    if has_value(look_closely(exact, time, look))[k]:
        return False
    return not has_value(look_closely(exact, time + onward, look))[k]


def valued_end(a: TimeNode, b: TimeNode, look: Look) -> float:
    """Last time between two nodes at which all events have a value.

    Those count that have none at the second node; the first that has none behind that time is
    noted. It is infinite where there is none.
    """
    end, exact = math.inf, np.zeros_like(look.noise)
    look.lost = 0
    for k in np.flatnonzero(~has_value(b)[: len(look.work.scene.events)]).tolist():
        if not lacks_value(k, b.time, look):
            continue
        first, last = a.time, b.time
        while last - first > SMALLEST * larger(abs(first), abs(last)):
            time = 0.5 * (first + last)
            if not first < time < last:
                break
            if has_value(look_closely(exact, time, look))[k]:
                first = time
            else:
                last = time
        if first < end:
            end, look.lost = first, 1 + k
    return end


def noise_of(k: int, look: Look) -> Array:
    """Noise to which values are known where a function is looked for.

    An event is where the polynomial is zero, and a force is infinite there.
    """
    scene = look.work.scene
    is_exact = k < len(scene.events) or k >= len(look.state.sides) - scene.n_poles
    return look.rounding if is_exact else look.noise


def time_of(k: int, a: TimeNode, b: TimeNode, look: Look) -> float:
    """First time between two nodes at which a function that crosses does.

    Those of events are zero there, the others beyond it, so that what follows is all on the other
    side.
    """
    side, first, last = -float(side_at(b)[k]), a.time, b.time
    is_event, noise = k < len(look.work.scene.events), noise_of(k, look).copy()
    is_pole = k >= len(look.state.sides) - look.work.scene.n_poles
    if not (is_event or is_pole):  # rates may be in a window that is narrower
        noise[:, 1] = noise_at(last, b.read, look)[:, 1]
    # by the polynomial it is beyond zero, by less than that
    if side_at(look_closely(noise, last, look))[k] != -side:
        noise = look.rounding
    while last - first > SMALLEST * larger(abs(first), abs(last)):
        time = 0.5 * (first + last)
        if not first < time < last:
            break
        node = look_closely(noise, time, look)
        if side * middle(node)[k] <= 0.0 if is_event else side_at(node)[k] == -side:
            last = time
        else:
            first = time
    return last


def first_time(a: TimeNode, b: TimeNode, look: Look) -> float:
    """Time at which the first function crosses; only those that do so there are left.

    What is behind the end of the run does not count, however near it is.
    """
    events = look.work.scene.events
    times = {int(k): time_of(int(k), a, b, look) for k in np.flatnonzero(look.crosses)}
    first = min(times.values())
    together = first + look.slack
    for k, time in times.items():
        if k < len(events) and ACTIONS[events[k, 1]] == "stop" and time <= first + look.slack:
            together = first + 4.0 * SMALLEST * abs(first)
    for k, time in times.items():
        look.crosses[k] = time <= together
    return first


def is_short_of(k: int, a: TimeNode, look: Look) -> bool:
    """Whether a step begins where a function that has crossed is on the side that it left.

    A step ends there where errors let it. Formulas are then those of that side, and the errors of a
    method can be blind to its first stage.
    """
    if a.time != look.start:
        return False
    return bool(side_at(look_closely(look.rounding, a.time, look))[k] != look.state.sides[k])


def first_left(a: TimeNode, b: TimeNode, look: Look) -> float:
    """First time at which a function but for events is on a side that was near to zero so far.

    Formulas at zero, where jumps are, tell nothing of what follows; those that are near to it on
    that side already do.
    """
    first, sides, now, before = math.inf, look.state.sides, side_at(b), middle(a)
    for k in range(len(look.work.scene.events), len(sides) - look.work.scene.n_poles):
        if now[k] == 0.0 or now[k] * before[k] > 0.0:
            continue
        if sides[k] == 0.0 or (sides[k] == now[k] and is_short_of(k, a, look)):
            first = smaller(first, time_of(k, a, b, look))
    return first


def note_left(a: TimeNode, look: Look) -> None:
    """Note on which side functions are where a step starts: by the noise that was open.

    Rates are known to rounding where they pass by, places to the noise. Events, which are looked
    for until they are exact, and poles stay.
    """
    noise, sides = look.noise.copy(), look.state.sides
    noise[:, 1] = noise_at(a.time, a.read, look)[:, 1]
    events, n = len(look.work.scene.events), len(sides) - look.work.scene.n_poles
    now = side_at(see_at(a.read, noise, a.time, look.work.w))[events:n]
    sides[events:n] = np.where(now == -sides[events:n], now, sides[events:n])


def is_still_short(sides: Array, time: float, look: Look) -> Flags:
    """Whether events that a step starts short of are no further from zero than the noise.

    They were noted where that step ended for them: there is nothing to go back from.
    """
    if not look.is_short.any():
        return look.is_short
    known = side_at(look_closely(look.noise, time, look))[: len(sides)]
    found: Flags = look.is_short & (known != -sides)
    return found


def are_crossed(sides: Array, b: TimeNode, look: Look) -> Flags:
    """Whether functions that were on sides are beyond zero at a node."""
    crosses: Flags = (sides != 0.0) & (side_at(b)[: len(sides)] == -sides)
    return crosses & ~is_still_short(sides, b.time, look)


def seen_end(end: float, look: Look) -> float:
    """Time at which a step to an end must end: where a function first crosses, or what was seen."""
    sides = look.state.sides
    n, start = len(sides), look.start
    is_pole = np.arange(n) >= n - look.work.scene.n_poles
    passed = np.zeros(n, dtype=bool)
    look.pole = 0
    tiny = SMALLEST * larger(abs(start), abs(end))
    nearest = start + larger(ONWARD * tiny, look.least_part * look.h)
    soon = start + larger(ONWARD * tiny, look.slack)
    widest = look.h / CELLS
    width, a = widest, look_at(start, look)
    valued_end(a, a, look)
    if look.lost:
        return end
    note_left(a, look)
    look.is_short = (np.arange(n) < len(look.work.scene.events)) & (sides != 0.0)
    look.is_short &= side_at(a)[:n] == -sides
    for _ in range(MOST_LOOKS):
        if not a.time < end:
            break
        b = look_at(a.time + width if a.time + 1.0000001 * width < end else end, look)
        sides[:] = np.where(sides == 0.0, side_at(a)[:n], sides)
        now = np.where(passed, -sides, sides)
        look.crosses = are_crossed(now, b, look)
        passes = look.crosses & is_pole
        look.crosses &= ~is_pole
        valued, is_lost = valued_end(a, b, look), np.zeros(n, dtype=bool)
        if look.lost:
            first = first_time(a, b, look) if look.crosses.any() else math.inf
            if first <= valued + look.slack:
                look.lost = 0
                return smaller(larger(first, nearest), end)
            if look.is_kept and valued <= soon:
                return end
            look.lost = 0
            # at the end, where it was cut for that, or by rounding
            if not end - valued <= (SMALL * look.h if end == look.cut else ONWARD * tiny):
                look.crosses[:] = False
                return smaller(larger(valued, nearest), end)
            is_lost = ~has_value(b)[:n]  # it ends where that has no value
        bounds = bound_seen(a, b, look)
        is_known = bool((is_lost | is_told(now, a, b, bounds, look)).all())
        left = larger(first_left(a, b, look), start + ONWARD * tiny)
        if left - start < SOON * (end - start):
            look.crosses[:] = False
            return left
        if not is_known and b.time - a.time > tiny:
            width = 0.5 * (b.time - a.time)
            continue
        if passes.any() and look.is_kept:
            find_pole(passes, a, b, look)
            if look.pole:
                return end
        passed ^= passes
        if look.crosses.any():
            look.breaks = np.where(look.crosses[look.work.scene.breaks], b.time, math.inf)
            return smaller(larger(first_time(a, b, look), nearest), end)
        a, width = b, smaller(2.0 * width, widest)
    look.is_untold = a.time < end and not a.time > nearest
    return a.time if nearest < a.time < end else end


def find_pole(passes: Flags, a: TimeNode, b: TimeNode, look: Look) -> None:
    """Find the first pole of a force between two nodes, but behind nothing else that crosses there.

    Functions pass zero there, where forces may be infinite.
    """
    crossed, first = look.crosses.copy(), math.inf
    if crossed.any():
        first = first_time(a, b, look)
        look.crosses = crossed
    for k in np.flatnonzero(passes).tolist():
        side = side_at(b)[k]
        time = a.time if side_at(a)[k] == side else time_of(k, a, b, look)
        if time <= first and is_infinite(k, float(side), time, look):
            first = look.pole_time = time
            look.pole = 1 + k - len(passes) + look.work.scene.n_poles


def see_beside(way: float, time: float, read: Array, noise: Array, look: Look) -> TimeNode:
    """Node that far from a time where formulas read this, and go on evenly."""
    there = read.copy()
    there[:, 0] += way * read[:, 1]
    there[:, 1] += way * look.bend
    return see_at(there, noise, time + way, look.work.w)


def sizes_beside(way: float, time: float, read: Array, look: Look) -> Array:
    """Sizes of parts of forces that may be infinite, that far from a time."""
    node = see_beside(way, time, read, np.zeros_like(read), look)
    return np.abs(middle(node)[len(node.least) - len(look.work.w.infinite) // 4 :])


def is_infinite(k: int, side: float, time: float, look: Look) -> bool:
    """Whether a force is infinite where a function gets on a side of zero at a time.

    So that no motion leads through: it grows as 1/x or faster on a side. What is 0/0 there, or
    jumps, does not grow, and what grows less, as 1/sqrt(x), has a finite integral.
    """
    read, far = read_at(time, look), ROUNDINGS * SMALLEST * larger(abs(time), look.h)
    while (
        side_at(see_beside(-far, time, read, look.rounding, look))[k] != -side
        or side_at(see_beside(far, time, read, look.rounding, look))[k] != side
    ):
        far *= FURTHER
        if not far < look.state.stride:
            return True  # rounding hides that
    is_pole = np.zeros(len(look.work.w.infinite) // 4, dtype=bool)
    for way in (-far, far):
        near = sizes_beside(FURTHER * FURTHER * way, time, read, look)
        there = sizes_beside(FURTHER * FURTHER * FURTHER * way, time, read, look)
        away = sizes_beside(FURTHER * FURTHER * FURTHER * FURTHER * way, time, read, look)
        grows = (near > STEEP * there) & (there > STEEP * away)
        both, square = near * away, there * there
        grows &= (both <= EVENLY * square) & (square <= EVENLY * both)
        is_pole |= grows | np.isinf(near)
    return bool(is_pole.any())


def end_before_pole(look: Look) -> float:
    """End of a step before a pole that is seen in it: its start if that is near."""
    way = look.pole_time - look.start
    return look.start + CLOSER * way if way > NO_WAY * look.state.stride else look.start


def why_stopped(seen: float, look: Look) -> Status:
    """Reason why a run leads no further, where a step would end there; GOOD where it does."""
    state = look.state
    if look.lost:
        state.event = float(look.lost)
        return Status.NO_VALUE
    if look.pole and not seen > state.time:
        state.pole = float(look.pole)
        return Status.INFINITE
    return Status.GOOD


def gap_across(
    k: int, side: float, time: float, far: float, look: Look, *, is_beyond: bool
) -> float:
    """Difference of a function from one side of a time to the other, so far away.

    That is in the polynomial, or beyond it. It is 0 where values, as far as they are known, are not
    on the sides of zero, and negative where it gets on the other one.
    """
    if is_beyond:
        read = read_at(time, look)
        a = see_beside(-far, time, read, look.rounding, look)
        b = see_beside(far, time, read, look.rounding, look)
    else:
        a = look_closely(look.rounding, time - far, look)
        b = look_closely(look.rounding, time + far, look)
    if side_at(a)[k] != -side or side_at(b)[k] != side:
        return -1.0 if side_at(a)[k] == side and side_at(b)[k] == -side else 0.0
    return float(b.least[k] - a.most[k] if side > 0.0 else a.least[k] - b.most[k])


def passes_zero(k: int, side: float, end: float, look: Look) -> bool:
    """Whether an event that gets on a side of zero in a step to an end is zero there.

    Else it jumps, or goes through infinity: right beside the place it is as large as further away,
    or larger. Where rounding hides that it counts as zero. It may be beyond a short step, of
    whose end no more is known, where its polynomial tells nothing. Where it gets on the other side
    rounding brought it back over a jump that was passed.
    """
    if look.work.scene.events[k, 2] == 0:
        return True
    first, last = look.start, end
    if side_at(look_closely(look.rounding, end, look))[k] != side:
        last = end + SMALL * look.h
    while last - first > SMALLEST * larger(abs(first), abs(last)):
        time = 0.5 * (first + last)
        if not first < time < last:
            break
        if side_at(look_closely(look.rounding, time, look))[k] == side:
            last = time
        else:
            first = time
    far = ROUNDINGS * SMALLEST * larger(abs(last), look.h)
    while far < larger(look.h, look.state.stride) / FURTHER:
        is_beyond = not far < look.h / FURTHER
        gap = gap_across(k, side, last, far, look, is_beyond=is_beyond)
        if gap != 0.0:
            further = gap_across(k, side, last, FURTHER * far, look, is_beyond=is_beyond)
            return gap > 0.0 and further >= LARGER_THERE * gap
        far *= FURTHER
    return True


def polished_cut(look: Look) -> float:
    """Time of an event that a step was cut for, by the step that ends near it."""
    most, cut = SMALL * look.h, look.cut
    sides = look.state.sides
    every = np.flatnonzero(look.was_crossing[: len(look.work.scene.events)]).tolist()
    found = next((k for k in every if passes_zero(k, -sides[k], cut, look)), None)
    if found is None:
        return cut

    def value(time: float) -> float:
        return float(middle(look_closely(noise_of(found, look), time, look))[found])

    before, there = cut - most, cut
    a, b = value(before), value(there)
    for _ in range(4):
        if a == b:
            break
        time = there - b / ((b - a) / (there - before))
        if not abs(time - cut) <= most or time == there:
            break
        a, before, there = b, there, time
        b = value(there)
    return there


def is_thrown_back(k: int, end: float, look: Look) -> bool:
    """Whether an event that passed zero is back there, where a jump of a force threw it back.

    So it is all the time while dry friction holds a body at rest. Nothing got further meanwhile
    than it is known to. On its way through a narrow window it goes on evenly: half as long ago as
    it passed zero it was on the side that it leaves, before and soon it is on the other one. Where
    it was held once that is not asked again.
    """
    state, way, read = look.state, end - look.state.crossed[k], read_at(end, look)
    speeds, known = np.column_stack((read[:, 1], look.bend)), look.noise[:, 0]
    is_there = len(read) > 0 and way <= NO_WAY * state.stride
    if is_there:
        most = np.column_stack((known, known * state.fastest))
        is_there = bool((np.abs(speeds) * way <= most).all())
    if not is_there:
        state.held[k] = 0.0
    elif state.held[k] == 0.0:
        beside = (-EARLIER * way, -HALF * way, HALF * way)
        nodes = (see_beside(part, end, read, look.rounding, look) for part in beside)
        before, between, behind = (side_at(node)[k] * state.sides[k] for node in nodes)
        state.held[k] = float(not (before < 0.0 and between > 0.0 and behind < 0.0))
    return bool(state.held[k] > 0.0)


def note_crossings(end: float, look: Look) -> None:
    """Note what a step that is kept has crossed: one that was cut, also what is zero there."""
    state, events = look.state, look.work.scene.events
    sides, now = state.sides.copy(), side_at(look_at(end, look))
    is_near = (now == 0.0) | (side_at(look_closely(look.noise, end, look)) == 0.0)
    is_back = (now[: len(sides)] == -sides) & ~is_still_short(sides, end, look)
    for k, side in enumerate(sides.tolist()):
        is_there = is_near[k] and end == look.cut and look.was_crossing[k]
        if side == 0.0 or not (is_back[k] or is_there):
            continue
        is_same = k < len(events) and is_thrown_back(k, end, look)
        state.sides[k] = -side
        if k >= len(events):
            continue
        state.crossed[k] = end
        if is_same or events[k, 0] not in {0, -side} or not passes_zero(k, -side, end, look):
            continue
        state.counts[k] += 1.0
        if ACTIONS[events[k, 1]] != "count":
            state.fired[k] = 1.0


def are_narrow_told(start: float, end: float, look: Look) -> bool:
    """Whether samples between two times tell how parts vary.

    Their rates change as little, or bounds leave them nearly what they are, or, where formulas
    switch and an error tells of what they change by, no more than samples show, as of a root at
    whose end no rate is bounded.
    """
    h, first = (end - start) / CELLS, len(look.state.sides)
    n = slice(first, first + len(look.work.w.narrow) // 4)
    a = look_at(start, look)
    least = most = low = high = middle(a)[n]
    band, change, reach = half_width(a)[n], np.zeros(len(least)), np.zeros(len(least))
    for cell in range(1, CELLS + 1):
        b = look_at(start + cell * h, look)
        below, above, slowest, fastest = bound_seen(a, b, look)[:, n]
        least, most = smallest(middle(b)[n], least), largest(middle(b)[n], most)
        low, high = smallest(below, low), largest(above, high)
        band, change = largest(half_width(b)[n], band), change + h * (fastest - slowest)
        reach = reach + (above - below)
        a = b
    size = largest(-least, most)
    nothing = band + NOTHING * np.where(size > 1.0, size, 1.0)
    is_shown = (reach <= SHOWN * (most - least) + nothing) & look.has_error
    is_explained = is_shown | (change <= EXPLAINED * (most - least) + nothing)
    return bool(np.all(is_explained | (high - low <= STEADY * size + nothing)))


def is_at_pole(first: float, last: float, look: Look, *, in_between: bool) -> bool:
    """Whether at both times a function is near to zero, or in between, for a pole.

    A force may be infinite there: no bound tells how it varies, and of what is narrow the energy
    does.
    """
    n, count = len(look.state.sides), look.work.scene.n_poles
    if count == 0:
        return False
    a, b = (side_at(look_closely(look.noise, time, look))[n - count : n] for time in (first, last))
    is_there = (a == 0.0) & (b == 0.0)
    return bool((is_there | (in_between & (a * b != 1.0))).any())


def told_end(end: float, look: Look) -> float:
    """Time at which a step to an end must end so that samples tell how parts vary.

    What they do not tell in the finest intervals either is gone over, and noted.
    """
    start = first = look.start
    whole = allowed = width = end - start
    looks = 0
    while first < start + allowed:
        if looks == MOST_LOOKS:
            look.is_untold = look.is_untold or not is_at_pole(first, end, look, in_between=True)
            break
        looks += 1
        last = smaller(first + width, end)
        is_there = is_at_pole(first, last, look, in_between=False)
        is_good = not is_there and are_narrow_told(first, last, look)
        if not (is_good or is_there) and width > FINEST * look.h:
            width = 0.5 * width
            continue
        if is_good:
            allowed = smaller(allowed, larger(first - start, last - first))
        elif not is_at_pole(first, last, look, in_between=True):
            look.is_untold = True
        first = last
        width = 2.0 * width
    return start + allowed if allowed < whole else end
