"""A driver of a coordinate of the scene."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.model.elements.driver import DriverKind, require_value
from kousoku.model.elements.joints import sort_of
from kousoku.model.errors import SceneError
from kousoku.model.records.dotted_keys import join, require_known

if TYPE_CHECKING:
    from collections.abc import Iterator

    from kousoku.model.elements.driver import Driven
    from kousoku.model.lowering.coordinates import CoordinateList
    from kousoku.model.records.scene import Scene
    from kousoku.model.records.spatial import Driver, Value


class DrivenCoordinate(DriverKind):
    """A coordinate as a function of time: C = u − f(t) = 0 (1,) [m or rad]."""

    title = "a coordinate as a function of time"
    keys = ("coordinate", "value")

    def driven(self, scene: Scene, driver: Driver, key: str) -> Iterator[Driven]:
        """Driven coordinate; one that is held is refused."""
        require_value(driver, key)
        name = driver.coordinate or ""
        require_known("coordinate", name, scene.coordinates, f"{key}.coordinate")
        coordinate = scene.coordinates[name]
        if coordinate.hold:
            raise SceneError(
                f"{name} is driven by {key}; a driver says where it is, leave 'hold' out",
                key=join("coordinates", name) + ".hold",
            )
        if coordinate.joint is not None:
            yield coordinate.joint, sort_of(scene.joints[coordinate.joint].type, coordinate.of)
        elif coordinate.bodies is not None and coordinate.points is not None:
            yield frozenset(zip(coordinate.bodies, coordinate.points, strict=True)), "length"
        else:
            yield coordinate.body, coordinate.point or (0.0, 0.0, 0.0), coordinate.along

    def laws(
        self, name: str, driver: Driver, coordinates: CoordinateList
    ) -> Iterator[tuple[int, Value]]:
        """Coordinate u and its law f(t), in the unit of the scene or rad."""
        assert driver.coordinate is not None
        assert driver.value is not None
        yield coordinates.index_of(driver.coordinate), driver.value

    def of_joint(self, scene: Scene, driver: Driver) -> tuple[str, str | None] | None:
        """Joint of the coordinate, and which of its free coordinates, if it has a joint."""
        coordinate = scene.coordinates[driver.coordinate or ""]
        return None if coordinate.joint is None else (coordinate.joint, coordinate.of)

    def near(self, scene: Scene, driver: Driver) -> tuple[str, float] | None:
        """Name of the coordinate and its ``near``, if that is given."""
        name = driver.coordinate or ""
        near = scene.coordinates[name].near
        return None if near is None else (name, near)
