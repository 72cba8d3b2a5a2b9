"""The component level of a derivation as a list of operations, run with derivatives in 50 digits.

References are computed here, from the scalar expressions that the derivation gives beside the
matrix level. The frozen graph and the code that is emitted from it have no part in this.
"""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import sympy

from kousoku.codegen.interpret import HIGH_CONTEXT
from kousoku.model.errors import FreezeError
from kousoku.symbolic.matrices import elements

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from kousoku.symbolic.derivation import Function

High = Any  # a number of HIGH_CONTEXT: mpmath is untyped


class Step(enum.Enum):
    """What one entry of a tape does."""

    NUMBER = "number"
    INPUT = "input"
    SUM = "sum"
    PRODUCT = "product"
    POWER = "power"
    SIN = "sin"
    COS = "cos"
    ATAN2 = "atan2"


@dataclass(frozen=True, slots=True)
class Entry:
    """One operation on earlier entries.

    Parameters
    ----------
    step : Step
        What is done.
    args : tuple of int
        Positions of the operands.
    number : mpf or None
        The value of a ``NUMBER``, the exponent of a ``POWER``.
    place : int
        The place of an ``INPUT`` among all input numbers.
    """

    step: Step
    args: tuple[int, ...] = ()
    number: High = None
    place: int = -1


@dataclass(frozen=True, slots=True)
class Tape:
    """All outputs of a function, element by element.

    Parameters
    ----------
    entries : tuple of Entry
        In the order of evaluation.
    inputs : tuple of (str, int)
        Array name and flat index of each input number.
    outputs : tuple of (str, tuple of int)
        For each output its name and the positions of its elements, flat row-major.
    """

    entries: tuple[Entry, ...]
    inputs: tuple[tuple[str, int], ...]
    outputs: tuple[tuple[str, tuple[int, ...]], ...]

    @property
    def has_limits(self) -> bool:
        """Whether something finite can come of an infinite operand, as with 1/∞."""
        return any(
            entry.step is Step.ATAN2 or (entry.step is Step.POWER and entry.number < 0)
            for entry in self.entries
        )


@dataclass(frozen=True, slots=True)
class Dual:
    """A number and its derivatives by the input numbers on which it depends."""

    value: High
    gradient: Mapping[int, High]


def record(function: Function) -> Tape:
    """Return the tape of a function's components; equal sub-expressions are evaluated once.

    Raises
    ------
    FreezeError
        A component holds something else than +, ×, rational powers, sin, cos and atan2.
    """
    recorder = _Recorder(function)
    outputs = tuple(
        (output.quantity.name, tuple(recorder.position(x) for x in output.components))
        for output in function.outputs
    )
    return Tape(tuple(recorder.entries), tuple(recorder.places), outputs)


class _Recorder:
    def __init__(self, function: Function) -> None:
        self.name = function.name
        self.entries: list[Entry] = []
        self.places: dict[tuple[str, int], int] = {}
        self._known: dict[Any, int] = {}
        for quantity in function.inputs:
            for index, symbol in enumerate(elements(quantity)):
                place = self.places.setdefault((quantity.name, index), len(self.places))
                self._known[symbol] = self._add(Entry(Step.INPUT, place=place))

    def _add(self, entry: Entry) -> int:
        self.entries.append(entry)
        return len(self.entries) - 1

    def position(self, expression: Any) -> int:
        """Return where ``expression`` is on the tape, putting it there if it is new."""
        known = self._known.get(expression)
        if known is None:
            known = self._known[expression] = self._add(self._entry(expression))
        return known

    def _entry(self, expression: Any) -> Entry:
        if isinstance(expression, sympy.Rational):
            return Entry(Step.NUMBER, (), _high(expression))
        if isinstance(expression, sympy.Pow) and isinstance(expression.exp, sympy.Rational):
            base = self.position(expression.base)
            return Entry(Step.POWER, (base,), _high(expression.exp))
        steps = {
            sympy.Add: Step.SUM,
            sympy.Mul: Step.PRODUCT,
            sympy.sin: Step.SIN,
            sympy.cos: Step.COS,
            sympy.atan2: Step.ATAN2,
        }
        step = steps.get(expression.func)
        if step is None:
            raise FreezeError(
                f"the components of {self.name} hold {expression}, a {expression.func.__name__};"
                " allowed are numbers, elements of the inputs, +, ×, rational powers, sin, cos"
                " and atan2"
            )
        return Entry(step, tuple(self.position(arg) for arg in expression.args))


def _high(number: Any) -> High:
    return HIGH_CONTEXT.mpf(int(number.p)) / int(number.q)


