"""Rows that depend on others and are left out of the equations: they are known, and watched."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable

    from kousoku.codegen.dynamics.recording.program import RowIndex

#: Rows up to which all of them are solved for at once: memory grows with their square, and the time
#: of a step with their cube.
MOST_ROWS_AT_ONCE = 200
#: Largest product of the counts of kept and left-out rows for which code of the scene computes the
#: forces of joints: with more, it takes longer to compile than loops lose.
MOST_UNROLLED = 2000


def take_over(kept: int, left_out: int) -> bool:
    """Whether rows that are left out take over where those that are kept lose rank."""
    return left_out > 0 and kept + left_out <= MOST_ROWS_AT_ONCE


def shares_out(kept: int, left_out: int) -> bool:
    """Whether loops compute the forces that are not unique, not code of the scene.

    That code has some multiple of these operations, and compilers take minutes for a million.
    """
    return take_over(kept, left_out) and kept * left_out > MOST_UNROLLED


def by_instance(rows: Iterable[RowIndex]) -> dict[int, list[int]]:
    """Rows by the indices of their constraints."""
    groups: dict[int, list[int]] = {}
    for row in rows:
        groups.setdefault(row.instance, []).append(row.row)
    return groups
