"""Motion of a linkage of nodes: the result of an analysis, division by division."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, cast

import numpy as np

from ..integrate.result import Column, Named, Result
from ..messages import missing, not_generated
from .rows import LINKAGE_METHODS, OF_LINKS, OF_NODES

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    import numpy.typing as npt

    from ..integrate.result import Ledger
    from .rows import Rows, RunRequest
    from .tables import Array, LinkageTables

#: Of a turn that leads back, the most that nodes may be off, relative to the largest length.
LARGEST_CLOSURE_GAP = 1e-6
#: Residuals that move a coordinate as often as this have lost digits worth telling.
DIGITS_LOST = 1e3
#: Tables of a node and of a link, the letters of their columns, and what follows the unit.
NODE = (("positions", "", ""), ("velocities", "v", "/s"), ("accelerations", "a", "/s²"))
LINK = (
    ("angles", "", ""),
    ("angular_velocities", "_dot", "/s"),
    ("angular_accelerations", "_ddot", "/s²"),
)
#: All tables, and the output that each comes with.
TABLES = {"inputs": "positions"} | {table: table for table, *_ in NODE}
TABLES |= {table: "angles" for table, *_ in LINK}


class Iterations(NamedTuple):
    """Iterations of an analysis, and residuals that it left: its ledger.

    Parameters
    ----------
    method, target : str
        How positions were found, and what computed.
    rows : int
        How many positions.
    least, most, total : int
        Corrections in a step, and in all.
    residual : float
        The largest residual of all rows, in the unit of lengths.
    condition : float
        By how much a residual may be magnified, the most of all rows: its decimal logarithm is how
        many digits positions lose, and velocities twice as many.
    unit : str
        That unit.
    """

    method: str
    target: str
    rows: int
    least: int
    most: int
    total: int
    residual: float
    condition: float
    unit: str

    def __str__(self) -> str:
        return (
            f"{self.method} by {self.target}: {self.rows} position{'s' * (self.rows != 1)},"
            f" {self.least} to {self.most}"
            f" iterations a step, {self.total} in all, residual at most {self.residual:.1e}"
            f" {self.unit}, condition at most {self.condition:.2g}"
        )


@dataclass(repr=False, eq=False)
class Trajectory(Result):
    """Positions of a linkage, row by row, with what was wanted beside them.

    Lengths are in the unit of the scene, angles in radians, times in seconds, vectors in frame O.
    Mappings keep the order of the scene; what was not wanted is an empty mapping.

    Parameters
    ----------
    name, unit : str
        The scene and its unit of length.
    method : {"newton", "paper"}
        How positions were found.
    divisions : int
        Divisions of a turn.
    inputs : mapping of str to (rows,) array
        The prescribed coordinates by name; angles count on over the turns.
    input_units : mapping of str to str
        Their units.
    times : (rows,) array [s] or None
        When the inputs have these values, where they change evenly.
    positions, velocities, accelerations : mapping of str to (rows, 2) array
        Of each node.
    angles, angular_velocities, angular_accelerations : mapping of str to (rows,) array
        Of each link, from +x to the direction from its first to its second node.
    iterations : (rows,) array of int
        Corrections in the step that led to each row.
    residual : (rows,) array
        Largest residual at each row.
    condition : (rows,) array
        By how much residuals may be magnified in positions: large near a dead centre.
    links : tuple of (str, str, str, float)
        Name, nodes and design length of each link.
    target : {"c", "numpy"}
        What computed.
    is_in_time : bool
        Whether the inputs were followed in time, so that it is a column.
    """

    PARTS: ClassVar = {
        "node": {
            "position": "positions",
            "velocity": "velocities",
            "acceleration": "accelerations",
        },
        "link": {
            "angle": "angles",
            "angular_velocity": "angular_velocities",
            "angular_acceleration": "angular_accelerations",
        },
    }

    name: str
    unit: str
    method: str
    divisions: int
    inputs: Mapping[str, Array]
    input_units: Mapping[str, str]
    times: Array | None
    positions: Mapping[str, Array]
    velocities: Mapping[str, Array]
    accelerations: Mapping[str, Array]
    angles: Mapping[str, Array]
    angular_velocities: Mapping[str, Array]
    angular_accelerations: Mapping[str, Array]
    iterations: npt.NDArray[np.intc]
    residual: Array
    condition: Array
    links: tuple[tuple[str, str, str, float], ...]
    target: str
    is_in_time: bool = False

    def __len__(self) -> int:
        return len(self.residual)

    @property
    def time(self) -> Array:
        """The times (rows,) [s]."""
        if self.times is None:
            raise missing(
                f"{self.name}: no time: its inputs do not change evenly and together; rows are"
                f" divisions of {', '.join(self.inputs)}"
            )
        return self.times

    def _state(self, k: int) -> tuple[Array, Array]:
        """Coordinates x and y of all nodes, and their rates."""
        q, v = (
            np.concatenate([table[node][k] for node in self.positions])
            for table in (self.positions, self.velocities)
        )
        return q, v

    @property
    def alpha(self) -> Array:
        """Input (rows,) [rad or unit of the scene], or with several inputs all (rows, inputs)."""
        columns = tuple(self.inputs.values())
        return columns[0] if len(columns) == 1 else np.stack(columns, axis=-1)

    @property
    def residual_max(self) -> float:
        """The largest residual of all rows, in the unit of the scene."""
        return float(np.max(self.residual, initial=0.0))

    def __getitem__(self, name: str) -> Array:
        """Column by its name, or the time."""
        return self.time if name == "time" else super().__getitem__(name)

    def _no_column(self, name: object) -> str:
        """Say which output has a column that is not there, or which columns there are."""
        owner, _, letter = str(name).rpartition(".")
        for table, start, _ in NODE:
            if owner in self.positions and letter in {f"{start}x", f"{start}y"}:
                return not_generated(table, table)
        return super()._no_column(name)

    @cached_property
    def places(self) -> dict[str, Column]:
        """Places of the columns: the input is called ``alpha``, several ones by their names."""
        columns = {"time": Column("time", "", None, "s")} if self.is_in_time else {}
        for name in self.inputs:
            shown = "alpha" if len(self.inputs) == 1 else name
            columns[shown] = Column("inputs", name, None, self.input_units.get(name, "-"))
        for node in self.positions:
            for table, letter, per in NODE:
                if node in getattr(self, table):
                    for k, axis in enumerate("xy"):
                        unit = f"{self.unit}{per}"
                        columns[f"{node}.{letter}{axis}"] = Column(table, node, k, unit)
        for link in self.angles:
            for table, ending, per in LINK:
                columns[f"{link}.angle{ending}"] = Column(table, link, None, f"rad{per}")
        return columns

    def _names(self, sort: str) -> list[str]:
        return [*self.positions] if sort == "node" else [link[0] for link in self.links]

    @property
    def ledger(self) -> Ledger:
        """Ledger: what it cost, and what is left of the equations."""
        steps = self.iterations
        least = int(np.min(steps[1:])) if len(steps) > 1 else 0
        counts = least, int(np.max(steps, initial=0)), int(np.sum(steps))
        sizes = self.residual_max, float(np.max(self.condition, initial=0.0))
        iterations = Iterations(self.method, self.target, len(self), *counts, *sizes, self.unit)
        return cast("Ledger", iterations)

    @property
    def turn_gaps(self) -> dict[str, float]:
        """Distances, in the unit of the scene, of nodes that are not back from a turn before."""
        n = self.divisions
        if self.is_in_time or len(self) <= n:
            return {}
        turns = [(rows[n] - rows[0]) / math.tau for rows in self.inputs.values()]
        if not all(round(x) and abs(x - round(x)) < LARGEST_CLOSURE_GAP for x in turns) or {
            *self.input_units.values()
        } != {"rad"}:
            return {}
        gaps = {node: math.dist(rows[n], rows[0]) for node, rows in self.positions.items()}
        length = max(link[-1] for link in self.links)
        return {node: gap for node, gap in gaps.items() if gap > LARGEST_CLOSURE_GAP * length}

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes for a reader: turns that do not lead back, and digits that are lost."""
        notes = []
        gaps = ", ".join(f"{node} {gap:.3g} {self.unit}" for node, gap in self.turn_gaps.items())
        if gaps:
            notes.append(f"a turn leads to another assembly: {gaps} from where it began")
        if (condition := self.ledger.condition) >= DIGITS_LOST:
            k = int(np.argmax(self.condition))
            where = ", ".join(
                f"{name} = {values[k]:.9g} {self.input_units.get(name, '')}".rstrip()
                for name, values in self.inputs.items()
            )
            notes.append(
                f"near a dead centre, at {where}, positions lose {math.log10(condition):.0f} of 16"
                " digits, and velocities and accelerations up to twice as many"
            )
        return tuple(notes)

    def main_columns(self, of: str | None = None) -> list[str]:
        """Columns of a node, or of the last one that moves and angles of links."""
        groups = [[x for x in self.places if x.startswith(f"{node}.")] for node in self.positions]
        if of is None:
            moving = [group for group in groups if self._moving(group)]
            turning = [x for x, column in self.places.items() if column.table == "angles"]
            links = [x for x in turning if self._moving([x])]
            return [*self.places][: len(self.inputs)] + (moving or groups)[-1] + links
        return [x for x in self.places if x.startswith(f"{of}.")]

    def summary(self) -> dict[str, Any]:
        """Summary for programs, ready for JSON."""
        ledger = self.ledger
        return {
            "scene": self.name,
            "unit": self.unit,
            "target": self.target,
            "method": self.method,
            "divisions": self.divisions,
            "rows": len(self),
            "iterations": {"min": ledger.least, "max": ledger.most, "total": ledger.total},
            "residual_max": self.residual_max,
            "condition_max": ledger.condition,
            "turn_gaps": dict(self.turn_gaps),
        }


