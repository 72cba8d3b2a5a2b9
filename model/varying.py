"""Numbers of a system that depend on parameters, as doubles with the value of the scene."""

from __future__ import annotations

from dataclasses import fields, is_dataclass, replace
from typing import TYPE_CHECKING, Any, TypeVar, cast

import msgspec

from kousoku.model.design import Formula, Guarded
from kousoku.model.design_numbers import changed_scene
from kousoku.model.expression import parse_expression
from kousoku.model.traced import Traced, at_scene, parameter, traced

if TYPE_CHECKING:
    from collections.abc import Iterator

    from kousoku.model.multibody import System
    from kousoku.model.scene import Scene

    T = TypeVar("T")


class Varying(Guarded):
    """A double that depends on parameters; :func:`kousoku.model.precise.number` computes with it.

    Parameters
    ----------
    traced : Traced
        The number in 50 digits, with its formula.
    """

    __slots__ = ("traced",)

    traced: Traced

    def __new__(cls, traced: Traced) -> Varying:
        """Round the value that it has in the scene."""
        made = super().__new__(cls, float(at_scene(traced)))
        made.traced = traced
        return made

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Varying) and self.traced == other.traced

    def __hash__(self) -> int:
        return hash(self.traced)

    def __repr__(self) -> str:
        return f"{float(self)!r} of {self.traced.expression.key}"

    def __reduce__(self) -> tuple[Any, ...]:
        return Varying, (self.traced,)


def varying_scene(scene: Scene) -> Scene:
    """Checked scene with numbers that can be traced in place of its formulas."""
    if not scene.parameters:
        return scene
    pairs = enumerate(scene.parameters.items())
    known = {name: parameter(name, value, place) for place, (name, value) in pairs}

    def read(given: Formula, _: str) -> float:
        value = traced(parse_expression(given.text, scene.parameters), known)
        return Varying(value) if isinstance(value, Traced) else float(value)

    return changed_scene(scene, read)


POSITIVE: dict[str, tuple[str, ...]] = {
    "Body": ("mass",),
    "Joint": ("length",),
    "MassPoint": ("mass",),
    "Box": ("mass", "size"),
    "Rod": ("mass",),
    "Cylinder": ("mass", "radius"),
    "Sphere": ("mass", "radius"),
}
"""The numbers of each record that must be positive."""


def positive_numbers(scene: Scene) -> Iterator[tuple[str, float]]:
    """Numbers that depend on parameters and must be positive, with their keys."""
    for table in ("bodies", "joints") if scene.parameters else ():
        for name, item in getattr(scene, table).items():
            yield from _positive(item, f"{table}.{name}", is_wanted=False)


def _positive(value: object, key: str, *, is_wanted: bool) -> Iterator[tuple[str, float]]:
    if isinstance(value, Varying):
        if is_wanted:
            yield key, value
    elif isinstance(value, tuple):
        for k, item in enumerate(value):
            yield from _positive(item, f"{key}[{k}]", is_wanted=is_wanted)
    elif isinstance(value, msgspec.Struct):
        wanted = POSITIVE.get(type(value).__name__, ())
        for name in value.__struct_fields__:
            part = getattr(value, name)
            yield from _positive(part, f"{key}.{name}", is_wanted=name in wanted)


def is_varying(value: object) -> bool:
    """Whether a number, or one in a tuple, depends on parameters."""
    if isinstance(value, tuple):
        return any(map(is_varying, value))
    return isinstance(value, Varying)


def fixed(value: T) -> T:
    """Number, tuple or record with the numbers of the scene, which nothing varies.

    What has no number that varies is returned as it is.
    """
    found: Any = value
    if isinstance(value, Varying):
        found = float(value)
    elif isinstance(value, tuple):
        parts = tuple(map(fixed, value))
        found = value if all(a is b for a, b in zip(parts, value, strict=True)) else parts
    elif is_dataclass(value) and not isinstance(value, type):
        given = {field.name: getattr(value, field.name) for field in fields(value)}
        changed = {name: fixed(part) for name, part in given.items()}
        changed = {name: part for name, part in changed.items() if part is not given[name]}
        found = replace(value, **changed) if changed else value
    return cast("T", found)


def fixed_system(system: System) -> System:
    """System with the numbers of the scene: for what is decided before it runs."""
    found = fixed(system) if system.parameters else system
    return replace(found, positive=()) if found.positive else found
