"""A screw: a turn about an axis and, with it, a displacement along it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from kousoku.model.elements.joint import ANGLE, DISPLACEMENT, JointKind
from kousoku.model.errors import SceneError
from kousoku.model.text import with_a

if TYPE_CHECKING:
    from kousoku.model.lowering.coordinates import CoordinateList
    from kousoku.model.mechanics.multibody import Instance
    from kousoku.model.records.spatial import Joint


@dataclass(frozen=True, slots=True)
class Screw(JointKind):
    """A turn about an axis and, with it, a displacement: C = x − pitch θ / 2π + c₀ = 0 (1,) [m]."""

    def check_numbers(self, joint: Joint, key: str) -> None:
        """Refuse a screw without a pitch, and one that does not advance."""
        if joint.pitch is None:
            raise SceneError(
                f"is missing; {with_a(joint.type)} joint wants its advance in one turn",
                key=f"{key}.pitch",
            )
        if joint.pitch == 0:
            raise SceneError(
                "a pitch of zero does not advance; take a revolute joint", key=f"{key}.pitch"
            )

    def combination(self, name: str, joint: Joint, coordinates: CoordinateList) -> Instance:
        """Combination displacement − pitch / 2π · angle [m]."""
        from kousoku.model.elements.combinations import as_written
        from kousoku.model.numbers import precise
        from kousoku.model.numbers.digits import CONTEXT

        assert joint.pitch is not None
        angle = coordinates.of_joint(name, ANGLE)
        displacement = coordinates.of_joint(name, DISPLACEMENT)
        advance = coordinates.unit * precise.number(joint.pitch) / (2 * CONTEXT.pi)
        return as_written(name, [(displacement, 1), (angle, -advance)], coordinates)
