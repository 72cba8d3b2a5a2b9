"""Numbers that belong to a design: masses, lengths, points, axes. They may be formulas.

In a file a formula of parameters is a text; in a scene that was read it is a :class:`Formula`,
a double with the value that it has there.
"""

from __future__ import annotations

from typing import Annotated, Any, NoReturn

import msgspec

Design = Annotated[float, msgspec.Meta(extra_json_schema={"formula": True})]
"""A number, or in a file the text of a formula of parameters."""

NumberOrAngle = Annotated[float, msgspec.Meta(extra_json_schema={"angle": True})]
"""A number, or in a file the text of an angle, such as ``"30 deg"``, which is one in radians."""

Turns = tuple[NumberOrAngle, NumberOrAngle, NumberOrAngle]
"""Three angles, or a vector of an angular velocity."""

DesignVector = tuple[Design, Design, Design]
"""Three such numbers: a point, or a direction."""

LARGEST = 1e50
"""Numbers beyond it are refused: their products would leave the range of doubles."""

CLOSURE_TOLERANCE = 1e-4
"""Default of ``closure_tolerance``: largest miss of redundant rows [lengths of the scene, rad]."""


class Guarded(float):
    """A double that depends on parameters: it is compared as a double is, but equals none.

    It cannot be computed with, so that no formula is lost.
    """

    __slots__ = ()

    def __bool__(self) -> bool:
        return True

    def __ne__(self, other: object) -> bool:
        return not self == other

    def __deepcopy__(self, memo: object) -> Guarded:
        return self

    def _refuse(self, *_: object) -> NoReturn:
        raise TypeError(f"{self!r} depends on parameters: what is computed with it would not")

    __add__ = __radd__ = __sub__ = __rsub__ = __mul__ = __rmul__ = _refuse
    __truediv__ = __rtruediv__ = __floordiv__ = __rfloordiv__ = _refuse
    __pow__ = __rpow__ = __neg__ = as_integer_ratio = _refuse


class Formula(Guarded):
    """A number of a scene that is a formula of parameters.

    Parameters
    ----------
    text : str
        The formula.
    value : float
        What it is with the parameters of the scene; not a number while the scene is being read.
    """

    __slots__ = ("text",)

    text: str

    def __new__(cls, text: str, value: float = float("nan")) -> Formula:
        """Keep the text."""
        number = super().__new__(cls, value)
        number.text = text
        return number

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Formula) and self.text == other.text

    def __hash__(self) -> int:
        return hash(self.text)

    def __repr__(self) -> str:
        return repr(self.text)

    def __reduce__(self) -> tuple[Any, ...]:
        return Formula, (self.text, float(self))
