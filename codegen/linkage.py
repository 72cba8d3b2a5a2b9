"""From a scene to the folder of its solver: assemble, specialise, emit; SymPy is never started."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from kousoku.codegen.kernel import Package
from kousoku.codegen.kernel_json import load_frozen
from kousoku.codegen.linkage_blocks import live_blocks, triangular_blocks
from kousoku.codegen.linkage_emit import emit_scene
from kousoku.codegen.linkage_kernels import block_kernels
from kousoku.codegen.linkage_layout import Layout
from kousoku.codegen.linkage_link import rows_of
from kousoku.codegen.linkage_outputs import angle_kernel, node_kernel
from kousoku.codegen.linkage_reference import references
from kousoku.codegen.linkage_solution import places, solution
from kousoku.codegen.linkage_view import SolverView, solver_view
from kousoku.model.assemble import assemble
from kousoku.model.manifest import REFERENCE_FILE

if TYPE_CHECKING:
    from kousoku.model.assemble import System
    from kousoku.model.scene import Scene

SOLUTION_FILE = "solution.json"


@dataclass(frozen=True, slots=True)
class Program:
    """A scene ready to be emitted.

    Parameters
    ----------
    layout : Layout
        The system and its blocks.
    package : Package
        The kernels: three for each block, then those of the outputs.
    solver : SolverView
        The tables that the solver walks along.
    """

    layout: Layout
    package: Package
    solver: SolverView


def specialise(system: System, link: Package) -> Program:
    """Return the program of a system: constants bound, only what is wanted, block by block.

    Parameters
    ----------
    system : System
        An assembled scene.
    link : Package
        The frozen link element, with the kernels ``deformation`` and ``rate``.

    Raises
    ------
    SceneError
        Some nodes are free to move, or some links hold what is held already.
    """
    scene = system.scene
    wanted = [term.coordinate for _, x, y in system.nodes for term in (x, y)]
    blocks = live_blocks(system, triangular_blocks(system), wanted)
    layout = Layout(system, blocks, rows_of(link))
    kernels = [kernel for number in range(len(blocks)) for kernel in block_kernels(layout, number)]
    kernels.append(node_kernel(layout))
    if "angles" in scene.outputs:
        kernels.append(angle_kernel(layout))
    package = Package(
        name=scene.name,
        title=scene.title or f"the linkage {scene.name}",
        regenerate=f"kousoku generate {scene.name}.toml",
        kernels=tuple(kernels),
    )
    return Program(layout, package, solver_view(layout))


def generate_scene(scene: Scene) -> dict[str, str]:
    """Return the folder of a scene's solver.

    Parameters
    ----------
    scene : Scene
        A checked planar scene.

    Returns
    -------
    dict of str to str
        File name and text; write them to ``generated/<scene.name>/``, or anywhere else.

    Raises
    ------
    SceneError
        The scene is not a linkage that its inputs determine.
    """
    program = specialise(assemble(scene), load_frozen("link"))
    found = places(program.layout)
    data = {
        REFERENCE_FILE: references(program.package, program.layout, found),
        SOLUTION_FILE: solution(program.layout, found),
    }
    return emit_scene(program.package, program.solver, data)
