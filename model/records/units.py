"""Units of length of scenes."""

from __future__ import annotations

from fractions import Fraction
from typing import Literal

Unit = Literal["m", "dm", "cm", "mm", "um", "km", "in", "ft"]
#: Lengths of the units of scenes [m].
METRES: dict[str, Fraction] = {
    "m": Fraction(1),
    "dm": Fraction(1, 10),
    "cm": Fraction(1, 100),
    "mm": Fraction(1, 1000),
    "um": Fraction(1, 10**6),
    "km": Fraction(1000),
    "in": Fraction(254, 10**4),
    "ft": Fraction(3048, 10**4),
}
