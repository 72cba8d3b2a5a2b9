"""Measures between two bodies, in 50 digits: angles, cosines, distances, places."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from kousoku.model.mechanics.constraints import COORDINATES
from kousoku.model.mechanics.frames import GROUND_FRAME
from kousoku.model.numbers import precise
from kousoku.model.numbers.precise import ZERO

if TYPE_CHECKING:
    from kousoku.model.mechanics.frames import BodyFrame
    from kousoku.model.numbers.precise import High, Triple


@dataclass(frozen=True, slots=True)
class PreciseMeasure:
    """A scalar quantity of two bodies, in 50 digits.

    Parameters
    ----------
    kind : str
        The package, see :class:`kousoku.model.mechanics.multibody.RelativeCoordinate`.
    ends : (BodyFrame, BodyFrame)
        Bodies i and j.
    vectors : tuple of (str, (3,)) [-]
        Axes by the names of the package's inputs, of norm one, in the principal frames.
    points : ((3,), (3,)) [unit of the scene], optional
        Points in the frames of the bodies.
    is_turned : bool
        Whether its body i is body j of the joint that leaves it free.
    """

    kind: str
    ends: tuple[BodyFrame, BodyFrame]
    vectors: tuple[tuple[str, Triple], ...] = ()
    points: tuple[Triple, Triple] | None = None
    is_turned: bool = False

    def constants(self, unit: High) -> tuple[tuple[str, tuple[float, ...]], ...]:
        """Fixed inputs of the package, rounded: axes (3,) [-], points (3,) [m], principal frames.

        ``unit`` [m] is the unit of the scene.
        """
        constants = [(name, precise.rounded(vector)) for name, vector in self.vectors]
        for letter, end, point in zip("ij", self.ends, self.points or (), strict=False):
            constants.append((f"s_{letter}_b", end.point(point, unit)))
        return tuple(constants)

    def value(self) -> High:
        """Value, a scalar, at the positions as written, in rad or the unit of the scene."""
        i, j = self.ends
        fixed = {
            name: (i if name.endswith("i_b") else j).to_ground(vector)
            for name, vector in self.vectors
        }
        points = None if self.points is None else (i.place(self.points[0]), j.place(self.points[1]))
        return COORDINATES[self.kind].value(fixed, points)


def place_measure(frame: BodyFrame, point: Triple, along: Triple) -> PreciseMeasure:
    """Coordinate of a point of a body along a direction of frame O: n2, lecture 8.2, (8.12).

    Parameters
    ----------
    frame : BodyFrame
        The body.
    point : (3,) [unit of the scene]
        In the body frame.
    along : (3,)
        The direction in frame O, of any length but zero.
    """
    vectors = (("a_i_b", precise.unit(along)),)
    return PreciseMeasure("n2", (GROUND_FRAME, frame), vectors, (ZERO, point))
