"""Numbers of 50 digits: references of doubles, and for decisions."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING, Any

import mpmath

from kousoku.model.operations.arithmetic import FormulaArithmetic

if TYPE_CHECKING:
    from kousoku.model.numbers.real import Real

#: mpmath with 50 digits, apart from the context that other code may set.
CONTEXT = mpmath.mp.clone()
CONTEXT.dps = 50


def exact(number: Any) -> Fraction:
    """Exact value of a number of mpmath, a double or a fraction."""
    if not hasattr(number, "_mpf_"):
        return Fraction(number)
    sign, mantissa, exponent, _ = number._mpf_
    return Fraction(-int(mantissa) if sign else int(mantissa)) * Fraction(2) ** int(exponent)


def _number(value: Fraction | float) -> Any:
    exact = value if isinstance(value, Fraction) else Fraction(value)
    return CONTEXT.mpf(exact.numerator) / exact.denominator


#: Numbers of :data:`CONTEXT`; a double stands for its exact value.
HIGH: FormulaArithmetic[Real] = FormulaArithmetic(
    number=_number,
    sqrt=CONTEXT.sqrt,
    sin=CONTEXT.sin,
    cos=CONTEXT.cos,
    atan2=CONTEXT.atan2,
    exp=CONTEXT.exp,
    log=CONTEXT.log,
    abs=abs,
    max=max,
    tan=CONTEXT.tan,
    asin=CONTEXT.asin,
    acos=CONTEXT.acos,
    atan=CONTEXT.atan,
    sign=CONTEXT.sign,
    min=min,
    pow=CONTEXT.power,
)
