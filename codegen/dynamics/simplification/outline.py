"""The outline of a system's equations: which velocities bodies have, and which rows of C_q matter.

A row whose derivatives by all velocities are structurally zero is constant along every motion: it
is not solved. Kinds are traced for that with numbers where nothing moves, and nothing is composed.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.composition.bodies import GROUND, body_blocks
from kousoku.codegen.dynamics.operations.mechanics import COLUMNS, frozen
from kousoku.codegen.dynamics.recording.program import Row
from kousoku.codegen.dynamics.recording.recorder import Recorder, pattern_of
from kousoku.codegen.dynamics.recording.traces import Trace
from kousoku.codegen.dynamics.simplification.shapes import shape, sizes
from kousoku.codegen.dynamics.simplification.turned import own_columns, turned, turned_rows
from kousoku.model.mechanism import COMBINATION, GROUND_INDEX

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from kousoku.codegen.dynamics.composition.bodies import BodyBlocks
    from kousoku.codegen.dynamics.recording.recorder import Pattern
    from kousoku.model.mechanism import Coordinate, Instance, System

#: The axis across the xy-plane.
NORMAL = 2


@dataclass(frozen=True, slots=True)
class Outline:
    """Rows and columns of C_q that are not structurally zero, in the axes of the system.

    Parameters
    ----------
    shift : int, optional
        The permutation of axes that brings the plane of the motion into the xy-plane, see
        :mod:`~kousoku.codegen.dynamics.simplification.turned`; None where bodies move in space.
    columns : tuple of tuple of int
        Of each body the places in (δr, δθ′) that are velocities.
    rows : tuple of Row
        In the order in which they are composed.
    """

    shift: int | None
    columns: tuple[tuple[int, ...], ...]
    rows: tuple[Row, ...]

    @property
    def is_planar(self) -> bool:
        """Whether bodies move in parallel coordinate planes."""
        return self.shift is not None

    @property
    def normal(self) -> int | None:
        """The axis across the plane."""
        return None if self.shift is None else (NORMAL + self.shift) % 3

    @property
    def velocities(self) -> int:
        """Count of columns."""
        return sum(map(len, self.columns))

    def columns_of(self, bodies: Iterable[int]) -> list[int]:
        """Return the columns of some bodies; six in turn belong to each body of the system."""
        return [COLUMNS * body + k for body in bodies for k in self.columns[body]]


def outline_of(system: System, shift: int | None) -> Outline:
    """Return the outline of a system that moves in a plane, or in space.

    Parameters
    ----------
    system : System
        A scene, as it starts.
    shift : int, optional
        Its plane, as :func:`~kousoku.codegen.dynamics.simplification.planar.plane_of` finds it;
        None for equations in space.
    """
    is_planar = shift is not None
    there = turned(system, shift or 0)
    live = live_rows(there, is_planar=is_planar)
    rows = tuple(
        Row(one.joint, place, row)
        for place, (one, own) in enumerate(zip(system.constraints, live, strict=True))
        for row in own
    )
    shapes = (shape(body, is_planar=is_planar) for body in system.bodies)
    return Outline(
        shift=shift,
        columns=tuple(own_columns(columns, shift or 0) for _, columns in shapes),
        rows=turned_rows(rows, there, -(shift or 0)),
    )


def live_rows(system: System, *, is_planar: bool) -> Iterator[tuple[int, ...]]:
    """Yield for each constraint the rows whose Jacobian is not structurally zero.

    Parameters
    ----------
    system : System
        A scene.
    is_planar : bool
        Whether its bodies move in planes parallel to the xy-plane.
    """
    recorder = Recorder()
    q, v = (recorder.region("", size) for size in sizes(system, is_planar=is_planar))
    bodies = body_blocks(system, recorder, q, v, is_planar=is_planar)

    def body(index: int) -> BodyBlocks:
        return GROUND if index == GROUND_INDEX else bodies[index]

    for one in system.constraints:
        if one.kind != COMBINATION:
            yield _live(one, recorder, body)
        else:
            terms = (system.coordinates[term.coordinate] for term in one.terms)
            yield (0,) if any(_live(term, recorder, body) for term in terms) else ()


def _live(
    one: Instance | Coordinate, recorder: Recorder, body: Callable[[int], BodyBlocks]
) -> tuple[int, ...]:
    i, j = body(one.i), body(one.j)
    constants = [recorder.constant(values) for _, values in one.constants]
    pattern, _, _, lengths = pattern_of((i.r, i.p, j.r, j.p, *constants))
    columns = (*i.columns, *(COLUMNS + k for k in j.columns))
    names = tuple(name for name, _ in one.constants)
    return _live_rows(one.kind, names, pattern, tuple(lengths), columns)


@cache
def _live_rows(
    kind: str,
    names: tuple[str, ...],
    pattern: Pattern,
    lengths: tuple[int, ...],
    columns: tuple[int, ...],
) -> tuple[int, ...]:
    trace = Trace(lengths)
    nodes = [trace.matrix(*block).flat for block in pattern]
    inputs = dict(zip(("r_i", "p_i", "r_j", "p_j", *names), nodes, strict=True))
    jacobian = trace.inline(frozen(kind, "constraint"), inputs)["C_q"]
    width = 2 * COLUMNS
    return tuple(
        row
        for row in range(len(jacobian) // width)
        if any(trace.graph.value(jacobian[row * width + k]) != 0 for k in columns)
    )
