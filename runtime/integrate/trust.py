"""Verdict on a run: what speaks against it, decided as in ``trust.h``, and put into words."""

from __future__ import annotations

from dataclasses import dataclass
from operator import itemgetter
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..messages import listed, scene_key, shortly
from .arithmetic import larger, smaller
from .settings import CLEARLY, NOTHING_MOVES, Doubt

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from .arithmetic import Array
    from .motion import Layout
    from .settings import Settings

#: Largest loss of a healthy run in each thousand steps, in tolerances.
HEALTHY = 100.0
#: Number of steps in which a run may lose that.
PER_STEPS = 1000.0
#: Largest loss of a healthy run however many steps it has, relative to all that moves.
MOST_LOST = 0.5
#: Value in place of the tolerance where steps have a fixed length: the tolerance does not decide
#: their error.
FIXED = 1e-9
#: Smallest tolerance that the limit of corrections is computed with: near singular configurations
#: rounding makes them larger.
LEAST = 1e-11
#: Rounding of energies and of constraints, relative to what they are compared with.
KNOWN = 1e-12
#: Misses of rows that are left out, in lengths of the scene or radians, below which they are
#: rounding.
MISSES = 1e-9
#: Energy that is no motion where hardly anything moves [J]: the heat of one freedom at room
#: temperature.
HEAT = 4e-21
#: Doubts that shorter steps remove.
OF_STEPS = Doubt.ENERGY | Doubt.WORKS | Doubt.CONSTRAINTS | Doubt.DRIFT | Doubt.ROW_DRIFT


class CheckedRows(NamedTuple):
    """Joint and unit of each row of the constraints that is checked.

    Parameters
    ----------
    rows, left_out, satisfied : sequence of (str, str)
        Those solved for; those that others imply but for the closure tolerance; those that
        joint coordinates satisfy identically.
    """

    rows: Sequence[tuple[str, str]]
    left_out: Sequence[tuple[str, str]]
    satisfied: Sequence[tuple[str, str]]


class RunVerdict(NamedTuple):
    """Verdict on a run: bits of :class:`Doubt`, and its limits; ``solver.h`` has units."""

    doubts: int
    limit: float
    correction_limit: float
    energy_limit: float
    work_limit: float
    constraints: float
    missed: float


