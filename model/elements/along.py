"""A force or moment along a coordinate."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from kousoku.model.elements.force import ForceKind, require_one, scalars
from kousoku.model.errors import SceneError
from kousoku.model.mechanics.multibody import ForceElement
from kousoku.model.records.dotted_keys import require_known

if TYPE_CHECKING:
    from collections.abc import Iterator

    from kousoku.model.elements.force import Lowering
    from kousoku.model.records.loads import Force
    from kousoku.model.records.scene import Scene


@dataclass(frozen=True, slots=True)
class CoordinateForce(ForceElement):
    """A force τ (1,) [N or N m] along a coordinate u: Jᵀτ on its bodies, with u̇ = J v.

    J (1, 12) has the columns δr in frame O, δθ′ in the body frame. ``force`` of ``constants`` is τ;
    a formula of it may depend on the motion.
    """

    kind: str = field(init=False, default="along")


class Along(ForceKind):
    """A force or moment τ (1,) [N or N m] along a coordinate u: see :class:`CoordinateForce`."""

    title = "a force or moment along a coordinate"
    keys = ("coordinate", "force")

    def check(self, scene: Scene, force: Force, key: str) -> None:
        """Refuse a missing or unknown coordinate, and a force that is not one number."""
        if force.coordinate is None:
            raise SceneError(
                "is missing; wanted the coordinate that it acts along", key=f"{key}.coordinate"
            )
        known_coordinate(scene, force, key)
        require_one(force.force, f"{key}.force", f", that increases {force.coordinate}")

    def elements(self, name: str, force: Force, lowering: Lowering) -> Iterator[ForceElement]:
        """Element of the force: one number τ (1,) in SI units, Jᵀτ."""
        assert force.coordinate is not None
        assert not isinstance(force.force, tuple)
        index = lowering.coordinates.index_of(force.coordinate)
        scale = lowering.unit if is_length(lowering, index) else lowering.unit**2
        constants, formulas = scalars({"force": (force.force, scale)})
        u = lowering.coordinates.record(index)
        yield CoordinateForce(name, u.i, u.j, constants, formulas=formulas, coordinate=index)


def known_coordinate(scene: Scene, force: Force, key: str) -> str:
    """Coordinate that a force names.

    Raises
    ------
    SceneError
        There is no such coordinate.
    """
    name = force.coordinate or ""
    require_known("coordinate", name, scene.coordinates, f"{key}.coordinate")
    return name


def is_length(lowering: Lowering, index: int) -> bool:
    """Whether a coordinate is a length, not an angle."""
    return lowering.coordinates.unit_of(index)[0] == "m"
