"""Rows that others imply but for less than the closure tolerance: which, and their gaps.

People type 0.7071 for an axis. The rows of such a loop are independent by a hair, and what they
hold beyond each other is no motion that anyone means: they count as redundant, as the exact ones
do. Rows are told apart by their pivots in C_q where the loop is assembled, all lengths compared
with those of the part and turns with the arms of their body, without masses. A pivot is what a row
misses per unit of a motion that all others allow. Pivots below the closure tolerance are redundant,
above ten times that independent, and a scene with one in between is refused.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING, NoReturn

import numpy as np

from kousoku.codegen.dynamics.assembly.pose import normalised
from kousoku.codegen.dynamics.assembly.residuals import places_of
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
    from kousoku.codegen.dynamics.recording.program import ConstraintEquation
    from kousoku.codegen.dynamics.redundancy.branch import BranchPosition
    from kousoku.codegen.dynamics.redundancy.freedom import Freedom
    from kousoku.codegen.dynamics.redundancy.rank import LQFactors
    from kousoku.model.mechanics.multibody import Instance, MovingBody, RelativeCoordinate, System
    from kousoku.model.numbers.real import Array

#: Pivots below it are rounding: rows have size one, and some hundred are eliminated.
ROUNDING_OF_PIVOTS = 1e-12
#: What rows miss at the start, of which assembly refuses more than ten times as much, and the same
#: for each length that a scene is from the origin: more is no rounding.
OPEN, OPEN_FAR = 1e-13, 2.0**-44
#: Axes that lean more against each other are not meant to be parallel [rad]: a message would name
#: the wrong cause.
NEARLY_PARALLEL = 0.1
#: What counts as equal to the closure tolerance: a scene that misses as much as it says is taken.
ROUNDED = 1e-9


@dataclass(frozen=True, slots=True)
class Closed:
    """A row that others imply but for less than the closure tolerance.

    Parameters
    ----------
    row : ConstraintEquation
        Which; it is left out.
    is_length : bool
        Whether what it misses is a length, or else an angle.
    pivot : float
        What it misses per unit of a motion that the other rows allow, in lengths and radians.
    missed : float [lengths of the scene, or rad]
        The most that it misses at the positions that were looked at.
    """

    row: ConstraintEquation
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
        The rows of joints and the columns that are looked at.
    bodies : sequence of MovingBody
        Those of the part, where they are.
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
    """Whether rows may depend on each other nearly where bodies are, not to rounding."""
    c, matrix = branch.start(bodies)
    pivots = factorise(matrix, ROUNDING_OF_PIVOTS).pivots
    is_small = len(pivots) > 0 and pivots.min() <= BEYOND_DOUBT * CLEARLY * branch.tolerance
    far = max(max(map(abs, body.r)) for body in bodies) / branch.length
    return bool(is_small or np.abs(c).max(initial=0.0) > _open_from(far))


def _open_from(far: float) -> float:
    """Residual at the start that is no rounding, so many lengths from the origin."""
    return min(BRANCH_TOLERANCE, max(OPEN, OPEN_FAR * far))


def _scales(residuals: Residuals, bodies: Sequence[MovingBody]) -> Scales:
    """Scales that compare lengths with that of the part, turns with the arms of a body."""
    arms = [0.0] * (len(bodies) + 1)  # the ground last
    sources: list[Instance | RelativeCoordinate] = [*residuals.constraints, *residuals.coordinates]
    for one in sources:
        for end, values in lengths_of(one):
            if end:
                body = one.i if end == "i" else one.j
                arms[body] = max(arms[body], *map(abs, values))
    arms[GROUND_INDEX] = 0.0  # where its points are tells nothing of sizes
    largest = max(arms) or 1.0
    turns = np.array([largest / arm if arm else 1.0 for arm in arms])
    columns = np.repeat([largest, 1.0], COLUMNS // 2)[None, :] * np.ones((len(bodies), 1))
    columns[:, COLUMNS // 2 :] = turns[:-1, None]
    rows = np.where(residuals.in_metres, 1 / largest, 1.0)
    _, matrix = residuals.doubles(*places_of(bodies))
    for one, first in zip(residuals.constraints, residuals.first, strict=False):
        if one.is_combination:  # ratios may be of any size
            size = float(((matrix[first] * columns.ravel()) ** 2).sum()) ** 0.5
            rows[first] = 1 / size if size else 1.0
        elif not residuals.in_metres[first]:
            own = slice(first, first + residuals.count(one))
            rows[own] = 1 / max(float(turns[body]) for body in one.bodies)
    return Scales(rows, columns.ravel())


def require_gap(
    system: System,
    branch: Branch,
    rows: Sequence[ConstraintEquation],
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
    place = at.factors.taken[-1]
    others = [name for name in _beside(at.factors, rows) if name != rows[place].joint]
    missed = branch.rate_of_last(at)
    size = f"{missed:.3g} rad" if not branch.is_length(place) else f"{missed:.3g} lengths"
    _refuse(system, rows[place], others, f"{size} for each length or radian that bodies move")


def far_from_singular(positions: Sequence[BranchPosition]) -> list[BranchPosition]:
    """Positions that are not near a singular configuration, and the start.

    There one freedom more is nearly open, and what rows miss along it tells nothing of them.
    """
    ((rank, _),) = Counter(position.factors.rank for position in positions).most_common(1)
    last = [one.pivots[rank - 1] if rank <= len(one.pivots) else 0.0 for one in positions]
    least = NEAR_SINGULAR**0.5 * max(last)
    others = zip(positions[1:], last[1:], strict=True)
    return [positions[0], *[position for position, pivot in others if pivot >= least]]


def starts_closed(
    system: System, branch: Branch, rows: Sequence[ConstraintEquation], start: BranchPosition
) -> bool:
    """Whether rows that others imply miss no more than they may where a scene starts.

    Raises
    ------
    SceneError
        They miss more, and are not independent beyond doubt.
    """
    missed, most = np.abs(branch.missed(start)), system.closure_tolerance * (1 + ROUNDED)
    place = int(np.argmax(missed))
    size = float(missed[place])
    if most < size <= CLEARLY * most:
        others = dict.fromkeys(row.joint for row in rows if row.joint != rows[place].joint)
        unit = f"{size * branch.length:.3g} m" if branch.is_length(place) else f"{size:.3g} rad"
        _refuse(system, rows[place], [*others], unit)
    return size <= most


def _refuse(system: System, row: ConstraintEquation, others: Sequence[str], size: str) -> NoReturn:
    """Refuse a row that is neither redundant nor independent."""
    tolerance, leaning = system.closure_tolerance, _leaning(system, (row.joint, *others))
    raise SceneError(
        f"holds beyond {listed([f'joints.{name}' for name in others])} no more than {size}:"
        f" closure_tolerance is {tolerance:.3g}, above which it is not redundant, and it is"
        f" independent above {CLEARLY * tolerance:.3g} only; {leaning}"
        "give points and axes with more digits, or set closure_tolerance",
        key=key_of(system.constraints[row.instance]),
    )


def _beside(factors: LQFactors, rows: Sequence[ConstraintEquation]) -> list[str]:
    """Joints of the rows that the last row that was taken nearly depends on."""
    last = factors.rank - 1
    part = factors.lower[last].copy()
    for k in reversed(range(last)):
        part[k] /= factors.lower[k, k]
        part[:k] -= part[k] * factors.lower[k, :k]
    taking = [factors.taken[k] for k in range(last) if abs(part[k]) > TAKES_PART]
    return list(dict.fromkeys(rows[k].joint for k in sorted(taking)))


def _leaning(system: System, joints: Sequence[str]) -> str:
    """Axis of some nearly parallel ones that leans, and by how much; empty of others.

    That is the one that is furthest from the others.
    """
    axes: dict[str, Array] = {}
    for one in system.constraints:
        if one.joint in joints and RelativeMotion.TILT in held_by(one.kind):
            axis = np.array(dict(one.constants)["a_i_b"])
            p = (1.0, 0.0, 0.0, 0.0) if one.i < 0 else system.bodies[one.i].p
            seen = precise.rotate(normalised(p), precise.triple(axis.tolist()))
            axes.setdefault(one.joint, np.array([float(x) for x in seen]))
    if len(axes) < 2:
        return ""
    angles = {
        name: [_between(axis, other) for key, other in axes.items() if key != name]
        for name, axis in axes.items()
    }
    if not BRANCH_TOLERANCE < max(map(max, angles.values())) <= NEARLY_PARALLEL:
        return ""
    if len(axes) == 2:
        both = " and ".join(f"joints.{name}" for name in axes)
        return f"the axes of {both} are {max(map(max, angles.values())):.3g} rad apart; "
    name = max(angles, key=lambda joint: sum(angles[joint]))
    return f"the axis of joints.{name} leans by {max(angles[name]):.3g} rad; "


def _between(a: Array, b: Array) -> float:
    """Angle between two lines."""
    return float(np.arctan2(np.linalg.norm(np.cross(a, b)), abs(a @ b)))


def closed_rows(
    branch: Branch,
    rows: Sequence[ConstraintEquation],
    left: Sequence[ConstraintEquation],
    positions: Sequence[BranchPosition],
) -> tuple[Closed, ...]:
    """Rows that are left out and that others do not imply to rounding.

    With yᵀ C_q = 0 what all rows miss at a position comes to the rows that are left out where the
    others hold: yᵀ C stays.
    """
    places = [rows.index(row) for row in left]
    rank = max(position.factors.rank for position in positions)
    regular = [position for position in positions if position.factors.rank == rank]
    regular = [position for position in regular if _is_good(position, places)] or regular
    pivots = branch.left_over(regular[0], places).tolist()
    limit = BRANCH_TOLERANCE  # of positions that were searched for
    if regular[0] is positions[0]:
        limit = _open_from(float(np.abs(positions[0].r).max()))
    is_open = np.abs(_missed_alone(branch, regular[0], places)) > limit
    missed = np.zeros(len(left))
    for position in regular:
        missed = np.maximum(missed, np.abs(_missed_alone(branch, position, places)))
    is_length = [branch.is_length(place) for place in places]
    found = zip(left, is_length, pivots, missed.tolist(), strict=True)
    return tuple(
        Closed(*one)
        for one, starts_open in zip(found, is_open.tolist(), strict=True)
        if one[2] > ROUNDING_OF_PIVOTS or one[3] > BRANCH_TOLERANCE or starts_open
    )


def _missed_alone(branch: Branch, position: BranchPosition, places: Sequence[int]) -> Array:
    """Residuals of some rows where all others hold, in lengths of the scene and radians."""
    y = position.factors.dependences()
    alone = factorise(y[:, list(places)]).least_change((y * position.c).sum(axis=1))
    return branch.in_units(alone, places)


def _is_good(position: BranchPosition, places: Sequence[int]) -> bool:
    """Whether rows, by their places, stay left out at a position, and do not take over."""
    factors = factorise(position.factors.dependences()[:, list(places)])
    return factors.rank == len(places) and bool(factors.pivots.min() ** 2 > FALL_BACK)


def notes_of_freedom(system: System, freedom: Freedom) -> Iterator[str]:
    """Notes on rows that were taken as redundant, and on scenes in which nothing moves."""
    fixed = fixed_system(system)
    # with other ones rows may miss more, and what holds here may move
    depends = fixed.constraints != system.constraints or system.given
    given = ", with the parameters of the scene" if depends else ""
    worst: dict[tuple[str, bool], float] = {}
    for one in freedom.closed:
        key = (key_of(system.constraints[one.row.instance]), one.is_length)
        worst[key] = max(worst.get(key, 0.0), one.missed)
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
            f" rows of {listed(texts)}{given}; they are left out, and miss so much"
            " along the motion"
        )
    if not freedom.degrees and not any(one.is_driver for one in system.constraints):
        yield f"nothing can move: joints hold all bodies where they are{given}"
