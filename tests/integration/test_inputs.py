"""Inputs of every sort: several cranks, sliders, rigid connections; and lengths of every size."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.runtime.linkage import LinkageSolver

    Solver = Callable[[str], LinkageSolver]

FIVE_BAR = """
name = "five_bar"
unit = "mm"
[nodes]
O1 = { at = [0, 0], fixed = true }
O5 = { at = [100, 0], fixed = true }
A = { at = [30, 0] }
B = { at = [50, 88] }
C = { at = [100, 25] }
[links]
crank1 = { nodes = ["O1", "A"], length = 30 }
rod1 = { nodes = ["A", "B"], length = 90 }
rod2 = { nodes = ["C", "B"], length = 80 }
crank2 = { nodes = ["C", "O5"], length = 25 }
[inputs]
alpha = { link = "crank1", about = "O1", turns = 1, rate = 1.5, acceleration = 0.25 }
beta = { link = "crank2", about = "O5", from = 1.5, turns = -2, rate = -0.5, acceleration = 2 }
"""


def test_five_bar_moves_with_both_of_its_inputs(solver: Solver, plane: Any) -> None:
    """Second-order terms of both inputs count, the mixed ones too."""
    mp = plane.mp
    got = solver(FIVE_BAR).solve()
    assert list(got.columns())[:2] == ["alpha", "beta"]
    assert got.alpha.shape == (61, 2)
    np.testing.assert_allclose(got.inputs["beta"], 1.5 - 4 * np.pi * np.arange(61) / 60, 1e-15)
    for row in range(0, 61, 5):
        turn = 2 * mp.pi * row / 60

        def place(t: Any, turn: Any = turn) -> Any:
            a = plane.turned((0, 0), 30, turn + 1.5 * t + t * t / 8)
            c = plane.turned((100, 0), 25, mp.mpf(1.5) - 2 * turn - t / 2 + t * t)
            return plane.meet(a, 90, c, 80, 1)

        exact = plane.motion(place, mp.mpf(0))
        for motion, wanted, limit in zip(
            (got.positions, got.velocities, got.accelerations),
            exact,
            (1e-13, 1e-12, 1e-11),
            strict=True,
        ):
            assert plane.error(motion["B"][row], wanted) <= limit


SLIDER = """
name = "ram"
unit = "in"
divisions = 40
[nodes]
O = { at = [2, -1], fixed = true }
A = { at = [2.5, 1] }
S = { at = [5.5, 3.5] }
[links]
crank = { nodes = ["O", "A"], length = 2 }
rod = { nodes = ["A", "S"], length = 4 }
[sliders]
ram = { node = "S", through = [2, 0], direction = [3, 3] }
[inputs]
stroke = { slider = "ram", from = 4.5, to = 2.5, rate = -1, acceleration = 0.5 }
"""


def test_slider_drives_along_an_inclined_line(solver: Solver, plane: Any) -> None:
    mp = plane.mp
    got = solver(SLIDER).solve()
    assert len(got) == 41
    assert got.alpha[-1] == 2.5
    for row in range(0, 41, 8):

        def place(t: Any, row: int = row) -> Any:
            s = (mp.mpf(9) / 2 - mp.mpf(2 * row) / 40 - t + t * t / 4) / mp.sqrt(2)
            return plane.meet((mp.mpf(2), mp.mpf(-1)), 2, (2 + s, s), 4, 1)

        exact = plane.motion(place, mp.mpf(0))
        for motion, wanted in zip(
            (got.positions, got.velocities, got.accelerations), exact, strict=True
        ):
            assert plane.error(motion["A"][row], wanted) <= 1e-13


BELL_CRANK = """
name = "bell_crank"
unit = "m"
[nodes]
O1 = { at = [0, 0], fixed = true }
O4 = { at = [10, 0], fixed = true }
A = { at = [3, 0] }
B = { at = [4.5, 5.8] }
T = { at = [1.5, 9] }
U = { at = [1, 9.5] }
[links]
crank = { nodes = ["A", "O1"], length = 3 }
rod = { nodes = ["A", "B"], length = 6 }
lever = { nodes = ["B", "O4"], length = 8 }
tip = { nodes = ["T", "B"], length = 4 }
top = { nodes = ["T", "U"], length = 0.5 }
[rigid]
coupler = { at = "B", links = ["rod", "tip"], angle = 2 }
beyond = { at = "T", links = ["tip", "top"], angle = -2.5 }
[inputs]
alpha = { link = "crank", about = "O1", from = 0.25, turns = 1 }
"""


def test_rigid_connections_carry_links_of_a_coupler_along(solver: Solver, plane: Any) -> None:
    mp = plane.mp
    got = solver(BELL_CRANK).solve()
    for row in range(0, 61, 3):
        turn = 2 * mp.pi * row / 60

        def places(t: Any, turn: Any = turn) -> tuple[Any, Any, Any]:
            a = plane.turned((0, 0), 3, mp.mpf(0.25) + turn + t)
            b = plane.meet(a, 6, (mp.mpf(10), mp.mpf(0)), 8, 1)
            towards_a = mp.atan2(a[1] - b[1], a[0] - b[0])
            tip = plane.turned(b, 4, towards_a + 2)
            up = plane.turned(tip, mp.mpf(0.5), towards_a + 2 + mp.pi - mp.mpf(2.5))
            return b, tip, up

        for k, node in enumerate("BTU"):
            exact = plane.motion(lambda t, k=k: places(t)[k], mp.mpf(0))
            for motion, wanted, limit in zip(
                (got.positions, got.velocities, got.accelerations),
                exact,
                (1e-14, 3e-14, 1e-13),
                strict=True,
            ):
                assert plane.error(motion[node][row], wanted) <= 10 * limit, (node, row)


@pytest.mark.parametrize("scale", [1e-9, 1e-4, 1.0, 1e5, 1e9])
@pytest.mark.parametrize("method", ["newton", "paper"])
def test_lengths_of_every_size_are_solved_alike(
    solver: Solver, plane: Any, scale: float, method: str
) -> None:
    lengths = [length * scale for length in (30, 60, 80, 100)]
    got = solver(
        f"""
