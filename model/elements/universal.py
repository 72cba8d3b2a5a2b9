"""A universal joint: turns about the two arms of a cross."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from kousoku.model.elements.joint import ANGLE, JointKind

if TYPE_CHECKING:
    from kousoku.model.mechanics.frames import BodyFrame
    from kousoku.model.mechanics.measures import PreciseMeasure
    from kousoku.model.records.spatial import Joint


@dataclass(frozen=True, slots=True)
class Universal(JointKind):
    """Turns about the arms of a cross, each fixed in one of the bodies: a_i·a_j = 0, (8.9).

    a_i and a_j (3,) [-] are the arms in frame O.
    """

    def measure(self, joint: Joint, sort: str, ends: tuple[BodyFrame, BodyFrame]) -> PreciseMeasure:
        """Turn of the cross about one of its arms [rad].

        The angle is that of the arm of j, seen from body i, about the arm of i. The second is that
        of body j about its own arm: against it the arm of i turns the other way. Each is
        atan2(b_i·a_j, a_i·a_j) of vectors (3,) in the body frames.
        """
        from kousoku.model.mechanics.frames import joint_vectors
        from kousoku.model.mechanics.measures import PreciseMeasure
        from kousoku.model.numbers import precise
        from kousoku.model.numbers.digits import CONTEXT
        from kousoku.model.numbers.traced import NOISE

        i, j = joint_vectors(ends, joint)
        first, second = ends
        is_turned = sort != ANGLE
        if not is_turned:
            axis, arm, across = i["axis"], j["axis"], i["across"]
        else:
            ends = second, first
            axis, arm, across = j["axis"], i["axis"], j["across"]
        if joint.zero is None:
            seen = ends[0].from_ground(ends[1].to_ground(arm))
            aside = precise.without(seen, axis)
            across = precise.across(axis) if precise.length(aside) < NOISE else precise.unit(aside)
        third = precise.cross(axis, across)
        if is_turned:
            third = precise.scale(CONTEXT.mpf(-1), third)
        vectors = (("a_i_b", across), ("b_i_b", third), ("a_j_b", arm))
        return PreciseMeasure("angle", ends, vectors, is_turned=is_turned)
