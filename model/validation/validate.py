"""Check all that can be known of a scene before anything is derived of it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec

from kousoku.model.errors import SceneError
from kousoku.model.expressions.design_numbers import with_numbers
from kousoku.model.linkage.grashof import check_closure
from kousoku.model.linkage.mobility import check_mobility
from kousoku.model.records.design import CLOSURE_TOLERANCE
from kousoku.model.records.dotted_keys import join
from kousoku.model.records.problems import Problems
from kousoku.model.records.scene import TABLES
from kousoku.model.validation.drivers import check_drivers
from kousoku.model.validation.inputs import check_inputs
from kousoku.model.validation.names import name_problem, scene_name_problem
from kousoku.model.validation.planar import check_planar
from kousoku.model.validation.spatial import check_spatial
from kousoku.model.validation.unused import check_unused, foreign_output

if TYPE_CHECKING:
    from collections.abc import Collection

    from kousoku.model.records.scene import Scene

MOST_DIVISIONS = 10_000_000
"""Rows that a motion may have; more would not fit into the memory of common machines."""

MOST_ITERATIONS = 100_000
"""Largest limit of iterations in one step that is accepted."""

MOST_CLOSURE = 0.01
"""Largest ``closure_tolerance``; rows that miss by ten times as much are independent."""

LONGEST_TITLE = 120
"""Characters of the longest title, which becomes one line of generated text."""

SECOND = "_ddot"
"""Suffix of the column with the second derivative of a coordinate."""


def check(scene: Scene) -> tuple[str, ...]:
    """Check a scene, and say what is worth knowing before it is solved.

    Returns
    -------
    tuple of str
        Notes on a valid scene: positions where the linkage is stretched or folded, for instance.

    Raises
    ------
    SceneError
        All problems that are found, each with its dotted key.
    """
    problems = Problems()
    fields = msgspec.structs.fields(scene)
    written_keys = [field.name for field in fields if getattr(scene, field.name) != field.default]
    notes = check_parts(scene, problems, written_keys)
    problems.settle()
    return notes


def check_parts(scene: Scene, problems: Problems, written_keys: Collection[str]) -> tuple[str, ...]:
    """Check the elements of a scene, and the whole mechanism only when all elements are right.

    Parameters
    ----------
    scene : Scene
        What could be built of it.
    problems : Problems
        What is broken in it, and where to note what else is wrong.
    written_keys : collection of str
        The keys of the scene that are written, defaults included.

    Returns
    -------
    tuple of str
        As :func:`check` gives them; none where there are problems.
    """
    written, scene = scene, with_numbers(scene)
    _check_names(scene, problems)
    _check_settings(scene, problems)
    is_spatial = scene.is_spatial or problems.touches("bodies", "joints")
    if is_spatial:
        check_spatial(scene, problems)
    else:
        if any(scene.gravity):
            problem = "belongs to bodies; a linkage of nodes and links has no masses"
            problems.add(problem, "gravity")
        if scene.closure_tolerance != CLOSURE_TOLERANCE:
            problem = "belongs to bodies and joints; a linkage is closed to rounding"
            problems.add(problem, "closure_tolerance")
        if scene.forces or problems.touches("forces"):
            problem = "belong to bodies; a linkage of nodes and links has no masses"
            problems.add(problem, "forces")
        for table in ("parameters", "coordinates", "drivers", "events"):
            if getattr(scene, table) or problems.touches(table):
                problems.add("belong to bodies; wanted bodies and joints", table)
        check_planar(scene, problems)
    check_inputs(scene, problems)
    if is_spatial:
        check_drivers(scene, problems)
        check_unused(written, written_keys, problems)
    if is_spatial or problems.found:
        return ()
    problems.check("inputs", (), check_mobility, scene)
    return problems.check("links", ("inputs",), check_closure, scene) or ()


def require_planar(scene: Scene) -> None:
    """Refuse bodies where a linkage of nodes is asked for.

    Raises
    ------
    SceneError
        The scene has bodies or joints in space.
    """
    if scene.is_spatial:
        raise SceneError(
            f"{scene.name} is a scene of bodies; wanted a planar linkage of nodes and links:"
            " kousoku.load moves both",
            key="bodies",
        )


def _check_names(scene: Scene, problems: Problems) -> None:
    problem = scene_name_problem(scene.name)
    if problem and not problems.is_broken("name"):
        problems.add(problem, "name")
    table_of: dict[str, str] = {}
    for table in TABLES:
        for name in getattr(scene, table):
            element_key = join(table, name)
            problem = name_problem(name)
            if problem:
                problems.add(problem, table, breaks=element_key, place=element_key)
            elif name in table_of:
                problem = f"the name {name!r} is also in {table_of[name]}; wanted a name of its own"
                problems.add(problem, element_key)
            elif problem := _column_problem(scene, table, name):
                problems.add(f"{problem}; choose another name", element_key)
            table_of.setdefault(name, table)


def _column_problem(scene: Scene, table: str, name: str) -> str | None:
    """Reason why a column of an element of such a name would hide another one of the motion."""
    base = name.removesuffix(SECOND)
    is_second = table == "coordinates" and base != name and base in scene.coordinates
    if is_second or (name == "time" and table in {"coordinates", "inputs"}):
        return f"the name {name!r} is a column of the motion already"
    if name == "work" and table in {"bodies", "joints", "drivers"} and scene.forces:
        return "columns 'work.…' are the works of forces"
    return None


def _check_settings(scene: Scene, problems: Problems) -> None:
    if not 1 <= scene.divisions <= MOST_DIVISIONS:
        problem = f"{_short(scene.divisions)} divisions; wanted 1 to {MOST_DIVISIONS}"
        problems.add(problem, "divisions", breaks="divisions")
    if scene.duration is not None and not scene.duration > 0:
        problems.add(f"a duration of {scene.duration!r}; wanted seconds, above 0", "duration")
    if not 0 < scene.closure_tolerance <= MOST_CLOSURE:
        problem = f"a closure_tolerance of {scene.closure_tolerance!r}; wanted 0 to {MOST_CLOSURE}"
        problems.add(f"{problem}, in lengths of the scene and rad", "closure_tolerance")
    method = scene.method
    if not 1 <= method.iterations <= MOST_ITERATIONS:
        problem = f"{_short(method.iterations)} iterations; wanted 1 to {MOST_ITERATIONS}"
        problems.add(problem, "method.iterations")
    if method.residual is not None and not method.residual > 0:
        problem = f"a residual of {method.residual!r} cannot be reached; wanted a positive length"
        problems.add(problem, "method.residual", breaks="method")
    if len(set(scene.outputs)) < len(scene.outputs):
        problems.add("an output stands there twice; leave one out", "outputs")
    for index, output in enumerate(scene.outputs):
        if problem := foreign_output(scene, output):
            problems.add(problem, f"outputs[{index}]")
    title = scene.title
    unsafe = [mark for mark in ("\\", '"', "*/", "/*", "??/") if mark in title]
    if len(title) > LONGEST_TITLE or not title.isprintable() or unsafe:
        problems.add(
            f"wanted one line of at most {LONGEST_TITLE} printable characters without double "
            "quotes, backslashes and comment marks: it heads the generated files",
            "title",
        )


def _short(number: int) -> str:
    return str(number) if abs(number) < 10**20 else "more than 10²⁰"
