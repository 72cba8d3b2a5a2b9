"""CasADi: CVODES on explicit equations, IDAS on those of index 1 with their multipliers."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from tests.benchmarks.kit import required

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.model.numbers.real import Array
    from tests.benchmarks.peers.equations import StateEquations

MOST_STEPS = 10_000_000


def cvodes(
    equations: StateEquations, tolerance: float, times: Array
) -> tuple[Callable[[], object], Callable[[], Array]]:
    """Functions that run to the last time, and that give the states at all times."""
    ca = required("casadi")
    state = ca.MX.sym("x", len(equations.start))
    rate = ca.densify(equations.explicit)
    function = ca.Function("f", [equations.x], [rate], {"cse": True})
    return _both("cvodes", {"x": state, "ode": function(state)}, equations, {}, tolerance, times)


def idas(
    equations: StateEquations, tolerance: float, times: Array
) -> tuple[Callable[[], object], Callable[[], Array]]:
    """The same by IDAS, which gets v̇ and the multipliers as algebraic variables.

    Steps are controlled by positions and velocities alone, as its manual advises for index 1.
    """
    ca = required("casadi")
    unknown = ca.SX.sym("z", equations.right.numel())
    moving = equations.x.numel() - equations.q_dot.numel()
    dae = {
        "x": equations.x,
        "z": unknown,
        "ode": ca.vertcat(equations.q_dot, unknown[:moving]),
        "alg": ca.mtimes(equations.matrix, unknown) - equations.right,
    }
    begin = ca.Function(
        "begin", [equations.x], [ca.densify(equations.matrix), ca.densify(equations.right)]
    )
    matrix, right = begin(equations.start)
    first = np.linalg.lstsq(np.array(matrix), np.array(right).ravel(), rcond=None)[0]
    return _both("idas", dae, equations, {"z0": first}, tolerance, times)


def _both(
    plugin: str,
    dae: dict[str, Any],
    equations: StateEquations,
    more: dict[str, Array],
    tolerance: float,
    times: Array,
) -> tuple[Callable[[], object], Callable[[], Array]]:
    ca = required("casadi")
    options: dict[str, Any] = {
        "abstol": tolerance,
        "reltol": tolerance,
        "max_num_steps": MOST_STEPS,
    }
    if plugin == "idas":
        options["suppress_algebraic"] = True
    run = ca.integrator("run", plugin, dae, 0.0, float(times[-1]), options)
    grid = ca.integrator("grid", plugin, dae, 0.0, times.tolist(), options)
    given = {"x0": equations.start, **more}
    return (lambda: run(**given)), lambda: np.array(grid(**given)["xf"]).T
