"""The value of a formula, in doubles."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from kousoku.model.operations.arithmetic import FLOAT
from kousoku.model.operations.expression import evaluated
from kousoku.model.operations.graph import Op

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from kousoku.model.operations.expression import Expression


def value_of(expression: Expression, values: Mapping[str, float]) -> float:
    """Value of a formula; not a number where it has none that is real and finite.

    Parameters
    ----------
    expression : Expression
        The formula.
    values : mapping of str to float
        The value of each name in it.
    """
    value = evaluated(expression, float, values, _applied)
    return value if math.isfinite(value) else math.nan


def _applied(op: Op, args: Sequence[float]) -> float:
    try:
        is_sum = op is Op.ADD
        value = math.fsum(args) if is_sum else FLOAT.applied(op, args)
    except OverflowError:  # as in solvers: what is divided by it is zero
        return math.inf if op is Op.EXP else math.nan
    except (ValueError, ZeroDivisionError):
        return math.nan
    return value if isinstance(value, float) else math.nan
