"""Read the formulas of parameters that stand in place of numbers of a design, and check them."""

from __future__ import annotations

from math import isfinite
from typing import TYPE_CHECKING, Any, TypeVar, cast

import msgspec

from kousoku.model.errors import ExpressionError
from kousoku.model.expressions.formulas import TIME, WORD, state_names, used_names
from kousoku.model.expressions.parser import parse_expression
from kousoku.model.expressions.values import value_of
from kousoku.model.operations.expression import names_of
from kousoku.model.records.design import LARGEST, Formula
from kousoku.model.records.dotted_keys import join

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Mapping

    from kousoku.model.records.problems import Problems
    from kousoku.model.records.scene import Scene

    T = TypeVar("T")

TABLES = ("bodies", "joints", "coordinates", "drivers", "forces")
"""The tables with numbers of a design."""

FORMULAS = "formulas"
"""Key that a wrong formula breaks beside its element: what is computed from the whole element."""


def read_formulas(scene: Scene, problems: Problems) -> Scene:
    """Scene whose formulas have the values that its parameters give them.

    Parameters
    ----------
    scene : Scene
        As it was decoded.
    problems : Problems
        Where to note wrong formulas; such a formula becomes 1, and its element is broken.
    """
    values: dict[str, float] = {}
    broken = problems.broken("parameters")
    moving = state_names(scene) - {*scene.parameters}
    exact: dict[str, Any] = {}

    def number(formula: Formula, key: str) -> float:
        if formula.text in values:
            return values[formula.text]
        is_known = not problems.is_broken("parameters") and not used_names(formula.text, broken)
        if is_known and not problems.is_full:
            try:
                _require_fixed(formula.text, moving)
                exact.update({} if exact else _in_fifty_digits(scene.parameters))
                values[formula.text] = _value(formula.text, scene.parameters, exact)
                return values[formula.text]
            except ExpressionError as error:
                problems.add(str(error), key)
        element = ".".join(key.split(".")[:2])
        problems.break_(element)
        problems.break_(join(element, FORMULAS))
        return 1.0

    return changed_scene(scene, number)


def with_numbers(scene: Scene) -> Scene:
    """Scene with the values of its formulas in place of them."""
    if not scene.parameters:
        return scene
    return changed_scene(scene, lambda formula, _: float(formula))


def _require_fixed(text: str, moving: Collection[str]) -> None:
    """Refuse a formula of names that change in a run."""
    for match in WORD.finditer(text):
        if (name := match.group()) in moving:
            quantity = "the time" if name == TIME else f"{name}, which moves"
            problem = f"depends on {quantity}; a number of the design may depend on parameters only"
            raise ExpressionError(problem, column=match.start() + 1)


def _in_fifty_digits(parameters: Mapping[str, float]) -> dict[str, Any]:
    from kousoku.model.numbers.digits import CONTEXT

    return {name: CONTEXT.mpf(value) for name, value in parameters.items()}


def _value(text: str, parameters: Mapping[str, float], exact: Mapping[str, Any]) -> float:
    """Value of a formula in a scene, which must be finite in 50 digits and in doubles."""
    from kousoku.model.numbers.traced import traced

    expression = parse_expression(text, parameters)
    value = float(traced(expression, exact))
    if not abs(value) <= LARGEST or not isfinite(value_of(expression, parameters)):
        problem = "has no finite value with the parameters of the scene"
        raise ExpressionError(f"{problem}; wanted at most {LARGEST:g}", column=1)
    return Formula(text, value) if names_of(expression) else value


def changed_scene(scene: Scene, change: Callable[[Formula, str], float]) -> Scene:
    """Scene with other numbers in place of its formulas, itself where it has none.

    Parameters
    ----------
    scene : Scene
        The scene that is changed.
    change : callable
        Gets a formula and its dotted key.
    """
    tables = {}
    for table in TABLES:
        old = getattr(scene, table)
        new = {name: _with(item, join(table, name), change) for name, item in old.items()}
        if any(new[name] is not item for name, item in old.items()):
            tables[table] = new
    return msgspec.structs.replace(scene, **tables) if tables else scene


def _with(value: T, key: str, change: Callable[[Formula, str], float]) -> T:
    """Record, tuple or number with its formulas changed, itself where it has none."""
    result: Any = value
    if isinstance(value, Formula):
        result = change(value, key)
    elif isinstance(value, tuple):
        elements = tuple(_with(item, f"{key}[{k}]", change) for k, item in enumerate(value))
        result = value if all(a is b for a, b in zip(elements, value, strict=True)) else elements
    elif isinstance(value, msgspec.Struct):
        names = zip(value.__struct_fields__, value.__struct_encode_fields__, strict=True)
        members = [(name, encoded, getattr(value, name)) for name, encoded in names]
        flat = getattr(value, "FLAT", "")
        pairs = (
            (name, old, _with(old, key if name == flat else join(key, encoded), change))
            for name, encoded, old in members
        )
        changed = {name: new for name, old, new in pairs if new is not old}
        result = msgspec.structs.replace(value, **changed) if changed else value
    elif isinstance(value, dict):
        items = {name: _with(item, join(key, name), change) for name, item in value.items()}
        result = items if any(items[name] is not item for name, item in value.items()) else value
    return cast("T", result)
