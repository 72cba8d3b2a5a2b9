"""Joints of a planar scene whose rows out of the plane are redundant.

The rows that hold bodies in the plane are not solved for. Where some of them depend on each other,
as in every loop of revolute joints, the forces out of the plane are not unique.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from kousoku.codegen.dynamics.assembly.residuals import Residuals
from kousoku.codegen.dynamics.operations.mechanics import COLUMNS
from kousoku.codegen.dynamics.recording.interpreter import ProgramInterpreter
from kousoku.codegen.dynamics.redundancy.loops import loops_of
from kousoku.codegen.dynamics.redundancy.rank import TAKES_PART, factorise
from kousoku.codegen.sha256_random import Sha256Random

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from kousoku.codegen.dynamics.recording.program import CoordinatePlace, Program
    from kousoku.codegen.dynamics.redundancy.loops import LoopPart
    from kousoku.model.mechanics.multibody import System
    from kousoku.model.numbers.real import Array

#: Rows of the largest part that is looked at; the time grows with their cube.
MOST_OUT_OF_PLANE_ROWS = 2000
#: Distance of the second position from the first, and count of its corrections.
AWAY, CORRECTIONS = 2.0**-5, 8


def held_twice(system: System, program: Program) -> tuple[str, ...]:
    """Joints whose rows out of the plane depend on others, in the order of the system.

    Ranks are taken at the start and at one more position, as a start may be special. Joints of
    parts that are too large are included, as nothing is known of them.

    Parameters
    ----------
    system : System
        An assembled scene.
    program : Program
        Its program in the plane.
    """
    solved = {(row.instance, row.row) for row in (*program.rows, *program.left_out)}
    out = [
        COLUMNS * k + c
        for k, body in enumerate(program.bodies)
        for c, coordinate in enumerate((*body.v, *body.omega_b))
        if coordinate.slot < 0 and not (system.bodies[k].is_point and c > 2)
    ]
    positions = list(_positions(program))
    joints: dict[str, None] = {}
    for part in loops_of(system):
        joints |= dict.fromkeys(_dependent_joints(system, part, solved, out, positions))
    return tuple(joints)


def _dependent_joints(
    system: System,
    part: LoopPart,
    solved: set[tuple[int, int]],
    out: Sequence[int],
    positions: Sequence[tuple[Array, Array]],
) -> Iterator[str]:
    """Joints of a part whose rows depend on others, one for each such row."""
    instances = [system.constraints[index] for index in part.instances]
    residuals = Residuals.of(system, instances)
    rows = [
        (first + row, instance.joint)
        for index, instance, first in zip(part.instances, instances, residuals.first, strict=False)
        for row in range(residuals.count(instance))
        if (index, row) not in solved
    ]
    if len(rows) > MOST_OUT_OF_PLANE_ROWS:
        yield from (joint for _, joint in rows)
        return
    for r, p in positions:
        _, jacobian = residuals.doubles(r, p)
        matrix = jacobian[np.ix_([row for row, _ in rows], out)]
        sizes = np.abs(factorise(matrix).dependences()).max(axis=0, initial=0.0).tolist()
        yield from (joint for (_, joint), x in zip(rows, sizes, strict=True) if x > TAKES_PART)


def _positions(program: Program) -> Iterator[tuple[Array, Array]]:
    """Positions r, p of all bodies, the ground last, at the start and near it on the branch."""
    work, stream = ProgramInterpreter(program), Sha256Random("near the start")
    yield _position(work)
    work["q"] = [x + AWAY * stream.sign() * stream.magnitude() for x in work["q"]]
    for _ in range(CORRECTIONS):
        try:
            work.run("geometry", "position", "move")
        except ZeroDivisionError:  # a pivot is exactly zero: the start is all that can be had
            return
        work["q"] = work["q_moved"]
    yield _position(work)


def _position(work: ProgramInterpreter) -> tuple[Array, Array]:
    bodies = work.program.bodies
    r = [_numbers(work, body.r) for body in bodies]
    p = [_numbers(work, body.p) for body in bodies]
    return np.array([*r, [0.0] * 3]), np.array([*p, [1.0, 0.0, 0.0, 0.0]])


def _numbers(work: ProgramInterpreter, coordinates: Sequence[CoordinatePlace]) -> list[float]:
    return [work.values[c.slot] if c.slot >= 0 else c.value for c in coordinates]
