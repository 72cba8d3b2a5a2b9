"""Linkages of several loops, against constructions by circles that know nothing of the solver."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.runtime.linkage import LinkageSolver, Trajectory

    Solver = Callable[[str], LinkageSolver]


def watt(plane: Any, alpha: Any) -> dict[str, Any]:
    """Construct the Watt six-bar: two four-bars, joined at O3 by a constant angle of -1.2."""
    mp = plane.mp
    o1, o3, o6 = (mp.mpf(0), mp.mpf(0)), (mp.mpf(110), mp.mpf(0)), (mp.mpf(230), mp.mpf(0))
    a = plane.turned(o1, 40, alpha)
    b = plane.meet(a, 100, o3, 80, 1)
    towards_b = mp.atan2(b[1] - o3[1], b[0] - o3[0])
    c = plane.turned(o3, 60, towards_b - mp.mpf(1.2))
    d = plane.meet(c, 120, o6, 90, 1)
    return {"O1": o1, "O3": o3, "O6": o6, "A": a, "B": b, "C": c, "D": d}


def stephenson(plane: Any, alpha: Any) -> dict[str, Any]:
    """Construct the Stephenson six-bar: a four-bar, a triangle on its coupler, a dyad on that."""
    mp = plane.mp
    o1, o3, o6 = (mp.mpf(0), mp.mpf(0)), (mp.mpf(60), mp.mpf(0)), (mp.mpf(120), mp.mpf(20))
    a = plane.turned(o1, 20, alpha)
    b = plane.meet(a, 55, o3, 45, 1)
    p = plane.meet(a, 50, b, 40, 1)
    q = plane.meet(p, 110, o6, 70, 1)
    return {"O1": o1, "O3": o3, "O6": o6, "A": a, "B": b, "P": p, "Q": q}


CASES = {"watt_six_bar": (watt, 120), "stephenson_six_bar": (stephenson, 110)}
both = pytest.mark.parametrize("name", CASES)


@both
@pytest.mark.parametrize("method", ["newton", "paper"])
def test_positions_are_where_circles_meet(
    solver: Solver, plane: Any, name: str, method: str
) -> None:
    construct, largest = CASES[name]
    got = solver(name).solve(method=method)
    assert len(got) == 61
    worst = 0.0
    for row in range(61):
        exact = construct(plane, 2 * plane.mp.pi * row / 60)
        worst = max(plane.error(got.positions[n][row], exact[n]) for n in exact)
    assert worst <= 1e-13 * largest


@both
def test_velocities_and_accelerations_are_derivatives_of_the_construction(
    solver: Solver, plane: Any, name: str
) -> None:
    construct, largest = CASES[name]
    got = solver(name).solve()
    for row in range(0, 61, 7):
        time = 2 * plane.mp.pi * row / 60
        for node in got.positions:

            def place(t: Any, node: str = node) -> Any:
                return construct(plane, t)[node]

            _, velocity, acceleration = plane.motion(place, time)
            assert plane.error(got.velocities[node][row], velocity) <= 1e-13 * largest
            assert plane.error(got.accelerations[node][row], acceleration) <= 1e-12 * largest


STEPHENSON_FROM_BEHIND = """
name = "from_behind"
unit = "mm"
divisions = {divisions}
outputs = ["positions", "velocities", "accelerations", "angles"]
[nodes]
O1 = {{ at = [0, 0], fixed = true }}
O3 = {{ at = [60, 0], fixed = true }}
O6 = {{ at = [120, 20], fixed = true }}
{nodes}
[links]
crank = {{ nodes = ["O1", "A"], length = 20 }}
ab = {{ nodes = ["A", "B"], length = 55 }}
bp = {{ nodes = ["B", "P"], length = 40 }}
pa = {{ nodes = ["P", "A"], length = 50 }}
rocker1 = {{ nodes = ["O3", "B"], length = 45 }}
rod = {{ nodes = ["P", "Q"], length = 110 }}
rocker2 = {{ nodes = ["O6", "Q"], length = 70 }}
[inputs]
alpha = {{ link = "rocker2", about = "O6", from = {start}, to = {end}, rate = 0.7 }}
"""


def from_behind(solver: Solver, got: Trajectory, rows: tuple[int, int]) -> LinkageSolver:
    """Stephenson six-bar that is driven by its last rocker, between two rows."""
    at = {node: got.positions[node][rows[0]] for node in "ABPQ"}
    nodes = "\n".join(f"{n} = {{ at = [{x:.1f}, {y:.1f}] }}" for n, (x, y) in at.items())
    arms = [got.positions["Q"][row] - got.positions["O6"][row] for row in rows]
    start, end = (float(np.arctan2(y, x)) for x, y in arms)
    return solver(STEPHENSON_FROM_BEHIND.format(nodes=nodes, start=start, end=end, divisions=30))


def test_a_loop_that_no_dyad_opens_is_solved_as_one_block(solver: Solver) -> None:
    """Driven by the last rocker, six coordinates have to be found together."""
    got = solver("stephenson_six_bar").solve()
    behind = from_behind(solver, got, (20, 40))
    sizes = [len(behind.mechanism.unknowns[b.unknowns]) for b in behind.mechanism.blocks]
    assert sizes == [2, 6]
    back = behind.solve()
    assert back.inputs["alpha"][0] == pytest.approx(1.6461494, abs=1e-6)
    for node in got.positions:
        for row, other in ((0, 20), (-1, 40)):
            np.testing.assert_allclose(
                back.positions[node][row], got.positions[node][other], atol=1e-13 * 110
            )


def test_motion_of_a_large_block_is_the_derivative_of_its_positions(solver: Solver) -> None:
    got = solver("stephenson_six_bar").solve()
    back = from_behind(solver, got, (20, 40)).solve(divisions=400)
    step = (back.alpha[1] - back.alpha[0]) / 0.7
    for node in "ABP":
        x, v, a = back.positions[node], back.velocities[node], back.accelerations[node]
        first = (x[:-4] - 8 * x[1:-3] + 8 * x[3:-1] - x[4:]) / (12 * step)
        second = (v[:-4] - 8 * v[1:-3] + 8 * v[3:-1] - v[4:]) / (12 * step)
        np.testing.assert_allclose(v[2:-2], first, rtol=1e-4, atol=1e-6)
        np.testing.assert_allclose(a[2:-2], second, rtol=1e-3, atol=1e-4)


def test_angles_of_links_and_their_rates_belong_to_the_nodes(solver: Solver) -> None:
    got = solver("stephenson_six_bar").solve()
    back = from_behind(solver, got, (20, 40)).solve()
    np.testing.assert_allclose(back.angles["rocker2"], back.inputs["alpha"], atol=1e-14)
    np.testing.assert_allclose(back.angular_velocities["rocker2"], 0.7, atol=1e-13)
    np.testing.assert_allclose(back.angular_accelerations["rocker2"], 0, atol=1e-13)
    d = back.positions["B"] - back.positions["A"]
    v = back.velocities["B"] - back.velocities["A"]
    rate = (d[:, 0] * v[:, 1] - d[:, 1] * v[:, 0]) / 55**2
    np.testing.assert_allclose(back.angular_velocities["ab"], rate, atol=1e-13)
    np.testing.assert_allclose(back.angles["ab"], np.arctan2(d[:, 1], d[:, 0]), atol=1e-14)
