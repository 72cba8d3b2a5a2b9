"""The length of the line between two points: the coordinate that a rod keeps and a driver moves.

Where the points coincide the line has no direction; its Jacobian is then zero.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import sympy
from sympy.matrices.expressions import Identity, MatrixSymbol

from kousoku.symbolic.bodies import DELTA
from kousoku.symbolic.components import dot
from kousoku.symbolic.constraint import derive_constraint
from kousoku.symbolic.derivation import Step
from kousoku.symbolic.forms import (
    Closed,
    Constraint,
    Plain,
    blocks_of,
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

#: One divided by l, and zero times it where l is zero.
INVERSE = 1 / Divisor(L)


def derive(_: str) -> Derivation:
    """Return the derivation of ``length``."""
    return derive_constraint(_length())


def _gamma() -> Matrix:
    """Return γ = ((d·ḋ/l)² − z)/l, −z that of ½ d·d: each in a form where no digits cancel."""
    rate = Named("x", mul(INVERSE, Named("u", half_square_rate())))
    return mul(INVERSE, add(mul(rate, rate), neg(Named("z", half_square_curvature()))))


def _closed() -> Closed:
    """Return l_q and l_qq = (½ d·d)_qq / l − l_qᵀl_q / l."""
    half_square = blocks_of(mul(transpose(D), DELTA(D)), own_point_drops)
    second = [blocks_of(DELTA(transpose(part)), own_point_drops) for part in half_square]
    row = name_blocks("C", [mul(INVERSE, block) for block in name_blocks("D", half_square)])
    lines = [[mul(INVERSE, block) for block in line] for line in name_lines("D", second)]
    less = less_products(lines, (row, [mul(INVERSE, block) for block in row]))
    rules = ("the own point drops out", "δ(d/l) = δd/l − d δl/l²")
    return Closed(row, name_lines("K", less), rules, Plain(row, less, _gamma()))


def _length() -> Constraint:
    left = MatrixSymbol("C", 1, 1)
    d = point_offset()
    value = mul(L, Identity(1))
    return Constraint(
        name="length",
        kind="length",
        title="length, distance of two points",
        source="lecture 8.2, (8.8)",
        formula="C = |d|, d = r_j + A_j s′_j − r_i − A_i s′_i",
        unit="m",
        steps=(
            Step(MatrixSymbol("d", 3, 1), D.value, "vector between the points", "8.8"),
            Step(left, value, "its length", ""),
        ),
        value=value,
        components=(sympy.sqrt(dot(d, d)),),
        names=(D,),
        rule=own_point_drops,
        gamma=Step(MatrixSymbol("gamma", 1, 1), _gamma(), GAMMA_RULE, "7.15"),
        closed=_closed(),
    )