@dataclass(frozen=True, slots=True)
class Trust:
    """Trust that a run deserves: its numbers, and what speaks against it.

    Parameters
    ----------
    energy_error, energy_moved : float or None [J]
        Largest change of energy that no work explains, and the scale of this error: the largest sum
        of kinetic energy, change of potential energy and works. None where rows were not checked,
        or drivers move bodies without mass.
    work_error : float or None [J]
        Under ``kinematics``, error of works as estimated by a second rule of quadrature: the energy
        balance does not show it where the works of a load and of its driver miss the same. Else
        None.
    constraints : float or None
        Largest residual of a constraint in position, relative to a length of the scene, or in
        radians; None where rows were not checked. Rows that are left out are not among them.
    missed, closure_tolerance : float
        Largest residual of rows that are left out, in the same units, and its limit.
    drift, row_drift : float or None
        Largest correction onto the constraints of a step, and of a row that the dense output gives
        between steps, relative to a length of the scene. None where joints and drivers leave no
        freedom: corrections then remove the whole error of a step or row.
    pivot_ratio : float or None
        Smallest pivot ratio: near zero at a singular configuration; None without constraints.
    unresolved : int
        Steps over which bounds do not tell how formulas vary: what acts for a moment there may be
        passed over.
    impulse, impulse_time : float or None, float or None [s]
        Largest change of velocities, relative to the largest speed, by forces that are infinite or
        too steep for doubles, so near to such a place that rounding hides it; and the time of the
        last such force. None where the change is within the tolerance.
    stillness : float or None
        Largest motion of bodies in the longest step, in lengths of the scene or radians, where it
        is so small that at this tolerance the energy that moves is not distinguished from the loss
        of steps: at rest, or in a motion too small for the tolerance. Else None.
    below_tolerance : mapping of str to float
        Coordinates that rows show, then bodies, that move by no more than the limit in the whole
        run, and how far: in lengths of the scene or radians, the least first. Steps may lose as
        much, so that rows tell little of such a motion beside a larger one. Left out are those that
        stand still but for rounding, and what drivers lead, which is exact.
    branch_point_time : float or None [s]
        When the motion first went so near to another branch of it that the length of steps may have
        decided which of them goes on.
    meeting_time : float or None [s]
        When it first went straight on where branches meet, or come nearer than rounding tells.
    error : kousoku.runtime.error_estimate.ErrorEstimate or None
        Estimate of the error of all rows, where it was asked for.
    limit : float
        Largest value of the relative errors above, 100 × tolerance × max(1, steps/1000), at most
        0.5. With a fixed step the tolerance counts as 1e-9. Where rows that were left out as
        redundant took over, the tolerance is replaced by the largest miss of such rows, if that is
        larger.
    problems : tuple of str
        Numbers beyond their limits, and what to do; empty where nothing speaks against the run.
    """

    energy_error: float | None
    energy_moved: float | None
    work_error: float | None
    constraints: float | None
    missed: float
    closure_tolerance: float
    drift: float | None
    row_drift: float | None
    pivot_ratio: float | None
    unresolved: int
    impulse: float | None
    impulse_time: float | None
    stillness: float | None
    below_tolerance: Mapping[str, float]
    branch_point_time: float | None
    meeting_time: float | None
    error: Any
    limit: float
    problems: tuple[str, ...]

    @property
    def is_trusted(self) -> bool:
        """Whether nothing speaks against the run."""
        return not self.problems

    def as_data(self) -> dict[str, object]:
        """Verdict as data, ready for JSON."""
        named = {name: getattr(self, name) for name in self.__slots__}
        named["error"] = None if self.error is None else self.error.as_data()
        return {"is_trusted": self.is_trusted} | named | {"problems": list(self.problems)}

    def _numbers(self) -> Iterator[str]:
        """Numbers that are known."""
        if self.energy_error is not None and self.energy_moved is not None:
            yield f"energy {shortly(self.energy_error)} of {shortly(self.energy_moved, 2)} J"
        if self.constraints is None:
            yield "rows not checked"
        elif self.constraints <= KNOWN:
            yield "constraints at rounding"
        else:
            yield f"constraints {shortly(self.constraints)}"
        if self.missed > MISSES:
            yield f"redundant rows miss {shortly(self.missed)}"
        if self.pivot_ratio is not None:
            yield f"smallest pivot {shortly(self.pivot_ratio)}"
        if self.impulse is not None and self.impulse_time is not None:
            yield (
                f"velocities known to {shortly(self.impulse)}, as a force is infinite, or"
                f" too steep for doubles, at t = {shortly(self.impulse_time, 9)} s"
            )
        if self.stillness is not None:
            part = shortly(self.stillness)
            yield f"bodies move by {part} of a length or rad a step, less than this tolerance tells"
        if self.below_tolerance:
            name, moved = next(iter(self.below_tolerance.items()))
            others = len(self.below_tolerance) - 1
            more = f", so do {others} more" * (others > 0)
            size = f"{shortly(moved)} of a length or rad"
            yield f"{name} moves by {size}, less than this tolerance tells{more}"
        if self.branch_point_time is not None:
            when = shortly(self.branch_point_time, 6)
            yield f"branch not known beyond t = {when} s, where another one comes near"
        if self.meeting_time is not None:
            yield f"branches meet at t = {shortly(self.meeting_time, 6)} s"
        yield "error not estimated" if self.error is None else str(self.error)

    def __str__(self) -> str:
        numbers = " · ".join(self._numbers())
        return f"trust: {numbers}" if self.is_trusted else f"not trusted: {self.why} · {numbers}"

    @property
    def why(self) -> str:
        """Doubts about the run, in one line."""
        return "; ".join(self.problems)


def beyond(size: float, most: float, doubt: Doubt) -> Doubt:
    """Doubt where a number is larger than it may be, or a NaN."""
    return Doubt(0) if size <= most else doubt


def allowed_part(limit: float, settings: Settings, single: Mapping[str, float]) -> float:
    """Part of the moved energy that may be lost.

    It is the limit, unless bodies move so little in the longest step that velocities and their
    errors are compared with more: at rest all that moves may be such an error.
    """
    travel = single["fastest"] * single["stride"]
    if settings.fixed_step > 0.0 or not 0.0 < travel < NOTHING_MOVES:
        return limit
    part = limit * (NOTHING_MOVES / travel)
    return part + part * part


