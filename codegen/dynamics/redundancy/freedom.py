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
from kousoku.codegen.dynamics.assembly.residuals import Residuals, places_of
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

    from kousoku.codegen.dynamics.recording.program import ConstraintEquation
    from kousoku.codegen.dynamics.redundancy.branch import BranchPosition
    from kousoku.codegen.dynamics.redundancy.closure import Closed
    from kousoku.codegen.dynamics.redundancy.loops import LoopPart
    from kousoku.codegen.dynamics.redundancy.rank import LQFactors
    from kousoku.codegen.dynamics.redundancy.undetermined import Undetermined
    from kousoku.codegen.dynamics.simplification.outline import Outline
    from kousoku.model.mechanics.multibody import System

#: Rows of the largest part whose dependent rows are looked for; the time grows with their cube.
MOST_SEARCHED_ROWS = 700
#: Positions that are looked at, where they are cheap, and rows times positions where not.
MOST_POSITIONS, ROWS_AND_POSITIONS = 24, 6000
#: From so many lengths of the system on its bodies are far from the origin of frame O: coordinates
#: have lost four of the digits that tell dependent rows.
FAR_FROM_ORIGIN = 1e4


@dataclass(frozen=True, slots=True)
class DependentSet:
    """Rows that depend on each other.

    Parameters
    ----------
    joints : tuple of str
        Whose rows take part: what these joints carry is not determined, where they are several.
    rows : int
        How many rows take part.
    dimension : int
        How many of them can be left out.
    is_everywhere : bool
        Whether they depend on each other along the branch, or only at the start.
    """

    joints: tuple[str, ...]
    rows: int
    dimension: int
    is_everywhere: bool


@dataclass(frozen=True, slots=True)
class Freedom:
    """Freedoms that the rows of a system leave.

    Parameters
    ----------
    columns, rows : int
        Velocities, and rows that are not structurally zero.
    rank : int
        Of C_q along the branch.
    dependent : tuple of DependentSet
        Those along the branch, then those at the start only.
    dropped : tuple of ConstraintEquation
        Rows that depend on the others and are left out.
    worst : float
        How well the remaining rows keep their rank at the worst position: 1 is best.
    positions : int
        How many positions were looked at in the part with the fewest; 0 without a loop.
    unknown : tuple of str
        Joints of parts that have too many rows and may have some that depend on others: nothing is
        known of them.
    drivers : int
        How many of the rows are those of drivers in loops.
    idle : tuple of ConstraintEquation
        Of the rows that are left out those that nothing changes, and those of kinds of one's own
        that others of the same joint imply: they carry nothing.
    closed : tuple of Closed
        Of the rows that are left out those that others imply but for less than the closure
        tolerance, and not to rounding.
    undetermined : tuple of (str, tuple of str)
        Of joints whose rows depend on each other the components of force and torque, ``"fx"`` to
        ``"mz"``, that are not unique.
    """

    columns: int
    rows: int
    rank: int
    dependent: tuple[DependentSet, ...] = ()
    dropped: tuple[ConstraintEquation, ...] = ()
    worst: float = 1.0
    positions: int = 0
    unknown: tuple[str, ...] = ()
    drivers: int = 0
    idle: tuple[ConstraintEquation, ...] = ()
    closed: tuple[Closed, ...] = ()
    undetermined: Undetermined = ()

    @classmethod
    def of(cls, outline: Outline) -> Freedom:
        """Freedom that rows leave of which none depends on others."""
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
        sets = (one.joints for one in self.dependent if one.is_everywhere)
        return tuple(joints for joints in sets if len(joints) > 1)


class _PartFreedom(NamedTuple):
    """Findings about a part, and where it was looked at."""

    branch: Branch
    positions: list[BranchPosition]
    drivers: Drivers
    freedom: Freedom


def freedom_of(system: System, outline: Outline) -> Freedom:
    """Degrees of freedom and dependent rows of a system.

    Parameters
    ----------
    system : System
        An assembled scene.
    outline : Outline
        Its rows and columns.
    """
    system = near_origin(system)
    total = Freedom.of(outline)
    by_instance: dict[int, list[ConstraintEquation]] = {}
    for row in outline.rows:
        by_instance.setdefault(row.instance, []).append(row)
    for part in loops_of(system):
        rows = [row for place in part.instances for row in by_instance.get(place, ())]
        if len(rows) > MOST_SEARCHED_ROWS:
            if not _is_independent(system, outline, part, rows):
                total = replace(total, unknown=(*total.unknown, *_joints(rows)))
            continue
        found = _freedom_of_part(system, outline, part, rows)
        total = replace(
            total,
            rank=total.rank - (found.rows - found.rank),
            dependent=total.dependent + found.dependent,
            dropped=total.dropped + found.dropped,
            worst=min(total.worst, found.worst),
            positions=min(total.positions or found.positions, found.positions),
            drivers=total.drivers + found.drivers,
            idle=total.idle + found.idle,
            closed=total.closed + found.closed,
            undetermined=total.undetermined + found.undetermined,
        )
    return total


