"""The prover: both levels are carried into one ring of polynomials, where equal means equal.

A number is a fraction of two polynomials with rational coefficients. Square roots, sines, cosines
and angles are generators of their own, with the one relation that holds between them:
(√x)² = x and cos² = 1 − sin². Fractions are compared by clearing denominators. Nothing is
evaluated at points, and nothing is rounded.
"""

from __future__ import annotations

from dataclasses import dataclass
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
from kousoku.model.quantity import Quantity
from kousoku.symbolic.components import Flow, half_turn
from kousoku.symbolic.matrices import (
    Dot,
    Named,
    NamedScalar,
    Orientation,
    Skew,
    coefficient_and_factors,
    elements,
    quadratic_form,
)

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from kousoku.symbolic.derivation import Derivation, Function

Polynomial = Any
Rows = list[list["Fraction"]]

#: Generators kept ready for square roots, sines, cosines and angles.
SPARE = 16


@dataclass(frozen=True, slots=True)
class Fraction:
    """A fraction of two polynomials; common factors stay."""

    over: Polynomial
    under: Polynomial

    def __add__(self, other: Fraction) -> Fraction:
        if self.under == other.under:
            return Fraction(self.over + other.over, self.under)
        if not self.over:
            return other
        if not other.over:
            return self
        return Fraction(self.over * other.under + other.over * self.under, self.under * other.under)

    def __sub__(self, other: Fraction) -> Fraction:
        return self + Fraction(-other.over, other.under)

    def __mul__(self, other: Fraction) -> Fraction:
        return Fraction(self.over * other.over, self.under * other.under)

    def __rmul__(self, number: int) -> Fraction:
        return Fraction(number * self.over, self.under)


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
    """

    def __init__(
        self,
        quantities: Sequence[Quantity],
        matrices: Mapping[str, Any] | None = None,
        *,
        is_unit: bool = False,
    ) -> None:
        self._is_unit = is_unit
        self._symbols = [symbol for q in quantities for symbol in elements(q)]
        names = [*(str(s) for s in self._symbols), *(f"extra {k}" for k in range(SPARE))]
        self._ring, *generators = ring(names, QQ)
        self._one = self._ring.one
        n = len(self._symbols)
        self._scalars: dict[Any, Fraction] = {
            s: Fraction(g, self._one) for s, g in zip(self._symbols, generators[:n], strict=True)
        }
        self._spare = generators[n:]
        self._functions: list[tuple[str, tuple[Fraction, ...], Fraction]] = []
        self._squares: list[tuple[Polynomial, Polynomial, Polynomial]] = []
        self._quantities = {q.name: q for q in quantities}
        self._given = dict(matrices or {})
        self._memo: dict[Any, Rows] = {}

    # -- numbers -------------------------------------------------------------------------------

    def scalar(self, x: Any) -> Fraction:
        """Return a scalar expression of either level."""
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
            case Dot() if self._is_unit and x.args[0] == x.args[1] and x.args[0].shape == (4, 1):
                return self.scalar(sympy.S.One)
            case Dot():
                ((value,),) = _product(_transposed(self.matrix(x.args[0])), self.matrix(x.args[1]))
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
        over, under = (x.over, x.under) if n > 0 else (x.under, x.over)
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
            self._squares.append((value.over, args[0].over, args[0].under))
        if name == "cos":
            sine = self._function("sin", args).over
            self._squares.append((value.over, self._one - sine**2, self._one))
        return value

    def _reduced(self, x: Fraction) -> Fraction:
        """Replace the squares of roots and cosines."""
        over, under = x.over, x.under
        for generator, square_over, square_under in reversed(self._squares):
            over, factor = _without_squares(over, generator, square_over, square_under)
            under = under * factor
            under, factor = _without_squares(under, generator, square_over, square_under)
            over = over * factor
        return Fraction(over, under)

    def is_equal(self, x: Fraction, y: Fraction) -> bool:
        """Return whether two numbers are the same for all values of the inputs."""
        if x.under == y.under and x.over == y.over:
            return True
        difference = Fraction(x.over * y.under - y.over * x.under, self._one)
        return not self._reduced(self._reduced(difference)).over

    # -- matrices ------------------------------------------------------------------------------

    def matrix(self, x: Any) -> Rows:
        """Return the elements of a matrix-level expression."""
        known = self._memo.get(x)
        if known is None:
            known = self._memo[x] = self._matrix(x)
        return known

    def _matrix(self, x: Any) -> Rows:
        match x:
            case MatrixSymbol():
                return self._array(x)
            case Named():
                return self.matrix(x.value)
            case Orientation():
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
                rows, columns = x.blockshape
                blocks = [
                    [self.matrix(x.blocks[i, j]) for j in range(columns)] for i in range(rows)
                ]
                return [
                    [cell for block in row for cell in block[k]]
                    for row in blocks
                    for k in range(len(row[0]))
                ]
        raise DerivationError(f"proof: no rule for {type(x).__name__} in {x}")

    def _orientation(self, p: list[Fraction]) -> Rows:
        form = quadratic_form(p)
        if not self._is_unit:
            return form
        square = _sum([e * e for e in p])
        return [[Fraction(cell.over, square.over) for cell in row] for row in form]

    def _array(self, x: Any) -> Rows:
        rows, columns = (int(n) for n in x.shape)
        if x.name in self._given:
            flat = [self.scalar(value) for value in self._given[x.name]]
        elif x.name in self._quantities:
            flat = [self.scalar(value) for value in elements(self._quantities[x.name])]
        else:
            raise DerivationError(f"proof: {x.name} is not among the inputs")
        return [flat[i * columns : (i + 1) * columns] for i in range(rows)]

    def _scaled_product(self, x: Any) -> Rows:
        scalar, factors = coefficient_and_factors(x)
        matrices = [self.matrix(factor) for factor in factors]
        while len(matrices) > 1:  # start at the narrow end
            if len(matrices[-1][0]) <= len(matrices[0]):
                matrices[-2:] = [_product(matrices[-2], matrices[-1])]
            else:
                matrices[:2] = [_product(matrices[0], matrices[1])]
        value = self.scalar(scalar)
        return [[self._reduced(value * cell) for cell in row] for row in matrices[0]]


def _without_squares(
    x: Polynomial, generator: Polynomial, over: Polynomial, under: Polynomial
) -> tuple[Polynomial, Polynomial]:
    """Return x·f and f, f a power of ``under``, where generator² = over / under."""
    place = x.ring.gens.index(generator)
    highest = max((powers[place] for powers in x), default=0) // 2
    if highest == 0:
        return x, x.ring.one
    result = x.ring.zero
    for half in range(highest + 1):
        part = x.ring.zero
        for powers, value in x.terms():
            if powers[place] // 2 == half:
                rest = (*powers[:place], powers[place] % 2, *powers[place + 1 :])
                part[rest] = part.get(rest, QQ.zero) + value
        result += part * over**half * under ** (highest - half)
    return result, under**highest


def _sum(terms: list[Fraction]) -> Fraction:
    total = terms[0]
    for term in terms[1:]:
        total = total + term
    return total


def _transposed(rows: Rows) -> Rows:
    return [list(column) for column in zip(*rows, strict=True)]


def _product(left: Rows, right: Rows) -> Rows:
    columns = _transposed(right)
    return [
        [
            _sum(
                [a * b for a, b in zip(row, column, strict=True) if a.over and b.over]
                or [row[0] - row[0]]
            )
            for column in columns
        ]
        for row in left
    ]


def _cells(carrier: Ring, x: Any) -> list[Fraction]:
    if not getattr(x, "is_Matrix", False):
        return [carrier.scalar(x)]
    return [cell for row in carrier.matrix(x) for cell in row]


def prove(function: Function) -> int:
    """Prove that both levels of every output agree, for all values of the inputs.

    Parameters
    ----------
    function : Function
        Its matrix level against its component level.

    Returns
    -------
    int
        How many elements were proved equal.

    Raises
    ------
    DerivationError
        Names the first element that differs.
    """
    carrier = Ring(function.inputs)
    count = 0
    for output in function.outputs:
        cells = _cells(carrier, output.expression)
        for k, (cell, component) in enumerate(zip(cells, output.components, strict=True)):
            if not carrier.is_equal(cell, carrier.scalar(component)):
                raise DerivationError(
                    f"{function.name}: the two levels differ in {output.quantity.name}, element "
                    f"{k} of {output.quantity.size}; correct the derivation of one of them"
                )
            count += 1
    return count


def prove_steps(derivation: Derivation) -> int:
    """Prove that the lines of a derivation follow from each other.

    Two lines with the same left-hand side must have equal right-hand sides; where the left-hand
    side is itself a formula, it must equal the right. δA is what the component level gives. An
    identity that fails for Euler parameters of any norm must hold for those of norm one.

    Parameters
    ----------
    derivation : Derivation
        Its steps. Those on assembled systems, whose sizes are letters, are left out.

    Returns
    -------
    int
        How many equalities were proved.

    Raises
    ------
    DerivationError
        Names the first step that does not follow.
    """
    before: dict[Any, Any] = {}
    count = 0
    for number, step in enumerate(derivation.steps, 1):
        left = step.left
        if any(not size.is_Integer for s in step.right.atoms(MatrixSymbol) for size in s.shape):
            continue
        if isinstance(left, MatrixSymbol | sympy.Symbol | NamedScalar):
            left, before[step.left] = before.get(step.left), step.right
        if left is None:
            continue
        if not any(_agree(left, step.right, is_unit=is_unit) for is_unit in (False, True)):
            raise DerivationError(
                f"{derivation.name}: step {number} does not follow: {step.rule}; correct it"
            )
        count += 1
    return count


def _agree(left: Any, right: Any, *, is_unit: bool) -> bool:
    """Return whether two formulas are equal for all values of their symbols."""
    symbols = sorted(
        left.atoms(MatrixSymbol, sympy.Symbol) | right.atoms(MatrixSymbol, sympy.Symbol), key=str
    )
    quantities = []
    variations: dict[str, Any] = {}
    for s in symbols:
        shape = tuple(int(n) for n in s.shape) if isinstance(s, MatrixSymbol) else ()
        if s.name.startswith("δA"):
            variations[s.name] = s.name.removeprefix("δA")
        else:
            quantities.append(Quantity(s.name, shape, "", ""))
    known = {q.name for q in quantities}
    for body in variations.values():
        for name, shape in ((f"p{body}", (4, 1)), (_virtual_rotation(body, known), (3, 1))):
            if name not in known:
                quantities.append(Quantity(name, shape, "", ""))
                known.add(name)
    given = {
        name: _varied_orientation(f"p{body}", _virtual_rotation(body, known), is_unit=is_unit)
        for name, body in variations.items()
    }
    carrier = Ring(quantities, given, is_unit=is_unit)
    pairs = zip(_cells(carrier, left), _cells(carrier, right), strict=True)
    return all(carrier.is_equal(a, b) for a, b in pairs)


def _virtual_rotation(body: str, known: set[str]) -> str:
    """Return the name of δθ′ of a body: an input of the rotation, or a column of a constraint."""
    return "dtheta_b" if not body or "dtheta_b" in known else f"δθ{body}_b"


def _varied_orientation(p_name: str, theta_name: str, *, is_unit: bool) -> list[Any]:
    """Return δA by differentiating A(p) along ½ p∘(0, δθ′)."""
    p = elements(Quantity(p_name, (4,), "", ""))
    theta = elements(Quantity(theta_name, (3,), "", ""))
    flow = Flow(dict(zip(p, half_turn(p, theta), strict=True)), (*p, *theta))
    square = sum((e**2 for e in p), sympy.S.Zero) if is_unit else sympy.S.One
    return [flow(cell) / square for row in quadratic_form(p) for cell in row]
