"""The state of a run: all that lasts from call to call, laid out once for all that use it.

The body of :class:`State` is the record of what is where. The header of a solver in C declares the
struct after it, the integrator in NumPy works on it, ``motion.json`` tells it to those who read a
run.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple, overload

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from .arithmetic import Array


class Field(NamedTuple):
    """A field of the state.

    Parameters
    ----------
    name : str
        In C and in Python.
    place : int
        Of its first number.
    shape : tuple of int
        Count of numbers along each axis; empty of a single number.
    unit : str
        ``s``, ``J``, ``-``; empty where its numbers have different ones.
    meaning : str
        What it is.
    """

    name: str
    place: int
    shape: tuple[int, ...]
    unit: str
    meaning: str

    @property
    def room(self) -> tuple[int, ...]:
        """Count of numbers that are set aside along each axis: C has no empty arrays."""
        return tuple(max(count, 1) for count in self.shape)

    def view(self, numbers: Array) -> Array:
        """Part of a state (state_size,) that the field is, in its shape and unit: a view."""
        size = math.prod(self.room)
        values = numbers[self.place : self.place + size].reshape(self.room)
        return values[tuple(slice(count) for count in self.shape)] if self.shape else values


class StateNumber:
    """A number of the state.

    Parameters
    ----------
    unit, meaning : str
        As of a :class:`Field`.
    """

    def __init__(self, unit: str, meaning: str) -> None:
        self.unit = unit
        self.meaning = meaning
        self.shape: tuple[str, ...] = ()
        self.name = ""
        self.place = -1

    @overload
    def __get__(self, state: None, owner: type[State]) -> StateNumber: ...

    @overload
    def __get__(self, state: State, owner: type[State]) -> float: ...

    def __get__(self, state: State | None, owner: type[State]) -> StateNumber | float:
        """Read it."""
        return self if state is None else float(state.numbers[self.place])

    def __set__(self, state: State, value: float) -> None:
        """Write it."""
        state.numbers[self.place] = value


class Numbers:
    """An array in the state.

    Parameters
    ----------
    *shape : str
        The size of each axis, as the solver calls it.
    unit, meaning : str
        As of a :class:`Field`.
    """

    def __init__(self, *shape: str, unit: str, meaning: str) -> None:
        self.shape = shape
        self.unit = unit
        self.meaning = meaning
        self.name = ""

    @overload
    def __get__(self, state: None, owner: type[State]) -> Numbers: ...

    @overload
    def __get__(self, state: State, owner: type[State]) -> Array: ...

    def __get__(self, state: State | None, owner: type[State]) -> Numbers | Array:
        """View that a state was made with."""
        return self if state is None else state.views[self.name]


class State:
    """The state of a run.

    Parameters
    ----------
    numbers : array
        Where it is.
    sizes : mapping of str to int
        ``NY`` and others that shapes name.
    """

    key = StateNumber("-", "which solver made it; negative where it could not be started")
    time = StateNumber("s", "time reached")
    step_size = StateNumber("s", "length of the next step")
    error = StateNumber("-", "error of the last step, in units of the tolerance")
    next_row = StateNumber("-", "the first time that is still to be written")
    time_before = StateNumber("s", "where the last step began")
    steps = StateNumber("-", "steps that were made")
    rejected = StateNumber("-", "steps that were tried in vain")
    derivatives = StateNumber("-", "evaluations of the accelerations")
    factorisations = StateNumber("-", "of C_q M^-1 C_q^T")
    drift = StateNumber("-", "largest correction of a whole step, lengths relative to LENGTH")
    fastest = StateNumber("1/s", "largest speed of the steps so far, lengths relative to LENGTH")
    stride = StateNumber(
        "s", "the longest step so far, or what moves a part of a length at the start"
    )
    work_error = StateNumber("J", "of works under kinematics, what Simpson's rule left unnoticed")
    simpson = StateNumber(
        "-", "error of works by Simpson's rule, in units of the tolerance, fading"
    )
    balance = StateNumber(
        "J", "energy that no work explains, at the last position under kinematics"
    )
    untold = StateNumber("s", "length of steps since Lobatto's rule last checked the works")
    is_refined = StateNumber("-", "1: accelerations are refined all along, 0.5: looked at, else 0")
    method = StateNumber("-", "1 + the method; 0 before the first step")
    avoided = StateNumber(
        "-", "lengths of steps given up, since a stage was where rows are dependent"
    )
    least_pivot_ratio = StateNumber("-", "smallest pivot ratio of all steps")
    least_pivot_ratio_time = StateNumber("s", "when that was")
    largest_pivot_ratio = StateNumber("-", "largest pivot ratio of all steps")
    energy = StateNumber("J", "at the start")
    energy_error = StateNumber("J", "largest change that no work explains, in the rows checked")
    corrections = StateNumber("-", "of positions, in Newton's method")
    passed = StateNumber(
        "-", "rows where constraints are dependent: the polynomial alone tells them"
    )
    passed_time = StateNumber("s", "when the last of them was")
    fallbacks = StateNumber("-", "factorisations of all rows, those too that are left out")
    fallback_time = StateNumber("s", "when the last of them was")
    longest = StateNumber("s", "longest step tried before bounds of formulas of time, fading")
    short_steps = StateNumber("-", "steps in a row that are very short beside it")
    unresolved = StateNumber("-", "steps over which bounds do not tell how formulas vary")
    unresolved_time = StateNumber("s", "when the last of them was")
    impulse = StateNumber("1/s", "what is not known of forces, infinite or too steep for doubles")
    impulse_time = StateNumber("s", "when the last of them was")
    steepness = StateNumber("1/s^2", "by how much rounding changes accelerations at the last time")
    branch_points = StateNumber("-", "steps that may have ended on another branch")
    branch_point_time = StateNumber("s", "when the first of them was")
    meetings = StateNumber(
        "-", "steps straight on where branches meet, or nearer than rounding tells"
    )
    meeting_time = StateNumber("s", "when the first of them was")
    is_near = StateNumber("-", "1 where branches may meet in the driven step that is tried, else 0")
    refinements = StateNumber("-", "accelerations that were refined, since much of them was lost")
    pivot_ratio = StateNumber("-", "the pivot ratio of the last accelerations")
    position_ratio = StateNumber("-", "branch ratio at the last position that was kept")
    usual_ratio = StateNumber("-", "largest branch ratio so far")
    root_before = StateNumber("-", "root of the branch ratio at a stage before that position")
    stage_before = StateNumber("s", "time from this stage to that position; 0: none")
    least_inverse_pivot = StateNumber("kg", "of all steps; 0 before the first")
    limit = StateNumber("s", "no step goes beyond: where formulas of time switch, or the end")
    behind = StateNumber("s", "first time behind that switch; as limit where there is none")
    switched = StateNumber("s", "where formulas switched last, of time or of the state")
    bent = StateNumber(
        "-", "1-based index of the law that bends, or gap that closes, here; 0: none"
    )
    pole = StateNumber("-", "1-based index of the function zero where a force is infinite; 0: none")
    potential = StateNumber("J", "potential energy at the start")
    energy_moved = StateNumber("J", "kinetic energy, change of potential, works: largest sum")
    moved = StateNumber("J", "the same at ends of steps: errors of works are compared with it")
    row_drift = StateNumber("-", "largest correction of a row between steps, relative to LENGTH")
    not_finite = StateNumber("-", "rows with numbers that are not finite, those passed left out")
    not_finite_time = StateNumber("s", "when the first of them was")
    event = StateNumber("-", "1-based index of the event told last, or without a value; 0: none")
    y = Numbers("NY", unit="", meaning="q, then v")
    low = Numbers("NY", unit="", meaning="what rounding of y has left over")
    f = Numbers("NY", unit="", meaning="time derivative of y")
    y_before = Numbers("NY", unit="", meaning="y before the last step")
    dense = Numbers("DENSE", "NY", unit="", meaning="polynomial of the last step")
    parameters = Numbers("N_PARAMETERS", unit="", meaning="of the run")
    momenta = Numbers("MOMENTA", unit="", meaning="at the start, of those that are constant")
    momentum_errors = Numbers("MOMENTA", unit="", meaning="their largest changes")
    violations = Numbers("LEVELS", "NCHECK", unit="", meaning="largest of C, C_dot, C_ddot by row")
    usual_pivots = Numbers("NCHECK", unit="", meaning="pivots at the start where drivers lead")
    sides = Numbers("N_CROSSINGS", unit="-", meaning="1 or -1, side of each function; 0: not known")
    counts = Numbers("EVENTS", unit="-", meaning="how often each event was")
    crossed = Numbers("EVENTS", unit="s", meaning="when each event passed zero last, either way")
    held = Numbers("EVENTS", unit="-", meaning="1 of an event that is thrown back to zero there")
    fired = Numbers("EVENTS", unit="-", meaning="1 of an event that is still to be told")
    lowest = Numbers("RANGED", unit="", meaning="of q, then of coordinates, at ends of steps")
    highest = Numbers("RANGED", unit="", meaning="the same; under kinematics at the start")

    def __init__(self, numbers: Array, sizes: Mapping[str, int]) -> None:
        self.numbers = numbers
        self.views = {field.name: field.view(numbers) for field in fields(sizes) if field.shape}


def _records() -> Iterator[tuple[str, StateNumber | Numbers]]:
    for name, record in vars(State).items():
        if isinstance(record, StateNumber | Numbers):
            yield name, record


for _place, (_name, _record) in enumerate(_records()):
    _record.name = _name
    if isinstance(_record, StateNumber):
        _record.place = _place  # numbers stand before arrays, so that a solver's sizes move none

#: How many numbers stand before the arrays.
SINGLE = sum(isinstance(_record, StateNumber) for _, _record in _records())
#: Levels at which constraints are checked: position, velocity, acceleration.
LEVELS = 3


def fields(sizes: Mapping[str, int]) -> tuple[Field, ...]:
    """Fields of a state, in order and without gaps.

    Parameters
    ----------
    sizes : mapping of str to int
        ``NY``, ``DENSE``, ``N_PARAMETERS``, ``MOMENTA``, ``NCHECK``, ``N_CROSSINGS``, ``EVENTS``,
        ``RANGED``.
    """
    known = {"LEVELS": LEVELS, **sizes}
    ordered: list[Field] = []
    place = 0
    for name, record in _records():
        shape = tuple(known[axis] for axis in record.shape)
        ordered.append(Field(name, place, shape, record.unit, record.meaning))
        place += math.prod(ordered[-1].room)
    return tuple(ordered)


def fields_as_data(ordered: Sequence[Field]) -> list[list[object]]:
    """Fields ready for JSON, as :func:`fields_of` reads them."""
    return [[f.name, f.place, list(f.shape), f.unit, f.meaning] for f in ordered]


def fields_of(data: Sequence[Sequence[Any]]) -> tuple[Field, ...]:
    """Fields that ``motion.json`` tells."""
    return tuple(
        Field(name, place, tuple(shape), unit, meaning)
        for name, place, shape, unit, meaning in data
    )


def size_of_state(sizes: Mapping[str, int]) -> int:
    """Size of a state: the count of its numbers."""
    last = fields(sizes)[-1]
    return last.place + math.prod(last.room)
