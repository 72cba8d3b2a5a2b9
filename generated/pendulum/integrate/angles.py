"""Angles as people write them: a number with its unit, ``"30 deg"``, or a part of pi.

Nothing but the standard library is imported here, and no text is evaluated: a copy goes along with
generated solvers.
"""

from __future__ import annotations

import re
from fractions import Fraction

PI = Fraction("3.14159265358979323846264338327950288419716939937510582097494459")

DEGREE = PI / 180
"""One degree in radians."""

LONGEST_NUMBER = 80
"""Characters of the longest number."""

_NUMBER = r"(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]{1,2})?"
_TEXT = re.compile(
    rf"\s*(?P<sign>[+-]?)\s*(?:(?P<number>{_NUMBER})\s*(?:\*?\s*(?P<unit>deg|pi)\b)?"
    rf"|(?P<alone>deg|pi)\b)\s*(?:/\s*(?P<divisor>{_NUMBER})\s*)?",
    re.ASCII,
)
_FACTORS = {None: Fraction(1), "deg": DEGREE, "pi": PI}


class Angle(float):
    """A double that was given as a text; it is written as that text, and is a float otherwise.

    Parameters
    ----------
    text : str
        What :func:`number_of` reads, such as ``"30 deg"``.
    """

    __slots__ = ("exact", "text")

    text: str
    exact: Fraction

    def __new__(cls, text: str) -> Angle:
        """Read the text; `exact` is its value to more than 60 digits.

        Raises
        ------
        ValueError
            As :func:`number_of`.
        """
        exact = _exact(text)
        made = super().__new__(cls, exact)
        made.text, made.exact = text, exact
        return made

    def __reduce__(self) -> tuple[type[Angle], tuple[str]]:
        return Angle, (self.text,)


def number_of(text: str) -> float:
    """Number that a text stands for; an angle, or the rate of one, is in radians.

    Parameters
    ----------
    text : str
        A number, such as ``"0.5"``, degrees, such as ``"30 deg"``, or a part of pi, such as
        ``"pi/6"`` or ``"3*pi/4"``.

    Returns
    -------
    float
        The double that is nearest, of an angle to so many radians.

    Raises
    ------
    ValueError
        The text is something else; the message says what was wanted.
    """
    return float(_exact(text))


def _exact(text: str) -> Fraction:
    found = _TEXT.fullmatch(text) if len(text) <= LONGEST_NUMBER else None
    if found is None or (found["divisor"] and not Fraction(found["divisor"])):
        shown = repr(text if len(text) <= 40 else f"{text[:40]}…")
        is_rate = re.search(r"deg\s*/\s*s(ec)?\s*$", text[:LONGEST_NUMBER])
        hint = "; per second is understood, leave '/s' out" if is_rate else ""
        raise ValueError(
            f"{shown} is no number and no angle, such as 0.5, '30 deg' or 'pi/6'{hint}"
        )
    value = Fraction(found["number"] or 1) * _FACTORS[found["unit"] or found["alone"]]
    value /= Fraction(found["divisor"] or 1)
    return -value if found["sign"] == "-" else value
