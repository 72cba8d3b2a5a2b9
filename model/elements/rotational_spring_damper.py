"""A spring and damper against an angle."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.model.elements.along import known_coordinate
from kousoku.model.elements.checks import check_leaves
from kousoku.model.elements.coordinate_spring import linear_spring, spring_against
from kousoku.model.elements.force import ForceKind
from kousoku.model.elements.joint import ANGLE, ANGLES, DISPLACEMENTS, SECOND_ANGLE
from kousoku.model.elements.joints import free_coordinates_of, sort_of
from kousoku.model.elements.spring import check_law, unused_free
from kousoku.model.errors import SceneError
from kousoku.model.text import with_a

if TYPE_CHECKING:
    from collections.abc import Iterator

    from kousoku.model.elements.force import Lowering
    from kousoku.model.mechanics.multibody import ForceElement
    from kousoku.model.records.loads import Force
    from kousoku.model.records.scene import Scene


class RotationalSpringDamper(ForceKind):
    """A spring and damper against an angle: moment τ = −k (θ − θ⁰) − c θ̇ (1,) [N m]."""

    title = "a spring and damper against an angle"
    keys = ("joint", "of", "coordinate", "stiffness", "damping", "moment", "free_angle")

    def check(self, scene: Scene, force: Force, key: str) -> None:
        """Refuse a rotational spring without an angle, or without a law."""
        if (force.joint is None) == (force.coordinate is None):
            problem = (
                "is given too; wanted one of them" if force.joint else "is missing; or 'coordinate'"
            )
            raise SceneError(f"{problem}: the angle that it acts on", key=f"{key}.joint")
        if force.joint is not None:
            _check_angle(scene, force, key)
        elif not _is_angle(scene, known_coordinate(scene, force, key)):
            raise SceneError(
                f"{force.coordinate} is no angle; wanted an angle, or a force of type 'along'",
                key=f"{key}.coordinate",
            )
        check_law(force, "moment", key)

    def unused(self, force: Force) -> Iterator[tuple[str, str]]:
        """Free angle without effect, and an ``of`` beside a coordinate."""
        yield from unused_free(force, "free_angle", "moment")
        if force.coordinate is not None and force.of is not None:
            yield (
                "of",
                "belongs to 'joint'; the coordinate says which angle it is, leave it out",
            )

    def elements(self, name: str, force: Force, lowering: Lowering) -> Iterator[ForceElement]:
        """Spring against the coordinate θ [rad]."""
        from kousoku.model.numbers import precise

        assert not isinstance(force.stiffness, tuple)
        assert not isinstance(force.damping, tuple)
        if force.coordinate is not None:
            index = lowering.coordinates.index_of(force.coordinate)
        else:
            assert force.joint is not None
            index = lowering.coordinates.of_joint(force.joint, force.of or ANGLE)
        free = lowering.coordinates.value(index) if force.free_angle is None else force.free_angle
        if force.moment is None:
            yield linear_spring(name, index, (force.stiffness, force.damping), lowering, free)
        else:
            numbers = {"moment": (1.0, lowering.unit**2), "free": (free, precise.number(1))}
            yield spring_against(name, index, numbers, lowering, force.moment)


def _check_angle(scene: Scene, force: Force, key: str) -> None:
    """Refuse a joint without an angle, or with two angles of which none is named."""
    joint, of = force.joint or "", force.of
    if of in DISPLACEMENTS:
        raise SceneError("is no angle; wanted an angle", key=f"{key}.of")
    free = free_coordinates_of(scene.joints[joint].type) if joint in scene.joints else ()
    if free and ANGLE not in free:
        kind = scene.joints[joint].type
        raise SceneError(
            f"{joint} is {with_a(kind)} joint, which has no angle that is one number",
            key=f"{key}.joint",
        )
    check_leaves(scene, joint, of if of or SECOND_ANGLE in free else ANGLE, key)


def _is_angle(scene: Scene, name: str) -> bool:
    coordinate = scene.coordinates[name]
    if coordinate.joint is None:
        return False
    return sort_of(scene.joints[coordinate.joint].type, coordinate.of) in ANGLES
