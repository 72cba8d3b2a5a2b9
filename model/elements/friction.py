"""Viscous friction in a joint."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.model.elements.checks import check_leaves
from kousoku.model.elements.coordinate_spring import linear_spring
from kousoku.model.elements.force import ForceKind, require_one
from kousoku.model.elements.joints import free_coordinates_of
from kousoku.model.errors import SceneError

if TYPE_CHECKING:
    from collections.abc import Iterator

    from kousoku.model.elements.force import Lowering
    from kousoku.model.mechanics.multibody import ForceElement
    from kousoku.model.records.loads import Force
    from kousoku.model.records.scene import Scene


class Friction(ForceKind):
    """Viscous friction in a joint: τ = −c u̇ (1,) [N or N m] by each coordinate u that is free."""

    title = "viscous friction in a joint"
    keys = ("joint", "of", "damping")

    def check(self, scene: Scene, force: Force, key: str) -> None:
        """Refuse friction in a joint that leaves no coordinate free."""
        if force.joint is None:
            raise SceneError("is missing; wanted the joint that it is in", key=f"{key}.joint")
        of: str | None = force.of
        if of is None and force.joint in scene.joints:
            free = free_coordinates_of(scene.joints[force.joint].type)
            of = free[0] if free else None
        check_leaves(scene, force.joint, of, key)
        require_one(force.damping, f"{key}.damping")

    def elements(self, name: str, force: Force, lowering: Lowering) -> Iterator[ForceElement]:
        """Damper against each coordinate u that the joint leaves free, c [N s/m or N m s/rad]."""
        assert force.joint is not None
        assert not isinstance(force.damping, tuple)
        free = free_coordinates_of(lowering.scene.joints[force.joint].type)
        sorts = free if force.of is None else (force.of,)
        for index in [lowering.coordinates.of_joint(force.joint, sort) for sort in sorts]:
            yield linear_spring(name, index, (0.0, force.damping), lowering)
