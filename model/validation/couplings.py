"""Check couplings of a spatial scene: gears, racks and pinions, linear relations."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.model.elements.checks import check_counted
from kousoku.model.elements.joints import COUPLINGS, NAMES, free_coordinates_of
from kousoku.model.errors import SceneError
from kousoku.model.records.dotted_keys import require_known
from kousoku.model.records.spatial import GROUND
from kousoku.model.text import with_a

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from kousoku.model.records.scene import Scene
    from kousoku.model.records.spatial import Joint

MOST_BODIES = 4
"""Moving bodies that one coupling may connect."""


def check_coupling(scene: Scene, joint: Joint, key: str) -> None:
    """Check a coupling: its keys, its numbers, and the coordinates that it couples.

    Raises
    ------
    SceneError
        With the dotted key of what is wrong.
    """
    kind = COUPLINGS[NAMES[joint.type]]
    for name in joint.__struct_fields__:
        if name in ("type", joint.FLAT, *kind.keys) or getattr(joint, name) is None:
            continue
        raise SceneError(
            f"{with_a(joint.type)} couples what joints leave free, and has none; leave it out",
            key=f"{key}.{name}",
        )
    wanted = [(name, meaning, getattr(joint, name)) for name, meaning in kind.wanted.items()]
    wanted += [(name, entry.meaning, joint.input(name)) for name, entry in kind.inputs.items()]
    for name, meaning, value in wanted:
        if value is None:
            problem = f"is missing; {with_a(joint.type)} wants {meaning}"
            raise SceneError(problem, key=f"{key}.{name}")
    if joint.joints is not None:
        _check_joints(scene, joint, kind.couples, key)
    for name, _, value in wanted:
        if name in kind.not_zero and value == 0:
            raise SceneError(
                f"a {name} of zero holds one of the two and leaves the other free; wanted a "
                "positive or negative number",
                key=f"{key}.{name}",
            )
    kind.check(scene, joint, key)
    bodies = dict.fromkeys(_bodies(scene, joint))
    if len(bodies) > MOST_BODIES:
        raise SceneError(
            f"connects {len(bodies)} moving bodies; at most {MOST_BODIES} are possible: couple "
            "fewer coordinates",
            key=key,
        )


def _check_joints(scene: Scene, joint: Joint, sorts: Sequence[str], key: str) -> None:
    coupled: tuple[str, ...] = joint.joints or ()
    for index, (name, sort) in enumerate(zip(coupled, sorts, strict=True)):
        item_key = f"{key}.joints[{index}]"
        require_known("joint", name, scene.joints, item_key)
        kind = scene.joints[name].type
        if sort not in free_coordinates_of(kind):
            raise SceneError(
                f"{name} is {with_a(kind)} joint, which has no {sort} that is one number; wanted a "
                f"joint that leaves one free",
                key=item_key,
            )
        check_counted(scene, name, sort, item_key)
    if len(set(coupled)) == 1:
        raise SceneError(
            f"couples {coupled[0]} to itself; wanted two different joints", key=f"{key}.joints"
        )


def _bodies(scene: Scene, joint: Joint) -> Iterator[str]:
    """Moving bodies that a coupling connects."""
    coordinates = [scene.coordinates[name] for name in joint.coordinates or ()]
    joints = [*(joint.joints or ()), *(u.joint for u in coordinates if u.joint is not None)]
    bodies = [body for name in joints for body in scene.joints[name].ends]
    bodies += [body for u in coordinates for body in (u.body, *(u.bodies or ())) if body]
    yield from (body for body in bodies if body != GROUND)
