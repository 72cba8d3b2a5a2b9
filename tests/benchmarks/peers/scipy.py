"""SciPy: its methods for equations that are given, whose rates are compiled C."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tests.benchmarks.kit import required
from tests.benchmarks.peers.equations import caller

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.model.numbers.real import Array
    from tests.benchmarks.peers.equations import StateEquations

#: The least relative tolerance that it takes.
LEAST = 3e-14
IMPLICIT = ("Radau", "LSODA", "BDF")


def solved(
    rate: Callable[[float, Array], Array],
    start: Array,
    tolerance: float,
    times: Array,
    method: str = "DOP853",
    **more: object,
) -> tuple[Callable[[], object], Callable[[], Array]]:
    """Functions that run to the last time, and that give the states at all times."""
    integrate = required("scipy.integrate")
    end = float(times[-1])
    options = {"method": method, "rtol": max(tolerance, LEAST), "atol": tolerance, **more}

    def solution(**wanted: Array) -> Array:
        found = integrate.solve_ivp(rate, (0.0, end), start, **options, **wanted)
        if not found.success:
            raise ArithmeticError(f"SciPy stops: {found.message}")
        states: Array = found.y.T
        return states

    return solution, lambda: solution(t_eval=times)


def runs(
    equations: StateEquations, tolerance: float, times: Array, method: str = "DOP853"
) -> tuple[Callable[[], object], Callable[[], Array]]:
    """Both for equations; implicit methods get the exact Jacobian, as its manual advises."""
    more = {"jac": caller(equations, "jacobian")} if method in IMPLICIT else {}
    return solved(caller(equations), equations.start, tolerance, times, method, **more)
