"""A driver that is not shipped: the angle of a joint swings to and fro."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from kousoku.model.elements.checks import check_leaves
from kousoku.model.elements.driver import DriverKind
from kousoku.model.elements.inputs import ElementInput
from kousoku.model.elements.joint import ANGLE
from kousoku.model.errors import SceneError
from kousoku.model.linkage.input_drivers import formula_text
from kousoku.model.records.spatial import Value

if TYPE_CHECKING:
    from collections.abc import Iterator

    from kousoku.model.elements.driver import Driven
    from kousoku.model.lowering.coordinates import CoordinateList
    from kousoku.model.records.scene import Scene
    from kousoku.model.records.spatial import Driver


class Swing(DriverKind):
    """The angle of a joint, to and fro about where it is written."""

    title = "the angle of a joint, to and fro"
    keys = ()
    inputs: ClassVar = {
        "swing": ElementInput(str, "the joint"),
        "amplitude": ElementInput(float, "its largest angle [rad]"),
        "phase": ElementInput(Value, "the angle of its sine, a formula of t [rad]", "time"),
    }

    def driven(self, scene: Scene, driver: Driver, key: str) -> Iterator[Driven]:
        """Joint that is driven; it is refused without amplitude or phase."""
        for name in ("amplitude", "phase"):
            if driver.input(name) is None:
                raise SceneError("is missing; a swing wants it", key=f"{key}.{name}")
        joint = driver.input("swing")
        yield joint, check_leaves(scene, joint, ANGLE, key)

    def laws(
        self, name: str, driver: Driver, coordinates: CoordinateList
    ) -> Iterator[tuple[int, Value]]:
        """Law amplitude · sin(phase)."""
        place = coordinates.of_joint(driver.input("swing"), ANGLE)
        yield place, f"{driver.input('amplitude')}*sin({formula_text(driver.input('phase'))})"
