"""The program of a scene with bodies reduced to what their joints with the ground leave free."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.composition.bodies import thickened
from kousoku.codegen.dynamics.composition.compose import compose
from kousoku.codegen.dynamics.explanation.counts import counts
from kousoku.model.mechanism import GROUND_INDEX

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.codegen.dynamics.recording.program import Program
    from kousoku.model.mechanism import System

#: How many velocities a joint may leave: none of bodies that drivers lead, and any number.
PRESCRIBED, ALL = 0, 6
#: Of so many rows one must go at least, or a second program takes longer than it will ever save.
WORTH = 8
#: The segments that every stage of a step runs: what they cost decides, whatever is wanted beside.
OFTEN = frozenset({"geometry", "position", "move", "velocity", "acceleration"})


def reduced(
    system: System, wanted: Sequence[str], program: Program, most_free: int = ALL
) -> Program:
    """Return the program in which bodies on joints with the ground have no rows of these joints.

    That is the program itself where there are no such bodies, or few in a large scene and drivers
    lead none of them, where it would cost more, and where rows depend on others: there all rows are
    needed, to watch them and to take over.

    Parameters
    ----------
    system : System
        The scene.
    wanted : sequence of str
        What is computed.
    program : Program
        What :func:`~kousoku.codegen.dynamics.generate.independent` returned, or the program that
        tells the forces of joints.
    most_free : int
        How many velocities a joint may leave to a body.
    """
    if program.left_out or not _is_worth(system, program):
        return program
    heavy = system if program.is_planar else thickened(system)
    found = compose(heavy, wanted, may_be_planar=program.is_planar, most_free=most_free)
    if not found.reduced or _cost(found) >= _cost(program):
        return program
    return replace(
        found,
        not_unique=program.not_unique,
        undetermined=program.undetermined,
        unique_in_plane=program.unique_in_plane,
        only_in_plane=program.only_in_plane,
        is_weighed=program.is_weighed,
    )


def _is_worth(system: System, program: Program) -> bool:
    """Return whether drivers act on bodies at the ground, or joints there have many of the rows."""
    grounded = [len(one.bodies) == 2 and GROUND_INDEX in one.bodies for one in system.constraints]
    if any(one.is_driver for one, at in zip(system.constraints, grounded, strict=True) if at):
        return True
    count = sum(grounded[row.instance] for row in program.rows)
    return 0 < len(program.rows) <= WORTH * count


def _cost(program: Program) -> int:
    return sum(one.operations for one in counts(program) if one.segment in OFTEN)
