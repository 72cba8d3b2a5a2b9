"""Check the bodies and joints of a spatial scene one by one."""

from __future__ import annotations

from math import hypot
from typing import TYPE_CHECKING

from kousoku.model.decode import LARGEST, unknown
from kousoku.model.errors import SceneError
from kousoku.model.spatial import GROUND, JOINTS_WITH_AXES

if TYPE_CHECKING:
    from kousoku.model.scene import Scene
    from kousoku.model.spatial import Body, Inertia, Joint


def check_spatial(scene: Scene) -> None:
    """Check bodies and joints; whether the mechanism can move is left to its solver.

    Raises
    ------
    SceneError
        The first problem that is found, with its dotted key.
    """
    for table in ("nodes", "links", "rigid", "sliders"):
        if getattr(scene, table):
            raise SceneError(
                "belongs to a planar linkage; wanted either nodes and links, or bodies and joints",
                key=table,
            )
    if not scene.bodies:
        raise SceneError("is missing; joints need bodies to connect", key="bodies")
    if GROUND in scene.bodies:
        raise SceneError(
            f"{GROUND!r} is the fixed body that every scene has; choose another name",
            key=f"bodies.{GROUND}",
        )
    for name, body in scene.bodies.items():
        _check_body(body, f"bodies.{name}")
    for name, joint in scene.joints.items():
        _check_joint(scene, joint, f"joints.{name}")
    connected = {body for joint in scene.joints.values() for body in joint.bodies}
    for name in scene.bodies:
        if name not in connected:
            raise SceneError("no joint connects this body", key=f"bodies.{name}")


def _check_body(body: Body, key: str) -> None:
    if body.orientation is not None and not hypot(*body.orientation.quaternion) >= 1 / LARGEST:
        raise SceneError(
            "has zero length; wanted Euler parameters of a rotation",
            key=f"{key}.orientation.quaternion",
        )
    direct = [of for of in ("mass", "center", "inertia") if getattr(body, of) is not None]
    if direct and body.mass_points:
        raise SceneError(
            f"has mass_points and {' and '.join(direct)}; wanted one description of the mass",
            key=key,
        )
    if direct and body.mass is None:
        raise SceneError(f"is missing, but {direct[0]} is given", key=f"{key}.mass")
    if body.mass is not None:
        _check_mass(body.mass, f"{key}.mass")
    for index, point in enumerate(body.mass_points):
        _check_mass(point.mass, f"{key}.mass_points[{index}].mass")
    if body.inertia is not None:
        _check_inertia(body.inertia, f"{key}.inertia")


def _check_mass(mass: float, key: str) -> None:
    if not 0 < mass <= LARGEST:
        raise SceneError(f"a mass of {mass!r} kg; wanted a positive mass", key=key)


def _check_inertia(inertia: Inertia, key: str) -> None:
    """Refuse moments that no body has: the sum of two is never less than the third."""
    moments = (inertia.xx, inertia.yy, inertia.zz)
    largest = max(moments)
    if min(moments) < 0 or largest > (sum(moments) - largest) * (1 + 1e-9):
        raise SceneError(
            "no body has these moments: each is positive, and the sum of two is at least the third",
            key=key,
        )


def _check_joint(scene: Scene, joint: Joint, key: str) -> None:
    known = (*scene.bodies, GROUND)
    for index, body in enumerate(joint.bodies):
        if body not in known:
            raise SceneError(
                unknown(f"body {body[:40]!r}", body, known), key=f"{key}.bodies[{index}]"
            )
    if joint.bodies[0] == joint.bodies[1]:
        raise SceneError(
            f"connects {joint.bodies[0]} to itself; wanted two different bodies",
            key=f"{key}.bodies",
        )
    if joint.type in JOINTS_WITH_AXES:
        if joint.axes is None:
            raise SceneError(
                f"is missing; a {joint.type} joint wants an axis in each body", key=f"{key}.axes"
            )
        for index, axis in enumerate(joint.axes):
            if not hypot(*axis) >= 1 / LARGEST:
                raise SceneError("has zero length; wanted an axis", key=f"{key}.axes[{index}]")
    elif joint.axes is not None:
        raise SceneError(f"a {joint.type} joint has no axis; leave it out", key=f"{key}.axes")
