"""Rows that begin elsewhere than the scene are those of the walk there, whole turns with it."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

from kousoku.runtime.kinematics.rows import OF_NODES
from kousoku.runtime.kinematics.status import AnalysisStatus
from tests.integration.test_linkage_branches import JUMP, MONODROMY, TWO_TURNS, positions

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.runtime.kinematics.rows import Rows
    from kousoku.runtime.linkage import LinkageSolver
    from tests.integration.test_linkage_branches import SixBar

    SolverIn = Callable[[str, str], LinkageSolver]

#: Divisions of a turn.
COUNT = 24
#: A slider that drives a crank to both sides of where it begins.
RAM = """
name = "ram"
unit = "m"
[nodes]
O = { at = [0, 0], fixed = true }
A = { at = [0, 1] }
S = { at = [2, 0] }
[links]
crank = { nodes = ["O", "A"], length = 1 }
rod = { nodes = ["A", "S"], length = 2 }
[sliders]
ram = { node = "S", through = [0, 0], direction = [1, 0] }
[inputs]
stroke = { slider = "ram", from = 2, to = 2.5 }
"""

targets = pytest.mark.parametrize("target", ["c", "numpy"])
pytestmark = pytest.mark.usefixtures("compiler")


def rows_from(moving: LinkageSolver, *origin: float, count: int = 2) -> Rows:
    """Rows at divisions from an origin on."""
    return moving.rows(replace(moving.request(divisions=COUNT), origin=origin, rows=count))


@targets
@pytest.mark.parametrize("name", ["lever_crank", "piston_crank", "stephenson_six_bar"])
def test_rows_from_any_origin_are_those_of_the_turn(
    solver_in: SolverIn, name: str, target: str
) -> None:
    moving = solver_in(name, target)
    turn, (begin,) = rows_from(moving, *moving.scene.origin, count=COUNT + 1), moving.scene.origin
    for k in range(-2 * COUNT - 3, 2 * COUNT + 4, 1 if target == "c" else 5):
        got = rows_from(moving, begin + math.tau * k / COUNT)
        assert (got.status, got.done) == (AnalysisStatus.GOOD, 2)
        for of in OF_NODES:
            found, wanted = (getattr(one, of) for one in (got, turn))
            size = np.abs(wanted).max()
            wanted = wanted[[k % COUNT, (k + 1) % COUNT]]
            np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-11 * size, err_msg=f"{k}")


@targets
@pytest.mark.parametrize("six", [JUMP, MONODROMY, TWO_TURNS], ids=["jump", "monodromy", "two"])
def test_turns_that_do_not_lead_back_are_walked(
    solver_in: SolverIn, six: SixBar, target: str
) -> None:
    """Where small steps stop, at a dead centre, no row is made from an origin beyond it."""
    moving, fine, step = solver_in(six.text, target), six.fine, math.tau / 720
    for k in range(0, 1440, 45 if target == "c" else 225):
        got = rows_from(moving, six.start + k * step)
        if k < len(fine):
            assert got.done >= 1
            np.testing.assert_allclose(positions(got)[0], fine[k], rtol=0, atol=1e-8)
        else:
            assert (got.status, got.done) == (AnalysisStatus.DEAD_CENTRE, 0)
            stop = six.start + (len(fine) - 1) * step
            assert got.reached[0] == pytest.approx(stop, abs=2 * step)


@targets
def test_turns_before_the_scene_are_walked_backwards(solver_in: SolverIn, target: str) -> None:
    """Two turns lead back, and so one of them before the scene and one behind it are the same."""
    moving, fine, step = solver_in(TWO_TURNS.text, target), TWO_TURNS.fine, math.tau / 720
    for k in (-100_003 * 720 - 90, -1081, -720, -450, 720 * 100_001 + 90):
        got = rows_from(moving, TWO_TURNS.start + k * step)
        wanted = fine[[k % 1440]]
        np.testing.assert_allclose(positions(got)[:1], wanted, rtol=0, atol=1e-8)


@targets
def test_two_inputs_go_straight_from_those_of_the_scene(solver_in: SolverIn, target: str) -> None:
    moving = solver_in("five_bar", target)
    begin = np.array(moving.scene.origin)
    for way in ((1.5, -3.0), (-2.0, 0.5), (7.0, 7.0), (0.0, -9.0)):
        run = moving.request(divisions=COUNT)
        straight = moving.rows(replace(run, turns=(0, 0), span=way))
        got = rows_from(moving, *(begin + way), count=1)
        assert (got.done == 1) == (straight.done == COUNT + 1)
        if got.done:
            np.testing.assert_allclose(got.position[0], straight.position[-1], rtol=0, atol=1e-9)


@targets
def test_a_stroke_stops_where_the_crank_is_stretched(solver_in: SolverIn, target: str) -> None:
    moving = solver_in(RAM, target)
    for stroke in (1.2, 1.7, 2.9):
        (A,) = rows_from(moving, stroke).position[:1, moving.mechanism.nodes.index("A")]
        x = (stroke**2 + 1 - 4) / (2 * stroke)
        np.testing.assert_allclose(A, [x, math.sqrt(1 - x * x)], atol=1e-12)
    for stroke, end in ((3.5, 3.0), (0.5, 1.0), (-2.0, 1.0)):
        got = rows_from(moving, stroke)
        assert (got.status, got.done) == (AnalysisStatus.DEAD_CENTRE, 0)
        assert got.reached[0] == pytest.approx(end, abs=1e-5)


def test_two_inputs_begin_many_turns_away(solver_in: SolverIn) -> None:
    """They went there in one division, whose shortest steps were too many, or too long."""
    moving = solver_in("five_bar", "c")
    begin = moving.scene.origin
    for turns in (3, -40_000):
        way = math.tau * turns
        got = rows_from(moving, begin[0] + way, begin[1] - 2.0 * way)
        assert (got.status, got.done) == (AnalysisStatus.GOOD, 2)
        wanted = rows_from(moving, *begin).position
        np.testing.assert_allclose(got.position, wanted, rtol=0, atol=1e-6)
    far = rows_from(moving, begin[0] + 1e12, begin[1] - 2e12)
    assert far.status == AnalysisStatus.TOO_FAR
    assert "to the first row or from row to row" in AnalysisStatus(far.status).message
