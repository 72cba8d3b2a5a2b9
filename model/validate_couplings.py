"""Check couplings of a spatial scene: gears, racks and pinions, linear relations."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.model.decode import require_known
from kousoku.model.errors import SceneError
from kousoku.model.joints import COUPLINGS, NAMES, leaves_of
from kousoku.model.spatial import GROUND
from kousoku.model.text import with_a
from kousoku.model.validate_coordinates import check_counted

if TYPE_CHECKING:
    from collections.abc import Iterator

    from kousoku.model.scene import Scene
    from kousoku.model.spatial import Joint

MOST_BODIES = 4
"""Moving bodies that one coupling may connect."""


def check_coupling(scene: Scene, joint: Joint, key: str) -> None:
    """Check a joint that couples coordinates of others.

    Raises
    ------
    SceneError
        With the dotted key of what is wrong.
    """
    own = COUPLINGS[NAMES[joint.type]].keys
    for name in joint.__struct_fields__:
        if name not in ("type", *own) and getattr(joint, name) is not None:
            raise SceneError(
                f"{with_a(joint.type)} couples what joints leave free, and has none; leave it out",
                key=f"{key}.{name}",
            )
    for name in own:
        if getattr(joint, name) is None:
            raise SceneError(
                f"is missing; {with_a(joint.type)} wants {WANTED[name]}", key=f"{key}.{name}"
            )
    if joint.joints is not None:
        _check_joints(scene, joint, key)
    for name in ("ratio", "radius"):
        if getattr(joint, name) == 0:
            raise SceneError(
                f"a {name} of zero holds one of the two and leaves the other free; wanted a "
                "positive or negative number",
                key=f"{key}.{name}",
            )
    if joint.coordinates is not None:
        _check_coordinates(scene, joint, key)
    bodies = dict.fromkeys(_bodies(scene, joint))
    if len(bodies) > MOST_BODIES:
        raise SceneError(
            f"connects {len(bodies)} moving bodies; at most {MOST_BODIES} are possible: couple "
            "fewer coordinates",
            key=key,
        )


WANTED = {
    "joints": "the names of two joints",
    "ratio": "the turns of the second joint by a turn of the first",
    "radius": "the displacement of the rack by the angle of the pinion",
    "coordinates": "names of coordinates",
    "factors": "a number for each coordinate",
}


def _check_joints(scene: Scene, joint: Joint, key: str) -> None:
    coupled: tuple[str, ...] = joint.joints or ()
    wanted = COUPLINGS[NAMES[joint.type]].couples
    for index, (name, sort) in enumerate(zip(coupled, wanted, strict=True)):
        place = f"{key}.joints[{index}]"
        require_known("joint", name, scene.joints, place)
        kind = scene.joints[name].type
        if sort not in leaves_of(kind):
            raise SceneError(
                f"{name} is {with_a(kind)} joint, which has no {sort} that is one number; wanted a "
                f"joint that leaves one free",
                key=place,
            )
        check_counted(scene, name, sort, place)
    if len(set(coupled)) == 1:
        raise SceneError(
            f"couples {coupled[0]} to itself; wanted two different joints", key=f"{key}.joints"
        )


def _check_coordinates(scene: Scene, joint: Joint, key: str) -> None:
    names, factors = joint.coordinates or (), joint.factors or ()
    if not names:
        raise SceneError("is empty; wanted names of coordinates", key=f"{key}.coordinates")
    if len(names) != len(factors):
        raise SceneError(
            f"has {len(factors)} numbers for {len(names)} coordinates; wanted one for each",
            key=f"{key}.factors",
        )
    for index, name in enumerate(names):
        place = f"{key}.coordinates[{index}]"
        require_known("coordinate", name, scene.coordinates, place)
        if name in names[:index]:
            raise SceneError(f"{name} stands there twice; leave one out", key=place)
    for index, factor in enumerate(factors):
        if factor == 0:
            raise SceneError(
                "is zero; wanted a number, or leave the coordinate out",
                key=f"{key}.factors[{index}]",
            )


def _bodies(scene: Scene, joint: Joint) -> Iterator[str]:
    """Moving bodies that a coupling connects."""
    given = [scene.coordinates[name] for name in joint.coordinates or ()]
    names = [*(joint.joints or ()), *(one.joint for one in given if one.joint is not None)]
    bodies = [body for name in names for body in scene.joints[name].ends]
    bodies += [body for one in given for body in (one.body, *(one.bodies or ())) if body]
    yield from (body for body in bodies if body != GROUND)
