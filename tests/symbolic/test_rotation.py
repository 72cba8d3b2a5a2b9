"""The rotation: angular velocity there and back, and an update that keeps the norm."""

from __future__ import annotations

from typing import TYPE_CHECKING

import mpmath
import pytest
import sympy

from kousoku.symbolic.components import compose, half_turn
from kousoku.symbolic.matrices import elements
from kousoku.symbolic.ring import Ring
from kousoku.symbolic.rotation import DTHETA_B, OMEGA_B, P_DOT, P

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.symbolic.derivation import Derivation, Function


def function_named(derivation: Derivation, name: str) -> Function:
    (function,) = (f for f in derivation.functions if f.name == name)
    return function


def test_angular_velocity_of_the_rates_is_the_one_they_came_from(
    derived: Callable[[str], Derivation],
) -> None:
    there = function_named(derived("rotation"), "angular_velocity").outputs[0].components
    rates = half_turn(elements(P), elements(OMEGA_B))
    back = there.subs(dict(zip(elements(P_DOT), rates, strict=True)), simultaneous=True)
    carrier = Ring([P, OMEGA_B])
    for found, wanted in zip(back, elements(OMEGA_B), strict=True):
        assert carrier.is_equal(carrier.scalar(found), carrier.scalar(wanted))


def test_rates_of_the_angular_velocity_are_the_tangential_part(
    derived: Callable[[str], Derivation],
) -> None:
    omega = function_named(derived("rotation"), "angular_velocity").outputs[0].components
    p, p_dot = elements(P), elements(P_DOT)
    carrier = Ring([P, P_DOT])
    along = sum(a * b for a, b in zip(p, p_dot, strict=True)) / sum(a * a for a in p)
    for found, rate, e in zip(half_turn(p, list(omega)), p_dot, p, strict=True):
        assert carrier.is_equal(carrier.scalar(found), carrier.scalar(rate - along * e))


@pytest.mark.parametrize(
    "theta",
    [(0, 0, 0), (5e-324, 0, 0), (1e-160, -3e-161, 2e-161), (1e-8, 2e-8, -1e-8), (0.3, -2, 40)],
)
def test_update_is_the_exponential_of_the_turn(
    theta: tuple[float, float, float], derived: Callable[[str], Derivation]
) -> None:
    components = function_named(derived("rotation"), "update").outputs[0].components
    context = mpmath.mp.clone()
    context.dps = 50
    p = [context.mpf(x) for x in (0.6, -0.48, 0.64, 0)]
    t = [context.mpf(x) for x in theta]
    values = dict(zip([*elements(P), *elements(DTHETA_B)], [*p, *t], strict=True))
    found = sympy.lambdify(list(values), list(components), context)(*values.values())
    angle = context.sqrt(sum(x * x for x in t))
    ratio = context.sin(angle / 2) / angle if angle else context.mpf(0.5)
    whole = compose(p, [context.cos(angle / 2), *(ratio * x for x in t)])
    size = context.sqrt(sum(x * x for x in p))
    for a, b in zip(found, whole, strict=True):
        assert abs(a - b / size) <= context.mpf(10) ** -45
    assert abs(sum(x * x for x in found) - 1) <= context.mpf(10) ** -45