name = "scaled"
unit = "m"
[nodes]
O1 = {{ at = [0, 0], fixed = true }}
O2 = {{ at = [{lengths[0]!r}, 0] }}
O3 = {{ at = [{45 * scale!r}, {58 * scale!r}] }}
O4 = {{ at = [{lengths[3]!r}, 0], fixed = true }}
[links]
l1 = {{ nodes = ["O1", "O2"], length = {lengths[0]!r} }}
l2 = {{ nodes = ["O2", "O3"], length = {lengths[1]!r} }}
l3 = {{ nodes = ["O3", "O4"], length = {lengths[2]!r} }}
l4 = {{ nodes = ["O4", "O1"], length = {lengths[3]!r} }}
[inputs]
alpha = {{ link = "l1", about = "O1" }}
"""
    ).solve(method=method)
    assert got.residual_max <= 8 * 2**-52 * lengths[3]
    for row in range(0, 61, 5):
        pin = plane.turned((0, 0), lengths[0], 2 * plane.mp.pi * row / 60)
        exact = plane.meet(pin, lengths[1], (plane.mp.mpf(lengths[3]), 0), lengths[2], 1)
        limit = 4e-15 if method == "newton" else 1e-14
        assert plane.error(got.positions["O3"][row], exact) <= limit * lengths[3]


def test_crank_may_turn_backwards_and_many_times(solver: Solver) -> None:
    text = FIVE_BAR.replace("turns = -2", "turns = -5")
    got = solver(text).solve(divisions=360)
    for node, rows in got.positions.items():
        np.testing.assert_allclose(rows[-1], rows[0], rtol=0, atol=1e-13, err_msg=node)


def test_part_of_a_turn_ends_where_it_should(solver: Solver) -> None:
    text = SLIDER.replace(
        'stroke = { slider = "ram", from = 4.5, to = 2.5,',
        ('stroke = { link = "crank", about = "O", from = 1.3, turns = 0.05,'),
    )
    got = solver(text).solve()
    assert got.alpha[-1] == pytest.approx(1.3 + 0.1 * math.pi, rel=1e-15)
    arm = got.positions["A"][-1] - got.positions["O"][-1]
    assert math.atan2(arm[1], arm[0]) == pytest.approx(1.3 + 0.1 * math.pi, rel=1e-15)
