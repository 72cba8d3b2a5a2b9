"""The constraints between two vectors of lecture 8.2: n1, n2, p1 and p2."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from sympy.matrices.immutable import ImmutableDenseMatrix

from kousoku.symbolic.components import cross, plus, rotate, rotate_back, subtract
from kousoku.symbolic.components import dot as dot_product
from kousoku.symbolic.constraint import COMPONENTS, SYMBOLS, A, Constraint, derive_constraint
from kousoku.symbolic.matrices import Dot, Matrix, Named, add, mul, neg, skew, transpose

if TYPE_CHECKING:
    from kousoku.symbolic.derivation import Derivation

#: The rows of ã′ that hold the component of the named axis.
ROWS = {"x": (1, 2), "y": (0, 2), "z": (0, 1)}


def derive(package: str) -> Derivation:
    """Return the derivation of ``n1``, ``n2``, ``p1_x`` … ``p2_z``."""
    kind, _, axis = package.partition("_")
    builders = {"n1": _n1, "n2": _n2, "p1": _p1, "p2": _p2}
    return derive_constraint(builders[kind](axis))


def _between() -> Matrix:
    """Return y = A_iᵀ (r_j + A_j s_j′ − r_i): the point on j seen from i."""
    to_point = add(SYMBOLS["r_j"], mul(A["j"], SYMBOLS["s_j_b"]), neg(SYMBOLS["r_i"]))
    return Named("y", mul(transpose(A["i"]), to_point))


def _offset() -> Matrix:
    """Return A_iᵀ d, with A_iᵀA_i = (p·p)² I: y − (p·p)² s_i′."""
    p = SYMBOLS["p_i"]
    return add(_between(), mul(-(Dot(p, p) ** 2), SYMBOLS["s_i_b"]))


def _offset_components() -> list[Any]:
    """Return A_iᵀ d; s_i′ comes back to frame i with the factor (p·p)² for any p."""
    x = COMPONENTS
    to_point = subtract(plus(x["r_j"], rotate(x["p_j"], x["s_j_b"])), x["r_i"])
    square = sum(e**2 for e in x["p_i"]) ** 2
    return subtract(rotate_back(x["p_i"], to_point), [square * s for s in x["s_i_b"]])


def _selection(axis: str) -> Matrix:
    rows = [[int(k == row) for k in range(3)] for row in ROWS[axis]]
    return Named("S", ImmutableDenseMatrix(rows))


def _n1(_: str) -> Constraint:
    x = COMPONENTS
    value = mul(transpose(SYMBOLS["a_i_b"]), transpose(A["i"]), A["j"], SYMBOLS["a_j_b"])
    scalar = dot_product(rotate(x["p_i"], x["a_i_b"]), rotate(x["p_j"], x["a_j_b"]))
    return Constraint(
        "n1",
        "n1",
        "n1, two vectors perpendicular (dot-1, PERPENDICULAR)",
        "lecture 8.2, (8.9)",
        "C = a_i^T A_i^T A_j a_j",
        "-",
        (),
        value,
        (scalar,),
    )


def _n2(_: str) -> Constraint:
    x = COMPONENTS
    value = mul(transpose(SYMBOLS["a_i_b"]), _offset())
    scalar = dot_product(x["a_i_b"], _offset_components())
    return Constraint(
        "n2",
        "n2",
        "n2, vector perpendicular to the line between two points (dot-2, INPLANE)",
        "lecture 8.2, (8.12)",
        "C = a_i^T A_i^T d",
        "m",
        (),
        value,
        (scalar,),
    )


def _p1(axis: str) -> Constraint:
    x = COMPONENTS
    value = mul(
        _selection(axis), skew(SYMBOLS["a_i_b"]), transpose(A["i"]), A["j"], SYMBOLS["a_j_b"]
    )
    product = cross(x["a_i_b"], rotate_back(x["p_i"], rotate(x["p_j"], x["a_j_b"])))
    return Constraint(
        f"p1_{axis}",
        "p1",
        "p1, two vectors parallel (parallel-1, PARALLEL AXES)",
        "lecture 8.2, (8.14)",
        "C = S a_i~ A_i^T A_j a_j",
        "-",
        (),
        value,
        tuple(product[row] for row in ROWS[axis]),
    )


def _p2(axis: str) -> Constraint:
    x = COMPONENTS
    value = mul(_selection(axis), skew(SYMBOLS["a_i_b"]), _offset())
    product = cross(x["a_i_b"], _offset_components())
    return Constraint(
        f"p2_{axis}",
        "p2",
        "p2, vector parallel to the line between two points (parallel-2, INLINE)",
        "lecture 8.2, (8.16)",
        "C = S a_i~ A_i^T d",
        "m",
        (),
        value,
        tuple(product[row] for row in ROWS[axis]),
    )
