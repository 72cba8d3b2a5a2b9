"""Verdict on a run: how far it can be trusted, and what speaks against that."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from .result import key_of, listed, shortly
from .settings import CLEARLY, KINEMATICS

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence
    from typing import TypeAlias

    import numpy.typing as npt

    from .motion import Layout

    Array: TypeAlias = npt.NDArray[np.float64]

#: What a healthy run may lose, in tolerances, in each thousand steps.
HEALTHY, PER_STEPS = 100.0, 1000.0
#: Instead of the tolerance where steps have a fixed length: no error decides that.
FIXED = 1e-9
#: The least tolerance of corrections: near singular configurations they have more of rounding.
LEAST = 1e-11
#: What energies are known to, and constraints, relative to what they are compared with.
ROUNDING = 1e-12
#: What rows that are left out miss is rounding below that, in lengths of the scene or radians.
MISSES = 1e-9
#: An energy that is no motion: that of heat, of one freedom at room temperature [J].
HEAT = 4e-21


class CheckedRows(NamedTuple):
    """Joint and unit of each row of the constraints that is checked.

    Parameters
    ----------
    rows, left_out, reduced : sequence of (str, str)
        Those solved for; those that others imply but for the closure tolerance; those that
        coordinates of the solver fulfil.
    """

    rows: Sequence[tuple[str, str]]
    left_out: Sequence[tuple[str, str]]
    reduced: Sequence[tuple[str, str]]


@dataclass(frozen=True, slots=True)
class Trust:
    """How far a run can be trusted: its numbers, and what speaks against it.

    Parameters
    ----------
    energy_error, energy_moved : float or None [J]
        Largest change of energy that no work explains, and what that is compared with: the largest
        sum of kinetic energy, change of potential energy and works. None where rows were not
        checked, or drivers move bodies without mass.
    work_error : float or None [J]
        Under ``kinematics``, what a second rule of quadrature finds missing in works: energies of
        rows cannot tell it where a load and its driver miss the same. Else None.
    constraints : float or None
        Largest residual of a constraint in position, relative to a length of the scene, or in
        radians; None where rows were not checked. Rows that are left out are not among them.
    missed, closure_tolerance : float
        What rows that are left out miss at most, in the same units, and what they may.
    drift, row_drift : float or None
        Largest correction onto the constraints of a step, and of a row between steps, which the
        dense output tells, relative to a length of the scene; None where joints and drivers leave
        nothing free: corrections then take away all of the error of a step or row.
    pivot_ratio : float or None
        Smallest pivot ratio: near zero at a singular configuration; None without constraints.
    unresolved : int
        Steps over which bounds do not tell how formulas vary: what acts for a moment there may be
        passed over.
    branch_point_time : float or None [s]
        When the motion first went so near to where branches of it meet that rounding, or the length
        of steps, decides which of them goes on.
    error : kousoku.runtime.error_estimate.ErrorEstimate or None
        Of all rows, where that was wanted.
    limit : float
        What the others may be, relative to what they are compared with:
        100 × tolerance × max(1, steps/1000). Where rows that others imply but for the closure
        tolerance took over from these, what they missed stands for a smaller tolerance.
    problems : tuple of str
        What is beyond its limit, and what to do; empty where nothing speaks against the run.
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
    branch_point_time: float | None
    error: Any
    limit: float
    problems: tuple[str, ...]

    @property
    def is_trusted(self) -> bool:
        """Whether nothing speaks against the run."""
        return not self.problems

    def as_data(self) -> dict[str, object]:
        """Return it ready for JSON."""
        named = {name: getattr(self, name) for name in self.__slots__}
        named["error"] = None if self.error is None else self.error.as_data()
        return {"is_trusted": self.is_trusted} | named | {"problems": list(self.problems)}

    def _numbers(self) -> Iterator[str]:
        """Yield the numbers that are known."""
        if self.energy_error is not None and self.energy_moved is not None:
            yield f"energy {shortly(self.energy_error)} of {shortly(self.energy_moved, 2)} J"
        if self.constraints is None:
            yield "rows not checked"
        elif self.constraints <= ROUNDING:
            yield "constraints at rounding"
        else:
            yield f"constraints {shortly(self.constraints)}"
        if self.missed > MISSES:
            yield f"redundant rows miss {shortly(self.missed)}"
        if self.pivot_ratio is not None:
            yield f"smallest pivot {shortly(self.pivot_ratio)}"
        if self.unresolved:
            count = f"{self.unresolved} step{'s' * (self.unresolved > 1)}"
            yield f"narrow forces may be passed over in {count}"
        if self.branch_point_time is not None:
            when = shortly(self.branch_point_time, 6)
            yield f"branch not known beyond t = {when} s, where others meet it"
        yield "error not estimated" if self.error is None else str(self.error)

    def __str__(self) -> str:
        numbers = " · ".join(self._numbers())
        return f"trust: {numbers}" if self.is_trusted else f"not trusted: {self.why} · {numbers}"

    @property
    def why(self) -> str:
        """What speaks against the run, in one line."""
        return "; ".join(self.problems)


