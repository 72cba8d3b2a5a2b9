"""Operations that forces share: M⁻¹f of a body, a force at a point, columns of nodes."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.operations.mechanics import frozen
from kousoku.codegen.dynamics.recording.matrix import Matrix
from kousoku.model.expressions.formulas import LAW_NAMES

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.codegen.dynamics.recording.traces import Trace

#: Names that the law of a spring depends on first: elongation and its rate.
ELONGATION = LAW_NAMES[:2]


def column_of(trace: Trace, *nodes: int) -> Matrix:
    """Column (n, 1) of n nodes."""
    return Matrix.of(trace.graph, nodes)


def at_point(trace: Trace, p: Sequence[int], point: Matrix, force: Matrix) -> tuple[int, ...]:
    """Force in frame O, and its torque s̃′ A(p)ᵀ F: three mass points, (torque-definition).

    Parameters
    ----------
    trace : Trace
        Its graph takes the nodes.
    p : (4,) nodes [-]
        Euler parameters of the principal frame, of norm one.
    point : (3,) Matrix [m]
        Point of application, from the centre of mass, in the principal frame.
    force : (3,) Matrix [N]
        In frame O.

    Returns
    -------
    tuple of int
        Force (3,) [N] in frame O; torque (3,) [N m] about the centre of mass, in the principal
        frame.
    """
    zeros = (trace.graph.const(0),) * 6
    inputs = {"p": p, "s_b": (*point.flat, *zeros), "f": (*force.flat, *zeros)}
    resultant = trace.inline(frozen("mass_points", "resultant"), inputs)
    return (*resultant["F"], *resultant["N_b"])


def accelerations(
    trace: Trace, forces: Sequence[int], columns: Sequence[int], inverse_mass: Matrix
) -> Matrix:
    """Share M⁻¹f (c, 1) [m/s², rad/s²] of force and torque f = (F, N′) in a body's accelerations.

    Parameters
    ----------
    trace : Trace
        Its graph takes the nodes.
    forces : (6,) nodes [N, N m]
        Force in frame O, torque in the principal frame.
    columns : sequence of int
        Its coordinates.
    inverse_mass : Matrix (1, c) [1/kg, 1/(kg m²)]
        The diagonal of M⁻¹ of these.
    """
    mul = trace.graph.mul
    pairs = zip(columns, inverse_mass.flat, strict=True)
    return column_of(trace, *(mul(forces[k], inverse) for k, inverse in pairs))
