"""Emit a linkage: its segments and tables as of a scene of bodies, and the analysis beside them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku import __version__
from kousoku.codegen.emit import along, environment, hashed, promise, template, with_manifest
from kousoku.codegen.kernel import Package
from kousoku.codegen.linkage_view import linkage_view

if TYPE_CHECKING:
    from collections.abc import Mapping

    from kousoku.codegen.dynamics.recording.program import Program
    from kousoku.codegen.linkage_layout import Layout

TEMPLATES = {
    "solver.c": "linkage/solver.c.jinja",
    "solver.h": "linkage/solver.h.jinja",
    "solver.py": "linkage/solver.py.jinja",
    "__init__.py": "linkage/__init__.py.jinja",
}
#: What these are made of beside themselves, for the digest.
PARTS = (
    "dynamics/_segments.jinja",
    "dynamics/_straight_line.jinja",
    "dynamics/solver.py.jinja",
)
#: The analysis that all scenes share: a folder of the runtime that goes along.
LIBRARY = "kinematics"
#: What runs segments in Python, what results are made of, and what checks options.
SHARED = tuple(f"integrate/{name}.py" for name in ("__init__", "given", "result", "tasks"))


def emit_linkage(program: Program, layout: Layout, more: Mapping[str, str]) -> dict[str, str]:
    """Return the folder of a linkage's solver.

    Parameters
    ----------
    program : Program
        The segments of the blocks and of the outputs.
    layout : Layout
        What they were composed of.
    more : mapping of str to str
        Further files, such as reference values.

    Returns
    -------
    dict of str to str
        File name and text, the manifest last.
    """
    view = linkage_view(program, layout)
    analysis = along(LIBRARY, *SHARED)
    inputs = hashed(
        scene=repr(view),
        templates="".join(map(template, (*TEMPLATES.values(), *PARTS))),
        runtime=repr(analysis),
    )
    package = Package(view.name, view.title, f"kousoku generate {view.name}.toml", ())
    promised = promise(package, inputs)
    python = {"kernels": view.python_kernels, "segments": view.python_segments}
    given = {"view": view, "python": python, "version": __version__, "digest": promised.digest}
    templates = environment()
    files = {name: templates.get_template(path).render(**given) for name, path in TEMPLATES.items()}
    return with_manifest({**files, **analysis, **more}, promised)
