"""Turn the forces of a scene into elements: SI units, principal frames, rounded once."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.model import precise
from kousoku.model.frames import to_vector
from kousoku.model.mechanism import GROUND_INDEX, ForceElement

if TYPE_CHECKING:
    from collections.abc import Mapping

    from kousoku.model.frames import BodyFrame
    from kousoku.model.loads import Force
    from kousoku.model.mechanism import Vector
    from kousoku.model.precise import High, Triple
    from kousoku.model.spatial import Components, Value

    Constants = tuple[tuple[str, tuple[float, ...]], ...]

AXES = "xyz"


def force_elements(
    forces: Mapping[str, Force], frames: Mapping[str, BodyFrame], unit: High
) -> tuple[ForceElement, ...]:
    """Return the forces of a checked scene as elements.

    Parameters
    ----------
    forces : mapping of str to Force
        The forces.
    frames : mapping of str to BodyFrame
        Of all bodies and the ground.
    unit : number [m]
        The unit of the scene.
    """
    return tuple(_element(name, force, frames, unit) for name, force in forces.items())


def _element(name: str, force: Force, frames: Mapping[str, BodyFrame], unit: High) -> ForceElement:
    if force.type == "spring_damper":
        return _spring(name, force, frames, unit)
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


def _vectors(
    force: Force, kind: str, frame: BodyFrame, scale: High
) -> tuple[Constants, tuple[tuple[str, str], ...]]:
    """Return the vectors that a force or torque is the sum of, and the formulas of some of them.

    Components that are numbers make one vector. Each that is a formula stands beside the direction
    that it belongs to, in frame O or in the principal frame.
    """

    def seen(vector: Triple) -> Vector:
        return to_vector(precise.scale(scale, vector if kind == force.type else in_body(vector)))

    in_body = frame.principal
    given: Components = getattr(force, kind)
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
        law = {"stiffness": (force.stiffness or 0.0, one), "damping": (force.damping or 0.0, one)}
    scalars, formulas = _scalars(law | {"free_length": (free, unit)})
    constants = (
        ("s_i_b", ends[0].point(points[0], unit)),
        ("s_j_b", ends[1].point(points[1], unit)),
        *scalars,
    )
    i, j = (end.index for end in ends)
    law_text = force.tension or ""
    return ForceElement(name, force.type, i, j, constants, law=law_text, formulas=formulas)


def _scalars(
    given: Mapping[str, tuple[Value | High, High]],
) -> tuple[Constants, tuple[tuple[str, str], ...]]:
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
