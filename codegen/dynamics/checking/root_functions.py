"""Values and rates of the functions whose roots a run looks for, to compare the solver's with.

They are of the formulas alone, with random numbers for the measures that these read: rates are
quotients of differences in 50 digits, so that neither bounds nor derivatives have a part in them.
"""

from __future__ import annotations

from fractions import Fraction
from math import isfinite
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.checking.start import measures_at_start
from kousoku.codegen.dynamics.emission.context_numbers import measure_size
from kousoku.codegen.dynamics.operations.characteristic_length import characteristic_length
from kousoku.codegen.sha256_random import Sha256Random
from kousoku.model.expressions.formulas import TIME
from kousoku.model.lowering.root_functions import root_functions_of
from kousoku.model.numbers.digits import HIGH
from kousoku.model.operations.expression import evaluated
from kousoku.model.operations.graph import Op

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from kousoku.codegen.dynamics.recording.program import Program
    from kousoku.model.mechanics.multibody import System
    from kousoku.model.numbers.real import Real
    from kousoku.model.operations.expression import Expression

#: Regions of a program that have functions: fields of the result of ``root_functions_of``.
REGIONS = (
    *("switches", "features", "gaps", "laws", "crossings", "breaks", "poles", "narrow", "infinite"),
    *("lengths", "distances"),
)
#: Count of random points, and their distance from the start and from each other, relative to sizes.
POINTS, FAR = 6, 0.5
#: Step of difference quotients [s]: half of the digits remain.
DIFFERENCE = Fraction(1, 2**80)
#: Unit of error, relative to the largest intermediate number of a formula. Sines of numbers that
#: are larger than its inverse are known to less.
UNIT = 2.0**-24


def root_function_points(program: Program, system: System) -> list[dict[str, object]]:
    """Points at which functions are known: a time, numbers that they read, values and rates.

    Parameters
    ----------
    program, system : Program, System
        Program and system that a solver is emitted from.
    """
    functions = root_functions_of(system)
    formulas: dict[str, Sequence[Expression]] = {
        name: expressions for name in REGIONS if (expressions := getattr(functions, name))
    }
    if not formulas:
        return []
    count, length = len(functions.measures), characteristic_length(system)
    start = measures_at_start(program, count) or [(0.0, 0.0)] * count
    stream = Sha256Random(f"root functions of {system.name}")

    def drawn(size: float) -> float:
        return FAR * size * stream.sign() * stream.magnitude()

    points: list[dict[str, object]] = []
    for _ in range(POINTS):
        time, names, measures = abs(drawn(4.0)), dict[str, list[float]](), []
        for measure, (value, rate) in zip(functions.measures, start, strict=True):
            size = measure_size(measure, system, length)
            numbers = [value + drawn(size), rate + drawn(size), drawn(size)]
            names |= {measure.name: numbers[:2], measure.rate: numbers[1:]}
            measures.append(numbers)
        parameters = {name: [value, 0.0] for name, value in system.parameters}
        courses = {TIME: [time, 1.0], **parameters, **names}
        values = {
            name: [_value_and_rate(formula, courses) for formula in expressions]
            for name, expressions in formulas.items()
        }
        points.append({"time": time, "read": measures, "values": values})
    return points


def _value_and_rate(
    formula: Expression, courses: Mapping[str, Sequence[float]]
) -> list[float] | None:
    """Value and rate of a formula, with their unit of error; None unless they are finite."""
    sizes = [1.0]

    def applied(op: Op, args: Sequence[Real]) -> Real:
        result = _applied(op, args)
        sizes.append(abs(float(result)))
        return result

    def value_at(time: Fraction) -> Real:
        names = {
            name: HIGH.number(Fraction(value) + time * Fraction(rate))
            for name, (value, rate) in courses.items()
        }
        return evaluated(formula, _as_double, names, applied)

    try:
        value, before, following = (value_at(x) for x in (Fraction(0), -DIFFERENCE, DIFFERENCE))
        rate = (following - before) / HIGH.number(2 * DIFFERENCE)
        largest = max(*sizes, abs(float(rate)))
        numbers = [float(value), float(rate), UNIT * largest * max(1.0, UNIT * largest)]
        return numbers if all(map(isfinite, numbers)) else None
    except (ArithmeticError, ValueError, TypeError):  # a pole, or a root that is not real
        return None


def _as_double(value: Fraction) -> Real:
    """Number of a formula as solvers have it."""
    return HIGH.number(Fraction(float(value)))


def _applied(op: Op, args: Sequence[Real]) -> Real:
    """Result of an operation, by its definition where that is of exponentials: none overflows."""
    match op:
        case Op.LOG_SUM:
            return HIGH.log(HIGH.exp(args[0]) + HIGH.exp(args[1]))
        case Op.SHARE:
            return HIGH.number(Fraction(1)) / (HIGH.number(Fraction(1)) + HIGH.exp(-args[0]))
        case _:
            return HIGH.applied(op, args)
