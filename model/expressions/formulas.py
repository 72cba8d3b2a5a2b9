"""Values of a scene that are numbers or formulas: which names a formula may use, and its check."""

from __future__ import annotations

import re
from collections import ChainMap
from itertools import chain
from math import isfinite
from typing import TYPE_CHECKING, cast

import msgspec

from kousoku.model.errors import ExpressionError, Problem
from kousoku.model.expressions.parser import parse_expression
from kousoku.model.expressions.values import value_of
from kousoku.model.records.design import Formula

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable, Iterator, Mapping

    from kousoku.model.records.scene import Scene

WORD = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
"""What may be a name."""

TIME = "t"
"""The name of time in a formula."""

RATE = "_dot"
"""What follows the name of a coordinate where its rate is meant."""

WITH_FORMULAS = ("bodies", "joints", "coordinates", "drivers", "forces", "events", "gravity")
"""The keys of a scene of bodies under which a formula may stand."""


def fixed_names(scene: Scene, *also: str) -> Mapping[str, float]:
    """Parameters, which do not change in a run, and names `also` with the value 0.

    The parameters are not copied: each formula asks for them.
    """
    return ChainMap(dict.fromkeys(also, 0.0), cast("dict[str, float]", scene.parameters))


def state_names(scene: Scene) -> frozenset[str]:
    """Names that a formula of the motion may depend on: time, parameters, coordinates, rates."""
    rates = (f"{name}{RATE}" for name in scene.coordinates)
    return frozenset((TIME, *scene.parameters, *scene.coordinates, *rates))


def used_names(formula: str, names: Collection[str]) -> tuple[str, ...]:
    """Names among ``names`` that stand in a formula, in the order of its text.

    Factors of zero count, too: the formula cannot be read without them.
    """
    return tuple(dict.fromkeys(name for name in WORD.findall(formula) if name in names))


def used_coordinates(scene: Scene, formulas: Iterable[str]) -> list[str]:
    """Coordinates that formulas of a scene name, or whose rates they name."""
    known = state_names(scene)
    names = chain.from_iterable(used_names(text, known) for text in formulas)
    rates = {f"{name}{RATE}": name for name in scene.coordinates}
    used = dict.fromkeys(rates.get(name, name) for name in names)
    return [name for name in used if name in scene.coordinates]


def used_parameters(scene: Scene) -> dict[str, float]:
    """Parameters of a scene of bodies that stand in its formulas."""
    if not scene.parameters:
        return {}
    texts = " ".join(text for part in WITH_FORMULAS for text in texts_of(getattr(scene, part)))
    used = used_names(texts, scene.parameters)
    return {name: value for name, value in scene.parameters.items() if name in used}


def texts_of(value: object) -> Iterator[str]:
    """Texts in a part of a scene, names of elements among them."""
    if isinstance(value, str):
        yield value
    elif isinstance(value, Formula):
        yield value.text
    elif isinstance(value, msgspec.Struct):
        for name in value.__struct_fields__:
            yield from texts_of(getattr(value, name))
    elif isinstance(value, tuple):
        for item in value:
            yield from texts_of(item)
    elif hasattr(value, "values"):
        for item in value.values():
            yield from texts_of(item)


def values_at_start(scene: Scene) -> Mapping[str, float]:
    """Values that are known before the scene is put together: parameters, and t = 0."""
    return fixed_names(scene, TIME)


def formula_problems(
    value: object, names: Collection[str], key: str, start: Mapping[str, float]
) -> Iterator[Problem]:
    """Problems of the formulas of a value.

    Parameters
    ----------
    value : float, str, or tuple of them
        A number has no problem.
    names : collection of str
        What its formulas may depend on.
    key : str
        Its dotted key.
    start : mapping of str to float
        Values that are known at the start: a formula of these alone must have a finite value.
    """
    if isinstance(value, tuple):
        for index, item in enumerate(value):
            yield from formula_problems(item, names, f"{key}[{index}]", start)
    elif isinstance(value, str):
        try:
            formula = parse_expression(value, names)
        except ExpressionError as error:
            yield Problem(str(error), key)
            return
        is_known = all(name in start for name in used_names(value, names))
        if is_known and not isfinite(value_of(formula, start)):
            yield Problem("has no finite value at t = 0; wanted one", key)


LAW_NAMES = ("x", "v", "t")
"""What the tension of a spring may depend on: elongation, rate of its length, time."""
