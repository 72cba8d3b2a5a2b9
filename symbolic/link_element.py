"""The matrix level of the planar link element: its vectors, and ε, D and Ḋ in terms of them."""

from __future__ import annotations

import sympy
from sympy import Symbol
from sympy.matrices.expressions import BlockMatrix, MatrixSymbol
from sympy.matrices.immutable import ImmutableDenseMatrix

from kousoku.model.quantity import Quantity
from kousoku.symbolic.matrices import (
    Dot,
    Matrix,
    Named,
    NamedScalar,
    add,
    mul,
    neg,
    symbol,
    transpose,
)
from kousoku.symbolic.variation import coefficient

X = Quantity("x", (6,), "m, rad", "x1 y1 β1 x2 y2 β2 of the ends, frame O, (2)")
X_DOT = Quantity("x_dot", (6,), "m/s, rad/s", "derivative of x along the motion")
LENGTH = Quantity("length", (), "m", "design length l0, (8)")
OFFSET = Quantity("offset", (2,), "rad", "angles of β1 and β2 from the link at design")
DELTA_X = MatrixSymbol("δx", 6, 1)
ENDS = ImmutableDenseMatrix([[-1, 0, 0, 1, 0, 0], [0, -1, 0, 0, 1, 0]])
QUARTER_TURN = ImmutableDenseMatrix([[0, -1], [1, 0]])
FIRST_ANGLE = ImmutableDenseMatrix([[0, 0, 1, 0, 0, 0]])
SECOND_ANGLE = ImmutableDenseMatrix([[0, 0, 0, 0, 0, 1]])

L0 = Symbol("length")
#: From end 1 to end 2; its length l; the unit vectors along and across the link.
D = Named("d", mul(Named("N", ENDS), symbol(X)))
L = NamedScalar("l", sympy.sqrt(Dot(D, D)))
ALONG = Named("n", mul(1 / L, D))
ACROSS = Named("t", mul(Named("J", QUARTER_TURN), ALONG))
D_RATE = Named("d_dot", mul(Named("N", ENDS), symbol(X_DOT)))
L_RATE = NamedScalar("l_dot", Dot(ALONG, D_RATE))
BETA_RATE = NamedScalar("beta_dot", Dot(ACROSS, D_RATE) / L)


def variations() -> tuple[Matrix, Matrix, Matrix]:
    """Return δε1, δε2, δε3: δl = nᵀδd and l δβ = tᵀδd."""
    delta_d = mul(Named("N", ENDS), DELTA_X)
    angle = mul(L0 / L, transpose(ACROSS), delta_d)
    first, second = (
        mul(L0, Named(f"b{k}", row), DELTA_X) for k, row in ((1, FIRST_ANGLE), (2, SECOND_ANGLE))
    )
    return mul(transpose(ALONG), delta_d), add(first, neg(angle)), add(angle, neg(second))


def jacobian() -> Matrix:
    """Return D = ∂ε/∂x, by collecting δx."""
    return BlockMatrix([[coefficient(row, DELTA_X)] for row in variations()])


def jacobian_rate() -> Matrix:
    """Return Ḋ with ṅ = β̇ t, ṫ = −β̇ n, l̇ = nᵀḋ, l β̇ = tᵀḋ."""
    ends = Named("N", ENDS)
    turned = add(mul(BETA_RATE, transpose(ALONG)), mul(L_RATE / L, transpose(ACROSS)))
    row = mul(L0 / L, turned, ends)
    return BlockMatrix([[mul(BETA_RATE, transpose(ACROSS), ends)], [row], [neg(row)]])
