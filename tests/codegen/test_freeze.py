"""Freezing keeps the meaning of every derivation, exactly, and costs few operations."""

from __future__ import annotations

from fractions import Fraction as Rational
from functools import cache
from typing import TYPE_CHECKING, Any

import pytest
import sympy
from sympy.matrices.expressions import HadamardProduct, MatrixSymbol
from sympy.matrices.immutable import ImmutableDenseMatrix

from kousoku.codegen.freeze import freeze
from kousoku.model.errors import FreezeError
from kousoku.model.files.quantity import Quantity
from kousoku.model.operations.graph import Op
from kousoku.symbolic import KINDS, derive
from kousoku.symbolic.derivation import DerivedOutput, Function
from kousoku.symbolic.fractions import Fraction
from kousoku.symbolic.matrices import (
    NamedMatrix,
    OrientationMatrix,
    elements,
    mul,
    skew,
    transpose,
    vector,
)
from kousoku.symbolic.ring import Ring

if TYPE_CHECKING:
    from kousoku.model.operations.kernel import Kernel
    from kousoku.symbolic.derivation import Derivation

PACKAGES = [package for kind in KINDS.values() for package in kind.packages]
A_B = Quantity("a_b", (3,), "-", "a vector")
S_B = Quantity("s_b", (3,), "m", "another vector")
P = Quantity("p", (4,), "-", "Euler parameters")
LENGTH = Quantity("length", (), "m", "a number")


@pytest.fixture(scope="module", name="derived")
def _derived() -> Any:
    return cache(derive)


def function_of(expression: Any, shape: tuple[int, ...], *inputs: Quantity) -> Function:
    output = DerivedOutput(
        Quantity("x", shape, "-", ""), expression, ImmutableDenseMatrix(0, 1, [])
    )
    return Function("trial", "", "", "", inputs, (output,))


def carried(kernel: Kernel, carrier: Ring) -> list[list[Fraction]]:
    """Elements of all outputs as fractions of polynomials: nothing is rounded."""
    symbols = {q.name: elements(q) for q in kernel.inputs}
    values: list[Fraction] = []
    for node in kernel.nodes:
        args = [values[k] for k in node.args]
        match node.op:
            case Op.CONST:
                assert node.value is not None
                number = sympy.Rational(node.value.numerator, node.value.denominator)
                values.append(carrier.scalar(number))
            case Op.INPUT:
                assert node.symbol is not None
                values.append(carrier.scalar(symbols[node.symbol[0]][node.symbol[1]]))
            case Op.ADD:
                values.append(args[0] + args[1])
            case Op.SUB:
                values.append(args[0] - args[1])
            case Op.NEG:
                values.append(-1 * args[0])
            case Op.MUL:
                values.append(args[0] * args[1])
            case Op.DIV:
                a, b = args
                quotient = Fraction(a.numerator * b.denominator, a.denominator * b.numerator)
                values.append(quotient)
            case _:
                pytest.fail(f"{kernel.name} holds {node.op}")
    return [[values[node] for node in result] for result in kernel.results]


@pytest.mark.parametrize("package", [p for p in PACKAGES if p not in {"link", "distance"}])
def test_frozen_kernel_is_the_derived_polynomial(package: str, derived: Any) -> None:
    derivation: Derivation = derived(package)
    for function in derivation.functions:
        kernel = freeze(function)
        if Op.SQRT in kernel.operations or Op.DIV in kernel.operations:
            continue  # roots and quotients are compared with 50 digits elsewhere
        carrier = Ring(function.inputs)
        for output, cells in zip(function.outputs, carried(kernel, carrier), strict=True):
            for cell, component in zip(cells, output.components, strict=True):
                assert carrier.is_equal(cell, carrier.scalar(component))


@pytest.mark.parametrize(
    ("package", "kernel", "products", "sums"),
    [
        ("p2_z", "constraint", 101, 84),
        ("p1_z", "constraint", 104, 74),
        ("n1", "constraint", 77, 58),
        ("n2", "constraint", 81, 71),
        ("point", "constraint", 80, 65),
        ("p2_z", "rates", 117, 97),
        ("p2_z", "reaction", 176, 143),
        ("rotation", "orientation", 13, 13),
    ],
)
def test_kernels_cost_few_operations(
    package: str, kernel: str, products: int, sums: int, derived: Any
) -> None:
    (function,) = (f for f in derived(package).functions if f.name == kernel)
    counts = freeze(function).operations
    assert counts[Op.MUL] + counts[Op.DIV] <= products
    assert counts[Op.ADD] + counts[Op.SUB] + counts[Op.NEG] <= sums


