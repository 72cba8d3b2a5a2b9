"""Frozen component level of a derivation: the formulas that references are computed from.

The nodes are those of a kernel, so that one evaluator serves both. They are recorded as SymPy has
them, one for each operation: the lowering of the matrix level, the builder that folds constants,
and the passes, all of which references check, have no part in this.
"""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING, Any

import sympy

from kousoku.model.errors import FreezeError
from kousoku.model.operations.graph import Op, OperationNode
from kousoku.model.operations.kernel import Kernel
from kousoku.symbolic.matrices import elements

if TYPE_CHECKING:
    from collections.abc import Iterable

    from kousoku.symbolic.derivation import Function

#: The operations that SymPy and the graph have in common.
_OPS = {sympy.sin: Op.SIN, sympy.cos: Op.COS, sympy.atan2: Op.ATAN2}


def freeze_components(function: Function) -> Kernel:
    """Kernel of a function's components; equal sub-expressions are one node.

    Parameters
    ----------
    function : Function
        Each of its outputs holds its components, row-major.

    Raises
    ------
    FreezeError
        A component holds something else than +, ×, whole and half powers, sin, cos and atan2.
    """
    freezing = _Freezing(function)
    results = tuple(
        tuple(freezing.node_of(x) for x in output.components) for output in function.outputs
    )
    return Kernel(
        name=function.name,
        title=function.title,
        formula=function.formula,
        source=function.source,
        inputs=function.inputs,
        outputs=tuple(output.quantity for output in function.outputs),
        nodes=tuple(freezing.nodes),
        results=results,
    )


class _Freezing:
    """Walk over the components of a function, depth first."""

    def __init__(self, function: Function) -> None:
        self.where = function.name
        self.nodes: list[OperationNode[int]] = []
        self._known: dict[Any, int] = {}
        for quantity in function.inputs:
            for index, symbol in enumerate(elements(quantity)):
                self._known[symbol] = self._add(
                    OperationNode(Op.INPUT, symbol=(quantity.name, index))
                )

    def node_of(self, expression: Any) -> int:
        """Node of an expression, added if it is new."""
        known = self._known.get(expression)
        if known is None:
            known = self._known[expression] = self._lower(expression)
        return known

    def _add(self, node: OperationNode[int]) -> int:
        self.nodes.append(node)
        return len(self.nodes) - 1

    def _lower(self, expression: Any) -> int:
        match expression:
            case sympy.Rational():
                return self._add(
                    OperationNode(Op.CONST, value=Fraction(int(expression.p), expression.q))
                )
            case sympy.Add():
                return self._folded(Op.ADD, map(self.node_of, expression.args))
            case sympy.Mul():
                return self._folded(Op.MUL, map(self.node_of, expression.args))
            case sympy.Pow() if (2 * expression.exp).is_Integer:
                return self._power(expression.base, int(2 * expression.exp))
        op = _OPS.get(expression.func)
        if op is None:
            raise FreezeError(
                f"the components of {self.where} hold {expression}, a {expression.func.__name__};"
                " allowed are numbers, elements of the inputs, +, ×, whole and half powers, sin,"
                " cos and atan2"
            )
        return self._add(OperationNode(op, tuple(map(self.node_of, expression.args))))

    def _folded(self, op: Op, nodes: Iterable[int]) -> int:
        """Node of a sum or product of several nodes, from left to right."""
        first, *others = nodes
        for other in others:
            first = self._add(OperationNode(op, (first, other)))
        return first

    def _power(self, base: Any, halves: int) -> int:
        """Node of the base to the power ``halves``/2."""
        if halves < 0:
            one = self.node_of(sympy.S.One)
            return self._add(
                OperationNode(Op.DIV, (one, self.node_of(base ** sympy.Rational(-halves, 2))))
            )
        factors = [self.node_of(base)] * (halves // 2)
        if halves % 2:
            factors.append(self._add(OperationNode(Op.SQRT, (self.node_of(base),))))
        return self._folded(Op.MUL, factors)
