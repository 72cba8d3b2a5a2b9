"""Request of an analysis, and the rows of its results."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from .status import AnalysisStatus

if TYPE_CHECKING:
    from collections.abc import Sequence

    import numpy.typing as npt

    from .tables import Array, LinkageTables

#: Full Newton, and the iteration of the paper; a run holds the index.
LINKAGE_METHODS = ("newton", "paper")
#: Results of nodes and of links; a row holds them under these names.
OF_NODES = ("position", "velocity", "acceleration")
OF_LINKS = ("angle", "angle_dot", "angle_ddot")


class RecordField(NamedTuple):
    """A field of the record ``run`` of ``solver.h``.

    Parameters
    ----------
    type, name : str
        As C declares it; a pointer ends in an asterisk.
    meaning : str
        What it is.
    is_by_input : bool
        Whether it has a number for each input.
    is_length : bool
        Whether it is in the unit of the mechanism.
    """

    type: str
    name: str
    meaning: str
    is_by_input: bool = False
    is_length: bool = False

    @property
    def is_pointer(self) -> bool:
        """Whether it points at rows, or at nothing."""
        return self.type.endswith("*")

    def declared(self, inputs: int) -> str:
        """Declaration of the field, given how many inputs there are."""
        room = f"[{inputs}]" if self.is_by_input else ""
        return f"{self.type}{' ' * (not self.is_pointer)}{self.name}{room}"


#: The record ``run``, which the header states and the compiled solver is called with: what is
#: asked, the fields of :class:`RunRequest`; then where it goes, and what happened, those of
#: :class:`Rows`.
RUN = (
    RecordField("int", "method", "0 full Newton, 1 the iteration of the paper"),
    RecordField("int", "max_iterations", "in one step"),
    RecordField("double", "limit", "largest residual", is_length=True),
    RecordField("long long", "divisions", "of the way of the inputs, or of their turns"),
    RecordField("long long", "start", "the walk begins where the turn of this division does"),
    RecordField("long long", "first", "division of the first row"),
    RecordField("size_t", "rows", "how many are wanted"),
    RecordField("double", "origin", "inputs at division 0", is_by_input=True),
    RecordField("double", "span", "what is added over all divisions", is_by_input=True),
    RecordField("long long", "turns", "whole turns over all divisions, or 0", is_by_input=True),
    RecordField("double", "rate", "time derivatives of the inputs, at t = 0", is_by_input=True),
    RecordField("double", "rate_dot", "second ones, constant", is_by_input=True),
    RecordField("const double *", "times", "(rows) [s], ascending from 0; NULL for divisions"),
    RecordField("double *", "alpha", "(rows, inputs), counting on over the turns"),
    RecordField(
        "double *", "position", "(rows, nodes, 2); as all results NULL where it is not wanted"
    ),
    RecordField("double *", "velocity", "(rows, nodes, 2)"),
    RecordField("double *", "acceleration", "(rows, nodes, 2)"),
    RecordField("double *", "angle", "(rows, links)"),
    RecordField("double *", "angle_dot", "(rows, links)"),
    RecordField("double *", "angle_ddot", "(rows, links)"),
    RecordField("int *", "iterations", "(rows) corrections in the step that led here"),
    RecordField("double *", "residual", "(rows)", is_length=True),
    RecordField(
        "double *",
        "condition",
        "(rows) most that residuals of 1 move nodes: large near a dead centre",
    ),
    RecordField("size_t", "done", "good rows; after a failure the next one is where it stopped"),
    RecordField("size_t", "block", "the block that failed"),
    RecordField(
        "double", "reached", "inputs at the last good position, counting on", is_by_input=True
    ),
)


@dataclass(frozen=True, slots=True)
class RunRequest:
    """Request of a run. The inputs of a division are those of ``solver.h``.

    Parameters
    ----------
    method : int
        0 full Newton, 1 the iteration of the paper.
    max_iterations : int
        In one step.
    limit : float
        Largest residual, in the unit of the mechanism.
    divisions, start, first, rows : int
        Row r is division ``first + r``; the continuation begins with the first position at the
        division where the turn of ``start`` begins.
    origin, span, rate, rate_dot : sequence of float
        Of each input, in its unit: value at division 0, what is added over all divisions, time
        derivatives at time 0.
    turns : sequence of int
        Of each input: whole turns over all divisions, 0 where ``span`` counts.
    times : (rows,) array [s], optional
        Row r is this time, ascending from 0, and the inputs follow their laws
        origin + rate t + ½ rate_dot t²; ``start`` and ``first`` are 0.
    """

    method: int
    max_iterations: int
    limit: float
    divisions: int
    rows: int
    origin: Sequence[float]
    span: Sequence[float]
    turns: Sequence[int]
    rate: Sequence[float]
    rate_dot: Sequence[float]
    start: int = 0
    first: int = 0
    times: Array | None = None

    @property
    def is_periodic(self) -> bool:
        """Whether all inputs make whole turns."""
        return all(self.turns)

    @property
    def is_possible(self) -> bool:
        """Whether counts, limit, method and inputs are such that an analysis can be made."""
        inputs = (*self.origin, *self.span, *self.rate, *self.rate_dot)
        times = np.zeros(1) if self.times is None else np.concatenate(([0.0], self.times))
        return (
            bool((np.diff(times) >= 0).all() and times[-1] < math.inf)
            and (self.times is None or self.first == 0)
            and self.divisions >= 1
            and self.rows >= 1
            and 0 <= self.start <= self.first
            and self.max_iterations >= 1
            and self.limit > 0
            and self.method in range(len(LINKAGE_METHODS))
            and all(map(math.isfinite, inputs))
        )

    def inputs_of(self, division: int) -> tuple[Array, Array]:
        """Inputs of a division, each turn from the same numbers, and one division.

        With N turns over n divisions α = origin + 2π frac(N k / n), else origin + span · k / n.

        Returns
        -------
        alpha : (inputs,) array
            The inputs, in their units.
        delta : (inputs,) array
            How far one division goes, in their units.
        """
        n = self.divisions
        alpha, delta = np.zeros(len(self.turns)), np.zeros(len(self.turns))
        for i, turns in enumerate(self.turns):
            if turns:
                part = int(math.fmod(turns * division, n))
                alpha[i] = self.origin[i] + math.tau * (part / n)
                delta[i] = math.tau * (turns / n)
            else:
                alpha[i] = self.origin[i] + self.span[i] * (division / n)
                delta[i] = self.span[i] / n
        return alpha, delta

    def laws_at(self, time: float) -> tuple[Array, Array]:
        """Inputs origin + rate t + ½ rate_dot t² (inputs,), in their units, and rates [1/s]."""
        rate, rate_dot = np.asarray(self.rate), np.asarray(self.rate_dot)
        alpha = np.asarray(self.origin) + (rate + 0.5 * rate_dot * time) * time
        return alpha, rate + rate_dot * time

    def end_of(self, now: float, time: float) -> float:
        """End [s] of a step to a time, at the latest where rate + rate_dot t of an input is 0."""
        turns = -np.asarray(self.rate) / np.asarray(self.rate_dot)  # not finite: never
        return float(np.min(turns[(now < turns) & (turns < time)], initial=time))

    def whole_turns(self, division: int) -> Array:
        """Whole turns (inputs,) [rad] by which counted inputs exceed those of a division."""
        n = self.divisions
        remainders = [math.fmod(turns * division, n) for turns in self.turns]
        pairs = zip(self.turns, remainders, strict=True)
        return np.array([math.tau * round((turns * division - r) / n) for turns, r in pairs])

    def counted_inputs(self, division: int) -> list[float]:
        """Inputs (inputs,) of a division, in their units, counting on over the turns.

        origin + 2π N k / n with N turns over n divisions, else origin + span · k / n.
        """
        part, counted = division / self.divisions, []
        for i, turns in enumerate(self.turns):
            turned = math.tau * (turns * division / self.divisions)
            counted.append(self.origin[i] + (turned if turns else self.span[i] * part))
        return counted


def request(
    scene: RunRequest,
    *,
    method: str | None = None,
    divisions: int | None = None,
    turns: int = 1,
    first_turn: int = 0,
    from_turn: int | None = None,
    limit: float | None = None,
) -> RunRequest:
    """Run over whole turns of the inputs, or once over the way that they go.

    Parameters
    ----------
    scene : RunRequest
        What the scene asks for, where nothing else is said.
    method : {"newton", "paper"}, optional
        Full Newton, or the iteration of the paper.
    divisions : int, optional
        Divisions of a turn.
    turns, first_turn : int
        How many turns to write, and the first of them.
    from_turn : int, optional
        The turn at whose start the mechanism is as in the scene, 0 when left out: turns need not
        lead back.
    limit : float, optional
        Largest residual, in the unit of the mechanism.

    Raises
    ------
    ValueError
        An argument is not one of these; or inputs that do not turn are to be turned on.
    """
    begin = 0 if from_turn is None else from_turn
    if method not in {None, *LINKAGE_METHODS}:
        raise ValueError(f"method: got {method!r}, wanted {' or '.join(LINKAGE_METHODS)}")
    if (divisions is not None and divisions < 1) or turns < 1 or not 0 <= begin <= first_turn:
        raise ValueError(
            f"got divisions={divisions}, turns={turns}, first_turn={first_turn}, "
            f"from_turn={from_turn}; wanted 1 or more divisions and turns, "
            "and 0 <= from_turn <= first_turn"
        )
    if not scene.is_periodic and (turns, first_turn) != (1, 0):
        raise ValueError("inputs that do not make whole turns go their way once: leave turns out")
    n = scene.divisions if divisions is None else divisions
    return replace(
        scene,
        method=scene.method if method is None else LINKAGE_METHODS.index(method),
        divisions=n,
        limit=scene.limit if limit is None else limit,
        start=begin * n,
        first=first_turn * n,
        rows=turns * n + 1,
    )


@dataclass(slots=True)
class Rows:
    """Results, one row for each division; after a failure row ``done`` is where it stopped.

    Parameters
    ----------
    alpha : (rows, inputs) array
        The inputs in their units, counting on over the turns.
    position, velocity, acceleration : (rows, nodes, 2) array
        Of the nodes, in frame O, in the unit of the mechanism and seconds.
    angle, angle_dot, angle_ddot : (rows, links) array
        Of the links, from +x [rad, rad/s, rad/s²], where they are wanted.
    iterations : (rows,) array of int
        Corrections in the step that led to the row.
    residual : (rows,) array
        Largest residual, in the unit of the mechanism.
    condition : (rows,) array
        The most that a residual of 1 moves a coordinate, as a length: large near a dead centre.
    reached : (inputs,) array
        The inputs at the last good position, counting on over the turns.
    done, block : int
        Good rows, and the block that failed.
    status : int
        Why it ended, a :class:`AnalysisStatus`.
    """

    alpha: Array
    position: Array
    velocity: Array
    acceleration: Array
    angle: Array
    angle_dot: Array
    angle_ddot: Array
    iterations: npt.NDArray[np.intc]
    residual: Array
    condition: Array
    reached: Array
    done: int = 0
    block: int = 0
    status: int = AnalysisStatus.GOOD


def empty_rows(mechanism: LinkageTables, count: int) -> Rows:
    """Room for as many rows."""
    inputs, links = len(mechanism.inputs), len(mechanism.links) * mechanism.wants_angles
    shapes: Any = {"alpha": (inputs,), "residual": (), "condition": ()}
    shapes |= dict.fromkeys(OF_NODES, (len(mechanism.nodes), 2)) | dict.fromkeys(OF_LINKS, (links,))
    arrays: Any = {name: np.zeros((count, *shape)) for name, shape in shapes.items()}
    return Rows(**arrays, iterations=np.zeros(count, dtype=np.intc), reached=np.zeros(inputs))