def near_origin(system: System) -> System:
    """System with the origin of frame O among its bodies, if that lies far from them.

    Freedoms do not depend on where that is, but coordinates of a million lengths have lost the
    digits that tell which rows depend on others.
    """
    origin = system.bodies[0].r if system.bodies else (0.0, 0.0, 0.0)
    is_far = max(map(abs, origin)) > FAR_FROM_ORIGIN * Metric(system).size
    return seen_from(system, origin) if is_far else system


def _freedom_of_part(
    system: System, outline: Outline, part: LoopPart, rows: Sequence[ConstraintEquation]
) -> Freedom:
    residuals, first = part_residuals(system, part)
    joints, driven = _sorted(system, rows)
    chosen = [first[row.instance] + row.row for row in joints]
    others = [(row, first[row.instance] + row.row) for row in driven]
    pairs = list(zip(joints, chosen, strict=True))
    bodies = [system.bodies[k] for k in part.bodies]
    columns, length = _columns(outline, part), Metric(system).size
    count = max(2, min(MOST_POSITIONS, ROWS_AND_POSITIONS // max(1, len(rows))))
    few = min(len(joints), len(columns))

    def sampled_positions(branch: Branch) -> tuple[list[BranchPosition], Drivers]:
        drivers = Drivers(system, branch, pairs, others)
        positions: list[BranchPosition] = []
        for position in branch.positions(bodies):
            positions.append(position)
            are_free = drivers.look(position)
            depends = position.clear < len(joints)
            if len(positions) == count or (are_free and not depends):
                break
        return positions, drivers

    def exact_freedom() -> _PartFreedom:
        branch = Branch(residuals, chosen, columns, length)
        positions, drivers = sampled_positions(branch)
        is_stuck = len(positions) == 1 and positions[0].factors.rank < few
        found = _shaky(joints, positions[0], few) if is_stuck else _dependences(joints, positions)
        return _PartFreedom(branch, positions, drivers, found)

    def freedom_within_tolerance() -> _PartFreedom | None:
        positions, drivers = sampled_positions(near)
        positions = far_from_singular(positions)
        require_gap(system, near, joints, positions)
        if not near.is_redundant(positions, few):
            return None
        if not starts_closed(system, near, joints, positions[0]):
            return None
        found = _dependences(joints, positions, CLEARLY * system.closure_tolerance)
        closed = closed_rows(near, joints, found.dropped, positions)
        return (
            _PartFreedom(near, positions, drivers, replace(found, closed=closed))
            if closed
            else None
        )

    near = near_branch(residuals, chosen, columns, bodies=bodies, system=system)
    made = freedom_within_tolerance() if is_near(near, bodies) else None
    if made is None:
        made = exact_freedom()
        if made.positions[0].factors.rank < made.freedom.rank:
            # beside the start rows may depend on each other nearly
            made = freedom_within_tolerance() or made
    branch, positions, drivers, found = made
    takes_part = CLEARLY * system.closure_tolerance if found.closed else TAKES_PART
    drivers.require_free()
    if found.not_unique:
        regular = [one for one in positions if one.factors.rank == found.rank]
        joined = found.not_unique
        own = undetermined(
            system, part, branch, joints, regular, joints=joined, takes_part=takes_part
        )
        found = replace(found, undetermined=own)
    return replace(found, rows=len(rows), rank=found.rank + len(driven), drivers=len(driven))


def _is_independent(
    system: System, outline: Outline, part: LoopPart, rows: Sequence[ConstraintEquation]
) -> bool:
    """Whether sparse factors show that no row depends on others at the start.

    Then none does along the branch, but at some of its positions.
    """
    residuals, first = part_residuals(system, part)
    scales = Scales.of_length(residuals, Metric(system).size)
    bodies = [system.bodies[k] for k in part.bodies]
    _, at, columns, values = residuals.elements(*places_of(bodies))
    is_row, is_column = np.zeros(residuals.rows, bool), np.zeros(residuals.columns, bool)
    is_row[[first[row.instance] + row.row for row in rows]] = True
    is_column[_columns(outline, part)] = True
    there = is_row[at] & is_column[columns]
    at, columns, values = at[there], columns[there], values[there]
    values = values * scales.rows[at] * scales.columns[columns]
    left_out = np.flatnonzero(~is_row).tolist()
    return BlockFactors(Pattern(residuals), (at, columns, values), left_out=left_out).is_regular


def _sorted(
    system: System, rows: Sequence[ConstraintEquation]
) -> tuple[list[ConstraintEquation], list[ConstraintEquation]]:
    """Rows that hold at all times and those of drivers.

    A point is driven in three directions. Where one of them stays, as in a plane, nothing moves in
    it: such a row may repeat what joints hold.
    """
    instances = [system.constraints[row.instance] for row in rows]
    parts = Counter((one.joint, one.is_driver) for one in instances)
    names = [name for name, _ in system.parameters]
    drives = [
        one.is_driver and not (parts[one.joint, True] > 1 and isfinite(fixed_law(one, names)))
        for one in instances
    ]
    joints = [row for row, is_driven in zip(rows, drives, strict=True) if not is_driven]
    return joints, [row for row, is_driven in zip(rows, drives, strict=True) if is_driven]


def _dependences(
    rows: Sequence[ConstraintEquation],
    positions: Sequence[BranchPosition],
    takes_part: float = TAKES_PART,
) -> Freedom:
    """Dependences of the rows of joints after all positions were looked at."""
    rank = max(position.factors.rank for position in positions)
    regular = [position for position in positions if position.factors.rank == rank]
    dependences = [position.factors.dependences() for position in regular]
    left, worst = rows_to_leave(dependences)
    everywhere = _components([position.factors for position in regular], takes_part)
    alone = [places[0] for places, _ in everywhere if len(places) == 1]
    everywhere = [(places, count) for places, count in everywhere if len(places) > 1]
    sets = [_set(rows, places, count, is_everywhere=True) for places, count in everywhere]
    if positions[0].factors.rank < rank:
        for places, count in _components([positions[0].factors], takes_part):
            more = count - sum(n for other, n in everywhere if set(other) <= set(places))
            if more > 0:
                sets.append(_set(rows, places, more, is_everywhere=False))
    return Freedom(
        columns=0,
        rows=len(rows),
        rank=rank,
        dependent=tuple(sets),
        dropped=tuple(rows[place] for place in left),
        idle=tuple(rows[place] for place in alone),
        worst=worst,
        positions=len(positions),
    )


def _shaky(rows: Sequence[ConstraintEquation], position: BranchPosition, rank: int) -> Freedom:
    """Freedom of a shaky linkage: infinitesimally mobile, but finitely rigid.

    Rows that depend on each other there hold what the others do not, as those of two bars that are
    stretched between two points do: none can be left out.
    """
    sets = [
        _set(rows, places, count, is_everywhere=False)
        for places, count in _components([position.factors], TAKES_PART)
    ]
    return Freedom(0, len(rows), rank, tuple(sets), positions=1)


def part_residuals(system: System, part: LoopPart) -> tuple[Residuals, Mapping[int, int]]:
    """Rows of a part between its own bodies, and the first row of each instance."""
    place = {body: k for k, body in enumerate(part.bodies)} | {GROUND_INDEX: GROUND_INDEX}
    instances = [system.constraints[k] for k in part.instances]
    terms = dict.fromkeys(term.coordinate for one in instances for term in one.terms)
    term_of = {coordinate: k for k, coordinate in enumerate(terms)}
    own = [
        replace(
            one,
            i=place[one.i],
            j=place[one.j],
            terms=tuple(replace(x, coordinate=term_of[x.coordinate]) for x in one.terms),
        )
        for one in instances
    ]
    measured = [system.coordinates[k] for k in terms]
    coordinates = [replace(one, i=place[one.i], j=place[one.j]) for one in measured]
    bodies = [system.bodies[k] for k in part.bodies]
    residuals = Residuals(own, bodies, coordinates, system.parameters)
    return residuals, dict(zip(part.instances, residuals.first, strict=False))


def _columns(outline: Outline, part: LoopPart) -> list[int]:
    """Columns of a part; one of its bodies stays if none is the ground."""
    place = {body: k for k, body in enumerate(part.bodies)}
    free = part.bodies if part.is_grounded else part.bodies[1:]
    return [
        COLUMNS * place[column // COLUMNS] + column % COLUMNS for column in outline.columns_of(free)
    ]


def _components(
    factors: Sequence[LQFactors], takes_part: float
) -> list[tuple[tuple[int, ...], int]]:
    """Sets of rows that depend on each other at some of the positions, and dimensions.

    Rows are in one set when a row that depends on others is made of them by more than
    ``takes_part``. One that nothing changes is alone.
    """
    together = DisjointSets(range(len(factors[0].taken) + len(factors[0].left)))
    for one in factors:
        is_part = np.abs(one.combinations()) > takes_part
        for row, parts in zip(one.left, is_part, strict=True):
            for k in np.flatnonzero(parts):
                together.join(row, one.taken[int(k)])
    left = factors[0].left
    sets = [(tuple(rows), sum(row in rows for row in left)) for rows in together.sets()]
    return [(rows, count) for rows, count in sets if count]


def _set(
    rows: Sequence[ConstraintEquation],
    places: Sequence[int],
    dimension: int,
    *,
    is_everywhere: bool,
) -> DependentSet:
    joints = _joints(rows[place] for place in places)
    return DependentSet(joints, len(places), dimension, is_everywhere)


def _joints(rows: Iterable[ConstraintEquation]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(row.joint for row in rows))
