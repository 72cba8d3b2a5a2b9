"""From a scene of bodies to the folder of its solver; SymPy is never started."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.assembly import assemble
from kousoku.codegen.dynamics.compose import compose
from kousoku.codegen.dynamics.emit import emit_dynamics
from kousoku.codegen.dynamics.inline import inline
from kousoku.model.system import system_of

if TYPE_CHECKING:
    from kousoku.model.scene import Scene


def generate_dynamics(scene: Scene) -> dict[str, str]:
    """Return the folder of the solver of a scene of bodies.

    Parameters
    ----------
    scene : Scene
        A checked spatial scene.

    Returns
    -------
    dict of str to str
        File name and text.

    Raises
    ------
    SceneError
        The scene asks for what dynamics does not honour; the message names it.
    AssemblyError
        Its bodies do not fit together near the positions that it gives.
    """
    system = assemble(system_of(scene))
    return emit_dynamics(inline(compose(system)), system)
