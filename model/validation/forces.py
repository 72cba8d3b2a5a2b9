"""Check the forces of a spatial scene one by one."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.model.elements.checks import require_two
from kousoku.model.elements.forces import DEPENDS_ON, FORCES
from kousoku.model.errors import SceneError
from kousoku.model.expressions.formulas import (
    LAW_NAMES,
    TIME,
    fixed_names,
    formula_problems,
    values_at_start,
)
from kousoku.model.records.dotted_keys import join, require_known
from kousoku.model.records.spatial import GROUND
from kousoku.model.text import with_a

if TYPE_CHECKING:
    from collections.abc import Collection

    from kousoku.model.records.loads import Force
    from kousoku.model.records.problems import Problems
    from kousoku.model.records.scene import Scene


def uses_of(force: Force) -> list[str]:
    """Elements that the check of a force depends on."""
    tables = {
        "bodies": (force.body, *(force.bodies or ())),
        "joints": (force.joint,),
        "coordinates": (force.coordinate,),
    }
    return [join(table, name) for table, names in tables.items() for name in names if name]


def check_force(
    scene: Scene, force: Force, key: str, names: Collection[str], problems: Problems
) -> None:
    """Check the keys and the formulas of a force, each whatever is wrong with the other.

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
    """Refuse keys that do not belong to the type, unknown bodies, and wrong values of its keys."""
    require_known("force", force.type, FORCES, f"{key}.type")
    kind = FORCES[force.type]
    every_key = dict.fromkeys(name for sort in FORCES.values() for name in sort.keys)
    for name in every_key:
        if name not in kind.keys and getattr(force, name) is not None:
            raise SceneError(f"{with_a(force.type)} has none; leave it out", key=f"{key}.{name}")
    if "bodies" in kind.keys:
        _check_ends(scene, force, key)
    kind.check(scene, force, key)


def _check_ends(scene: Scene, force: Force, key: str) -> None:
    """Check the two bodies of a spring or a bushing."""
    if force.bodies is None:
        raise SceneError("is missing; wanted the two bodies", key=f"{key}.bodies")
    for index, name in enumerate(force.bodies):
        require_known("body", name, scene.bodies, f"{key}.bodies[{index}]", GROUND)
    require_two(force.bodies, key)


def _check_formulas(scene: Scene, force: Force, key: str, names: Collection[str]) -> None:
    """Refuse all texts that are no formulas, and unknown names in formulas."""
    constants, start = fixed_names(scene), values_at_start(scene)
    known: dict[str, Collection[str]]
    known = {"parameters": constants, "time": fixed_names(scene, TIME), "motion": names}
    known["law"] = fixed_names(scene, *LAW_NAMES)
    values = [(name, getattr(force, name), depends_on) for name, depends_on in DEPENDS_ON.items()]
    inputs = FORCES[force.type].inputs if force.type in FORCES else {}
    values += [(name, force.input(name), entry.depends_on) for name, entry in inputs.items()]
    problems = [
        problem
        for name, value, depends_on in values
        if depends_on != "nothing"
        for problem in formula_problems(value, known[depends_on], f"{key}.{name}", start)
    ]
    if problems:
        raise SceneError.of(problems)
