"""The graph interpreter in each of its arithmetics."""

from fractions import Fraction

import numpy as np
import pytest

from kousoku.model.files.quantity import Quantity
from kousoku.model.numbers.digits import CONTEXT, HIGH
from kousoku.model.operations.arithmetic import EXACT, FLOAT
from kousoku.model.operations.graph import Graph
from kousoku.model.operations.interpret import ARRAY, evaluate
from kousoku.model.operations.kernel import Kernel

#: Rational Euler parameters of unit norm, and vectors that they turn to right angles.
POINT = {
    "p_i": [Fraction(1, 2)] * 4,
    "a_i_b": [Fraction(1), Fraction(0), Fraction(0)],
    "p_j": [Fraction(3, 5), Fraction(0), Fraction(0), Fraction(4, 5)],
    "a_j_b": [Fraction(1), Fraction(2), Fraction(3)],
}


@pytest.fixture
def angle_kernel() -> Kernel:
    graph = Graph()
    angle, radius = graph.input("angle", 0), graph.input("radius", 0)
    x, y = graph.mul(radius, graph.cos(angle)), graph.mul(radius, graph.sin(angle))
    length = graph.sqrt(graph.add(graph.mul(x, x), graph.mul(y, y)))
    third = graph.mul(graph.const(Fraction(1, 3)), graph.atan2(y, x))
    return Kernel(
        "polar",
        "",
        "",
        "",
        (Quantity("angle", (), "rad", ""), Quantity("radius", (), "m", "")),
        (Quantity("length", (), "m", ""), Quantity("third", (), "rad", "")),
        tuple(graph.nodes),
        ((length,), (third,)),
    )


def test_fractions_are_exact(n1: Kernel) -> None:
    outputs = evaluate(n1, POINT, EXACT)
    # p_i turns x to y, y to z, z to x; p_j turns by the angle with cosine −7/25 and sine 24/25.
    assert list(outputs["a_i"]) == [0, 1, 0]
    assert outputs["C"] == (Fraction(24, 25) * 1 + Fraction(-7, 25) * 2,)


def test_floats_and_arrays_agree_bit_for_bit(n1: Kernel) -> None:
    rng = np.random.default_rng(1)
    batch = {q.name: list(rng.normal(size=(q.size, 5))) for q in n1.inputs}
    together = evaluate(n1, batch, ARRAY)
    for k in range(5):
        alone = evaluate(n1, {q: [float(x[k]) for x in v] for q, v in batch.items()}, FLOAT)
        assert alone["C"][0] == together["C"][0][k]


def test_fifty_digits_are_fifty_digits(angle_kernel: Kernel) -> None:
    mpf = CONTEXT.mpf
    angle, radius = mpf(3) / 7, mpf("1e-9")
    outputs = evaluate(angle_kernel, {"angle": [angle], "radius": [radius]}, HIGH)
    assert abs(outputs["third"][0] - angle / 3) < mpf("1e-49")
    assert abs(outputs["length"][0] / radius - 1) < mpf("1e-48")


def test_an_irrational_function_of_a_fraction_is_refused(angle_kernel: Kernel) -> None:
    with pytest.raises(ArithmeticError, match="not rational"):
        evaluate(angle_kernel, {"angle": [Fraction(1)], "radius": [Fraction(1)]}, EXACT)
