"""Stress points: always the same, of each sort, and inside the doubles."""

import math

import pytest
from sympy import ImmutableDenseMatrix, S

from kousoku.codegen.freeze_components import freeze_components
from kousoku.codegen.points import finite_points, infinite_points, ordinary
from kousoku.codegen.sha256_random import Sha256Random
from kousoku.model.files.quantity import Quantity
from kousoku.model.numbers.dual import evaluate_dual
from kousoku.model.operations.kernel import Kernel
from kousoku.symbolic import derive
from kousoku.symbolic.derivation import DerivedOutput, Function
from kousoku.symbolic.matrices import elements


@pytest.fixture(scope="module")
def components() -> Kernel:
    return freeze_components(derive("n2").functions[0])


def test_a_seed_fixes_the_numbers() -> None:
    stream = Sha256Random("seed")
    assert [stream.integer(8) for _ in range(4)] == [162, 124, 30, 224]
    assert stream.magnitude() == 1.8858182134191406


def test_magnitudes_lie_between_a_half_and_two() -> None:
    stream = Sha256Random("magnitudes")
    numbers = [stream.magnitude() for _ in range(200)]
    assert 0.5 <= min(numbers) < 0.6
    assert 1.8 < max(numbers) < 2


def test_ordinary_euler_parameters_are_of_unit_norm_and_lengths_positive() -> None:
    inputs = (
        Quantity("p_i", (4,), "-", ""),
        Quantity("length", (), "m", ""),
        Quantity("masses", (3,), "kg", ""),
    )
    numbers = ordinary(inputs, Sha256Random("s"))
    assert math.isclose(math.hypot(*numbers["p_i"]), 1, rel_tol=1e-15)
    assert min(numbers["length"] + numbers["masses"]) > 0


def test_each_sort_of_point_is_there(components: Kernel) -> None:
    labels = [point.label for point in finite_points(components, Sha256Random("s"), 0)]
    assert labels == [
        "ordinary",
        "badly scaled arrays",
        "badly scaled elements",
        "nearly coincident",
        "near half a turn, near an axis",
        "small integers",
        "r_i is zero",
        "p not normalised",
        "subnormal r_i, s_i_b, r_j, s_j_b",
    ]


def test_all_turns_stay_inside_the_doubles(components: Kernel) -> None:
    for turn in range(4):
        for point in finite_points(components, Sha256Random("s"), turn):
            for duals in evaluate_dual(components, point.inputs).values():
                assert all(abs(dual.value) < 1e300 for dual in duals), point.label


def test_badly_scaled_points_are_badly_scaled(components: Kernel) -> None:
    for turn in range(4):
        points = finite_points(components, Sha256Random("s"), turn)
        for point in points[1:3]:
            numbers = [abs(x) for xs in point.inputs.values() for x in xs]
            assert max(numbers) / min(numbers) > 1e30


def test_subnormal_points_hold_subnormals_only_where_products_stay_exact(
    components: Kernel,
) -> None:
    point = finite_points(components, Sha256Random("s"), 0)[-1]
    assert 0 < max(map(abs, point.inputs["r_i"])) < 1e-316
    assert all(x == int(x) for x in point.inputs["p_i"])


def test_points_that_are_not_finite_hold_one_bad_number_each(components: Kernel) -> None:
    points = infinite_points(components, Sha256Random("s"))
    bad = [[x for xs in p.inputs.values() for x in xs if not math.isfinite(x)] for p in points]
    assert [str(x) for (x,) in bad] == ["nan", "inf", "-inf"]


def test_body_j_comes_close_to_body_i_but_its_directions_keep_apart() -> None:
    axis, place = (
        (Quantity(f"{name}_i_b", (3,), unit, ""), Quantity(f"{name}_j_b", (3,), unit, ""))
        for name, unit in (("hinge", "-"), ("pin", "m"))
    )
    jaw = Quantity("x_jaw", (3,), "m", "")
    inputs = (*axis, *place, Quantity("p_i", (4,), "-", ""), Quantity("p_j", (4,), "-", ""), jaw)
    names = [(a.name, b.name) for a, b in ((inputs[0], inputs[1]), (inputs[2], inputs[3]))]
    x = [elements(q)[0] for q in inputs]
    output = DerivedOutput(
        Quantity("f", (), "m", ""), S.Zero, ImmutableDenseMatrix([sum(x, S.Zero)])
    )
    components = freeze_components(Function("f", "", "", "", inputs, (output,)))
    (point,) = (
        p for p in finite_points(components, Sha256Random("s"), 0) if p.label == "nearly coincident"
    )

    def is_close(one: str, two: str) -> bool:
        pairs = zip(point.inputs[one], point.inputs[two], strict=True)
        return all(math.isclose(a, b, rel_tol=1e-8) for a, b in pairs)

    assert [is_close(*pair) for pair in (*names, ("p_i", "p_j"))] == [False, True, True]
