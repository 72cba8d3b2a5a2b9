"""Crossing: steps end where events are and where formulas of the state have a kink or a jump.

A step that was tried is looked at before it is kept. Its polynomial tells at some times what
formulas read: coordinates, lengths of springs, their rates. That bounds them between these times,
and they bound the functions and their rates, as of switching functions of time. What is nearer to
zero than the error of a step may be counts as zero: a function crosses when it is beyond on the
other side. Then the step is made again, to end there. Parts of formulas that vary with the state
beyond polynomials are bounded likewise: where samples do not tell how, the step is made shorter.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from .dense_output import add_dense_rows, hermite_cubic, interpolate
from .scene import larger, smaller
from .settings import ACTIONS

if TYPE_CHECKING:
    import numpy.typing as npt

    from .methods import Method
    from .scene import Work
    from .settings import Settings
    from .state import State

    Array = npt.NDArray[np.float64]
    Flags = npt.NDArray[np.bool_]

#: The smallest step, relative to the time.
SMALLEST = 1e-15
#: In how many parts a step is looked at, and how often at most.
CELLS = 4
MOST_LOOKS = 512
#: Second derivatives may be so much further from those of a cubic polynomial as it is from a
#: parabola.
DOUBT = 2.0
#: How much bounds may exceed what samples tell; what always may be left, by the size of a part.
EXPLAINED = 2.0
NOTHING = 1e-12
#: A part that changes by less than this part of it in an interval needs no samples.
STEADY = 0.5
#: The shortest interval in which a part is looked at, in a step: what is narrower has no bounds.
FINEST = 1e-9
#: The part of the way of a step by which its polynomial may leave the cubic one.
FAR = 0.5
#: The part of a step by which an event may be off where the step was cut, to be found again.
SMALL = 1e-3
#: What rates are known to of a length in a step, in units of the tolerance.
SLOW = 1e-4


def largest(a: Array, b: Array) -> Array:
    """Return the larger of each two numbers, the second if the first is a NaN."""
    return np.where(a > b, a, b)


def smallest(a: Array, b: Array) -> Array:
    """Return the smaller of each two numbers, the second if the first is a NaN."""
    return np.where(a < b, a, b)


def stay_positive(a: Array, b: Array, falls: Array, rises: Array, h: float) -> Flags:
    """Return whether what is a at the start of h and b at its end is positive between.

    It is no less than lines from both ends as steep as it falls and rises at most.
    """
    found: Flags = a * rises - b * falls + falls * rises * h > 0.0
    return found


@dataclass(slots=True)
class Node:
    """What is seen at a time of a step.

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

    @property
    def side(self) -> Array:
        """1 or -1, the side of zero of each function; 0 where that is not known."""
        found: Array = (self.least > 0.0) * 1.0 - (self.most < 0.0)
        return found

    @property
    def middle(self) -> Array:
        """The middle of each function's bounds."""
        found: Array = 0.5 * (self.least + self.most)
        return found

    @property
    def half_width(self) -> Array:
        """Half of their distance."""
        found: Array = 0.5 * (self.most - self.least)
        return found


