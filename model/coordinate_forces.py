"""Forces of a scene that act along coordinates: rotational springs, friction, bushings, formulas."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.model import precise
from kousoku.model.coordinates import Measure
from kousoku.model.joints import ANGLE, JOINTS, NAMES
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


def coordinate_elements(
    name: str,
    force: Force,
    scene: Scene,
    frames: Mapping[str, BodyFrame],
    coordinates: CoordinateList,
    unit: High,
) -> Iterator[ForceElement]:
    """Yield what a force of a checked scene is made of.

    Parameters
    ----------
    name : str
        Its name.
    force : Force
        One that acts along coordinates.
    scene : Scene
        Where it is.
    frames : mapping of str to BodyFrame
        Of all bodies and the ground.
    coordinates : CoordinateList
        What it needs is added.
    unit : number [m]
        The unit of the scene.
    """
    if force.type == "bushing":
        yield from _bushing(name, force, frames, coordinates, unit)
    elif force.type == "friction":
        assert force.joint is not None
        leaves = JOINTS[NAMES[scene.joints[force.joint].type]].leaves
        for sort in leaves if force.of is None else (force.of,):
            place = coordinates.of_joint(force.joint, sort)
            given = (0.0, force.damping, 0.0)
            yield _spring(name, place, coordinates, given, unit)
    elif force.type == "along":
        assert force.coordinate is not None
        place = coordinates.place(force.coordinate)
        scale = unit if coordinates.unit_of(place)[0] == "m" else unit * unit
        yield _element(name, "along", place, coordinates, {"force": (force.force, scale)})
    else:
        place = _angle(force, coordinates)
        free = coordinates.value(place) if force.free_angle is None else force.free_angle
        if force.moment is None:
            given = (force.stiffness or 0.0, force.damping or 0.0, free)
            yield _spring(name, place, coordinates, given, unit)
        else:
            law = {"moment": (1.0, unit * unit), "free": (free, precise.number(1))}
            yield _element(name, SPRING, place, coordinates, law, force.moment)


def _angle(force: Force, coordinates: CoordinateList) -> int:
    if force.coordinate is not None:
        return coordinates.place(force.coordinate)
    assert force.joint is not None
    return coordinates.of_joint(force.joint, ANGLE)


def _bushing(
    name: str,
    force: Force,
    frames: Mapping[str, BodyFrame],
    coordinates: CoordinateList,
    unit: High,
) -> Iterator[ForceElement]:
    """Yield springs along three directions of body i, and about them by the sines of small turns."""
    assert force.bodies is not None
    i, j = (frames[body] for body in force.bodies)
    points = _middle(force, (i, j))
    directions = _directions(force)
    a_i = [i.from_ground(one) for one in directions]
    a_j = [j.from_ground(one) for one in directions]
    along = [Measure("n2", (i, j), (("a_i_b", one),), points) for one in a_i]
    # Of a turn of j about the axis k the sine is the cosine between k + 2 of i and k + 1 of j.
    about = [
        Measure("n1", (i, j), (("a_i_b", a_i[k - 1]), ("a_j_b", a_j[k - 2]))) for k in range(3)
    ]
    names = (*LETTERS, *(f"about_{letter}" for letter in LETTERS))
    given = zip(names, (*along, *about), _six(force.stiffness), _six(force.damping), strict=True)
    for own, measure, stiffness, damping in given:
        if stiffness or damping:
            place = coordinates.add(f"{name}.{own}", measure)
            yield _spring(name, place, coordinates, (stiffness, damping, 0.0), unit)


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


def _spring(
    name: str,
    place: int,
    coordinates: CoordinateList,
    given: tuple[Value | None, Value | None, Value | High],
    unit: High,
) -> ForceElement:
    """Return a linear spring; stiffness and damping are those of the scene."""
    stiffness, damping, free = given
    scale = precise.number(1) if coordinates.unit_of(place)[0] == "m" else unit * unit
    law = {
        "stiffness": (stiffness, scale),
        "damping": (damping, scale),
        "free": (free, precise.number(1)),
    }
    return _element(name, SPRING, place, coordinates, law)


def _element(
    name: str,
    kind: str,
    place: int,
    coordinates: CoordinateList,
    given: Mapping[str, tuple[object, High]],
    law: str = "",
) -> ForceElement:
    one = coordinates.records[place]
    constants, formulas = scalars(given)
    return ForceElement(name, kind, one.i, one.j, constants, law, formulas, place)


def scalars(given: Mapping[str, tuple[object, High]]) -> tuple[Constants, Formulas]:
    """Return numbers in SI units; of a formula its unit, and the text.

    Parameters
    ----------
    given : mapping of str to (float or str, number)
        By name the value in the scene, and its unit.
    """
    constants = tuple(
        (name, (float(unit * precise.number(1 if isinstance(value, str) else value)),))
        for name, (value, unit) in given.items()
    )
    texts = ((name, value) for name, (value, _) in given.items() if isinstance(value, str))
    return constants, tuple(texts)
