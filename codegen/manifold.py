"""Points that satisfy a constraint: Newton's iteration in 50 digits, then rounded to doubles."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from kousoku.codegen.points import is_euler_parameters
from kousoku.model.numbers.digits import CONTEXT
from kousoku.model.numbers.dual import evaluate_dual

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from kousoku.model.operations.kernel import Kernel

    #: An element of an input: the input's name and the element's index, row-major.
    InputElement = tuple[str, int]

#: Newton's iteration doubles the digits where it converges, and 50 take six; a start that takes
#: five times as many has no point near.
MOST_ITERATIONS = 30


def solve_constraint(
    kernel: Kernel, output: str, start: Mapping[str, Sequence[float]]
) -> dict[str, tuple[float, ...]] | None:
    """Point near ``start`` where an output vanishes to rounding and p·p = 1.

    Each step is the least change of all input numbers that solves the linearised equations.

    Parameters
    ----------
    kernel : Kernel
        The components of the function that holds the constraint.
    output : str
        The name of the constraint among its outputs.
    start : mapping of str to sequence of float
        Start, flat row-major.

    Returns
    -------
    dict or None
        The point in doubles; None where the iteration does not converge.
    """
    numbers = {
        (quantity.name, k): CONTEXT.mpf(start[quantity.name][k])
        for quantity in kernel.inputs
        for k in range(quantity.size)
    }
    for _ in range(MOST_ITERATIONS):
        try:
            values, rows = _equations(kernel, output, numbers)
            if max(map(abs, values)) < CONTEXT.mpf(10) ** -40:
                break
            step = _least_step(values, rows)
        except ArithmeticError:  # a pole, no real root, or rows that depend on each other
            return None
        for element, change in step.items():
            numbers[element] += change
    else:
        return None
    return {
        quantity.name: tuple(float(numbers[quantity.name, k]) for k in range(quantity.size))
        for quantity in kernel.inputs
    }


def _equations(
    kernel: Kernel, output: str, numbers: Mapping[InputElement, Any]
) -> tuple[list[Any], list[dict[InputElement, Any]]]:
    """Residuals and sparse rows of their derivatives: the constraint, then p·p = 1."""
    arrays = {q.name: [numbers[q.name, k] for k in range(q.size)] for q in kernel.inputs}
    duals = evaluate_dual(kernel, arrays)[output]
    values = [dual.value for dual in duals]
    rows = [dict(dual.gradient) for dual in duals]
    for quantity in filter(is_euler_parameters, kernel.inputs):
        p = {(quantity.name, k): numbers[quantity.name, k] for k in range(quantity.size)}
        values.append(sum(x**2 for x in p.values()) - 1)
        rows.append({element: 2 * x for element, x in p.items()})
    return values, rows


def _least_step(
    values: Sequence[Any], rows: Sequence[Mapping[InputElement, Any]]
) -> dict[InputElement, Any]:
    """Minimum-norm x with J x = −values: x = Jᵀ (J Jᵀ)⁻¹ (−values)."""
    count = len(rows)
    square = CONTEXT.matrix(count, count)
    for i in range(count):
        for j in range(count):
            square[i, j] = sum(x * rows[j].get(k, 0) for k, x in rows[i].items())
    multipliers = CONTEXT.lu_solve(square, CONTEXT.matrix([-value for value in values]))
    step: dict[InputElement, Any] = {}
    for multiplier, row in zip(multipliers, rows, strict=True):
        for element, derivative in row.items():
            step[element] = step.get(element, 0) + multiplier * derivative
    return step
