"""Rows that depend on others and are left out of the equations: they are known, and watched."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.operations.mechanics import COLUMNS
from kousoku.codegen.dynamics.recording.program import Row

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from kousoku.codegen.dynamics.composition.joints import JointBlocks
    from kousoku.model.mechanism import System


#: Rows up to which all of them are solved for at once.
MOST_DENSE = 200
#: Products of the numbers of rows that are kept and left out up to which forces of joints are
#: found by code of the scene.
MOST_UNROLLED = 2000


def take_over(kept: int, left_out: int) -> bool:
    """Return whether rows that are left out take over where those that are kept lose rank."""
    return left_out > 0 and kept + left_out <= MOST_DENSE


def shares_out(kept: int, left_out: int) -> bool:
    """Return whether forces that are not unique are found by loops, not by code of the scene.

    That code has some multiple of these operations, and compilers take minutes for a million.
    """
    return take_over(kept, left_out) and kept * left_out > MOST_UNROLLED


def others(system: System, rows: Mapping[int, Sequence[int]]) -> dict[int, Sequence[int]]:
    """Return the rows of each instance that are not kept.

    Parameters
    ----------
    system : System
        The scene.
    rows : mapping of int to sequence of int
        For instances of which not all rows are kept, the rows that are.
    """
    found: dict[int, Sequence[int]] = dict.fromkeys(range(len(system.constraints)), ())
    for place, kept in rows.items():
        # no kind has more rows than a body has columns
        found[place] = [row for row in range(COLUMNS) if row not in kept]
    return found


def rows_of(joints: Iterable[JointBlocks]) -> tuple[Row, ...]:
    """Return the rows of joints in their order."""
    return tuple(
        Row(joint.name, instance, row)
        for joint in joints
        for instance, part in zip(joint.instances, joint.parts, strict=True)
        for row in part.rows
    )
