"""Evaluate a kernel without emitting it: in doubles, arrays, fractions or 50 digits."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING, Any

import numpy as np

from kousoku.model.operations.arithmetic import Arithmetic
from kousoku.model.operations.graph import Op

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from typing import TypeVar

    from kousoku.model.operations.graph import OperationNode
    from kousoku.model.operations.kernel import Kernel

    Number = TypeVar("Number")

#: NumPy arrays and NumPy doubles, elementwise, with the infinities and NaNs of IEEE 754.
ARRAY: Arithmetic[Any] = Arithmetic(
    lambda value: np.float64(float(value)),
    np.sqrt,
    np.sin,
    np.cos,
    np.arctan2,
    np.exp,
    np.log,
    np.abs,
    np.fmax,
)


def evaluate(
    kernel: Kernel, inputs: Mapping[str, Sequence[Number]], arithmetic: Arithmetic[Number]
) -> dict[str, tuple[Number, ...]]:
    """Outputs of a kernel.

    Parameters
    ----------
    kernel : Kernel
        What is evaluated, every node of it in the order of the text.
    inputs : mapping of str to sequence
        For each input its elements, flat row-major.
    arithmetic : Arithmetic
        The numbers that ``inputs`` holds: of :mod:`kousoku.model.operations.arithmetic`,
        :data:`ARRAY`, or 50 digits of :mod:`kousoku.model.numbers.digits`.

    Returns
    -------
    dict
        For each output its elements, flat row-major.
    """
    values = node_values(kernel, inputs, arithmetic)
    return {
        quantity.name: tuple(values[node] for node in result)
        for quantity, result in zip(kernel.outputs, kernel.results, strict=True)
    }


def node_values(
    kernel: Kernel, inputs: Mapping[str, Sequence[Number]], arithmetic: Arithmetic[Number]
) -> list[Number]:
    """Values of all nodes of a kernel, as :func:`evaluate` does for its outputs."""
    values: list[Any] = []
    for node in kernel.nodes:
        op, args, symbol = node.op, node.args, node.symbol
        # This runs a million times where a scene is analysed: names of members are looked up once.
        if op is _MUL:
            value = values[args[0]] * values[args[1]]
        elif op is _ADD:
            value = values[args[0]] + values[args[1]]
        elif op is _SUB:
            value = values[args[0]] - values[args[1]]
        elif op is _NEG:
            value = -values[args[0]]
        elif symbol is not None:
            value = inputs[symbol[0]][symbol[1]]
        else:
            value = _rare(node, [values[arg] for arg in args], arithmetic)
        values.append(value)
    return values


_ADD, _SUB, _MUL, _NEG = Op.ADD, Op.SUB, Op.MUL, Op.NEG


def _rare(node: OperationNode[int], args: Sequence[Any], arithmetic: Arithmetic[Any]) -> Any:
    if node.op is Op.CONST:
        return arithmetic.number(node.value or Fraction(0))
    if node.op is Op.DIV:
        return args[0] / args[1]
    return getattr(arithmetic, node.op.value)(*args)
