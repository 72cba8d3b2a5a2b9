"""Numbers of 50 digits with the formula that they came from."""

from __future__ import annotations

import math
import operator
import pickle
from copy import deepcopy
from typing import Any

import pytest

from kousoku.model.expressions.parser import parse_expression
from kousoku.model.expressions.values import value_of
from kousoku.model.lowering.mass import principal
from kousoku.model.numbers import precise
from kousoku.model.numbers.traced import Traced, at_scene, parameter, traced
from kousoku.model.numbers.varying import Varying, fixed, is_varying
from kousoku.model.records.design import Formula

VALUES = {"m": 2.0, "L": 1.5, "z": 0.0, "a": 0.5}
M, L, Z, A = (parameter(name, value, k) for k, (name, value) in enumerate(VALUES.items()))


def test_a_computed_number_has_the_formula_that_gives_it() -> None:
    found = precise.sqrt(M * L * L / 12 + abs(-A)) - precise.atan2(A, 3 - L) ** 2
    assert isinstance(found, Traced)
    other = {"m": 0.7, "L": 3.0, "z": 1.0, "a": -0.25}
    wanted = math.sqrt(0.7 * 9 / 12 + 0.25) - math.atan2(-0.25, 0.0) ** 2
    assert value_of(found.expression, other) == pytest.approx(wanted, rel=1e-14)
    assert float(at_scene(found)) == pytest.approx(value_of(found.expression, VALUES), rel=1e-15)


def test_what_does_not_depend_on_parameters_is_a_number() -> None:
    sine, cosine = (
        traced(parse_expression(text, VALUES), {"a": A}) for text in ("sin(a)", "cos(a)")
    )
    found = (
        M / M,
        M + L - M - L,
        sine * sine + cosine * cosine,
        0 * L,
        (A * M) ** 2 / (M * A) / M / A,
    )
    assert [float(x) for x in found] == [1.0, 0.0, 1.0, 0.0, 1.0]


@pytest.mark.parametrize(
    ("text", "other", "wanted"),
    [
        ("2 * max(m, 5)", {"m": 7.0}, 14.0),
        ("min(m, L) - L", {"m": 1.0}, -0.5),
        ("abs(a) - a", {"a": -0.25}, 0.5),
        ("a / sqrt(a^2)", {"a": -0.25}, -1.0),
        ("(a^2)^0.5 / a", {"a": -0.25}, -1.0),
        ("sign(a - 3)", {"a": 4.0}, 1.0),
        ("asin(sin(a)) - a", {"a": 3.0}, math.pi - 6.0),
        ("atan2(sin(a), cos(a)) - a", {"a": 4.0}, -2 * math.pi),
    ],
)
def test_what_is_fixed_near_the_scene_only_still_depends_on_parameters(
    text: str, other: dict[str, float], wanted: float
) -> None:
    found = traced(parse_expression(text, VALUES), {"m": M, "L": L, "a": A}) * 1
    assert isinstance(found, Traced)
    assert value_of(found.expression, VALUES | other) == pytest.approx(wanted)


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("2 + sin(exp(exp(1000*z)))", 2 + math.sin(math.e)),
        ("2 + sin((1 + z)^1e30)", 2 + math.sin(1)),
        ("a + exp(-1e49)", 0.5),
        ("a + atan2(0.5^1e9, 1)", 0.5),
    ],
)
def test_numbers_that_no_double_has_cost_no_time(text: str, wanted: float) -> None:
    found = traced(parse_expression(text, VALUES), {"z": Z, "a": A})
    assert float(at_scene(found)) == pytest.approx(wanted, rel=1e-14)


def test_zero_in_the_scene_is_not_zero_for_good() -> None:
    assert Z != 0
    assert bool(Z)
    assert isinstance(Z * M, Traced)
    assert is_varying(precise.rounded((Z, M, precise.number(1.0)))[0])


def test_comparisons_take_the_value_of_the_scene() -> None:
    assert Z < A < 1 < L < M
    assert max((A, L, Z)) is L
    assert M >= 2


def test_a_double_of_a_formula_is_compared_and_never_computed_with() -> None:
    x = precise.double(M * L)
    assert isinstance(x, Varying)
    assert x > 2.0
    assert x != 3.0
    assert float(x) == 3.0
    assert x == precise.double(M * L)
    assert x != precise.double(M + L)
    assert deepcopy(x) is x
    for compute in (operator.add, operator.sub, operator.mul, operator.truediv, operator.pow):
        for pair in ((x, 2.0), (2.0, x)):
            with pytest.raises(TypeError, match="depends on parameters"):
                compute(*pair)
    with pytest.raises(TypeError):
        float(M)
    assert fixed((x, 1.0)) == (3.0, 1.0)
    assert pickle.loads(pickle.dumps(Formula("m", 2.0))) == Formula("m", 2.0)


def test_principal_axes_that_parameters_do_not_turn_are_those_of_the_scene() -> None:
    tensor = [[2 * M, M / 2, 0 * M], [M / 2, 3 * M, 0 * M], [0 * M, 0 * M, 4 * M]]
    moments, p = principal(tensor)
    assert not any(isinstance(x, Traced) for x in p)
    assert all(isinstance(x, Traced) for x in moments)
    plain, _ = principal([[at_scene(x) for x in row] for row in tensor])
    for found, wanted in zip(moments, plain, strict=True):
        assert isinstance(found, Traced)
        assert abs(at_scene(found) - wanted) < 1e-45
        assert value_of(found.expression, VALUES | {"m": 1.0}) == pytest.approx(wanted / 2)


@pytest.mark.parametrize("element", [M / 5, -M / 5, Z])
def test_one_product_of_inertia_is_cleared_for_all_parameters(element: Traced) -> None:
    zero = precise.number(0.0)
    tensor = [[M, element, zero], [element, L, zero], [zero, zero, M + L]]
    moments, p = principal(tensor)
    rows = [
        precise.rotate_back(p, precise.triple(row)) for row in ((1, 0, 0), (0, 1, 0), (0, 0, 1))
    ]
    for k in range(3):
        values = {"m": 1.25, "L": 2.5, "z": 0.125, "a": 0.5}
        a = [[_value(x, values) for x in row] for row in tensor]
        axis = [_value(x, values) for x in rows[k]]
        moment = _value(moments[k], values)
        image = [sum(a[i][j] * axis[j] for j in range(3)) for i in range(3)]
        assert image == pytest.approx([moment * x for x in axis], abs=1e-14)


def _value(number: Any, values: dict[str, float]) -> float:
    return value_of(number.expression, values) if isinstance(number, Traced) else float(number)
