"""The mass that moves with the coordinates of a joint with the ground: Rᵀ M R, exactly.

It does not change with the position, since R turns with the body: of a turn about an axis it is
m |s′ × a′|² + a′ᵀ I′ a′, of turns about a point m s̃′ᵀ s̃′ + I′, of a displacement m.
"""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.operations.joint_projections import NOTHING, POINT
from kousoku.codegen.dynamics.simplification.ground_joints import AXIS_TOLERANCE

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.codegen.dynamics.simplification.ground_joints import VelocityTransformation
    from kousoku.model.mechanics.multibody import MovingBody

    Square = list[list[Fraction]]


def axes_of(joint: VelocityTransformation) -> Square:
    """Axes a′ (k, 3) [-] of k rotations of a body, ω′ = Σ a′ u, in its frame, row by row."""
    if joint.rotates_about == POINT:
        return [[Fraction(int(k == n)) for n in range(3)] for k in range(3)]
    return [] if joint.rotates_about == NOTHING else [[Fraction(x) for x in joint.axis_b]]


def arms_of(joint: VelocityTransformation) -> Square:
    """Arms s′ × a′ (3, k) [m] of these axes, body frame: the mass centre moves along them."""
    x, y, z = (Fraction(value) for value in joint.joint_b)
    arms = [(y * c - z * b, z * a - x * c, x * b - y * a) for a, b, c in axes_of(joint)]
    return [[arm[k] for arm in arms] for k in range(3)]


def reduced_mass_matrix(joint: VelocityTransformation, body: MovingBody) -> Square:
    """Mass matrix Rᵀ M R (f, f) of all freedoms, rotations first, driven ones included.

    (s′ × a′)·m (s′ × b′) + a′·I′b′ [kg m²] of turns about a′ and b′, m [kg] of a displacement, body
    frame.
    """
    mass, moments = Fraction(body.mass), [Fraction(x) for x in body.inertia]
    axes = axes_of(joint)
    arms = transposed(arms_of(joint)) if axes else []
    masses = [
        [
            mass * _dot(arm, other_arm)
            + _dot([x * m for x, m in zip(axis, moments, strict=True)], other_axis)
            for other_arm, other_axis in zip(arms, axes, strict=True)
        ]
        for arm, axis in zip(arms, axes, strict=True)
    ]
    if joint.slides:  # across all arms
        masses = [[*row, Fraction(0)] for row in masses]
        masses.append([Fraction(0)] * joint.rotations + [mass])
    return masses


def shares_of(joint: VelocityTransformation, body: MovingBody) -> tuple[Square, Square]:
    """Shares (Rᵀ M R)⁻¹ m and (Rᵀ M R)⁻¹ a′ᵀ I′ of k rotations, (k, k) and (k, 3).

    Units are 1/m² and [-]; a′ and I′ are in the body frame.
    """
    rotations, masses = range(joint.rotations), reduced_mass_matrix(joint, body)
    inverse = inverse_of([[masses[a][b] for b in rotations] for a in rotations])
    mass, moments = Fraction(body.mass), [Fraction(x) for x in body.inertia]
    spins = [[x * m for x, m in zip(axis, moments, strict=True)] for axis in axes_of(joint)]
    return [[mass * x for x in row] for row in inverse], [
        [_dot(row, column) for column in transposed(spins)] for row in inverse
    ]


def is_principal(joint: VelocityTransformation, body: MovingBody) -> bool:
    """Whether the axis that a body turns about is a principal one, to rounding."""
    x, y, z = (Fraction(x) for x in joint.axis_b)
    a, b, c = (Fraction(value) for value in body.inertia)
    off_axis = (y * z * (c - b), z * x * (a - c), x * y * (b - a))  # a′ × I′a′
    return all(abs(value) <= AXIS_TOLERANCE * max(a, b, c) for value in off_axis)


def transposed(rows: Sequence[Sequence[Fraction]]) -> Square:
    """Columns as rows; there is one row at least, or none at all."""
    return [list(column) for column in zip(*rows, strict=True)]


def inverse_of(matrix: Square) -> Square:
    """Inverse (n, n) of a symmetric positive definite matrix, by elimination."""
    size = len(matrix)
    rows = [[*row, *(Fraction(int(k == n)) for n in range(size))] for k, row in enumerate(matrix)]
    for k in range(size):
        rows[k] = [x / rows[k][k] for x in rows[k]]
        for n in range(size):
            if n != k:
                factor = rows[n][k]
                rows[n] = [x - factor * y for x, y in zip(rows[n], rows[k], strict=True)]
    return [row[size:] for row in rows]


def _dot(a: Sequence[Fraction], b: Sequence[Fraction]) -> Fraction:
    return sum((x * y for x, y in zip(a, b, strict=True)), Fraction(0))
