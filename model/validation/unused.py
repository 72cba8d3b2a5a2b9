"""Refuse keys of a scene of bodies that have no effect: nothing is dropped silently."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.model.elements.forces import FORCES
from kousoku.model.records.dotted_keys import join, unknown
from kousoku.model.records.planar import Method
from kousoku.model.records.spatial import SOLIDS

if TYPE_CHECKING:
    from collections.abc import Collection

    from kousoku.model.records.problems import Problems
    from kousoku.model.records.scene import Scene

OUTPUTS = ("positions", "velocities", "accelerations", "coordinates", "reactions", "energies")
"""All outputs of a scene of bodies."""

OF_LINKAGES = ("positions", "velocities", "accelerations", "angles")
"""All outputs of a planar linkage."""

SOURCES = {"coordinates": ("coordinates",), "reactions": ("joints", "drivers")}
"""Tables whose elements an output needs."""


def check_unused(scene: Scene, written_keys: Collection[str], problems: Problems) -> None:
    """Note each key of a scene of bodies that changes nothing.

    Keys that an element with a problem may need are left out.

    Parameters
    ----------
    scene : Scene
        What could be built of it.
    written_keys : collection of str
        The keys of the scene that are written, defaults included.
    problems : Problems
        What is broken in it, and where to note what else is wrong.
    """
    if "divisions" in written_keys and not (
        scene.inputs or problems.touches("inputs", "divisions")
    ):
        problem = (
            "divides the way of inputs, and there are none; leave it out: a run says its times, as "
            "kousoku simulate --end and --samples"
        )
        problems.add(problem, "divisions")
    if "method" in written_keys and scene.method == Method() and not problems.is_broken("method"):
        problems.add("belongs to a planar linkage; leave it out", "method")
    _check_outputs(scene, problems)
    _check_masses(scene, problems)
    for name, body in scene.bodies.items():
        for index, held in enumerate(body.hold):
            if held in body.hold[:index]:
                key = f"{join('bodies', name)}.hold[{index}]"
                problems.add(f"{held!r} stands there twice; leave one out", key)
    for name, force in scene.forces.items():
        key = join("forces", name)
        if not problems.is_broken(key):
            unused = FORCES[force.type].unused(force) if force.type in FORCES else ()
            for own_key, problem in unused:
                problems.add(problem, f"{key}.{own_key}")


def _check_outputs(scene: Scene, problems: Problems) -> None:
    """Refuse outputs of elements that the scene does not have."""
    for index, output in enumerate(scene.outputs):
        if output not in OUTPUTS or problems.touches(*SOURCES.get(output, ())):
            continue  # the output is refused elsewhere, or its table is broken
        if problem := output_problem(scene, output):
            problems.add(problem, f"outputs[{index}]")


def output_problem(scene: Scene, output: str) -> str:
    """Problem with an output of a scene: it is unknown, or the scene has no elements for it.

    Parameters
    ----------
    scene : Scene
        The scene.
    output : str
        Its name.

    Returns
    -------
    str
        Empty where nothing is.
    """
    known = OUTPUTS if scene.is_spatial else OF_LINKAGES
    if problem := foreign_output(scene, output):
        return problem
    if output not in known:
        return unknown(f"output {output[:40]!r}", output, known)
    tables = SOURCES.get(output, ())
    if tables and not any(getattr(scene, table) for table in tables):
        return f"the scene has no {' and no '.join(tables)}; leave it out"
    return ""


def foreign_output(scene: Scene, output: str) -> str:
    """Problem with an output that scenes of the other sort alone have, else an empty text."""
    known, others = (OUTPUTS, OF_LINKAGES) if scene.is_spatial else (OF_LINKAGES, OUTPUTS)
    if output in known or output not in others:
        return ""
    mechanism = "bodies and joints" if scene.is_spatial else "a planar linkage"
    return f"{output!r} is no output of {mechanism}; leave it out"


def _check_masses(scene: Scene, problems: Problems) -> None:
    """Refuse forces where no body has a mass."""
    if not scene.forces or not scene.bodies or problems.touches("bodies"):
        return
    if any(getattr(body, key) for body in scene.bodies.values() for key in ("mass", *SOLIDS)):
        return
    problem = "move nothing, since no body has a mass; give the bodies masses, or leave them out"
    problems.add(problem, "forces")