def known_energy(single: Mapping[str, float]) -> float:
    """Uncertainty of energies [J]: below that they are rounding, or heat of what hardly moves."""
    moved = single["energy_moved"]
    largest = larger(larger(abs(single["energy"]), abs(single["potential"])), moved)
    is_still = single["fastest"] * single["stride"] < NOTHING_MOVES
    return larger(KNOWN * largest, HEAT * is_still)


def fastest_or_nothing(single: Mapping[str, float]) -> float:
    """Largest speed so far [1/s], in lengths of the scene and radians.

    Where nothing moves it is what counts as none.
    """
    stride = single["stride"]
    return larger(single["fastest"], NOTHING_MOVES / stride if stride > 0.0 else 0.0)


def relative_impulse(single: Mapping[str, float]) -> float:
    """Impulse of what is too steep for doubles, relative to the largest speed so far [-]."""
    return single["impulse"] / fastest_or_nothing(single) if single["impulse"] > 0.0 else 0.0


def judge(
    state: Mapping[str, Array],
    rows: CheckedRows,
    layout: Layout,
    settings: Settings,
    *,
    has_masses: bool,
    is_driven: bool,
) -> RunVerdict:
    """Doubts and numbers of the verdict on a run; arguments as of :func:`trust_of`."""
    single = {name: float(field) for name, field in state.items() if field.ndim == 0}
    units = [unit for part in rows for _, unit in part]
    lengths = [layout.length if unit == "m" else 1.0 for unit in units]
    residuals, held = state["violations"][0] / lengths, len(rows.rows) + len(rows.satisfied)
    ends = (residuals[:held], residuals[held:])
    constraints, missed = (float(np.max(part, initial=0.0)) for part in ends)  # a NaN stays
    moved, is_free = single["energy_moved"], layout.sizes["v"] != held
    allowance = HEALTHY * larger(1.0, single["steps"] / PER_STEPS)
    tolerance = FIXED if settings.fixed_step > 0.0 else settings.tolerance
    # where rows take over from others bodies go on where these hold: as far off as rows miss
    if single["fallbacks"] > 0.0 and missed > MISSES:
        tolerance = larger(tolerance, missed)
    limit = smaller(allowance * tolerance, MOST_LOST)
    correction_limit = smaller(allowance * larger(tolerance, LEAST), MOST_LOST)
    part = allowed_part(limit, settings, single)
    energy_limit = larger(part * moved, known_energy(single))
    # without signs, so that errors of steps add up that are none in all
    work_limit = larger(energy_limit, smaller(single["steps"] * tolerance, MOST_LOST) * moved)
    doubts = beyond(single["not_finite"], 0.0, Doubt.NOT_FINITE)
    doubts |= beyond(missed, CLEARLY * layout.closure_tolerance, Doubt.OPEN)
    # where joints hold all that could move what energy there is is rounding
    if settings.checks and has_masses and (is_driven or is_free):
        doubts |= beyond(single["energy_error"], energy_limit, Doubt.ENERGY)
        if settings.is_kinematic:
            doubts |= beyond(single["work_error"], work_limit, Doubt.WORKS)
    doubts |= beyond(constraints, correction_limit, Doubt.CONSTRAINTS)
    if is_free:  # else corrections take away all of the error of a step or row
        doubts |= beyond(single["drift"], correction_limit, Doubt.DRIFT)
        doubts |= beyond(single["row_drift"], correction_limit, Doubt.ROW_DRIFT)
    doubts |= beyond(single["branch_points"], 0.0, Doubt.BRANCH_POINTS)
    doubts |= beyond(single["unresolved"], 0.0, Doubt.NARROW)
    doubts |= beyond(single["impulse"], limit * fastest_or_nothing(single), Doubt.IMPULSE)
    return RunVerdict(
        doubts, limit, correction_limit, energy_limit, work_limit, constraints, missed
    )


