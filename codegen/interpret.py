"""Evaluate a kernel without emitting it: in doubles, arrays, fractions or 50 digits."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from math import isqrt
from typing import TYPE_CHECKING, Any, Generic, TypeVar

import mpmath
import numpy as np

from kousoku.codegen.graph import Op

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from kousoku.codegen.graph import Node
    from kousoku.codegen.kernel import Kernel

Number = TypeVar("Number")

#: mpmath with 50 digits, apart from the context that other code may set.
HIGH_CONTEXT = mpmath.mp.clone()
HIGH_CONTEXT.dps = 50


@dataclass(frozen=True, slots=True)
class Arithmetic(Generic[Number]):
    """A kind of numbers: what the operators + − × ÷ of Python leave open.

    Parameters
    ----------
    number : callable
        Turns the exact value of a constant into a number, rounding once.
    sqrt, sin, cos, atan2, exp, log, abs, max : callable
        The functions of the graph; angles in radians.
    """

    number: Callable[[Fraction], Number]
    sqrt: Callable[[Number], Number]
    sin: Callable[[Number], Number]
    cos: Callable[[Number], Number]
    atan2: Callable[[Number, Number], Number]
    exp: Callable[[Number], Number]
    log: Callable[[Number], Number]
    abs: Callable[[Number], Number]
    max: Callable[[Number, Number], Number]


def _exact_sqrt(value: Fraction) -> Fraction:
    root = Fraction(isqrt(value.numerator), isqrt(value.denominator))
    if root * root != value:
        raise ArithmeticError(f"{value} has no rational square root")
    return root


def _not_rational(*_: Fraction) -> Fraction:
    raise ArithmeticError("angle functions, powers of e and logarithms are not rational")


#: Python floats; a division by zero raises, as it does in Python.
FLOAT: Arithmetic[float] = Arithmetic(
    float, math.sqrt, math.sin, math.cos, math.atan2, math.exp, math.log, abs, max
)

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

#: Exact fractions; a root of what is not a square raises.
EXACT: Arithmetic[Fraction] = Arithmetic(
    Fraction,
    _exact_sqrt,
    _not_rational,
    _not_rational,
    _not_rational,
    _not_rational,
    _not_rational,
    abs,
    max,
)

#: Numbers of :data:`HIGH_CONTEXT`, 50 digits.
HIGH: Arithmetic[Any] = Arithmetic(
    lambda value: HIGH_CONTEXT.mpf(value.numerator) / value.denominator,
    HIGH_CONTEXT.sqrt,
    HIGH_CONTEXT.sin,
    HIGH_CONTEXT.cos,
    HIGH_CONTEXT.atan2,
    HIGH_CONTEXT.exp,
    HIGH_CONTEXT.log,
    abs,
    max,
)


def evaluate(
    kernel: Kernel, inputs: Mapping[str, Sequence[Number]], arithmetic: Arithmetic[Number]
) -> dict[str, tuple[Number, ...]]:
    """Return the outputs of a kernel.

    Parameters
    ----------
    kernel : Kernel
        What is evaluated, every node of it in the order of the text.
    inputs : mapping of str to sequence
        For each input its elements, flat row-major.
    arithmetic : Arithmetic
        The numbers that ``inputs`` holds: :data:`FLOAT`, :data:`ARRAY`, :data:`EXACT` or
        :data:`HIGH`.

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
    """Return the values of all nodes of a kernel, as :func:`evaluate` does for its outputs."""
    values: list[Any] = []
    for node in kernel.nodes:
        op, args, _, symbol = node
        # This runs a million times where a scene is looked at: names of members are looked up once.
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


def _rare(node: Node, args: Sequence[Any], arithmetic: Arithmetic[Any]) -> Any:
    if node.op is Op.CONST:
        return arithmetic.number(node.value or Fraction(0))
    if node.op is Op.DIV:
        return args[0] / args[1]
    return getattr(arithmetic, node.op.value)(*args)
