"""Formulas of a scene in its program: what their names stand for, and constants times a formula."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.matrix import Matrix
from kousoku.codegen.expressions import to_graph
from kousoku.model.expression import parse_expression
from kousoku.model.terms import names_of

if TYPE_CHECKING:
    from collections.abc import Mapping

    from kousoku.codegen.dynamics.recorder import Block, Recorder
    from kousoku.codegen.dynamics.traces import Trace

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
    return to_graph(parse_expression(formula, names), trace.graph, leaves)


def used_names(formula: str, names: tuple[str, ...]) -> tuple[str, ...]:
    """Return those names that a formula depends on, in the order of its text."""
    return names_of(parse_expression(formula, names))


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
    used = used_names(formula, tuple(names))
    blocks = [block for name in used for block in names[name]]
    return recorder.call(Scaled(formula, used), constant, *blocks)[0]