def problems_of(
    verdict: RunVerdict,
    state: Mapping[str, Array],
    rows: CheckedRows,
    layout: Layout,
    settings: Settings,
) -> list[str]:
    """Doubts of a verdict in words, with what may help; arguments as of :func:`trust_of`."""
    single = {name: float(field) for name, field in state.items() if field.ndim == 0}
    advice = "a smaller step" if settings.fixed_step else "a smaller tolerance or largest_step"
    advice = "a smaller largest_step, or more rows" if settings.is_kinematic else advice
    opened = map(scene_key, released(missed_by(state["violations"][0], rows, layout), layout))
    moved, count = shortly(single["energy_moved"], 2), single["branch_points"]
    impulse = shortly(relative_impulse(single))
    limits = f"of a length of the scene, wanted at most {shortly(verdict.correction_limit)}"
    reasons = {
        Doubt.NOT_FINITE: f"numbers of rows are not finite, of {single['not_finite']:.0f} in all,"
        f" first at t = {single['not_finite_time']:.9g} s: a formula has no value there; ask for"
        " other times, or write it without the quotient that is 0/0",
        Doubt.OPEN: f"{listed([*opened])} came open by more than ten times"
        f" closure_tolerance, {layout.closure_tolerance:g}: this is not the motion of the scene",
        Doubt.ENERGY: f"energy is off by {shortly(single['energy_error'])} J of {moved} J, wanted"
        f" at most {shortly(verdict.energy_limit)} J",
        Doubt.WORKS: f"works are off by {shortly(single['work_error'])} J of {moved} J, as"
        f" positions between those of steps tell, wanted at most {shortly(verdict.work_limit)} J",
        Doubt.CONSTRAINTS: f"constraints are left by {shortly(verdict.constraints)} {limits}",
        Doubt.DRIFT: f"a step left the constraints by {shortly(single['drift'])} {limits}",
        Doubt.ROW_DRIFT: "rows between steps are off the constraints by"
        f" {shortly(single['row_drift'])} {limits}",
        OF_STEPS: f"try {advice}",
        Doubt.BRANCH_POINTS: f"{count:.0f} step{'s' * (count > 1)} went by a singular"
        f" configuration, the first to t = {single['branch_point_time']:.6g} s: the motion may be"
        f" that of another branch, try {advice}",
        Doubt.NARROW: untold(single, advice),
        Doubt.IMPULSE: "a force is infinite, or too steep for doubles, at"
        f" t = {single['impulse_time']:.9g} s, and what it does so near to it that rounding hides"
        f" times and places may be {impulse} of the largest speed, wanted at most"
        f" {shortly(verdict.limit)}: no tolerance tells more, write it so that it is finite and"
        " less steep",
    }
    return [text for doubt, text in reasons.items() if doubt & verdict.doubts]


def trust_of(
    state: Mapping[str, Array],
    rows: CheckedRows,
    layout: Layout,
    settings: Settings,
    *,
    has_masses: bool,
    is_driven: bool,
    error: Any = None,
) -> Trust:
    """Verdict on a run.

    Parameters
    ----------
    state : mapping of str to array
        Its state by names.
    rows : CheckedRows
        What was checked.
    layout : Layout
        What stands where in a row.
    settings : Settings
        How it was made.
    has_masses, is_driven : bool
        Whether energies are known, and whether drivers determine the motion.
    error : kousoku.runtime.error_estimate.ErrorEstimate, optional
        Of its rows.
    """
    verdict = judge(state, rows, layout, settings, has_masses=has_masses, is_driven=is_driven)
    single = {name: float(field) for name, field in state.items() if field.ndim == 0}
    checks, is_kinematic = bool(settings.checks), settings.is_kinematic
    knows_energy = checks and has_masses
    is_free = layout.sizes["v"] != len(rows.rows) + len(rows.satisfied)
    largest_loss = larger(verdict.limit * single["energy_moved"], known_energy(single))
    is_still = knows_energy and largest_loss < single["energy_error"] <= verdict.energy_limit
    impulse = relative_impulse(single)
    has_impulse = impulse > (FIXED if settings.fixed_step > 0.0 else settings.tolerance)
    problems = problems_of(verdict, state, rows, layout, settings)
    if error is not None and error.unknown_from is not None:
        problems.append(error.unknown)
    return Trust(
        energy_error=single["energy_error"] if knows_energy else None,
        energy_moved=single["energy_moved"] if knows_energy else None,
        work_error=single["work_error"] if knows_energy and is_kinematic else None,
        constraints=verdict.constraints if checks else None,
        missed=verdict.missed,
        closure_tolerance=layout.closure_tolerance,
        drift=single["drift"] if is_free else None,
        row_drift=single["row_drift"] if is_free else None,
        pivot_ratio=single["least_pivot_ratio"] if single["factorisations"] > 0 else None,
        unresolved=int(single["unresolved"]),
        impulse=impulse if has_impulse else None,
        impulse_time=single["impulse_time"] if has_impulse else None,
        stillness=single["fastest"] * single["stride"] if is_still else None,
        below_tolerance=below_tolerance(state, layout, settings, verdict.limit),
        branch_point_time=single["branch_point_time"] if single["branch_points"] else None,
        meeting_time=single["meeting_time"] if single["meetings"] else None,
        error=error,
        limit=verdict.limit,
        problems=tuple(problems),
    )


