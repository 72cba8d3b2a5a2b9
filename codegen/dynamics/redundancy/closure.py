"""Rows that others imply within the closure tolerance, and what these rows miss.

People type 0.7071 for an axis. The rows of such a loop are independent by a hair, which nobody
means: they count as redundant, as the exact ones do. The pivots of rows in C_q decide, where the
loop is assembled, all lengths compared with those of the part and turns with the arms of their
body, without masses. A pivot is the residual of a row per unit of a motion that all others allow.
Rows with pivots below the closure tolerance are redundant, above ten times that independent, and a
scene with one in between is refused.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING, NoReturn

import numpy as np

from kousoku.codegen.dynamics.assembly.pose import normalised
from kousoku.codegen.dynamics.assembly.residuals import positions_of
from kousoku.codegen.dynamics.assembly.violations import key_of
from kousoku.codegen.dynamics.elements.constraints import RelativeMotion, held_by
from kousoku.codegen.dynamics.operations.characteristic_length import characteristic_length
from kousoku.codegen.dynamics.operations.mechanics import COLUMNS, lengths_of
from kousoku.codegen.dynamics.redundancy.branch import (
    BEYOND_DOUBT,
    BRANCH_TOLERANCE,
    Branch,
    Scales,
)
from kousoku.codegen.dynamics.redundancy.rank import TAKES_PART, factorise
from kousoku.model.errors import SceneError
from kousoku.model.lowering.parametric import fixed_system
from kousoku.model.lowering.system import UNIT_NAMES
from kousoku.model.mechanics.multibody import GROUND_INDEX
from kousoku.model.numbers import precise
from kousoku.runtime.integrate.continuation import NEAR_SINGULAR
from kousoku.runtime.integrate.row_switch import FALL_BACK
from kousoku.runtime.integrate.settings import CLEARLY
from kousoku.runtime.messages import listed

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from kousoku.codegen.dynamics.assembly.residuals import Residuals
    from kousoku.codegen.dynamics.recording.program import RowIndex
    from kousoku.codegen.dynamics.redundancy.branch import BranchPosition
    from kousoku.codegen.dynamics.redundancy.freedom import Mobility
    from kousoku.codegen.dynamics.redundancy.rank import LQFactors
    from kousoku.model.mechanics.multibody import Instance, MovingBody, RelativeCoordinate, System
    from kousoku.model.numbers.real import Array

#: Pivots below it are rounding: rows have size one, and some hundred are eliminated.
ROUNDING_OF_PIVOTS = 1e-12
#: Residual at the start above which it is no rounding, a tenth of what assembly refuses, and the
#: same for each length that a scene is from the origin.
OPEN, OPEN_FAR = 1e-13, 2.0**-44
#: Angle between axes above which they are not meant to be parallel [rad]: a message would name the
#: wrong cause.
NEARLY_PARALLEL = 0.1
#: Relative margin of the closure tolerance: a residual that equals it is accepted.
ROUNDED = 1e-9


@dataclass(frozen=True, slots=True)
class NearlyRedundantRow:
    """A row that others imply within the closure tolerance, and that is left out.

    Parameters
    ----------
    row : RowIndex
        The row.
    is_length : bool
        Whether its residual is a length, or else an angle.
    pivot : float
        Its residual per unit of a motion that the other rows allow, in lengths and radians.
    missed : float [lengths of the scene, or rad]
        Its largest residual at the positions that were looked at.
    """

    row: RowIndex
    is_length: bool
    pivot: float
    missed: float


def near_branch(
    residuals: Residuals,
    rows: Sequence[int],
    columns: Sequence[int],
    *,
    bodies: Sequence[MovingBody],
    system: System,
) -> Branch:
    """Branch of a part on which rows that are nearly implied count as redundant.

    Parameters
    ----------
    residuals : Residuals
        The constraints of the part between its bodies.
    rows, columns : sequence of int
        The rows of joints, and the columns of free displacements.
    bodies : sequence of MovingBody
        Bodies of the part, at their positions.
    system : System
        The scene, which has a length and a closure tolerance.
    """
    return Branch(
        residuals,
        rows,
        columns,
        characteristic_length(system),
        scales=_scales(residuals, bodies),
        tolerance=system.closure_tolerance,
    )


def is_near(branch: Branch, bodies: Sequence[MovingBody]) -> bool:
    """Whether some rows nearly depend on each other where the bodies are, beyond rounding."""
    c, matrix = branch.start(bodies)
    pivots = factorise(matrix, ROUNDING_OF_PIVOTS).pivots
    is_small = len(pivots) > 0 and pivots.min() <= BEYOND_DOUBT * CLEARLY * branch.tolerance
    distance = max(max(map(abs, body.r)) for body in bodies) / branch.length
    return bool(is_small or np.abs(c).max(initial=0.0) > _rounding_limit(distance))


def _rounding_limit(distance: float) -> float:
    """Residual at the start that is no rounding, at a distance in lengths from the origin."""
    return min(BRANCH_TOLERANCE, max(OPEN, OPEN_FAR * distance))


def _scales(residuals: Residuals, bodies: Sequence[MovingBody]) -> Scales:
    """Scales that compare lengths with the largest arm of the part, turns with those of a body."""
    arms = [0.0] * (len(bodies) + 1)  # the ground last
    sources: list[Instance | RelativeCoordinate] = [*residuals.constraints, *residuals.coordinates]
    for source in sources:
        for end, values in lengths_of(source):
            if end:
                body = source.i if end == "i" else source.j
                arms[body] = max(arms[body], *map(abs, values))
    arms[GROUND_INDEX] = 0.0  # its points are positions, not arms
    largest = max(arms) or 1.0
    turns = np.array([largest / arm if arm else 1.0 for arm in arms])
    columns = np.repeat([largest, 1.0], COLUMNS // 2)[None, :] * np.ones((len(bodies), 1))
    columns[:, COLUMNS // 2 :] = turns[:-1, None]
    rows = np.where(residuals.in_metres, 1 / largest, 1.0)
    _, matrix = residuals.doubles(*positions_of(bodies))
    for instance, first in zip(residuals.constraints, residuals.first, strict=False):
        if instance.is_combination:  # ratios may be of any size
            size = float(((matrix[first] * columns.ravel()) ** 2).sum()) ** 0.5
            rows[first] = 1 / size if size else 1.0
        elif not residuals.in_metres[first]:
            block = slice(first, first + residuals.count(instance))
            rows[block] = 1 / max(float(turns[body]) for body in instance.bodies)
    return Scales(rows, columns.ravel())


def require_gap(
    system: System,
    branch: Branch,
    rows: Sequence[RowIndex],
    positions: Sequence[BranchPosition],
) -> None:
    """Refuse rows that are neither redundant nor independent.

    Raises
    ------
    SceneError
        The message names the joint, what it holds beyond which others, and the limits.
    """
    rank = max(position.factors.rank for position in positions)
    if rank <= max(position.clear for position in positions):
        return
    at = max(positions, key=lambda position: position.factors.rank)
    last = at.factors.taken[-1]
    others = [name for name in _joints_beside_last(at.factors, rows) if name != rows[last].joint]
    missed = branch.rate_of_last(at)
    size = f"{missed:.3g} rad" if not branch.is_length(last) else f"{missed:.3g} lengths"
    _refuse(system, rows[last], others, f"{size} for each length or radian that bodies move")


def far_from_singular(positions: Sequence[BranchPosition]) -> list[BranchPosition]:
    """Positions that are not near a singular configuration, and the start.

    Near one a freedom more is nearly open, and residuals along it say nothing of the rows.
    """
    ((rank, _),) = Counter(position.factors.rank for position in positions).most_common(1)
    last_pivots = [
        position.pivots[rank - 1] if rank <= len(position.pivots) else 0.0 for position in positions
    ]
    least = NEAR_SINGULAR**0.5 * max(last_pivots)
    later = zip(positions[1:], last_pivots[1:], strict=True)
    return [positions[0], *[position for position, pivot in later if pivot >= least]]


def starts_closed(
    system: System, branch: Branch, rows: Sequence[RowIndex], start: BranchPosition
) -> bool:
    """Whether residuals at the start of a scene are within the closure tolerance.

    Raises
    ------
    SceneError
        One is larger, and yet its row is not independent beyond doubt.
    """
    residuals, tolerance = np.abs(branch.missed(start)), system.closure_tolerance * (1 + ROUNDED)
    worst = int(np.argmax(residuals))
    size = float(residuals[worst])
    if tolerance < size <= CLEARLY * tolerance:
        others = dict.fromkeys(row.joint for row in rows if row.joint != rows[worst].joint)
        unit = f"{size * branch.length:.3g} m" if branch.is_length(worst) else f"{size:.3g} rad"
        _refuse(system, rows[worst], [*others], unit)
    return size <= tolerance


def _refuse(system: System, row: RowIndex, others: Sequence[str], size: str) -> NoReturn:
    """Refuse a row that is neither redundant nor independent."""
    tolerance, leaning = system.closure_tolerance, _leaning(system, (row.joint, *others))
    raise SceneError(
        f"holds beyond {listed([f'joints.{name}' for name in others])} no more than {size}:"
        f" closure_tolerance is {tolerance:.3g}, above which it is not redundant, and it is"
        f" independent above {CLEARLY * tolerance:.3g} only; {leaning}"
        "give points and axes with more digits, or set closure_tolerance",
        key=key_of(system.constraints[row.instance]),
    )


def _joints_beside_last(factors: LQFactors, rows: Sequence[RowIndex]) -> list[str]:
    """Joints of the rows that nearly imply the row that was taken last."""
    last = factors.rank - 1
    weights = factors.lower[last].copy()
    for k in reversed(range(last)):
        weights[k] /= factors.lower[k, k]
        weights[:k] -= weights[k] * factors.lower[k, :k]
    implying = [factors.taken[k] for k in range(last) if abs(weights[k]) > TAKES_PART]
    return list(dict.fromkeys(rows[k].joint for k in sorted(implying)))


def _leaning(system: System, joints: Sequence[str]) -> str:
    """Remark on the axis that leans most among nearly parallel ones; empty where they are not.

    That is the one at the largest angles to the others.
    """
    axes: dict[str, Array] = {}
    for instance in system.constraints:
        if instance.joint in joints and RelativeMotion.TILT in held_by(instance.kind):
            axis = np.array(dict(instance.constants)["a_i_b"])
            p = (1.0, 0.0, 0.0, 0.0) if instance.i < 0 else system.bodies[instance.i].p
            in_o = precise.rotate(normalised(p), precise.triple(axis.tolist()))
            axes.setdefault(instance.joint, np.array([float(x) for x in in_o]))
    if len(axes) < 2:
        return ""
    angles = {
        name: [_angle_between(axis, other) for key, other in axes.items() if key != name]
        for name, axis in axes.items()
    }
    if not BRANCH_TOLERANCE < max(map(max, angles.values())) <= NEARLY_PARALLEL:
        return ""
    if len(axes) == 2:
        both = " and ".join(f"joints.{name}" for name in axes)
        return f"the axes of {both} are {max(map(max, angles.values())):.3g} rad apart; "
    name = max(angles, key=lambda joint: sum(angles[joint]))
    return f"the axis of joints.{name} leans by {max(angles[name]):.3g} rad; "


def _angle_between(a: Array, b: Array) -> float:
    """Angle between two lines."""
    return float(np.arctan2(np.linalg.norm(np.cross(a, b)), abs(a @ b)))


def closed_rows(
    branch: Branch,
    rows: Sequence[RowIndex],
    dropped: Sequence[RowIndex],
    positions: Sequence[BranchPosition],
) -> tuple[NearlyRedundantRow, ...]:
    """Rows that are left out and that others do not imply to rounding.

    With yᵀ C_q = 0 small displacements keep yᵀ C: where all other rows are met, the residuals of
    the rows left out make it up alone.
    """
    indices = [rows.index(row) for row in dropped]
    rank = max(position.factors.rank for position in positions)
    regular = [position for position in positions if position.factors.rank == rank]
    regular = [position for position in regular if _stay_left_out(position, indices)] or regular
    pivots = branch.remainders(regular[0], indices).tolist()
    limit = BRANCH_TOLERANCE  # of positions that were searched for
    if regular[0] is positions[0]:
        limit = _rounding_limit(float(np.abs(positions[0].r).max()))
    is_open = np.abs(_missed_alone(branch, regular[0], indices)) > limit
    missed = np.zeros(len(dropped))
    for position in regular:
        missed = np.maximum(missed, np.abs(_missed_alone(branch, position, indices)))
    is_length = [branch.is_length(k) for k in indices]
    candidates = zip(dropped, is_length, pivots, missed.tolist(), strict=True)
    closed = (NearlyRedundantRow(*candidate) for candidate in candidates)
    return tuple(
        row
        for row, starts_open in zip(closed, is_open.tolist(), strict=True)
        if row.pivot > ROUNDING_OF_PIVOTS or row.missed > BRANCH_TOLERANCE or starts_open
    )


def _missed_alone(branch: Branch, position: BranchPosition, indices: Sequence[int]) -> Array:
    """Residuals of some rows where all others hold, in lengths of the scene and radians."""
    y = position.factors.dependences()
    residuals = factorise(y[:, list(indices)]).least_change((y * position.c).sum(axis=1))
    return branch.in_units(residuals, indices)


def _stay_left_out(position: BranchPosition, indices: Sequence[int]) -> bool:
    """Whether rows, by their indices, stay left out at a position instead of taking over."""
    factors = factorise(position.factors.dependences()[:, list(indices)])
    return factors.rank == len(indices) and bool(factors.pivots.min() ** 2 > FALL_BACK)


def notes_of_freedom(system: System, mobility: Mobility) -> Iterator[str]:
    """Notes on rows that were taken as redundant, and on scenes in which nothing moves."""
    fixed = fixed_system(system)
    # with other parameters residuals may be larger, and what is rigid here may move
    depends = fixed.constraints != system.constraints or system.written_starts
    condition = ", with the parameters of the scene" if depends else ""
    worst: dict[tuple[str, bool], float] = {}
    for closed in mobility.closed:
        key = (key_of(system.constraints[closed.row.instance]), closed.is_length)
        worst[key] = max(worst.get(key, 0.0), closed.missed)
    if max(worst.values(), default=0.0) > BRANCH_TOLERANCE:
        size, unit = (
            characteristic_length(fixed) / system.unit,
            UNIT_NAMES[system.unit],
        )
        texts = [
            f"{key} but for {x * size:.3g} {unit}" if is_length else f"{key} but for {x:.3g} rad"
            for (key, is_length), x in sorted(worst.items(), key=lambda item: -item[1])
        ]
        yield (
            f"redundant within closure_tolerance, {system.closure_tolerance:g}: other joints imply"
            f" rows of {listed(texts)}{condition}; they are left out, and miss so much"
            " along the motion"
        )
    if not mobility.degrees and not any(instance.is_driver for instance in system.constraints):
        yield f"nothing can move: joints hold all bodies where they are{condition}"
