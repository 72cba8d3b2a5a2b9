"""A coupling that is not shipped: a belt over two pulleys."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from kousoku.model.elements.coupling import Coupling
from kousoku.model.elements.inputs import ElementInput
from kousoku.model.elements.joint import ANGLE
from kousoku.model.errors import SceneError
from kousoku.model.records.design import Design

if TYPE_CHECKING:
    from kousoku.model.lowering.coordinates import CoordinateList
    from kousoku.model.mechanics.multibody import Instance
    from kousoku.model.records.scene import Scene
    from kousoku.model.records.spatial import Joint


class Belt(Coupling):
    """A belt over two pulleys, which turn the same way."""

    title = "the angles of two joints, by a belt over two pulleys"
    wanted: ClassVar = {"joints": "the names of two joints"}
    inputs: ClassVar = {"radii": ElementInput(tuple[Design, Design], "the radii of two pulleys")}
    couples = (ANGLE, ANGLE)
    aliases = ("chain_drive",)

    def check(self, scene: Scene, joint: Joint, key: str) -> None:
        """Refuse pulleys without a radius."""
        for index, radius in enumerate(joint.input("radii")):
            if isinstance(radius, float) and radius <= 0:
                raise SceneError(
                    f"a radius of {radius}; wanted a positive one", key=f"{key}.radii[{index}]"
                )

    def combination(self, name: str, joint: Joint, coordinates: CoordinateList) -> Instance:
        """Combination radius · angle of the second − radius · angle of the first."""
        from kousoku.model.elements.combinations import as_written
        from kousoku.model.numbers import precise

        first, second = (coordinates.of_joint(one, ANGLE) for one in joint.joints or ())
        radii = (coordinates.unit * precise.number(one) for one in joint.input("radii"))
        small, large = radii
        return as_written(name, [(second, large), (first, -small)], coordinates)
