"""Keys of a scene that one kind of force, joint or coupling has beside those of all."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Dependence = Literal["nothing", "parameters", "law", "motion"]
"""What formulas of a key may depend on: ``parameters`` only, or ``law`` with elongation, rate and
time, or ``motion`` with time, coordinates and their rates. ``nothing`` where it has no formulas
that are checked with the forces: names of elements, and numbers of type
:data:`~kousoku.model.design.Design`, whose formulas are read with them."""


@dataclass(frozen=True, slots=True)
class ElementInput:
    """A key that one kind has beside those of :class:`~kousoku.model.loads.Force` or ``Joint``.

    Parameters
    ----------
    type : object
        The type of its value in a scene, such as :data:`~kousoku.model.spatial.Value`.
    meaning : str
        What it is, with its unit.
    depends_on : {"nothing", "parameters", "law", "motion"}
        Of a force, what its formulas may depend on.
    """

    type: object
    meaning: str
    depends_on: Dependence = "nothing"
