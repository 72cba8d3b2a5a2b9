"""The N-four-bar A02 passes its singular positions on the parallelogram branch at every tolerance.

With c_m = (N + 1)/3 + N and c_g = (N + 1)/2 + N the angle of its cranks from the vertical obeys
θ̈ = g (c_g/c_m) sin θ. Where cos θ = 0 all bars lie on one line, and the Jacobian loses rank.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.model.reading.families import n_four_bar
from kousoku.runtime.integrate.body_tables import indices

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.model.numbers.real import Array
    from kousoku.model.records.scene import Scene
    from kousoku.runtime.dynamics import DynamicsSolver

    Mover = Callable[[str | Scene], DynamicsSolver]

END = 10.0
TOLERANCES = (1e-7, 1e-8, 1e-9, 1e-10)
#: Angles at the start: the one of the definition, others that turn over, and others that swing.
STARTS = np.array([0.0, 0.1, -0.15, 0.2, 0.9, -1.3, 1.9, -2.2, 2.6, 3.0])
#: x of B₀ and its velocity at 10 s, from the elliptic functions of the definition's start.
PUBLISHED = {
    2: (0.328458111540815, 1.42305147020694),
    40: (0.180512226686728, 1.14844127746941),
}


def crank_angles(count: int, starts: Array) -> Array:
    """Angle θ and θ̇ at 10 s of cranks that start with 1 rad/s, by Taylor series of order 24."""
    factor = 9.81 * ((count + 1) / 2 + count) / ((count + 1) / 3 + count)
    theta, rate = starts.copy(), np.ones_like(starts)
    steps, order = 250, 24
    h = END / steps
    orders = np.arange(0.0, order + 2)
    powers: Array = h**orders
    for _ in range(steps):
        x, sine, cosine = [theta, rate], [np.sin(theta)], [np.cos(theta)]
        for n in range(order):
            x.append(factor * sine[n] / ((n + 1) * (n + 2)))
            slopes = [(k + 1) * x[k + 1] for k in range(n + 1)]
            sine.append(products(slopes, cosine) / (n + 1))
            cosine.append(-products(slopes, sine[: n + 1]) / (n + 1))
        theta = powers @ np.array(x)
        rate = (orders * powers / h) @ np.array(x)
    return np.stack([theta, rate])


def products(first: list[Array], second: list[Array]) -> Array:
    """Last coefficient of the product of two series."""
    array: Array = np.sum([a * b for a, b in zip(first, second[::-1], strict=True)], axis=0)
    return array


def started_at(solver: DynamicsSolver, angle: float) -> DynamicsSolver:
    """Solver with its cranks turned clockwise from the vertical."""
    q, v = solver.q.copy(), solver.v.copy()
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    half = np.array([np.cos(angle / 2), -np.sin(angle / 2)])
    for body in solver.bodies:
        k = int(body.name.partition("_")[2])
        is_crank = body.name.startswith("crank")
        centre = np.array([k, 0.0] if is_crank else [k + 0.5, 0.0])
        places, rates = indices(body.r[:2]), indices(body.v[:2])
        q[places] = centre + turn @ (q[places] - centre)
        v[rates] = turn @ v[rates]
        if is_crank:
            cosine, sine = indices((body.p[0], body.p[3]))
            before = q[cosine], q[sine]
            q[cosine] = half[0] * before[0] - half[1] * before[1]
            q[sine] = half[0] * before[1] + half[1] * before[0]
    return replace(solver, q=q, v=v)


def test_the_reference_is_the_closed_form() -> None:
    for count, (x, speed) in PUBLISHED.items():
        theta, rate = crank_angles(count, STARTS[:1])
        assert np.sin(theta) == pytest.approx(x, rel=1e-11)
        assert rate * np.cos(theta) == pytest.approx(speed, rel=1e-11)


@pytest.mark.parametrize("count", [2, pytest.param(40, marks=pytest.mark.release)])
def test_four_bars_stay_parallelograms_and_their_error_falls_with_the_tolerance(
    mover: Mover, count: int
) -> None:
    solver = mover(n_four_bar(count))
    theta, _ = crank_angles(count, STARTS)
    for k, angle in enumerate(STARTS):
        start = started_at(solver, angle)
        motions = [start.simulate(END, samples=201, tolerance=x) for x in TOLERANCES]
        errors = []
        for motion in motions:
            ledger: Any = motion.ledger
            assert ledger.rejected <= ledger.steps, (angle, ledger)
            first = motion.position["coupler_0"]
            for bar in range(1, count):
                across = motion.position[f"coupler_{bar}"] - first - [bar, 0, 0]
                assert np.abs(across).max() < 1e-9, (angle, ledger)
            errors.append(
                np.hypot(first[-1, 0] - np.sin(theta[k]), first[-1, 1] - np.cos(theta[k]))
            )
        assert errors[-1] < errors[-2] < errors[-3] < errors[-4], (angle, errors)
        assert max(errors[2:]) <= 1e-6, (angle, errors)


@pytest.mark.parametrize("count", [2, 40])
def test_a_stage_is_brought_only_as_near_as_the_tolerance_asks_for(
    mover: Mover, count: int
) -> None:
    """Newton to rounding at every stage would take more than three factorisations for each."""
    ledger = mover(n_four_bar(count)).simulate(END, samples=2, tolerance=1e-8).ledger
    assert ledger.factorisations < 2.75 * ledger.derivatives


def test_rounding_beside_a_singular_position_is_no_error_of_a_step(mover: Mover) -> None:
    """Accelerations lose digits there across the constraints: steps would be 1e-8 s long."""
    solver = mover(n_four_bar(2))
    for tolerance in (1e-11, 3e-12, 1e-12, 3e-13):
        motion = solver.simulate(
            END, samples=2, tolerance=tolerance, method="dop853", most_steps=1000
        )
        assert motion.ledger.steps + motion.ledger.rejected < 600, tolerance
