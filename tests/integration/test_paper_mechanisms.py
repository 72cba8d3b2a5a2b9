"""Section 4 of Yamada and Tatsumi (1981): the piston crank and the lever crank."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.runtime.linkage import LinkageSolver, Trajectory

    Solver = Callable[[str], LinkageSolver]

#: Largest length, and limits of position, velocity and acceleration relative to it.
LARGEST_LENGTH = {"piston_crank": 2, "lever_crank": 100}
LIMITS = (4e-15, 1e-14, 2e-14)
#: What the iteration of the paper really needs; the paper reports 6 to 7.
PAPER_NEEDS = {"piston_crank": (10, 10), "lever_crank": (11, 12)}

both = pytest.mark.parametrize("name", LARGEST_LENGTH)


def piston(plane: Any, alpha: Any) -> dict[str, Any]:
    """Position, velocity, acceleration of each node by (30), (31), (32)."""
    mp = plane.mp
    s, c = mp.sin(alpha), mp.cos(alpha)
    l1, l2 = mp.mpf(1), mp.mpf(2)
    root = mp.sqrt(l2**2 - l1**2 * s**2)
    slider = (
        (l1 * c + root, 0),
        (-l1 * s - l1**2 * s * c / root, 0),
        (-l1 * c - l1**2 * (l1**2 * s**4 + l2**2 * mp.cos(2 * alpha)) / root**3, 0),
    )
    still = ((0, 0), (0, 0), (0, 0))
    return {"O1": still, "O2": ((c, s), (-s, c), (-c, -s)), "O3": slider}


def lever(plane: Any, alpha: Any) -> dict[str, Any]:
    """Motion of the four-bar's nodes, where circles about O2 and O4 meet above the frame."""
    mp = plane.mp
    origin, o4 = (mp.mpf(0), mp.mpf(0)), (mp.mpf(100), mp.mpf(0))
    still = ((0, 0), (0, 0))

    def joint(t: Any) -> Any:
        return plane.meet(plane.turned(origin, 30, t), 60, o4, 80, 1)

    return {
        "O1": (origin, *still),
        "O2": plane.motion(lambda t: plane.turned(origin, 30, t), alpha),
        "O3": plane.motion(joint, alpha),
        "O4": (o4, *still),
    }


EXACT = {"piston_crank": piston, "lever_crank": lever}


@pytest.fixture(scope="module")
def exact(plane: Any) -> dict[str, list[dict[str, Any]]]:
    angles = [2 * plane.mp.pi * k / 60 for k in range(60)]
    return {name: [place(plane, alpha) for alpha in angles] for name, place in EXACT.items()}


def largest_errors(plane: Any, got: Trajectory, exact: list[dict[str, Any]]) -> list[float]:
    """Largest errors of position, velocity, acceleration over all rows and nodes."""
    motions = (got.positions, got.velocities, got.accelerations)
    return [
        max(
            plane.error(motions[order][node][row], exact[row % 60][node][order])
            for row in range(len(got))
            for node in exact[0]
        )
        for order in range(3)
    ]


def assert_accurate(
    plane: Any, name: str, got: Trajectory, exact: dict[str, list[dict[str, Any]]]
) -> None:
    errors = largest_errors(plane, got, exact[name])
    limits = [limit * LARGEST_LENGTH[name] for limit in LIMITS]
    assert all(e <= limit for e, limit in zip(errors, limits, strict=True)), (errors, limits)


@both
def test_full_newton_is_accurate_to_rounding(
    solver: Solver, plane: Any, exact: Any, name: str
) -> None:
    got = solver(name).solve()
    assert len(got) == 61
    assert got.residual_max <= 1e-13
    assert_accurate(plane, name, got, exact)


@both
def test_alpha_goes_once_around_in_sixty_divisions(solver: Solver, name: str) -> None:
    got = solver(name).solve()
    np.testing.assert_allclose(got.alpha, np.arange(61) * np.pi / 30, rtol=4e-16, atol=0)
    assert got.divisions == 60
    assert (
        list(got.positions)
        == {"piston_crank": ["O1", "O2", "O3"], "lever_crank": ["O1", "O2", "O3", "O4"]}[name]
    )


@both
def test_full_newton_needs_few_iterations(solver: Solver, name: str) -> None:
    iterations = solver(name).solve().iterations
    assert iterations[0] == 0
    assert iterations[1:].min() >= 2
    assert iterations.max() <= 4


@both
def test_scheme_of_the_paper_needs_more_iterations_than_it_reports(
    solver: Solver, name: str
) -> None:
    got = solver(name).solve(method="paper")
    assert got.iterations[1:].min() == PAPER_NEEDS[name][0]
    assert got.iterations.max() <= PAPER_NEEDS[name][1]
    assert got.residual_max <= 1e-13
    assert got.method == "paper"


@both
def test_scheme_of_the_paper_comes_to_the_same_motion(
    solver: Solver, plane: Any, exact: Any, name: str
) -> None:
    """Velocities and accelerations belong to the converged position, (24) and (25)."""
    errors = largest_errors(plane, solver(name).solve(method="paper"), exact[name])
    assert max(errors) <= 2e-15 * LARGEST_LENGTH[name] + 4e-13


@both
def test_turn_ten_thousand_started_there_is_as_accurate(
    solver: Solver, plane: Any, exact: Any, name: str
) -> None:
    got = solver(name).solve(first_turn=10_000)
    assert_accurate(plane, name, got, exact)
    assert got.alpha[0] == pytest.approx(2 * np.pi * 10_000, rel=4e-16)


@both
def test_turn_ten_thousand_after_all_turns_is_as_accurate(
    solver: Solver, plane: Any, exact: Any, name: str
) -> None:
    got = solver(name).solve(first_turn=10_000, from_turn=0)
    assert len(got) == 61
    assert_accurate(plane, name, got, exact)


@both
def test_many_turns_repeat_the_first_one(solver: Solver, name: str) -> None:
    got = solver(name).solve(turns=3)
    assert len(got) == 181
    for rows in got.positions.values():
        np.testing.assert_allclose(
            rows[60:121], rows[:61], rtol=0, atol=4e-15 * LARGEST_LENGTH[name]
        )
        np.testing.assert_allclose(rows[120:], rows[:61], rtol=0, atol=4e-15 * LARGEST_LENGTH[name])
