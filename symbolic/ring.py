"""One ring of polynomials for both levels of a derivation, where equal means equal.

A number is a fraction of two polynomials with rational coefficients. Square roots, sines, cosines
and angles are generators of their own, with the one relation that holds between them:
(√x)² = x and cos² = 1 − sin². Fractions are compared by clearing denominators. Nothing is
evaluated at points, and nothing is rounded.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

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
from sympy.polys.domains import QQ
from sympy.polys.rings import ring

from kousoku.model.errors import DerivationError
from kousoku.symbolic.fractions import Fraction, Norm, SparsePolynomial
from kousoku.symbolic.matrices import (
    Divisor,
    Dot,
    NamedMatrix,
    NamedScalar,
    OrientationMatrix,
    Skew,
    coefficient_and_factors,
    elements,
    quadratic_form,
)

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from kousoku.model.files.quantity import Quantity

FractionRows = list[list[Fraction]]

#: Generators kept ready for square roots, sines, cosines and angles.
SPARE = 16


class Ring:
    """Carries expressions of both levels into one ring of polynomials.

    Parameters
    ----------
    quantities : Sequence of Quantity
        The arrays whose elements are the generators.
    matrices : Mapping, optional
        Component-level elements of further matrix symbols, row-major, e.g. of δA.
    is_unit : bool
        Whether Euler parameters have norm one: A(p) is divided by p·p, and p·p counts as one.
    scalars : Sequence of sympy.Symbol
        Further generators.
    at : Sequence of rational, optional
        Numbers in place of all generators: a point that may be a counterexample.
    """

    def __init__(
        self,
        quantities: Sequence[Quantity],
        matrices: Mapping[str, Any] | None = None,
        *,
        is_unit: bool = False,
        scalars: Sequence[Any] = (),
        at: Sequence[Any] | None = None,
    ) -> None:
        self._is_unit = is_unit
        self._symbols = [*(s for q in quantities for s in elements(q)), *scalars]
        names = [] if at is not None else [str(s) for s in self._symbols]
        self._ring, *generators = ring([*names, *(f"extra {k}" for k in range(SPARE))], QQ)
        self._one = self._ring.one
        self._spare = generators[len(names) :]
        values = generators[: len(names)] if at is None else [self._ring(value) for value in at]
        self._scalars: dict[Any, Fraction] = {
            s: Fraction(value, self._one) for s, value in zip(self._symbols, values, strict=True)
        }
        self._functions: list[tuple[str, tuple[Fraction, ...], Fraction]] = []
        self._squares: list[tuple[SparsePolynomial, SparsePolynomial, SparsePolynomial]] = []
        self._norms: list[Norm] = []
        self._cancelled: Sequence[Norm] | None = self._norms
        self._quantities = {q.name: q for q in quantities}
        self._matrices = dict(matrices or {})
        self._memo: dict[Any, FractionRows] = {}

    # -- numbers -------------------------------------------------------------------------------

    def scalar(self, x: Any) -> Fraction:
        """Scalar expression of either level."""
        known = self._scalars.get(x)
        if known is None:
            known = self._scalars[x] = self._scalar(x)
        return known

    def _scalar(self, x: Any) -> Fraction:
        match x:
            case sympy.Rational():
                return Fraction(self._ring(QQ(int(x.p), int(x.q))), self._one)
            case MatrixElement():
                return self.matrix(x.parent)[int(x.i)][int(x.j)]
            case NamedScalar():
                return self.scalar(x.value)
            case Divisor():
                return self.scalar(x.args[0])
            case Dot() if self._is_unit and x.args[0] == x.args[1] and x.args[0].shape == (4, 1):
                return self.scalar(sympy.S.One)
            case Dot():
                ((value,),) = _product(
                    _transposed(self.matrix(x.args[0])), self.matrix(x.args[1]), self._cancelled
                )
                return value
            case sympy.Add():
                return _sum([self.scalar(arg) for arg in x.args])
            case sympy.Mul():
                result = self.scalar(x.args[0])
                for arg in x.args[1:]:
                    result = result * self.scalar(arg)
                return self._reduced(result)
            case sympy.Pow():
                return self._power(x)
            case sympy.sin() | sympy.cos() | sympy.atan2():
                return self._function(type(x).__name__, [self.scalar(arg) for arg in x.args])
        raise DerivationError(f"proof: no rule for {type(x).__name__} in {x}")

    def _power(self, x: Any) -> Fraction:
        base, exponent = x.args
        if exponent.is_Rational and exponent.q == 2:
            root = self._function("sqrt", [self.scalar(base)])
            return self._integer_power(root, int(exponent.p))
        if not exponent.is_Integer:
            raise DerivationError(f"proof: no rule for the power {x}")
        return self._integer_power(self.scalar(base), int(exponent))

    def _integer_power(self, x: Fraction, n: int) -> Fraction:
        over, under = (x.numerator, x.denominator) if n > 0 else (x.denominator, x.numerator)
        return self._reduced(Fraction(over ** abs(n), under ** abs(n)))

    def _function(self, name: str, args: Sequence[Fraction]) -> Fraction:
        for known, known_args, value in self._functions:
            if known == name and all(
                self.is_equal(a, b) for a, b in zip(args, known_args, strict=True)
            ):
                return value
        if len(self._functions) == SPARE:
            raise DerivationError(f"proof: more than {SPARE} different functions")
        value = Fraction(self._spare[len(self._functions)], self._one)
        self._functions.append((name, tuple(args), value))
        if name == "sqrt":
            self._squares.append((value.numerator, args[0].numerator, args[0].denominator))
        if name == "cos":
            sine = self._function("sin", args).numerator
            self._squares.append((value.numerator, self._one - sine**2, self._one))
        return value

    def _reduced(self, x: Fraction) -> Fraction:
        """Replace the squares of roots and cosines."""
        if x.numerator == x.denominator:
            return Fraction(self._one, self._one)
        numerator, denominator = x.numerator, x.denominator
        for generator, square_over, square_under in reversed(self._squares):
            numerator, factor = _without_squares(numerator, generator, square_over, square_under)
            denominator = denominator * factor
            denominator, factor = _without_squares(
                denominator, generator, square_over, square_under
            )
            numerator = numerator * factor
        return Fraction(numerator, denominator)

    def is_equal(self, x: Fraction, y: Fraction) -> bool:
        """Whether two numbers are the same for all values of the inputs."""
        if x.denominator == y.denominator and x.numerator == y.numerator:
            return True
        if not self._functions and self._differ_at_a_point(x, y):
            return False
        difference = Fraction((x - y).numerator, self._one)
        return not self._reduced(self._reduced(difference)).numerator

    def _differ_at_a_point(self, x: Fraction, y: Fraction) -> bool:
        """Whether two rational functions differ at one rational point: a counterexample."""
        point = [QQ(2 * k + 3, k + 2) for k in range(len(self._ring.gens))]
        x_over, x_under, y_over, y_under = (
            _value(part, point) for part in (x.numerator, x.denominator, y.numerator, y.denominator)
        )
        return bool(x_over * y_under != y_over * x_under)

    # -- matrices ------------------------------------------------------------------------------

    def matrix(self, x: Any) -> FractionRows:
        """Elements of a matrix-level expression."""
        known = self._memo.get(x)
        if known is None:
            known = self._memo[x] = self._matrix(x)
        return known

    def _matrix(self, x: Any) -> FractionRows:
        match x:
            case MatrixSymbol():
                return self._array(x)
            case NamedMatrix():
                return self.matrix(x.value)
            case OrientationMatrix():
                return self._orientation([e for (e,) in self.matrix(x.p)])
            case Skew():
                (a,), (b,), (c,) = self.matrix(x.v)
                zero = self.scalar(sympy.S.Zero)
                return [[zero, zero - c, b], [c, zero, zero - a], [zero - b, a, zero]]
            case Transpose():
                return _transposed(self.matrix(x.arg))
            case MatAdd():
                terms = [self.matrix(arg) for arg in x.args]
                return [
                    [_sum(list(cells)) for cells in zip(*rows, strict=True)]
                    for rows in zip(*terms, strict=True)
                ]
            case MatMul():
                return self._scaled_product(x)
            case Identity() | ZeroMatrix():
                is_one = isinstance(x, Identity)
                rows, columns = (int(n) for n in x.shape)
                return [
                    [self.scalar(sympy.Integer(is_one and i == j)) for j in range(columns)]
                    for i in range(rows)
                ]
            case ImmutableDenseMatrix():
                return [[self.scalar(cell) for cell in row] for row in x.tolist()]
            case BlockMatrix():
                return self._blocks(x)
        raise DerivationError(f"proof: no rule for {type(x).__name__} in {x}")

    def _blocks(self, x: Any) -> FractionRows:
        rows, columns = x.blockshape
        blocks = [[self.matrix(x.blocks[i, j]) for j in range(columns)] for i in range(rows)]
        return [
            [cell for block in row for cell in block[k]]
            for row in blocks
            for k in range(len(row[0]))
        ]

    def _orientation(self, p: list[Fraction]) -> FractionRows:
        form = quadratic_form(p)
        if not self._is_unit:
            return form
        square = _sum([e * e for e in p])
        if p[0].numerator.is_generator:
            index = self._ring.gens.index(p[0].numerator)
            self._norms.append(Norm(index, square.numerator - p[0].numerator ** 2))
        return [[Fraction(cell.numerator, square.numerator) for cell in row] for row in form]

    def cells(self, x: Any) -> list[Fraction]:
        """Elements of a scalar or matrix expression, row-major."""
        if not getattr(x, "is_Matrix", False):
            return [self.scalar(x)]
        return [cell for row in self.matrix(x) for cell in row]

    def _array(self, x: Any) -> FractionRows:
        rows, columns = (int(n) for n in x.shape)
        if x.name in self._matrices:
            flat = [self.scalar(value) for value in self._matrices[x.name]]
        elif x.name in self._quantities:
            flat = [self.scalar(value) for value in elements(self._quantities[x.name])]
        else:
            raise DerivationError(f"proof: {x.name} is not among the inputs")
        return [flat[i * columns : (i + 1) * columns] for i in range(rows)]

    def _scaled_product(self, x: Any) -> FractionRows:
        scalar, factors = coefficient_and_factors(x)
        matrices = [self.matrix(factor) for factor in factors]
        while len(matrices) > 1:  # start at the narrow end
            if len(matrices[-1][0]) <= len(matrices[0]):
                matrices[-2:] = [_product(matrices[-2], matrices[-1], self._cancelled)]
            else:
                matrices[:2] = [_product(matrices[0], matrices[1], self._cancelled)]
        value = self.scalar(scalar)
        return [[self._reduced(value * cell) for cell in row] for row in matrices[0]]


def _value(x: SparsePolynomial, point: Sequence[Any]) -> Any:
    total = QQ.zero
    for powers, coefficient in x.terms():
        product = coefficient
        for value, power in zip(point, powers, strict=True):
            if power:
                product *= value**power
        total += product
    return total


def _without_squares(
    x: SparsePolynomial,
    generator: SparsePolynomial,
    over: SparsePolynomial,
    under: SparsePolynomial,
) -> tuple[SparsePolynomial, SparsePolynomial]:
    """Products x·f and f, f a power of ``under``, where generator² = over / under."""
    index = x.ring.gens.index(generator)
    highest = max((powers[index] for powers in x), default=0) // 2
    if highest == 0:
        return x, x.ring.one
    result = x.ring.zero
    for half in range(highest + 1):
        term = x.ring.zero
        for powers, value in x.terms():
            if powers[index] // 2 == half:
                reduced = (*powers[:index], powers[index] % 2, *powers[index + 1 :])
                term[reduced] = term.get(reduced, QQ.zero) + value
        result += term * over**half * under ** (highest - half)
    return result, under**highest


def _sum(terms: list[Fraction]) -> Fraction:
    total = terms[0]
    for term in terms[1:]:
        total = total + term
    return total


def _transposed(rows: FractionRows) -> FractionRows:
    return [list(column) for column in zip(*rows, strict=True)]


def _product(left: FractionRows, right: FractionRows, norms: Sequence[Norm] | None) -> FractionRows:
    columns = _transposed(right)
    return [
        [
            _sum(
                [a * b for a, b in zip(row, column, strict=True) if a.numerator and b.numerator]
                or [row[0] - row[0]]
            ).cancelled(norms)
            for column in columns
        ]
        for row in left
    ]
