"""Check the parameters and coordinates of a spatial scene: their names, joints, points."""

from __future__ import annotations

from math import hypot
from typing import TYPE_CHECKING

from kousoku.model.angles import Angle
from kousoku.model.elements.checks import (
    check_leaves,
    check_only_point,
    check_place,
    only_one,
    refuse_foreign,
    require_two,
)
from kousoku.model.elements.joint import ANGLES
from kousoku.model.errors import SceneError
from kousoku.model.expressions.formulas import LAW_NAMES, RATE, TIME
from kousoku.model.expressions.parser import ARGUMENTS
from kousoku.model.records.design import LARGEST
from kousoku.model.records.dotted_keys import join, require_known
from kousoku.model.records.spatial import GROUND

if TYPE_CHECKING:
    from kousoku.model.records.problems import Problems
    from kousoku.model.records.scene import Scene
    from kousoku.model.records.spatial import Coordinate

KEYS = {
    "joint": ("joint", "of"),
    "bodies": ("bodies", "points"),
    "body": ("body", "point", "along"),
}
"""Keys of each sort of coordinate, by the key that selects the sort."""

TITLES = {
    "joint": "the angle or the displacement of a joint",
    "bodies": "the distance of two points",
    "body": "the place of a point along a direction",
}
"""Title of each sort in one line."""


def check_coordinates(scene: Scene, problems: Problems) -> None:
    """Check names that formulas use, and coordinates.

    Parameters
    ----------
    scene : Scene
        What could be built of it.
    problems : Problems
        What is broken in it, and where to note what else is wrong.
    """
    for table in ("parameters", "coordinates"):
        for name in getattr(scene, table):
            key = join(table, name)
            problems.check(key, [key], _check_name, scene, table, name)
    for name, coordinate in scene.coordinates.items():
        key = join("coordinates", name)
        bodies = (coordinate.body, *(coordinate.bodies or ()))
        uses = [join("bodies", body) for body in bodies if body]
        if coordinate.joint is not None:
            uses.append(join("joints", coordinate.joint))
        problems.check(key, [key, *uses], _check_coordinate, scene, coordinate, key)


def _check_name(scene: Scene, table: str, name: str) -> None:
    taken = {TIME: "the time", "pi": "a number", "deg": "the unit of 1/180 of pi"}
    taken |= dict.fromkeys(ARGUMENTS, "a function")
    if table == "parameters":
        taken = dict.fromkeys(LAW_NAMES, "what the tension of a spring may depend on") | taken
    key = join(table, name)
    if name in taken:
        raise SceneError(
            f"the name {name!r} is {taken[name]} in formulas; choose another name", key=key
        )
    base = name.removesuffix(RATE)
    if base != name and base in scene.coordinates:
        raise SceneError(
            f"the name {name!r} is the rate of coordinates.{base} in formulas; choose another name",
            key=key,
        )


def _check_coordinate(scene: Scene, coordinate: Coordinate, key: str) -> None:
    sort = only_one(coordinate, tuple(KEYS), key)
    known = tuple(name for names in KEYS.values() for name in names)
    refuse_foreign(coordinate, KEYS[sort], known, key)
    is_angle = False
    if coordinate.joint is not None:
        is_angle = check_leaves(scene, coordinate.joint, coordinate.of, key) in ANGLES
    elif coordinate.bodies is not None:
        _check_distance(scene, coordinate, key)
    else:
        check_place(scene, coordinate.body, coordinate.point, key)
        if coordinate.along is None:
            raise SceneError("is missing; wanted a direction in frame O", key=f"{key}.along")
        if not hypot(*coordinate.along) >= 1 / LARGEST:
            raise SceneError("has zero length; wanted a direction", key=f"{key}.along")
    if isinstance(coordinate.near, Angle) and not is_angle:
        raise SceneError("is an angle; wanted a distance", key=f"{key}.near")
    if coordinate.near is not None and not is_angle and not coordinate.hold:
        raise SceneError(
            "belongs to an angle, whose turns it tells apart, or to a coordinate with 'hold'; "
            "leave it out",
            key=f"{key}.near",
        )


def _check_distance(scene: Scene, coordinate: Coordinate, key: str) -> None:
    assert coordinate.bodies is not None
    if coordinate.points is None:
        raise SceneError("is missing; wanted a point in each body", key=f"{key}.points")
    for index, (body, point) in enumerate(zip(coordinate.bodies, coordinate.points, strict=True)):
        if body != GROUND:
            require_known("body", body, scene.bodies, f"{key}.bodies[{index}]", GROUND)
            check_only_point(scene, body, point, f"{key}.points[{index}]")
    require_two(coordinate.bodies, key)
