"""Points that satisfy a constraint: Newton's iteration in 50 digits, then rounded to doubles."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from kousoku.codegen.interpret import HIGH_CONTEXT
from kousoku.codegen.points import is_euler_parameters
from kousoku.codegen.tape import run

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from kousoku.codegen.tape import Tape
    from kousoku.model.quantity import Quantity

MOST_ITERATIONS = 30


def solve_constraint(
    tape: Tape, output: str, inputs: Sequence[Quantity], start: Mapping[str, Sequence[float]]
) -> dict[str, tuple[float, ...]] | None:
    """Return a point near ``start`` where an output vanishes to rounding and p·p = 1.

    Each step is the least change of all input numbers that solves the linearised equations.

    Parameters
    ----------
    tape : Tape
        The function that holds the constraint.
    output : str
        The name of the constraint among its outputs.
    inputs : sequence of Quantity
        The inputs of the function.
    start : mapping of str to sequence of float
        Where to start, flat row-major.

    Returns
    -------
    dict or None
        The point in doubles; None where the iteration does not converge.
    """
    numbers = [HIGH_CONTEXT.mpf(start[name][index]) for name, index in tape.inputs]
    for _ in range(MOST_ITERATIONS):
        try:
            values, rows = _equations(tape, output, inputs, numbers)
            if max(map(abs, values)) < HIGH_CONTEXT.mpf(10) ** -40:
                break
            step = _least_step(values, rows)
        except ArithmeticError:  # a pole, no real root, or rows that depend on each other
            return None
        for place, change in step.items():
            numbers[place] += change
    else:
        return None
    return {
        quantity.name: tuple(
            float(number)
            for number, (name, _) in zip(numbers, tape.inputs, strict=True)
            if name == quantity.name
        )
        for quantity in inputs
    }


def _equations(
    tape: Tape, output: str, inputs: Sequence[Quantity], numbers: Sequence[Any]
) -> tuple[list[Any], list[dict[int, Any]]]:
    """Return residuals and sparse rows of their derivatives: the constraint, then p·p = 1."""
    arrays: dict[str, list[Any]] = {}
    for number, (name, _) in zip(numbers, tape.inputs, strict=True):
        arrays.setdefault(name, []).append(number)
    duals = run(tape, arrays)[output]
    values = [dual.value for dual in duals]
    rows = [dict(dual.gradient) for dual in duals]
    for quantity in filter(is_euler_parameters, inputs):
        places = [k for k, (name, _) in enumerate(tape.inputs) if name == quantity.name]
        values.append(sum(numbers[k] ** 2 for k in places) - 1)
        rows.append({k: 2 * numbers[k] for k in places})
    return values, rows


def _least_step(values: Sequence[Any], rows: Sequence[Mapping[int, Any]]) -> dict[int, Any]:
    """Return the smallest x with J x = −values: x = Jᵀ (J Jᵀ)⁻¹ (−values)."""
    count = len(rows)
    square = HIGH_CONTEXT.matrix(count, count)
    for i in range(count):
        for j in range(count):
            square[i, j] = sum(x * rows[j].get(k, 0) for k, x in rows[i].items())
    multipliers = HIGH_CONTEXT.lu_solve(square, HIGH_CONTEXT.matrix([-value for value in values]))
    step: dict[int, Any] = {}
    for multiplier, row in zip(multipliers, rows, strict=True):
        for place, derivative in row.items():
            step[place] = step.get(place, 0) + multiplier * derivative
    return step
