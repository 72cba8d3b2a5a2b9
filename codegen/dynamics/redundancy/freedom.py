"""Degrees of freedom of a scene, the rows that depend on others, and which can be left out.

Only joints that loops connect can depend on each other. For each such part the rank of C_q is
taken at the start and at positions along the branch that the part is assembled on, because rows
may depend on each other only there (Bricard's linkage), or only at some of its positions (a
parallelogram that lies flat). The rows that are left out can be left out at all of them.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace
from math import isfinite
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from kousoku.codegen.dynamics.assembly.block_factors import BlockFactors, Pattern
from kousoku.codegen.dynamics.assembly.driver_laws import fixed_law
from kousoku.codegen.dynamics.assembly.minimum_norm import Metric
from kousoku.codegen.dynamics.assembly.near_origin import seen_from
from kousoku.codegen.dynamics.assembly.residuals import Residuals, positions_of
from kousoku.codegen.dynamics.disjoint_sets import DisjointSets
from kousoku.codegen.dynamics.operations.mechanics import COLUMNS
from kousoku.codegen.dynamics.redundancy.branch import Branch, Scales
from kousoku.codegen.dynamics.redundancy.closure import (
    closed_rows,
    far_from_singular,
    is_near,
    near_branch,
    require_gap,
    starts_closed,
)
from kousoku.codegen.dynamics.redundancy.driven import Drivers
from kousoku.codegen.dynamics.redundancy.loops import loops_of
from kousoku.codegen.dynamics.redundancy.rank import TAKES_PART, rows_to_leave
from kousoku.codegen.dynamics.redundancy.undetermined import undetermined
from kousoku.model.mechanics.multibody import GROUND_INDEX
from kousoku.runtime.integrate.settings import CLEARLY

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from kousoku.codegen.dynamics.recording.program import RowIndex
    from kousoku.codegen.dynamics.redundancy.branch import BranchPosition
    from kousoku.codegen.dynamics.redundancy.closure import NearlyRedundantRow
    from kousoku.codegen.dynamics.redundancy.loops import LoopPart
    from kousoku.codegen.dynamics.redundancy.rank import LQFactors
    from kousoku.codegen.dynamics.redundancy.undetermined import Undetermined
    from kousoku.codegen.dynamics.simplification.outline import Outline
    from kousoku.model.mechanics.multibody import System

#: Rows of the largest part whose dependent rows are looked for; the time grows with their cube.
MOST_SEARCHED_ROWS = 700
#: Positions that are looked at, where they are cheap, and rows times positions where not.
MOST_POSITIONS, ROWS_AND_POSITIONS = 24, 6000
#: Distance of bodies from the origin of frame O, in lengths of the system, that is far: coordinates
#: have lost four of the digits that tell dependent rows.
FAR_FROM_ORIGIN = 1e4


@dataclass(frozen=True, slots=True)
class DependentSet:
    """Rows that depend on each other.

    Parameters
    ----------
    joints : tuple of str
        Joints whose rows take part: where they are several, their reactions are not unique.
    rows : int
        Count of rows that take part.
    dimension : int
        Count of those that can be left out.
    is_everywhere : bool
        Whether they depend on each other along the branch, or only at the start.
    """

    joints: tuple[str, ...]
    rows: int
    dimension: int
    is_everywhere: bool


@dataclass(frozen=True, slots=True)
class Mobility:
    """Freedoms that the rows of a system leave.

    Parameters
    ----------
    columns, rows : int
        Velocities, and rows that are not structurally zero.
    rank : int
        Of C_q along the branch.
    dependent : tuple of DependentSet
        Sets that depend along the branch, then those that do at the start only.
    dropped : tuple of RowIndex
        Rows that depend on the others and are left out.
    worst : float
        Smallest pivot of the rows left out, over the positions: 1 is best, at 0 the remaining rows
        lose rank.
    positions : int
        Count of positions that were looked at in the part with the fewest; 0 without a loop.
    unknown : tuple of str
        Joints of parts with too many rows, whose dependences are not looked for.
    drivers : int
        Count of rows of drivers in loops.
    idle : tuple of RowIndex
        Rows left out that carry nothing: no motion changes them, or rows of the same joint, of a
        kind of one's own, imply them.
    closed : tuple of NearlyRedundantRow
        Rows left out that others imply within the closure tolerance, but not to rounding.
    undetermined : tuple of (str, tuple of str)
        Components of force and torque, ``"fx"`` to ``"mz"``, that are not unique, of joints whose
        rows depend on each other.
    """

    columns: int
    rows: int
    rank: int
    dependent: tuple[DependentSet, ...] = ()
    dropped: tuple[RowIndex, ...] = ()
    worst: float = 1.0
    positions: int = 0
    unknown: tuple[str, ...] = ()
    drivers: int = 0
    idle: tuple[RowIndex, ...] = ()
    closed: tuple[NearlyRedundantRow, ...] = ()
    undetermined: Undetermined = ()

    @classmethod
    def of(cls, outline: Outline) -> Mobility:
        """Mobility of a system whose rows are all independent."""
        count = len(outline.rows)
        return cls(outline.velocities, count, count)

    @property
    def degrees(self) -> int:
        """Degrees of freedom."""
        return self.columns - self.rank

    @property
    def not_unique(self) -> tuple[str, ...]:
        """Joints whose reactions are not unique.

        Multipliers of rows of one joint that cancel each other do so in its force and torque, too.
        """
        return tuple(dict.fromkeys(joint for joints in self.shared for joint in joints))

    @property
    def shared(self) -> tuple[tuple[str, ...], ...]:
        """The joints of each set of rows that depend on each other along the branch."""
        joint_sets = (group.joints for group in self.dependent if group.is_everywhere)
        return tuple(names for names in joint_sets if len(names) > 1)


class _PartMobility(NamedTuple):
    """Mobility of a part, and the positions at which it was looked at."""

    branch: Branch
    positions: list[BranchPosition]
    drivers: Drivers
    freedom: Mobility


def mobility_of(system: System, outline: Outline) -> Mobility:
    """Degrees of freedom and dependent rows of a system.

    Parameters
    ----------
    system : System
        An assembled scene.
    outline : Outline
        Its rows and columns.
    """
    system = near_origin(system)
    total = Mobility.of(outline)
    by_instance: dict[int, list[RowIndex]] = {}
    for row in outline.rows:
        by_instance.setdefault(row.instance, []).append(row)
    for part in loops_of(system):
        rows = [row for index in part.instances for row in by_instance.get(index, ())]
        if len(rows) > MOST_SEARCHED_ROWS:
            if not _is_independent(system, outline, part, rows):
                total = replace(total, unknown=(*total.unknown, *_joints(rows)))
            continue
        of_part = _freedom_of_part(system, outline, part, rows)
        total = replace(
            total,
            rank=total.rank - (of_part.rows - of_part.rank),
            dependent=total.dependent + of_part.dependent,
            dropped=total.dropped + of_part.dropped,
            worst=min(total.worst, of_part.worst),
            positions=min(total.positions or of_part.positions, of_part.positions),
            drivers=total.drivers + of_part.drivers,
            idle=total.idle + of_part.idle,
            closed=total.closed + of_part.closed,
            undetermined=total.undetermined + of_part.undetermined,
        )
    return total


def near_origin(system: System) -> System:
    """System with the origin of frame O among its bodies, if that lies far from them.

    Freedoms do not depend on the origin, but coordinates of a million lengths have lost the digits
    that tell which rows depend on others.
    """
    origin = system.bodies[0].r if system.bodies else (0.0, 0.0, 0.0)
    is_far = max(map(abs, origin)) > FAR_FROM_ORIGIN * Metric(system).size
    return seen_from(system, origin) if is_far else system


def _freedom_of_part(
    system: System, outline: Outline, part: LoopPart, rows: Sequence[RowIndex]
) -> Mobility:
    """Mobility that the rows of a part leave, exact or within the closure tolerance."""
    residuals, first_row = part_residuals(system, part)
    joints, driven = _joint_and_driver_rows(system, rows)
    joint_rows = [first_row[row.instance] + row.row for row in joints]
    driver_pairs = [(row, first_row[row.instance] + row.row) for row in driven]
    joint_pairs = list(zip(joints, joint_rows, strict=True))
    bodies = [system.bodies[k] for k in part.bodies]
    columns, length = _columns(outline, part), Metric(system).size
    most_positions = max(2, min(MOST_POSITIONS, ROWS_AND_POSITIONS // max(1, len(rows))))
    full_rank = min(len(joints), len(columns))

    def sampled_positions(branch: Branch) -> tuple[list[BranchPosition], Drivers]:
        drivers = Drivers(system, branch, joint_pairs, driver_pairs)
        positions: list[BranchPosition] = []
        for position in branch.positions(bodies):
            positions.append(position)
            are_free = drivers.look(position)
            depends = position.clear < len(joints)
            if len(positions) == most_positions or (are_free and not depends):
                break
        return positions, drivers

    def exact_freedom() -> _PartMobility:
        branch = Branch(residuals, joint_rows, columns, length)
        positions, drivers = sampled_positions(branch)
        is_stuck = len(positions) == 1 and positions[0].factors.rank < full_rank
        freedom = (
            _shaky(joints, positions[0], full_rank) if is_stuck else _dependences(joints, positions)
        )
        return _PartMobility(branch, positions, drivers, freedom)

    def freedom_within_tolerance() -> _PartMobility | None:
        positions, drivers = sampled_positions(near)
        positions = far_from_singular(positions)
        require_gap(system, near, joints, positions)
        if not near.is_redundant(positions, full_rank):
            return None
        if not starts_closed(system, near, joints, positions[0]):
            return None
        freedom = _dependences(joints, positions, CLEARLY * system.closure_tolerance)
        closed = closed_rows(near, joints, freedom.dropped, positions)
        return (
            _PartMobility(near, positions, drivers, replace(freedom, closed=closed))
            if closed
            else None
        )

    near = near_branch(residuals, joint_rows, columns, bodies=bodies, system=system)
    findings = freedom_within_tolerance() if is_near(near, bodies) else None
    if findings is None:
        findings = exact_freedom()
        if findings.positions[0].factors.rank < findings.freedom.rank:
            # away from the start rows may nearly depend on each other
            findings = freedom_within_tolerance() or findings
    branch, positions, drivers, freedom = findings
    takes_part = CLEARLY * system.closure_tolerance if freedom.closed else TAKES_PART
    drivers.require_free()
    if freedom.not_unique:
        regular = [position for position in positions if position.factors.rank == freedom.rank]
        components = undetermined(
            system, part, branch, joints, regular, joints=freedom.not_unique, takes_part=takes_part
        )
        freedom = replace(freedom, undetermined=components)
    return replace(freedom, rows=len(rows), rank=freedom.rank + len(driven), drivers=len(driven))


def _is_independent(
    system: System, outline: Outline, part: LoopPart, rows: Sequence[RowIndex]
) -> bool:
    """Whether sparse factors show that no row depends on others at the start.

    Then they are independent along the branch, too, but for singular positions.
    """
    residuals, first_row = part_residuals(system, part)
    scales = Scales.of_length(residuals, Metric(system).size)
    bodies = [system.bodies[k] for k in part.bodies]
    _, at, columns, values = residuals.elements(*positions_of(bodies))
    is_row, is_column = np.zeros(residuals.rows, bool), np.zeros(residuals.columns, bool)
    is_row[[first_row[row.instance] + row.row for row in rows]] = True
    is_column[_columns(outline, part)] = True
    is_kept = is_row[at] & is_column[columns]
    at, columns, values = at[is_kept], columns[is_kept], values[is_kept]
    values = values * scales.rows[at] * scales.columns[columns]
    left_out = np.flatnonzero(~is_row).tolist()
    return BlockFactors(Pattern(residuals), (at, columns, values), left_out=left_out).is_regular


def _joint_and_driver_rows(
    system: System, rows: Sequence[RowIndex]
) -> tuple[list[RowIndex], list[RowIndex]]:
    """Rows of joints, which hold at all times, and rows of drivers.

    A point is driven in three directions. A driver that is constant in one of them, as across a
    plane, holds like a joint there: that row may repeat what joints hold.
    """
    instances = [system.constraints[row.instance] for row in rows]
    counts = Counter((instance.joint, instance.is_driver) for instance in instances)
    names = [name for name, _ in system.parameters]
    drives = [
        instance.is_driver
        and not (counts[instance.joint, True] > 1 and isfinite(fixed_law(instance, names)))
        for instance in instances
    ]
    joints = [row for row, is_driven in zip(rows, drives, strict=True) if not is_driven]
    return joints, [row for row, is_driven in zip(rows, drives, strict=True) if is_driven]


def _dependences(
    rows: Sequence[RowIndex],
    positions: Sequence[BranchPosition],
    takes_part: float = TAKES_PART,
) -> Mobility:
    """Dependences of the rows of joints after all positions were looked at."""
    rank = max(position.factors.rank for position in positions)
    regular = [position for position in positions if position.factors.rank == rank]
    dependences = [position.factors.dependences() for position in regular]
    redundant, worst = rows_to_leave(dependences)
    everywhere = _components([position.factors for position in regular], takes_part)
    constant = [indices[0] for indices, _ in everywhere if len(indices) == 1]
    everywhere = [(indices, count) for indices, count in everywhere if len(indices) > 1]
    sets = [
        _dependent_set(rows, indices, count, is_everywhere=True) for indices, count in everywhere
    ]
    if positions[0].factors.rank < rank:
        for indices, count in _components([positions[0].factors], takes_part):
            added = count - sum(n for other, n in everywhere if set(other) <= set(indices))
            if added > 0:
                sets.append(_dependent_set(rows, indices, added, is_everywhere=False))
    return Mobility(
        columns=0,
        rows=len(rows),
        rank=rank,
        dependent=tuple(sets),
        dropped=tuple(rows[k] for k in redundant),
        idle=tuple(rows[k] for k in constant),
        worst=worst,
        positions=len(positions),
    )


def _shaky(rows: Sequence[RowIndex], position: BranchPosition, rank: int) -> Mobility:
    """Mobility of a shaky linkage: infinitesimally mobile, but finitely rigid.

    Rows that depend on each other there hold what the others do not, as those of two bars that are
    stretched between two points do: none can be left out.
    """
    sets = [
        _dependent_set(rows, indices, count, is_everywhere=False)
        for indices, count in _components([position.factors], TAKES_PART)
    ]
    return Mobility(0, len(rows), rank, tuple(sets), positions=1)


def part_residuals(system: System, part: LoopPart) -> tuple[Residuals, Mapping[int, int]]:
    """Rows of a part between its own bodies, and the first row of each instance."""
    local = {body: k for k, body in enumerate(part.bodies)} | {GROUND_INDEX: GROUND_INDEX}
    instances = [system.constraints[k] for k in part.instances]
    terms = dict.fromkeys(term.coordinate for instance in instances for term in instance.terms)
    term_of = {coordinate: k for k, coordinate in enumerate(terms)}
    renumbered = [
        replace(
            instance,
            i=local[instance.i],
            j=local[instance.j],
            terms=tuple(
                replace(term, coordinate=term_of[term.coordinate]) for term in instance.terms
            ),
        )
        for instance in instances
    ]
    measured = [system.coordinates[k] for k in terms]
    coordinates = [replace(c, i=local[c.i], j=local[c.j]) for c in measured]
    bodies = [system.bodies[k] for k in part.bodies]
    residuals = Residuals(renumbered, bodies, coordinates, system.parameters)
    return residuals, dict(zip(part.instances, residuals.first, strict=False))


def _columns(outline: Outline, part: LoopPart) -> list[int]:
    """Columns of a part; one of its bodies stays if none is the ground."""
    local = {body: k for k, body in enumerate(part.bodies)}
    free = part.bodies if part.is_grounded else part.bodies[1:]
    return [
        COLUMNS * local[column // COLUMNS] + column % COLUMNS for column in outline.columns_of(free)
    ]


def _components(
    factors: Sequence[LQFactors], takes_part: float
) -> list[tuple[tuple[int, ...], int]]:
    """Sets of rows that depend on each other at some of the positions, and their dimensions.

    A dependent row is in one set with the rows of its combination whose factors are above
    ``takes_part``. A row that no motion changes is a set of its own.
    """
    connected = DisjointSets(range(len(factors[0].taken) + len(factors[0].left)))
    for lq in factors:
        is_part = np.abs(lq.combinations()) > takes_part
        for row, mask in zip(lq.left, is_part, strict=True):
            for k in np.flatnonzero(mask):
                connected.join(row, lq.taken[int(k)])
    left = factors[0].left
    sets = [(tuple(rows), sum(row in rows for row in left)) for rows in connected.sets()]
    return [(rows, count) for rows, count in sets if count]


def _dependent_set(
    rows: Sequence[RowIndex],
    indices: Sequence[int],
    dimension: int,
    *,
    is_everywhere: bool,
) -> DependentSet:
    joints = _joints(rows[k] for k in indices)
    return DependentSet(joints, len(indices), dimension, is_everywhere)


def _joints(rows: Iterable[RowIndex]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(row.joint for row in rows))
