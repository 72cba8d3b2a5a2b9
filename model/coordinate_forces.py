"""Forces of a scene along coordinates: rotational springs, friction, bushings, formulas."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from kousoku.model import precise
from kousoku.model.coordinates import PreciseMeasure
from kousoku.model.joints import ANGLE, leaves_of
from kousoku.model.mechanism import ForceElement

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from kousoku.model.coordinates import CoordinateList
    from kousoku.model.frames import BodyFrame
    from kousoku.model.loads import Force
    from kousoku.model.precise import High, Triple
    from kousoku.model.scene import Scene
    from kousoku.model.spatial import Value

    Constants = tuple[tuple[str, tuple[float, ...]], ...]
    Formulas = tuple[tuple[str, str], ...]

SPRING = "coordinate_spring"
LETTERS = "xyz"


@dataclass(frozen=True, slots=True)
class CoordinateForces:
    """What turns forces along coordinates into elements.

    Parameters
    ----------
    scene : Scene
        A checked scene.
    frames : mapping of str to BodyFrame
        Of all bodies and the ground.
    coordinates : CoordinateList
        What the forces need is added.
    unit : number [m]
        The unit of the scene.
    """

    scene: Scene
    frames: Mapping[str, BodyFrame]
    coordinates: CoordinateList
    unit: High

    def elements(self, name: str, force: Force) -> Iterator[ForceElement]:
        """Yield what a force is made of."""
        match force.type:
            case "bushing":
                yield from self._bushing(name, force)
            case "friction":
                for place in self._free(force):
                    yield self._spring(name, place, 0.0, force.damping)
            case "along":
                assert force.coordinate is not None
                place = self.coordinates.place(force.coordinate)
                scale = self.unit if self._is_length(place) else self.unit**2
                yield self._element(name, "along", place, {"force": (force.force, scale)})
            case _:
                yield self._rotational(name, force)

    def _free(self, force: Force) -> list[int]:
        """Return what a joint with friction leaves free."""
        assert force.joint is not None
        leaves = leaves_of(self.scene.joints[force.joint].type)
        sorts = leaves if force.of is None else (force.of,)
        return [self.coordinates.of_joint(force.joint, sort) for sort in sorts]

    def _rotational(self, name: str, force: Force) -> ForceElement:
        if force.coordinate is not None:
            place = self.coordinates.place(force.coordinate)
        else:
            assert force.joint is not None
            place = self.coordinates.of_joint(force.joint, force.of or ANGLE)
        free = self.coordinates.value(place) if force.free_angle is None else force.free_angle
        if force.moment is None:
            return self._spring(name, place, force.stiffness, force.damping, free)
        given = {"moment": (1.0, self.unit**2), "free": (free, precise.number(1))}
        return self._element(name, SPRING, place, given, force.moment)

    def _bushing(self, name: str, force: Force) -> Iterator[ForceElement]:
        """Yield springs along three directions of body i, and about them by sines of the turns."""
        assert force.bodies is not None
        i, j = (self.frames[body] for body in force.bodies)
        points = _middle(force, (i, j))
        directions = _directions(force)
        a_i = [i.from_ground(one) for one in directions]
        a_j = [j.from_ground(one) for one in directions]
        along = [PreciseMeasure("n2", (i, j), (("a_i_b", one),), points) for one in a_i]
        # Of a turn of j about the axis k the sine is the cosine between k + 2 of i and k + 1 of j.
        about = [
            PreciseMeasure("n1", (i, j), (("a_i_b", a_i[k - 1]), ("a_j_b", a_j[k - 2])))
            for k in range(3)
        ]
        names = (*LETTERS, *(f"about_{letter}" for letter in LETTERS))
        given = zip(
            names, (*along, *about), _six(force.stiffness), _six(force.damping), strict=True
        )
        for own, measure, stiffness, damping in given:
            if stiffness or damping:
                place = self.coordinates.add(f"{name}.{own}", measure)
                yield self._spring(name, place, stiffness, damping)

    def _spring(
        self, name: str, place: int, stiffness: Any, damping: Any, free: Value | High = 0.0
    ) -> ForceElement:
        """Return a linear spring; stiffness and damping are those of the scene, or None."""
        one = precise.number(1)
        scale = one if self._is_length(place) else self.unit**2
        given = {"stiffness": (stiffness or 0.0, scale), "damping": (damping or 0.0, scale)}
        return self._element(name, SPRING, place, given | {"free": (free, one)})

    def _is_length(self, place: int) -> bool:
        return self.coordinates.unit_of(place)[0] == "m"

    def _element(
        self, name: str, kind: str, place: int, given: Mapping[str, tuple[Any, High]], law: str = ""
    ) -> ForceElement:
        one = self.coordinates.record(place)
        constants, formulas = scalars(given)
        return ForceElement(name, kind, one.i, one.j, constants, law, formulas, place)


def _six(values: object) -> Sequence[Value]:
    return values if isinstance(values, tuple) else (0.0,) * 6


def _middle(force: Force, ends: tuple[BodyFrame, BodyFrame]) -> tuple[Triple, Triple]:
    """Return the middle of a bushing in the frames of both bodies."""
    if force.points is not None:
        start, end = map(precise.triple, force.points)
        return start, end
    assert force.at is not None
    at = precise.triple(force.at)
    start, end = (precise.rotate_back(one.p, precise.subtract(at, one.position)) for one in ends)
    return start, end


def _directions(force: Force) -> tuple[Triple, Triple, Triple]:
    """Return the three directions of a bushing in frame O, at the positions as they are written."""
    first, near = force.axes or ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    x = precise.unit(precise.triple(first))
    y = precise.unit(precise.without(precise.triple(near), x))
    return x, y, precise.cross(x, y)


def scalars(given: Mapping[str, tuple[Any, High]]) -> tuple[Constants, Formulas]:
    """Return numbers in SI units; of a formula its unit, and the text.

    Parameters
    ----------
    given : mapping of str to (float or str, number)
        By name the value in the scene, and its unit.
    """
    constants = tuple(
        (name, (precise.double(unit * precise.number(1 if isinstance(value, str) else value)),))
        for name, (value, unit) in given.items()
    )
    texts = ((name, value) for name, (value, _) in given.items() if isinstance(value, str))
    return constants, tuple(texts)
