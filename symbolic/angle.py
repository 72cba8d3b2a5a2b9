"""The angle about an axis that two bodies share, from two outputs of n1: its cosine and its sine.

θ = atan2(s, c) has the degree 0 in the Euler parameters, so that their norm does not matter. Where
the zero direction of j lies along the axis, c = s = 0, there is no angle; its Jacobian is then
zero.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import sympy
from sympy.matrices.expressions import Identity, MatrixSymbol

from kousoku.model.files.quantity import Quantity
from kousoku.symbolic.bodies import BODIES, COMPONENTS, DELTA, RATE, SYMBOLS, A
from kousoku.symbolic.components import dot, rotate
from kousoku.symbolic.constraint import derive_constraint
from kousoku.symbolic.derivation import Step
from kousoku.symbolic.forms import (
    ClosedForm,
    Constraint,
    Plain,
    blocks_of,
    curvature,
    less_products,
    name_blocks,
    name_lines,
)
from kousoku.symbolic.matrices import (
    Divisor,
    Dot,
    NamedMatrix,
    NamedScalar,
    add,
    elements,
    mul,
    neg,
    skew,
    symbol,
    transpose,
)
from kousoku.symbolic.pairs import AXES, n1_gamma, turning_seen_from
from kousoku.symbolic.variation import abbreviate, orthogonality, replaced

if TYPE_CHECKING:
    from kousoku.symbolic.derivation import Derivation
    from kousoku.symbolic.sympy_types import SymbolicMatrix

THIRD = Quantity("b_i_b", (3,), "-", "direction in body i across axis and a_i, frame of i")
#: The zero direction of j seen from the frame of i.
Y = NamedMatrix("y", mul(transpose(A["i"]), A["j"], SYMBOLS["a_j_b"]))
#: Its rate, and its second rate without accelerations.
Y_DOT = NamedMatrix("y_dot", abbreviate(RATE(Y), Y))
Y_DDOT = NamedMatrix("y_ddot", abbreviate(curvature(Y), Y))
#: Cosine and sine of the angle, times the lengths of the vectors.
COSINE = NamedScalar("c", Dot(SYMBOLS["a_i_b"], Y))
SINE = NamedScalar("s", Dot(symbol(THIRD), Y))
SQUARE = Divisor(COSINE**2 + SINE**2)
#: One, and zero where there is no angle.
APART = NamedScalar("apart", (COSINE**2 + SINE**2) / SQUARE)

#: The axis, times the lengths of a_i and b_i.
AXIS = NamedMatrix("n", mul(skew(SYMBOLS["a_i_b"]), symbol(THIRD)))
#: Their n1 with a_j has the Jacobians of θ and of ρ = ln √(c² + s²), frame of i.
ACROSS = NamedMatrix("h", mul(1 / SQUARE, NamedMatrix("m", mul(skew(AXIS), Y))))
ALONG = NamedMatrix(
    "g", add(mul(COSINE / SQUARE, SYMBOLS["a_i_b"]), mul(SINE / SQUARE, symbol(THIRD)))
)

#: Rates and γ of the cosine and the sine.
RATES = ("c_dot", "s_dot", "gamma_c", "gamma_s")


def derive(_: str) -> Derivation:
    """Derivation of ``angle``: θ = atan2(s, c) (1,) [rad], two outputs of n1, lecture 8.2, (8.9).

    c = a_i·a_j and s = b_i·a_j [-]; a_i and b_i (3,) are vectors of body i, across the axis, a_j
    one of body j, all in frame O.
    """
    return derive_constraint(_angle())


def _row(vector: SymbolicMatrix) -> tuple[SymbolicMatrix, ...]:
    """Jacobian of n1 for a fixed vector of body i, frame of i, and a_j."""
    return blocks_of(DELTA(_n1(vector)), orthogonality, (Y,))


def _second(vector: SymbolicMatrix) -> list[tuple[SymbolicMatrix, ...]]:
    """Variations of the transposed blocks of this Jacobian."""
    return [blocks_of(DELTA(transpose(block)), orthogonality, (Y,)) for block in _row(vector)]


def _n1(vector: SymbolicMatrix) -> SymbolicMatrix:
    return mul(transpose(vector), transpose(A["i"]), A["j"], SYMBOLS["a_j_b"])


def _closed() -> ClosedForm:
    """Slopes θ_q and θ_qq: with u = c + i s, ln u = ρ + i θ and (ln u)_qq = u_qq/u − (u_q/u)²."""
    fixed = MatrixSymbol("h", 3, 1)
    theta_q, rho_q = (
        name_blocks(letter, [replaced(block, fixed, vector) for block in _row(fixed)])
        for letter, vector in (("C", ACROSS), ("G", ALONG))
    )
    # Seen from j, so that nothing is lost of what stands along the axes of j.
    squares = [Dot(SYMBOLS[f"p_{body}"], SYMBOLS[f"p_{body}"]) for body in BODIES]
    axis_from_j = NamedMatrix("n_j", mul(transpose(A["j"]), A["i"], AXIS))
    across = NamedMatrix("m_j", mul(skew(axis_from_j), SYMBOLS["a_j_b"]))
    inverse = APART * squares[0] * squares[1] / SQUARE
    turn = mul(inverse, NamedMatrix("o_j", mul(skew(SYMBOLS["a_j_b"]), across)))
    assert isinstance(theta_q[3], NamedMatrix)
    row = (*theta_q[:3], NamedMatrix(theta_q[3].name, transpose(turn)))
    n1_second = [[replaced(block, fixed, ACROSS) for block in line] for line in _second(fixed)]
    return ClosedForm(
        row,
        name_lines("K", less_products(n1_second, (theta_q, rho_q), (rho_q, theta_q))),
        (
            "the Jacobian of n1 for h and a_j",
            "δh = −g δθ − h δρ, ρ = ln √(c² + s²): that of n1 for h, less products of rows",
        ),
        _plain(),
        _lines(),
    )


def _n1_rate(vector: SymbolicMatrix) -> SymbolicMatrix:
    """Rate Ω·(y × a), the rate of n1 for a vector a of body i and a_j, frame of i."""
    return mul(transpose(turning_seen_from("i").omega), skew(Y), vector)


def _gamma() -> Step:
    """Step of γ, that of n1 for h and a_j and 2 θ̇ ρ̇: small where the bodies turn together."""
    theta_dot, rho_dot = (
        NamedMatrix("theta_dot", _n1_rate(ACROSS)),
        NamedMatrix("rho_dot", _n1_rate(ALONG)),
    )
    gamma = add(n1_gamma(ACROSS, "i"), mul(2, theta_dot, rho_dot))
    rule = "that of n1 for h and a_j, and dh/dt = −g dθ/dt − h dρ/dt"
    return Step(MatrixSymbol("gamma", 1, 1), gamma, rule, "7.15")


def _plain() -> Plain:
    """Derivatives of atan2(s, c) by the chain rule, in c and s, their rows, rates and γ."""
    first, second = SYMBOLS["a_i_b"], symbol(THIRD)
    c_q, s_q = name_blocks("c", _row(first)), name_blocks("s", _row(second))
    lines = zip(name_lines("c", _second(first)), name_lines("s", _second(second)), strict=True)
    theta_q, rho_q = zip(*(_chain(c, s) for c, s in zip(c_q, s_q, strict=True)), strict=True)
    chained = [[_chain(c, s)[0] for c, s in zip(*line, strict=True)] for line in lines]
    rates, gammas = zip(*((_n1_rate(x), n1_gamma(x, "i")) for x in (first, second)), strict=True)
    gamma = _plain_gamma(*rates, *gammas)
    second = less_products(chained, (theta_q, rho_q), (rho_q, theta_q))
    return Plain(theta_q, second, gamma)


def _chain(of_c: SymbolicMatrix, of_s: SymbolicMatrix) -> tuple[SymbolicMatrix, SymbolicMatrix]:
    """Derivatives of θ and of ρ from those of c and s."""
    by_c, by_s = SINE / SQUARE, COSINE / SQUARE
    return add(mul(by_s, of_s), mul(-by_c, of_c)), add(mul(by_s, of_c), mul(by_c, of_s))


def _plain_gamma(*forms: SymbolicMatrix) -> SymbolicMatrix:
    """Components of γ from the rates of c and s, and from their γ."""
    c_dot, s_dot, *gammas = map(NamedMatrix, RATES, forms)
    theta_dot, rho_dot = _chain(c_dot, s_dot)
    return add(_chain(*gammas)[0], mul(2, theta_dot, rho_dot))


def _lines() -> tuple[Step, ...]:
    vectors = (SYMBOLS["a_i_b"], symbol(THIRD))
    rates = [(mul(transpose(x), Y_DOT), _n1_rate(x)) for x in vectors]
    gammas = [(neg(mul(transpose(x), Y_DDOT)), n1_gamma(x, "i")) for x in vectors]
    pairs = [*rates, *gammas]
    steps = []
    for name, (left, relative) in zip(RATES, pairs, strict=True):
        letter = MatrixSymbol(name, 1, 1)
        steps += [
            Step(letter, left, "δ → d/dt: dA/dt = A ω′~", "5.16"),
            Step(letter, relative, "(7.15) for ω, and (x × y)·z = x·(y × z)", "7.15"),
        ]
    gamma = _plain_gamma(*(left for left, _ in pairs))
    rule = "γ of a function of c and s: γ_c and γ_s are theirs"
    return (*steps, Step(MatrixSymbol("gamma", 1, 1), gamma, rule, ""))


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
        names=(Y, Y_DOT, Y_DDOT),
        gamma=_gamma(),
        inputs=(THIRD,),
        closed=_closed(),
    )