def named_tables(name: str, generated: Mapping[str, tuple[Sequence[str], Array]]) -> dict[str, Any]:
    """Tables of a trajectory by name, given owners and columns of those that were generated.

    Columns are (rows, owners) or (rows, owners, 2), each in its unit.
    """
    tables = {}
    for table, output in TABLES.items():
        owners, values = generated.get(table, ((), np.empty(0)))
        label = "input" if table == "inputs" else table.replace("_", " ")
        advice = "" if owners else f"{name}: {not_generated(label, output)}"
        columns = {owner: values[:, k] for k, owner in enumerate(owners)}
        tables[table] = Named(columns, f"{name}: no {label}", advice)
    return tables


def trajectory_of(
    mechanism: LinkageTables, run: RunRequest, rows: Rows, *, name: str, target: str
) -> Trajectory:
    """Trajectory of the good rows."""
    n, wanted, generated = rows.done, ("positions", *mechanism.outputs), {}
    inputs, links = ([r.name for r in records] for records in (mechanism.inputs, mechanism.links))
    owners = (inputs, *[mechanism.nodes] * len(OF_NODES), *[links] * len(OF_LINKS))
    fields = ("alpha", *OF_NODES, *OF_LINKS)
    for (table, output), names, field in zip(TABLES.items(), owners, fields, strict=True):
        values = getattr(rows, field)[:n]
        values.flags.writeable = False  # nobody can write to what others read
        if output in wanted:
            generated[table] = names, values
    return Trajectory(
        name=name,
        unit=mechanism.unit,
        method=LINKAGE_METHODS[run.method],
        divisions=run.divisions,
        input_units={coordinate.name: coordinate.unit for coordinate in mechanism.inputs},
        times=_times(run, n) if run.times is None else run.times[:n],
        is_in_time=run.times is not None,
        iterations=rows.iterations[:n],
        residual=rows.residual[:n],
        condition=rows.condition[:n],
        links=mechanism.links,
        target=target,
        **named_tables(name, generated),
    )


def _times(run: RunRequest, count: int) -> Array | None:
    """Times at which the inputs have their values, if all change evenly and take as long."""
    spans = [
        math.tau * turns if turns else span for turns, span in zip(run.turns, run.span, strict=True)
    ]
    if any(run.rate_dot) or not all(
        span * rate > 0.0 for span, rate in zip(spans, run.rate, strict=True)
    ):
        return None
    durations = [span / rate for span, rate in zip(spans, run.rate, strict=True)]
    if max(durations) - min(durations) > 1e-12 * max(durations):
        return None
    times: Array = durations[0] * ((run.first + np.arange(count)) / run.divisions)
    return times