@pytest.mark.parametrize("package", PACKAGES)
def test_no_node_is_left_that_no_output_needs(package: str, derived: Any) -> None:
    for function in derived(package).functions:
        kernel = freeze(function)
        used = {node for result in kernel.results for node in result}
        for k in reversed(range(len(kernel.nodes))):
            if k in used:
                used.update(kernel.nodes[k].args)
        assert used == set(range(len(kernel.nodes)))
        assert len(dict(kernel.names)) == len(kernel.names)
        assert len({name for _, name in kernel.names}) == len(kernel.names)


def test_elements_of_orientations_and_abbreviations_have_names(derived: Any) -> None:
    names = {name for _, name in freeze(derived("p2_z").functions[0]).names}
    assert {"A_i_11", "A_i_33", "A_j_12", "y_1", "y_2", "y_3"} <= names


def test_structural_zeros_are_constants(derived: Any) -> None:
    kernel = freeze(derived("n1").functions[0])
    assert kernel.nonzero(1) == (3, 4, 5, 9, 10, 11)
    assert freeze(derived("n1").functions[1]).nonzero(0) == ()


def test_products_shared_by_transposition_are_multiplied_out_once() -> None:
    a, s, into = vector("a_b"), vector("s_b"), transpose(OrientationMatrix(vector("p", 4)))
    one = function_of(mul(skew(a), into, s), (3,), A_B, P, S_B)
    both = DerivedOutput(
        Quantity("y", (1, 3), "-", ""),
        mul(transpose(s), transpose(into), skew(a)),
        ImmutableDenseMatrix(0, 1, []),
    )
    two = Function("trial", "", "", "", one.inputs, (*one.outputs, both))
    assert freeze(two).operations[Op.MUL] == freeze(one).operations[Op.MUL]


def test_scalar_quotients_and_powers_become_products() -> None:
    length = sympy.Symbol("length")
    kernel = freeze(function_of(3 * length**5 / (2 * length**2 + 1), (), LENGTH))
    assert kernel.operations == {Op.MUL: 5, Op.ADD: 1, Op.DIV: 1}


def test_half_powers_become_roots() -> None:
    length = sympy.Symbol("length")
    assert freeze(function_of(length ** sympy.Rational(-3, 2), (), LENGTH)).operations == {
        Op.SQRT: 1,
        Op.MUL: 1,
        Op.DIV: 1,
    }


def test_numbers_stay_exact() -> None:
    tenth = sympy.Rational(1, 10)
    kernel = freeze(function_of(sympy.Symbol("length") + tenth, (), LENGTH))
    assert [node.value for node in kernel.nodes if node.op is Op.CONST] == [Rational(1, 10)]


def test_unknown_matrix_node_is_named() -> None:
    a, s = vector("a_b"), vector("s_b")
    with pytest.raises(FreezeError, match="trial: HadamardProduct is not a node"):
        freeze(function_of(HadamardProduct(a, s), (3,), A_B, S_B))


def test_unknown_scalar_is_named() -> None:
    with pytest.raises(FreezeError, match="trial: exp is not a scalar"):
        freeze(function_of(sympy.exp(sympy.Symbol("length")), (), LENGTH))
    with pytest.raises(FreezeError, match="no integer or half-integer exponent"):
        freeze(function_of(sympy.Symbol("length") ** sympy.Rational(1, 3), (), LENGTH))


def test_symbols_that_are_no_inputs_are_named() -> None:
    with pytest.raises(FreezeError, match=r"b \(3, 1\) is not among the inputs a_b"):
        freeze(function_of(MatrixSymbol("b", 3, 1), (3,), A_B))
    with pytest.raises(FreezeError, match="the scalar l is not among the inputs length"):
        freeze(function_of(sympy.Symbol("l"), (), LENGTH))


def test_output_of_another_size_is_refused() -> None:
    with pytest.raises(FreezeError, match=r"output x has shape \(2,\), but its expression has 3"):
        freeze(function_of(NamedMatrix("n", vector("a_b")), (2,), A_B))
