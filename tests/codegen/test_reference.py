"""References: values in 50 digits, told in the unit that no algorithm can beat."""

import json
import math
from dataclasses import replace
from fractions import Fraction
from typing import Any

import pytest
import sympy

from kousoku.codegen.freeze import freeze
from kousoku.codegen.known_errors import known_errors
from kousoku.codegen.reference import references
from kousoku.model.errors import DerivationError
from kousoku.model.files.quantity import Quantity
from kousoku.model.operations.arithmetic import EXACT
from kousoku.model.operations.graph import Graph
from kousoku.model.operations.interpret import evaluate
from kousoku.model.operations.kernel import Kernel, Package
from kousoku.symbolic import derive
from kousoku.symbolic.derivation import Derivation, DerivedOutput, Function
from kousoku.symbolic.matrices import elements


@pytest.fixture(scope="module")
def n1() -> Derivation:
    return derive("n1")


@pytest.fixture(scope="module")
def package(n1: Derivation) -> Package:
    return Package("n1", "", "", tuple(freeze(function) for function in n1.functions))


@pytest.fixture(scope="module")
def data(n1: Derivation, package: Package) -> Any:
    return json.loads(references(package, n1.functions))


def test_high_and_low_are_the_exact_value(package: Package, data: Any) -> None:
    for kernel, referred in zip(package.kernels, data["kernels"], strict=True):
        assert kernel.name == referred["name"]
        for point in referred["points"]:
            if any(isinstance(x, str) for xs in point["inputs"].values() for x in xs):
                continue
            inputs = {name: [Fraction(x) for x in xs] for name, xs in point["inputs"].items()}
            exact = evaluate(kernel, inputs, EXACT)
            for k, output in enumerate(kernel.outputs):
                columns = point["outputs"][output.name]
                for element, high, low, unit in zip(
                    kernel.nonzero(k), columns["high"], columns["low"], columns["unit"], strict=True
                ):
                    error = exact[output.name][element] - Fraction(high) - Fraction(low)
                    assert abs(error) <= Fraction(unit) / 1000 + Fraction(5e-324) / 2


def test_bad_inputs_reach_the_outputs_that_depend_on_them_and_no_others(
    package: Package, data: Any
) -> None:
    kernel, referred = package.kernels[0], data["kernels"][0]
    bad_points = [
        point
        for point in referred["points"]
        if any(isinstance(x, str) for xs in point["inputs"].values() for x in xs)
    ]
    assert len(bad_points) == 3
    for point in bad_points:
        highs = point["outputs"]["C_q"]["high"]
        assert None in highs + point["outputs"]["C"]["high"]
        assert len(highs) == len(kernel.nonzero(1)) == 6


def test_each_point_says_why_it_is_there(data: Any) -> None:
    labels = {point["label"] for point in data["kernels"][0]["points"]}
    assert {"ordinary", "on the manifold", "near the manifold", "p not normalised"} <= labels


def difference() -> tuple[Package, Function]:
    """Build f = (a − b) c, and g = b, whose errors and dependences are known by hand."""
    graph = Graph()
    inputs = tuple(Quantity(name, (1,), "m", "") for name in "abc")
    a, b, c = (graph.input(name, 0) for name in "abc")
    product = graph.mul(graph.sub(a, b), c)
    outputs = (Quantity("f", (2,), "m^2", ""), Quantity("g", (1,), "m", ""))
    kernel = Kernel(
        "k", "", "", "", inputs, outputs, tuple(graph.nodes), ((product, graph.const(0)), (b,))
    )
    (sa,), (sb,), (sc,) = (elements(quantity) for quantity in inputs)
    function = Function(
        "k",
        "",
        "",
        "",
        inputs,
        (
            DerivedOutput(
                outputs[0], sympy.S.Zero, sympy.ImmutableDenseMatrix([(sa - sb) * sc, 0])
            ),
            DerivedOutput(outputs[1], sympy.S.Zero, sympy.ImmutableDenseMatrix([sb])),
        ),
    )
    return Package(
        "difference",
        "",
        "",
        (replace(kernel, nodes=tuple(graph.nodes)),),
    ), function


def test_the_unit_is_the_rounding_of_inputs_and_output() -> None:
    package, function = difference()
    (kernel,) = json.loads(references(package, [function]))["kernels"]
    for point in kernel["points"]:
        if any(isinstance(x, str) for xs in point["inputs"].values() for x in xs):
            continue
        (a,), (b,), (c,) = point["inputs"].values()
        wanted = 2.0**-53 * (2 * abs((a - b) * c) + abs(a * c) + abs(b * c))
        (unit,) = point["outputs"]["f"]["unit"]
        assert math.isclose(unit, max(wanted, 5e-324), rel_tol=0.006)


def test_only_elements_that_can_be_nonzero_are_listed() -> None:
    package, function = difference()
    (kernel,) = json.loads(references(package, [function]))["kernels"]
    assert all(len(point["outputs"]["f"]["high"]) == 1 for point in kernel["points"])


def test_a_frozen_zero_that_the_component_level_denies_is_an_error() -> None:
    package, function = difference()
    (kernel,) = package.kernels
    zero = next(k for k, node in enumerate(kernel.nodes) if node.value == 0)
    wrong = replace(kernel, results=((zero, zero), kernel.results[1]))
    with pytest.raises(DerivationError, match="element 0 of f in kernel k is frozen to zero"):
        references(replace(package, kernels=(wrong,)), [function])


def test_equal_derivations_give_equal_bytes(n1: Derivation, package: Package) -> None:
    assert references(package, n1.functions) == references(package, derive("n1").functions)


def test_an_error_that_is_known_may_not_grow(
    n1: Derivation, package: Package, monkeypatch: pytest.MonkeyPatch
) -> None:
    (known,) = known_errors(package, "rates")
    better = {("n1", "rates"): (replace(known, units={"gamma": known.units["gamma"] - 1}),)}
    monkeypatch.setattr("kousoku.codegen.known_errors.KNOWN", better)
    with pytest.raises(DerivationError, match=r"gamma is 117\.6 units off where 116\.63 are known"):
        references(package, n1.functions)