def below_tolerance(
    state: Mapping[str, Array], layout: Layout, settings: Settings, limit: float
) -> dict[str, float]:
    """Coordinates and bodies that move by no more [-] than steps may lose, as in :class:`Trust`.

    Ranges of coordinates, lengths relative to that of the scene. Where drivers lead, bodies are
    left out: some are exact, and which of them is not known.
    """
    if settings.fixed_step > 0.0 or settings.is_kinematic:
        return {}
    low, high = state["lowest"], state["highest"]
    ranges, sizes = high - low, np.maximum(np.abs(low), np.abs(high))
    first, length = len(low) - len(layout.coordinates), layout.length
    positions = [k for body in layout.bodies for k in body.r if isinstance(k, int)]
    rounding = KNOWN * (1.0 + float(np.max(sizes[positions], initial=0.0)) / length)
    shown, bodies = {}, {}
    for k, (name, is_length, _) in enumerate(layout.coordinates, first):
        unit = length if is_length else 1.0
        if name not in layout.driven and ranges[k] > rounding * larger(unit, sizes[k]):
            shown[f"coordinates.{name}"] = float(ranges[k] / unit)
    for body in () if layout.has_drivers else layout.bodies:
        motions = [ranges[k] / length for k in body.r if isinstance(k, int)]
        motions += [2.0 * ranges[k] for k in body.p if isinstance(k, int)]
        if max(motions, default=0.0) > rounding:
            bodies[f"bodies.{body.name}"] = float(max(motions))
    pairs = [*sorted(shown.items(), key=itemgetter(1)), *sorted(bodies.items(), key=itemgetter(1))]
    return {name: motion for name, motion in pairs if motion <= limit}


def untold(single: Mapping[str, float], advice: str) -> str:
    """Steps over which no bounds tell how formulas vary, and what to do."""
    count = single["unresolved"]
    return (
        f"narrow forces may be passed over in {count:.0f} step{'s' * (count > 1)}, the last from"
        f" t = {single['unresolved_time']:.9g} s on, where bounds do not tell how formulas vary:"
        f" try {advice}, or another way to write them"
    )


class Missed(NamedTuple):
    """Largest residual of the rows of a joint that are left out.

    Parameters
    ----------
    metres : float [m]
        Those that are lengths.
    radians : float [rad]
        Those that are angles.
    part : float
        The larger of both, lengths relative to that of the scene.
    """

    metres: float
    radians: float
    part: float


def missed_by(worst: Array, rows: CheckedRows, layout: Layout) -> dict[str, Missed]:
    """Largest misses of rows that are left out, by joint, the worst first.

    ``worst`` (rows,) [m, rad] has those of all rows: solved for, left out, satisfied.
    """
    first = len(rows.rows)
    by_joint: dict[str, list[float]] = {}
    for (joint, unit), size in zip(rows.left_out, worst[first:].tolist(), strict=False):
        sizes = by_joint.setdefault(joint, [0.0, 0.0])
        kind = 0 if unit == "m" else 1
        sizes[kind] = float(np.maximum(sizes[kind], size))  # a NaN stays
    misses = [
        (joint, Missed(metres, radians, float(np.maximum(metres / layout.length, radians))))
        for joint, (metres, radians) in by_joint.items()
    ]
    return dict(sorted(misses, key=lambda item: -item[1].part))


def released(missed: Mapping[str, Missed], layout: Layout) -> tuple[str, ...]:
    """Joints that came open at rows that were left out."""
    limit = CLEARLY * layout.closure_tolerance
    return tuple(joint for joint, miss in missed.items() if not miss.part <= limit)
