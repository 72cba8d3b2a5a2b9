"""Numbers with their derivatives by time: those of all functions, against differences."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest

from kousoku.codegen.dynamics.operations.jets import Jet, arithmetic_of
from kousoku.model.numbers.digits import CONTEXT, HIGH

if TYPE_CHECKING:
    from collections.abc import Callable

FUNCTIONS = ("sin", "cos", "tan", "asin", "acos", "atan", "exp", "log", "sqrt", "abs")
JETS = arithmetic_of(HIGH)


def x(t: Any) -> Any:
    return -t * t / 7 + t / 3 + CONTEXT.mpf(2) / 5


def y(t: Any) -> Any:
    return t * t / 5 - t / 2 + CONTEXT.mpf(3) / 4


def jet(course: Callable[[Any], Any]) -> Jet:
    return Jet(*(CONTEXT.diff(course, 0, n) for n in range(3)))


def require_same(found: Jet, course: Callable[[Any], Any]) -> None:
    wanted = jet(course)
    for got, value in zip(
        (found.x, found.d, found.dd), (wanted.x, wanted.d, wanted.dd), strict=True
    ):
        assert abs(got - value) <= 1e-20 * max(1, abs(value))


@pytest.mark.parametrize("name", FUNCTIONS)
def test_rates_of_a_function_are_its_derivatives(name: str) -> None:
    of_numbers = getattr(HIGH, name)
    require_same(getattr(JETS, name)(jet(x)), lambda t: of_numbers(x(t)))


@pytest.mark.parametrize("name", ["atan2", "pow", "min", "max"])
def test_rates_of_a_function_of_two_numbers_are_its_derivatives(name: str) -> None:
    of_numbers = getattr(HIGH, name)
    require_same(getattr(JETS, name)(jet(x), jet(y)), lambda t: of_numbers(x(t), y(t)))


@pytest.mark.parametrize("exponent", [-2, 0, 1, 2, 5, 0.5])
def test_rates_of_a_power_are_its_derivatives(exponent: float) -> None:
    constant = HIGH.number(exponent)
    require_same(JETS.pow(jet(x), Jet(constant)), lambda t: HIGH.pow(x(t), constant))
