"""The constraints that every joint needs beside those of lecture 8.2: point, distance, norm."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from sympy import Integer, Rational, S
from sympy.matrices.expressions import Identity, MatrixSymbol

from kousoku.symbolic.bodies import BODIES, COMPONENTS, SYMBOLS, A
from kousoku.symbolic.components import dot, plus, rotate, subtract
from kousoku.symbolic.constraint import derive_constraint
from kousoku.symbolic.derivation import Derivation, Step
from kousoku.symbolic.forms import Constraint
from kousoku.symbolic.matrices import (
    Divisor,
    Dot,
    NamedMatrix,
    add,
    coefficient_and_factors,
    mul,
    neg,
    skew,
    transpose,
)
from kousoku.symbolic.norm import derive_norm
from kousoku.symbolic.pairs import FROM_CENTRE, TO_POINT, D

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from kousoku.symbolic.sympy_types import SymbolicMatrix

    Rule = Callable[[SymbolicMatrix], SymbolicMatrix | None]

#: Why the γ of a distance and of a length is equal to the result of the product rule.
GAMMA_RULE = "|ω′~ s′|² + s′·ω′~ ω′~ s′ = 0, (7.15) for ω, and (x × y)·z = x·(y × z)"


def derive(package: str) -> Derivation:
    """Derivation of ``point``, ``distance`` or ``norm``.

    With d = r_j + A_j s_j′ − r_i − A_i s_i′, frame O [m], lecture 8.2, (8.8): d = 0 (3,) [m] of a
    point, (d·d − l²)/(2 l) = 0 (1,) [m] of a distance; p·p − 1 = 0 (1,) [-] of the norm.
    """
    if package == "norm":
        return derive_norm()
    return derive_constraint(_point() if package == "point" else _distance())


def point_offset() -> list[Any]:
    """Vector d = r_j + A_j s_j′ − r_i − A_i s_i′ (3,) [m], frame O, on the component level.

    It leads from the point on i to the point on j; lecture 8.2, (8.8).
    """
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
            Step(MatrixSymbol("d", 3, 1), D.value, "vector between the points", "8.8"),
            Step(left, D, "it vanishes", "8.7"),
            Step(left, D.value, "d resolved", "8.8"),
        ),
        value=D.value,
        components=tuple(point_offset()),
    )


def own_point_drops(d: SymbolicMatrix, from_own_origin: Mapping[str, SymbolicMatrix]) -> Rule:
    """Row dᵀA s̃′ = (d ∓ A s′)ᵀA s̃′: the own point drops out, as (A s′)ᵀA s̃′ = (p·p)² s′ᵀs̃′ = 0.

    Without it the product would hold a part that cancels, and with it digits, where the point is
    far from its origin.

    Parameters
    ----------
    d : SymbolicMatrix (3, 1) [m]
        The vector between the points, frame O, lecture 8.2, (8.8).
    from_own_origin : mapping of str to SymbolicMatrix (3, 1) [m]
        For each body d without its own point, frame O: from the origin of i, to the origin of j.
    """

    def rule(x: SymbolicMatrix) -> SymbolicMatrix | None:
        scalar, factors = coefficient_and_factors(x)
        for k in range(len(factors) - 2):
            for body, arm in from_own_origin.items():
                if factors[k : k + 3] == (transpose(d), A[body], skew(SYMBOLS[f"s_{body}_b"])):
                    return mul(scalar, *factors[:k], transpose(arm), *factors[k + 1 :])
        return None

    return rule


def half_square_curvature() -> SymbolicMatrix:
    """Right-hand side −γ of ½ d·d [m²/s²], v·(v + 2 w) + r·u + Ω·(s_i × w_j − s_j × w_i), (1, 1).

    v and r belong to the origins, s = A s′, w = A ω̃′s′ and u = A ω̃′ω̃′s′ to the points, Ω to the
    orientations, in frame O as of :func:`parts_of_motion`; those without an index are of body j
    less those of body i. Each term is small where the bodies move together, and none holds the part
    that a point far from its own origin adds to ḋ·ḋ and takes from d·d̈, so that no digits cancel.
    """
    motion = relative_motion()
    v, w = motion["v"], motion["w"]
    return add(mul(transpose(v), add(v, mul(Integer(2), w))), turning_curvature())


def turning_curvature() -> SymbolicMatrix:
    """Curvature without v, r·u + Ω·(s_i × w_j − s_j × w_i) (1, 1) [m²/s²]: all that turning leaves.

    The vectors (3,) are in frame O, as of :func:`parts_of_motion`.
    """
    of_body, motion = {body: parts_of_motion(body) for body in BODIES}, relative_motion()
    s, w = ({body: parts[name] for body, parts in of_body.items()} for name in "sw")
    arm = add(mul(skew(s["i"]), w["j"]), neg(mul(skew(s["j"]), w["i"])))
    return add(
        mul(transpose(motion["r"]), motion["u"]),
        mul(transpose(motion["omega"]), arm),
    )


def parts_of_motion(body: str) -> dict[str, SymbolicMatrix]:
    """Vectors (3,) of a body, frame O: s [m], w [m/s], u [m/s²], ω [rad/s]; r, v of its origin.

    s = A s′, w = A ω̃′s′, u = A ω̃′ω̃′s′ and ω = A ω′/(p·p), for p of any norm.
    """
    p, s, spin = SYMBOLS[f"p_{body}"], SYMBOLS[f"s_{body}_b"], SYMBOLS[f"omega_{body}_b"]
    turned = mul(skew(spin), s)
    turning = NamedMatrix(f"Omega_{body}", mul(A[body], spin))
    return {
        "s": NamedMatrix(f"s_{body}", mul(A[body], s)),
        "w": NamedMatrix(f"w_{body}", mul(A[body], turned)),
        "u": NamedMatrix(f"u_{body}", mul(A[body], skew(spin), turned)),
        "omega": NamedMatrix(f"omega_{body}", mul(1 / Divisor(Dot(p, p)), turning)),
        "r": SYMBOLS[f"r_{body}"],
        "v": SYMBOLS[f"v_{body}"],
    }


def relative_motion() -> dict[str, SymbolicMatrix]:
    """Motion of body j less that of body i, in frame O: r_j − r_i (3,) [m] and so on.

    The parts and their units are those of :func:`parts_of_motion`.
    """
    i, j = (parts_of_motion(body) for body in BODIES)
    return {name: NamedMatrix(name, add(j[name], neg(i[name]))) for name in i}


def _distance() -> Constraint:
    length = SYMBOLS["length"]
    square = mul(length**2, Identity(1))
    value = mul(Rational(1, 2) / length, add(mul(transpose(D), D), neg(square)))
    left = MatrixSymbol("C", 1, 1)
    d = point_offset()
    gamma = mul(S.NegativeOne / length, half_square_curvature())
    from_own_origin = {
        "i": NamedMatrix("d_i", TO_POINT),
        "j": NamedMatrix("d_j", add(SYMBOLS["r_j"], neg(SYMBOLS["r_i"]), FROM_CENTRE)),
    }
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
        rule=own_point_drops(D, from_own_origin),
        gamma=Step(MatrixSymbol("gamma", 1, 1), gamma, GAMMA_RULE, "7.15"),
    )
