"""heyoka: Taylor series of high order, just-in-time compiled, from equations that are given."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from tests.benchmarks.kit import required

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.model.numbers.real import Array
    from tests.benchmarks.peers.equations import StateEquations


def translated(expression: Any, x: Any) -> tuple[list[Any], list[Any]]:
    """Variables and expressions of heyoka for one of CasADi, operation by operation."""
    ca, hy = required("casadi"), required("heyoka")
    function = ca.Function("f", [x], [ca.densify(expression)], {"cse": True})
    variables = [hy.expression(f"x{i}") for i in range(x.numel())]
    one: dict[int, Callable[[Any], Any]] = {
        ca.OP_SIN: hy.sin,
        ca.OP_COS: hy.cos,
        ca.OP_SQRT: hy.sqrt,
        ca.OP_NEG: lambda a: -a,
        ca.OP_SQ: lambda a: a * a,
        ca.OP_TWICE: lambda a: 2.0 * a,
        ca.OP_INV: lambda a: 1.0 / a,
        ca.OP_ASSIGN: lambda a: a,
    }
    two: dict[int, Callable[[Any, Any], Any]] = {
        ca.OP_ADD: lambda a, b: a + b,
        ca.OP_SUB: lambda a, b: a - b,
        ca.OP_MUL: lambda a, b: a * b,
        ca.OP_DIV: lambda a, b: a / b,
    }
    values: dict[int, Any] = {}
    results: list[Any] = [None] * expression.numel()
    for k in range(function.n_instructions()):
        kind = function.instruction_id(k)
        out, into = function.instruction_output(k), function.instruction_input(k)
        if kind == ca.OP_CONST:
            values[out[0]] = hy.expression(function.instruction_constant(k))
        elif kind == ca.OP_INPUT:
            values[out[0]] = variables[into[1]]
        elif kind == ca.OP_OUTPUT:
            results[out[1]] = values[into[0]]
        elif kind in one:
            values[out[0]] = one[kind](values[into[0]])
        else:
            values[out[0]] = two[kind](values[into[0]], values[into[1]])
    return variables, results


def integrator(equations: StateEquations, tolerance: float, *, compact: bool = False) -> Any:
    """Heyoka's adaptive integrator; compact code compiles faster and runs slower."""
    hy = required("heyoka")
    variables, rates = translated(equations.explicit, equations.x)
    system = list(zip(variables, rates, strict=True))
    start = equations.start.tolist()
    return hy.taylor_adaptive(system, start, tol=tolerance, compact_mode=compact)


def runs(
    equations: StateEquations, tolerance: float, times: Array, *, compact: bool = False
) -> tuple[Callable[[], object], Callable[[], Array]]:
    """Functions that run to the last time, and that give the states at all times."""
    hy = required("heyoka")
    made = integrator(equations, tolerance, compact=compact)
    end = float(times[-1])

    def begin() -> None:
        made.time = 0.0
        made.state[:] = equations.start

    def run() -> None:
        begin()
        outcome = made.propagate_until(end)[0]
        if outcome != hy.taylor_outcome.time_limit:
            raise ArithmeticError(f"heyoka stops: {outcome}")

    def states() -> Array:
        begin()
        return np.array(made.propagate_grid(np.concatenate([[0.0], times]))[-1])[1:]

    return run, states
