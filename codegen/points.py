"""Adverse points: where emitted code would go wrong if it could.

The numbers come from a stream of SHA-256 digests, so that they are the same on every machine and
under every version of NumPy.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from kousoku.model.numbers.digits import CONTEXT
from kousoku.model.numbers.real import SMALLEST_SUBNORMAL
from kousoku.model.operations.graph import Op

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from kousoku.codegen.sha256_random import Sha256Random
    from kousoku.model.files.quantity import Quantity
    from kousoku.model.operations.graph import OperationNode
    from kousoku.model.operations.kernel import Kernel

    Numbers = Mapping[str, tuple[float, ...]]

#: No array is scaled by more than 2^±200, about 1e±60.
LARGEST_EXPONENT = 200
#: Products of scaled arrays stay within 2^±900, so that no intermediate result leaves the doubles.
EXPONENT_BUDGET = 900
#: A subnormal number that stays a multiple of the smallest one when divided by 4 a few times.
SUBNORMAL = SMALLEST_SUBNORMAL * 2**20


@dataclass(frozen=True, slots=True)
class EvaluationPoint:
    """Inputs of one evaluation.

    Parameters
    ----------
    label : str
        Kind of the point.
    inputs : mapping of str to tuple of float
        For each input its elements, flat row-major.
    """

    label: str
    inputs: Numbers


def is_euler_parameters(quantity: Quantity) -> bool:
    """Whether an input is the Euler parameters of a body, which a solver keeps at unit norm."""
    return quantity.shape == (4,) and (quantity.name == "p" or quantity.name.startswith("p_"))


def unit(p: Sequence[float]) -> tuple[float, ...]:
    """Unit vector of ``p``, rounded once."""
    norm = CONTEXT.sqrt(sum(CONTEXT.mpf(x) ** 2 for x in p))
    return tuple(float(x / norm) for x in p)


def ordinary(inputs: Sequence[Quantity], stream: Sha256Random) -> dict[str, tuple[float, ...]]:
    """Numbers of order one: masses, lengths and angles positive, p of unit norm."""
    numbers = {}
    for quantity in inputs:
        is_positive = not quantity.shape or quantity.unit.startswith("kg")
        values = tuple(
            stream.magnitude() * (1 if is_positive else stream.sign()) for _ in range(quantity.size)
        )
        numbers[quantity.name] = unit(values) if is_euler_parameters(quantity) else values
    return numbers


def scattered(
    numbers: Numbers, stream: Sha256Random, exponent: int
) -> dict[str, tuple[float, ...]]:
    """``numbers``, each with a relative change of about 2^exponent."""
    return {
        name: tuple(x * (1 + stream.sign() * math.ldexp(stream.magnitude(), exponent)) for x in xs)
        for name, xs in numbers.items()
    }


def finite_points(components: Kernel, stream: Sha256Random, pick: int) -> list[EvaluationPoint]:
    """Points at which every output is finite: one of each sort, another at each pick.

    Parameters
    ----------
    components : Kernel
        Formulas of the function, which bound the scales of its inputs.
    stream : Sha256Random
        Source of the digits.
    pick : int
        Index of the array or axis, for sorts that pick one.
    """
    inputs = components.inputs

    def ordinary_numbers() -> dict[str, tuple[float, ...]]:
        return ordinary(inputs, stream)

    points = [
        EvaluationPoint("ordinary", ordinary_numbers()),
        EvaluationPoint(
            "badly scaled arrays", _scaled_arrays(components, ordinary_numbers(), stream, pick)
        ),
        EvaluationPoint(
            "badly scaled elements", _scaled_elements(components, ordinary_numbers(), stream)
        ),
        EvaluationPoint("nearly coincident", _coincident(inputs, ordinary_numbers(), stream)),
        EvaluationPoint(
            "near half a turn, near an axis", _degenerate(inputs, ordinary_numbers(), pick)
        ),
        EvaluationPoint("small integers", _integers(inputs, stream)),
    ]
    vanishing = inputs[pick % len(inputs)]
    zeros = {vanishing.name: (0.0,) * vanishing.size}
    points.append(EvaluationPoint(f"{vanishing.name} is zero", ordinary_numbers() | zeros))
    if any(map(is_euler_parameters, inputs)):
        points.append(
            EvaluationPoint("p not normalised", _unnormalised(inputs, ordinary_numbers(), stream))
        )
    if group := _subnormal_group(components, pick):
        numbers = _integers(inputs, stream) | _powers_of_two(components, stream)
        tiny = {name: tuple(x * SUBNORMAL for x in numbers[name]) for name in group}
        points.append(EvaluationPoint(f"subnormal {', '.join(group)}", {**numbers, **tiny}))
    return points


def infinite_points(components: Kernel, stream: Sha256Random) -> list[EvaluationPoint]:
    """Points with one number that is not finite.

    An infinity is left out where results of it can be finite, as with 1/∞.
    """
    inputs = components.inputs
    has_limits = any(node.op in {Op.DIV, Op.ATAN2} for node in components.nodes)
    nonfinite = (math.nan,) if has_limits else (math.nan, math.inf, -math.inf)
    points = []
    for number, bad in enumerate(nonfinite):
        quantity = inputs[(stream.integer(16) + number) % len(inputs)]
        index = stream.between(0, quantity.size - 1)
        numbers = ordinary(inputs, stream)
        values = list(numbers[quantity.name])
        values[index] = bad
        numbers[quantity.name] = tuple(values)
        points.append(EvaluationPoint(f"{quantity.name}[{index}] is {bad}", numbers))
    return points


def _scaled_arrays(
    components: Kernel, numbers: Numbers, stream: Sha256Random, pick: int
) -> dict[str, tuple[float, ...]]:
    """Scale one array as far as doubles allow, all others by the remaining exponents."""
    array_degrees = degrees(components)
    names = [name for name in numbers if array_degrees[name]]
    budget = EXPONENT_BUDGET
    exponents = dict.fromkeys(numbers, 0)
    if names:
        first = names[pick % len(names)]
        exponents[first] = min(LARGEST_EXPONENT, budget // array_degrees[first])
        budget -= exponents[first] * array_degrees[first]
        other_degrees = sum(array_degrees[name] for name in names if name != first)
        for name in names:
            if name != first:
                exponents[name] = min(LARGEST_EXPONENT, budget // other_degrees)
    scales = {name: stream.sign() * exponent for name, exponent in exponents.items()}
    return {name: tuple(math.ldexp(x, scales[name]) for x in xs) for name, xs in numbers.items()}


def _scaled_elements(
    components: Kernel, numbers: Numbers, stream: Sha256Random
) -> dict[str, tuple[float, ...]]:
    """Scale each number on its own."""
    largest = min(LARGEST_EXPONENT, EXPONENT_BUDGET // max(1, sum(degrees(components).values())))
    return {
        name: tuple(math.ldexp(x, stream.between(-largest, largest)) for x in xs)
        for name, xs in numbers.items()
    }


def _coincident(
    inputs: Sequence[Quantity], numbers: Numbers, stream: Sha256Random
) -> dict[str, tuple[float, ...]]:
    """Let body j be almost where body i is; without a body j, all elements almost equal.

    Directions keep apart: where they coincide too, a scalar product vanishes together with all its
    derivatives, and the unit, which is of first order, bounds nothing any more.
    """
    close = scattered(numbers, stream, -30)
    twins = {
        q.name: "_".join("i" if part == "j" else part for part in q.name.split("_"))
        for q in inputs
        if "j" in q.name.split("_") and (q.unit != "-" or is_euler_parameters(q))
    }
    if any(twin in numbers for twin in twins.values()):
        return {
            name: close[twins[name]] if twins.get(name) in numbers else xs
            for name, xs in numbers.items()
        }
    return {
        name: tuple(abs(xs[0]) * (1 + math.ldexp(x, -30)) for x in xs)
        for name, xs in numbers.items()
    }


def _degenerate(
    inputs: Sequence[Quantity], numbers: Numbers, pick: int
) -> dict[str, tuple[float, ...]]:
    """Let orientations be almost half a turn, angles almost a quarter, vectors almost an axis."""
    chosen = {}
    for k, quantity in enumerate(inputs):
        values = numbers[quantity.name]
        if is_euler_parameters(quantity):
            chosen[quantity.name] = unit((math.ldexp(values[0], -30), *values[1:]))
        elif quantity.unit == "rad" and not quantity.shape:
            chosen[quantity.name] = (float(CONTEXT.pi * (pick + k + 1) / 2),)
        elif quantity.size > 1:
            axis = (pick + k) % quantity.size
            chosen[quantity.name] = tuple(
                x if n == axis else math.ldexp(x, -27 * (1 + n % 2)) for n, x in enumerate(values)
            )
        else:
            chosen[quantity.name] = values
    return chosen


def _integers(inputs: Sequence[Quantity], stream: Sha256Random) -> dict[str, tuple[float, ...]]:
    """Integers of ±(1 … 4), positive where ordinary numbers are."""
    return {
        quantity.name: tuple(float(stream.between(1, 4) * (-1 if x < 0 else 1)) for x in values)
        for quantity in inputs
        for values in (ordinary([quantity], stream)[quantity.name],)
    }


def _powers_of_two(components: Kernel, stream: Sha256Random) -> dict[str, tuple[float, ...]]:
    """Powers of two for the numbers under a quotient, 1, 2 or 4, so that it stays exact."""
    curved = curved_inputs(components)
    return {
        q.name: tuple(float(1 << stream.between(0, 2)) for _ in range(q.size))
        for q in components.inputs
        if q.name in curved and not is_euler_parameters(q)
    }


def _unnormalised(
    inputs: Sequence[Quantity], numbers: Numbers, stream: Sha256Random
) -> dict[str, tuple[float, ...]]:
    """Let the norm of Euler parameters be 1/8 … 8."""
    scales = {q.name: math.ldexp(1.0, stream.between(-3, 2)) * stream.magnitude() for q in inputs}
    return {
        q.name: tuple(
            x * (scales[q.name] if is_euler_parameters(q) else 1.0) for x in numbers[q.name]
        )
        for q in inputs
    }


def _subnormal_group(components: Kernel, pick: int) -> tuple[str, ...]:
    """Arrays that are made subnormal together: those of one unit, or a single pure one.

    The other inputs are small integers at these points and divisors powers of two, so that products
    are multiples of the smallest subnormal and the result is exact; a processor that flushes
    subnormals to zero is caught. With other numbers each product would be rounded to that multiple,
    and the count of products, not the care of the code, would decide whether it stays within the
    limit. Arrays under a root, in a quotient or in an angle are left out: their squares vanish, in
    the derivation's formula as in any code.
    """
    curved = curved_inputs(components)
    straight = [q for q in components.inputs if q.name not in curved and not is_euler_parameters(q)]
    groups = dict.fromkeys(q.name if q.unit == "-" else q.unit for q in straight)
    if not groups:
        return ()
    group = list(groups)[pick % len(groups)]
    return tuple(q.name for q in straight if group in {q.name, q.unit})


def curved_inputs(kernel: Kernel) -> tuple[str, ...]:
    """Input arrays of which a root, a quotient or an angle function is taken."""
    arrays: list[dict[str, None]] = []
    curved: dict[str, None] = {}
    for node in kernel.nodes:
        leaf = [node.symbol[0]] if node.symbol else []
        names = dict.fromkeys([*leaf, *(name for k in node.args for name in arrays[k])])
        arrays.append(names)
        if node.op in {Op.SQRT, Op.SIN, Op.COS, Op.ATAN2}:
            curved.update(names)
        elif node.op is Op.DIV:
            curved.update(arrays[node.args[1]])
    return tuple(curved)


def degrees(kernel: Kernel) -> dict[str, int]:
    """Highest degree in which any node of a kernel holds an input array, for each of them.

    Scaling the array by 2^k scales no intermediate result by more than 2^(k · degree).
    """
    node_degrees: list[dict[str, int]] = []
    for node in kernel.nodes:
        node_degrees.append({node.symbol[0]: 1} if node.symbol else _degree(node, node_degrees))
    return {q.name: max(degree.get(q.name, 0) for degree in node_degrees) for q in kernel.inputs}


def _degree(node: OperationNode[int], node_degrees: Sequence[Mapping[str, int]]) -> dict[str, int]:
    operands = [node_degrees[k] for k in node.args]
    names = dict.fromkeys(name for arg in operands for name in arg)
    if node.op in {Op.MUL, Op.DIV}:
        return {name: sum(arg.get(name, 0) for arg in operands) for name in names}
    if node.op is Op.SQRT:
        return {name: math.ceil(operands[0][name] / 2) for name in names}
    return {name: max(arg.get(name, 0) for arg in operands) for name in names}
