"""System of a scene whose equations are solved: the first stage of all pipelines."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.redundancy.nearly import with_consistent_start
from kousoku.codegen.dynamics.simplification.written_start import require_held
from kousoku.model.lowering.held import require_kept, without_held
from kousoku.model.lowering.system import system_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.model.mechanics.multibody import System
    from kousoku.model.records.scene import Scene


@dataclass(frozen=True, slots=True)
class Assembled:
    """Scene of bodies in SI units, before anything is simplified.

    Parameters
    ----------
    written_system : System
        The scene as it is written.
    placed : System
        The scene at positions and velocities that its joints and drivers allow, with the
        coordinates that only assembly holds.
    system : System
        The same without these: the system that moves.
    """

    written_system: System
    placed: System
    system: System


def assemble_scene(scene: Scene, wanted: Sequence[str]) -> Assembled:
    """Scene as it is written, and at a consistent start.

    Parameters
    ----------
    scene : Scene
        A checked spatial scene.
    wanted : sequence of str
        Outputs that are computed.

    Raises
    ------
    SceneError, AssemblyError
        It asks for what dynamics does not honour, or its bodies do not fit together.
    """
    written = system_of(scene, wanted)
    require_kept(written)
    placed = with_consistent_start(written)
    require_held(written, placed)
    return Assembled(written, placed, without_held(placed))
