"""The constraints between two vectors of lecture 8.2: n1, n2, p1 and p2."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from sympy.matrices.expressions import MatrixSymbol
from sympy.matrices.immutable import ImmutableDenseMatrix

from kousoku.model.mechanics.parallel_rows import ROWS
from kousoku.symbolic.bodies import BODIES, COMPONENTS, SYMBOLS, A
from kousoku.symbolic.components import cross, plus, rotate, rotate_back, subtract
from kousoku.symbolic.components import dot as dot_product
from kousoku.symbolic.constraint import derive_constraint
from kousoku.symbolic.derivation import Step
from kousoku.symbolic.forms import Constraint
from kousoku.symbolic.matrices import Divisor, Dot, NamedMatrix, add, mul, neg, skew, transpose
from kousoku.symbolic.variation import orthogonality

if TYPE_CHECKING:
    from kousoku.symbolic.derivation import Derivation
    from kousoku.symbolic.sympy_types import SymbolicMatrix

#: A frame-O vector of each body, a = A a′.
AXES = {body: NamedMatrix(f"a_{body}", mul(A[body], SYMBOLS[f"a_{body}_b"])) for body in ("i", "j")}
TO_POINT = add(SYMBOLS["r_j"], mul(A["j"], SYMBOLS["s_j_b"]), neg(SYMBOLS["r_i"]))
FROM_CENTRE = neg(mul(A["i"], SYMBOLS["s_i_b"]))
#: The vector from the point on i to the point on j, frame O.
D = NamedMatrix("d", add(TO_POINT, FROM_CENTRE))
#: Why γ in the relative angular velocity Ω is equal to the result of the product rule.
TURNING_RULE = "seen from one body dy/dt = Ω × y and dΩ/dt = Ω × ω, by (7.15)"
#: The point on j seen from the frame of i.
Y = NamedMatrix("y", mul(transpose(A["i"]), TO_POINT))


def derive(package: str) -> Derivation:
    """Derivation of ``n1``, ``n2``, ``p1_x`` … ``p2_z``, lecture 8.2.

    n1: a_i·a_j = 0 (1,), (8.9); n2: a_i·d = 0 (1,) [m], (8.12); p1: two rows of ã_i a_j = 0 (2,),
    (8.14); p2: two rows of ã_i d = 0 (2,) [m], (8.16). Vectors a = A a′ and d, from the point on i
    to the point on j, are in frame O; the rows of p1 and p2 are taken in the frame of i.
    """
    kind, _, axis = package.partition("_")
    builders = {"n1": _n1, "n2": _n2, "p1": _p1, "p2": _p2}
    return derive_constraint(builders[kind](axis))


def body_frame_offset() -> SymbolicMatrix:
    """Offset A_iᵀ d (3,) [m] = y − (p·p)² s_i′, frame of i, by A_iᵀA_i = (p·p)² I and (8.8)."""
    own_point = mul(transpose(A["i"]), FROM_CENTRE)
    return add(Y, orthogonality(own_point) or own_point)


def _offset_steps(*before: SymbolicMatrix) -> tuple[SymbolicMatrix, tuple[Step, ...]]:
    """Constraint C = before · A_iᵀ d with d resolved, and the steps from the frame-O form to it."""
    value = mul(*before, body_frame_offset())
    left = MatrixSymbol("C", *value.shape)
    d = MatrixSymbol("d", 3, 1)
    expanded = mul(*before, transpose(A["i"]), D.value)
    split = mul(*before, add(Y, mul(transpose(A["i"]), FROM_CENTRE)))
    return value, (
        Step(d, D.value, "vector between the points", "8.8"),
        Step(left, expanded, "d resolved", "8.8"),
        Step(MatrixSymbol("y", 3, 1), Y.value, "abbreviation: the point on j seen from i", ""),
        Step(left, split, "multiplied out", ""),
        Step(left, value, "AᵀA = (p·p)² I, for Euler parameters of any norm", "4.3"),
    )


def _offset_components() -> list[Any]:
    """Components of A_iᵀ d; s_i′ comes back to frame i with the factor (p·p)² for any p."""
    x = COMPONENTS
    to_point = subtract(plus(x["r_j"], rotate(x["p_j"], x["s_j_b"])), x["r_i"])
    square = sum(e**2 for e in x["p_i"]) ** 2
    return subtract(rotate_back(x["p_i"], to_point), [square * s for s in x["s_i_b"]])


def _selection(axis: str) -> NamedMatrix:
    rows = [[int(k == row) for k in range(3)] for row in ROWS[axis]]
    selection: NamedMatrix = NamedMatrix("S", ImmutableDenseMatrix(rows))
    return selection


def _choice(axis: str) -> Step:
    selection = _selection(axis)
    return Step(
        MatrixSymbol("S", 2, 3),
        selection.value,
        f"the two rows that hold a′_{axis}, its largest component, in the frame of i",
        "8.16",
    )


@dataclass(frozen=True, slots=True)
class Turning:
    """A vector of one body as the other one sees it turn: dy/dt = Ω × y, lecture 7.1, (7.15).

    All are in the frame of the one that sees, and divided by the squares of the Euler parameters
    where these would count, so that p may have any norm.

    Parameters
    ----------
    y : SymbolicMatrix (3, 1) [-]
        The vector, y = A_iᵀA_j a′ seen from i.
    w : SymbolicMatrix (3, 1) [1/s]
        Its rate by the turning of its own body alone, A_iᵀA_j ω̃′a′.
    own : SymbolicMatrix (3, 1) [rad/s]
        Angular velocity of the body that sees.
    omega : SymbolicMatrix (3, 1) [rad/s]
        Ω, that of the other body less this one. It is found before anything is multiplied with it,
        so that no digits cancel where the bodies turn together.
    """

    y: SymbolicMatrix
    w: SymbolicMatrix
    own: SymbolicMatrix
    omega: SymbolicMatrix


def turning_seen_from(body: str) -> Turning:
    """Vector a (3,) [-] of the other body as it turns in the frame of ``body``: dy/dt = Ω × y."""
    (other,) = set(BODIES) - {body}
    axis, spin, own = (SYMBOLS[x] for x in (f"a_{other}_b", f"omega_{other}_b", f"omega_{body}_b"))
    p, q = SYMBOLS[f"p_{body}"], SYMBOLS[f"p_{other}"]
    squares = Divisor(Dot(p, p) * Dot(q, q))
    into = (transpose(A[body]), A[other])
    seen = NamedMatrix("omega_seen", mul(*into, spin))
    return Turning(
        NamedMatrix("y", mul(*into, axis)),
        NamedMatrix("w", mul(*into, skew(spin), axis)),
        own,
        NamedMatrix("omega", add(mul(1 / squares, seen), neg(own))),
    )


def n1_gamma(vector: SymbolicMatrix, body: str) -> SymbolicMatrix:
    """γ (1, 1) [1/s²] of n1 for a vector b of ``body`` and a of the other, Ω·(b × w − y × (ω × b)).

    b (3,) [-] is in the frame of ``body``, from which it is seen: nothing is lost there of what
    stands along its own axes. The condition is lecture 8.2, (8.9).
    """
    seen = turning_seen_from(body)
    arm = add(mul(skew(vector), seen.w), neg(mul(skew(seen.y), skew(seen.own), vector)))
    return mul(transpose(seen.omega), arm)


def _p1_gamma(axis: str) -> Step:
    """γ = S a′_i~ (ω × (Ω × y) − Ω × w), seen from i."""
    seen = turning_seen_from("i")
    turned = add(mul(skew(seen.own), skew(seen.omega), seen.y), neg(mul(skew(seen.omega), seen.w)))
    gamma = mul(_selection(axis), skew(SYMBOLS["a_i_b"]), turned)
    return Step(MatrixSymbol("gamma", 2, 1), gamma, TURNING_RULE, "7.15")


def _n1(_: str) -> Constraint:
    x = COMPONENTS
    value = mul(transpose(SYMBOLS["a_i_b"]), transpose(A["i"]), A["j"], SYMBOLS["a_j_b"])
    left = MatrixSymbol("C", 1, 1)
    seen_from_j = n1_gamma(SYMBOLS["a_j_b"], "j")
    gamma = Step(MatrixSymbol("gamma", 1, 1), seen_from_j, TURNING_RULE, "7.15")
    return Constraint(
        name="n1",
        kind="n1",
        title="n1, two vectors perpendicular (dot-1, PERPENDICULAR)",
        source="lecture 8.2, (8.9)",
        formula="C = a′_i^T A_i^T A_j a′_j",
        unit="-",
        steps=(
            Step(
                left, mul(transpose(AXES["i"]), AXES["j"]), "the vectors are perpendicular", "8.9"
            ),
            Step(left, value, "a = A a′ in each body", "8.9"),
        ),
        value=value,
        components=(dot_product(rotate(x["p_i"], x["a_i_b"]), rotate(x["p_j"], x["a_j_b"])),),
        gamma=gamma,
    )


def _n2(_: str) -> Constraint:
    value, steps = _offset_steps(transpose(SYMBOLS["a_i_b"]))
    first = Step(
        MatrixSymbol("C", 1, 1),
        mul(transpose(AXES["i"]), D),
        "the vector is perpendicular to the line between the points",
        "8.12",
    )
    return Constraint(
        name="n2",
        kind="n2",
        title="n2, vector perpendicular to the line between two points (dot-2, INPLANE)",
        source="lecture 8.2, (8.12)",
        formula="C = a′_i^T A_i^T d, d = r_j + A_j s′_j − r_i − A_i s′_i",
        unit="m",
        steps=(first, *steps),
        value=value,
        components=(dot_product(COMPONENTS["a_i_b"], _offset_components()),),
        names=(Y,),
    )


def _p1(axis: str) -> Constraint:
    x = COMPONENTS
    into = transpose(A["i"])
    value = mul(_selection(axis), skew(SYMBOLS["a_i_b"]), into, A["j"], SYMBOLS["a_j_b"])
    crossed = mul(skew(AXES["i"]), AXES["j"])
    left = MatrixSymbol("C", 2, 1)
    product = cross(x["a_i_b"], rotate_back(x["p_i"], rotate(x["p_j"], x["a_j_b"])))
    return Constraint(
        name=f"p1_{axis}",
        kind="p1",
        title="p1, two vectors parallel (parallel-1, PARALLEL AXES)",
        source="lecture 8.2, (8.14)",
        formula="C = S a′_i~ A_i^T A_j a′_j",
        unit="-",
        steps=(
            Step(MatrixSymbol("c", 3, 1), crossed, "the cross product vanishes", "8.14"),
            _choice(axis),
            Step(left, value, "a~ = A a′~ Aᵀ for a = A a′; two rows, in the frame of i", "4.20"),
        ),
        value=value,
        components=tuple(product[row] for row in ROWS[axis]),
        gamma=_p1_gamma(axis),
    )


def _p2(axis: str) -> Constraint:
    value, steps = _offset_steps(_selection(axis), skew(SYMBOLS["a_i_b"]))
    product = cross(COMPONENTS["a_i_b"], _offset_components())
    left, crossed = MatrixSymbol("C", 2, 1), mul(skew(AXES["i"]), D)
    in_frame_i = mul(_selection(axis), skew(SYMBOLS["a_i_b"]), transpose(A["i"]), D)
    return Constraint(
        name=f"p2_{axis}",
        kind="p2",
        title="p2, vector parallel to the line between two points (parallel-2, INLINE)",
        source="lecture 8.2, (8.16)",
        formula="C = S a′_i~ A_i^T d, d = r_j + A_j s′_j − r_i − A_i s′_i",
        unit="m",
        steps=(
            Step(MatrixSymbol("c", 3, 1), crossed, "the cross product vanishes", "8.16"),
            _choice(axis),
            Step(
                left, in_frame_i, "a~ = A a′~ Aᵀ for a = A a′; two rows, in the frame of i", "4.20"
            ),
            *steps,
        ),
        value=value,
        components=tuple(product[row] for row in ROWS[axis]),
        names=(Y,),
    )
