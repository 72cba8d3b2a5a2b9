"""What cannot be assembled or moved on: said clearly, with the good positions kept."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.model.errors import AssemblyError, MotionError, SolveError

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.runtime.linkage import LinkageSolver

    Solver = Callable[[str], LinkageSolver]


def four_bar(
    lengths: tuple[float, float, float, float] = (30, 60, 80, 100),
    o2: str = "[30, 0]",
    o3: str = "[45, 58]",
    given: str = "turns = 1",
) -> str:
    """Text of a four-bar."""
    l1, l2, l3, l4 = lengths
    return f"""
name = "four_bar"
unit = "cm"
[nodes]
O1 = {{ at = [0, 0], fixed = true }}
O2 = {{ at = {o2} }}
O3 = {{ at = {o3} }}
O4 = {{ at = [{l4}, 0], fixed = true }}
[links]
l1 = {{ nodes = ["O1", "O2"], length = {l1} }}
l2 = {{ nodes = ["O2", "O3"], length = {l2} }}
l3 = {{ nodes = ["O3", "O4"], length = {l3} }}
[inputs]
alpha = {{ link = "l1", about = "O1", {given} }}
"""


PARALLELOGRAM = four_bar((30, 100, 30, 100), "[16, 25]", "[116, 25]", "from = 1, turns = 1")

TWO_LOOPS = """
name = "two_loops"
unit = "mm"
[nodes]
O1 = { at = [0, 0], fixed = true }
O3 = { at = [110, 0], fixed = true }
O6 = { at = [230, 0], fixed = true }
A = { at = [40, 0] }
B = { at = [101, 79] }
C = { at = [163, 28] }
D = { at = [%s] }
[links]
crank = { nodes = ["O1", "A"], length = 40 }
rod1 = { nodes = ["A", "B"], length = 100 }
r1 = { nodes = ["O3", "B"], length = 80 }
r2 = { nodes = ["O3", "C"], length = 60 }
rod2 = { nodes = ["C", "D"], length = %s }
rocker = { nodes = ["O6", "D"], length = %s }
[rigid]
ternary = { at = "O3", links = ["r1", "r2"], angle = -1.2 }
[inputs]
alpha = { link = "crank", about = "O1", from = 0, turns = 1 }
"""


def test_each_branch_is_kept_for_the_whole_turn(solver: Solver) -> None:
    above = solver(four_bar()).solve()
    below = solver(four_bar(o3="[45, -58]")).solve()
    assert above.positions["O3"][:, 1].min() > 10
    for row in range(61):
        mirrored = above.positions["O3"][60 - row] * [1, -1]
        np.testing.assert_allclose(below.positions["O3"][row], mirrored, atol=2e-13)


def test_assembly_finds_the_branch_from_rough_positions(solver: Solver) -> None:
    rough = solver(four_bar(o2="[10, 20]", o3="[100, 158]")).solve()
    np.testing.assert_allclose(rough.positions["O3"][0], [45, 58.0947501931], atol=1e-9)


def test_change_point_stops_with_the_good_positions(solver: Solver) -> None:
    with pytest.raises(MotionError, match="change point") as stop:
        solver(PARALLELOGRAM).solve()
    kept: Any = stop.value.result
    assert len(kept) == 1 + math.floor((math.pi - 1) / (2 * math.pi / 60))
    assert "O3, held by l2, l3, at alpha = 3.14159" in str(stop.value)
    np.testing.assert_allclose(
        kept.positions["O3"], kept.positions["O2"] + [100, 0], rtol=0, atol=1e-11
    )


@pytest.mark.parametrize("divisions", [7, 60, 61, 1000])
def test_change_point_is_not_stepped_over(solver: Solver, divisions: int) -> None:
    with pytest.raises(MotionError) as stop:
        solver(PARALLELOGRAM).solve(divisions=divisions)
    kept: Any = stop.value.result
    assert kept.alpha[-1] < math.pi <= kept.alpha[-1] + 2 * math.pi / divisions + 1e-12


def test_positions_on_a_dead_centre_are_refused(solver: Solver) -> None:
    with pytest.raises(AssemblyError, match=r"lie on a dead centre.*O3, held by l2, l3") as stop:
        solver(four_bar((30, 100, 30, 100), "[30, 0]", "[130, 0]")).solve()
    assert stop.value.keys == ("links.l2", "links.l3")


def test_dead_centre_on_the_way_is_where_the_links_are_stretched(solver: Solver) -> None:
    """Only the position of the first loop shows where the second one opens."""
    with pytest.raises(MotionError, match="D, held by rod2, rocker") as stop:
        solver(TWO_LOOPS % ("200, 45", 40, 55)).solve()
    kept: Any = stop.value.result
    assert 1 <= len(kept) < 61
    assert f"after {len(kept)} good positions of 61" in str(stop.value)
    assert kept.residual_max <= 8 * 2**-52 * 100
    reach = np.hypot(*(kept.positions["C"] - kept.positions["O6"]).T)
    assert (reach < 95).all()
    assert (reach > 15).all()


def test_linkage_that_cannot_be_assembled_names_links_and_misfit(solver: Solver) -> None:
    problem = r": links\.rod2, links\.rocker: the linkage cannot be assembled"
    with pytest.raises(AssemblyError, match=problem) as stop:
        solver(TWO_LOOPS % ("205, 25", 30, 40)).solve()
    assert "mm longer to reach from C to D" in str(stop.value)
    assert "mm longer to reach from O6 to D" in str(stop.value)
    assert "r1 would" not in str(stop.value)


def test_limit_below_rounding_is_refused(solver: Solver) -> None:
    for method in ("newton", "paper"):
        with pytest.raises(MotionError, match=r"smaller than rounding allows.*larger residual"):
            solver(four_bar()).solve(limit=1e-17, method=method)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"method": "euler"}, "method: got 'euler', wanted newton or paper"),
        ({"divisions": 0}, "wanted 1 or more divisions"),
        ({"turns": 0}, "wanted 1 or more divisions and turns"),
        ({"first_turn": -1}, "0 <= from_turn <= first_turn"),
        ({"first_turn": 1, "from_turn": 2}, "0 <= from_turn <= first_turn"),
        ({"limit": math.nan}, "limit nan; wanted a length above 0"),
        ({"limit": 0.0}, r"limit 0\.0; wanted a length above 0"),
        ({"speed": 3}, "speed"),
    ],
)
def test_impossible_options_are_refused(
    solver: Solver, options: dict[str, Any], message: str
) -> None:
    with pytest.raises(SolveError, match=message):
        solver(four_bar()).solve(**options)


def test_inputs_that_go_to_a_value_are_not_turned_on(solver: Solver) -> None:
    with pytest.raises(SolveError, match="leave turns out"):
        solver(four_bar(given="to = 1.0")).solve(turns=2)


@pytest.mark.parametrize("divisions", [1, 2, 3, 4, 17])
def test_coarse_divisions_are_stepped_within(solver: Solver, divisions: int) -> None:
    fine = solver(four_bar()).solve(divisions=divisions * 60)
    coarse = solver(four_bar()).solve(divisions=divisions)
    for node, rows in coarse.positions.items():
        np.testing.assert_allclose(rows, fine.positions[node][::60], rtol=0, atol=4e-13)


def test_link_near_its_dead_centre_is_passed_where_it_does_not_reach_it(solver: Solver) -> None:
    """Nearly a change-point linkage: the angle between l2 and l3 all but closes."""
    got = solver(four_bar((30, 70.01, 60, 100), o3="[70, 58]")).solve()
    assert len(got) == 61
    assert got.positions["O3"][:, 1].min() > 0
