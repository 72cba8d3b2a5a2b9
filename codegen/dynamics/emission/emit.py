"""Emit a scene of bodies: the solver in C and in Python, and which number belongs to which body."""

from __future__ import annotations

import hashlib
from dataclasses import astuple
from typing import TYPE_CHECKING

from kousoku import __version__
from kousoku.codegen.dynamics.composition.length import characteristic_length
from kousoku.codegen.dynamics.emission.motion_data import motion_data
from kousoku.codegen.dynamics.emission.numpy_view import numpy_view
from kousoku.codegen.dynamics.emission.view import dynamics_view
from kousoku.codegen.emit import along, environment, manifest, template
from kousoku.codegen.kernel import Package
from kousoku.model.jsontext import to_text

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping

    from kousoku.codegen.dynamics.recording.program import Program
    from kousoku.model.mechanism import System

MOTION_FILE = "motion.json"
#: What a row has for each output beyond positions and velocities.
PARTS_OF_ROWS = {
    "accelerations": "v_dot",
    "coordinates": "coordinates",
    "reactions": "reactions",
    "energies": "energies",
}
TEMPLATES = {
    "solver.c": "dynamics/solver.c.jinja",
    "solver.h": "dynamics/solver.h.jinja",
    "__init__.py": "dynamics/__init__.py.jinja",
    "alone.py": "dynamics/alone.py.jinja",
}
#: A module of the runtime that needs NumPy only goes along, for folders that are copied out.
ALONG = ("body_tables.py",)
PYTHON_FILE, PYTHON_TEMPLATE = "solver.py", "dynamics/solver.py.jinja"
#: What the text is made of, for the digest.
PARTS = (
    *TEMPLATES.values(),
    "dynamics/integrator.c.jinja",
    "dynamics/fallback.c.jinja",
    "dynamics/driven.c.jinja",
    "dynamics/calls.c.jinja",
    "c/_macros.jinja",
    PYTHON_TEMPLATE,
    "dynamics/integrator.py.jinja",
    "dynamics/fallback.py.jinja",
    "dynamics/driven.py.jinja",
    "dynamics/calls.py.jinja",
)


def emit_dynamics(
    program: Program,
    system: System,
    outputs: Collection[str] = (),
    more: Mapping[str, str] | None = None,
) -> dict[str, str]:
    """Return the folder of a scene's solver.

    Parameters
    ----------
    program : Program
        Task lists, or what inlining made of them, with ``checks`` and ``energies``.
    system : System
        What the program was composed of.
    outputs : collection of str
        What is wanted beside positions and velocities, of :data:`PARTS_OF_ROWS`.
    more : mapping of str to str, optional
        Further files, such as reference values.

    Returns
    -------
    dict of str to str
        File name and text, the manifest last.
    """
    length = characteristic_length(system)
    parts = tuple(part for name, part in PARTS_OF_ROWS.items() if name in outputs)
    view = dynamics_view(program, system, length, parts)
    templates = environment()
    total = hashlib.sha256(f"{__version__}\n{view!r}\n{astuple(system)!r}".encode())
    tables = along(ALONG)
    for text in (*tables.values(), *map(template, PARTS)):
        total.update(text.encode())
    signature = total.hexdigest()
    given = {"view": view, "version": __version__, "digest": signature, "key": key_of(signature)}
    files = {name: templates.get_template(path).render(**given) for name, path in TEMPLATES.items()}
    python = numpy_view(program, length)
    files[PYTHON_FILE] = templates.get_template(PYTHON_TEMPLATE).render(**given, python=python)
    files |= tables
    files[MOTION_FILE] = to_text(motion_data(program, system, parts))
    files |= more or {}
    package = Package(
        system.name, f"the motion of {system.name}", f"kousoku generate {system.name}.toml", ()
    )
    return files | {"manifest.json": manifest(package, signature, files).to_json()}


def key_of(signature: str) -> str:
    """Return the number that a state of a package begins with: never 0, and exact in a double."""
    return f"{int(signature[:13], 16) | 1}.0"
