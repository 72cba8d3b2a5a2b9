"""The formulas of drivers at the start: value, rate and second derivative in 50 digits.

Derivatives are formulas, too, by the rules of differentiation: nothing is differenced.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

from kousoku.codegen.expressions import to_graph
from kousoku.model.errors import AssemblyError
from kousoku.model.expressions.exponentials import rate_of
from kousoku.model.expressions.formulas import TIME
from kousoku.model.expressions.parser import parse_expression
from kousoku.model.files.quantity import Quantity
from kousoku.model.numbers import precise
from kousoku.model.numbers.digits import CONTEXT, HIGH
from kousoku.model.operations.graph import Graph
from kousoku.model.operations.interpret import evaluate
from kousoku.model.operations.kernel import Kernel

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.model.mechanics.multibody import Instance
    from kousoku.model.numbers.precise import High

#: A formula and its derivatives by the time.
LEVELS = ("value", "rate", "second")
#: Values below it are zeros with rounding, such as sin(pi).
ROUNDING_OF_FORMULAS = 1e-30


@dataclass(frozen=True, slots=True)
class LawStart:
    """A formula of the time at t = 0, multiplied by its unit: f, ḟ and f̈.

    Parameters
    ----------
    value, rate, second : number [m or rad, per s, per s²]
        In 50 digits.
    """

    value: High = precise.ZERO[0]
    rate: High = precise.ZERO[0]
    second: High = precise.ZERO[0]


def law_at_start(instance: Instance, parameters: Sequence[tuple[str, float]]) -> LawStart:
    """Values f, ḟ, f̈ of the formula of a driver at t = 0, numbers [m or rad, per s, per s²].

    They are zeros where an instance has no formula.

    Parameters
    ----------
    instance : Instance
        A linear combination.
    parameters : sequence of (str, float)
        Names that the formula may use, and their values.

    Raises
    ------
    AssemblyError
        The formula or one of its derivatives is no number at t = 0, such as the rate of sqrt(t).
    """
    if not instance.law:
        return LawStart()
    inputs: dict[str, list[High]] = {TIME: [precise.ZERO[0]]}
    inputs |= {name: [precise.number(value)] for name, value in parameters}
    unit = precise.number(instance.law_unit)
    levels = []
    for level, kernel in zip(LEVELS, _kernels(instance.law, tuple(inputs)), strict=True):
        try:
            ((number,),) = evaluate(kernel, inputs, HIGH).values()
        except (ZeroDivisionError, ValueError, OverflowError):  # as mpmath says it
            number = None
        if number is None or not CONTEXT.isfinite(number) or CONTEXT.im(number):
            raise AssemblyError(
                f"drivers.{instance.joint}: the {level} of {instance.law!r} is no number at t = 0;"
                " give a formula with two derivatives by t there",
                [f"drivers.{instance.joint}"],
            )
        levels.append(unit * number if abs(number) > ROUNDING_OF_FORMULAS else precise.ZERO[0])
    return LawStart(*levels)


@cache
def _kernels(law: str, names: tuple[str, ...]) -> tuple[Kernel, ...]:
    """Formula and its derivatives by the time, each as a kernel of its names."""
    formula = parse_expression(law, names)
    levels = [rate_of(formula, order) for order in range(len(LEVELS))]
    kernels = []
    for expression in levels:
        graph = Graph()
        node = to_graph(expression, graph, {name: graph.input(name, 0) for name in names})
        value = Quantity("value", (1,), "-", "of a formula at some time")
        kernels.append(
            Kernel("law", "", law, "", (), (value,), tuple(graph.nodes), ((node,),)),
        )
    return tuple(kernels)


def fixed_law(instance: Instance, parameters: Sequence[str]) -> float:
    """Value f(t), a number [m or rad], of a law that never changes, 0 for none, else infinity."""
    if not instance.is_driver:
        return 0.0
    graph, names = Graph(), (TIME, *parameters)
    leaves = {name: graph.input(name, 0) for name in names}
    value = graph.value(to_graph(parse_expression(instance.law, names), graph, leaves))
    return math.inf if value is None else instance.law_unit * float(value)
