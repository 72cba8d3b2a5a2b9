"""Systems as they are composed in tests: with all rows, or without some."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.analyse import (
    ANY,
    Analysed,
    ranked,
    with_all_rows,
    with_joint_coordinates,
)
from kousoku.codegen.dynamics.redundancy.freedom import DependentSet
from kousoku.codegen.dynamics.simplification.planarity import plane_of

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from kousoku.codegen.dynamics.recording.program import RowIndex
    from kousoku.model.mechanics.multibody import System


def all_rows(system: System, *, may_be_planar: bool = True) -> Analysed:
    """System, in its plane if it has one, with all rows."""
    return with_all_rows(system, plane_of(system) if may_be_planar else None)


def independent(system: System, *, may_be_planar: bool = True) -> Analysed:
    """System without the rows that depend on others."""
    return ranked(system, plane_of(system) if may_be_planar else None)


def without(
    found: Analysed, rows: Iterable[RowIndex], joints: Sequence[str] | None = None
) -> Analysed:
    """System without some rows; forces of joints, all unless named, are not unique."""
    names = dict.fromkeys(row.joint for row in found.outline.rows) if joints is None else joints
    one = DependentSet(tuple(names), 0, 0, is_everywhere=True)
    mobility = replace(found.mobility, dropped=tuple(rows), dependent=(one,))
    return replace(found, mobility=mobility)


def jointed(system: System, most_free: int = ANY) -> Analysed:
    """System in joint coordinates, whatever these cost."""
    return with_joint_coordinates(all_rows(system), most_free)