def trust_of(
    state: Mapping[str, Array],
    rows: CheckedRows,
    layout: Layout,
    method: str,
    *,
    tolerance: float,
    step: float | None,
    checks: bool,
    is_weighed: bool,
    is_driven: bool,
    error: Any = None,
) -> Trust:
    """Return the verdict on a run.

    Parameters
    ----------
    state : mapping of str to array
        Its state by names.
    rows : CheckedRows
        What was checked.
    layout : Layout
        What stands where in a row.
    method, tolerance, step, checks
        How it was made.
    is_weighed, is_driven : bool
        Whether energies are known, and whether drivers determine the motion.
    error : kousoku.runtime.error_estimate.ErrorEstimate, optional
        Of its rows.
    """
    single = {name: float(field) for name, field in state.items() if field.ndim == 0}
    joints = missed_by(state["violations"][0], rows, layout) if checks else {}
    missed = max((one.part for one in joints.values()), default=0.0)
    constraints = _constraints(state["violations"][0], rows, layout) if checks else None
    is_determined = layout.sizes["v"] == len(rows.rows) + len(rows.reduced)
    # joints hold all that could move: what energy there is is rounding
    is_still = is_determined and not is_driven
    is_led, advice = method == KINEMATICS, "a smaller tolerance or largest_step"
    if step is not None:
        tolerance, advice = FIXED, "a smaller step"
    many = HEALTHY * max(1.0, single["steps"] / PER_STEPS)
    # where rows take over from others bodies go on where these hold: as far off as rows miss
    took_over = single["fallbacks"] > 0 and missed > MISSES
    tolerance = max(tolerance, missed) if took_over else tolerance
    limit, corrections = many * tolerance, many * max(tolerance, LEAST)
    knows_energy = checks and is_weighed
    lost, moved, unseen = (
        single[name] if knows_energy else None
        for name in ("energy_error", "energy_moved", "work_error")
    )
    unseen = unseen if is_led else None
    drift, row_drift = (None if is_determined else single[name] for name in ("drift", "row_drift"))
    advice = "a smaller largest_step, or more rows" if is_led else advice
    problems, beyond = [], []
    if single["not_finite"]:
        problems.append(
            f"numbers of rows are not finite, of {single['not_finite']:.0f} in all, first at t ="
            f" {single['not_finite_time']:.9g} s: a formula has no value there; ask for other"
            " times, or write it without the quotient that is 0/0"
        )
    if opened := released(joints, layout):
        problems.append(
            f"{listed([key_of(name) for name in opened])} came open by more than ten times"
            f" closure_tolerance, {layout.closure_tolerance:g}: this is not the motion of the scene"
        )
    if lost is not None and moved is not None and not is_still:
        known = ROUNDING * max(abs(single["energy"]), abs(single["potential"]), moved)
        allowed = max(limit * moved, known, HEAT)
        if not lost <= allowed:
            beyond.append(
                f"energy is off by {shortly(lost)} J of {shortly(moved, 2)} J, wanted at most"
                f" {shortly(allowed)} J"
            )
        # without signs, so that errors of steps add up that are none in all
        allowed = max(allowed, single["steps"] * tolerance * moved)
        if unseen is not None and not unseen <= allowed:
            beyond.append(
                f"works are off by {shortly(unseen)} J of {shortly(moved, 2)} J, as positions"
                f" between those of steps tell, wanted at most {shortly(allowed)} J"
            )
    for name, size, most in (
        ("constraints are left by", constraints, corrections),
        ("a step left the constraints by", drift, corrections),
        ("rows between steps are off the constraints by", row_drift, corrections),
    ):
        if size is not None and not size <= most:
            beyond.append(
                f"{name} {shortly(size)} of a length of the scene, wanted at most {shortly(most)}"
            )
    problems += [*beyond, *[f"try {advice}"] * bool(beyond)]
    if single["branch_points"] and not is_led:
        count = f"{single['branch_points']:.0f} step{'s' * (single['branch_points'] > 1)}"
        problems.append(
            f"{count} went by a singular configuration, the first to t ="
            f" {single['branch_point_time']:.6g} s: the motion may be that of another branch, try"
            f" {advice}"
        )
    if error is not None and error.unknown_from is not None:
        problems.append(error.unknown)
    has_pivots = single["factorisations"] > 0
    return Trust(
        energy_error=lost,
        energy_moved=moved,
        work_error=unseen,
        constraints=constraints,
        missed=missed,
        closure_tolerance=layout.closure_tolerance,
        drift=drift,
        row_drift=row_drift,
        pivot_ratio=single["least_pivot_ratio"] if has_pivots else None,
        unresolved=int(single["unresolved"]),
        branch_point_time=single["branch_point_time"] if single["branch_points"] else None,
        error=error,
        limit=limit,
        problems=tuple(problems),
    )


class Missed(NamedTuple):
    """What the rows of a joint that are left out missed at most.

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
    """Return by joint what rows that are left out missed, the worst first."""
    first = len(rows.rows)
    found: dict[str, list[float]] = {}
    for (joint, unit), size in zip(rows.left_out, worst[first:].tolist(), strict=False):
        own = found.setdefault(joint, [0.0, 0.0])
        place = 0 if unit == "m" else 1
        own[place] = max(own[place], size)
    all_of = [
        (joint, Missed(metres, radians, max(metres / layout.length, radians)))
        for joint, (metres, radians) in found.items()
    ]
    return dict(sorted(all_of, key=lambda one: -one[1].part))


def released(missed: Mapping[str, Missed], layout: Layout) -> tuple[str, ...]:
    """Return the joints that came open at rows that were left out."""
    most = CLEARLY * layout.closure_tolerance
    return tuple(joint for joint, one in missed.items() if not one.part <= most)


def _constraints(worst: Array, rows: CheckedRows, layout: Layout) -> float:
    """Return the largest residual of rows that hold, relative to a length where it is one."""
    units = [unit for part in rows for _, unit in part]
    parts = worst[: len(units)] / [layout.length if unit == "m" else 1.0 for unit in units]
    first = len(rows.rows)
    holds = np.delete(parts, range(first, first + len(rows.left_out)))
    return float(np.max(holds, initial=0.0))
