"""Position, velocity and acceleration analysis of a four-bar, in Python and in C."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import pytest

from kousoku.runtime.kinematics.status import AnalysisStatus

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.runtime.kinematics.rows import Rows

    Bar = dict[str, float]
    Analysed = Callable[..., Rows]


def bar(*lengths: float, phi: float, psi: float) -> Bar:
    """Crank, coupler, rocker, frame, and the angles near the first position."""
    names = ("crank", "coupler", "rocker", "frame")
    return dict(zip(names, lengths, strict=True)) | {"phi": phi, "psi": psi}


CRANK_ROCKER = bar(30.0, 60.0, 80.0, 100.0, phi=1.3, psi=2.3)
#: The frame is the shortest link: all others turn fully.
DRAG_LINK = bar(60.0, 70.0, 65.0, 30.0, phi=1.95, psi=1.5)
#: Coupler and rocker are stretched before the crank is half around.
STOPS = bar(60.0, 60.0, 70.0, 100.0, phi=1.0, psi=2.0)
#: A change point, where all links lie on the frame.
PARALLELOGRAM = bar(30.0, 100.0, 30.0, 100.0, phi=0.0, psi=1.0) | {"alpha": 1.0}
#: The first position would have to stretch them further than they reach.
OPEN = bar(30.0, 20.0, 30.0, 100.0, phi=1.0, psi=2.0)

methods = pytest.mark.parametrize("method", [0, 1], ids=["newton", "paper"])


def assert_links_hold(four: Bar, rows: Rows) -> None:
    """Check the lengths of all links and the first and second derivatives of these."""
    r, v, a = (m[: rows.done] for m in (rows.position, rows.velocity, rows.acceleration))
    frame = np.array([four["frame"], 0.0])
    arms = (
        (four["crank"], r[:, 0], v[:, 0], a[:, 0]),
        (four["coupler"], r[:, 1] - r[:, 0], v[:, 1] - v[:, 0], a[:, 1] - a[:, 0]),
        (four["rocker"], r[:, 1] - frame, v[:, 1], a[:, 1]),
    )
    for length, arm, first, second in arms:
        unit = length * four["frame"]
        np.testing.assert_allclose(np.hypot(*arm.T), length, rtol=1e-11)
        np.testing.assert_allclose(np.sum(arm * first, axis=1), 0, atol=1e-11 * unit)
        curvature = np.sum(arm * second + first * first, axis=1)
        np.testing.assert_allclose(curvature, 0, atol=1e-10 * unit)


@methods
def test_links_keep_their_lengths_around_the_turn(analysed: Analysed, method: int) -> None:
    rows = analysed(CRANK_ROCKER, method=method)
    assert (rows.status, rows.done) == (AnalysisStatus.GOOD, 13)
    assert_links_hold(CRANK_ROCKER, rows)
    np.testing.assert_allclose(rows.alpha[:, 0], np.linspace(0, 2 * np.pi, 13), rtol=1e-15)
    np.testing.assert_allclose(rows.position[-1], rows.position[0], atol=1e-12)
    assert rows.residual.max() <= 1e-12
    assert rows.reached == pytest.approx([2 * np.pi])  # counted, not reduced


def test_crank_moves_at_the_rates_of_its_input(analysed: Analysed) -> None:
    rows = analysed(CRANK_ROCKER, rate=(-1.5,), rate_dot=(0.75,), origin=(0.4,), turns=(-1,))
    alpha = 0.4 - np.linspace(0, 2 * np.pi, 13)
    along, across = (
        np.array([np.cos(alpha), np.sin(alpha)]),
        np.array([-np.sin(alpha), np.cos(alpha)]),
    )
    np.testing.assert_allclose(rows.position[:, 0].T, 30 * along, atol=1e-12)
    np.testing.assert_allclose(rows.velocity[:, 0].T, 30 * -1.5 * across, atol=1e-12)
    hurry = 30 * (0.75 * across - 1.5**2 * along)
    np.testing.assert_allclose(rows.acceleration[:, 0].T, hurry, atol=1e-12)
    np.testing.assert_allclose(rows.angle_dot[:, 0], -1.5)
    np.testing.assert_allclose(rows.angle_ddot[:, 0], 0.75)
    assert_links_hold(CRANK_ROCKER, rows)


def test_newton_needs_fewer_corrections_than_the_iteration_of_the_paper(
    analysed: Analysed,
) -> None:
    newton, paper = (analysed(CRANK_ROCKER, method=k).iterations for k in (0, 1))
    assert newton[0] == paper[0] == 0
    assert newton[1:].max() < paper[1:].min()


def test_iteration_of_the_paper_knows_how_blocks_depend_on_those_before(
    analysed: Analysed,
) -> None:
    """Without the term of the blocks before, it would converge as well, later."""
    rows = analysed(CRANK_ROCKER, method=1, divisions=60, rows=61)
    assert (rows.iterations[1:].min(), rows.iterations.max()) == (6, 8)


@methods
@pytest.mark.parametrize("divisions", [1, 2, 5])
def test_coarse_divisions_are_stepped_within(
    analysed: Analysed, method: int, divisions: int
) -> None:
    rows = analysed(DRAG_LINK, divisions=divisions, rows=divisions + 1, method=method)
    fine = analysed(DRAG_LINK, divisions=60 * divisions, rows=60 * divisions + 1)
    assert (rows.status, fine.status) == (AnalysisStatus.GOOD, AnalysisStatus.GOOD)
    np.testing.assert_allclose(rows.position, fine.position[::60], atol=1e-11)
    assert rows.iterations[1:].min() > fine.iterations.max()


def test_angles_of_links_that_turn_stay_next_to_zero(analysed: Analysed) -> None:
    rows = analysed(DRAG_LINK, rows=37)
    assert rows.done == 37
    assert np.abs(rows.angle[:, 1:]).max() <= math.pi
    assert np.ptp(rows.angle[:, 2]) > 5
    np.testing.assert_allclose(rows.position[12::12], rows.position[[0, 0, 0]], atol=1e-11)


def test_a_later_turn_begins_at_the_start_of_its_turn(analysed: Analysed) -> None:
    once = analysed(DRAG_LINK)
    later = analysed(DRAG_LINK, start=27, first=29, rows=5)
    assert later.done == 5
    np.testing.assert_allclose(later.position, once.position[5:10], atol=1e-11)
    np.testing.assert_allclose(later.alpha[0], 29 * np.pi / 6)


def test_inputs_that_do_not_turn_go_their_span(analysed: Analysed) -> None:
    rows = analysed(CRANK_ROCKER, turns=(0,), origin=(0.2,), span=(0.6,), start=3, first=6, rows=7)
    np.testing.assert_allclose(rows.alpha[:, 0], 0.2 + 0.05 * np.arange(6, 13))
    np.testing.assert_allclose(rows.angle[:, 0], rows.alpha[:, 0])
    assert_links_hold(CRANK_ROCKER, rows)


@methods
def test_dead_centre_on_the_way_keeps_the_good_rows(analysed: Analysed, method: int) -> None:
    rows = analysed(STOPS, divisions=60, rows=61, method=method)
    stretched = math.acos((60**2 + 100**2 - 130**2) / (2 * 60 * 100))
    assert (rows.status, rows.block) == (AnalysisStatus.DEAD_CENTRE, 1)
    assert rows.done == 1 + math.floor(stretched / (math.pi / 30))
    assert rows.reached[0] == pytest.approx(stretched, abs=1e-4)
    assert rows.reached[0] <= stretched
    assert rows.alpha[rows.done, 0] == rows.reached[0]
    assert math.isinf(rows.residual[rows.done])
    assert_links_hold(STOPS, rows)


def test_a_stop_in_the_first_division_of_turns_before_those_wanted(analysed: Analysed) -> None:
    rows = analysed(STOPS, divisions=1, first=3, rows=2)
    assert (rows.status, rows.done, rows.block) == (AnalysisStatus.DEAD_CENTRE, 0, 1)
    assert 1.5 < rows.reached[0] < math.pi


def test_where_it_stops_is_written_also_into_the_last_row(analysed: Analysed) -> None:
    whole = analysed(STOPS, divisions=60, rows=61)
    last = analysed(STOPS, divisions=60, rows=whole.done + 1)
    assert (last.status, last.done) == (AnalysisStatus.DEAD_CENTRE, whole.done)
    assert last.alpha[-1, 0] == whole.reached[0]
    assert math.isinf(last.residual[-1])


@methods
@pytest.mark.parametrize("divisions", [1, 7, 12, 61])
def test_change_point_is_not_stepped_over(analysed: Analysed, method: int, divisions: int) -> None:
    """A whole turn in one step would come back to the same position."""
    rows = analysed(
        PARALLELOGRAM, origin=(1.0,), method=method, divisions=divisions, rows=divisions + 1
    )
    assert rows.status == AnalysisStatus.DEAD_CENTRE
    assert rows.done == 1 + math.floor((math.pi - 1) / (2 * math.pi / divisions))
    np.testing.assert_allclose(rows.angle[: rows.done, 1], 0, atol=1e-9)


@methods
def test_limit_below_rounding_is_too_small(analysed: Analysed, method: int) -> None:
    rows = analysed(CRANK_ROCKER, limit=1e-17, method=method)
    assert rows.status == AnalysisStatus.LIMIT_TOO_SMALL


def test_large_limit_still_leads_to_full_accuracy(analysed: Analysed) -> None:
    """Full Newton goes on until a correction leaves nothing to correct."""
    rows = analysed(CRANK_ROCKER, limit=1e-3)
    assert rows.residual.max() < 1e-10
    assert_links_hold(CRANK_ROCKER, rows)


def test_iterations_are_limited(analysed: Analysed) -> None:
    few = analysed(CRANK_ROCKER, method=1, max_iterations=3)
    many = analysed(CRANK_ROCKER, method=1)
    assert few.status == AnalysisStatus.GOOD  # by shorter steps
    assert few.iterations[1:].min() > many.iterations.max()


def test_rough_positions_are_assembled_by_damped_steps(analysed: Analysed) -> None:
    rough = analysed(CRANK_ROCKER | {"phi": 2.5, "psi": 2.9})
    good = analysed(CRANK_ROCKER)
    assert rough.status == AnalysisStatus.GOOD
    np.testing.assert_allclose(rough.position, good.position, atol=1e-11)


def test_both_branches_are_mirrored(analysed: Analysed) -> None:
    above, below = analysed(CRANK_ROCKER), analysed(CRANK_ROCKER | {"phi": -1.3, "psi": -2.3})
    np.testing.assert_allclose(below.position[::-1] * [1, -1], above.position, atol=1e-11)
    assert above.position[:, 1, 1].min() > 0


def test_linkage_that_does_not_reach_is_not_assembled(analysed: Analysed) -> None:
    rows = analysed(OPEN)
    assert (rows.status, rows.block, rows.done) == (AnalysisStatus.NOT_ASSEMBLED, 1, 0)
    np.testing.assert_allclose(rows.position[0, 0], [30, 0], atol=1e-9)


def test_first_position_on_a_dead_centre_is_refused(analysed: Analysed) -> None:
    rows = analysed(PARALLELOGRAM | {"psi": 0.0, "alpha": 0.0})
    assert (rows.status, rows.block) == (AnalysisStatus.ON_DEAD_CENTRE, 1)


def test_rough_position_with_a_singular_jacobian_is_refused(analysed: Analysed) -> None:
    """Coupler and rocker are parallel, far from where they come together."""
    rows = analysed(CRANK_ROCKER | {"phi": 1.0, "psi": 1.0})
    assert (rows.status, rows.block) == (AnalysisStatus.ON_DEAD_CENTRE, 1)


def test_stretched_first_position_is_on_a_dead_centre(analysed: Analysed) -> None:
    """Newton's method converges slowly to it, and the pivot vanishes."""
    rows = analysed(bar(30.0, 50.0, 20.0, 100.0, phi=0.2, psi=2.9))
    assert rows.status == AnalysisStatus.ON_DEAD_CENTRE


