"""Numbers of a system that depend on parameters, as doubles with the value of the scene."""

from __future__ import annotations

from dataclasses import fields, is_dataclass, replace
from typing import TYPE_CHECKING, Any, TypeVar, cast

from kousoku.model.numbers.traced import Traced, at_scene
from kousoku.model.records.design import Guarded

if TYPE_CHECKING:
    T = TypeVar("T")


class Varying(Guarded):
    """A double that depends on parameters, see :func:`kousoku.model.numbers.precise.number`.

    A :class:`~kousoku.model.records.design.Formula` of a scene is another class: it has a text, and
    scenes are read and written without 50 digits.

    Parameters
    ----------
    traced : Traced
        The number in 50 digits, with its formula.
    """

    __slots__ = ("traced",)

    traced: Traced

    def __new__(cls, traced: Traced) -> Varying:
        """Round the value that it has in the scene."""
        rounded = super().__new__(cls, float(at_scene(traced)))
        rounded.traced = traced
        return rounded

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Varying) and self.traced == other.traced

    def __hash__(self) -> int:
        return hash(self.traced)

    def __repr__(self) -> str:
        return f"{float(self)!r} of {self.traced.expression.key}"

    def __reduce__(self) -> tuple[Any, ...]:
        return Varying, (self.traced,)


def is_varying(value: object) -> bool:
    """Whether a number, or one in a tuple, depends on parameters."""
    if isinstance(value, tuple):
        return any(map(is_varying, value))
    return isinstance(value, Varying)


def fixed(value: T) -> T:
    """Number, tuple or record with the numbers of the scene, which do not vary.

    A value without a number that varies is returned as it is.
    """
    result: Any = value
    if isinstance(value, Varying):
        result = float(value)
    elif isinstance(value, tuple):
        elements = tuple(map(fixed, value))
        result = value if all(a is b for a, b in zip(elements, value, strict=True)) else elements
    elif is_dataclass(value) and not isinstance(value, type):
        members = {field.name: getattr(value, field.name) for field in fields(value)}
        changed = {name: fixed(member) for name, member in members.items()}
        changed = {name: member for name, member in changed.items() if member is not members[name]}
        result = replace(value, **changed) if changed else value
    return cast("T", result)
