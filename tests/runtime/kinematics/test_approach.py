"""Rows that begin elsewhere than the scene: on its branch, or not at all."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import pytest

from kousoku.runtime.kinematics.status import AnalysisStatus

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.runtime.kinematics.rows import Rows
    from kousoku.runtime.toolchain import Toolchain

    Analysed = Callable[..., Rows]

CRANK_ROCKER = {"crank": 30.0, "coupler": 60.0, "rocker": 80.0, "frame": 100.0}
CRANK_ROCKER |= {"phi": 1.3, "psi": 2.3}
#: All links but the frame turn fully, far away from where they begin.
DRAG_LINK = {"crank": 60.0, "coupler": 70.0, "rocker": 65.0, "frame": 30.0}
DRAG_LINK |= {"phi": 1.95, "psi": 1.5}
#: Driven by a rocker, which has two ranges; the other one is that of the mirrored linkage.
TWO_RANGES = {"crank": 80.0, "coupler": 60.0, "rocker": 30.0, "frame": 100.0}
TWO_RANGES |= {"phi": -0.4, "psi": 0.8, "alpha": 0.6}
FOLDED, STRETCHED = (
    math.acos((80**2 + 100**2 - reach**2) / (2 * 80 * 100)) for reach in (60 - 30, 60 + 30)
)
COUNT = 28


@pytest.fixture(params=["c", "numpy"])
def backend(request: pytest.FixtureRequest, compiler: Toolchain) -> str:
    """Both targets: steps on the way are in no row that others compare."""
    return str(request.param)


methods = pytest.mark.parametrize("method", [0, 1], ids=["newton", "paper"])


@methods
@pytest.mark.parametrize("bar", [CRANK_ROCKER, DRAG_LINK], ids=["rocker", "drag_link"])
def test_rows_from_any_origin_are_on_the_branch_of_the_scene(
    analysed: Analysed, backend: str, bar: dict[str, float], method: int
) -> None:
    walked = analysed(bar, divisions=COUNT, rows=COUNT + 1).position
    for k in range(-2 * COUNT - 3, 2 * COUNT + 4, 1 if backend == "c" else 17):
        origin = math.tau * k / COUNT
        rows = analysed(bar, origin=(origin,), divisions=COUNT, rows=3, method=method)
        assert (rows.status, rows.done, rows.iterations[0]) == (AnalysisStatus.GOOD, 3, 0)
        wanted = walked[[(k + row) % COUNT for row in range(3)]]
        np.testing.assert_allclose(rows.position, wanted, atol=1e-11, err_msg=f"{k}")
        assert rows.alpha[0, 0] == origin


@pytest.mark.parametrize("turns", [0, 1])
@pytest.mark.parametrize(
    ("origin", "end"), [(-0.6, FOLDED), (0.6 - math.tau, FOLDED), (0.6 + math.tau, STRETCHED)]
)
@methods
def test_an_origin_behind_a_dead_centre_is_refused(
    analysed: Analysed, method: int, origin: float, end: float, turns: int
) -> None:
    """The linkage fits together there, but its motion does not lead there."""
    rows = analysed(TWO_RANGES, turns=(turns,), span=(0.1,), origin=(origin,), method=method)
    assert (rows.status, rows.done, rows.block) == (AnalysisStatus.DEAD_CENTRE, 0, 1)
    assert rows.reached[0] == pytest.approx(end, abs=1e-4)
    assert FOLDED < rows.reached[0] < STRETCHED
    assert rows.alpha[0, 0] == rows.reached[0]
    reach = np.hypot(*(rows.position[0, 1] - rows.position[0, 0]))
    assert reach == pytest.approx(60)


def test_a_stop_on_the_way_to_a_later_turn_is_counted(analysed: Analysed) -> None:
    rows = analysed(TWO_RANGES, origin=(-0.6,), start=24, first=24)
    assert (rows.status, rows.done) == (AnalysisStatus.DEAD_CENTRE, 0)
    assert rows.reached[0] == pytest.approx(FOLDED + 2 * math.tau, abs=1e-4)


def test_turns_that_lead_back_are_made_once(analysed: Analysed) -> None:
    near, far = (analysed(CRANK_ROCKER, origin=(turns * math.tau + 0.5,)) for turns in (0, 900_000))
    assert far.status == AnalysisStatus.GOOD
    np.testing.assert_allclose(far.position, near.position, atol=1e-7)
    assert analysed(CRANK_ROCKER, origin=(1e7,)).status == AnalysisStatus.TOO_FAR


def test_times_count_from_the_origin(analysed: Analysed) -> None:
    """Also where the first one is not zero."""
    times = np.array([0.5, 0.5, 0.9, 4.0])
    laws = {"rate": (1.5,), "rate_dot": (-0.25,)}
    for first in (-3.5, 0.0, 2.0):
        rows = analysed(CRANK_ROCKER, origin=(first,), times=times, rows=4, **laws)
        assert rows.status == AnalysisStatus.GOOD
        angles = first + 1.5 * times - 0.125 * times**2
        np.testing.assert_allclose(rows.alpha[:, 0], angles, atol=1e-14)
        for k, angle in enumerate(angles):
            there = analysed(CRANK_ROCKER, turns=(0,), span=(angle,), divisions=9, rows=10)
            np.testing.assert_allclose(rows.position[k], there.position[-1], atol=1e-11)
        np.testing.assert_allclose(rows.angle_dot[:, 0], 1.5 - 0.25 * times)
