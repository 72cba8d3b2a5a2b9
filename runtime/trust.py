"""Verdict on a run: how far it can be trusted, and what speaks against that."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from kousoku.runtime.integrate.result import shortly
from kousoku.runtime.options import KINEMATICS

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from kousoku.runtime.error_estimate import ErrorEstimate
    from kousoku.runtime.options import Options

#: What a healthy run may lose, in tolerances, in each thousand steps.
HEALTHY, PER_STEPS = 100.0, 1000.0
#: Instead of the tolerance where steps have a fixed length: no error decides that.
FIXED = 1e-9
#: The least tolerance of corrections: near singular configurations they have more of rounding.
LEAST = 1e-11
#: What energies are known to, and constraints, relative to what they are compared with.
ROUNDING = 1e-12
#: An energy that is no motion: that of heat, of one freedom at room temperature [J].
HEAT = 4e-21


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
        radians; None where rows were not checked.
    drift, row_drift : float or None
        Largest correction onto the constraints of a step, and of a row between steps, which the
        dense output tells, relative to a length of the scene; None where drivers lead.
    pivot_ratio : float or None
        Smallest pivot ratio: near zero at a singular configuration; None without constraints.
    error : ErrorEstimate or None
        Of all rows, where that was wanted.
    limit : float
        What the others may be, relative to what they are compared with:
        100 × tolerance × max(1, steps/1000).
    problems : tuple of str
        What is beyond its limit, and what to do; empty where nothing speaks against the run.
    """

    energy_error: float | None
    energy_moved: float | None
    work_error: float | None
    constraints: float | None
    drift: float | None
    row_drift: float | None
    pivot_ratio: float | None
    error: ErrorEstimate | None
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
        if self.pivot_ratio is not None:
            yield f"smallest pivot {shortly(self.pivot_ratio)}"
        yield "error not estimated" if self.error is None else str(self.error)

    def __str__(self) -> str:
        numbers = " · ".join(self._numbers())
        return f"trust: {numbers}" if self.is_trusted else f"not trusted: {self.why} · {numbers}"

    @property
    def why(self) -> str:
        """What speaks against the run, in one line."""
        return "; ".join(self.problems)


def trust_of(
    single: Mapping[str, float],
    options: Options,
    *,
    constraints: float | None,
    is_weighed: bool,
    released: str,
    error: ErrorEstimate | None,
) -> Trust:
    """Return the verdict on a run.

    Parameters
    ----------
    single : mapping of str to float
        The numbers of its state.
    options : Options
        How it was made.
    constraints : float or None
        Largest residual in position, relative to a length of the scene, where rows were checked.
    is_weighed : bool
        Whether energies are known.
    released : str
        The joints that came open, empty where none did.
    error : ErrorEstimate or None
        Of its rows.
    """
    is_driven = options.method == KINEMATICS
    tolerance = options.tolerance if options.step is None else FIXED
    many = HEALTHY * max(1.0, single["steps"] / PER_STEPS)
    limit, corrections = many * tolerance, many * max(tolerance, LEAST)
    knows_energy = options.checks and is_weighed
    lost, moved, missed = (
        single[name] if knows_energy else None
        for name in ("energy_error", "energy_moved", "work_error")
    )
    missed = missed if is_driven else None
    drift, row_drift = (None if is_driven else single[name] for name in ("drift", "row_drift"))
    advice = "a smaller step" if options.step is not None else "a smaller tolerance or largest_step"
    advice = "a smaller largest_step, or more rows" if is_driven else advice
    problems, beyond = [], []
    if single["not_finite"]:
        problems.append(
            f"numbers of rows are not finite, of {single['not_finite']:.0f} in all, first at t ="
            f" {single['not_finite_time']:.9g} s: a formula has no value there; ask for other"
            " times, or write it without the quotient that is 0/0"
        )
    if released:
        problems.append(f"{released} came open: this is not the motion of the scene")
    if lost is not None and moved is not None:
        known = ROUNDING * max(abs(single["energy"]), abs(single["potential"]), moved)
        allowed = max(limit * moved, known, HEAT)
        if not lost <= allowed:
            beyond.append(
                f"energy is off by {shortly(lost)} J of {shortly(moved, 2)} J, wanted at most"
                f" {shortly(allowed)} J"
            )
        # without signs, so that errors of steps add up that are none in all
        allowed = max(allowed, single["steps"] * tolerance * moved)
        if missed is not None and not missed <= allowed:
            beyond.append(
                f"works are off by {shortly(missed)} J of {shortly(moved, 2)} J, as positions"
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
    if error is not None and error.unknown_from is not None:
        problems.append(error.unknown)
    has_pivots = single["factorisations"] > 0
    return Trust(
        energy_error=lost,
        energy_moved=moved,
        work_error=missed,
        constraints=constraints,
        drift=drift,
        row_drift=row_drift,
        pivot_ratio=single["least_pivot_ratio"] if has_pivots else None,
        error=error,
        limit=limit,
        problems=tuple(problems),
    )
