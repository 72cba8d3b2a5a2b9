"""The matrix level of the planar link element: its vectors, and ε, D and Ḋ in terms of them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import sympy
from sympy import Symbol
from sympy.matrices.expressions import BlockMatrix, MatrixSymbol
from sympy.matrices.immutable import ImmutableDenseMatrix

from kousoku.model.files.quantity import Quantity
from kousoku.symbolic.matrices import (
    Dot,
    NamedMatrix,
    NamedScalar,
    add,
    mul,
    neg,
    symbol,
    transpose,
)
from kousoku.symbolic.sympy_types import as_matrix
from kousoku.symbolic.variation import coefficient

if TYPE_CHECKING:
    from kousoku.symbolic.sympy_types import SymbolicMatrix

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
D = NamedMatrix("d", mul(NamedMatrix("N", ENDS), symbol(X)))
L = NamedScalar("l", sympy.sqrt(Dot(D, D)))
ALONG = NamedMatrix("n", mul(1 / L, D))
ACROSS = NamedMatrix("t", mul(NamedMatrix("J", QUARTER_TURN), ALONG))
D_RATE = NamedMatrix("d_dot", mul(NamedMatrix("N", ENDS), symbol(X_DOT)))
L_RATE = NamedScalar("l_dot", Dot(ALONG, D_RATE))
BETA_RATE = NamedScalar("beta_dot", Dot(ACROSS, D_RATE) / L)


def variations() -> tuple[SymbolicMatrix, SymbolicMatrix, SymbolicMatrix]:
    """Variations δε1, δε2, δε3 (1, 1) [m], (5) to (7): δl = nᵀδd and l δβ = tᵀδd.

    d (2,) [m] leads from end 1 to end 2, n along it and t a quarter turn on, in frame O.
    """
    delta_d = mul(NamedMatrix("N", ENDS), DELTA_X)
    angle = mul(L0 / L, transpose(ACROSS), delta_d)
    first, second = (
        mul(L0, NamedMatrix(f"b{k}", row), DELTA_X)
        for k, row in ((1, FIRST_ANGLE), (2, SECOND_ANGLE))
    )
    return mul(transpose(ALONG), delta_d), add(first, neg(angle)), add(angle, neg(second))


def jacobian() -> SymbolicMatrix:
    """Jacobian D (3, 6) = ∂ε/∂x [-, m/rad] of Yamada and Tatsumi (1981), by collecting δx.

    x (6,) [m, rad] are the ends in frame O, (2); at the reference, l = l0, it is (15).
    """
    return as_matrix(BlockMatrix([[coefficient(row, DELTA_X)] for row in variations()]))


def jacobian_rate() -> SymbolicMatrix:
    """Rate Ḋ (3, 6) [1/s, m/s/rad], frame O, with ṅ = β̇ t, ṫ = −β̇ n, l̇ = nᵀḋ, l β̇ = tᵀḋ."""
    ends = NamedMatrix("N", ENDS)
    turned = add(mul(BETA_RATE, transpose(ALONG)), mul(L_RATE / L, transpose(ACROSS)))
    row = mul(L0 / L, turned, ends)
    return as_matrix(BlockMatrix([[mul(BETA_RATE, transpose(ACROSS), ends)], [row], [neg(row)]]))
