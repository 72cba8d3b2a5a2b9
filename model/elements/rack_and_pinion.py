"""A rack and pinion: the angle of one joint and the displacement of another."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from kousoku.model.elements.coupling import Coupling
from kousoku.model.elements.joint import ANGLE, DISPLACEMENT

if TYPE_CHECKING:
    from kousoku.model.lowering.coordinates import CoordinateList
    from kousoku.model.mechanics.multibody import Instance
    from kousoku.model.records.spatial import Joint


class RackAndPinion(Coupling):
    """The angle of one joint and the displacement of another: x − radius θ + c₀ = 0 (1,) [m]."""

    title = "the angle of one joint and the displacement of another"
    wanted: ClassVar = {
        "joints": "the names of two joints",
        "radius": "the displacement of the rack by the angle of the pinion",
    }
    couples = (ANGLE, DISPLACEMENT)
    not_zero = ("radius",)
    aliases = ("rack", "rackpin")

    def combination(self, name: str, joint: Joint, coordinates: CoordinateList) -> Instance:
        """Combination displacement of the rack − radius · the angle of the pinion [m]."""
        from kousoku.model.elements.combinations import as_written
        from kousoku.model.numbers import precise

        assert joint.joints is not None
        assert joint.radius is not None
        angle = coordinates.of_joint(joint.joints[0], ANGLE)
        displacement = coordinates.of_joint(joint.joints[1], DISPLACEMENT)
        radius = coordinates.unit * precise.number(joint.radius)
        return as_written(name, [(displacement, 1), (angle, -radius)], coordinates)
