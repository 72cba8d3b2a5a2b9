"""Events of a run, and words for where events, drivers or forces lead no further."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from .settings import BENT, NO_TIME

if TYPE_CHECKING:
    from .arithmetic import Array
    from .motion import Layout, Motion


class EventLog(NamedTuple):
    """Log of the events of a run.

    Parameters
    ----------
    counts : tuple of int
        How often each was.
    rows : (n, 1 + row_size) array
        The index of an event, then the row there, in the order of time.
    """

    counts: tuple[int, ...]
    rows: Array


def without_value(layout: Layout, event: float, where: str) -> str:
    """Message on which formula of an event has no value, and what to do.

    Parameters
    ----------
    layout : Layout
        Of the scene.
    event : float
        The number in the state of the run, counted from 1.
    where : str
        Where it has none.
    """
    (name, _), when = layout.events[int(event) - 1], layout.whens[int(event) - 1]
    return (
        f"events.{name}: {when} has no finite value {where}; write it so that it has one, as"
        " sqrt(max(x, 0)) in place of sqrt(x) and x - 1 of log(x), start elsewhere, or let an event"
        ' with action = "stop" end the run before'
    )


def bends(layout: Layout, bent: float, limit: float, behind: float) -> str:
    """Message on which driver leads no further, and what to do.

    Parameters
    ----------
    layout : Layout
        Of the scene.
    bent : float
        The number of its law in the state of the run, counted from 1.
    limit, behind : float [s]
        Between which times it bends.
    """
    driver, time = layout.led[int(bent) - 1], NO_TIME / math.sqrt(BENT) * (behind - limit)
    return (
        f"no step can be taken: the law of drivers.{driver} bends or jumps within {time:.0e} s, so"
        " that velocities or accelerations do: a driver must have two derivatives; wanted a smooth"
        " formula, or one that turns more slowly"
    )


def without_direction(layout: Layout, drawn: float) -> str:
    """Message on which driver brings two points together, and what to do.

    Parameters
    ----------
    layout : Layout
        Of the scene.
    drawn : float
        The number of its distance in the state of the run, counted from 1.
    """
    driver = layout.drawn[int(drawn) - 1]
    return (
        f"no step can be taken: drivers.{driver} prescribes a distance of 0, or less, where its two"
        " points meet: nothing tells in which direction they part; wanted a formula that stays"
        " positive, or a driver of a displacement along an axis, which has a sign"
    )


def infinite(layout: Layout, pole: float) -> str:
    """Message on which force no motion leads through, and what to do.

    Parameters
    ----------
    layout : Layout
        Of the scene.
    pole : float
        The number in the state of the run, counted from 1.
    """
    return (
        f"no step can be taken: {layout.poles[int(pole) - 1]} is infinite right behind, as 1/x"
        " where x is 0: no motion leads through; wanted a formula that is bounded there, as"
        " x/(x^2 + 1e-6) for 1/x"
    )


def add_row(rows: list[Array], event: float, row: Array) -> None:
    """Add the row of an event, whose number is counted from 1, unless it is there already.

    Parameters
    ----------
    rows : list of (1 + row_size,) array
        As of :class:`EventLog`.
    event : float
        Its number in the state of the run.
    row : (row_size,) array
        The row.
    """
    new = np.concatenate(([event - 1.0], row))
    if not (rows and np.array_equal(rows[-1][:2], new[:2])):
        rows.append(new)


@dataclass(frozen=True, slots=True)
class EventOccurrences:
    """An event of a run.

    Parameters
    ----------
    name, action : str
        As in the scene.
    count : int
        How often it was.
    states : Motion
        The states there, a row each; none of an event that is only counted.
    """

    name: str
    action: str
    count: int
    states: Motion

    @property
    def time(self) -> Array:
        """Times (n,) [s] at which it was; none of an event that is only counted."""
        return self.states.time

    def __repr__(self) -> str:
        times = ", ".join(f"{time:.6g}" for time in self.time[:3])
        more = ", …" * (len(self.time) > 3)
        at = f", at {times}{more} s" if times else ""
        return f"<Event {self.name}: {self.count} time{'s' * (self.count != 1)}{at}>"
