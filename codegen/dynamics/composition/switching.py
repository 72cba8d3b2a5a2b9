"""Segments of formulas that switch, or that are watched for where they cross zero.

``switching`` bounds formulas of time between two times, ``bending`` laws of drivers. ``measure``
evaluates the measures of a state that formulas read, ``distance`` the squares of distances in
them, and ``crossing`` bounds them between two times of a step.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import reduce
from itertools import chain
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.recording.matrix import Matrix
from kousoku.codegen.expressions import to_graph
from kousoku.model.expressions.derivative import derivative
from kousoku.model.expressions.enclosure import Bounds, enclosure
from kousoku.model.expressions.exponentials import without_overflow
from kousoku.model.expressions.formulas import TIME
from kousoku.model.expressions.linear_sums import without_linear_sums
from kousoku.model.expressions.quotients import without_quotients
from kousoku.model.lowering.root_functions import root_functions_of
from kousoku.model.operations.expression import ONE, ZERO, add, mul, names_of, symbol

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from kousoku.codegen.dynamics.composition.record_forces import ForceRecorder
    from kousoku.codegen.dynamics.recording.recorder import Recorder, SlotMatrix
    from kousoku.codegen.dynamics.recording.traces import Trace
    from kousoku.model.lowering.root_functions import Measure
    from kousoku.model.mechanics.multibody import System
    from kousoku.model.operations.expression import Expression

#: Numbers of each function: least and most, and those of its rate.
BOUNDS = 4
#: Numbers of each measure: least and most of value, rate, and second derivative.
RANGES = 6
#: Suffixes of a name: its least and most value; its second derivative.
LEAST, MOST, SECOND = ".least", ".most", ".second"


@dataclass(frozen=True, slots=True)
class Enclosed:
    """Bounds of formulas. Blocks: two times and bounds of measures, the parameters.

    Parameters
    ----------
    formulas : tuple of Expression
        Formulas that are bounded.
    parameters : tuple of str
        Names of their arguments beside the time.
    measures : tuple of Measure
        Measures of the state that they depend on.
    """

    formulas: tuple[Expression, ...]
    parameters: tuple[str, ...]
    measures: tuple[Measure, ...] = ()
    title: str = "bounds between two times"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Numbers of each formula, four, in one column."""
        ranges, parameters = (block.flat for block in blocks)
        varying = [TIME]
        for measure in self.measures:
            varying += (measure.name, measure.rate, f"{measure.rate}{SECOND}")
        spans = {
            name: Bounds(symbol(f"{name}{LEAST}"), symbol(f"{name}{MOST}")) for name in varying
        }
        names = [f"{name}{end}" for name in varying for end in (LEAST, MOST)]
        leaves = dict(zip((*names, *self.parameters), (*ranges, *parameters), strict=True))
        bounds = chain.from_iterable(self._bounds(formula, spans) for formula in self.formulas)
        nodes = (to_graph(bound, trace.graph, leaves) for bound in bounds)
        return (Matrix.of(trace.graph, nodes),)

    def _bounds(self, formula: Expression, spans: Mapping[str, Bounds]) -> Iterator[Expression]:
        """Least and most of a formula, and those of its rate."""
        rates = {TIME: ONE}
        for measure in self.measures:
            rates[measure.name] = symbol(measure.rate)
            rates[measure.rate] = symbol(f"{measure.rate}{SECOND}")
        substituted, sums = without_linear_sums(without_overflow(formula), rates)
        spans = dict(spans)
        for linear in sums:
            spans |= linear.bounds(TIME, rates, spans)
        rates |= {linear.name: symbol(linear.rate) for linear in sums}
        substituted, quotients = without_quotients(substituted, spans)
        for quotient in quotients:
            parts = quotient.formula, quotient.vanishing_argument
            rate, speed = (_rate(part, rates) for part in parts)
            spans |= quotient.bounds(rate, speed, spans)
            rates[quotient.name] = symbol(quotient.rate)
        yield from enclosure(substituted, spans)
        yield from enclosure(without_overflow(_rate(substituted, rates)), spans)


def _rate(formula: Expression, rates: Mapping[str, Expression]) -> Expression:
    """Derivative of a formula by time; of each name that varies the rate is given."""
    used = {*names_of(formula)}
    terms = (mul(derivative(formula, name), x) for name, x in rates.items() if name in used)
    return reduce(add, terms, ZERO)


@dataclass(frozen=True, slots=True)
class Valued:
    """Values of formulas. Blocks: the time, value and rate of each measure, the parameters.

    Parameters
    ----------
    formulas : tuple of Expression
        Formulas that are evaluated.
    parameters : tuple of str
        Names of their arguments beside the time.
    measures : tuple of Measure
        Measures of the state that they depend on.
    """

    formulas: tuple[Expression, ...]
    parameters: tuple[str, ...]
    measures: tuple[Measure, ...]
    title: str = "values of formulas"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Values, in one column."""
        read = chain.from_iterable((measure.name, measure.rate) for measure in self.measures)
        nodes = chain.from_iterable(block.flat for block in blocks)
        leaves = dict(zip((TIME, *read, *self.parameters), nodes, strict=True))
        values = (to_graph(formula, trace.graph, leaves) for formula in self.formulas)
        return (Matrix.of(trace.graph, values),)


def record_switching(
    recorder: Recorder, system: System, parameters: SlotMatrix, forces: ForceRecorder
) -> None:
    """Record the segments, if some formula switches or varies, or there are events.

    Parameters
    ----------
    recorder : Recorder
        The program.
    system : System
        The scene.
    parameters : SlotMatrix
        Its parameters.
    forces : ForceRecorder
        Recorder of its forces.
    """
    functions, names = root_functions_of(system), tuple(name for name, _ in system.parameters)

    def record(
        segment: str,
        ranges: SlotMatrix,
        by_region: Mapping[str, Sequence[Expression]],
        *measures: Measure,
    ) -> None:
        recorder.begin(segment)
        for name, formulas in by_region.items():
            if formulas:
                target = recorder.region(name, BOUNDS * len(formulas))
                operation = Enclosed(tuple(formulas), names, measures)
                recorder.call(operation, ranges, parameters, into=(target,))

    if functions.switches or functions.features:
        by_region = {"switches": functions.switches, "features": functions.features}
        by_region |= {"gaps": functions.gaps}
        record("switching", recorder.region("span", 2), by_region)
    if functions.laws:
        record("bending", recorder.region("law_span", 2), {"laws": functions.laws})
    squares = {"lengths": functions.lengths, "distances": functions.distances}
    crossing = {
        "crossings": functions.crossings,
        "breaks": functions.breaks,
        "poles": functions.poles,
        "narrow": functions.narrow,
        "infinite": functions.infinite,
    }
    if any(crossing.values()) or any(squares.values()):
        region = recorder.region("measures", 2 * len(functions.measures))
        recorder.begin("measure")
        for k, measure in enumerate(functions.measures):
            forces.measure(system, measure, region.part(2 * k, 1), region.part(2 * k + 1, 1))
    if any(squares.values()):
        recorder.begin("distance")
        for name, formulas in squares.items():
            if formulas:
                target = recorder.region(name, len(formulas))
                valued = Valued(formulas, names, functions.measures)
                recorder.call(valued, forces.names[TIME][0], region, parameters, into=(target,))
    if any(crossing.values()):
        ranges = recorder.region("ranges", 2 + RANGES * len(functions.measures))
        record("crossing", ranges, crossing, *functions.measures)