@dataclass(slots=True)
class Look:
    """A step that is looked at, whose polynomial is in the state.

    Parameters
    ----------
    state, work : State, Work
        Of the run.
    cut : float [s]
        Where it was cut.
    m, start, h : Method, float [s], float [s]
        How it was made.
    least_part : float
        At which part of it at least it may be cut.
    is_distorted : bool
        Whether stages that only the polynomial wants were elsewhere, so that it is cubic.
    slack : float [s]
        What crosses within it crosses together.
    noise : (n, 2) array
        What values are known to.
    crosses, was_crossing : array of bool
        Which functions cross, and crossed where it was cut.
    """

    state: State
    work: Work
    cut: float
    m: Method = field(init=False)
    start: float = 0.0
    h: float = 0.0
    least_part: float = 0.0
    is_distorted: bool = False
    slack: float = 0.0
    noise: Array = field(init=False)
    crosses: Flags = field(init=False)
    was_crossing: Flags = field(init=False)

    def into(
        self, s: Settings, m: Method, h: float, y: Array, f: Array, *, has_stages: bool
    ) -> None:
        """Make the polynomial of a step from the state to y, where the derivative is f."""
        state, scene = self.state, self.work.scene
        self.m, self.start, self.h, self.slack = m, state.time, h, s.tolerance * h
        state.y_before[:] = state.y
        state.dense[:] = 0.0
        hermite_cubic(h, y, state.f, f, state)
        middle = state.time + 0.5 * h
        first, cubic, last = map(self._read_at, (state.time, middle, state.time + h))
        most, sizes = largest(np.abs(first), np.abs(last)), scene.measure_sizes
        self.noise = np.empty_like(most)
        self.noise[:, 0] = s.tolerance * sizes + SMALLEST * most[:, 0]
        self.noise[:, 1] = s.tolerance * (most[:, 1] + SLOW * sizes / h)
        self.is_distorted = False
        if not has_stages:
            return
        add_dense_rows(m, h, state, self.work)
        way = np.abs(cubic - first) + np.abs(last - cubic)
        is_near = np.abs(self._read_at(middle) - cubic) <= FAR * way + self.noise
        self.is_distorted = not bool(is_near.all())
        if self.is_distorted:
            state.dense[3:] = 0.0

    def _read_at(self, time: float) -> Array:
        work = self.work
        interpolate(self.m, (time - self.start) / self.h, self.state, work.scratch)
        work.w.place(time, work.scratch)
        work.w.run("measure")
        found: Array = work.w.measures.reshape(-1, 2).copy()
        return found

    def at(self, time: float) -> Node:
        """Return what is seen at a time."""
        w, read = self.work.w, self._read_at(time)
        own = w.ranges[2:].reshape(-1, 6)
        w.ranges[:2] = time
        own[:, [0, 2]], own[:, [1, 3]], own[:, 4:] = read - self.noise, read + self.noise, 0.0
        w.run("crossing")
        least, most = w.seen.reshape(-1, 4).T[:2].copy()
        return Node(time, read, least, most)

    def bounds(self, a: Node, b: Node) -> Array:
        """Return least, most, slowest and fastest of the functions between two nodes."""
        w, h = self.work.w, b.time - a.time
        (x, v), (y, u) = a.read.T, b.read.T
        own = w.ranges[2:].reshape(-1, 6)
        w.ranges[:2] = a.time, b.time
        mean = (u - v) / h
        bend = np.abs(3.0 * (v + u) - 6.0 * (y - x) / h) / h
        own[:, 4], own[:, 5] = mean - DOUBT * bend, mean + DOUBT * bend
        reach_between(v, u, own[:, 4], own[:, 5], h, own[:, 2:4])
        reach_between(x, y, own[:, 2], own[:, 3], h, own[:, :2])
        w.run("crossing")
        return w.seen.reshape(-1, 4).T

    def cut_at(self, end: float) -> float:
        """Cut the step where it must end, and remember what crosses there."""
        self.was_crossing, self.cut = self.crosses, end
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


def are_told(sides: Array, a: Node, b: Node, bounds: Array) -> Flags:
    """Return whether functions cross between two nodes as often as their sides tell."""
    n, is_down = len(sides), sides < 0.0
    low, high, slowest, fastest = bounds[:, :n]
    sign, least = np.where(is_down, -1.0, 1.0), np.where(is_down, -high, low)
    falls, rises = np.where(is_down, -fastest, slowest), np.where(is_down, -slowest, fastest)
    band = largest(a.half_width[:n], b.half_width[:n])
    is_clear = (least > -band) | (falls >= 0.0) | (rises <= 0.0)
    first, last = sign * a.middle[:n] + band, sign * b.middle[:n] + band
    is_positive = stay_positive(first, last, falls, rises, b.time - a.time)
    stays = is_clear | np.where(sides == 0.0, high < band, is_positive)
    crosses = (sides != 0.0) & (b.side[:n] == -sides)
    told: Flags = np.where(crosses, rises <= 0.0, stays)
    return told


def time_of(k: int, a: Node, b: Node, look: Look) -> float:
    """Return the first time between two nodes at which a function that crosses does.

    Those of events are zero there, the others beyond it, so that what follows is all on the other
    side.
    """
    side, first, last = -float(b.side[k]), a.time, b.time
    is_event = k < len(look.work.scene.events)
    while last - first > SMALLEST * larger(abs(first), abs(last)):
        time = 0.5 * (first + last)
        if not first < time < last:
            break
        node = look.at(time)
        if side * node.middle[k] <= 0.0 if is_event else node.side[k] == -side:
            last = time
        else:
            first = time
    return last


