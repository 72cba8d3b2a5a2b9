"""Settings of a run, as the struct of a solver's header, and the status of a call.

The header is written from here, field by field and code by code.
"""

from __future__ import annotations

from enum import IntEnum, IntFlag
from typing import NamedTuple

from .methods import METHODS

#: Options of a run.
OPTIONS = (
    *("tolerance", "method", "step", "largest_step", "checks", "most_steps", "parameters"),
    *("initial", "q0", "v0"),
)
#: Number of steps that a run makes at most by default.
MOST_STEPS = 1_000_000
#: The method of scenes whose motion drivers determine.
KINEMATICS = "kinematics"
#: Smallest tolerance at which each Runge-Kutta method needs the fewest evaluations for the error
#: that it gives, as ``make bench`` measures.
LEAST_TOLERANCES = {"dopri5": 2e-5, "dop853": 0.0}
#: Violation, in closure tolerances, above which a dropped row is not redundant: memory.h has it,
#: too.
CLEARLY = 10.0
#: Motion of bodies in a step, in lengths of the scene or radians, up to which they count as at
#: rest: velocities are then compared with it; memory.h has it, too.
NOTHING_MOVES = 1e-4
#: Time that is no longer than rounding of times, in smallest steps: memory.h has it, too.
NO_TIME = 8.0
#: Part of a rate by which it changes unevenly within this time where its law bends: memory.h has
#: it, too.
BENT = 1e-6


#: What a run does at an event, by its number.
ACTIONS = ("record", "count", "stop")


def method_for(tolerance: float, *, is_driven: bool) -> str:
    """Method of a run that asks for none: what costs least for its tolerance."""
    if is_driven:
        return KINEMATICS
    return next(name for name, least in LEAST_TOLERANCES.items() if tolerance >= least)


class Settings(NamedTuple):
    """Settings that the integrator takes, as numbers: the record ``settings`` of ``solver.h``.

    What a user asks for, with parameters and the start, are ``Options`` of the runtime.

    Parameters
    ----------
    tolerance : float
        Local error of a step, relative.
    largest_step : float [s]
        No step is longer.
    fixed_step : float [s]
        Length of all steps, whatever their error; they are shorter only at the end, where formulas
        switch or are narrow, and near dependent rows. 0: the error decides.
    checks : int
        Whether rows are checked: what is left of the constraints, the energy.
    method : int
        0-based index of the Runge-Kutta method; their number stands for ``kinematics``, where
        drivers determine the motion.
    """

    tolerance: float
    largest_step: float
    fixed_step: float
    checks: int
    method: int

    @property
    def is_kinematic(self) -> bool:
        """Whether drivers tell positions: the method after those of Runge and Kutta."""
        return self.method == len(METHODS)


class Status(IntEnum):
    """Status of a call; a run that was stopped goes on from where it is, with the same bits.

    ``EVENT`` and ``STOPPED``: an event is at the time that was reached. Its row stands behind those
    that were written, and is not counted with them; after ``STOPPED`` a run does not go on.
    ``NO_VALUE``: the formula of an event has no finite value at the start, or none from where the
    run came. ``BENDS``: the law of a driver bends or jumps where the run came.
    ``INFINITE``: a force is infinite right behind the time that was reached. ``DEPENDENT``: rows
    are nearly dependent that are independent at nominal parameters. ``NO_DIRECTION``: two
    points whose distance is driven meet where the run came.
    """

    GOOD = 0
    BUFFER_FULL = 1
    PAUSED = 2
    EVENT = 3
    STOPPED = 4
    STEP_TOO_SMALL = -1
    NOT_PROJECTED = -2
    NOT_ASSEMBLED = -3
    BAD_ARGUMENT = -4
    WRONG_STATE = -5
    NOT_CLOSED = -6
    NO_VALUE = -7
    BENDS = -8
    INFINITE = -9
    DEPENDENT = -10
    NO_DIRECTION = -11


class Doubt(IntFlag):
    """Doubts about a run, in bits; ``OPEN`` are rows that were left out."""

    NOT_FINITE = 1
    OPEN = 2
    ENERGY = 4
    WORKS = 8
    CONSTRAINTS = 16
    DRIFT = 32
    ROW_DRIFT = 64
    BRANCH_POINTS = 128
    NARROW = 256
    IMPULSE = 512


#: Why a run did not start, or does not go on.
MESSAGES: dict[int, str] = {
    Status.PAUSED: "most_steps are made",
    Status.STEP_TOO_SMALL: "no step can be taken: from here on the motion is not determined, it is"
    " too fast, or the tolerance is too tight for doubles",
    Status.NOT_PROJECTED: "the constraints cannot be met inside of a step, as where their rows are"
    " dependent; steps of other lengths may pass such a place",
    Status.NOT_ASSEMBLED: "the start cannot be brought onto the constraints, or they do not"
    " determine the motion there, or a formula of a force has no finite value there, which"
    " kousoku check names",
    Status.BAD_ARGUMENT: "a number is not finite, or an argument is out of range",
    Status.NOT_CLOSED: "joints come open: constraints that were left out, because they depend on"
    " others where they were looked at, do not depend on them here",
    Status.DEPENDENT: "rows of joints depend on each other nearly, that do not with the parameters"
    " of the scene",
    Status.WRONG_STATE: "the state belongs to another solver, or was damaged",
}
