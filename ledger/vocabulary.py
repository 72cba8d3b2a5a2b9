"""Symbols of a document and their meaning, and the reader of a formula's sides as values."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cache
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import sympy
from sympy import Integer, S
from sympy.matrices.expressions import BlockMatrix, Inverse, ZeroMatrix
from sympy.matrices.immutable import ImmutableDenseMatrix
from sympy.polys.matrices import DomainMatrix
from sympy.polys.matrices.exceptions import DMNonInvertibleMatrixError

from kousoku.ledger.formula import (
    Array,
    Cross,
    Derivative,
    Division,
    FormulaNode,
    FunctionCall,
    Numeral,
    Power,
    Product,
    Sum,
    SymbolName,
    Tilde,
    Transposed,
)
from kousoku.model.errors import FormulaError
from kousoku.symbolic.matrices import (
    Skew,
    add,
    coefficient_and_factors,
    is_zero,
    mul,
    neg,
    transpose,
)
from kousoku.symbolic.ring import Ring
from kousoku.symbolic.sympy_types import as_value

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from kousoku.model.files.quantity import Quantity
    from kousoku.symbolic.sympy_types import Scalar, SymbolicMatrix, Value


_FUNCTIONS = {"cos": sympy.cos, "sin": sympy.sin, "sqrt": sympy.sqrt}


@dataclass(frozen=True, slots=True)
class Vocabulary:
    """Symbols of a document and their meaning.

    Parameters
    ----------
    quantities : tuple of Quantity
        The arrays that everything is made of; identities hold for all their values.
    meanings : Mapping
        The value of each symbol, by its name as :class:`kousoku.ledger.formula.SymbolName` prints
        it: ``a'^i``, ``δr^P``. A vector is a (3, 1) matrix, a scalar an expression.
    given : Mapping
        Component-level elements, row-major, of matrix symbols that are no quantities, such as δA.
    is_unit : bool
        Whether Euler parameters have norm one.
    derivatives : Mapping
        By ``t`` or another number: what gives the derivative of a value.
    """

    quantities: tuple[Quantity, ...]
    meanings: Mapping[str, Scalar | SymbolicMatrix]
    given: Mapping[str, Sequence[Any]] = field(default_factory=dict)
    is_unit: bool = True
    derivatives: Mapping[str, Callable[[Value], Scalar | SymbolicMatrix]] = field(
        default_factory=dict
    )

    def knowing(self, meanings: Mapping[str, Scalar | SymbolicMatrix]) -> Vocabulary:
        """Vocabulary that knows more symbols, or others by the same names."""
        return replace(self, meanings={**self.meanings, **meanings})

    def meaning(self, name: str) -> Value:
        """Value of a symbol, by its name."""
        return as_value(self.meanings[name])

    def ring(self, at: Sequence[Any] | None = None) -> Ring:
        """Ring in which values are compared, or their values at one rational point."""
        return Ring(self.quantities, self.given, is_unit=self.is_unit, at=at)

    def value(self, node: FormulaNode) -> Value:
        """Value of a formula.

        Raises
        ------
        FormulaError
            A symbol is unknown, or shapes do not fit.
        """
        match node:
            case Numeral():
                return as_value(sympy.Rational(node.text))
            case SymbolName():
                return self._symbol(node)
            case Sum():
                return _total([(sign, self.value(term)) for sign, term in node.terms])
            case Product():
                return _product([self.value(factor) for factor in node.factors])
            case Cross():
                return _product([_tilde(self.value(node.left)), self.value(node.right)])
            case Division():
                return _product(
                    [as_value(1 / _number(self.value(node.under))), self.value(node.over)]
                )
            case Power():
                return _power(self.value(node.base), node.exponent)
            case Transposed():
                return as_value(transpose(self.value(node.inner)))
            case Tilde():
                return _tilde(self.value(node.inner))
            case FunctionCall():
                # A double angle has no other sines and cosines than the angle.
                value = _FUNCTIONS[node.function](_number(self.value(node.argument)))
                return as_value(sympy.expand_trig(value))
            case Derivative():
                return self._derivative(node)
            case Array():
                return _array([[self.value(cell) for cell in row] for row in node.rows])

    def _derivative(self, node: Derivative) -> Value:
        if node.by not in self.derivatives:
            raise FormulaError(f"nothing is differentiated by {node.by}")
        return as_value(self.derivatives[node.by](self.value(node.inner)))

    def _symbol(self, name: SymbolName) -> Value:
        if str(name) in self.meanings:
            return self.meaning(str(name))
        base = str(SymbolName(name.letter, name.primes, name.sub))
        if name.sup.isdigit() and base in self.meanings:
            return _power(self.meaning(base), int(name.sup))
        raise FormulaError(f"nothing is called {name}")


def shape(value: Scalar | SymbolicMatrix) -> tuple[int, ...]:
    """Shape () of a scalar, (rows, columns) of a matrix."""
    is_matrix = getattr(value, "is_Matrix", False)
    return tuple(int(n) for n in as_value(value).shape) if is_matrix else ()


def _number(value: Value) -> Value:
    if shape(value):
        raise FormulaError(f"a matrix of shape {shape(value)} stands where a number is wanted")
    return value


def _total(terms: Sequence[tuple[int, Value]]) -> Value:
    shapes = [shape(value) for _, value in terms if value != 0]
    if len(set(shapes)) > 1:
        raise FormulaError("a sum of terms of shapes " + ", ".join(str(s) for s in shapes))
    signed = [value if sign > 0 else _negative(value) for sign, value in terms]
    if not shapes or not shapes[0]:
        return sum(signed, S.Zero)
    return as_value(add(*(value for value in signed if shape(value))))


def _negative(value: Value) -> Value:
    return as_value(neg(value) if shape(value) else -value)


def _product(factors: Sequence[Value]) -> Value:
    shapes = [s for s in (shape(factor) for factor in factors) if s]
    for left, right in pairwise(shapes):
        if left[1] != right[0]:
            raise FormulaError(f"a product of shapes {left} and {right}")
    return as_value(mul(*factors) if shapes else sympy.Mul(*factors))


def _power(value: Value, exponent: int) -> Value:
    if not shape(value):
        return as_value(value**exponent)
    rows, columns = shape(value)
    if exponent != -1 or rows != columns:
        raise FormulaError(f"the power {exponent} of a matrix of shape {(rows, columns)}")
    dense = explicit(value)
    return Inverse(value) if dense is None else _inverse(dense)


def explicit(value: Scalar | SymbolicMatrix) -> Value:
    """Product of matrices of formulas as one of them; None where some are symbols."""
    if any(not isinstance(s, ImmutableDenseMatrix) for s in _factors(value)):
        return as_value(None)
    result, *rest = _factors(value)
    for factor in rest:
        result = as_value(result * factor)
    return result


def _factors(value: Scalar | SymbolicMatrix) -> tuple[Value, ...]:
    scalar, factors = coefficient_and_factors(as_value(value))
    first, *rest = map(as_value, factors)
    return (as_value(scalar * first) if scalar != 1 else first, *rest)


@cache
def _inverse(value: Scalar | SymbolicMatrix) -> Value:
    """Inverse of a matrix of rational functions, fractions reduced."""
    try:
        inverse = DomainMatrix.from_Matrix(value).to_field().inv()
    except DMNonInvertibleMatrixError:
        raise FormulaError("the inverse of a singular matrix") from None
    return as_value(ImmutableDenseMatrix(inverse.to_Matrix()))


def _tilde(value: Scalar | SymbolicMatrix) -> Value:
    if shape(value) != (3, 1):
        raise FormulaError(f"the skew matrix of something of shape {shape(value)}")
    return as_value(ZeroMatrix(3, 3) if is_zero(as_value(value)) else Skew(as_value(value)))


def _array(cells: Sequence[Sequence[Value]]) -> Value:
    """Matrix of numbers or of blocks; a 0 among blocks is as large as its place."""
    if not any(shape(cell) for row in cells for cell in row):
        return as_value(ImmutableDenseMatrix([list(row) for row in cells]))
    heights = [_extent([shape(cell)[:1] for cell in row if cell != 0]) for row in cells]
    columns = list(zip(*cells, strict=True))
    widths = [_extent([shape(cell)[1:] for cell in column if cell != 0]) for column in columns]
    blocks = [
        [ZeroMatrix(h, w) if cell == 0 else cell for cell, w in zip(row, widths, strict=True)]
        for row, h in zip(cells, heights, strict=True)
    ]
    return BlockMatrix(blocks) if len(blocks) > 1 or len(blocks[0]) > 1 else blocks[0][0]


def _extent(extents: Sequence[tuple[int, ...]]) -> Integer:
    """Common height of the blocks of a row, or the common width of a column."""
    if () in extents:
        raise FormulaError("a number stands where a block of a matrix belongs")
    if len(set(extents)) != 1:
        raise FormulaError(f"blocks of different extents in one line: {sorted(extents)}")
    return Integer(extents[0][0])
