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
    from kousoku.model.precise import High


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
    values = precise.triple(getattr(force, kind))
    scale = unit if force.type == "force" else unit * unit
    components = to_vector(precise.scale(scale, values if is_fixed else frame.principal(values)))
    constants: tuple[tuple[str, tuple[float, ...]], ...] = ((force.type, components),)
    if force.type == "force":
        place = precise.triple(force.point or (0.0, 0.0, 0.0))
        constants = (("s_j_b", frame.point(place, unit)), *constants)
    return ForceElement(name, kind, GROUND_INDEX, frame.index, constants)


def _spring(name: str, force: Force, frames: Mapping[str, BodyFrame], unit: High) -> ForceElement:
    assert force.bodies is not None
    assert force.points is not None
    ends = [frames[body] for body in force.bodies]
    points = [precise.triple(point) for point in force.points]
    free = force.free_length
    if free is None:
        start, end = (
            precise.add(frame.position, precise.rotate(frame.p, point))
            for frame, point in zip(ends, points, strict=True)
        )
        length = precise.length(precise.subtract(end, start))
    else:
        length = precise.number(free)
    law: tuple[tuple[str, tuple[float, ...]], ...]
    if force.tension is None:
        law = (("stiffness", (force.stiffness or 0.0,)), ("damping", (force.damping or 0.0,)))
    else:
        law = (("unit", (float(unit),)),)
    constants = (
        ("s_i_b", ends[0].point(points[0], unit)),
        ("s_j_b", ends[1].point(points[1], unit)),
        *law,
        ("free_length", (float(unit * length),)),
    )
    i, j = (end.index for end in ends)
    return ForceElement(name, force.type, i, j, constants, law=force.tension or "")
