"""Dual numbers of 50 digits: values with the derivatives that references and their units need."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from kousoku.model.numbers.digits import CONTEXT, HIGH
from kousoku.model.operations.arithmetic import Arithmetic
from kousoku.model.operations.differentials import slopes_of
from kousoku.model.operations.graph import Op
from kousoku.model.operations.interpret import evaluate

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from fractions import Fraction

    from kousoku.model.numbers.precise import High
    from kousoku.model.operations.kernel import Kernel


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
        return _applied(Op.SUB, self.value - other.value, self, other)

    def __neg__(self) -> Dual:
        return _applied(Op.NEG, -self.value, self)

    def __mul__(self, other: Dual) -> Dual:
        return _applied(Op.MUL, self.value * other.value, self, other)

    def __truediv__(self, other: Dual) -> Dual:
        return _applied(Op.DIV, self.value / other.value, self, other)


def _applied(op: Op, value: High, *args: Dual) -> Dual:
    """Value of an operation with the gradient Σ slope · ∇argument."""
    slopes = slopes_of(op, value, [arg.value for arg in args], HIGH)
    gradient: dict[Any, High] = {}
    for arg, slope in zip(args, slopes, strict=True):
        for name, derivative in arg.gradient.items():
            term = slope * derivative
            gradient[name] = gradient[name] + term if name in gradient else term
    return Dual(value, gradient)


def _function(op: Op) -> Callable[..., Dual]:
    def applied(*args: Dual) -> Dual:
        return _applied(op, HIGH.applied(op, [arg.value for arg in args]), *args)

    return applied


def variable(value: High, name: object) -> Dual:
    """Number that derivatives are taken by."""
    return Dual(value, {name: CONTEXT.one})


def _constant(value: Fraction) -> Dual:
    return Dual(HIGH.number(value), {})


def _sqrt(x: Dual) -> Dual:
    if x.value < 0:
        raise ArithmeticError("the root of a negative number")
    return _applied(Op.SQRT, HIGH.sqrt(x.value), x)


def _abs(x: Dual) -> Dual:
    return -x if x.value < 0 else x


def _max(x: Dual, y: Dual) -> Dual:
    return x if x.value >= y.value else y


#: Arithmetic of :class:`Dual`.
DUAL: Arithmetic[Dual] = Arithmetic(
    number=_constant,
    sqrt=_sqrt,
    sin=_function(Op.SIN),
    cos=_function(Op.COS),
    atan2=_function(Op.ATAN2),
    exp=_function(Op.EXP),
    log=_function(Op.LOG),
    abs=_abs,
    max=_max,
)


def evaluate_dual(
    kernel: Kernel, inputs: Mapping[str, Sequence[float | High]]
) -> dict[str, tuple[Dual, ...]]:
    """Outputs of a kernel in 50 digits, with their derivatives by its inputs.

    Parameters
    ----------
    kernel : Kernel
        What is evaluated.
    inputs : mapping of str to (n,) sequence
        For each input its elements, flat row-major, in the units of the kernel; finite. Gradients
        name an element by its input and index.

    Returns
    -------
    dict of str to (m,) tuple of Dual
        For each output its elements, flat row-major.

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
