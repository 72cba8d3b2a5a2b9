"""Checks that kinds of elements share: keys of a record, coordinates of joints, points."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.model.elements.inputs import key_value
from kousoku.model.elements.joint import DISPLACEMENTS
from kousoku.model.elements.joints import JOINTS, NAMES, free_coordinates_of, sort_of
from kousoku.model.errors import SceneError
from kousoku.model.records.dotted_keys import join, require_known
from kousoku.model.text import in_words, with_a

if TYPE_CHECKING:
    from kousoku.model.records.orientation import Vector
    from kousoku.model.records.scene import Scene


def only_one(record: object, names: tuple[str, ...], key: str) -> str:
    """Key of a record that is written, the only one of some keys.

    Raises
    ------
    SceneError
        None of them is written, or more than one.
    """
    written = [name for name in names if key_value(record, name) is not None]
    if len(written) != 1:
        got = " and ".join(written) or "none of them"
        raise SceneError(f"wanted one of {in_words(names)}, got {got}", key=key)
    return written[0]


def refuse_foreign(record: object, keys: tuple[str, ...], known: tuple[str, ...], key: str) -> None:
    """Refuse keys that belong to another sort.

    Raises
    ------
    SceneError
        One of the known keys is written that the sort does not have.
    """
    for name in known:
        if name not in keys and key_value(record, name) is not None:
            raise SceneError(f"does not belong to '{keys[0]}'; leave it out", key=f"{key}.{name}")


def check_leaves(scene: Scene, name: str, of: str | None, key: str) -> str:
    """Free coordinate of a joint, checked: the one that is named, or the only one.

    Raises
    ------
    SceneError
        There is no such joint, it does not leave that free, or leaves two free and none is named.
    """
    require_known("joint", name, scene.joints, f"{key}.joint")
    kind = scene.joints[name].type
    free = free_coordinates_of(kind)
    if not free:
        known = ", ".join(other for other, entry in JOINTS.items() if entry.free_coordinates)
        raise SceneError(
            f"{name} is {with_a(kind)} joint, which leaves free no angle or displacement that is "
            f"one number; wanted one of {known}",
            key=f"{key}.joint",
        )
    if of is not None and of not in free:
        raise SceneError(
            f"{name} is {with_a(kind)} joint, which has no {of} that is one number; wanted "
            f"{in_words([repr(sort) for sort in free], 'or')}",
            key=f"{key}.of",
        )
    if of is None and len(free) > 1:
        raise SceneError(
            f"is missing; {name} is {with_a(kind)} joint, which leaves {len(free)} free: wanted "
            f"{in_words([repr(sort) for sort in free], 'or')}",
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


def check_place(scene: Scene, body: str | None, point: Vector | None, key: str) -> None:
    """Check a body and a point (3,) [unit of the scene] of it, body frame.

    Raises
    ------
    SceneError
        There is no such body, or it is a point and has no other one.
    """
    assert body is not None
    require_known("body", body, scene.bodies, f"{key}.body")
    check_only_point(scene, body, point, f"{key}.point")


def check_only_point(scene: Scene, body: str, point: Vector | None, key: str) -> None:
    """Refuse any point (3,) [unit of the scene] but the origin of a body that is a point.

    Raises
    ------
    SceneError
        The body has no other point.
    """
    if scene.bodies[body].point and any(point or ()):
        raise SceneError(f"{body} is a point; wanted [0, 0, 0], its only point", key=key)


def require_two(bodies: tuple[str, str], key: str) -> None:
    """Refuse a body that is connected to itself.

    Raises
    ------
    SceneError
        With the dotted key of the bodies.
    """
    if bodies[0] == bodies[1]:
        raise SceneError(
            f"connects {bodies[0]} to itself; wanted two different bodies", key=f"{key}.bodies"
        )
