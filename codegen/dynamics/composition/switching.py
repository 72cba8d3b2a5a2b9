"""The segment ``switching``: bounds of what formulas do between two times."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import chain
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.recording.matrix import Matrix
from kousoku.codegen.expressions import to_graph
from kousoku.model.derivative import derivative
from kousoku.model.enclosure import Bounds, enclosure
from kousoku.model.formulas import TIME
from kousoku.model.switching import formulas_of, of_time, switching_functions, varying_parts
from kousoku.model.terms import Name

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.codegen.dynamics.recording.recorder import Block, Recorder
    from kousoku.codegen.dynamics.recording.traces import Trace
    from kousoku.model.mechanism import System
    from kousoku.model.terms import Expression

#: Numbers of each function: least and most, and those of its rate.
BOUNDS = 4
#: The names of the two times.
FIRST, LAST = "t.first", "t.last"


@dataclass(frozen=True, slots=True)
class Enclosed:
    """Bounds of formulas of time. Blocks: two times, the parameters.

    Parameters
    ----------
    formulas : tuple of Expression
        What is bounded.
    parameters : tuple of str
        Names that they may use beside the time.
    """

    formulas: tuple[Expression, ...]
    parameters: tuple[str, ...]
    title: str = "bounds between two times"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Return four numbers of each, one column."""
        times, parameters = (block.flat for block in blocks)
        names = (FIRST, LAST, *self.parameters)
        leaves = dict(zip(names, (*times, *parameters), strict=True))
        spans = {TIME: Bounds(Name(FIRST), Name(LAST))}
        both = ((one, derivative(one, TIME)) for one in self.formulas)
        bounds = chain.from_iterable(enclosure(one, spans) for one in chain.from_iterable(both))
        nodes = (to_graph(bound, trace.graph, leaves) for bound in bounds)
        return (Matrix(trace.graph, tuple((node,) for node in nodes), 1),)


def record_switching(recorder: Recorder, system: System, parameters: Block) -> None:
    """Record the segment, if some formula switches or varies with time.

    Parameters
    ----------
    recorder : Recorder
        The program.
    system : System
        The scene.
    parameters : Block
        Where its parameters are.
    """
    formulas = tuple(formulas_of(system))
    parts: dict[str, Sequence[Expression]] = {
        "switches": of_time(chain.from_iterable(map(switching_functions, formulas)), system),
        "features": of_time(chain.from_iterable(map(varying_parts, formulas)), system),
    }
    if not any(parts.values()):
        return
    span = recorder.region("span", 2)
    recorder.begin("switching")
    names = tuple(name for name, _ in system.parameters)
    for name, found in parts.items():
        if found:
            target = recorder.region(name, BOUNDS * len(found))
            recorder.call(Enclosed(tuple(found), names), span, parameters, into=(target,))
