"""A constant velocity joint: two shafts that turn equally fast."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from kousoku.model.elements.joint import JointKind
from kousoku.model.errors import SceneError

if TYPE_CHECKING:
    from kousoku.model.lowering.coordinates import CoordinateList
    from kousoku.model.mechanics.multibody import Instance
    from kousoku.model.records.spatial import Joint

FOLDED = 1e-3
"""Shafts whose 1 + cos of the angle between them is less are folded back on each other."""


@dataclass(frozen=True, slots=True)
class ConstantVelocity(JointKind):
    """A point in common, d = 0 (3,) [m], and shafts that turn equally fast whatever the bend."""

    def combination(self, name: str, joint: Joint, coordinates: CoordinateList) -> Instance:
        """Combination C = x_i·y_j − y_i·x_j (1,) [-], frame O; x, y (3,) are across each shaft."""
        from kousoku.model.elements.combinations import combination
        from kousoku.model.mechanics.frames import joint_vectors
        from kousoku.model.mechanics.measures import PreciseMeasure
        from kousoku.model.numbers import precise
        from kousoku.model.numbers.digits import CONTEXT

        ends = coordinates.frames[joint.ends[0]], coordinates.frames[joint.ends[1]]
        i, j = joint_vectors(ends, joint)
        if 1 + precise.dot(ends[0].to_ground(i["axis"]), ends[1].to_ground(j["axis"])) < FOLDED:
            raise SceneError(
                "the two shafts point against each other, where the joint is singular; wanted both "
                "pointing the same way through the joint",
                key=f"joints.{name}.axes",
            )
        xy = (("a_i_b", i["across"]), ("a_j_b", j["third"]))
        yx = (("a_i_b", i["third"]), ("a_j_b", j["across"]))
        first = coordinates.add(f"{name}.xy", PreciseMeasure("n1", ends, xy))
        second = coordinates.add(f"{name}.yx", PreciseMeasure("n1", ends, yx))
        one = CONTEXT.mpf(1)
        return combination(name, [(first, one), (second, -one)], CONTEXT.mpf(0), coordinates)
