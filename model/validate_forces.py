"""Check the forces, torques and springs of a spatial scene one by one."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.model.decode import unknown
from kousoku.model.errors import SceneError
from kousoku.model.formulas import fixed_names, formula_problems, state_names
from kousoku.model.mechanism import LAW_NAMES
from kousoku.model.spatial import GROUND

if TYPE_CHECKING:
    from kousoku.model.loads import Force
    from kousoku.model.scene import Scene

KEYS = {
    "force": ("body", "point", "force", "force_b"),
    "torque": ("body", "torque", "torque_b"),
    "spring_damper": ("bodies", "points", "stiffness", "damping", "tension", "free_length"),
}
"""Keys of each type."""

LATER = {"rotational_spring_damper": "the angle about a common axis, which must count turns"}
"""Types that are known but cannot be composed yet, and what they wait for."""


def check_force(scene: Scene, force: Force, key: str) -> None:
    """Refuse keys that do not belong to the type, bodies that are not there, and lost points.

    Raises
    ------
    SceneError
        With the dotted key of what is wrong.
    """
    if force.type in LATER:
        raise SceneError(
            f"a {force.type} is not composed yet: it wants {LATER[force.type]}", key=f"{key}.type"
        )
    if force.type not in KEYS:
        raise SceneError(
            unknown(f"force {force.type[:40]!r}", force.type, tuple(KEYS)), key=f"{key}.type"
        )
    own = KEYS[force.type]
    for name in dict.fromkeys(name for names in KEYS.values() for name in names):
        if name not in own and getattr(force, name) is not None:
            raise SceneError(f"a {force.type} has none; leave it out", key=f"{key}.{name}")
    if force.type == "spring_damper":
        _check_spring(scene, force, key)
    else:
        _check_load(scene, force, key)
    _check_formulas(scene, force, key)


def _check_load(scene: Scene, force: Force, key: str) -> None:
    if force.body is None:
        raise SceneError("is missing; wanted the body that it acts on", key=f"{key}.body")
    if force.body not in scene.bodies:
        problem = unknown(f"body {force.body[:40]!r}", force.body, tuple(scene.bodies))
        raise SceneError(problem, key=f"{key}.body")
    fixed, turning = (getattr(force, name) for name in (force.type, f"{force.type}_b"))
    if fixed is None and turning is None:
        raise SceneError(
            f"is missing; wanted its components in frame O, or in the body frame as "
            f"'{force.type}_b'",
            key=f"{key}.{force.type}",
        )
    if fixed is not None and turning is not None:
        raise SceneError(
            f"is given in frame O too, as {force.type}; wanted one of them",
            key=f"{key}.{force.type}_b",
        )
    if scene.bodies[force.body].point:
        if force.type == "torque":
            raise SceneError("a point does not turn; wanted a body", key=f"{key}.body")
        if force.force_b is not None:
            raise SceneError(
                "a point has no axes of its own; wanted 'force', in frame O", key=f"{key}.force_b"
            )
        _check_only_point(force.body, force.point, f"{key}.point")


def _check_only_point(name: str, point: tuple[float, float, float] | None, key: str) -> None:
    if any(point or ()):
        raise SceneError(f"{name} is a point; wanted [0, 0, 0], its only point", key=key)


def _check_spring(scene: Scene, force: Force, key: str) -> None:
    for name, what in (("bodies", "the two bodies"), ("points", "its end in each of them")):
        if getattr(force, name) is None:
            raise SceneError(f"is missing; wanted {what}", key=f"{key}.{name}")
    bodies: tuple[str, ...] = force.bodies or ()
    for index, name in enumerate(bodies):
        if name != GROUND and name not in scene.bodies:
            problem = unknown(f"body {name[:40]!r}", name, (*scene.bodies, GROUND))
            raise SceneError(problem, key=f"{key}.bodies[{index}]")
    if len(set(bodies)) == 1:
        raise SceneError(
            f"connects {bodies[0]} to itself; wanted two different bodies", key=f"{key}.bodies"
        )
    for index, (name, point) in enumerate(zip(bodies, force.points or (), strict=True)):
        if name != GROUND and scene.bodies[name].point:
            _check_only_point(name, point, f"{key}.points[{index}]")
    _check_law(force, key)
    free = force.free_length
    if isinstance(free, float) and free < 0:
        raise SceneError(
            f"a length of {free!r}; wanted none that is negative", key=f"{key}.free_length"
        )


def _check_law(force: Force, key: str) -> None:
    is_linear = force.stiffness is not None or force.damping is not None
    if force.tension is None:
        if not is_linear:
            raise SceneError(
                "is missing; wanted a stiffness, a damping or both, or a tension",
                key=f"{key}.stiffness",
            )
        return
    if is_linear:
        raise SceneError(
            "has a stiffness or a damping too; wanted one of them", key=f"{key}.tension"
        )


def _check_formulas(scene: Scene, force: Force, key: str) -> None:
    """Refuse texts that are no formulas, all of them."""
    fixed = fixed_names(scene)
    names = dict.fromkeys(("stiffness", "damping", "free_length"), fixed)
    names |= dict.fromkeys(("force", "force_b", "torque", "torque_b"), state_names(scene))
    names["tension"] = (*LAW_NAMES, *fixed)
    found = [
        problem
        for name, known in names.items()
        for problem in formula_problems(getattr(force, name), known, f"{key}.{name}")
    ]
    if found:
        raise SceneError.of(found)