def test_other_side_of_a_dead_centre_is_refused(analysed: Analysed) -> None:
    """Coupler before the rocker where they start, behind it where they come together."""
    rows = analysed(DRAG_LINK | {"phi": 0.9, "psi": 1.2})
    assert (rows.status, rows.block, rows.done) == (AnalysisStatus.OTHER_SIDE, 1, 0)
    assert rows.angle[0, 1] > rows.angle[0, 2]


@pytest.mark.parametrize(
    "options",
    [
        {"divisions": 0},
        {"rows": 0},
        {"start": -1},
        {"start": 2, "first": 1},
        {"max_iterations": 0},
        {"limit": 0.0},
        {"limit": math.nan},
        {"method": 2},
        {"method": -1},
        {"origin": (math.nan,)},
        {"span": (math.inf,)},
        {"rate": (-math.inf,)},
        {"rate_dot": (math.nan,)},
    ],
)
def test_impossible_runs_are_refused(analysed: Analysed, options: dict[str, object]) -> None:
    assert analysed(CRANK_ROCKER, **options).status == AnalysisStatus.BAD_ARGUMENT


def test_numbers_that_are_none_are_named(analysed: Analysed) -> None:
    rows = analysed(CRANK_ROCKER | {"phi": math.nan})
    assert (rows.status, rows.block) == (AnalysisStatus.NOT_FINITE, 1)
