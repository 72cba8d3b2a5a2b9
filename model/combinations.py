"""Rows that combine coordinates: screws, constant velocity joints, gears, linear couplings."""

from __future__ import annotations

from dataclasses import replace
from math import frexp, ldexp
from typing import TYPE_CHECKING

from kousoku.model import precise
from kousoku.model.coordinates import PreciseMeasure
from kousoku.model.digits import CONTEXT
from kousoku.model.errors import SceneError
from kousoku.model.frames import joint_points, joint_vectors
from kousoku.model.joints import ANGLE, DISPLACEMENT, JOINTS, NAMES
from kousoku.model.mechanism import COMBINATION, Instance, Term
from kousoku.model.precise import NOISE
from kousoku.model.traced import Traced, at_scene

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from kousoku.model.coordinates import CoordinateList
    from kousoku.model.frames import BodyFrame
    from kousoku.model.precise import High
    from kousoku.model.spatial import Joint

USUAL = 8
"""Powers of two that the largest factor of a linear coupling may have, lengths counted in one of
the scene."""

FOLDED = 1e-3
"""Shafts whose 1 + cos of the angle between them is less are folded back on each other."""


def combination_of(
    name: str, joint: Joint, frames: Mapping[str, BodyFrame], coordinates: CoordinateList
) -> Instance:
    """Row of a joint that combines coordinates.

    Parameters
    ----------
    name : str
        The joint.
    joint : Joint
        A screw, a constant velocity joint, or a coupling.
    frames : mapping of str to BodyFrame
        Of all bodies and the ground.
    coordinates : CoordinateList
        Where the coordinates that it combines are kept.

    Raises
    ------
    SceneError
        The shafts of a constant velocity joint are folded back on each other.
    """
    match NAMES[joint.type]:
        case "screw":
            return _screw(name, joint, coordinates)
        case "constant_velocity":
            return _constant_velocity(name, joint, frames, coordinates)
        case "gear":
            return _gear(name, joint, coordinates)
        case "rack_and_pinion":
            return _rack(name, joint, coordinates)
        case _:
            return _linear(name, joint, coordinates)


def _screw(name: str, joint: Joint, coordinates: CoordinateList) -> Instance:
    """Displacement − pitch / 2π · angle."""
    assert joint.pitch is not None
    angle = coordinates.of_joint(name, ANGLE)
    displacement = coordinates.of_joint(name, DISPLACEMENT)
    advance = coordinates.unit * precise.number(joint.pitch) / (2 * CONTEXT.pi)
    return _as_written(name, [(displacement, 1), (angle, -advance)], coordinates)


def _gear(name: str, joint: Joint, coordinates: CoordinateList) -> Instance:
    """Combination second angle − ratio · the first, of a gear."""
    assert joint.joints is not None
    assert joint.ratio is not None
    first, second = (coordinates.of_joint(geared, ANGLE) for geared in joint.joints)
    return _as_written(name, [(second, 1), (first, -precise.number(joint.ratio))], coordinates)


def _rack(name: str, joint: Joint, coordinates: CoordinateList) -> Instance:
    """Displacement of the rack − radius · the angle of the pinion."""
    assert joint.joints is not None
    assert joint.radius is not None
    angle = coordinates.of_joint(joint.joints[0], ANGLE)
    displacement = coordinates.of_joint(joint.joints[1], DISPLACEMENT)
    radius = coordinates.unit * precise.number(joint.radius)
    return _as_written(name, [(displacement, 1), (angle, -radius)], coordinates)


def _linear(name: str, joint: Joint, coordinates: CoordinateList) -> Instance:
    """Sum Σ factor · coordinate, of angles in rad, else in the unit of the scene."""
    assert joint.coordinates is not None
    assert joint.factors is not None
    places = [coordinates.place(coordinate) for coordinate in joint.coordinates]
    factors = [precise.number(factor) for factor in joint.factors]
    units = [coordinates.unit_of(place)[0] for place in places]
    if "m" in units:  # what is multiplied with an angle is a length
        pairs = zip(factors, units, strict=True)
        factors = [f * coordinates.unit if of == "rad" else f for f, of in pairs]
    sizes = [float(at_scene(factor)) for factor in factors]
    if "m" in units and "rad" in units:
        length = _length_of(coordinates)
        sizes = [f / length if of == "rad" else f for f, of in zip(sizes, units, strict=True)]
    scale = _scale_of(sizes)
    terms = [(place, scale * f) for place, f in zip(places, factors, strict=True)]
    return replace(_as_written(name, terms, coordinates), scale=scale)


def _scale_of(factors: Sequence[float]) -> float:
    """Scale of factors, so that their row has the size of other rows.

    A row that is far smaller would count as one that depends on others, and nothing would keep it.
    """
    largest = max(map(abs, factors))
    exponent = frexp(largest)[1] if largest else 0
    return 1.0 if abs(exponent) <= USUAL else ldexp(1.0, 1 - exponent)


def _length_of(coordinates: CoordinateList) -> float:
    """Length of a scene that compares radians with metres, whatever its units [m].

    The largest distance, along an axis, of a point of a joint from the centre of mass of a body;
    where there is none, that of a body from the origin.
    """
    scene, frames, unit = coordinates.scene, coordinates.frames, coordinates.unit
    arms: list[float] = []
    for joint in scene.joints.values():
        kind = JOINTS.get(NAMES.get(joint.type, ""))
        if kind is None or not kind.has_point:
            continue
        ends = frames[joint.ends[0]], frames[joint.ends[1]]
        for end, point in zip(ends, joint_points(joint, ends), strict=True):
            arms += end.point(point, unit) if end.index >= 0 else ()
        if joint.length is not None:
            arms.append(float(unit * at_scene(precise.number(joint.length))))
    if any(arms):
        return max(map(abs, arms))
    places = (unit * at_scene(x) for frame in frames.values() for x in frame.position)
    return float(max(map(abs, places))) or 1.0


def _constant_velocity(
    name: str, joint: Joint, frames: Mapping[str, BodyFrame], coordinates: CoordinateList
) -> Instance:
    """Difference x_i·y_j − y_i·x_j, where x, y and the shaft are the frame of each body."""
    ends = frames[joint.ends[0]], frames[joint.ends[1]]
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
    return _combination(name, [(first, one), (second, -one)], CONTEXT.mpf(0), coordinates)


def _as_written(
    name: str, terms: Sequence[tuple[int, High]], coordinates: CoordinateList
) -> Instance:
    """Combination that is zero at the positions as they are written."""
    parts = [factor * coordinates.value(place) for place, factor in terms]
    offset = -precise.total(parts)
    if not isinstance(offset, Traced) and abs(offset) <= NOISE * sum(map(abs, parts)):
        offset = CONTEXT.mpf(0)
    return _combination(name, terms, offset, coordinates)


def _combination(
    name: str, terms: Sequence[tuple[int, High]], offset: High, coordinates: CoordinateList
) -> Instance:
    records = [coordinates.record(place) for place, _ in terms]
    bodies = dict.fromkeys(body for record in records for body in (record.i, record.j))
    first = records[0]
    units = [coordinates.unit_of(place)[0] for place, _ in terms]
    return Instance(
        name,
        COMBINATION,
        first.i,
        first.j,
        terms=tuple(Term(place, precise.double(factor)) for place, factor in terms),
        others=tuple(body for body in bodies if body not in (first.i, first.j)),
        offset=precise.double(offset),
        unit="m" if "m" in units else "rad",
    )
