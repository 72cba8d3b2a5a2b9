"""A rod: two points that keep their distance."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from kousoku.model.elements.joint import JointKind
from kousoku.model.errors import SceneError
from kousoku.model.records.design import LARGEST

if TYPE_CHECKING:
    from kousoku.model.records.spatial import Joint


@dataclass(frozen=True, slots=True)
class RodJoint(JointKind):
    """All that keeps the distance of two points, ``length``, or that of their positions.

    C = (d·d − l²)/(2 l) = 0 (1,) [m], d in frame O of lecture 8.2, (8.8).
    """

    @property
    def point_keys(self) -> tuple[str, ...]:
        """Keys of its points, which lie apart: there is no common ``at``."""
        return ("points",)

    @property
    def own_keys(self) -> tuple[str, ...]:
        """Its length, which may be left out."""
        return ("length",)

    def check_numbers(self, joint: Joint, key: str) -> None:
        """Refuse a length that is not positive."""
        if joint.length is not None and not joint.length >= 1 / LARGEST:
            raise SceneError(
                f"a length of {joint.length!r}; wanted a positive length: where two points "
                "coincide, take a spherical joint",
                key=f"{key}.length",
            )
