"""The length of the line between two points: the coordinate that a rod keeps and a driver moves.

Where the points coincide, d = 0, the length is zero and the line has no direction: |d| has a kink
and no derivative. The Jacobian is then zero, and so is the reaction: a force along the length does
nothing at that moment, and a driver of it is refused there. The rate of points that pass through
each other jumps from −|ḋ| to |ḋ|, so that γ is minus infinity; it is zero where ḋ is. The
derivative of the reaction is not finite. Squares underflow where |d| is below 10⁻¹⁵⁴ m: no digit of
a shorter length is right.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import sympy
from sympy.matrices.expressions import Identity, MatrixSymbol

from kousoku.symbolic.bodies import DELTA, RATE
from kousoku.symbolic.components import dot
from kousoku.symbolic.constraint import derive_constraint
from kousoku.symbolic.derivation import Step
from kousoku.symbolic.forms import (
    Closed,
    Constraint,
    Plain,
    blocks_of,
    curvature,
    less_products,
    name_blocks,
    name_lines,
)
from kousoku.symbolic.joints import GAMMA_RULE, half_square_curvature, own_point_drops, point_offset
from kousoku.symbolic.matrices import Divisor, Matrix, Named, add, mul, neg, transpose
from kousoku.symbolic.pairs import D
from kousoku.symbolic.spring import L, half_square_rate

if TYPE_CHECKING:
    from kousoku.symbolic.derivation import Derivation

#: Rate of d, and its second without accelerations.
RATES = (Named("d_dot", RATE(D)), Named("d_ddot", curvature(D)))
#: One divided by l, and zero times it where l is zero.
INVERSE = 1 / Divisor(L)


def derive(_: str) -> Derivation:
    """Return the derivation of ``length``."""
    return derive_constraint(_length())


def _gamma(rate: Matrix, curved: Matrix) -> Matrix:
    """Return γ = ((h/l)² − z)/l, h = d·ḋ and z what d·ḋ has as its rate without accelerations."""
    along = Named("x", mul(INVERSE, Named("h", rate)))
    return mul(INVERSE, add(mul(along, along), neg(Named("z", curved))))


def _lines() -> tuple[Step, ...]:
    rate = mul(transpose(D), RATES[0])
    curved = add(mul(transpose(RATES[0]), RATES[0]), mul(transpose(D), RATES[1]))
    h, z, gamma = (MatrixSymbol(name, 1, 1) for name in ("h", "z", "gamma"))
    return (
        Step(h, rate, "abbreviation: l dl/dt", ""),
        Step(h, half_square_rate(), "s·w = 0 in each body, and (x × y)·z = x·(y × z)", ""),
        Step(z, curved, "abbreviation: the rate of h without accelerations", ""),
        Step(z, half_square_curvature(), GAMMA_RULE, "7.15"),
        Step(gamma, _gamma(rate, curved), "d²l/dt² = (dh/dt − (dl/dt)²)/l", ""),
    )


def _closed() -> Closed:
    """Return l_q and l_qq = (½ d·d)_qq / l − l_qᵀl_q / l."""
    half_square = blocks_of(mul(transpose(D), DELTA(D)), own_point_drops)
    second = [blocks_of(DELTA(transpose(part)), own_point_drops) for part in half_square]
    row = name_blocks("C", [mul(INVERSE, block) for block in name_blocks("D", half_square)])
    lines = [[mul(INVERSE, block) for block in line] for line in name_lines("D", second)]
    less = less_products(lines, (row, [mul(INVERSE, block) for block in row]))
    rules = ("the own point drops out", "δ(d/l) = δd/l − d δl/l²")
    gamma = _gamma(half_square_rate(), half_square_curvature())
    return Closed(row, name_lines("K", less), rules, Plain(row, less, gamma), _lines())


def _length() -> Constraint:
    left = MatrixSymbol("C", 1, 1)
    d = point_offset()
    value, closed = mul(L, Identity(1)), _closed()
    return Constraint(
        name="length",
        kind="length",
        title="length, distance of two points",
        source="lecture 8.2, (8.8)",
        formula="C = |d|, d = r_j + A_j s′_j − r_i − A_i s′_i; where d = 0 the Jacobian is 0",
        unit="m",
        steps=(
            Step(MatrixSymbol("d", 3, 1), D.value, "vector between the points", "8.8"),
            Step(left, value, "its length", ""),
        ),
        value=value,
        components=(sympy.sqrt(dot(d, d)),),
        names=(D, *RATES),
        rule=own_point_drops,
        gamma=Step(MatrixSymbol("gamma", 1, 1), closed.plain.gamma, "h and z as above", ""),
        closed=closed,
    )
