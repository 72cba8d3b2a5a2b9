"""Dual numbers of 50 digits: values with the derivatives that references and their units need."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from kousoku.model.arithmetic import Arithmetic
from kousoku.model.digits import CONTEXT, HIGH
from kousoku.model.interpret import evaluate

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from fractions import Fraction

    from kousoku.model.kernel import Kernel

High = Any  # a number of CONTEXT: mpmath is untyped


class Dual:
    """A number and its derivatives by the numbers that it was computed from.

    Parameters
    ----------
    value : High
        The number.
    gradient : mapping of Hashable to High
        Derivatives by whatever names a number.
    """

    __slots__ = ("gradient", "value")

    def __init__(self, value: High, gradient: Mapping[Any, High]) -> None:
        self.value = value
        self.gradient = gradient

    def __add__(self, other: Dual) -> Dual:
        gradient = dict(self.gradient)
        for name, derivative in other.gradient.items():
            gradient[name] = gradient[name] + derivative if name in gradient else derivative
        return Dual(self.value + other.value, gradient)

    def __sub__(self, other: Dual) -> Dual:
        return chain(self.value - other.value, (self, 1), (other, -1))

    def __neg__(self) -> Dual:
        return chain(-self.value, (self, -1))

    def __mul__(self, other: Dual) -> Dual:
        return chain(self.value * other.value, (self, other.value), (other, self.value))

    def __truediv__(self, other: Dual) -> Dual:
        quotient = self.value / other.value
        return chain(quotient, (self, 1 / other.value), (other, -quotient / other.value))


def chain(value: High, *parts: tuple[Dual, High]) -> Dual:
    """Return ``value`` with the gradient Σ slope · ∇argument."""
    gradient: dict[Any, High] = {}
    for argument, slope in parts:
        for name, derivative in argument.gradient.items():
            term = slope * derivative
            gradient[name] = gradient[name] + term if name in gradient else term
    return Dual(value, gradient)


def variable(value: High, name: object) -> Dual:
    """Return a number that derivatives are taken by."""
    return Dual(value, {name: CONTEXT.one})


def _constant(value: Fraction) -> Dual:
    return Dual(HIGH.number(value), {})


def _sqrt(x: Dual) -> Dual:
    if x.value < 0:
        raise ArithmeticError("the root of a negative number")
    root = HIGH.sqrt(x.value)
    return chain(root, (x, 1 / (2 * root)))


def _sin(x: Dual) -> Dual:
    return chain(HIGH.sin(x.value), (x, HIGH.cos(x.value)))


def _cos(x: Dual) -> Dual:
    return chain(HIGH.cos(x.value), (x, -HIGH.sin(x.value)))


def _atan2(y: Dual, x: Dual) -> Dual:
    square = x.value * x.value + y.value * y.value
    angle = HIGH.atan2(y.value, x.value)
    return chain(angle, (y, x.value / square), (x, -y.value / square))


def _exp(x: Dual) -> Dual:
    value = HIGH.exp(x.value)
    return chain(value, (x, value))


def _log(x: Dual) -> Dual:
    return chain(HIGH.log(x.value), (x, 1 / x.value))


def _abs(x: Dual) -> Dual:
    return -x if x.value < 0 else x


def _max(x: Dual, y: Dual) -> Dual:
    return x if x.value > y.value else y


#: Arithmetic of :class:`Dual`.
DUAL: Arithmetic[Dual] = Arithmetic(_constant, _sqrt, _sin, _cos, _atan2, _exp, _log, _abs, _max)


def evaluate_dual(
    kernel: Kernel, inputs: Mapping[str, Sequence[float | High]]
) -> dict[str, tuple[Dual, ...]]:
    """Return the outputs of a kernel in 50 digits, with their derivatives by its inputs.

    Parameters
    ----------
    kernel : Kernel
        What is evaluated.
    inputs : mapping of str to sequence
        For each input its elements, flat row-major; finite. Gradients name one by the input and
        its place there.

    Raises
    ------
    ArithmeticError
        The point is a pole, or lies where a root is not real.
    """
    variables = {
        name: [variable(CONTEXT.mpf(x), (name, k)) for k, x in enumerate(elements)]
        for name, elements in inputs.items()
    }
    return evaluate(kernel, variables, DUAL)
