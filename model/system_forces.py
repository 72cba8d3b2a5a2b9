"""Turn the forces of a scene into elements: SI units, principal frames, rounded once."""

from __future__ import annotations

from itertools import chain
from typing import TYPE_CHECKING

from kousoku.model import precise
from kousoku.model.coordinate_forces import CoordinateForces, scalars
from kousoku.model.formulas import RATE, state_names, used_names
from kousoku.model.frames import to_vector
from kousoku.model.mechanism import GROUND_INDEX, Event, ForceElement

if TYPE_CHECKING:
    from collections.abc import Mapping

    from kousoku.model.coordinate_forces import Constants, Formulas
    from kousoku.model.coordinates import CoordinateList
    from kousoku.model.frames import BodyFrame
    from kousoku.model.loads import Force
    from kousoku.model.mechanism import Vector
    from kousoku.model.precise import High, Triple
    from kousoku.model.scene import Scene
    from kousoku.model.spatial import Value

AXES = "xyz"

DIRECTIONS = {"both": 0, "rising": 1, "falling": -1}


def force_elements(
    scene: Scene, frames: Mapping[str, BodyFrame], coordinates: CoordinateList, unit: High
) -> tuple[ForceElement, ...]:
    """Return the forces of a checked scene as elements; a bushing is several.

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
    found: list[ForceElement] = []
    along = CoordinateForces(scene, frames, coordinates, unit)
    for name, force in scene.forces.items():
        if force.type == "spring_damper":
            found.append(_spring(name, force, frames, unit))
        elif force.type in ("force", "torque"):
            found.append(_load(name, force, frames, unit))
        else:
            found += along.elements(name, force)
    texts = chain.from_iterable(one.formulas for one in found)
    for name in _named(scene, [text for _, text in texts]):
        coordinates.place(name)
    return tuple(found)


def events_of(scene: Scene, coordinates: CoordinateList) -> tuple[Event, ...]:
    """Return the events of a checked scene; what they need is added to the coordinates."""
    for name in _named(scene, [event.when for event in scene.events.values()]):
        coordinates.place(name)
    return tuple(
        Event(name, event.when, DIRECTIONS[event.direction], event.action)
        for name, event in scene.events.items()
    )


def gravity_of(scene: Scene, unit: High) -> Vector:
    """Return the acceleration of free fall in SI units, zero where it is a formula."""
    x, y, z = (0.0 if isinstance(value, str) else value for value in scene.gravity)
    return to_vector(precise.scale(unit, precise.triple((x, y, z))))


def gravity_law(scene: Scene) -> tuple[str, str, str]:
    """Return the components of gravity that are formulas; the others are empty."""
    x, y, z = (value if isinstance(value, str) else "" for value in scene.gravity)
    return x, y, z


def _named(scene: Scene, formulas: list[str]) -> list[str]:
    """Return the coordinates that formulas name, or whose rates they name."""
    known = state_names(scene)
    names = chain.from_iterable(used_names(text, known) for text in formulas)
    rates = {f"{name}{RATE}": name for name in scene.coordinates}
    used = dict.fromkeys(rates.get(name, name) for name in names)
    return [name for name in used if name in scene.coordinates]


def _load(name: str, force: Force, frames: Mapping[str, BodyFrame], unit: High) -> ForceElement:
    assert force.body is not None
    frame = frames[force.body]
    is_fixed = getattr(force, force.type) is not None
    kind = force.type if is_fixed else f"{force.type}_b"
    scale = unit if force.type == "force" else unit * unit
    vectors, formulas = _vectors(force, kind, frame, scale)
    constants: Constants = vectors
    if force.type == "force":
        place = precise.triple(force.point or (0.0, 0.0, 0.0))
        constants = (("s_j_b", frame.point(place, unit)), *vectors)
    return ForceElement(name, kind, GROUND_INDEX, frame.index, constants, formulas=formulas)


def _vectors(force: Force, kind: str, frame: BodyFrame, scale: High) -> tuple[Constants, Formulas]:
    """Return the vectors that a force or torque is the sum of, and the formulas of some of them.

    Components that are numbers make one vector. Each that is a formula stands beside the direction
    that it belongs to, in frame O or in the principal frame.
    """

    def seen(vector: Triple) -> Vector:
        return to_vector(precise.scale(scale, vector if kind == force.type else in_body(vector)))

    in_body = frame.principal
    given = getattr(force, kind)
    numbers = [0.0 if isinstance(value, str) else value for value in given]
    constants = [(force.type, seen(precise.triple((numbers[0], numbers[1], numbers[2]))))]
    formulas = []
    for k, value in enumerate(given):
        if isinstance(value, str):
            x, y, z = (float(k == m) for m in range(3))
            constants.append((f"{force.type}_{AXES[k]}", seen(precise.triple((x, y, z)))))
            formulas.append((f"{force.type}_{AXES[k]}", value))
    return tuple(constants), tuple(formulas)


def _spring(name: str, force: Force, frames: Mapping[str, BodyFrame], unit: High) -> ForceElement:
    assert force.bodies is not None
    assert force.points is not None
    ends = [frames[body] for body in force.bodies]
    points = [precise.triple(point) for point in force.points]
    free: Value | High | None = force.free_length
    if free is None:
        start, end = (
            precise.add(frame.position, precise.rotate(frame.p, point))
            for frame, point in zip(ends, points, strict=True)
        )
        free = precise.length(precise.subtract(end, start))
    one = precise.number(1)
    law: dict[str, tuple[Value | High, High]] = {"unit": (1.0, unit)}
    if force.tension is None:
        given = {"stiffness": force.stiffness, "damping": force.damping}
        law = {name: (value or 0.0, one) for name, value in given.items()}
    numbers, formulas = scalars(law | {"free_length": (free, unit)})
    constants = (
        ("s_i_b", ends[0].point(points[0], unit)),
        ("s_j_b", ends[1].point(points[1], unit)),
        *numbers,
    )
    i, j = (end.index for end in ends)
    law_text = force.tension or ""
    return ForceElement(name, force.type, i, j, constants, law=law_text, formulas=formulas)