def run(tape: Tape, inputs: Mapping[str, Sequence[float | High]]) -> dict[str, tuple[Dual, ...]]:
    """Evaluate a tape in 50 digits.

    Parameters
    ----------
    tape : Tape
        What is evaluated.
    inputs : mapping of str to sequence
        For each input its elements, flat row-major; finite.

    Returns
    -------
    dict
        For each output its elements with their derivatives.

    Raises
    ------
    ArithmeticError
        The point is a pole, or lies where a root is not real.
    """
    numbers = [HIGH_CONTEXT.mpf(inputs[name][index]) for name, index in tape.inputs]
    duals: list[Dual] = []
    for entry in tape.entries:
        duals.append(_evaluate(entry, [duals[k] for k in entry.args], numbers))
    return {name: tuple(duals[k] for k in positions) for name, positions in tape.outputs}


def _evaluate(entry: Entry, args: Sequence[Dual], numbers: Sequence[High]) -> Dual:
    match entry.step:
        case Step.NUMBER:
            return Dual(entry.number, {})
        case Step.INPUT:
            return Dual(numbers[entry.place], {entry.place: HIGH_CONTEXT.one})
        case Step.SUM:
            return _chain(sum(x.value for x in args), [(x, HIGH_CONTEXT.one) for x in args])
        case Step.PRODUCT:
            return _product(args)
        case Step.POWER:
            return _power(args[0], entry.number)
        case Step.SIN:
            value, slope = HIGH_CONTEXT.sin(args[0].value), HIGH_CONTEXT.cos(args[0].value)
            return _chain(value, [(args[0], slope)])
        case Step.COS:
            value, slope = HIGH_CONTEXT.cos(args[0].value), -HIGH_CONTEXT.sin(args[0].value)
            return _chain(value, [(args[0], slope)])
        case Step.ATAN2:
            y, x = args
            square = x.value * x.value + y.value * y.value
            value = HIGH_CONTEXT.atan2(y.value, x.value)
            return _chain(value, [(y, x.value / square), (x, -y.value / square)])


def _chain(value: High, parts: Sequence[tuple[Dual, High]]) -> Dual:
    """Return ``value`` with the gradient Σ slope · ∇argument."""
    gradient: dict[int, High] = {}
    for argument, slope in parts:
        for place, derivative in argument.gradient.items():
            term = slope * derivative
            gradient[place] = gradient[place] + term if place in gradient else term
    return Dual(value, gradient)


def _product(args: Sequence[Dual]) -> Dual:
    product, *rest = args
    for factor in rest:
        product = _chain(
            product.value * factor.value, [(product, factor.value), (factor, product.value)]
        )
    return product


def _power(base: Dual, exponent: High) -> Dual:
    if exponent == 2:
        return _chain(base.value * base.value, [(base, 2 * base.value)])
    if base.value < 0 and exponent != int(exponent):
        raise ArithmeticError("the root of a negative number")
    return _chain(base.value**exponent, [(base, exponent * base.value ** (exponent - 1))])


def curved_inputs(tape: Tape) -> tuple[str, ...]:
    """Return the input arrays of which a root, a quotient or an angle function is taken."""
    held: list[dict[str, None]] = []
    curved: dict[str, None] = {}
    for entry in tape.entries:
        own = [tape.inputs[entry.place][0]] if entry.step is Step.INPUT else []
        names = dict.fromkeys([*own, *(name for k in entry.args for name in held[k])])
        held.append(names)
        is_power = entry.step is Step.POWER
        is_whole = is_power and entry.number > 0 and entry.number == int(entry.number)
        if (is_power and not is_whole) or entry.step in {Step.SIN, Step.COS, Step.ATAN2}:
            curved.update(names)
    return tuple(curved)


def degrees(tape: Tape) -> dict[str, int]:
    """Return for each input array the highest degree in which any step of the tape holds it.

    Scaling the array by 2^k scales no intermediate result by more than 2^(k · degree).
    """
    held: list[dict[str, int]] = []
    for entry in tape.entries:
        if entry.step is Step.INPUT:
            held.append({tape.inputs[entry.place][0]: 1})
        else:
            held.append(_degree(entry, [held[k] for k in entry.args]))
    names = dict.fromkeys(name for name, _ in tape.inputs)
    return {name: max(degree.get(name, 0) for degree in held) for name in names}


def _degree(entry: Entry, args: Sequence[Mapping[str, int]]) -> dict[str, int]:
    names = dict.fromkeys(name for arg in args for name in arg)
    if entry.step is Step.PRODUCT:
        return {name: sum(arg.get(name, 0) for arg in args) for name in names}
    if entry.step is Step.POWER:
        return {name: int(HIGH_CONTEXT.ceil(abs(entry.number) * args[0][name])) for name in names}
    return {name: max(arg.get(name, 0) for arg in args) for name in names}
