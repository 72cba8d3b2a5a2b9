"""The angle about an axis that two bodies share, from two outputs of n1: its cosine and its sine.

θ = atan2(s, c) has the degree 0 in the Euler parameters, so that their norm does not matter. Where
the zero direction of j lies along the axis, c = s = 0, there is no angle; its Jacobian is then
zero.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import sympy
from sympy.matrices.expressions import Identity, MatrixSymbol

from kousoku.model.quantity import Quantity
from kousoku.symbolic.bodies import COMPONENTS, DELTA, SYMBOLS, A
from kousoku.symbolic.components import dot, rotate
from kousoku.symbolic.constraint import derive_constraint
from kousoku.symbolic.derivation import Step
from kousoku.symbolic.forms import Closed, Constraint, blocks_of, less_products, name_blocks
from kousoku.symbolic.matrices import (
    Divisor,
    Dot,
    Named,
    NamedScalar,
    add,
    elements,
    mul,
    neg,
    skew,
    symbol,
    transpose,
)
from kousoku.symbolic.pairs import AXES, relative_turning, turned
from kousoku.symbolic.variation import orthogonality, replaced

if TYPE_CHECKING:
    from kousoku.symbolic.derivation import Derivation

THIRD = Quantity("b_i_b", (3,), "-", "direction in body i across axis and a_i, frame of i")
#: The zero direction of j seen from the frame of i.
Y = Named("y", mul(transpose(A["i"]), A["j"], SYMBOLS["a_j_b"]))
#: Cosine and sine of the angle, times the lengths of the vectors.
COSINE = NamedScalar("c", Dot(SYMBOLS["a_i_b"], Y))
SINE = NamedScalar("s", Dot(symbol(THIRD), Y))
SQUARE = Divisor(COSINE**2 + SINE**2)


#: The axis, times the lengths of a_i and b_i.
AXIS = Named("n", mul(skew(SYMBOLS["a_i_b"]), symbol(THIRD)))
#: Their n1 with a_j has the Jacobians of θ and of ρ = ln √(c² + s²), frame of i.
ACROSS = Named("h", mul(1 / SQUARE, skew(AXIS), Y))
ALONG = Named("g", add(mul(COSINE / SQUARE, SYMBOLS["a_i_b"]), mul(SINE / SQUARE, symbol(THIRD))))


def derive(_: str) -> Derivation:
    """Return the derivation of ``angle``."""
    return derive_constraint(_angle())


def _closed() -> Closed:
    """Return θ_q and θ_qq: with u = c + i s, ln u = ρ + i θ and (ln u)_qq = u_qq/u − (u_q/u)²."""
    fixed = MatrixSymbol("h", 3, 1)
    value = mul(transpose(fixed), transpose(A["i"]), A["j"], SYMBOLS["a_j_b"])
    row = blocks_of(DELTA(value), orthogonality, (Y,))
    second = [blocks_of(DELTA(transpose(block)), orthogonality, (Y,)) for block in row]
    own, other = (
        name_blocks(letter, [replaced(block, fixed, vector) for block in row])
        for letter, vector in (("C", ACROSS), ("G", ALONG))
    )
    kept = [[replaced(block, fixed, ACROSS) for block in line] for line in second]
    return Closed(
        own,
        less_products(kept, (own, other), (other, own)),
        (
            "the Jacobian of n1 for h and a_j",
            "δh = −g δθ − h δρ, ρ = ln √(c² + s²): that of n1 for h, less products of rows",
        ),
    )


def _gamma() -> Step:
    """Return γ = Ω·(h × w_j − a_j × w_h) + 2 θ̇ ρ̇, θ̇ = Ω·(a_j × h) and ρ̇ = Ω·(a_j × g).

    h and g are seen in frame O, w = A ω̃′a′. All of it is small where the bodies turn together.
    """
    omega = relative_turning()
    h, g = (Named(f"{x.name}_i", mul(A["i"], x)) for x in (ACROSS, ALONG))
    w = {
        body: Named(f"w_{body}", turned(body, vector))
        for body, vector in (("i", ACROSS), ("j", SYMBOLS["a_j_b"]))
    }
    arm = add(mul(skew(h), w["j"]), neg(mul(skew(AXES["j"]), w["i"])))
    theta_dot, rho_dot = (
        Named(name, mul(transpose(omega), skew(AXES["j"]), vector))
        for name, vector in (("theta_dot", h), ("rho_dot", g))
    )
    gamma = add(mul(transpose(omega), arm), mul(2, theta_dot, rho_dot))
    rule = "γ of n1 for h and a_j, and dh/dt"
    return Step(MatrixSymbol("gamma", 1, 1), gamma, rule, "7.15")


def _angle() -> Constraint:
    x = COMPONENTS
    left = MatrixSymbol("C", 1, 1)
    far = rotate(x["p_j"], x["a_j_b"])
    cosine, sine = (dot(rotate(x["p_i"], v), far) for v in (x["a_i_b"], elements(THIRD)))
    first = sympy.atan2(Dot(mul(A["i"], symbol(THIRD)), AXES["j"]), Dot(AXES["i"], AXES["j"]))
    value = mul(sympy.atan2(SINE, COSINE), Identity(1))
    return Constraint(
        name="angle",
        kind="angle",
        title="angle, angle about an axis common to two bodies",
        source="lecture 8.2, (8.9)",
        formula="C = atan2(b′_i^T y, a′_i^T y), y = A_i^T A_j a′_j",
        unit="rad",
        steps=(
            Step(left, mul(first, Identity(1)), "from the cosine and the sine, both n1", "8.9"),
            Step(MatrixSymbol("y", 3, 1), Y.value, "abbreviation: a_j seen from i", ""),
            Step(COSINE, COSINE.value, "a = A a′ in each body", "8.9"),
            Step(SINE, SINE.value, "a = A a′ in each body", "8.9"),
            Step(left, value, "the angle of the vector (c, s)", ""),
        ),
        value=value,
        components=(sympy.atan2(sine, cosine),),
        names=(Y,),
        gamma=_gamma(),
        inputs=(THIRD,),
        closed=_closed(),
    )
