"""A gear: the angles of two joints, in a ratio."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from kousoku.model.elements.coupling import Coupling
from kousoku.model.elements.joint import ANGLE

if TYPE_CHECKING:
    from kousoku.model.lowering.coordinates import CoordinateList
    from kousoku.model.mechanics.multibody import Instance
    from kousoku.model.records.spatial import Joint


class Gear(Coupling):
    """The angles of two joints, in a ratio: C = θ₂ − ratio θ₁ + c₀ = 0 (1,) [rad]."""

    title = "the angles of two joints, in a ratio"
    wanted: ClassVar = {
        "joints": "the names of two joints",
        "ratio": "the turns of the second joint by a turn of the first",
    }
    couples = (ANGLE, ANGLE)
    not_zero = ("ratio",)
    aliases = ("gears",)

    def combination(self, name: str, joint: Joint, coordinates: CoordinateList) -> Instance:
        """Combination second angle − ratio · the first [rad]."""
        from kousoku.model.elements.combinations import as_written
        from kousoku.model.numbers import precise

        assert joint.joints is not None
        assert joint.ratio is not None
        first, second = (coordinates.of_joint(geared, ANGLE) for geared in joint.joints)
        return as_written(name, [(second, 1), (first, -precise.number(joint.ratio))], coordinates)
