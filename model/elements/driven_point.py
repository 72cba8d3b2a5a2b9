"""A driver of a point of a body, on a path."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.model.elements.checks import check_place
from kousoku.model.elements.driver import DriverKind
from kousoku.model.errors import SceneError

if TYPE_CHECKING:
    from collections.abc import Iterator

    from kousoku.model.elements.driver import Driven
    from kousoku.model.lowering.coordinates import CoordinateList
    from kousoku.model.records.scene import Scene
    from kousoku.model.records.spatial import Driver, Value


class DrivenPoint(DriverKind):
    """A point on a path, three functions of time: r + A s′ − f(t) = 0 (3,) [m], frame O."""

    title = "a point on a path, three functions of time"
    keys = ("body", "point", "path")

    def driven(self, scene: Scene, driver: Driver, key: str) -> Iterator[Driven]:
        """Components of the position of the point along the axes of frame O."""
        check_place(scene, driver.body or "", driver.point, key)
        if driver.path is None:
            raise SceneError("is missing; wanted three formulas", key=f"{key}.path")
        for k in range(3):
            direction = tuple(float(k == axis) for axis in range(3))
            yield driver.body, driver.point or (0.0, 0.0, 0.0), direction

    def laws(
        self, name: str, driver: Driver, coordinates: CoordinateList
    ) -> Iterator[tuple[int, Value]]:
        """Components along the axes of frame O and their laws f(t), in the unit of the scene."""
        from kousoku.model.mechanics.frames import DIRECTIONS
        from kousoku.model.mechanics.measures import place_measure
        from kousoku.model.numbers import precise

        assert driver.body is not None
        assert driver.path is not None
        point = precise.triple(driver.point or (0.0, 0.0, 0.0))
        for (letter, axis), value in zip(DIRECTIONS.items(), driver.path, strict=True):
            measure = place_measure(coordinates.frames[driver.body], point, precise.triple(axis))
            yield coordinates.add(f"{name}.{letter}", measure), value
