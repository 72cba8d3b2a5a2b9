"""δ as an operator on the matrix level, and the linear form that it ends in.

A variation and a time derivative follow the same rules; only the symbols differ:
δr ↔ ṙ = v and δθ′ ↔ ω′. The one rule that is not plain algebra is (7.16), δA = A δθ̃′.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import sympy
from sympy.matrices.expressions import (
    BlockMatrix,
    Identity,
    MatAdd,
    MatMul,
    MatrixSymbol,
    Transpose,
    ZeroMatrix,
)
from sympy.matrices.expressions.matexpr import MatrixElement
from sympy.matrices.immutable import ImmutableDenseMatrix

from kousoku.model.errors import DerivationError
from kousoku.symbolic.matrices import (
    Divisor,
    Dot,
    NamedMatrix,
    NamedScalar,
    OrientationMatrix,
    Skew,
    add,
    coefficient_and_factors,
    description,
    is_zero,
    mul,
    neg,
    skew,
    transpose,
)
from kousoku.symbolic.sympy_types import as_matrix

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from kousoku.symbolic.sympy_types import Scalar, SymbolicMatrix


@dataclass(frozen=True, slots=True)
class Variation:
    """The operator δ (or d/dt): a linear map that obeys the product rule.

    Its result has the shape, frame and unit of the operand, of d/dt per second.

    Parameters
    ----------
    vectors : Mapping
        The variation of each vector that varies, e.g. r → δr; others are constant.
    rotations : Mapping
        For Euler parameters p the virtual rotation δθ′ (3, 1) [rad] in the body frame: δA(p) = A
        δθ̃′, lecture 7.1, (7.16). With δp = ½ p∘(0, δθ′), p·δp is zero, so that p·p is constant. A
        symbol (3, 3) instead of δθ′ stands for δA itself, before the rule is applied.
    """

    vectors: Mapping[SymbolicMatrix, SymbolicMatrix]
    rotations: Mapping[SymbolicMatrix, SymbolicMatrix]

    def __call__(self, x: SymbolicMatrix) -> SymbolicMatrix:
        """Variation δx, by the product rule and (7.16)."""
        match x:
            case MatAdd():
                return add(*(self(term) for term in x.args))
            case MatMul():
                return self._of_product(x)
            case OrientationMatrix():
                return self._of_orientation(x)
            case Skew():
                return skew(self(x.v))
            case Transpose():
                return transpose(self(x.arg))
            case NamedMatrix():
                return self(x.value)
            case BlockMatrix():
                rows, columns = x.blockshape
                return as_matrix(
                    BlockMatrix(
                        [[self(x.blocks[i, j]) for j in range(columns)] for i in range(rows)]
                    )
                )
            case MatrixSymbol():
                return self.vectors.get(x, ZeroMatrix(*x.shape))
            case Identity() | ZeroMatrix() | ImmutableDenseMatrix():
                return as_matrix(ZeroMatrix(*x.shape))
        raise DerivationError(f"variation: no rule for {type(x).__name__} in {x}")

    def _of_orientation(self, x: OrientationMatrix) -> SymbolicMatrix:
        change = self.rotations.get(x.p)
        if change is None:
            return as_matrix(ZeroMatrix(3, 3))
        return change if change.shape[1] == 3 else mul(x, skew(change))

    def _of_product(self, x: SymbolicMatrix) -> SymbolicMatrix:
        scalar, factors = coefficient_and_factors(x)
        change = self.of_scalar(scalar)
        varied = mul(change, *factors) if x.shape[0] == 1 else ZeroMatrix(*x.shape)
        if x.shape[0] > 1 and not is_zero(change):
            if x.shape[1] > 1:
                raise DerivationError(f"variation: the factor {scalar} of a matrix is not constant")
            varied = mul(*factors, change)
        if len(factors) == 2 and transpose(factors[1]) == factors[0] and x.shape[0] == 1:
            return add(varied, mul(2 * scalar, factors[0], self(factors[1])))  # δ(uᵀu) = 2 uᵀδu
        return add(
            varied,
            *(
                mul(scalar, *factors[:k], self(factor), *factors[k + 1 :])
                for k, factor in enumerate(factors)
            ),
        )

    def of_scalar(self, x: Scalar) -> SymbolicMatrix:
        """Variation δx (1, 1) of a scalar factor, by the chain rule δf = Σ ∂f/∂u δu; unit of x."""
        match x:
            case Dot() if x.args[0] == x.args[1]:
                u = x.args[0]
                return ZeroMatrix(1, 1) if u in self.rotations else mul(2, transpose(u), self(u))
            case Dot():
                u, v = x.args
                return add(mul(transpose(u), self(v)), mul(transpose(v), self(u)))
            case NamedScalar() if x.value.is_Pow and x.value.exp == sympy.Rational(1, 2):
                return mul(1 / (2 * x), self.of_scalar(x.value.base))  # δ√u = δu / (2 √u)
            case NamedScalar():
                return self.of_scalar(x.value)
            case Divisor():
                return self.of_scalar(x.args[0])
            case MatrixElement() if x.parent.shape[1] == 1 and x.parent not in self.rotations:
                row = [[int(k == x.i) for k in range(int(x.parent.shape[0]))]]
                return mul(ImmutableDenseMatrix(row), self(x.parent))
        changes = {arg: self.of_scalar(arg) for arg in x.args}
        if all(map(is_zero, changes.values())):
            return as_matrix(ZeroMatrix(1, 1))
        return add(*(mul(slope, changes[arg]) for slope, arg in _slopes(x)))


def _slopes(x: Scalar) -> list[tuple[Scalar, Scalar]]:
    """Arguments of a scalar formula that may vary, each after the derivative by it."""
    match x:
        case sympy.Add():
            return [(sympy.S.One, arg) for arg in sorted(x.args, key=description)]
        case sympy.Mul():
            return [(x / arg, arg) for arg in sorted(x.args, key=description)]
        case sympy.Pow() if x.exp.is_Rational:
            return [(x.exp * x.base ** (x.exp - 1), x.base)]
        case sympy.atan2():
            y, x_ = x.args
            square = Divisor(x_**2 + y**2)
            return [(x_ / square, y), (-y / square, x_)]
        case sympy.sin():
            return [(sympy.cos(x.args[0]), x.args[0])]
        case sympy.cos():
            return [(-sympy.sin(x.args[0]), x.args[0])]
    raise DerivationError(f"variation: no rule for {type(x).__name__} in the scalar factor {x}")


def contains(x: SymbolicMatrix, symbol: SymbolicMatrix) -> bool:
    """Whether ``symbol`` stands anywhere in ``x``."""
    return bool(x == symbol or any(contains(arg, symbol) for arg in x.args))


def coefficient(x: SymbolicMatrix, symbol: SymbolicMatrix) -> SymbolicMatrix:
    """Matrix M of the column ``x`` = M ``symbol`` + terms without it.

    The rules are ũ w = −w̃ u, and that a number is its own transpose.

    Raises
    ------
    DerivationError
        ``x`` is not linear in ``symbol``, or the symbol cannot be brought to the right.
    """
    zero = ZeroMatrix(x.shape[0], symbol.shape[0])
    if x == symbol:
        return as_matrix(Identity(symbol.shape[0]))
    if not contains(x, symbol):
        return as_matrix(zero)
    match x:
        case MatAdd():
            return add(*(coefficient(term, symbol) for term in x.args))
        case NamedMatrix():
            return coefficient(x.value, symbol)
        case MatMul():
            return _of_product(x, symbol)
    raise DerivationError(f"linear form: {symbol} cannot be collected from {x}")


def _of_product(x: SymbolicMatrix, symbol: SymbolicMatrix) -> SymbolicMatrix:
    scalar, factors = coefficient_and_factors(x)
    indices = [k for k, factor in enumerate(factors) if contains(factor, symbol)]
    if len(indices) != 1:
        raise DerivationError(f"linear form: {x} is not linear in {symbol}")
    index = indices[0]
    before, factor, after = factors[:index], factors[index], factors[index + 1 :]
    if not after and factor.shape[1] == 1:
        return mul(scalar, *before, coefficient(factor, symbol))
    if isinstance(factor, MatAdd):
        return add(
            *(coefficient(mul(scalar, *before, term, *after), symbol) for term in factor.args)
        )
    if isinstance(factor, NamedMatrix):
        return coefficient(mul(scalar, *before, factor.value, *after), symbol)
    if isinstance(factor, Skew):
        right = mul(*after)
        return neg(mul(scalar, *before, skew(right), coefficient(factor.v, symbol)))
    first = max((k for k in range(index + 1) if factors[k].shape[0] == 1), default=-1)
    last = min((k for k in range(index, len(factors)) if factors[k].shape[1] == 1), default=-1)
    if min(first, last) >= 0 and x.shape[1] == 1:  # the number that holds it may stand at the end
        number = transpose(mul(*factors[first : last + 1]))
        return mul(scalar, *factors[:first], *factors[last + 1 :], coefficient(number, symbol))
    raise DerivationError(f"linear form: {symbol} cannot be brought to the right in {x}")


def rewrite(
    x: SymbolicMatrix, rule: Callable[[SymbolicMatrix], SymbolicMatrix | None]
) -> SymbolicMatrix:
    """``x`` with ``rule`` applied to every node from the leaves up, until none changes."""
    if isinstance(x, MatAdd):
        rebuilt = add(*(rewrite(arg, rule) for arg in x.args))
    elif isinstance(x, MatMul):
        scalar, factors = coefficient_and_factors(x)
        rebuilt = mul(scalar, *(rewrite(factor, rule) for factor in factors))
    elif isinstance(x, Skew):
        rebuilt = skew(rewrite(x.v, rule))
    else:
        rebuilt = x
    changed = rule(rebuilt)
    return rebuilt if changed is None or changed == rebuilt else rewrite(changed, rule)


def replaced(x: SymbolicMatrix, symbol: SymbolicMatrix, other: SymbolicMatrix) -> SymbolicMatrix:
    """``x`` with ``other`` in the place of a symbol."""

    def exchange(node: SymbolicMatrix) -> SymbolicMatrix | None:
        if node in (symbol, transpose(symbol)):
            return other if node == symbol else transpose(other)
        return None

    return rewrite(x, exchange)


def without(x: SymbolicMatrix, *symbols: SymbolicMatrix) -> SymbolicMatrix:
    """``x`` with the vectors ``symbols`` set to zero."""

    def vanish(node: SymbolicMatrix) -> SymbolicMatrix | None:
        if node in symbols:
            return as_matrix(ZeroMatrix(*node.shape))
        if isinstance(node, NamedMatrix) and any(
            contains(node.value, symbol) for symbol in symbols
        ):
            return without(node.value, *symbols)
        if isinstance(node, Transpose) and node.arg in symbols:
            return as_matrix(ZeroMatrix(*node.shape))
        return None

    return rewrite(x, vanish)


def orthogonality(x: SymbolicMatrix) -> SymbolicMatrix | None:
    """Identity A(p)ᵀA(p) = (p·p)² I, for Euler parameters of any norm, put in where it stands in x.

    A (3, 3) [-] takes body components to frame O; of norm one it is lecture 7.1, (orthogonality).
    """
    if not isinstance(x, MatMul):
        return None
    scalar, factors = coefficient_and_factors(x)
    for k in range(len(factors) - 1):
        left, right = factors[k : k + 2]
        if (
            isinstance(left, Transpose)
            and left.arg == right
            and isinstance(right, OrientationMatrix)
        ):
            square = Dot(right.p, right.p) ** 2
            rest = (*factors[:k], *factors[k + 2 :]) or (Identity(3),)
            return mul(scalar * square, *rest)
    return None


def abbreviate(x: SymbolicMatrix, *names: NamedMatrix) -> SymbolicMatrix:
    """``x`` with every product, or sum, that a name stands for replaced by the name."""

    def shorten(node: SymbolicMatrix) -> SymbolicMatrix | None:
        scalar, factors = coefficient_and_factors(node)
        for name in names:
            product = coefficient_and_factors(name.value)[1]
            if isinstance(node, MatAdd) and transpose(node) == name.value:
                return transpose(name)
            for start in range(len(factors) - len(product) + 1):
                if factors[start : start + len(product)] == product:
                    return mul(scalar, *factors[:start], name, *factors[start + len(product) :])
        return None

    return rewrite(x, shorten)
