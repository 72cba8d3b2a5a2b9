"""From a scene to the system whose equations are solved: the first stage of all pipelines."""

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
    """A scene of bodies in SI units, before anything is simplified.

    Parameters
    ----------
    given : System
        As it is written.
    placed : System
        At positions and velocities that its joints and drivers allow, what is held among them.
    system : System
        The same without what only assembly holds: what moves.
    """

    given: System
    placed: System
    system: System


def assemble_scene(scene: Scene, wanted: Sequence[str]) -> Assembled:
    """Scene as it is written, and at a consistent start.

    Parameters
    ----------
    scene : Scene
        A checked spatial scene.
    wanted : sequence of str
        What is computed.

    Raises
    ------
    SceneError, AssemblyError
        It asks for what dynamics does not honour, or its bodies do not fit together.
    """
    given = system_of(scene, wanted)
    require_kept(given)
    placed = with_consistent_start(given)
    require_held(given, placed)
    return Assembled(given, placed, without_held(placed))
