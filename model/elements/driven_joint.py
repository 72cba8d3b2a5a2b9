"""A driver of a coordinate that a joint leaves free."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.model.elements.checks import check_leaves
from kousoku.model.elements.driver import DriverKind, require_value

if TYPE_CHECKING:
    from collections.abc import Iterator

    from kousoku.model.elements.driver import Driven
    from kousoku.model.lowering.coordinates import CoordinateList
    from kousoku.model.records.scene import Scene
    from kousoku.model.records.spatial import Driver, Value


class DrivenJoint(DriverKind):
    """The angle or displacement of a joint as a function of time: u − f(t) = 0 (1,) [rad or m]."""

    title = "the angle or the displacement of a joint as a function of time"
    keys = ("joint", "of", "value")

    def driven(self, scene: Scene, driver: Driver, key: str) -> Iterator[Driven]:
        """Joint, and which of its free coordinates."""
        require_value(driver, key)
        joint = driver.joint or ""
        yield joint, check_leaves(scene, joint, driver.of, key)

    def laws(
        self, name: str, driver: Driver, coordinates: CoordinateList
    ) -> Iterator[tuple[int, Value]]:
        """Coordinate u that the joint leaves free, and its law f(t) [rad or unit of the scene]."""
        assert driver.joint is not None
        assert driver.value is not None
        yield coordinates.of_joint(driver.joint, driver.of), driver.value

    def of_joint(self, scene: Scene, driver: Driver) -> tuple[str, str | None] | None:
        """Joint, and which of its free coordinates."""
        return driver.joint or "", driver.of
