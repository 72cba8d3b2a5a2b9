"""Options of a run of a solver of bodies: method, steps, parameters; checked before it begins."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, TypedDict

import numpy as np

from kousoku.model.errors import SolveError
from kousoku.runtime.integrate.initial_values import InitialValues, initial_of, parameters_of
from kousoku.runtime.integrate.run_arguments import require_steps, values_of
from kousoku.runtime.integrate.settings import (
    KINEMATICS,
    LEAST_TOLERANCES,
    MOST_STEPS,
    OPTIONS,
    Settings,
    method_for,
)
from kousoku.runtime.messages import shown

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from kousoku.runtime.dynamics import DynamicsSolver
    from kousoku.runtime.integrate.arithmetic import Array

#: Methods of scenes that move freely.
RUNGE_KUTTA = tuple(LEAST_TOLERANCES)
#: All methods, in the order of the solver's text; the last only where drivers determine the motion.
METHOD_NAMES = (*RUNGE_KUTTA, KINEMATICS)
#: All options of a run; a copied folder alone takes the others.
ALL_OPTIONS = (*OPTIONS, "strict", "estimate_error")


class RunOptions(TypedDict, total=False):
    """Options of a run, as :func:`options_of` takes them."""

    tolerance: float
    method: Literal["dopri5", "dop853", "kinematics"] | None
    step: float | None
    largest_step: float
    checks: bool
    most_steps: int
    parameters: Mapping[str, float | str] | None
    initial: Mapping[str, float | str] | None
    q0: Sequence[float] | Array | None
    v0: Sequence[float] | Array | None
    strict: bool
    estimate_error: bool


@dataclass(frozen=True, slots=True)
class Options:
    """Options of a run as a user asks for them, checked, with parameters and start of the scene.

    The integrator takes those that rule its steps as :class:`Settings`.

    Parameters
    ----------
    tolerance : float
        Local error of a step, relative to a length of the scene and to the state.
    largest_step : float [s]
        No step is longer.
    step : float or None [s]
        Steps are so long, shorter only at the end, where formulas switch or are narrow, and near
        dependent rows; no error decides.
    checks : bool
        Whether each row is checked for the ledger: constraints at three levels, and energy.
    method : {"dopri5", "dop853", "kinematics"}
        Of order 5 or 8, or position by position.
    most_steps : int
        A run that needs more is stopped.
    parameters : tuple of (str, float)
        All of the scene, in its order.
    initial : InitialValues
        Where the run starts, if not where the scene does.
    estimate_error : bool
        Whether a second run by another method tells how exact the rows are.
    strict : bool
        Whether a start is refused that assembly changed.
    """

    tolerance: float
    largest_step: float
    step: float | None
    checks: bool
    method: str
    most_steps: int
    parameters: tuple[tuple[str, float], ...]
    initial: InitialValues
    estimate_error: bool = False
    strict: bool = False

    def settings(self) -> Settings:
        """Settings that a solver takes."""
        longest = min(self.largest_step, 1e300)
        method = METHOD_NAMES.index(self.method)
        return Settings(self.tolerance, longest, self.step or 0.0, int(self.checks), method)


def options_of(
    solver: DynamicsSolver,
    *,
    tolerance: float = 1e-9,
    method: str | None = None,
    step: float | None = None,
    largest_step: float = np.inf,
    checks: bool = True,
    most_steps: int = MOST_STEPS,
    parameters: Mapping[str, float | str] | None = None,
    initial: Mapping[str, float | str] | None = None,
    q0: Sequence[float] | Array | None = None,
    v0: Sequence[float] | Array | None = None,
    strict: bool = False,
    estimate_error: bool = False,
) -> Options:
    """Options of a run.

    Parameters
    ----------
    solver : DynamicsSolver
        What moves.
    tolerance : float
        Local error of a step, relative to a length of the scene and to the state.
    method : {"dopri5", "dop853", "kinematics"}, optional
        Runge-Kutta of order 5 or 8, by the tolerance unless given; position by position where
        drivers determine the motion.
    step : float [s], optional
        Make steps so long, without control of the error; the last one may be shorter, and
        one that comes to dependent rows of the constraints is.
    largest_step : float [s]
        No step is longer.
    checks : bool
        Whether the ledger says what is left of the constraints, and how the energy changes.
    most_steps : int
        A run that needs more is stopped.
    parameters : mapping of str to float or str, optional
        Values of parameters of the scene; those that are left out keep what the scene says. Angles
        may be texts such as ``"30 deg"``.
    initial : mapping of str to float or str, optional
        Values at the start of coordinates, and of their rates as ``theta_dot``, in the unit of the
        scene; angles may be texts such as ``"30 deg"``. The scene is led there.
    q0, v0 : sequence of float, optional
        Instead of them position and velocity of all bodies, in the scene's order and unit: r of the
        body frame's origin and its Euler parameters; its velocity and ω′. Points have three each.
        Those of ``run.state(k)`` bring their turns along and, unless given, parameters.
    strict : bool
        Whether a start is refused that assembly changed, by more than 1e-6 of length and speed.
    estimate_error : bool
        Make a second run, by the other method of Runge-Kutta with a hundredth of the tolerance, or
        with shorter steps; the ledger tells the largest difference. It takes a few times as long.

    Raises
    ------
    SolveError
        An option is not possible.
    """
    require_steps(solver.name, tolerance, step, largest_step, most_steps)
    for option, flag in (
        ("checks", checks),
        ("strict", strict),
        ("estimate_error", estimate_error),
    ):
        if not isinstance(flag, bool | np.bool_):
            raise SolveError(f"{solver.name}: {option} {shown(flag)}; wanted True or False")
    step = None if step is None else float(step)
    name = method_for(tolerance, is_driven=solver.is_driven) if method is None else method
    _require_method(solver, name, step)
    values = with_values(solver, parameters_of(parameters, q0))
    if strict and not is_given_anew(solver, values):
        require_unmoved(solver)
    numbers = float(tolerance), float(largest_step), step
    started = initial_of(solver.layout, initial, q0, v0)
    flags = bool(checks), name, int(most_steps)
    return Options(*numbers, *flags, values, started, bool(estimate_error), bool(strict))


def is_given_anew(solver: DynamicsSolver, values: tuple[tuple[str, float], ...]) -> bool:
    """Whether the start depends on parameters, which are not those of the scene."""
    return bool(solver.layout.given) and values != (solver.base or solver).parameters


def require_unmoved(solver: DynamicsSolver) -> None:
    """Refuse a start that assembly changed."""
    if solver.moved:
        changed = "; ".join(f"bodies.{body} by {sizes}" for body, sizes in solver.moved.items())
        raise SolveError(
            f"{solver.name}: assembly changed the start that the scene gives: {changed}; strict"
            " refuses that: give positions and velocities that fit joints and drivers"
        )


def _require_method(solver: DynamicsSolver, name: str, step: float | None) -> None:
    possible = METHOD_NAMES if solver.is_driven else RUNGE_KUTTA
    if name not in METHOD_NAMES:
        raise SolveError(
            f"{solver.name}: method {shown(name)}; wanted one of {', '.join(possible)}"
        )
    if name not in possible:
        raise SolveError(
            f"{solver.name}: method {name!r} is for scenes whose drivers take all freedoms; this"
            f" one moves freely too: wanted {' or '.join(possible)}, or more drivers"
        )
    if name == KINEMATICS and step is not None:
        raise SolveError(
            f"{solver.name}: step {step!r}: the method {KINEMATICS!r} goes from one time to the"
            " next and needs none; ask for more times, or for another method"
        )


def with_values(
    solver: DynamicsSolver, given: Mapping[str, float | str] | None
) -> tuple[tuple[str, float], ...]:
    """All parameters of a scene, some of them with new values."""
    return tuple(values_of(solver.name, dict(solver.parameters), given).items())
