"""Sparse factors solve what dense ones solve, and see rows that depend on others."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.codegen.dynamics.assembly.block_factors import BlockFactors, Pattern
from kousoku.codegen.dynamics.assembly.fixed_points import AndersonAcceleration
from kousoku.codegen.dynamics.assembly.newton_double import DoublePose
from kousoku.codegen.dynamics.assembly.pose import Pose
from kousoku.codegen.dynamics.assembly.residuals import Residuals
from kousoku.codegen.dynamics.redundancy import freedom
from kousoku.codegen.dynamics.redundancy.freedom import mobility_of
from kousoku.model.numbers import precise
from tests.analysed import all_rows

if TYPE_CHECKING:
    from types import SimpleNamespace

    from kousoku.model.mechanics.multibody import System


def elements(system: System) -> tuple[Residuals, Any]:
    """Rows of a system, and C_q at the start by its elements."""
    rows = Residuals.of(system, system.constraints)
    place = DoublePose.of(Pose.of(system.bodies))
    _, *found = rows.elements(place.r, place.p)
    return rows, tuple(found)


@pytest.mark.parametrize("name", ["chain", "star", "four_bars"])
def test_sparse_factors_solve_the_dense_equations(mechanisms: SimpleNamespace, name: str) -> None:
    rows, (at, columns, values) = elements(getattr(mechanisms, name)(4))
    matrix = np.zeros((rows.rows, rows.columns))
    matrix[at, columns] = values
    square = matrix @ matrix.T
    damped = square + 1e-3 * square.diagonal().max() * np.eye(len(square))
    right = np.sin(np.arange(float(len(square))))

    solution = BlockFactors(Pattern(rows), (at, columns, values), 1e-3).solve(right)
    assert np.abs(damped @ solution - right).max() < 1e-12


def test_factors_see_rows_that_depend_on_others(mechanisms: SimpleNamespace) -> None:
    """A four-bar in space has three such rows, a chain none."""
    is_regular = {}
    for name in ("chain", "four_bars"):
        rows, found = elements(getattr(mechanisms, name)(3))
        is_regular[name] = BlockFactors(Pattern(rows), found).is_regular

    assert is_regular == {"chain": True, "four_bars": False}


def test_large_loops_are_known_where_sparse_factors_show_that_no_row_depends(
    mechanisms: SimpleNamespace, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(freedom, "MOST_SEARCHED_ROWS", 10)
    system = mechanisms.four_bars(5)
    in_plane = mobility_of(system, all_rows(system).outline)
    again = replace(system.constraints[0], joint="again")
    twice = replace(system, constraints=(*system.constraints, again))
    doubled = mobility_of(twice, all_rows(twice).outline)

    assert (in_plane.degrees, in_plane.unknown) == (1, ())
    assert "again" in doubled.unknown


def test_a_place_in_doubles_moves_as_a_pose_in_fifty_digits(mechanisms: SimpleNamespace) -> None:
    start = Pose.of(mechanisms.chain(3).bodies)
    pose = start.moved([precise.number(0.3 * (k % 4) - 0.4) for k in range(18)])
    step = [0.1 * (k % 5) - 0.2 for k in range(18)]
    moved = DoublePose.of(pose).moved(np.array(step))
    exact = DoublePose.of(pose.moved([precise.number(x) for x in step]))

    assert np.abs(moved.r - exact.r).max() < 1e-15
    assert np.abs(moved.p - exact.p).max() < 1e-15
    assert np.abs(moved.since(DoublePose.of(pose)) - step).max() < 1e-15


def test_a_fixed_point_is_found_in_fewer_steps() -> None:
    """Of x ← cos x, component by component, where each step alone gains a sixth of a digit."""

    def steps(accelerated: AndersonAcceleration | None) -> int:
        x = np.linspace(0.0, 1.0, 4)
        for count in range(200):
            value = np.cos(x)
            if np.abs(value - x).max() < 1e-13:
                return count
            x = accelerated.next(x, value) if accelerated else value
        return 200

    assert steps(None) > 60
    assert steps(AndersonAcceleration(np.ones(4))) < 20
