"""Numbers in 50 digits that know which formula of parameters they came from.

A scene is turned into a system in numbers. Where one of them depends on parameters that a run may
change, all that is computed from it is a :class:`Traced`: the value in the scene, and the formula.
Comparisons take the value; nothing is known to be zero or one that is so in the scene only.

Whether a formula depends on parameters at all, as m/m does not, is seen at two further values of
the parameters: a formula that has the same value at all three, to 40 digits, is a number. That
holds for all values, because these formulas are made of analytic functions. A function that is
not analytic everywhere, such as √ and max, counts there as an independent quantity.
"""

from __future__ import annotations

from fractions import Fraction
from functools import partial, reduce
from typing import TYPE_CHECKING, Any

from kousoku.model.numbers.digits import CONTEXT, HIGH, exact
from kousoku.model.operations.expression import apply, evaluated, number, symbol
from kousoku.model.operations.graph import Op

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from kousoku.model.operations.expression import Expression

NOISE = CONTEXT.mpf(10) ** -40
"""A result below this part of the numbers that it came from is a rounded zero."""

LARGEST_EXPONENT = 4096
"""Powers of two beyond which there is no value, and below whose inverse it is zero: doubles end at
1024, and the time and memory for a sine of a number grow with its exponent."""

OPAQUE = frozenset(
    {
        *(Op.SQRT, Op.ABS, Op.SIGN, Op.MIN, Op.MAX),
        *(Op.ASIN, Op.ACOS, Op.ATAN, Op.ATAN2),
    }
)
"""Functions that follow different formulas in different regions: √x² is x in one, −x in another."""


class Traced:
    """A number that depends on parameters.

    Parameters
    ----------
    values : sequence of number
        Its value with the parameters of the scene, then with others; not a number where the
        formula has no value.
    expression : Expression
        The formula.
    """

    __slots__ = ("expression", "values")

    def __init__(self, values: Sequence[Any], expression: Expression) -> None:
        self.values = tuple(values)
        self.expression = expression

    @property
    def value(self) -> Any:
        """Value with the parameters of the scene."""
        return self.values[0]

    def __add__(self, other: object) -> Any:
        return applied(Op.ADD, self, other)

    def __radd__(self, other: object) -> Any:
        return applied(Op.ADD, other, self)

    def __sub__(self, other: object) -> Any:
        return applied(Op.ADD, self, applied(Op.NEG, other))

    def __rsub__(self, other: object) -> Any:
        return applied(Op.ADD, other, -self)

    def __mul__(self, other: object) -> Any:
        return applied(Op.MUL, self, other)

    def __rmul__(self, other: object) -> Any:
        return applied(Op.MUL, other, self)

    def __truediv__(self, other: object) -> Any:
        return applied(Op.DIV, self, other)

    def __rtruediv__(self, other: object) -> Any:
        return applied(Op.DIV, other, self)

    def __neg__(self) -> Any:
        return applied(Op.NEG, self)

    def __abs__(self) -> Any:
        return applied(Op.ABS, self)

    def __pow__(self, exponent: int) -> Any:
        product: Any = CONTEXT.mpf(1)
        for _ in range(exponent):
            product = product * self
        return product

    def __lt__(self, other: object) -> bool:
        return bool(self.value < at_scene(other))

    def __le__(self, other: object) -> bool:
        return bool(self.value <= at_scene(other))

    def __gt__(self, other: object) -> bool:
        return bool(self.value > at_scene(other))

    def __ge__(self, other: object) -> bool:
        return bool(self.value >= at_scene(other))

    def __eq__(self, other: object) -> bool:
        # Two scenes may have the same formula and other parameters: what was found for one is not
        # that of the other. A value that is not a number makes them differ, which costs time only.
        return self is other or (
            isinstance(other, Traced)
            and self.expression == other.expression
            and self.values == other.values
        )

    def __hash__(self) -> int:
        return hash(self.expression)

    def __bool__(self) -> bool:
        return True

    def __float__(self) -> float:
        raise TypeError("a number that depends on parameters is rounded by precise.double")


def at_scene(number: Any) -> Any:
    """Value of a number with the parameters of the scene."""
    return number.value if isinstance(number, Traced) else number


