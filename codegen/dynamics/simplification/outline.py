"""The outline of a system's equations: velocities of bodies, and rows of C_q that are not zero.

A row whose derivatives by all velocities are structurally zero is constant along every motion: it
is not solved. Kinds are traced for that, with numbers for what cannot move; nothing is composed.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.operations.body_coordinates import coordinate_counts, shape
from kousoku.codegen.dynamics.operations.mechanics import COLUMNS, frozen, inputs_of
from kousoku.codegen.dynamics.recording.program import RowIndex
from kousoku.codegen.dynamics.recording.recorder import Recorder, pattern_of
from kousoku.codegen.dynamics.recording.traces import Trace
from kousoku.codegen.dynamics.simplification.axis_permutation import (
    permuted,
    permuted_columns,
    permuted_rows,
    shift_of,
)
from kousoku.codegen.dynamics.simplification.body_blocks import GROUND, body_blocks
from kousoku.model.mechanics.multibody import GROUND_INDEX

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from kousoku.codegen.dynamics.recording.recorder import OperandPattern
    from kousoku.codegen.dynamics.simplification.axis_permutation import Plane
    from kousoku.codegen.dynamics.simplification.body_blocks import BodyBlocks
    from kousoku.model.mechanics.multibody import Instance, RelativeCoordinate, System

    Elements = tuple[tuple[bool, ...], ...]


@dataclass(frozen=True, slots=True)
class Outline:
    """Rows and columns of C_q that are not structurally zero, in the axes of the system.

    Parameters
    ----------
    plane : Plane, optional
        The plane of the motion; None where bodies move in space.
    columns : tuple of tuple of int
        Indices in (δr, δθ′) of the velocities of each body.
    rows : tuple of RowIndex
        In the order in which they are composed.
    """

    plane: Plane | None
    columns: tuple[tuple[int, ...], ...]
    rows: tuple[RowIndex, ...]

    @property
    def is_planar(self) -> bool:
        """Whether bodies move in parallel coordinate planes."""
        return self.plane is not None

    @property
    def normal(self) -> int | None:
        """The axis normal to the plane."""
        return None if self.plane is None else self.plane.normal

    @property
    def velocities(self) -> int:
        """Count of columns."""
        return sum(map(len, self.columns))

    def columns_of(self, bodies: Iterable[int]) -> list[int]:
        """Columns of some bodies in C_q; each body of the system has six."""
        return [COLUMNS * body + k for body in bodies for k in self.columns[body]]


def outline_of(system: System, plane: Plane | None) -> Outline:
    """Outline of a system that moves in a plane, or in space.

    Parameters
    ----------
    system : System
        A scene, as it starts.
    plane : Plane, optional
        Its plane, as :func:`~kousoku.codegen.dynamics.simplification.planarity.plane_of` finds it;
        None for equations in space.
    """
    is_planar, shift = plane is not None, shift_of(plane)
    turned = permuted(system, shift)
    live = live_rows(turned, is_planar=is_planar)
    pairs = enumerate(zip(system.constraints, live, strict=True))
    rows = tuple(
        RowIndex(instance.joint, index, row)
        for index, (instance, of_instance) in pairs
        for row in of_instance
    )
    shapes = (shape(body, is_planar=is_planar) for body in system.bodies)
    return Outline(
        plane=plane,
        columns=tuple(permuted_columns(columns, -shift) for _, columns in shapes),
        rows=permuted_rows(rows, turned, -shift),
    )


def live_rows(system: System, *, is_planar: bool) -> Iterator[tuple[int, ...]]:
    """Rows of each constraint whose Jacobian is not structurally zero.

    Parameters
    ----------
    system : System
        A scene.
    is_planar : bool
        Whether its bodies move in planes parallel to the xy-plane.
    """
    return (rows for rows, _ in live_elements(system, is_planar=is_planar))


def live_elements(system: System, *, is_planar: bool) -> Iterator[tuple[tuple[int, ...], Elements]]:
    """Rows of each constraint, and elements of the Jacobian of a kind that has one.

    Parameters are those of :func:`live_rows`.
    """
    recorder = Recorder()
    q, v = (recorder.region("", size) for size in coordinate_counts(system, is_planar=is_planar))
    bodies = body_blocks(system, recorder, q, v, is_planar=is_planar)

    def body(index: int) -> BodyBlocks:
        return GROUND if index == GROUND_INDEX else bodies[index]

    for instance in system.constraints:
        if not instance.is_combination:
            elements = _elements(instance, recorder, body)
            yield _live(instance, elements, body), elements
        else:
            terms = (system.coordinates[term.coordinate] for term in instance.terms)
            live = (_live(term, _elements(term, recorder, body), body) for term in terms)
            yield (0,) if any(live) else (), ()


def _live(
    source: Instance | RelativeCoordinate, elements: Elements, body: Callable[[int], BodyBlocks]
) -> tuple[int, ...]:
    """Rows that have elements in the columns of their bodies."""
    columns = (*body(source.i).columns, *(COLUMNS + k for k in body(source.j).columns))
    rows = enumerate(elements)
    return tuple(row for row, mask in rows if any(mask[k] for k in columns))


def _elements(
    source: Instance | RelativeCoordinate, recorder: Recorder, body: Callable[[int], BodyBlocks]
) -> Elements:
    """Mask of the elements of the Jacobian (rows, 12) that are not structurally zero."""
    i, j = body(source.i), body(source.j)
    named = inputs_of(source)
    constants = [recorder.constant(values) for _, values in named]
    pattern, _, _, lengths = pattern_of((i.r, i.p, j.r, j.p, *constants))
    return _traced(source.kind, tuple(name for name, _ in named), pattern, tuple(lengths))


@cache
def _traced(
    kind: str, names: tuple[str, ...], pattern: OperandPattern, lengths: tuple[int, ...]
) -> Elements:
    trace = Trace(lengths)
    nodes = [trace.matrix(*block).flat for block in pattern]
    inputs = dict(zip(("r_i", "p_i", "r_j", "p_j", *names), nodes, strict=True))
    jacobian = trace.inline(frozen(kind, "constraint"), inputs)["C_q"]
    width = 2 * COLUMNS
    is_nonzero = [trace.graph.value(node) != 0 for node in jacobian]
    return tuple(tuple(is_nonzero[row : row + width]) for row in range(0, len(is_nonzero), width))
