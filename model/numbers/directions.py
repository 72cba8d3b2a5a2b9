"""Angles and unit vectors of exact numbers, the same on every machine.

The numbers of a scene are doubles, so they are exact fractions; what follows from them is rounded
once, to far more bits than a double has, and never comes from the machine's own libm.
"""

from __future__ import annotations

from fractions import Fraction
from math import isqrt

import mpmath

from kousoku.model.numbers.digits import exact

#: Bits to which angles and roots are rounded.
BITS = 200

#: Twice the bits first, so that rounding does not depend on the arithmetic that mpmath found. Both
#: are apart from the context that other code may set, and stay as they are.
WIDE, NARROW = mpmath.mp.clone(), mpmath.mp.clone()
WIDE.prec, NARROW.prec = 2 * BITS, BITS


def square_root(value: Fraction) -> Fraction:
    """Square root, exact where it is rational, else to :data:`BITS` bits."""
    root = Fraction(isqrt(value.numerator), isqrt(value.denominator))
    if root * root == value:
        return root
    exponent = (value.denominator.bit_length() - value.numerator.bit_length()) // 2 + BITS + 2
    scale = Fraction(2) ** exponent
    squared = value * scale * scale
    return Fraction(isqrt(squared.numerator // squared.denominator)) / scale


def unit_vector(x: Fraction, y: Fraction) -> tuple[Fraction, Fraction]:
    """Unit vector (x, y)/|(x, y)| (2,) [-]; the length must not be zero."""
    length = square_root(x * x + y * y)
    return x / length, y / length


def heading(x: Fraction | int, y: Fraction | int) -> Fraction:
    """Angle of the vector (x, y) from the axis x, in (−π, π] [rad]."""
    above, right = (
        WIDE.mpf(value.numerator) / value.denominator for value in (Fraction(y), Fraction(x))
    )
    return exact(NARROW.mpf(WIDE.atan2(above, right)))


#: π, rounded to :data:`BITS` bits.
HALF_TURN = heading(-1, 0)
