"""Emission of a scene of bodies: the solver in C and in Python, and the owners of its numbers."""

from __future__ import annotations

from dataclasses import astuple
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.emission.context import method_text, solver_context
from kousoku.codegen.dynamics.emission.motion_data import motion_data
from kousoku.codegen.dynamics.emission.numpy_context import numpy_context
from kousoku.codegen.dynamics.operations.characteristic_length import characteristic_length
from kousoku.codegen.emit import (
    MESSAGES,
    environment,
    hashed,
    promise,
    runtime_sources,
    templates_in,
    with_manifest,
)
from kousoku.model.files.jsontext import to_text
from kousoku.model.files.manifest import MOTION_FILE
from kousoku.model.operations.kernel import Package
from kousoku.model.version import __version__
from kousoku.runtime.integrate.methods import METHODS
from kousoku.runtime.integrate.motion import PARTS_OF_ROWS

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping

    from kousoku.codegen.dynamics.recording.program import Program
    from kousoku.model.lowering.about import About
    from kousoku.model.mechanics.multibody import System

TEMPLATES = {
    "solver.c": "dynamics/solver.c.jinja",
    "solver.h": "dynamics/solver.h.jinja",
    "solver.py": "dynamics/solver.py.jinja",
    "__init__.py": "dynamics/__init__.py.jinja",
    "integrate/methods.h": "dynamics/methods.h.jinja",
}
#: Files that a solver omits where no parameter changes rows of loops.
OF_RANK = tuple(f"integrate/{name}" for name in ("rank.h", "rank.py", "nearly_dependent.py"))
#: Files that a solver omits where drivers do not determine the motion.
OF_KINEMATICS = ("integrate/kinematics.h", "integrate/kinematics.py")
#: Files that a solver omits without forces along distances.
OF_DISTANCES = ("integrate/distances.h", "integrate/distances.py")
#: Files that a solver omits without forces that jump.
OF_BREAKS = ("integrate/breaks.h", "integrate/breaks.py")
#: Files that a solver omits without forces along distances and without forces that jump.
OF_CUTS = ("integrate/cuts.h", "integrate/cuts.py")


def emit_dynamics(
    program: Program,
    system: System,
    outputs: Collection[str] = (),
    more: Mapping[str, str] | None = None,
    about: About | None = None,
) -> dict[str, str]:
    """Folder of a scene's solver.

    Parameters
    ----------
    program : Program
        Task lists, or the program that inlining made of them, with ``checks`` and ``energies``.
    system : System
        System that the program was composed of.
    outputs : collection of str
        Outputs of :data:`PARTS_OF_ROWS` beside positions and velocities.
    more : mapping of str to str, optional
        Further files, such as reference values.
    about : About, optional
        Facts about the scene that a user may not expect.

    Returns
    -------
    dict of str to str
        File name and text, the manifest last.
    """
    length = characteristic_length(system)
    parts = tuple(part for name, part in PARTS_OF_ROWS.items() if name in outputs)
    context = solver_context(program, system, length, parts)
    omitted = OF_RANK * (not context.looks_at_rank) + OF_KINEMATICS * (not context.is_driven)
    omitted += OF_DISTANCES * ("HAS_DISTANCE" not in context.features)
    omitted += OF_BREAKS * ("HAS_BREAKS" not in context.features)
    omitted += OF_CUTS * {"HAS_DISTANCE", "HAS_BREAKS"}.isdisjoint(context.features)
    copies = runtime_sources("integrate", MESSAGES)
    integrator = {name: text for name, text in copies.items() if name not in omitted}
    variables = {
        "solver": context,
        "python": numpy_context(program, system, length, parts),
        "methods": tuple(map(method_text, METHODS)),
    }
    motion = to_text(motion_data(program, system, parts, context.state, about))
    return solver_folder(
        system.name,
        f"the motion of {system.name}",
        TEMPLATES,
        variables,
        {**integrator, MOTION_FILE: motion, **(more or {})},
        scene=repr(astuple(system)),
        composition=repr(context),
        runtime=repr(integrator),
    )


def solver_folder(
    name: str,
    title: str,
    templates: Mapping[str, str],
    variables: Mapping[str, object],
    files: Mapping[str, str],
    **made_of: str,
) -> dict[str, str]:
    """Folder of a scene's solver, which has no kernels that are called from outside.

    Parameters
    ----------
    name, title : str
        Name of the scene, and title of the folder.
    templates : mapping of str to str
        File name, and the template of each.
    variables : mapping of str to object
        Variables of the templates, beside the version of kousoku, digest and key.
    files : mapping of str to str
        Name and text of further files.
    **made_of
        Further inputs of the text, for the digest: scene, composition, plain source.
    """
    package = Package(name, title, f"kousoku generate {name}.toml", ())
    inputs = hashed(**made_of, templates=templates_in("dynamics/", "linkage/"))
    promised = promise(package, inputs)
    stamp = {"version": __version__, "digest": promised.digest, "key": state_key(promised.digest)}
    template_of = environment().get_template
    texts = {
        name: template_of(path).render(**variables, **stamp) for name, path in templates.items()
    }
    return with_manifest({**texts, **files}, promised)


def state_key(digest: str) -> str:
    """First number of a state of a package: never 0, and exact in a double."""
    return f"{int(digest[:13], 16) | 1}.0"
