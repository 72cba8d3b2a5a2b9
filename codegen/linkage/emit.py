"""Emission of a linkage: segments and tables as of a scene of bodies, and the analysis beside."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.codegen.context_lines import ascii_of, plain
from kousoku.codegen.dynamics.emission.context import enumerators, segment_text
from kousoku.codegen.dynamics.emission.emit import solver_folder
from kousoku.codegen.dynamics.emission.numpy_context import (
    python_kernels,
    python_segment,
    regions_of,
)
from kousoku.codegen.dynamics.emission.slots import slots_of
from kousoku.codegen.emit import MESSAGES, runtime_sources
from kousoku.codegen.linkage.data import linkage_data
from kousoku.codegen.linkage.layout import REGIONS
from kousoku.model.files.jsontext import to_text
from kousoku.model.files.manifest import LINKAGE_LIBRARY, MOTION_FILE
from kousoku.runtime.kinematics.rows import RUN

if TYPE_CHECKING:
    from collections.abc import Mapping

    from kousoku.codegen.dynamics.recording.program import Program
    from kousoku.codegen.linkage.layout import WorkspaceLayout

TEMPLATES = {
    "solver.c": "linkage/solver.c.jinja",
    "solver.h": "linkage/solver.h.jinja",
    "solver.py": "linkage/solver.py.jinja",
    "__init__.py": "linkage/__init__.py.jinja",
}
#: Modules that run segments in Python, that results use, and that check options.
SHARED = tuple(f"integrate/{name}.py" for name in ("__init__", "result", "run_arguments", "tasks"))


def emit_linkage(
    program: Program, layout: WorkspaceLayout, more: Mapping[str, str]
) -> dict[str, str]:
    """Folder of a linkage's solver.

    Parameters
    ----------
    program : Program
        The segments of the blocks and of the outputs.
    layout : WorkspaceLayout
        Layout that they were composed of.
    more : mapping of str to str
        Further files, such as reference values.

    Returns
    -------
    dict of str to str
        File name and text, the manifest last.
    """
    scene, regions, slots = layout.assembly.scene, regions_of(program), slots_of(program)
    title = scene.title or f"the linkage {scene.name}"
    sizes = [len(block.unknowns) for block in layout.blocks]
    context = {
        "name": scene.name,
        "title": title,
        "title_ascii": ascii_of(plain(title)),
        "has_angles": layout.wants_angles,
        "largest_block": max(sizes),
        "matrix_size": sum(size * size for size in sizes),
        "work_size": program.size,
        "regions": regions,
        "meanings": [(name, REGIONS[name]) for name, _, _ in regions],
        "places": enumerators({f"W_{name.upper()}": base for name, base, _ in regions}),
        "segments": [segment_text(program, segment, slots) for segment in program.segments],
    }
    python = {
        "kernels": list(python_kernels(program)),
        "segments": [python_segment(program, segment) for segment in program.segments],
    }
    data = linkage_data(program, layout)
    analysis = runtime_sources(LINKAGE_LIBRARY, *SHARED, MESSAGES)
    return solver_folder(
        scene.name,
        title,
        TEMPLATES,
        {"solver": context, "mechanism": data, "python": python, "run": RUN},
        {**analysis, MOTION_FILE: to_text(data), **more},
        scene=to_text(data),
        composition=repr((context, python)),
        runtime=repr(analysis),
    )
