"""Ends of a joint: its point, and the bodies on which its force and torque are recorded."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.model.mechanics.multibody import GROUND_INDEX

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.model.mechanics.multibody import System
    from kousoku.model.records.orientation import Vector


def loaded_bodies(bodies: Sequence[int]) -> tuple[int, ...]:
    """Bodies on which force and torque of a joint are recorded.

    Of two bodies it is j, or i where j is the ground; of more, as a gear has them, all that move.
    """
    i, j, *others = bodies
    if others:
        return tuple(body for body in bodies if body != GROUND_INDEX)
    return (i if j == GROUND_INDEX else j,)


def points_of(system: System) -> dict[str, Vector]:
    """Point s′ (3,) [m], of r + A s′, of each joint in the principal frame of body j, or frame O.

    Joints without a point have their torque at the origin of that frame.
    """
    points: dict[str, Vector] = {}
    for instance in system.constraints:
        coordinates = (system.coordinates[term.coordinate] for term in instance.terms)
        constants = [
            *instance.constants,
            *(x for u in coordinates if u.j == instance.j for x in u.constants),
        ]
        for name, values in constants:
            if name == "s_j_b":
                points[instance.joint] = _vector(values)
    return points


def _vector(values: Sequence[float]) -> Vector:
    x, y, z = values
    return x, y, z
