"""Numbers of 50 digits: what is decided, and what doubles are compared with."""

from __future__ import annotations

from typing import Any

import mpmath

from kousoku.model.arithmetic import Arithmetic

#: mpmath with 50 digits, apart from the context that other code may set.
CONTEXT = mpmath.mp.clone()
CONTEXT.dps = 50

#: Numbers of :data:`CONTEXT`.
HIGH: Arithmetic[Any] = Arithmetic(
    lambda value: CONTEXT.mpf(value.numerator) / value.denominator,
    CONTEXT.sqrt,
    CONTEXT.sin,
    CONTEXT.cos,
    CONTEXT.atan2,
    CONTEXT.exp,
    CONTEXT.log,
    abs,
    max,
)
