"""Formulas in doubles, as solvers compute them: what tests of bounds compare with."""

from __future__ import annotations

import operator
from typing import TYPE_CHECKING, Any

import numpy as np

from kousoku.model.expressions.values import value_of
from kousoku.model.operations.expression import ordered
from kousoku.model.operations.graph import Op

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from kousoku.model.operations.expression import Expression

CALLS: dict[Op, Callable[..., Any]] = {
    Op.ADD: lambda *terms: sum(terms),
    Op.MUL: operator.mul,
    Op.DIV: operator.truediv,
    Op.NEG: operator.neg,
    Op.POW: operator.pow,
    Op.SIN: np.sin,
    Op.COS: np.cos,
    Op.EXP: np.exp,
    Op.LOG: np.log,
    Op.SQRT: np.sqrt,
    Op.ASIN: np.arcsin,
    Op.ACOS: np.arccos,
    Op.ABS: np.abs,
    Op.MIN: np.fmin,
    Op.MAX: np.fmax,
}


def in_doubles(expression: Expression, values: Mapping[str, float]) -> float:
    """Value of a formula, where exponentials may be infinite."""
    known: dict[int, np.float64] = {}
    with np.errstate(all="ignore"):
        for part in ordered(expression):
            if part.args:
                known[id(part)] = CALLS[part.op](*(known[id(arg)] for arg in part.args))
            else:
                known[id(part)] = np.float64(value_of(part, values))
    return float(known[id(expression)])
