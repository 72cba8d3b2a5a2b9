"""Check the forces, torques and springs of a spatial scene one by one."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.model.decode import join, require_known
from kousoku.model.errors import SceneError
from kousoku.model.formulas import (
    fixed_names,
    formula_problems,
    state_names,
    used_names,
    values_at_start,
)
from kousoku.model.loads import KEYS
from kousoku.model.mechanism import LAW_NAMES
from kousoku.model.spatial import GROUND
from kousoku.model.text import with_a
from kousoku.model.validate_coordinate_forces import (
    check_along,
    check_bushing,
    check_friction,
    check_law,
    check_rotational,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Collection

    from kousoku.model.loads import Force
    from kousoku.model.problems import Problems
    from kousoku.model.scene import Scene
    from kousoku.model.spatial import Event

OF_MOTION = ("force", "force_b", "torque", "torque_b")
"""Keys whose formulas may depend on the motion; the others' on what is fixed in a run."""


def uses_of(force: Force) -> list[str]:
    """Return the elements that the check of a force depends on."""
    tables = {
        "bodies": (force.body, *(force.bodies or ())),
        "joints": (force.joint,),
        "coordinates": (force.coordinate,),
    }
    return [join(table, name) for table, names in tables.items() for name in names if name]


def check_force(
    scene: Scene, force: Force, key: str, names: Collection[str], problems: Problems
) -> None:
    """Check the parts of a force, each whatever is wrong with the others.

    Formulas are checked unless a table of names that they may use is not what it should be.

    Parameters
    ----------
    scene : Scene
        Where it is.
    force : Force
        The force.
    key : str
        Its dotted key.
    names : collection of str
        What formulas of the motion may depend on.
    problems : Problems
        What is broken in the scene, and where to note what else is wrong.
    """
    problems.check(key, uses_of(force), _check_keys, scene, force, key)
    if not problems.touches("parameters", "coordinates"):
        problems.check(key, (), _check_formulas, scene, force, key, names)


def _check_keys(scene: Scene, force: Force, key: str) -> None:
    """Refuse keys that do not belong to the type, bodies that are not there, and lost points."""
    require_known("force", force.type, KEYS, f"{key}.type")
    own = KEYS[force.type]
    for name in dict.fromkeys(name for names in KEYS.values() for name in names):
        if name not in own and getattr(force, name) is not None:
            raise SceneError(f"{with_a(force.type)} has none; leave it out", key=f"{key}.{name}")
    if "bodies" in own:
        _check_ends(scene, force, key)
    CHECKS[force.type](scene, force, key)


def check_gravity(scene: Scene) -> None:
    """Refuse components of gravity that are no formulas of parameters.

    Raises
    ------
    SceneError
        All of them.
    """
    start = values_at_start(scene)
    if found := list(formula_problems(scene.gravity, fixed_names(scene), "gravity", start)):
        raise SceneError.of(found)


def check_event(scene: Scene, event: Event, key: str) -> None:
    """Refuse an event whose formula is none, or never changes.

    Raises
    ------
    SceneError
        With the dotted key of the formula.
    """
    names = state_names(scene)
    if found := list(formula_problems(event.when, names, key, values_at_start(scene))):
        raise SceneError.of(found)
    if not used_names(event.when, names - scene.parameters.keys()):
        raise SceneError(
            "never changes, so that it passes zero nowhere; wanted a formula of t, of coordinates"
            " or of their rates, such as 'x - 1' or 'x_dot'",
            key=key,
        )


def _check_load(scene: Scene, force: Force, key: str) -> None:
    if force.body is None:
        raise SceneError("is missing; wanted the body that it acts on", key=f"{key}.body")
    require_known("body", force.body, scene.bodies, f"{key}.body")
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
    if isinstance(fixed, str | float):
        raise SceneError(
            "is one number; wanted three components in frame O", key=f"{key}.{force.type}"
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


def _check_ends(scene: Scene, force: Force, key: str) -> None:
    """Check what has two bodies."""
    if force.bodies is None:
        raise SceneError("is missing; wanted the two bodies", key=f"{key}.bodies")
    bodies = force.bodies
    for index, name in enumerate(bodies):
        require_known("body", name, scene.bodies, f"{key}.bodies[{index}]", GROUND)
    if len(set(bodies)) == 1:
        raise SceneError(
            f"connects {bodies[0]} to itself; wanted two different bodies", key=f"{key}.bodies"
        )


def _check_spring(scene: Scene, force: Force, key: str) -> None:
    if force.points is None:
        raise SceneError("is missing; wanted its end in each of them", key=f"{key}.points")
    bodies = force.bodies or ()
    for index, (name, point) in enumerate(zip(bodies, force.points, strict=True)):
        if name != GROUND and scene.bodies[name].point:
            _check_only_point(name, point, f"{key}.points[{index}]")
    check_law(force, "tension", key)
    free = force.free_length
    if isinstance(free, float) and free < 0:
        raise SceneError(
            f"a length of {free!r}; wanted none that is negative", key=f"{key}.free_length"
        )


def _check_formulas(scene: Scene, force: Force, key: str, names: Collection[str]) -> None:
    """Refuse texts that are no formulas, all of them."""
    fixed, start = fixed_names(scene), values_at_start(scene)
    may_name = dict.fromkeys(("stiffness", "damping", "free_length", "free_angle"), fixed)
    may_name |= dict.fromkeys(("tension", "moment"), fixed_names(scene, *LAW_NAMES))
    found = [
        problem
        for name, known in (may_name | dict.fromkeys(OF_MOTION, names)).items()
        for problem in formula_problems(getattr(force, name), known, f"{key}.{name}", start)
    ]
    if found:
        raise SceneError.of(found)


CHECKS: dict[str, Callable[[Scene, Force, str], None]] = {
    "force": _check_load,
    "torque": _check_load,
    "spring_damper": _check_spring,
    "rotational_spring_damper": check_rotational,
    "along": check_along,
    "friction": check_friction,
    "bushing": check_bushing,
}
"""What checks the own keys of each type."""
