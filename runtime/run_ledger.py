"""The ledger of a run: what it cost, and how far its result can be trusted."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from kousoku.runtime.integrate.result import Named
from kousoku.runtime.integrate.settings import KINEMATICS
from kousoku.runtime.integrate.trust import MISSES, CheckedRows, missed_by, released, trust_of
from kousoku.runtime.messages import MOST_PARTS_SHOWN, listed, scene_key
from kousoku.runtime.momenta import momenta_of

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from kousoku.runtime.dynamics import DynamicsSolver
    from kousoku.runtime.error_estimate import ErrorEstimate
    from kousoku.runtime.integrate.arithmetic import Array
    from kousoku.runtime.integrate.assembled_start import Moved
    from kousoku.runtime.integrate.trust import Trust
    from kousoku.runtime.momenta import Momentum
    from kousoku.runtime.options import Options

#: Fields of the state that are counts, and fields of the ledger.
COUNTS = (
    *("steps", "rejected", "derivatives", "factorisations", "corrections", "avoided", "passed"),
    *("fallbacks", "refinements", "unresolved", "branch_points", "meetings"),
)
CONSTRAINT_LEVELS = ("position", "velocity", "acceleration")
UNITS = ("m", "rad")
#: Works that the ledger prints, the largest first.
MOST_WORKS = 12


@dataclass(frozen=True, slots=True)
class Violation:
    """Residuals of the constraints of a joint, the largest of all rows that were written.

    Parameters
    ----------
    metres, radians : (3,) tuple of float
        Of residuals that are lengths and angles, at the levels of position, velocity [1/s] and
        acceleration [1/s²].
    """

    metres: tuple[float, ...]
    radians: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class RunLedger:
    """Ledger of a run: its cost, and how far it can be trusted.

    Parameters
    ----------
    method : str
        The Runge-Kutta method.
    tolerance : float
        Local error of a step, relative; nothing is measured by it where the step is fixed, and
        where drivers determine the motion.
    fixed_step : float or None [s]
        Length of steps, where no error decides it: shorter only at the end, where formulas switch
        or are narrow, and near dependent rows.
    parameters : mapping of str to float
        Of the run.
    steps, rejected : int
        Steps that were made, and that were tried in vain.
    derivatives, factorisations, corrections : int
        Evaluations of the accelerations, factorisations of C_q M⁻¹ C_qᵀ, and corrections of
        positions in Newton's method.
    drift : float
        Largest correction of a step onto the constraints, relative to a length of the scene.
    avoided : int
        Lengths of steps that were given up, since a stage fell where rows of the constraints are
        nearly dependent and rounding is large: for a shorter one, or at the end for a longer one.
    growth, growth_time : float, float [s]
        Smallest ratio of the smallest to the largest pivot of a factorisation, and when that was:
        it is near zero where the rank drops.
    unresolved, unresolved_time : int, float or None [s]
        Steps over which bounds do not tell how formulas vary, as near a quotient that is 0/0 or
        where fixed steps are long beside a narrow hill, and when the last of them was: what acts
        for a moment there may be passed over.
    branch_points, branch_point_time : int, float or None [s]
        Steps so near to where another branch of the motion comes near that none of a length that
        was tried is sure to stay on its own, and when the first was: the motion may be that of the
        other branch.
    meetings, meeting_time : int, float or None [s]
        Steps over places where branches of the motion meet, as the change points of a
        parallelogram, or come nearer than rounding tells, and when the first was: the motion went
        straight on.
    passed, passed_time : int, float or None [s]
        Rows that stand where rows of the constraints are dependent, or as good as that, and when
        the last of them is: the polynomial between the states before and after tells their
        accelerations, and forces of joints are NaN.
    fallbacks, fallback_time : int, float or None [s]
        Factorisations of all rows, those too that were left out, where those that are kept are
        nearly dependent, and when the last of them was.
    refinements : int
        Accelerations that one step of iterative refinement brought nearer to C_q v̇ = γ, since the
        pivots told that many digits were lost.
    energy, energy_error : float or None [J]
        Energy at the start, and the largest change since then that no work explains; None where
        rows were not checked, both where drivers move bodies without mass.
    works : mapping of str to float [J]
        Work at the end of what has no potential energy: drivers, dampers, springs with a formula,
        torques, forces that change or turn with a body; empty where ``kinematics`` was not checked.
    momenta : tuple of Momentum
        Largest change of momentum that nothing should change, part by part: bodies that nothing
        connects with the ground; empty where rows were not checked.
    violations : mapping of str to Violation
        Residuals of the constraints by joint, also of dependent ones that are not solved for;
        empty where rows were not checked.
    missed : mapping of str to (float, float) [m], [rad]
        Largest gaps of joints at rows that were left out, because others imply them but for the
        scene's closure tolerance; empty where they are rounding.
    released : tuple of str
        Joints of these that came open by more than ten times that tolerance: elsewhere these rows
        are not redundant, and the motion is not that of the scene.
    moved : mapping of str to Moved
        Changes of the start by assembly, of more than 1e-6 of length and speed: bodies, the one
        that changed most first.
    events : mapping of str to int
        Count of each event.
    seconds : mapping of str to float
        Time that each phase took: it differs from run to run.
    trust : Trust
        The verdict.
    """

    method: str
    tolerance: float
    fixed_step: float | None
    parameters: Mapping[str, float]
    steps: int
    rejected: int
    derivatives: int
    factorisations: int
    corrections: int
    drift: float
    avoided: int
    growth: float
    growth_time: float
    passed: int
    passed_time: float | None
    unresolved: int
    unresolved_time: float | None
    branch_points: int
    branch_point_time: float | None
    meetings: int
    meeting_time: float | None
    fallbacks: int
    fallback_time: float | None
    refinements: int
    energy: float | None
    energy_error: float | None
    works: Mapping[str, float]
    momenta: tuple[Momentum, ...]
    violations: Mapping[str, Violation]
    missed: Mapping[str, tuple[float, float]]
    released: tuple[str, ...]
    moved: Mapping[str, Moved]
    events: Mapping[str, int]
    seconds: Mapping[str, float]
    trust: Trust

    def __repr__(self) -> str:
        return f"<RunLedger: {str(self).splitlines()[0]}; print() shows all>"

    def worst(self, level: str) -> tuple[float, float]:
        """Largest violation of all joints at a level: of lengths [m], and of angles [rad].

        Of velocities and accelerations these are per s and per s².
        """
        k = CONSTRAINT_LEVELS.index(level)
        violations = self.violations.values()
        return (
            max((violation.metres[k] for violation in violations), default=0.0),
            max((violation.radians[k] for violation in violations), default=0.0),
        )

    def worst_joint(self, level: str) -> str:
        """Joint with the largest violation at a level; there is one at least."""
        k, violations = CONSTRAINT_LEVELS.index(level), self.violations
        return max(
            violations,
            key=lambda name: max(violations[name].metres[k], violations[name].radians[k]),
        )

    def _control(self) -> str:
        """Step-size control: none, a fixed step, or a tolerance."""
        if self.method == KINEMATICS:
            return "driven"
        if self.fixed_step is not None:
            return f"steps of {self.fixed_step:g} s without control of the error"
        return f"tolerance {self.tolerance:g}"

    def as_data(self) -> dict[str, object]:
        """Ledger as data, ready for JSON, without the verdict."""
        fields = {name: getattr(self, name) for name in self.__slots__ if name != "trust"}
        fields["violations"] = {
            joint: {"metres": list(violation.metres), "radians": list(violation.radians)}
            for joint, violation in self.violations.items()
        }
        fields["missed"] = {joint: list(sizes) for joint, sizes in self.missed.items()}
        fields["works"] = dict(self.works)
        fields["events"] = dict(self.events)
        fields["moved"] = {body: change._asdict() for body, change in self.moved.items()}
        fields["momenta"] = [momentum.as_data() for momentum in self.momenta]
        fields["parameters"] = dict(self.parameters)
        fields["seconds"] = dict(self.seconds)
        return fields

    def _constraint_lines(self) -> Iterator[str]:
        """Lines about residuals of the constraints, and where these nearly depend on each other."""
        if not self.violations:
            return
        for level, per in zip(CONSTRAINT_LEVELS, ("", "/s", "/s²"), strict=True):
            metres, radians = self.worst(level)
            yield (
                f"left of the constraints, {level}: {metres:.1e} m{per}, {radians:.1e} rad{per},"
                f" most at {scene_key(self.worst_joint(level))}"
            )
        if self.missed:
            texts = [
                f"{scene_key(joint)} by {metres:.1e} m, {radians:.1e} rad"
                for joint, (metres, radians) in self.missed.items()
            ]
            yield f"redundant rows, which others imply, missed at most: {listed(texts)}"
        if self.released:
            names = listed([scene_key(name) for name in self.released])
            yield (
                f"came open: {names}; a constraint that was left out, because others imply it"
                " where it was looked at, is not implied by them here: this is not the motion of"
                " the scene"
            )
        if self.factorisations:
            yield (
                f"smallest pivot ratio {self.growth:.1e} at t = {self.growth_time:.6g} s;"
                f" {self.refinements} accelerations refined and {self.avoided} lengths of"
                " steps given up near such places"
            )

    def __str__(self) -> str:
        lines = [
            str(self.trust),
            f"{self.method}, {self._control()}: {self.steps} step{'s' * (self.steps != 1)},"
            f" {self.rejected} rejected, {self.derivatives} accelerations,"
            f" {self.factorisations} factorisations, {self.corrections} corrections of positions;"
            f" a step left the constraints by {self.drift:.1e} at most before it was brought back",
        ]
        if self.moved:
            body, changed = next(iter(self.moved.items()))
            count = len(self.moved)
            bodies = f"{count} bodies, most bodies.{body}" if count > 1 else f"bodies.{body}"
            lines.append(f"assembly changed {bodies}: {changed}")
        if self.energy_error is not None:
            lines.append(
                f"energy {self.energy:.9g} J at the start, largest change"
                f"{' beyond work that is done' * bool(self.works)} {self.energy_error:.1e} J"
            )
        if self.works:
            most = sorted(self.works, key=lambda name: -abs(self.works[name]))
            texts = [f"{name} {self.works[name]:.6g} J" for name in most[:MOST_WORKS]]
            more = ", …" * (len(most) > MOST_WORKS)
            lines.append(f"work done at the end: {', '.join(texts)}{more}")
        lines += [str(momentum) for momentum in self.momenta[:MOST_PARTS_SHOWN]]
        if self.events:
            lines.append(
                f"events: {', '.join(f'{event} {count}' for event, count in self.events.items())}"
            )
        lines += self._constraint_lines()
        if self.unresolved:
            lines.append(
                f"{self.unresolved} steps over which bounds do not tell how formulas vary, the"
                f" last at t = {self.unresolved_time:.6g} s: what acts for a moment there may be"
                f" passed over{'; a smaller step tells more' * (self.fixed_step is not None)}"
            )
        if self.branch_points:
            lines.append(
                f"{self.branch_points} steps so near to another branch of the motion that none"
                f" tells them apart, the first at t = {self.branch_point_time:.6g} s: the motion"
                " may be that of another branch"
            )
        if self.meetings:
            lines.append(
                f"branches meet in {self.meetings} step{'s' * (self.meetings > 1)}, or come nearer"
                f" than rounding tells, the first to t = {self.meeting_time:.6g} s: the motion went"
                " straight on there"
            )
        if self.fallbacks:
            lines.append(
                f"{self.fallbacks} factorisations of all rows, the last at t ="
                f" {self.fallback_time:.6g} s, where those that are kept are nearly dependent"
            )
        if self.passed:
            lines.append(
                f"{self.passed} rows where rows of the constraints are dependent, the last at"
                f" t = {self.passed_time:.6g} s: told by the states before and after, reactions NaN"
            )
        return "\n".join(lines)


def ledger_of(
    solver: DynamicsSolver,
    numbers: Array,
    options: Options,
    seconds: Mapping[str, float],
    error: ErrorEstimate | None,
) -> RunLedger:
    """Ledger of a run.

    Parameters
    ----------
    solver : DynamicsSolver
        Solver of the scene that moves.
    numbers : (state_size,) array
        The state of the run, in the units of its fields.
    options : Options
        Options of the run.
    seconds : mapping of str to float [s]
        Time that each phase took.
    error : ErrorEstimate, optional
        Error of its rows.
    """
    state = {name: field.view(numbers) for name, field in solver.state.items()}
    single = {name: float(field) for name, field in state.items() if field.ndim == 0}
    counts = {name: int(single[name]) for name in COUNTS}
    layout, worst = solver.layout, state["violations"]
    rows = CheckedRows(solver.rows, solver.left_out, solver.satisfied)
    missed = missed_by(worst[0], rows, layout) if options.checks else {}
    works: dict[str, float] = {}
    violations: dict[str, Violation] = {}
    if solver.has_masses:
        works = _works(state["y"], layout.works, options)
    if options.checks:
        violations = violations_of(worst, [row for group in rows for row in group], layout.checked)
    changes = state["momentum_errors"].tolist()
    return RunLedger(
        method=options.method,
        tolerance=options.tolerance,
        fixed_step=options.step,
        parameters=Named(dict(options.parameters)),
        drift=single["drift"],
        growth=single["least_pivot_ratio"],
        growth_time=single["least_pivot_ratio_time"],
        passed_time=single["passed_time"] if single["passed"] else None,
        unresolved_time=single["unresolved_time"] if single["unresolved"] else None,
        branch_point_time=single["branch_point_time"] if single["branch_points"] else None,
        meeting_time=single["meeting_time"] if single["meetings"] else None,
        fallback_time=single["fallback_time"] if single["fallbacks"] else None,
        energy=single["energy"] if solver.has_masses else None,
        energy_error=single["energy_error"] if options.checks and solver.has_masses else None,
        works=Named(works),
        momenta=momenta_of(solver.conserved, changes) if options.checks else (),
        violations=Named(violations),
        missed=Named({joint: miss[:2] for joint, miss in missed.items() if miss.part > MISSES}),
        released=released(missed, layout),
        moved=Named(solver.moved),
        events=Named(_events(layout.events, state["counts"])),
        seconds=Named(seconds),
        trust=trust_of(
            state,
            rows,
            layout,
            options.settings(),
            has_masses=solver.has_masses,
            is_driven=solver.is_driven,
            error=error,
        ),
        **counts,
    )


def _events(events: Sequence[tuple[str, str]], counts: Array) -> dict[str, int]:
    return {name: int(count) for (name, _), count in zip(events, counts.tolist(), strict=True)}


def _works(y: Array, works: Sequence[tuple[str, int]], options: Options) -> dict[str, float]:
    """Works at the end; of driven motions steps integrate them for the ledger only."""
    if options.method == KINEMATICS and not options.checks:
        return {}
    return {name: float(y[index]) for name, index in works}


def violations_of(
    worst: Array, rows: Sequence[Sequence[str]], order: Sequence[str] = ()
) -> dict[str, Violation]:
    """Largest residuals of joints.

    Parameters
    ----------
    worst : (3, m) array
        C, Ċ and C̈ of each row [m or rad, per s, per s²].
    rows : sequence of (str, str)
        Joint or driver of each row, and the unit of its residual: m or rad.
    order : sequence of str
        Joints that come first, those too that have no rows.
    """
    joints = dict.fromkeys((*order, *(joint for joint, _ in rows)))
    sizes = {joint: {name: np.zeros(len(CONSTRAINT_LEVELS)) for name in UNITS} for joint in joints}
    for (joint, unit), column in zip(rows, worst.T, strict=True):
        largest = sizes[joint]
        largest[unit] = np.maximum(largest[unit], column)
    return {
        joint: Violation(*(tuple(largest[unit].tolist()) for unit in UNITS))
        for joint, largest in sizes.items()
    }
