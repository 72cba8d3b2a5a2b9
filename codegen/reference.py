"""Reference values for emitted code, in 50 digits, with the unit of its error.

They are computed with so many digits that 50 remain after the cancellation of terms that are larger
by any power of two in the points.

They come from the scalar formulas of the derivation, which do not use the matrix level that is
frozen and emitted.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from kousoku.codegen.error_unit import columns
from kousoku.codegen.freeze_components import freeze_components
from kousoku.codegen.known_errors import known_errors, units_off
from kousoku.codegen.manifold import solve_constraint
from kousoku.codegen.points import (
    EvaluationPoint,
    finite_points,
    infinite_points,
    ordinary,
    scattered,
)
from kousoku.codegen.sha256_random import Sha256Random
from kousoku.codegen.states import coincident_points, motion_points
from kousoku.model.errors import DerivationError
from kousoku.model.files.jsontext import to_text
from kousoku.model.files.manifest import REFERENCE_FORMATS
from kousoku.model.numbers.digits import CONTEXT
from kousoku.model.numbers.dual import Dual, evaluate_dual

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.codegen.known_errors import KnownError
    from kousoku.model.operations.kernel import Kernel, Package
    from kousoku.symbolic.derivation import DerivedOutput, Function

#: Count of starts from which the constraint manifold is sought.
MOST_STARTS = 8
#: Output whose zeros are the constraint manifold.
CONSTRAINT = "C"
#: Enough for 50 digits after a cancellation of 2^±900 against its inverse.
WORKING_DIGITS = 600
#: Numbers of reference that one kernel brings at most, unless one round of points is more.
MOST_NUMBERS = 600
MOST_ROUNDS = 2
#: The same where each input gets a round in which it is scaled, zero and subnormal.
MOST_NUMBERS_OF_ALL_ROUNDS = 2400


def references(
    package: Package, functions: Sequence[Function], *, is_thorough: bool = False
) -> str:
    """Text of the reference values.

    Parameters
    ----------
    package : Package
        The frozen kernels; they say which elements are identically zero.
    functions : sequence of Function
        Functions that the kernels were frozen from, in the same order.
    is_thorough : bool
        Whether each input of a kernel has a round, where that is not too many numbers.

    Returns
    -------
    str
        For each kernel its points, for each point the inputs (numbers that are not finite as
        ``"nan"``, ``"inf"``, ``"-inf"``) and for each output, over the elements that are not
        identically zero, lists ``high``, ``low`` and ``unit``: the value is high + low to about 21
        digits, and an error is told in units of u·(|f| + Σ|x_i ∂f/∂x_i|), u = 2⁻⁵³, at least the
        smallest subnormal. Where ``high`` is null the output must not be finite.

    Raises
    ------
    DerivationError
        The frozen kernel has a zero where the component level has none.
    """
    with CONTEXT.workdps(WORKING_DIGITS):
        kernels = _kernels(package, functions, is_thorough)
    return to_text(
        {"format": REFERENCE_FORMATS["kind"], "package": package.name, "kernels": kernels}
    )


def _kernels(
    package: Package, functions: Sequence[Function], is_thorough: bool
) -> list[dict[str, object]]:
    frozen = [freeze_components(function) for function in functions]
    kernels: list[dict[str, object]] = []
    for kernel, function, components in zip(package.kernels, functions, frozen, strict=True):
        points = _points(function, components, frozen, is_thorough)
        evaluated = [(point, values_at(kernel, function, components, point)) for point in points]
        valid = [(point, values) for point, values in evaluated if values is not None]
        if not any(_is_finite(point) for point, _ in valid):
            raise DerivationError(
                f"kernel {kernel.name} has a pole or no real root at every point that was tried, "
                "with inputs of order one; state it so that it holds for such inputs"
            )
        off_points = [
            _known_error_point(kernel, function, components, error)
            for error in known_errors(package, kernel.name)
        ]
        rows = [values for _, values in valid] + off_points
        kernels.append({"name": kernel.name, "points": rows})
    return kernels


def _known_error_point(
    kernel: Kernel, function: Function, components: Kernel, error: KnownError
) -> dict[str, object]:
    """Point at which errors of outputs are above the common limit, with limits of its own.

    Raises
    ------
    DerivationError
        An error is larger than is known.
    """
    point = EvaluationPoint("known to be off", error.inputs)
    values: dict[str, Any] | None = values_at(kernel, function, components, point)
    assert values is not None
    for output, units in error.units.items():
        units_found = units_off(kernel, output, error.inputs, values["outputs"][output])
        if not units_found <= units:
            raise DerivationError(
                f"kernel {kernel.name}: {output} is {units_found:.4g} units off where {units:g} are"
                " known; mend what grew, or say in codegen.known_errors why it must be"
            )
    return values | {"limits": dict(error.units)}


def _is_finite(point: EvaluationPoint) -> bool:
    return all(math.isfinite(x) for xs in point.inputs.values() for x in xs)


def _points(
    function: Function, components: Kernel, package: Sequence[Kernel], is_thorough: bool
) -> list[EvaluationPoint]:
    """Points of one function, fewer of them where it has many outputs."""
    stream = Sha256Random(function.name)
    numbers = 10 * sum(output.quantity.size for output in function.outputs)
    rounds = min(MOST_ROUNDS, MOST_NUMBERS // numbers)
    if is_thorough:
        rounds = min(len(function.inputs), MOST_NUMBERS_OF_ALL_ROUNDS // numbers)
    points: list[EvaluationPoint] = []
    for pick in range(max(1, rounds)):
        points += finite_points(components, stream, pick)
        points += _manifold_points(function, package, stream)
        points += motion_points(function.inputs, Sha256Random(f"{function.name} {pick}"), pick)
    if all(output.at_pole is not None for output in function.outputs):
        points += coincident_points(function.inputs, Sha256Random(f"{function.name} pole"))
    return points + infinite_points(components, stream)


def _manifold_points(
    function: Function, package: Sequence[Kernel], stream: Sha256Random
) -> list[EvaluationPoint]:
    """Point on the constraint manifold of the package, and one near it."""
    for other in package:
        if CONSTRAINT in (output.name for output in other.outputs):
            solution = _solution(other, stream)
            if solution is not None:
                names = [quantity.name for quantity in function.inputs]
                shared = {name: solution[name] for name in names if name in solution}
                on_manifold = {**ordinary(function.inputs, stream), **shared}
                near_manifold = {**on_manifold, **scattered(shared, stream, -33)}
                return [
                    EvaluationPoint("on the manifold", on_manifold),
                    EvaluationPoint("near the manifold", near_manifold),
                ]
    return []


def _solution(components: Kernel, stream: Sha256Random) -> dict[str, tuple[float, ...]] | None:
    """Point on the constraint manifold, None where no start leads there."""
    # Only the first start takes from the stream: later points are the same however many it takes.
    streams = (stream, *(Sha256Random(f"start {number}") for number in range(1, MOST_STARTS)))
    for start_stream in streams:
        start = ordinary(components.inputs, start_stream)
        solution = solve_constraint(components, CONSTRAINT, start)
        if solution is not None:
            return solution
    return None


def values_at(
    kernel: Kernel, function: Function, components: Kernel, point: EvaluationPoint
) -> dict[str, object] | None:
    """Point with its references, None where an output has no value by chance."""
    nonfinite = [
        (name, k)
        for name, xs in point.inputs.items()
        for k, x in enumerate(xs)
        if not math.isfinite(x)
    ]
    # In place of an input that is not finite, any number shows which outputs depend on it; the
    # others do not change with it.
    finite = {
        name: [x if math.isfinite(x) else 1.25 for x in xs] for name, xs in point.inputs.items()
    }
    numbers = {(name, k): CONTEXT.mpf(x) for name, xs in finite.items() for k, x in enumerate(xs)}
    try:
        duals = evaluate_dual(components, finite)
    except ArithmeticError:
        if any(output.at_pole is None for output in function.outputs):
            return None
        duals = {output.quantity.name: _documented(output) for output in function.outputs}
    outputs = {}
    for k, quantity in enumerate(kernel.outputs):
        _check_zeros(kernel, k, duals[quantity.name])
        chosen = [duals[quantity.name][element] for element in kernel.nonzero(k)]
        outputs[quantity.name] = columns(chosen, numbers, nonfinite)
    inputs = {name: [_json_number(x) for x in xs] for name, xs in point.inputs.items()}
    return {"label": point.label, "inputs": inputs, "outputs": outputs}


def _documented(output: DerivedOutput) -> tuple[Dual, ...]:
    """Documented values of an output where its formula has a pole."""
    assert output.at_pole is not None
    return (Dual(CONTEXT.mpf(output.at_pole), {}),) * output.quantity.size


def _json_number(x: float) -> float | str:
    return x if math.isfinite(x) else str(x)


def _check_zeros(kernel: Kernel, output: int, duals: Sequence[Dual]) -> None:
    nonzero = kernel.nonzero(output)
    for element, dual in enumerate(duals):
        if element not in nonzero and abs(dual.value) > 0:
            raise DerivationError(
                f"element {element} of {kernel.outputs[output].name} in kernel {kernel.name} is"
                f" frozen to zero, and the component level gives {float(dual.value)}"
            )
