"""Formulas of a scene in its program: the nodes of their names, and constants times a formula."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.recording.matrix import Matrix
from kousoku.codegen.expressions import to_graph
from kousoku.model.expressions.folds import with_signs
from kousoku.model.expressions.formulas import WORD, used_names
from kousoku.model.expressions.parser import parse_expression

if TYPE_CHECKING:
    from collections.abc import Mapping

    from kousoku.codegen.dynamics.recording.recorder import Recorder, SlotMatrix
    from kousoku.codegen.dynamics.recording.traces import Trace

    #: Meaning of a name: a value, and its unit.
    Meaning = tuple[SlotMatrix, SlotMatrix]


@dataclass(frozen=True, slots=True)
class Scaled:
    """Product f(x/unit) · c of a constant c and a formula f. Blocks: c, then x, unit of each name.

    Parameters
    ----------
    formula : str
        The text.
    names : tuple of str
        Names that it depends on.
    """

    formula: str
    names: tuple[str, ...]
    title: str = "formula"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Product, in the shape, unit and frame of the constant."""
        constant, *arguments = blocks
        factor = formula_node(trace, self.formula, self.names, arguments)
        mul = trace.graph.mul
        rows = tuple(tuple(mul(factor, x) for x in row) for row in constant.rows)
        return (Matrix(trace.graph, rows, constant.width),)


def formula_node(trace: Trace, formula: str, names: tuple[str, ...], blocks: list[Matrix]) -> int:
    """Node of a formula.

    Parameters
    ----------
    trace : Trace
        Its graph takes the node.
    formula : str
        The text.
    names : tuple of str
        Names that it depends on.
    blocks : list of Matrix
        Value and unit of each.
    """
    values = (node for block in blocks for node in block.flat)
    pairs = zip(values, values, strict=True)
    leaves = {
        name: trace.graph.div(value, unit) for name, (value, unit) in zip(names, pairs, strict=True)
    }
    # The formula was read before; the names of :func:`scaled` may be longer than its own.
    # Quotients such as v/abs(v) are signs: at rest they have a value, and lose no digits near it.
    expression, _ = with_signs(parse_expression(formula, names, longest=len(formula)))
    return to_graph(expression, trace.graph, leaves)


@dataclass(frozen=True, slots=True)
class MatrixProduct:
    """Product a b of matrices a (n, k) and b (k, m). Blocks: a, b."""

    title: str = "product"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Product (n, m), in the frame of the rows of a and the product of their units."""
        a, b = blocks
        return (a @ b,)


@dataclass(frozen=True, slots=True)
class Relative:
    """Difference (a − b)/unit of two numbers (1, 1). Blocks: a, b, the unit, all in one unit."""

    title: str = "difference in a unit"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Difference (1, 1) [-]: a number of units."""
        (a,), (b,), (unit,) = (block.flat for block in blocks)
        node = trace.graph.div(trace.graph.sub(a, b), unit)
        return (Matrix.of(trace.graph, [node]),)


def scaled(
    recorder: Recorder, constant: SlotMatrix, formula: str, names: Mapping[str, Meaning]
) -> SlotMatrix:
    """Constant times a formula, recorded.

    Parameters
    ----------
    recorder : Recorder
        The program, in the segment that needs it.
    constant : SlotMatrix
        The constant.
    formula : str
        The text.
    names : mapping of str to (SlotMatrix, SlotMatrix)
        Value and unit of each name.
    """
    used = used_names(formula, names)
    blocks = [block for name in used for block in names[name]]
    # Formulas that differ in names only are one operation, which is traced once.
    common = {name: f"x_{k}" for k, name in enumerate(used)}
    text = WORD.sub(lambda word: common.get(word.group(), word.group()), formula)
    return recorder.call(Scaled(text, tuple(common.values())), constant, *blocks)[0]
