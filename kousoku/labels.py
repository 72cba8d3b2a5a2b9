"""Names of the rows and columns of a scene as it is written."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

from kousoku.model.mechanics.constraints import base_and_axis, components_of
from kousoku.model.records.own_kind import is_own, kind_name

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from kousoku.codegen.dynamics.recording.program import RowIndex
    from kousoku.model.mechanics.multibody import Instance, MovingBody, System

#: Columns of a body: those of a point are the first three.
COLUMNS = ("x", "y", "z", "theta_x", "theta_y", "theta_z")


def columns_of(bodies: Sequence[MovingBody]) -> tuple[str, ...]:
    """Names of the columns of bodies."""
    return tuple(
        f"{body.name}.{component}"
        for body in bodies
        for component in COLUMNS[: 3 if body.is_point else 6]
    )


def rows_of(system: System, rows: Iterable[RowIndex]) -> Iterator[str]:
    """Labels of the rows: joint or driver, kind, component."""
    counts = Counter((constraint.joint, constraint.kind) for constraint in system.constraints)
    numbers: dict[int, int] = {}
    seen: Counter[tuple[str, str]] = Counter()
    for index, constraint in enumerate(system.constraints):
        seen[constraint.joint, constraint.kind] += 1
        numbers[index] = (
            seen[constraint.joint, constraint.kind]
            if counts[constraint.joint, constraint.kind] > 1
            else 0
        )
    for row in rows:
        constraint = system.constraints[row.instance]
        number = (
            f" {numbers[row.instance]}" if numbers[row.instance] and not constraint.terms else ""
        )
        yield f"{constraint.joint}: {_component(system, constraint, row.row)}{number}"


def _component(system: System, constraint: Instance, row: int) -> str:
    """Kind and component of a row of an instance; of a combination the coordinates in it."""
    if constraint.terms:
        return " and ".join(system.coordinates[term.coordinate].name for term in constraint.terms)
    if is_own(constraint.kind):
        return f"{kind_name(constraint.kind)} {row}"
    kind, axis = base_and_axis(constraint.kind)
    prime = "′" if axis else ""
    components = components_of(constraint.kind)
    return f"{kind} {'xyz'[components[row]]}{prime}" if components else kind


def is_turn(column: str) -> bool:
    """Whether a column is a virtual rotation."""
    return column.rpartition(".")[2] in COLUMNS[3:]
