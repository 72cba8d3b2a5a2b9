"""The segment ``setup``: parameters -> the numbers of a scene that depend on them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.recording.design import DesignNumbers, shown_numbers, starts
from kousoku.codegen.dynamics.recording.matrix import Matrix
from kousoku.codegen.expressions import to_graph
from kousoku.model.operations.expression import names_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.codegen.dynamics.recording.program import BodyCoordinates
    from kousoku.codegen.dynamics.recording.recorder import Recorder, SlotMatrix
    from kousoku.codegen.dynamics.recording.traces import Trace
    from kousoku.model.mechanics.multibody import System
    from kousoku.model.operations.expression import Expression

#: Numbers that one task computes: what they share is computed once.
EXPRESSIONS_AT_ONCE = 128


@dataclass(frozen=True, eq=False)
class ParameterFormulas:
    """Formulas of parameters. Block: all parameters.

    Parameters
    ----------
    expressions : sequence of Expression
        The formulas.
    names : sequence of str
        The parameters.
    """

    expressions: Sequence[Expression]
    names: Sequence[str]
    title: str = "numbers of the design"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Values of the formulas, one column."""
        leaves = dict(zip(self.names, blocks[0].flat, strict=True))
        nodes = (to_graph(expression, trace.graph, leaves) for expression in self.expressions)
        return (Matrix.of(trace.graph, nodes),)


def record_setup(
    recorder: Recorder, system: System, parameters: SlotMatrix, bodies: Sequence[BodyCoordinates]
) -> DesignNumbers:
    """Record the segment, if some number depends on parameters; return where the numbers are.

    Parameters
    ----------
    recorder : Recorder
        The program, with all its other segments.
    system : System
        The scene.
    parameters : SlotMatrix
        Its parameters.
    bodies : sequence of BodyCoordinates
        Slots of its bodies in q and v.
    """
    start = starts(system, bodies)
    for value in (*shown_numbers(system), *(value for _, value in start)):
        recorder.constant((value,))
    names = [name for name, _ in system.parameters]
    expressions = [traced.expression for _, traced in recorder.design.values()]
    if expressions:
        recorder.begin("setup")
    for first in range(0, len(expressions), EXPRESSIONS_AT_ONCE):
        chunk = expressions[first : first + EXPRESSIONS_AT_ONCE]
        target = recorder.design_part(first, len(chunk))
        recorder.call(ParameterFormulas(chunk, names), parameters, into=(target,))
    occurring = {name for formula in expressions for name in names_of(formula)}
    used = [name for name in names if name in occurring]
    places_of = {key: place for key, (place, _) in recorder.design.items()}
    return DesignNumbers.of(places_of, start, system.positive, used)