def first_time(a: Node, b: Node, look: Look) -> float:
    """Return when the first function crosses; only those that do so there are left."""
    times = {int(k): time_of(int(k), a, b, look) for k in np.flatnonzero(look.crosses)}
    first = min(times.values())
    for k, time in times.items():
        look.crosses[k] = time <= first + look.slack
    return first


def seen_end(end: float, look: Look) -> float:
    """Return where a step to an end must end: where a function first crosses, or what was seen."""
    sides = look.state.sides
    n, start = len(sides), look.start
    tiny = SMALLEST * larger(abs(start), abs(end))
    nearest = start + larger(8.0 * tiny, look.least_part * look.h)
    widest = look.h / CELLS
    width, a = widest, look.at(start)
    for _ in range(MOST_LOOKS):
        if not a.time < end:
            break
        b = look.at(a.time + width if a.time + 1.0000001 * width < end else end)
        bounds = look.bounds(a, b)
        sides[:] = np.where(sides == 0.0, a.side[:n], sides)
        is_known = bool(are_told(sides, a, b, bounds).all())
        look.crosses = (sides != 0.0) & (b.side[:n] == -sides)
        if not is_known and b.time - a.time > tiny:
            width = 0.5 * (b.time - a.time)
            continue
        if look.crosses.any():
            return smaller(larger(first_time(a, b, look), nearest), end)
        a, width = b, smaller(2.0 * width, widest)
    return a.time if nearest < a.time < end else end


def polished_cut(look: Look) -> float:
    """Return where an event is that a step was cut for, by the step that ends near it."""
    most, cut = SMALL * look.h, look.cut
    found = np.flatnonzero(look.was_crossing[: len(look.work.scene.events)]).tolist()
    if not found:
        return cut

    def value(time: float) -> float:
        return float(look.at(time).middle[found[0]])

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


def note_crossings(end: float, look: Look) -> None:
    """Note what a step that is kept has crossed: one that was cut, also what is zero there."""
    state, events = look.state, look.work.scene.events
    sides, now = state.sides.copy(), look.at(end).side
    for k, side in enumerate(sides.tolist()):
        is_there = now[k] == 0.0 and end == look.cut and look.was_crossing[k]
        if side == 0.0:
            state.sides[k] = now[k]
        if side == 0.0 or not (now[k] == -side or is_there):
            continue
        state.sides[k] = -side
        if k < len(events) and events[k, 0] in {0, -side}:
            state.counts[k] += 1.0
            if ACTIONS[events[k, 1]] != "count":
                state.fired[k] = 1.0


def are_narrow_told(start: float, end: float, look: Look) -> bool:
    """Return whether samples between two times tell how parts vary.

    Their rates change as little, or their bounds leave them nearly what they are.
    """
    n, h = len(look.state.sides), (end - start) / CELLS
    a = look.at(start)
    least = most = low = high = a.middle[n:]
    band, change = a.half_width[n:], np.zeros(len(least))
    for cell in range(1, CELLS + 1):
        b = look.at(start + cell * h)
        below, above, slowest, fastest = look.bounds(a, b)[:, n:]
        least, most = smallest(b.middle[n:], least), largest(b.middle[n:], most)
        low, high = smallest(below, low), largest(above, high)
        band, change = largest(b.half_width[n:], band), change + h * (fastest - slowest)
        a = b
    size = largest(-least, most)
    nothing = band + NOTHING * np.where(size > 1.0, size, 1.0)
    is_explained = change <= EXPLAINED * (most - least) + nothing
    return bool(np.all(is_explained | (high - low <= STEADY * size + nothing)))


def told_end(end: float, look: Look) -> float:
    """Return where a step to an end must end so that samples tell how parts vary."""
    start = first = look.start
    whole = allowed = width = end - start
    for _ in range(MOST_LOOKS):
        last = smaller(first + width, end)
        is_good = are_narrow_told(first, last, look)
        if not is_good and width > FINEST * whole:
            width = 0.5 * width
            continue
        if is_good:
            allowed = smaller(allowed, larger(first - start, last - first))
        first = last
        if not first < start + allowed:
            break
        width = 2.0 * width
    return start + allowed if allowed < whole else end
