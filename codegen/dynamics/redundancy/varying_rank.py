"""Rows that may become dependent with other parameters than those of the scene."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.redundancy.loops import loops_of
from kousoku.codegen.dynamics.redundancy.redundant_rows import MOST_ROWS_AT_ONCE
from kousoku.model.lowering.parametric import fixed_system
from kousoku.runtime.messages import listed

if TYPE_CHECKING:
    from collections.abc import Iterator

    from kousoku.codegen.dynamics.recording.program import Program, RowIndex
    from kousoku.model.mechanics.multibody import System


def rank_rows(program: Program, system: System) -> list[tuple[str, tuple[int, int]]]:
    """Rows whose rank a run with other parameters looks at, by their joints.

    They belong to joints of loops whose points, axes, lengths or ratios depend on parameters: the
    index of each among all rows that are checked, and 1 where it is left out. Where they are too
    many none is looked at.
    """
    rows = _rows_of_varying_loops(program, system)
    return rows if len(rows) <= MOST_ROWS_AT_ONCE else []


def notes_of_rank(program: Program, system: System) -> Iterator[str]:
    """Note where rows are too many for a run with other parameters to look at them."""
    rows = _rows_of_varying_loops(program, system)
    if len(rows) > MOST_ROWS_AT_ONCE:
        names = [f"joints.{joint}" for joint in dict.fromkeys(joint for joint, _ in rows)]
        yield (
            f"with other parameters rows of {listed(names)} may become redundant,"
            f" which no run looks at: they are {len(rows)}, more than {MOST_ROWS_AT_ONCE}"
        )


def _rows_of_varying_loops(program: Program, system: System) -> list[tuple[str, tuple[int, int]]]:
    if not system.parameters:
        return []
    instances = _varying_loops(system)
    first, last = len(program.rows), len(program.rows) + len(program.left_out)
    rows: tuple[RowIndex, ...] = (*program.rows, *program.left_out, *program.satisfied)
    return [
        (row.joint, (index, int(first <= index < last)))
        for index, row in enumerate(rows)
        if row.instance in instances and not system.constraints[row.instance].is_driver
    ]


def _varying_loops(system: System) -> frozenset[int]:
    """Indices of the constraints of loops in which one depends on parameters."""
    fixed = fixed_system(system)
    pairs = zip(system.constraints, fixed.constraints, strict=True)
    varying = {
        k
        for k, (instance, of_scene) in enumerate(pairs)
        if instance != of_scene
        or any(
            system.coordinates[term.coordinate] != fixed.coordinates[term.coordinate]
            for term in instance.terms
        )
    }
    parts = (part.instances for part in loops_of(system))
    return frozenset(k for indices in parts if not varying.isdisjoint(indices) for k in indices)
