"""Formulas of a scene in its program: what their names stand for, and constants times a formula."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.recording.matrix import Matrix
from kousoku.codegen.expressions import to_graph
from kousoku.model.elements.constraints import is_length
from kousoku.model.expression import parse_expression
from kousoku.model.formulas import RATE, TIME, WORD, used_names

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from kousoku.codegen.dynamics.composition.coordinate_tasks import CoordinateTasks
    from kousoku.codegen.dynamics.recording.recorder import Block, Recorder
    from kousoku.codegen.dynamics.recording.traces import Trace
    from kousoku.model.mechanism import System

    #: What a name stands for: a value, and the unit that it is given in.
    Meaning = tuple[Block, Block]


@dataclass(frozen=True, slots=True)
class Scaled:
    """A constant times a formula. Blocks: the constant, then value and unit of each name.

    Parameters
    ----------
    formula : str
        The text.
    names : tuple of str
        What it depends on.
    """

    formula: str
    names: tuple[str, ...]
    title: str = "formula"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Return the product, in the shape of the constant."""
        constant, *rest = blocks
        factor = formula_node(trace, self.formula, self.names, rest)
        mul = trace.graph.mul
        rows = tuple(tuple(mul(factor, x) for x in row) for row in constant.rows)
        return (Matrix(trace.graph, rows, constant.width),)


def formula_node(trace: Trace, formula: str, names: tuple[str, ...], blocks: list[Matrix]) -> int:
    """Return the node of a formula.

    Parameters
    ----------
    trace : Trace
        Where it goes.
    formula : str
        The text.
    names : tuple of str
        What it depends on.
    blocks : list of Matrix
        Value and unit of each.
    """
    values = (node for block in blocks for node in block.flat)
    pairs = zip(values, values, strict=True)
    leaves = {
        name: trace.graph.div(value, unit) for name, (value, unit) in zip(names, pairs, strict=True)
    }
    # It was read before, and the names of :func:`scaled` may be longer than those it had then.
    expression = parse_expression(formula, names, longest=len(formula))
    return to_graph(expression, trace.graph, leaves)


@dataclass(frozen=True, slots=True)
class Product:
    """A column times a number. Blocks: both."""

    title: str = "product"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Return the product."""
        column, number = blocks
        return (column @ number,)


@dataclass(frozen=True, slots=True)
class Relative:
    """A number beyond another, in a unit. Blocks: both, the unit."""

    title: str = "difference in a unit"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Return the quotient."""
        (a,), (b,), (unit,) = (block.flat for block in blocks)
        node = trace.graph.div(trace.graph.sub(a, b), unit)
        return (Matrix(trace.graph, ((node,),), 1),)


class Names(Mapping[str, "Meaning"]):
    """What formulas may depend on: time, parameters, coordinates, and rates of coordinates.

    Each is recorded in the segment that asks for it.

    Parameters
    ----------
    system : System
        The scene.
    recorder : Recorder
        The program.
    coordinates : CoordinateTasks
        Its coordinates.
    given : (Block, Block)
        Where time and parameters are.
    by_body : sequence of Block
        The velocities of each body.
    """

    def __init__(
        self,
        system: System,
        recorder: Recorder,
        coordinates: CoordinateTasks,
        given: tuple[Block, Block],
        by_body: Sequence[Block],
    ) -> None:
        time, parameters = given
        self._fixed = {TIME: time}
        for k, (name, _) in enumerate(system.parameters):
            self._fixed[name] = parameters.part(k, 1)
        self._places = {one.name: place for place, one in enumerate(system.coordinates)}
        self._rates = {f"{name}{RATE}": place for name, place in self._places.items()}
        self._unit = system.unit
        self._recorder, self._coordinates, self._by_body = recorder, coordinates, by_body

    def __getitem__(self, name: str) -> Meaning:
        one = self._recorder.constant((1,))
        if name in self._fixed:
            return self._fixed[name], one
        if name in self._rates:
            place = self._rates[name]
            value = self._coordinates.rate(place, self._by_body)
        else:
            place = self._places[name]
            value = self._coordinates.value(place)
        kind = self._coordinates.all[place].kind
        return value, self._recorder.constant((self._unit,)) if is_length(kind) else one

    def __contains__(self, name: object) -> bool:
        return name in self._fixed or name in self._places or name in self._rates

    def __iter__(self) -> Iterator[str]:
        yield from (*self._fixed, *self._places, *self._rates)

    def __len__(self) -> int:
        return len(self._fixed) + len(self._places) + len(self._rates)


def scaled(
    recorder: Recorder, constant: Block, formula: str, names: Mapping[str, Meaning]
) -> Block:
    """Record a constant times a formula; return where it is.

    Parameters
    ----------
    recorder : Recorder
        The program, in the segment that needs it.
    constant : Block
        The constant.
    formula : str
        The text.
    names : mapping of str to (Block, Block)
        What its names stand for.
    """
    used = used_names(formula, names)
    blocks = [block for name in used for block in names[name]]
    # Formulas that differ in names only are one operation, which is traced once.
    common = {name: f"x_{k}" for k, name in enumerate(used)}
    text = WORD.sub(lambda word: common.get(word.group(), word.group()), formula)
    return recorder.call(Scaled(text, tuple(common.values())), constant, *blocks)[0]
