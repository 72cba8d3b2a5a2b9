"""The matrix level: the closed set of nodes that a derivation is written in.

``codegen.freeze`` accepts exactly these, and refuses anything else by name.

====================================  ===========================================================
node                                  meaning
====================================  ===========================================================
``MatrixSymbol``                      an input array: (n, 1) for a vector, (m, n) for a matrix
``OrientationMatrix(p)``              A(p), the homogeneous quadratic form of the Euler parameters
``Skew(v)``                           the skew operator: ``Skew(v) w`` is the cross product v × w
``Transpose``, ``MatMul``, ``MatAdd`` as in SymPy; a product may carry scalar factors
``Identity``, ``ZeroMatrix``          constants
``ImmutableDenseMatrix``              a constant such as a selection of rows, or scalar formulas
``BlockMatrix``                       blocks side by side, such as a Jacobian
``NamedMatrix(name, x)``                    x, printed by its name
====================================  ===========================================================

Scalars, as factors of a product or as elements of an explicit matrix, are built from numbers,
``Symbol`` (an input of shape ``()``), elements ``v[i, j]`` of a ``MatrixSymbol``,
``Dot(u, v)`` (the number uᵀv), ``Divisor(x)`` (x), ``NamedScalar(name, x)``, ``+``, ``*``, integer
powers, square roots, ``sin``, ``cos`` and ``atan2``.

Expressions are built by :func:`add`, :func:`mul`, :func:`transpose` and :func:`skew`, which keep
the order in which terms are written; SymPy's own canonical order, which may change from version
to version, is never asked for.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from sympy import Add, Basic, Expr, Integer, Mul, Rational, S, Symbol
from sympy.core.symbol import Str
from sympy.matrices.expressions import (
    BlockMatrix,
    Identity,
    MatAdd,
    MatMul,
    MatrixExpr,
    MatrixSymbol,
    Transpose,
    ZeroMatrix,
)
from sympy.matrices.expressions.matexpr import MatrixElement
from sympy.matrices.immutable import ImmutableDenseMatrix

from kousoku.model.errors import DerivationError
from kousoku.symbolic.sympy_types import as_matrix

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.model.files.quantity import Quantity
    from kousoku.symbolic.sympy_types import Letter, Scalar, SymbolicMatrix


class OrientationMatrix(MatrixExpr):
    """Matrix A(p) = (e0² − e·e) I + 2 e eᵀ + 2 e0 ẽ (3, 3) [-], body components to frame O.

    The Euler parameters ``p`` (4, 1), scalar first, may have any norm: A Aᵀ = (p·p)² I; of norm one
    it is lecture 7.1, (4.3).
    """

    def __new__(cls, p: SymbolicMatrix) -> Any:
        return Basic.__new__(cls, p)

    p = property(lambda self: self.args[0])
    shape = property(lambda self: (Integer(3), Integer(3)))

    def _entry(self, i: Any, j: Any, **_: Any) -> Expr:
        return quadratic_form([self.p[k, 0] for k in range(4)])[int(i)][int(j)]


class Skew(MatrixExpr):
    """ṽ (3, 3), the skew-symmetric matrix of a vector (3, 1): ṽ w = v × w, frame and unit of v."""

    def __new__(cls, v: SymbolicMatrix) -> Any:
        return Basic.__new__(cls, v)

    v = property(lambda self: self.args[0])
    shape = property(lambda self: (Integer(3), Integer(3)))

    def _entry(self, i: Any, j: Any, **_: Any) -> Expr:
        i, j = int(i), int(j)
        if i == j:
            return S.Zero
        sign = 1 if (j - i) % 3 == 2 else -1
        return sign * self.v[3 - i - j, 0]


class NamedMatrix(MatrixExpr):
    """A matrix expression that is printed by its name, such as d or y."""

    def __new__(cls, name: str | Str, value: SymbolicMatrix) -> Any:
        return Basic.__new__(cls, Str(str(name)), value)

    name = property(lambda self: str(self.args[0]))
    value = property(lambda self: self.args[1])
    shape = property(lambda self: self.args[1].shape)

    def _entry(self, i: Any, j: Any, **_: Any) -> Expr:
        return self.value[i, j]


class Dot(Expr):
    """The number uᵀv of two vectors (n, 1) in one frame, a scalar factor in the unit of u v."""

    is_commutative = True

    def __new__(cls, u: SymbolicMatrix, v: SymbolicMatrix) -> Any:
        return Basic.__new__(cls, u, v)


class Divisor(Expr):
    """The number x ≥ 0, by which 0 is divided where it underflows: 0/``Divisor(x)`` is then 0.

    It is x on both levels; emitted is x plus the smallest subnormal number.
    """

    is_commutative = True

    def __new__(cls, x: Scalar) -> Any:
        return Basic.__new__(cls, x)


class NamedScalar(Expr):
    """A scalar formula that is printed by its name, such as the length l of a link."""

    is_commutative = True

    def __new__(cls, name: str | Str, value: Scalar) -> Any:
        return Basic.__new__(cls, Str(str(name)), value)

    name = property(lambda self: str(self.args[0]))
    value = property(lambda self: self.args[1])


def vector(name: str, size: int = 3) -> Letter:
    """Symbol of an input vector."""
    letter: Letter = MatrixSymbol(name, size, 1)
    return letter


def symbol(quantity: Quantity) -> Any:
    """Matrix-level symbol of an input: a ``Symbol`` where it is a scalar."""
    if not quantity.shape:
        return Symbol(quantity.name)
    rows, columns = (*quantity.shape, 1)[:2]
    return MatrixSymbol(quantity.name, rows, columns)


def elements(quantity: Quantity) -> tuple[Symbol, ...]:
    """Component-level symbols of an array, flat and row-major.

    They are named ``r_i[0]``, ``r_i[1]`` …; a scalar keeps its bare name.
    """
    if not quantity.shape:
        return (Symbol(quantity.name),)
    return tuple(Symbol(f"{quantity.name}[{k}]") for k in range(quantity.size))


def quadratic_form(p: Sequence[Any]) -> list[list[Any]]:
    """Elements (3, 3) of A(p) for any numbers ``p`` with ``+``, ``-`` and ``*``.

    A(p) = (e0² − e·e) I + 2 e eᵀ + 2 e0 ẽ, lecture 7.1, (4.3), takes components in the body frame
    to frame O, times p·p where p is not of norm one.

    Parameters
    ----------
    p : (4,) [-]
        Euler parameters, scalar first.
    """
    e0, e1, e2, e3 = p
    return [
        [e0 * e0 + e1 * e1 - e2 * e2 - e3 * e3, 2 * (e1 * e2 - e0 * e3), 2 * (e1 * e3 + e0 * e2)],
        [2 * (e1 * e2 + e0 * e3), e0 * e0 - e1 * e1 + e2 * e2 - e3 * e3, 2 * (e2 * e3 - e0 * e1)],
        [2 * (e1 * e3 - e0 * e2), 2 * (e2 * e3 + e0 * e1), e0 * e0 - e1 * e1 - e2 * e2 + e3 * e3],
    ]


def is_zero(x: SymbolicMatrix) -> bool:
    """Whether ``x`` is a zero matrix by construction."""
    return isinstance(x, ZeroMatrix) or (
        isinstance(x, ImmutableDenseMatrix) and all(value == 0 for value in x)
    )


def coefficient_and_factors(x: SymbolicMatrix) -> tuple[Scalar, tuple[SymbolicMatrix, ...]]:
    """Split a product into its scalar factor and its matrix factors, in order."""
    if not isinstance(x, MatMul):
        return S.One, (x,)
    scalar, factors = S.One, []
    for arg in x.args:
        if getattr(arg, "is_Matrix", False):
            factors.append(arg)
        else:
            scalar = scalar * arg
    return scalar, tuple(factors)


def mul(*factors: Any) -> SymbolicMatrix:
    """Product in the given order: flat, without identities, scalar factors in front."""
    scalar: Scalar = S.One
    matrices: list[SymbolicMatrix] = []
    for factor in factors:
        if not getattr(factor, "is_Matrix", False):
            scalar = scalar * factor
            continue
        coefficient, matrix_factors = coefficient_and_factors(factor)
        scalar = scalar * coefficient
        matrices.extend(matrix_factors)
    if not matrices:
        raise DerivationError(
            f"a product of {scalar} alone is a number; multiply it by Identity(1) for a matrix"
        )
    rows, columns = matrices[0].shape[0], matrices[-1].shape[1]
    if scalar == 0 or any(is_zero(matrix) for matrix in matrices):
        return as_matrix(ZeroMatrix(rows, columns))
    kept = [matrix for matrix in matrices if not isinstance(matrix, Identity)] or matrices[:1]
    if scalar == 1:
        return kept[0] if len(kept) == 1 else MatMul(*kept)
    return as_matrix(MatMul(scalar, *kept))


def add(*terms: SymbolicMatrix) -> SymbolicMatrix:
    """Sum in the given order: flat, without zeros, equal terms collected."""
    counts: dict[tuple[SymbolicMatrix, ...], Scalar] = {}
    for term in terms:
        for part in term.args if isinstance(term, MatAdd) else (term,):
            if not is_zero(part):
                scalar, factors = coefficient_and_factors(part)
                counts[factors] = counts.get(factors, S.Zero) + scalar
    kept = [mul(scalar, *factors) for factors, scalar in counts.items() if scalar != 0]
    if not kept:
        return as_matrix(ZeroMatrix(*terms[0].shape))
    return kept[0] if len(kept) == 1 else MatAdd(*kept)


def neg(x: SymbolicMatrix) -> SymbolicMatrix:
    """Negative −x."""
    if isinstance(x, MatAdd):
        return add(*(neg(term) for term in x.args))
    return mul(S.NegativeOne, x)


def skew(v: SymbolicMatrix) -> SymbolicMatrix:
    """Skew matrix ṽ (3, 3) of v (3, 1), its frame and unit, the scalar factor of v in front."""
    if is_zero(v):
        return as_matrix(ZeroMatrix(3, 3))
    scalar, factors = coefficient_and_factors(v)
    return mul(scalar, Skew(mul(*factors)))


def transpose(x: SymbolicMatrix) -> SymbolicMatrix:
    """Transpose xᵀ with the transposition carried to the symbols: (XY)ᵀ = YᵀXᵀ, ṽᵀ = −ṽ."""
    if tuple(x.shape) == (1, 1) and not isinstance(x, MatMul | MatAdd):
        return x
    match x:
        case MatMul():
            scalar, factors = coefficient_and_factors(x)
            return mul(scalar, *(transpose(factor) for factor in reversed(factors)))
        case MatAdd():
            return add(*(transpose(term) for term in x.args))
        case Transpose():
            return as_matrix(x.arg)
        case Skew():
            return neg(x)
        case ZeroMatrix():
            return as_matrix(ZeroMatrix(x.shape[1], x.shape[0]))
        case Identity():
            return as_matrix(x)
        case ImmutableDenseMatrix():
            return as_matrix(x.T)
        case BlockMatrix():
            rows, columns = x.blockshape
            return as_matrix(
                BlockMatrix(
                    [[transpose(x.blocks[i, j]) for i in range(rows)] for j in range(columns)]
                )
            )
    return as_matrix(Transpose(x))


def description(x: Any) -> str:
    """Text that fixes the order of commuting scalar terms, the same in all versions."""
    if isinstance(x, Rational):
        return f"0 {x.p}/{x.q}"
    if isinstance(x, MatrixElement):
        return f"1 {x.parent.name} {x.i},{x.j}"
    if isinstance(x, Symbol | MatrixSymbol | NamedMatrix | NamedScalar):
        return f"1 {x.name}"
    parts = [description(arg) for arg in x.args]
    if isinstance(x, Add | Mul):
        parts.sort()
    return f"2 {type(x).__name__}({' '.join(parts)})"
