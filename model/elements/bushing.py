"""A bushing: springs and dampers along three directions and about them."""

from __future__ import annotations

from math import hypot
from typing import TYPE_CHECKING

from kousoku.model.elements.coordinate_spring import linear_spring
from kousoku.model.elements.force import ForceKind
from kousoku.model.errors import SceneError
from kousoku.model.records.design import LARGEST

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from kousoku.model.elements.force import Lowering
    from kousoku.model.mechanics.frames import BodyFrame
    from kousoku.model.mechanics.multibody import ForceElement
    from kousoku.model.numbers.precise import Triple
    from kousoku.model.records.loads import Force
    from kousoku.model.records.scene import Scene
    from kousoku.model.records.spatial import Value

LETTERS = "xyz"

PARALLEL = 1e-6
"""Two directions of a bushing whose angle is smaller do not span a plane [rad]."""


class Bushing(ForceKind):
    """Springs and dampers along and about three directions a: τ = −k u − c u̇ by each coordinate u.

    Along a u = a_i·d [m], lecture 8.2, (8.12); about it u = a_i·a_j [-], (8.9), the sine of the
    turn. The directions (3,) are given in frame O and fixed in body i; τ [N, N m] acts by Jᵀτ.
    """

    title = "springs and dampers along and about three directions"
    keys = ("bodies", "points", "at", "axes", "stiffness", "damping")

    def check(self, scene: Scene, force: Force, key: str) -> None:
        """Refuse points as bodies, and a bushing without a middle, a law or two directions."""
        for index, body in enumerate(force.bodies or ()):
            if body in scene.bodies and scene.bodies[body].point:
                raise SceneError(
                    f"{body} is a point, which does not turn; wanted a body, or a spring_damper",
                    key=f"{key}.bodies[{index}]",
                )
        if (force.points is None) == (force.at is None):
            problem = "is missing" if force.at is None else "is given too"
            raise SceneError(
                f"{problem}; wanted its middle in each body, or once in frame O as 'at'",
                key=f"{key}.points",
            )
        for name in ("stiffness", "damping"):
            if getattr(force, name) is not None and not isinstance(getattr(force, name), tuple):
                raise SceneError(
                    "is one number; wanted six: along three directions, then about them",
                    key=f"{key}.{name}",
                )
        if force.stiffness is None and force.damping is None:
            raise SceneError(
                "is missing; wanted six stiffnesses, six dampings or both", key=f"{key}.stiffness"
            )
        if force.axes is not None:
            (a, b, c), (x, y, z) = force.axes
            size = hypot(a, b, c) * hypot(x, y, z)
            across = hypot(b * z - c * y, c * x - a * z, a * y - b * x)
            if not (size >= 1 / LARGEST and across > PARALLEL * size):
                raise SceneError("are parallel; wanted two directions", key=f"{key}.axes")

    def elements(self, name: str, force: Force, lowering: Lowering) -> Iterator[ForceElement]:
        """Springs along three directions (3,) of body i, and about them by sines of the turns."""
        from kousoku.model.mechanics.measures import PreciseMeasure

        assert force.bodies is not None
        i, j = (lowering.frames[body] for body in force.bodies)
        points = _middle(force, (i, j))
        directions = _directions(force)
        a_i = [i.from_ground(vector) for vector in directions]
        a_j = [j.from_ground(vector) for vector in directions]
        along = [PreciseMeasure("n2", (i, j), (("a_i_b", vector),), points) for vector in a_i]
        # The sine of a turn of j about axis k is the cosine between axis k + 2 of i and k + 1 of j.
        about = [
            PreciseMeasure("n1", (i, j), (("a_i_b", a_i[k - 1]), ("a_j_b", a_j[k - 2])))
            for k in range(3)
        ]
        names = (*LETTERS, *(f"about_{letter}" for letter in LETTERS))
        springs = zip(
            names, (*along, *about), _six(force.stiffness), _six(force.damping), strict=True
        )
        for direction, measure, stiffness, damping in springs:
            if stiffness or damping:
                index = lowering.coordinates.add(f"{name}.{direction}", measure)
                yield linear_spring(name, index, (stiffness, damping), lowering)


def _six(values: object) -> Sequence[Value]:
    return values if isinstance(values, tuple) else (0.0,) * 6


def _middle(force: Force, ends: tuple[BodyFrame, BodyFrame]) -> tuple[Triple, Triple]:
    """Middle of a bushing in the frames of both bodies."""
    from kousoku.model.numbers import precise

    if force.points is not None:
        start, end = map(precise.triple, force.points)
        return start, end
    assert force.at is not None
    at = precise.triple(force.at)
    start, end = (
        precise.rotate_back(frame.p, precise.subtract(at, frame.position)) for frame in ends
    )
    return start, end


def _directions(force: Force) -> tuple[Triple, Triple, Triple]:
    """Three directions of a bushing in frame O, at the positions as they are written."""
    from kousoku.model.numbers import precise

    first, near = force.axes or ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    x = precise.unit(precise.triple(first))
    y = precise.unit(precise.without(precise.triple(near), x))
    return x, y, precise.cross(x, y)
