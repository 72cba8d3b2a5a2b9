"""Check forces that act along coordinates: rotational springs, friction, bushings, formulas."""

from __future__ import annotations

from math import hypot
from typing import TYPE_CHECKING

from kousoku.model.decode import LARGEST, require_known
from kousoku.model.errors import SceneError
from kousoku.model.joints import ANGLE, ANGLES, DISPLACEMENTS, SECOND_ANGLE, leaves_of, sort_of
from kousoku.model.text import with_a
from kousoku.model.validate_coordinates import check_leaves

if TYPE_CHECKING:
    from kousoku.model.loads import Force
    from kousoku.model.scene import Scene

PARALLEL = 1e-6
"""Two directions of a bushing whose angle is smaller do not span a plane [rad]."""


def check_rotational(scene: Scene, force: Force, key: str) -> None:
    """Refuse a rotational spring without an angle, or without a law.

    Raises
    ------
    SceneError
        With the dotted key of what is wrong.
    """
    if (force.joint is None) == (force.coordinate is None):
        both = "is given too; wanted one of them" if force.joint else "is missing; or 'coordinate'"
        raise SceneError(f"{both}: the angle that it acts on", key=f"{key}.joint")
    if force.joint is not None:
        _check_angle(scene, force, key)
    elif not _is_angle(scene, _coordinate(scene, force, key)):
        raise SceneError(
            f"{force.coordinate} is no angle; wanted an angle, or a force of type 'along'",
            key=f"{key}.coordinate",
        )
    check_law(force, "moment", key)


def _check_angle(scene: Scene, force: Force, key: str) -> None:
    """Refuse a joint without an angle, or with two where neither is meant."""
    joint, of = force.joint or "", force.of
    if of in DISPLACEMENTS:
        raise SceneError("is no angle; wanted an angle", key=f"{key}.of")
    leaves = leaves_of(scene.joints[joint].type) if joint in scene.joints else ()
    if leaves and ANGLE not in leaves:
        kind = scene.joints[joint].type
        raise SceneError(
            f"{joint} is {with_a(kind)} joint, which has no angle that is one number",
            key=f"{key}.joint",
        )
    check_leaves(scene, joint, of if of or SECOND_ANGLE in leaves else ANGLE, key)


def check_along(scene: Scene, force: Force, key: str) -> None:
    """Refuse a force along no coordinate.

    Raises
    ------
    SceneError
        With the dotted key of what is wrong.
    """
    if force.coordinate is None:
        raise SceneError(
            "is missing; wanted the coordinate that it acts along", key=f"{key}.coordinate"
        )
    _coordinate(scene, force, key)
    _require_one(force.force, f"{key}.force", f", that increases {force.coordinate}")


def check_friction(scene: Scene, force: Force, key: str) -> None:
    """Refuse friction in what leaves nothing free that is one number.

    Raises
    ------
    SceneError
        With the dotted key of what is wrong.
    """
    if force.joint is None:
        raise SceneError("is missing; wanted the joint that it is in", key=f"{key}.joint")
    of: str | None = force.of
    if of is None and force.joint in scene.joints:
        leaves = leaves_of(scene.joints[force.joint].type)
        of = leaves[0] if leaves else None
    check_leaves(scene, force.joint, of, key)
    _require_one(force.damping, f"{key}.damping")


def _require_one(value: object, key: str, which: str = "") -> None:
    if value is None or isinstance(value, tuple):
        problem = "is missing" if value is None else "has components"
        raise SceneError(f"{problem}; wanted one number or formula{which}", key=key)


def check_bushing(scene: Scene, force: Force, key: str) -> None:
    """Refuse a bushing without a middle, or between points.

    Raises
    ------
    SceneError
        With the dotted key of what is wrong.
    """
    for index, body in enumerate(force.bodies or ()):
        if body in scene.bodies and scene.bodies[body].point:
            raise SceneError(
                f"{body} is a point, which does not turn; wanted a body, or a spring_damper",
                key=f"{key}.bodies[{index}]",
            )
    if (force.points is None) == (force.at is None):
        problem = "is missing" if force.at is None else "is given too"
        raise SceneError(
            f"{problem}; wanted its middle in each body, or once in frame O as 'at'",
            key=f"{key}.points",
        )
    for name in ("stiffness", "damping"):
        if getattr(force, name) is not None and not isinstance(getattr(force, name), tuple):
            raise SceneError(
                "is one number; wanted six: along three directions, then about them",
                key=f"{key}.{name}",
            )
    if force.stiffness is None and force.damping is None:
        raise SceneError(
            "is missing; wanted six stiffnesses, six dampings or both", key=f"{key}.stiffness"
        )
    if force.axes is not None:
        (a, b, c), (x, y, z) = force.axes
        size = hypot(a, b, c) * hypot(x, y, z)
        across = hypot(b * z - c * y, c * x - a * z, a * y - b * x)
        if not (size >= 1 / LARGEST and across > PARALLEL * size):
            raise SceneError("are parallel; wanted two directions", key=f"{key}.axes")


def check_law(force: Force, name: str, key: str) -> None:
    """Refuse a spring with no law, or with two.

    Raises
    ------
    SceneError
        With the dotted key of what is wrong.
    """
    for other in ("stiffness", "damping"):
        if isinstance(getattr(force, other), tuple):
            raise SceneError("has components; wanted one number", key=f"{key}.{other}")
    is_linear = force.stiffness is not None or force.damping is not None
    if getattr(force, name) is None and not is_linear:
        raise SceneError(
            f"is missing; wanted a stiffness, a damping or both, or a {name}",
            key=f"{key}.stiffness",
        )
    if getattr(force, name) is not None and is_linear:
        raise SceneError(
            "has a stiffness or a damping too; wanted one of them", key=f"{key}.{name}"
        )


def _coordinate(scene: Scene, force: Force, key: str) -> str:
    name = force.coordinate or ""
    require_known("coordinate", name, scene.coordinates, f"{key}.coordinate")
    return name


def _is_angle(scene: Scene, name: str) -> bool:
    given = scene.coordinates[name]
    if given.joint is None:
        return False
    return sort_of(scene.joints[given.joint].type, given.of) in ANGLES
