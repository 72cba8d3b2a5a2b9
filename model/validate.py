"""Check what can be known of a scene before anything is derived."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.model.errors import SceneError
from kousoku.model.grashof import check_closure
from kousoku.model.mobility import check_mobility
from kousoku.model.names import name_problem, scene_name_problem
from kousoku.model.scene import TABLES
from kousoku.model.validate_inputs import check_inputs
from kousoku.model.validate_planar import check_planar
from kousoku.model.validate_spatial import check_spatial

if TYPE_CHECKING:
    from kousoku.model.scene import Scene

MOST_DIVISIONS = 10_000_000
"""Rows that a motion may have; more would not fit into the memory of common machines."""

MOST_ITERATIONS = 100_000
"""Largest limit of iterations in one step that is accepted."""

LONGEST_TITLE = 120
"""Characters of the longest title, which becomes one line of generated text."""


def check(scene: Scene) -> tuple[str, ...]:
    """Check a scene, and say what is worth knowing before it is solved.

    Returns
    -------
    tuple of str
        Notes on a valid scene: positions where the linkage is stretched or folded, for instance.

    Raises
    ------
    SceneError
        The first problem that is found, with its dotted key.
    """
    _check_names(scene)
    _check_settings(scene)
    if scene.is_spatial:
        check_spatial(scene)
    else:
        if any(scene.gravity):
            raise SceneError(
                "belongs to bodies; a linkage of nodes and links has no masses", key="gravity"
            )
        check_planar(scene)
    check_inputs(scene)
    if scene.is_spatial:
        return ()
    check_mobility(scene)
    return check_closure(scene)


def require_planar(scene: Scene) -> None:
    """Refuse what today's solver cannot move.

    Raises
    ------
    SceneError
        The scene has bodies or joints in space.
    """
    if scene.is_spatial:
        raise SceneError(
            "spatial scenes are validated but not solved yet; wanted a planar linkage of nodes "
            "and links",
            key="bodies",
        )


def _check_names(scene: Scene) -> None:
    problem = scene_name_problem(scene.name)
    if problem:
        raise SceneError(problem, key="name")
    seen: dict[str, str] = {}
    for table in TABLES:
        for name in getattr(scene, table):
            problem = name_problem(name)
            if problem:
                raise SceneError(problem, key=table)
            if name in seen:
                raise SceneError(
                    f"the name {name!r} is also in {seen[name]}; wanted a name of its own",
                    key=f"{table}.{name}",
                )
            seen[name] = table


def _check_settings(scene: Scene) -> None:
    if not 1 <= scene.divisions <= MOST_DIVISIONS:
        raise SceneError(
            f"{_short(scene.divisions)} divisions; wanted 1 to {MOST_DIVISIONS}", key="divisions"
        )
    method = scene.method
    if not 1 <= method.iterations <= MOST_ITERATIONS:
        raise SceneError(
            f"{_short(method.iterations)} iterations; wanted 1 to {MOST_ITERATIONS}",
            key="method.iterations",
        )
    if method.residual is not None and not method.residual > 0:
        raise SceneError(
            f"a residual of {method.residual!r} cannot be reached; wanted a positive length",
            key="method.residual",
        )
    if len(set(scene.outputs)) < len(scene.outputs):
        raise SceneError("an output stands there twice; leave one out", key="outputs")
    title = scene.title
    unsafe = [mark for mark in ("\\", '"', "*/", "/*", "??/") if mark in title]
    if len(title) > LONGEST_TITLE or not title.isprintable() or unsafe:
        raise SceneError(
            f"wanted one line of at most {LONGEST_TITLE} printable characters without double "
            "quotes, backslashes and comment marks: it heads the generated files",
            key="title",
        )


def _short(number: int) -> str:
    return str(number) if abs(number) < 10**20 else "more than 10²⁰"