def other_value(value: float, index: int) -> float:
    """Other value of a parameter, the first of those that numbers are traced with."""
    return float(parameter("", value, index).values[1])


def parameter(name: str, value: float, index: int) -> Traced:
    """Parameter of a scene.

    Parameters
    ----------
    name : str
        Its name.
    value : float
        Its value in the scene.
    index : int
        Its index among the parameters: all are changed differently.
    """
    first, high = CONTEXT.mpf(value), CONTEXT.mpf(1)
    more, less = high / (17 + 3 * index), high / (23 + 5 * index)
    size = first or high
    return Traced((first, first + size * more, first - size * less), symbol(name))


def traced(expression: Expression, parameters: Mapping[str, Any]) -> Any:
    """Value of a formula of parameters, with the formula where these are traced."""

    def apply_to(op: Op, args: Sequence[Any]) -> Any:
        if op is Op.ADD:
            return reduce(partial(applied, op), args, CONTEXT.mpf(0))
        return applied(op, *args)

    return evaluated(expression, HIGH.number, parameters, apply_to)


def applied(op: Op, *args: Any) -> Any:
    """Value of a function of numbers, some of which depend on parameters.

    Where all are plain numbers, or the result does not depend on parameters, it is a plain number.
    """
    if result := _trivial(op, args):
        return result[0]
    count = max(len(arg.values) if isinstance(arg, Traced) else 1 for arg in args)
    columns = [arg.values if isinstance(arg, Traced) else (_high(arg),) * count for arg in args]
    values = [_value(op, row) for row in zip(*columns, strict=True)]
    if count == 1:
        return values[0]
    formula = apply(op, *map(_expression, args))
    if _is_opaque(op, args):
        values = _unrelated_values(values[0], formula.key)
    size = max((abs(x) for column in columns for x in column), default=0)
    noise = NOISE * (size if op is Op.ADD else abs(values[0]))
    if all(abs(value - values[0]) <= noise for value in values):
        return _plain(values[0], noise)
    return Traced(values, formula)


def _trivial(op: Op, args: Sequence[Any]) -> tuple[Any, ...]:
    """Result of an operation on a zero or one, alone; empty where it is to be computed."""
    if op in {Op.ADD, Op.MUL, Op.DIV}:
        a, b = args
        if op is Op.ADD and 0 in (a, b):
            return (a if b == 0 else b,)
        if op is Op.MUL and 1 in (a, b):
            return (a if b == 1 else b,)
        if op is Op.DIV and b == 1:
            return (a,)
        if 0 in (a, b) and op is Op.MUL:
            return (CONTEXT.mpf(0),)
    return ()


def _value(op: Op, args: Sequence[Any]) -> Any:
    """Value of an operation; not a number where none is real, or only a huge one."""
    try:
        value = HIGH.applied(op, args)
    except (ValueError, ZeroDivisionError, OverflowError, TypeError):
        return CONTEXT.nan
    if not hasattr(value, "_mpf_"):
        return CONTEXT.nan
    size = CONTEXT.mag(value)
    if size < -LARGEST_EXPONENT:
        return CONTEXT.mpf(0)
    return value if size <= LARGEST_EXPONENT else CONTEXT.nan


def _is_opaque(op: Op, args: Sequence[Any]) -> bool:
    if op is Op.POW:
        return isinstance(args[1], Traced) or not CONTEXT.isint(args[1])
    return op in OPAQUE


def _unrelated_values(value: Any, key: str) -> list[Any]:
    """Value in the scene and two others that no other formula has."""
    size = abs(value) or CONTEXT.mpf(1)
    fractions = (CONTEXT.mpf(int(half, 16)) / 16**20 for half in (key[:16], key[16:]))
    return [value, *(value + size * (fraction + 1) for fraction in fractions)]


def _plain(value: Any, noise: Any) -> Any:
    """Number that does not depend on parameters, without the noise of rounding."""
    near = CONTEXT.mpf(float(value))
    if abs(value) <= noise:
        return CONTEXT.mpf(0)
    return near if abs(value - near) <= noise else value


def _high(value: Any) -> Any:
    return HIGH.number(value) if isinstance(value, Fraction) else CONTEXT.mpf(value)


def _expression(value: Any) -> Expression:
    """Number as a formula."""
    return value.expression if isinstance(value, Traced) else number(exact(value))
