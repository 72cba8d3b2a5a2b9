"""Stages from a scene of nodes to the folder of its solver; SymPy is never started.

``assemble``: Scene → Assembly
    Coordinates, links between them, known and unknown parts.
``layout_of``: Assembly → WorkspaceLayout
    Equations in block-triangular order, as far as outputs need them; indices of all numbers.
``program_of``: WorkspaceLayout → Program
    The frozen link element, block by block: constants bound, in functions of the workspace.
``emit_linkage``: Program → {file: text}
    The folder.
"""

from __future__ import annotations

from textwrap import wrap
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.recording.program import Program, Segment, Task
from kousoku.codegen.linkage.assemble import assemble
from kousoku.codegen.linkage.blocks import live_blocks, triangular_blocks
from kousoku.codegen.linkage.emit import emit_linkage
from kousoku.codegen.linkage.kernels import block_kernels
from kousoku.codegen.linkage.layout import WorkspaceLayout
from kousoku.codegen.linkage.outputs import angle_kernel, node_kernel
from kousoku.codegen.linkage.reference import reference_values
from kousoku.codegen.linkage.solution import positions_of
from kousoku.model.files.manifest import REFERENCE_FILE

if TYPE_CHECKING:
    from kousoku.codegen.linkage.assemble import Assembly
    from kousoku.model.operations.kernel import Kernel
    from kousoku.model.records.scene import Scene


def layout_of(assembly: Assembly) -> WorkspaceLayout:
    """Equations of an assembly block by block, and the indices of all numbers."""
    wanted = [term.coordinate for _, x, y in assembly.nodes for term in (x, y)]
    blocks = live_blocks(assembly, triangular_blocks(assembly), wanted)
    return WorkspaceLayout(assembly, blocks)


def program_of(layout: WorkspaceLayout) -> Program:
    """Program that moves a linkage: three segments for each block, then the outputs."""
    numbers = range(len(layout.blocks))
    kernels = [kernel for number in numbers for kernel in block_kernels(layout, number)]
    kernels.append(node_kernel(layout))
    if layout.wants_angles:
        kernels.append(angle_kernel(layout))
    return Program(
        name=layout.assembly.scene.name,
        kernels=tuple(kernels),
        segments=tuple(_segment(layout, k, kernel) for k, kernel in enumerate(kernels)),
        regions=tuple(layout.regions.values()),
        constants=(),
        size=layout.size,
        bodies=(),
        rows=(),
        is_planar=True,
        is_inlined=True,
    )


def _segment(layout: WorkspaceLayout, number: int, kernel: Kernel) -> Segment:
    """Segment of one kernel of the whole workspace."""
    slots = tuple(layout.regions[quantity.name].base for quantity in kernel.outputs)
    contents = (*wrap(kernel.title, 92), kernel.source)
    return Segment(kernel.name, (Task(number, (0,), slots),), contents, kernel.formula)


def generate_linkage(scene: Scene, *, references: bool = False) -> dict[str, str]:
    """Folder of the solver of a linkage.

    Parameters
    ----------
    scene : Scene
        A checked planar scene.
    references : bool
        Whether the folder has reference values, which ``kousoku verify`` compares with.

    Returns
    -------
    dict of str to str
        File name and text; write them to ``generated/<scene.name>/``, or anywhere else.

    Raises
    ------
    SceneError
        The scene has bodies.
    """
    layout = layout_of(assemble(scene))
    program = program_of(layout)
    data = {}
    if references:
        data[REFERENCE_FILE] = reference_values(program, layout, positions_of(layout))
    return emit_linkage(program, layout, data)
