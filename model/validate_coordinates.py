"""Check the parameters and coordinates of a spatial scene: names, and what is measured."""

from __future__ import annotations

from math import hypot
from typing import TYPE_CHECKING

from kousoku.model.angles import Angle
from kousoku.model.decode import LARGEST, join, require_known
from kousoku.model.elements.inputs import given as value_given
from kousoku.model.elements.joint import ANGLES, DISPLACEMENTS
from kousoku.model.errors import SceneError
from kousoku.model.expression import ARGUMENTS
from kousoku.model.formulas import RATE, TIME
from kousoku.model.joints import JOINTS, NAMES, leaves_of, listed, sort_of
from kousoku.model.multibody import LAW_NAMES
from kousoku.model.spatial import GROUND
from kousoku.model.text import with_a

if TYPE_CHECKING:
    from kousoku.model.orientation import Vector
    from kousoku.model.problems import Problems
    from kousoku.model.scene import Scene
    from kousoku.model.spatial import Coordinate

KEYS = {
    "joint": ("joint", "of"),
    "bodies": ("bodies", "points"),
    "body": ("body", "point", "along"),
}
"""Keys of each sort of coordinate, by the one that says which it is."""

TITLES = {
    "joint": "the angle or the displacement of a joint",
    "bodies": "the distance of two points",
    "body": "the place of a point along a direction",
}
"""What each sort is, in one line."""

SECOND = "_ddot"
"""What follows the name of a coordinate in the column of its accelerations."""


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
    for name, given in scene.coordinates.items():
        key = join("coordinates", name)
        uses = [join("bodies", body) for body in (given.body, *(given.bodies or ())) if body]
        if given.joint is not None:
            uses.append(join("joints", given.joint))
        problems.check(key, [key, *uses], _check_coordinate, scene, given, key)


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
    of = name.removesuffix(SECOND)
    if table == "coordinates" and (name == "time" or (of != name and of in scene.coordinates)):
        raise SceneError(
            f"the name {name!r} is a column of the motion already; choose another name", key=key
        )
    of = name.removesuffix(RATE)
    if of != name and of in scene.coordinates:
        raise SceneError(
            f"the name {name!r} is the rate of coordinates.{of} in formulas; choose another name",
            key=key,
        )


def only_one(given: object, names: tuple[str, ...], key: str) -> str:
    """Key that is given of some, one of which is wanted.

    Raises
    ------
    SceneError
        None of them is, or more than one.
    """
    found = [name for name in names if value_given(given, name) is not None]
    if len(found) != 1:
        listed = f"{', '.join(names[:-1])} and {names[-1]}"
        got = " and ".join(found) or "none of them"
        raise SceneError(f"wanted one of {listed}, got {got}", key=key)
    return found[0]


def refuse_foreign(given: object, own: tuple[str, ...], known: tuple[str, ...], key: str) -> None:
    """Refuse keys that belong to another sort.

    Raises
    ------
    SceneError
        One of the known keys is given that is not the sort's own.
    """
    for name in known:
        if name not in own and value_given(given, name) is not None:
            raise SceneError(f"does not belong to '{own[0]}'; leave it out", key=f"{key}.{name}")


def check_leaves(scene: Scene, name: str, of: str | None, key: str) -> str:
    """Coordinate of a joint that is meant.

    Raises
    ------
    SceneError
        There is no such joint, or it does not leave that free, or leaves two free.
    """
    require_known("joint", name, scene.joints, f"{key}.joint")
    kind = scene.joints[name].type
    leaves = leaves_of(kind)
    if not leaves:
        known = ", ".join(other for other, entry in JOINTS.items() if entry.leaves)
        raise SceneError(
            f"{name} is {with_a(kind)} joint, which leaves free no angle or displacement that is "
            f"one number; wanted one of {known}",
            key=f"{key}.joint",
        )
    if of is not None and of not in leaves:
        raise SceneError(
            f"{name} is {with_a(kind)} joint, which has no {of} that is one number; wanted "
            f"{listed([repr(leaf) for leaf in leaves], 'or')}",
            key=f"{key}.of",
        )
    if of is None and len(leaves) > 1:
        raise SceneError(
            f"is missing; {name} is {with_a(kind)} joint, which leaves {len(leaves)} free: wanted "
            f"{listed([repr(leaf) for leaf in leaves], 'or')}",
            key=f"{key}.of",
        )
    sort = sort_of(kind, of)
    check_counted(scene, name, sort, key)
    return sort


def check_counted(scene: Scene, name: str, sort: str, key: str) -> None:
    """Refuse a displacement in a plane in which no direction is given.

    Raises
    ------
    SceneError
        The joint leaves two displacements free, and does not say along what the first is.
    """
    joint = scene.joints[name]
    is_across = JOINTS[NAMES[joint.type]].counts_along_zero and sort in DISPLACEMENTS
    if is_across and joint.zero is None:
        raise SceneError(
            f"is missing; {key} takes the {sort} of {name}: wanted the direction across the axis "
            "along which the first displacement is, in each body",
            key=f"{join('joints', name)}.zero",
        )


def _check_coordinate(scene: Scene, given: Coordinate, key: str) -> None:
    sort = only_one(given, tuple(KEYS), key)
    known = tuple(name for names in KEYS.values() for name in names)
    refuse_foreign(given, KEYS[sort], known, key)
    is_angle = False
    if given.joint is not None:
        is_angle = check_leaves(scene, given.joint, given.of, key) in ANGLES
    elif given.bodies is not None:
        _check_distance(scene, given, key)
    else:
        check_place(scene, given.body, given.point, key)
        if given.along is None:
            raise SceneError("is missing; wanted a direction in frame O", key=f"{key}.along")
        if not hypot(*given.along) >= 1 / LARGEST:
            raise SceneError("has zero length; wanted a direction", key=f"{key}.along")
    if isinstance(given.near, Angle) and not is_angle:
        raise SceneError("is an angle; wanted a distance", key=f"{key}.near")
    if given.near is not None and not is_angle and not given.hold:
        raise SceneError(
            "belongs to an angle, whose turns it tells apart, or to a coordinate with 'hold'; "
            "leave it out",
            key=f"{key}.near",
        )


def _check_distance(scene: Scene, given: Coordinate, key: str) -> None:
    bodies: tuple[str, ...] = given.bodies or ()
    if given.points is None:
        raise SceneError("is missing; wanted a point in each body", key=f"{key}.points")
    for index, (body, point) in enumerate(zip(bodies, given.points, strict=True)):
        if body != GROUND:
            require_known("body", body, scene.bodies, f"{key}.bodies[{index}]", GROUND)
            _check_only_point(scene, body, point, f"{key}.points[{index}]")
    if len(set(bodies)) == 1:
        raise SceneError(
            f"connects {bodies[0]} to itself; wanted two different bodies", key=f"{key}.bodies"
        )


def check_place(scene: Scene, body: str | None, point: Vector | None, key: str) -> None:
    """Check a body and a point of it.

    Raises
    ------
    SceneError
        There is no such body, or it is a point and has no other one.
    """
    assert body is not None
    require_known("body", body, scene.bodies, f"{key}.body")
    _check_only_point(scene, body, point, f"{key}.point")


def _check_only_point(scene: Scene, body: str, point: Vector | None, key: str) -> None:
    if scene.bodies[body].point and any(point or ()):
        raise SceneError(f"{body} is a point; wanted [0, 0, 0], its only point", key=key)
