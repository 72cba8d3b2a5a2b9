"""From a scene of bodies to the folder of its solver; SymPy is never started."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.assembly import assemble
from kousoku.codegen.dynamics.compose import compose
from kousoku.codegen.dynamics.emit import emit_dynamics
from kousoku.codegen.dynamics.freedom import freedom_of, kept_rows
from kousoku.codegen.dynamics.inline import inline
from kousoku.codegen.dynamics.merge import merged
from kousoku.codegen.dynamics.motion_data import is_flat
from kousoku.codegen.dynamics.run import Workspace
from kousoku.model.errors import SceneError
from kousoku.model.system import system_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.codegen.dynamics.freedom import Freedom
    from kousoku.codegen.dynamics.program import Program
    from kousoku.model.mechanism import System
    from kousoku.model.scene import Scene


#: What every solver has for the ledger of its runs.
LEDGER = ("checks", "energies")
#: Rows are dependent when one pivot is smaller than this part of another.
DEPENDENT = 1e-12
#: Joints that a message names.
SHOWN = 6


def generate_dynamics(scene: Scene, outputs: Sequence[str] | None = None) -> dict[str, str]:
    """Return the folder of the solver of a scene of bodies.

    Parameters
    ----------
    scene : Scene
        A checked spatial scene.
    outputs : sequence of str, optional
        What is wanted of ``accelerations``, ``reactions`` and ``energies``, beside positions and
        velocities; what the scene says unless given.

    Returns
    -------
    dict of str to str
        File name and text.

    Raises
    ------
    SceneError
        The scene asks for what dynamics does not honour, or for reactions that are not unique; the
        message names it.
    AssemblyError
        Its bodies do not fit together near the positions that it gives.
    """
    wanted = scene.outputs if outputs is None else outputs
    system = merged(assemble(system_of(scene)), wanted).system
    program, freedom = independent(system, (*LEDGER, *wanted))
    if "reactions" in wanted:
        _require_unique(freedom)
    if "reactions" in wanted and program.is_planar and not is_flat(program, system):
        program = _spatial(system, (*LEDGER, *wanted)) or program
    return emit_dynamics(inline(program), system, wanted)


def independent(
    system: System, wanted: Sequence[str], *, may_be_planar: bool = True
) -> tuple[Program, Freedom]:
    """Return the program of an assembled system without rows that depend on others.

    Returns
    -------
    Program
        As :func:`compose` returns it.
    Freedom
        What was found: degrees of freedom, and the rows that were left out.
    """
    program = compose(system, wanted, may_be_planar=may_be_planar)
    freedom = freedom_of(system, program)
    if freedom.dropped:
        rows = kept_rows(freedom, program)
        program = compose(system, wanted, rows=rows, may_be_planar=may_be_planar)
    return program, freedom


def _require_unique(freedom: Freedom) -> None:
    """Refuse reactions that the motion does not determine."""
    if joints := freedom.not_unique:
        shown = ", ".join(f"joints.{joint}" for joint in joints[:SHOWN])
        more = f" and {len(joints) - SHOWN} more" if len(joints) > SHOWN else ""
        raise SceneError(
            f"asks for reactions, which are not unique at {shown}{more}: {len(freedom.dropped)} of"
            f" {freedom.rows} rows depend on others; leave reactions out, or free what is held"
            " twice (kousoku explain lists it)",
            key="outputs",
        )


def _spatial(system: System, wanted: Sequence[str]) -> Program | None:
    """Return the program in space, if it determines all reactions: no row depends on others."""
    try:
        program = compose(system, wanted, may_be_planar=False)
        workspace = Workspace(program)
        workspace.run("geometry")
    except SceneError:  # a body that only a motion in the plane can have, such as a thin rod
        return None
    except ZeroDivisionError:  # a pivot is exactly zero
        return None
    pivots = workspace["pivots"]
    return program if min(pivots) > DEPENDENT * max(pivots) else None
