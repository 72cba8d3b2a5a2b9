"""Keys that one kind of force, joint, coupling or driver has beside those of its record."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Literal

if TYPE_CHECKING:
    from collections.abc import Mapping

Dependence = Literal["nothing", "parameters", "time", "law", "motion"]
"""What formulas of a key may depend on: ``parameters`` only, or ``time`` too, of which those of
drivers have two derivatives, or ``law`` with elongation, rate and time, or ``motion`` with time,
coordinates and their rates. ``nothing`` where it has no formulas
that are checked with the forces: names of elements, and numbers of type
:data:`~kousoku.model.records.design.Design`, whose formulas are read with them."""


@dataclass(frozen=True, slots=True)
class ElementInput:
    """A key that one kind has beside the keys of its record, a force, a joint or a driver.

    Parameters
    ----------
    type : object
        The type of its value in a scene, such as :data:`~kousoku.model.records.spatial.Value`.
    meaning : str
        What it is, with its unit.
    depends_on : {"nothing", "parameters", "time", "law", "motion"}
        Of a force or a driver, what its formulas may depend on.
    """

    type: object
    meaning: str
    depends_on: Dependence = "nothing"


class ElementKind(ABC):
    """A kind of force, coupling or driver, by the keys that a scene gives of it.

    Attributes
    ----------
    title : str
        What it is, in one line.
    inputs : mapping of str to ElementInput
        Keys that it alone has; a scene has their values in the ``inputs`` of its record.
    """

    title: ClassVar[str]
    inputs: ClassVar[Mapping[str, ElementInput]] = {}

    @property
    @abstractmethod
    def keys(self) -> tuple[str, ...]:
        """Keys of its record that it has: of a ``Force``, a ``Joint`` or a ``Driver``."""

    @property
    def all_keys(self) -> tuple[str, ...]:
        """Its keys in a scene, beside its type."""
        return (*self.keys, *self.inputs)


def key_value(record: object, name: str) -> object:
    """Value of a key of a record, or of one that its kind alone has; None where it is left out."""
    inputs = getattr(record, getattr(record, "FLAT", ""), None) or {}
    return inputs[name] if name in inputs else getattr(record, name, None)
