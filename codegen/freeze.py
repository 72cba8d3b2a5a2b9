"""Scalar graph of the matrix level of a derivation; SymPy is left behind here.

Every node of ``symbolic.matrices`` is lowered to a matrix of graph nodes by one walk with a memo.
A product is associated in the cheapest order, zeros known; partial products that several products
share count once. The order of terms is that of the derivation, and inside scalar formulas that of
``symbolic.matrices.description``, so that the same bytes come out under every version of SymPy.
"""

from __future__ import annotations

from fractions import Fraction
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

from kousoku.codegen.matrix_chain import Association, Cells, flip
from kousoku.codegen.passes.rebuild import drop_dead
from kousoku.model.errors import FreezeError
from kousoku.model.numbers.real import SMALLEST_SUBNORMAL
from kousoku.model.operations.graph import Graph, Op
from kousoku.model.operations.kernel import Kernel
from kousoku.symbolic.matrices import (
    Divisor,
    Dot,
    NamedMatrix,
    NamedScalar,
    OrientationMatrix,
    Skew,
    coefficient_and_factors,
    description,
    mul,
    symbol,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.model.files.quantity import Quantity
    from kousoku.symbolic.derivation import Function


def freeze(function: Function) -> Kernel:
    """Kernel of a derived function.

    Parameters
    ----------
    function : Function
        Its outputs are built from the nodes that ``symbolic.matrices`` lists.

    Returns
    -------
    Kernel
        The scalar operations that all outputs need, each once.

    Raises
    ------
    FreezeError
        An expression holds another node, or a symbol that is not an input.
    """
    lowering = _Lowering(function)
    results = tuple(lowering.output(output) for output in function.outputs)
    names = dict(reversed(lowering.names))  # the first name of a node wins
    kernel = Kernel(
        name=function.name,
        title=function.title,
        formula=function.formula,
        source=function.source,
        inputs=function.inputs,
        outputs=tuple(output.quantity for output in function.outputs),
        nodes=tuple(lowering.graph.nodes),
        results=results,
        names=tuple(sorted(names.items())),
    )
    return drop_dead(kernel)


class _Lowering:
    """Walk over the outputs of a function."""

    def __init__(self, function: Function) -> None:
        self.graph = Graph()
        self.names: list[tuple[int, str]] = []
        self._where = function.name
        self._inputs: dict[str, Quantity] = {q.name: q for q in function.inputs}
        self._memo: dict[Any, Cells] = {}
        self._scalars: dict[Any, int] = {}
        self._association = Association(self.graph)
        for quantity in function.inputs:
            for k in range(quantity.size):
                self.graph.input(quantity.name, k)
        orientations = {
            a for output in function.outputs for a in output.expression.atoms(OrientationMatrix)
        }
        for quantity in function.inputs:  # orientations first, in the order of the inputs
            if quantity.shape == (4,) and OrientationMatrix(symbol(quantity)) in orientations:
                self.matrix(OrientationMatrix(symbol(quantity)))
        products: dict[tuple[Any, ...], None] = {}
        for output in function.outputs:
            self._find_products(output.expression, products)
        self._association.expect(products)
        for factors in sorted(products, key=len):  # short products first: longer ones use them
            self._chain(factors)

    def output(self, output: Any) -> tuple[int, ...]:
        """Elements of an output, row-major."""
        expression, quantity = output.expression, output.quantity
        if not getattr(expression, "is_Matrix", False):
            return (self.scalar(expression),)
        cells = tuple(cell for row in self.matrix(expression) for cell in row)
        if len(cells) != quantity.size:
            raise FreezeError(
                f"{self._where}: output {quantity.name} has shape {quantity.shape}, but its "
                f"expression has {len(cells)} elements; give them the same size"
            )
        return cells

    def matrix(self, x: Any) -> Cells:
        """Graph nodes of the elements of a matrix expression."""
        cells = self._memo.get(x)
        if cells is None:
            cells = self._memo[x] = self._lower(x)
        return cells

    def _lower(self, x: Any) -> Cells:
        graph = self.graph
        match x:
            case MatrixSymbol():
                return self._input(x)
            case NamedMatrix():
                return self._name(x.name, self.matrix(x.value))
            case OrientationMatrix():
                return self._orientation(x)
            case Skew():
                ((a,), (b,), (c,)) = self.matrix(x.v)
                zero = graph.const(0)
                return (
                    (zero, graph.neg(c), b),
                    (c, zero, graph.neg(a)),
                    (graph.neg(b), a, zero),
                )
            case MatAdd():
                return self._sum([self.matrix(term) for term in x.args])
            case MatMul():
                return self._product(x)
            case Transpose():
                return tuple(zip(*self.matrix(x.arg), strict=True))
            case ZeroMatrix() | Identity():
                rows, columns = (int(n) for n in x.shape)
                one = int(isinstance(x, Identity))
                return tuple(
                    tuple(graph.const(one * (i == j)) for j in range(columns)) for i in range(rows)
                )
            case ImmutableDenseMatrix():
                return tuple(tuple(self.scalar(value) for value in row) for row in x.tolist())
            case BlockMatrix():
                return self._blocks(x)
        raise FreezeError(
            f"{self._where}: {type(x).__name__} is not a node of the matrix level, in {x}; "
            "use the nodes that symbolic.matrices lists"
        )

    def _input(self, x: Any) -> Cells:
        quantity = self._inputs.get(x.name)
        rows, columns = (int(n) for n in x.shape)
        if quantity is None or quantity.size != rows * columns:
            raise FreezeError(
                f"{self._where}: {x.name} ({rows}, {columns}) is not among the inputs "
                f"{', '.join(self._inputs)}; declare it with this shape"
            )
        return tuple(
            tuple(self.graph.input(x.name, i * columns + j) for j in range(columns))
            for i in range(rows)
        )

    def _name(self, name: str, cells: Cells) -> Cells:
        is_column = len(cells[0]) == 1
        for i, row in enumerate(cells, 1):
            for j, cell in enumerate(row, 1):
                if self.graph.nodes[cell].op not in {Op.CONST, Op.INPUT}:
                    self.names.append((cell, f"{name}_{i}" if is_column else f"{name}_{i}{j}"))
        return cells

    def _orientation(self, x: Any) -> Cells:
        """Elements of A(p) by ten products, with doubled e and shared sums of squares."""
        graph = self.graph
        e0, e1, e2, e3 = (cell for (cell,) in self.matrix(x.p))
        two = graph.const(2)
        d1, d2, d3 = graph.mul(two, e1), graph.mul(two, e2), graph.mul(two, e3)
        s0, s1, s2, s3 = (graph.mul(e, e) for e in (e0, e1, e2, e3))
        xy, xz, yz = graph.mul(d1, e2), graph.mul(d1, e3), graph.mul(d2, e3)
        wx, wy, wz = graph.mul(d1, e0), graph.mul(d2, e0), graph.mul(d3, e0)
        outer, inner = graph.sub(s0, s3), graph.sub(s1, s2)
        cells = (
            (graph.add(outer, inner), graph.sub(xy, wz), graph.add(xz, wy)),
            (graph.add(xy, wz), graph.sub(outer, inner), graph.sub(yz, wx)),
            (
                graph.sub(xz, wy),
                graph.add(yz, wx),
                graph.sub(graph.add(s0, s3), graph.add(s1, s2)),
            ),
        )
        return self._name("A" + x.p.name.removeprefix("p"), cells)

    def _sum(self, terms: Sequence[Cells]) -> Cells:
        rows, columns = len(terms[0]), len(terms[0][0])
        return tuple(
            tuple(self.graph.sum(term[i][j] for term in terms) for j in range(columns))
            for i in range(rows)
        )

    def _blocks(self, x: Any) -> Cells:
        rows, columns = x.blockshape
        return tuple(
            tuple(cell for cells in line for cell in cells)
            for i in range(rows)
            for line in zip(*(self.matrix(x.blocks[i, j]) for j in range(columns)), strict=True)
        )

    def _product(self, x: Any) -> Cells:
        scalar, factors = split(x)
        return self._scale(scalar, self._chain(factors))

    def _scale(self, scalar: Any, cells: Cells) -> Cells:
        if scalar == 1:
            return cells
        graph = self.graph
        numerator, denominator = sympy.fraction(scalar)
        if len(cells) == len(cells[0]) == 1 and not denominator.is_Number:
            product = graph.mul(self.scalar(numerator), cells[0][0])
            return ((graph.div(product, self.scalar(denominator)),),)
        if numerator == 1 and not denominator.is_Number:
            factor = self.scalar(denominator)
            return tuple(tuple(graph.div(cell, factor) for cell in row) for row in cells)
        factor = self.scalar(scalar)
        return tuple(tuple(graph.mul(factor, cell) for cell in row) for row in cells)

    def _chain(self, factors: tuple[Any, ...]) -> Cells:
        """Elements of a product of factors, in the cheapest association."""
        if len(factors) == 1:
            scalar, inner = coefficient_and_factors(factors[0])
            return self._scale(scalar, self.matrix(inner[0]))
        known = self._association.known(factors)
        if known is not None:
            return known
        operands = [self._chain((factor,)) for factor in factors]
        split_at = self._association.best(factors, operands)
        left, right = self._chain(factors[:split_at]), self._chain(factors[split_at:])
        cells = tuple(
            tuple(
                self.graph.sum(self.graph.mul(a, right[k][j]) for k, a in enumerate(row))
                for j in range(len(right[0]))
            )
            for row in left
        )
        self._association.keep(factors, cells)
        return cells

    def _find_products(self, x: Any, products: dict[tuple[Any, ...], None]) -> None:
        if isinstance(x, MatMul):
            _, factors = split(x)
            for factor in factors:
                self._find_products(factor, products)
            if len(factors) > 1 and flip(factors)[1] not in products:
                products[factors] = None
        elif not isinstance(x, ImmutableDenseMatrix):
            for arg in x.blocks if isinstance(x, BlockMatrix) else x.args:
                if getattr(arg, "is_Matrix", False):
                    self._find_products(arg, products)

    def scalar(self, x: Any) -> int:
        """Graph node of a scalar formula."""
        node = self._scalars.get(x)
        if node is None:
            node = self._scalars[x] = self._lower_scalar(x)
        return node

    def _lower_scalar(self, x: Any) -> int:
        graph = self.graph
        match x:
            case sympy.Rational():
                return graph.const(Fraction(int(x.p), int(x.q)))
            case sympy.Float():
                return graph.const(float(x))
            case sympy.Symbol():
                return self._scalar_input(x)
            case MatrixElement():
                return self.matrix(x.parent)[int(x.i)][int(x.j)]
            case NamedScalar():
                node = self.scalar(x.value)
                self.names.append((node, x.name))
                return node
            case Dot():
                return self._dot(*x.args)
            case Divisor():
                return graph.add(self.scalar(x.args[0]), graph.const(SMALLEST_SUBNORMAL))
            case sympy.Add():
                return graph.sum(self.scalar(arg) for arg in sorted(x.args, key=description))
            case sympy.Mul():
                return self._quotient(x)
            case sympy.Pow():
                return self._power(x)
            case sympy.sin() | sympy.cos() | sympy.atan2():
                return graph.apply(Op(type(x).__name__), [self.scalar(arg) for arg in x.args])
        raise FreezeError(
            f"{self._where}: {type(x).__name__} is not a scalar of the matrix level, in {x}; "
            "use the scalars that symbolic.matrices lists"
        )

    def _scalar_input(self, x: Any) -> int:
        if x.name not in self._inputs or self._inputs[x.name].shape:
            raise FreezeError(
                f"{self._where}: the scalar {x.name} is not among the inputs "
                f"{', '.join(self._inputs)}; declare it with shape ()"
            )
        return self.graph.input(x.name, 0)

    def _dot(self, u: Any, v: Any) -> int:
        graph = self.graph
        products = [
            graph.mul(a, b) for (a,), (b,) in zip(self.matrix(u), self.matrix(v), strict=True)
        ]
        if len(products) == 4:  # the sums of squares that A(p) has anyway
            s0, s1, s2, s3 = products
            return graph.add(graph.add(s0, s3), graph.add(s1, s2))
        return graph.sum(products)

    def _quotient(self, x: Any) -> int:
        numerator, denominator = sympy.fraction(x)
        if denominator != 1:
            return self.graph.div(self.scalar(numerator), self.scalar(denominator))
        product = self.graph.const(1)
        for arg in sorted(x.args, key=description):
            product = self.graph.mul(product, self.scalar(arg))
        return product

    def _power(self, x: Any) -> int:
        graph, (base, exponent) = self.graph, x.args
        if exponent.is_Rational and exponent < 0:
            return graph.div(graph.const(1), self.scalar(sympy.Pow(base, -exponent)))
        if exponent.is_Rational and exponent.q == 2:
            root = graph.sqrt(self.scalar(base))
            return graph.mul(root, self.scalar(base ** ((exponent.p - 1) // 2)))
        if not exponent.is_Integer:
            raise FreezeError(
                f"{self._where}: the power {x} has no integer or half-integer exponent"
            )
        half = self.scalar(base ** (exponent // 2)) if exponent > 1 else graph.const(1)
        square = graph.mul(half, half)
        return graph.mul(square, self.scalar(base)) if exponent % 2 else square


def split(x: Any) -> tuple[Any, tuple[Any, ...]]:
    """Scalar and factors of a product; a symbolic scalar goes to the cheapest factor.

    So d/l is divided once where several blocks hold it; a number stays for the result.
    """
    scalar, factors = coefficient_and_factors(x)
    if len(factors) == 1 or scalar.is_Rational:
        return scalar, factors
    sign = -1 if scalar.could_extract_minus_sign() else 1
    costs = [3 if isinstance(f, Skew) else int(f.shape[0] * f.shape[1]) for f in factors]
    cheapest = min(range(len(costs)), key=costs.__getitem__)
    scaled = mul(sign * scalar, factors[cheapest])
    return sympy.Integer(sign), (*factors[:cheapest], scaled, *factors[cheapest + 1 :])
