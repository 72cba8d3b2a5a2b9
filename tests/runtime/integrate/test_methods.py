"""The tables of the Runge-Kutta methods: conditions that a wrong digit breaks, and orders."""

from __future__ import annotations

import math
from typing import get_args

import numpy as np
import pytest

from kousoku.cli import simulate
from kousoku.runtime.integrate.methods import DOP853, METHODS, RungeKuttaMethod
from kousoku.runtime.integrate.settings import KINEMATICS
from kousoku.runtime.options import RUNGE_KUTTA

methods = pytest.mark.parametrize("method", METHODS, ids=lambda m: m.name)


def pendulum(y: np.ndarray) -> np.ndarray:
    return np.array([y[1], -math.sin(y[0])])


def step(method: RungeKuttaMethod, y: np.ndarray, h: float) -> tuple[np.ndarray, np.ndarray]:
    """End of a step and the derivatives of all stages."""
    k: list[np.ndarray] = []
    for row in method.a:
        k.append(pendulum(y + h * sum((a * f for a, f in zip(row, k, strict=True)), np.zeros(2))))
    end = y + h * sum(a * f for a, f in zip(method.a[method.stages], k, strict=False))
    return end, np.array(k)


def fine(y: np.ndarray, t: float) -> np.ndarray:
    """Solution after t, by steps so short that only rounding is left."""
    for _ in range(64):
        y, _ = step(DOP853, y, t / 64)
    return y


@methods
def test_each_stage_stands_at_its_node(method: RungeKuttaMethod) -> None:
    for node, row in zip(method.c, method.a, strict=True):
        assert sum(row) == pytest.approx(node, abs=2e-15 * max(1.0, *map(abs, row or (0.0,))))


@methods
def test_the_weights_integrate_powers_up_to_the_order(method: RungeKuttaMethod) -> None:
    weights = method.a[method.stages]
    for power in range(method.order):
        total = math.fsum(b * c**power for b, c in zip(weights, method.c, strict=False))
        assert total == pytest.approx(1 / (power + 1), abs=4e-15)


@methods
def test_an_estimate_of_the_error_vanishes_for_a_constant_derivative(
    method: RungeKuttaMethod,
) -> None:
    for row in (*method.errors, *method.dense):
        assert abs(math.fsum(row)) <= 1e-15 * sum(map(abs, row))


@methods
def test_the_error_of_a_step_falls_with_the_order(method: RungeKuttaMethod) -> None:
    start, sizes = np.array([1.0, 0.5]), (0.4, 0.2)
    errors = [np.abs(step(method, start, h)[0] - fine(start, h)).max() for h in sizes]
    assert math.log2(errors[0] / errors[1]) > method.order - 0.5


@methods
def test_dense_output_is_one_order_below_a_step(method: RungeKuttaMethod) -> None:
    start, errors = np.array([1.0, 0.5]), []
    for h in (0.4, 0.2):
        end, k = step(method, start, h)
        change = end - start
        rows = [change, h * k[0] - change, 2 * change - h * (k[0] + k[method.stages])]
        rows += [h * np.tensordot(row, k, 1) for row in method.dense]
        worst = 0.0
        for x in (0.2, 0.5, 0.7):
            y = np.zeros(2)
            for n, row in reversed(list(enumerate(rows))):
                y = (y + row) * (x if n % 2 == 0 else 1 - x)
            worst = max(worst, np.abs(start + y - fine(start, x * h)).max())
        errors.append(worst)
    assert math.log2(errors[0] / errors[1]) > method.order - 1


def test_runs_choose_methods_by_the_names_and_the_order_of_the_tables() -> None:
    names = tuple(method.name for method in METHODS)
    assert names == RUNGE_KUTTA
    of_bodies = [*get_args(simulate.MethodName)][: len(names) + 1]
    assert [*names, KINEMATICS] == of_bodies  # then those of linkages
