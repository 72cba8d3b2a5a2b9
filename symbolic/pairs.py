"""The constraints between two vectors of lecture 8.2: n1, n2, p1 and p2."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from sympy.matrices.expressions import MatrixSymbol
from sympy.matrices.immutable import ImmutableDenseMatrix

from kousoku.model.rows import ROWS
from kousoku.symbolic.bodies import COMPONENTS, SYMBOLS, A
from kousoku.symbolic.components import cross, plus, rotate, rotate_back, subtract
from kousoku.symbolic.components import dot as dot_product
from kousoku.symbolic.constraint import derive_constraint
from kousoku.symbolic.derivation import Step
from kousoku.symbolic.forms import Constraint
from kousoku.symbolic.matrices import (
    Divisor,
    Dot,
    Matrix,
    Named,
    add,
    mul,
    neg,
    skew,
    transpose,
)
from kousoku.symbolic.variation import orthogonality

if TYPE_CHECKING:
    from kousoku.symbolic.derivation import Derivation

#: A frame-O vector of each body, a = A a′.
AXES = {body: Named(f"a_{body}", mul(A[body], SYMBOLS[f"a_{body}_b"])) for body in ("i", "j")}
TO_POINT = add(SYMBOLS["r_j"], mul(A["j"], SYMBOLS["s_j_b"]), neg(SYMBOLS["r_i"]))
FROM_CENTRE = neg(mul(A["i"], SYMBOLS["s_i_b"]))
#: The vector from the point on i to the point on j, frame O.
D = Named("d", add(TO_POINT, FROM_CENTRE))
#: The point on j seen from the frame of i.
Y = Named("y", mul(transpose(A["i"]), TO_POINT))


def derive(package: str) -> Derivation:
    """Return the derivation of ``n1``, ``n2``, ``p1_x`` … ``p2_z``."""
    kind, _, axis = package.partition("_")
    builders = {"n1": _n1, "n2": _n2, "p1": _p1, "p2": _p2}
    return derive_constraint(builders[kind](axis))


def body_frame_offset() -> Matrix:
    """Return A_iᵀ d = y − (p·p)² s_i′, by A_iᵀA_i = (p·p)² I."""
    own = mul(transpose(A["i"]), FROM_CENTRE)
    return add(Y, orthogonality(own) or own)


def _offset_steps(*before: Matrix) -> tuple[Matrix, tuple[Step, ...]]:
    """Return C = before · A_iᵀ d with d resolved, and the steps from the frame-O form to it."""
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
    """Return A_iᵀ d; s_i′ comes back to frame i with the factor (p·p)² for any p."""
    x = COMPONENTS
    to_point = subtract(plus(x["r_j"], rotate(x["p_j"], x["s_j_b"])), x["r_i"])
    square = sum(e**2 for e in x["p_i"]) ** 2
    return subtract(rotate_back(x["p_i"], to_point), [square * s for s in x["s_i_b"]])


def _selection(axis: str) -> Matrix:
    rows = [[int(k == row) for k in range(3)] for row in ROWS[axis]]
    return Named("S", ImmutableDenseMatrix(rows))


def _choice(axis: str) -> Step:
    selection = _selection(axis)
    return Step(
        MatrixSymbol("S", 2, 3),
        selection.value,
        f"the two rows that hold a′_{axis}, its largest component, in the frame of i",
        "8.16",
    )


def _n1_gamma() -> Step:
    """Return γ = Ω·(a_i × w_j − a_j × w_i), with w = A ω̃′a′ and Ω = ω_j − ω_i in frame O.

    It is small where the bodies turn together, so that no digits cancel there.
    """
    w, omega = {}, {}
    for body in ("i", "j"):
        p, spin = SYMBOLS[f"p_{body}"], SYMBOLS[f"omega_{body}_b"]
        w[body] = Named(f"w_{body}", mul(A[body], skew(spin), SYMBOLS[f"a_{body}_b"]))
        turning = Named(f"Omega_{body}", mul(A[body], spin))
        omega[body] = Named(f"omega_{body}", mul(1 / Divisor(Dot(p, p)), turning))
    relative = Named("omega", add(omega["j"], neg(omega["i"])))
    arm = add(mul(skew(AXES["i"]), w["j"]), neg(mul(skew(AXES["j"]), w["i"])))
    rule = "|ω′~ a′|² + a′·ω′~ ω′~ a′ = 0, (7.15) for ω, and (x × y)·z = x·(y × z)"
    return Step(MatrixSymbol("gamma", 1, 1), mul(transpose(relative), arm), rule, "7.15")


def _n1(_: str) -> Constraint:
    x = COMPONENTS
    value = mul(transpose(SYMBOLS["a_i_b"]), transpose(A["i"]), A["j"], SYMBOLS["a_j_b"])
    left = MatrixSymbol("C", 1, 1)
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
        gamma=_n1_gamma(),
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
