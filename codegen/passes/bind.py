"""Give inputs of a kernel their numbers, exactly, and fold what follows from them."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from math import isqrt
from typing import TYPE_CHECKING

import mpmath

from kousoku.codegen.graph import Graph, Op
from kousoku.codegen.passes.rebuild import copy_node, finish, live_ids
from kousoku.model.errors import EmitError

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from kousoku.codegen.graph import Node
    from kousoku.codegen.kernel import Kernel

    Number = Fraction | int | float

#: Bits to which a root or an angle function of constants is rounded, far more than any target has.
FOLDED_BITS = 200


def bind(kernel: Kernel, constants: Mapping[str, Sequence[Number | None]]) -> Kernel:
    """Return the kernel with constants in place of inputs.

    Parameters
    ----------
    kernel : Kernel
        The kernel to specialise.
    constants : mapping of str to sequence
        For each bound input its elements, flat row-major; a float stands for its exact binary
        value, None leaves an element an argument.

    Returns
    -------
    Kernel
        Without the inputs that are bound whole. Zeros and ones fold away; sums, products and
        quotients of constants are exact, roots and angle functions of them are rounded to 200 bits.

    Raises
    ------
    EmitError
        A name is not an input of the kernel, or the count of its elements is another.
    """
    _check_constants(kernel, constants)
    graph = Graph()
    new_ids: dict[int, int] = {}
    for old in live_ids(kernel.nodes, (node for result in kernel.results for node in result)):
        node = kernel.nodes[old]
        bound = _bound_value(node, constants)
        new = copy_node(graph, node, new_ids) if bound is None else graph.const(bound)
        new_ids[old] = _fold(graph, new)
    kept = tuple(q for q in kernel.inputs if q.name not in constants or None in constants[q.name])
    return finish(replace(kernel, inputs=kept), graph, new_ids)


def _check_constants(kernel: Kernel, constants: Mapping[str, Sequence[Number | None]]) -> None:
    sizes = {quantity.name: quantity.size for quantity in kernel.inputs}
    for name, values in constants.items():
        if name not in sizes:
            raise EmitError(
                f"kernel {kernel.name} has no input {name} to bind; it has {', '.join(sizes)}"
            )
        if len(values) != sizes[name]:
            raise EmitError(
                f"input {name} of kernel {kernel.name} has {sizes[name]} elements, "
                f"got {len(values)} to bind"
            )


def _bound_value(node: Node, constants: Mapping[str, Sequence[Number | None]]) -> Number | None:
    if node.symbol is None or node.symbol[0] not in constants:
        return None
    name, index = node.symbol
    return constants[name][index]


def _fold(graph: Graph, node: int) -> int:
    """Return the constant that a root or an angle function of constants is, else ``node``."""
    op = graph.nodes[node].op
    values = [value for arg in graph.nodes[node].args if (value := graph.value(arg)) is not None]
    if op is Op.SQRT and values and values[0] >= 0:
        return graph.const(_square_root(values[0]))
    if op in {Op.SIN, Op.COS} and values:
        function = mpmath.sin if op is Op.SIN else mpmath.cos
        return graph.const(_rounded(function, values))
    if op is Op.ATAN2 and len(values) == 2 and any(values):
        return graph.const(_rounded(mpmath.atan2, values))
    return node


def _square_root(value: Fraction) -> Fraction:
    root = Fraction(isqrt(value.numerator), isqrt(value.denominator))
    return root if root * root == value else _rounded(mpmath.sqrt, [value])


def _rounded(function: Callable[..., mpmath.mpf], values: Sequence[Fraction]) -> Fraction:
    """Return a function of exact numbers, rounded once to :data:`FOLDED_BITS`.

    It is computed with twice the bits, so that the rounding does not depend on which arithmetic
    mpmath found on the machine.
    """
    with mpmath.workprec(2 * FOLDED_BITS):
        result = function(*(mpmath.mpf(v.numerator) / v.denominator for v in values))
    with mpmath.workprec(FOLDED_BITS):
        sign, mantissa, exponent, _ = (+result)._mpf_
    magnitude = Fraction(int(mantissa)) * Fraction(2) ** int(exponent)
    return -magnitude if sign else magnitude
