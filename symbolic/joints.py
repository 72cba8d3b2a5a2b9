"""The constraints that every joint needs beside those of lecture 8.2: point, distance, norm."""

from __future__ import annotations

from typing import Any

from sympy import Integer, Rational, S
from sympy.matrices.expressions import Identity, MatrixSymbol

from kousoku.symbolic.bodies import BODIES, COMPONENTS, SYMBOLS, A
from kousoku.symbolic.components import dot, plus, rotate, subtract
from kousoku.symbolic.constraint import derive_constraint
from kousoku.symbolic.derivation import Derivation, Step
from kousoku.symbolic.forms import Constraint
from kousoku.symbolic.matrices import (
    Matrix,
    Named,
    add,
    coefficient_and_factors,
    mul,
    neg,
    skew,
    transpose,
)
from kousoku.symbolic.norm import derive_norm
from kousoku.symbolic.pairs import FROM_CENTRE, TO_POINT, D

#: d without the point on the body itself: from the origin of i, and to the origin of j.
FROM_OWN_ORIGIN = {
    "i": Named("d_i", TO_POINT),
    "j": Named("d_j", add(SYMBOLS["r_j"], neg(SYMBOLS["r_i"]), FROM_CENTRE)),
}


def derive(package: str) -> Derivation:
    """Return the derivation of ``point``, ``distance`` or ``norm``."""
    if package == "norm":
        return derive_norm()
    return derive_constraint(_point() if package == "point" else _distance())


def _d_components() -> list[Any]:
    x = COMPONENTS
    ends = [plus(x[f"r_{body}"], rotate(x[f"p_{body}"], x[f"s_{body}_b"])) for body in "ij"]
    return subtract(ends[1], ends[0])


def _point() -> Constraint:
    left = MatrixSymbol("C", 3, 1)
    return Constraint(
        name="point",
        kind="point",
        title="point, two points coincident (SPHERICAL)",
        source="lecture 8.2, (8.8)",
        formula="C = d = r_j + A_j s′_j − r_i − A_i s′_i",
        unit="m",
        steps=(
            Step(left, D, "the vector between the points vanishes", "8.7"),
            Step(left, D.value, "in frame O", "8.8"),
        ),
        value=D.value,
        components=tuple(_d_components()),
    )


def _own_point_drops(x: Matrix) -> Matrix | None:
    """Apply dᵀA s̃′ = (d ∓ A s′)ᵀA s̃′: the own point drops out, as (A s′)ᵀA s̃′ = (p·p)² s′ᵀs̃′ = 0.

    Without it the product would hold a part that cancels, and with it digits, where the point is
    far from its origin.
    """
    scalar, factors = coefficient_and_factors(x)
    for k in range(len(factors) - 2):
        for body, own in FROM_OWN_ORIGIN.items():
            if factors[k : k + 3] == (transpose(D), A[body], skew(SYMBOLS[f"s_{body}_b"])):
                return mul(scalar, *factors[:k], transpose(own), *factors[k + 1 :])
    return None


def _distance_gamma() -> Matrix:
    """Return −γ length = v·(v + 2 (w_j − w_i)) − 2 w_i·w_j + d_j·u_j − d_i·u_i, divided.

    v is the relative velocity of the origins, w = A ω̃′s′ and u = A ω̃′ω̃′s′ for each body.
    """
    spin = {body: skew(SYMBOLS[f"omega_{body}_b"]) for body in BODIES}
    w, u = (
        {
            body: Named(
                f"{name}_{body}", mul(A[body], *[spin[body]] * times, SYMBOLS[f"s_{body}_b"])
            )
            for body in BODIES
        }
        for times, name in ((1, "w"), (2, "u"))
    )
    v = Named("v", add(SYMBOLS["v_j"], neg(SYMBOLS["v_i"])))
    total = add(
        mul(transpose(v), add(v, mul(Integer(2), w["j"]), mul(Integer(-2), w["i"]))),
        mul(Integer(-2), transpose(w["i"]), w["j"]),
        mul(transpose(FROM_OWN_ORIGIN["j"]), u["j"]),
        neg(mul(transpose(FROM_OWN_ORIGIN["i"]), u["i"])),
    )
    return mul(S.NegativeOne / SYMBOLS["length"], total)


def _distance() -> Constraint:
    length = SYMBOLS["length"]
    square = mul(length**2, Identity(1))
    value = mul(Rational(1, 2) / length, add(mul(transpose(D), D), neg(square)))
    left = MatrixSymbol("C", 1, 1)
    d = _d_components()
    return Constraint(
        name="distance",
        kind="distance",
        title="distance, two points at a given distance",
        source="lecture 8.2, (8.8)",
        formula="C = (d·d − length²) / (2 length), d = r_j + A_j s′_j − r_i − A_i s′_i",
        unit="m",
        steps=(
            Step(MatrixSymbol("d", 3, 1), D.value, "vector between the points", "8.8"),
            Step(left, value, "the squares agree; divided by 2 length, so that C is a length", ""),
        ),
        value=value,
        components=((dot(d, d) - length**2) / (2 * length),),
        names=(D,),
        rule=_own_point_drops,
        gamma=_distance_gamma(),
    )
