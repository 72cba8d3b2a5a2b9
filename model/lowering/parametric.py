"""Scenes and systems whose numbers depend on parameters, and the same with fixed numbers."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import msgspec

from kousoku.model.expressions.design_numbers import changed_scene
from kousoku.model.expressions.parser import parse_expression
from kousoku.model.numbers import precise
from kousoku.model.numbers.traced import parameter, traced
from kousoku.model.numbers.varying import Varying, fixed

if TYPE_CHECKING:
    from collections.abc import Iterator

    from kousoku.model.mechanics.multibody import System
    from kousoku.model.records.design import Formula
    from kousoku.model.records.scene import Scene


def varying_scene(scene: Scene) -> Scene:
    """Checked scene with numbers that can be traced in place of its formulas."""
    if not scene.parameters:
        return scene
    pairs = enumerate(scene.parameters.items())
    known = {name: parameter(name, value, index) for index, (name, value) in pairs}

    def traced_number(formula: Formula, _: str) -> float:
        return precise.double(traced(parse_expression(formula.text, scene.parameters), known))

    return changed_scene(scene, traced_number)


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
            member = getattr(value, name)
            yield from _positive(member, f"{key}.{name}", is_wanted=name in wanted)


def fixed_system(system: System) -> System:
    """System with the numbers of the scene, for decisions before a run."""
    numeric = fixed(system) if system.parameters else system
    return replace(numeric, positive=()) if numeric.positive else numeric
