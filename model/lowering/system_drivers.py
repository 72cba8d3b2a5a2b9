"""Turn the drivers of a scene into combinations of coordinates that depend on time."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.model.elements.drivers import kind_of
from kousoku.model.elements.joint import ANGLES
from kousoku.model.elements.joints import sort_of
from kousoku.model.expressions.formulas import TIME
from kousoku.model.expressions.parser import parse_expression
from kousoku.model.expressions.values import value_of
from kousoku.model.linkage.input_drivers import drivers_of, formula_text
from kousoku.model.mechanics.constraints import COMBINATION
from kousoku.model.mechanics.multibody import Instance, Term

if TYPE_CHECKING:
    from collections.abc import Iterator

    from kousoku.model.lowering.coordinates import CoordinateList
    from kousoku.model.records.scene import Scene
    from kousoku.model.records.spatial import Value


def start_values(scene: Scene, coordinates: CoordinateList) -> None:
    """Give a list of coordinates the initial values of driven angles, which fix their turns.

    A coordinate that states its own approximate value keeps that.
    """
    for driver in drivers_of(scene).values():
        driven = kind_of(driver).of_joint(scene, driver)
        if driven is None or driver.value is None:
            continue
        joint, of = driven
        sort = sort_of(scene.joints[joint].type, of)
        if sort in ANGLES:
            coordinates.starts_at(joint, sort, _at_start(scene, driver.value))


def _at_start(scene: Scene, value: Value) -> float:
    expression = parse_expression(formula_text(value), (TIME, *scene.parameters))
    return value_of(expression, {**scene.parameters, TIME: 0.0})


def driver_instances(scene: Scene, coordinates: CoordinateList) -> Iterator[Instance]:
    """Drivers of a scene as combinations: coordinate − law = 0."""
    for name, driver in drivers_of(scene).items():
        for index, value in kind_of(driver).laws(name, driver, coordinates):
            yield _driver(name, index, value, coordinates)


def _driver(name: str, index: int, value: Value, coordinates: CoordinateList) -> Instance:
    i, j = coordinates.ends(index)
    unit, scale = coordinates.unit_of(index)
    return Instance(
        name,
        COMBINATION,
        i,
        j,
        terms=(Term(index, 1.0),),
        law=formula_text(value),
        law_unit=float(scale),
        unit=unit,
    )
