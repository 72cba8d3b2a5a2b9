"""Emit a linkage: its kernels as of any package, its tables, and the analysis that they need."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku import __version__
from kousoku.codegen.context import package_context
from kousoku.codegen.emit import (
    FILES,
    LIBRARIES,
    along,
    environment,
    inputs_of,
    promise,
    with_manifest,
)

if TYPE_CHECKING:
    from collections.abc import Mapping

    from kousoku.codegen.kernel import Package
    from kousoku.codegen.linkage_view import SolverView

#: Files that are not as of any package, and their templates.
SOLVER_FILES = {
    "__init__.py": "linkage/__init__.py.jinja",
    "kernels.c": "linkage/kernels.c.jinja",
    "kernels.h": "linkage/kernels.h.jinja",
    "solver.py": "linkage/solver.py.jinja",
}
#: The analysis that all scenes share: a folder of the runtime that goes along.
LIBRARY = "kinematics"
#: What results are made of, and what checks options, of another folder.
RESULT = ("integrate/__init__.py", "integrate/given.py", "integrate/result.py")


def emit_scene(package: Package, solver: SolverView, data: Mapping[str, str]) -> dict[str, str]:
    """Return the folder of a scene: the kernels and their solver.

    Parameters
    ----------
    package : Package
        The kernels of the blocks and of the outputs.
    solver : SolverView
        What the solver is made of.
    data : mapping of str to str
        File name and text of what belongs in the folder beside the code.

    Returns
    -------
    dict of str to str
        File name and text, the manifest last.
    """
    templates = environment()
    analysis = along(LIBRARY, *RESULT)
    promised = promise(package, inputs_of(package, solver, analysis))
    view = package_context(package, __version__, promised.digest)
    files = {
        name: templates.get_template(path).render(package=view, solver=solver)
        for name, path in (FILES | SOLVER_FILES).items()
    }
    files |= along(*LIBRARIES) | analysis | dict(sorted(data.items()))
    return with_manifest(files, promised)
