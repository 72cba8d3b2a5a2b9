"""Results by name, for a folder without kousoku."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.model.errors import MotionError
from kousoku.runtime.kinematics.moving import Linkage
from kousoku.runtime.kinematics.rows import RunRequest
from kousoku.runtime.kinematics.solve import solve

if TYPE_CHECKING:
    from kousoku.runtime.kinematics.tables import LinkageTables
    from kousoku.runtime.kinematics.trajectory import Trajectory

RUN = RunRequest(
    method=1,
    max_iterations=50,
    limit=1e-12,
    divisions=8,
    rows=9,
    origin=(0.0,),
    span=(0.0,),
    turns=(1,),
    rate=(1.0,),
    rate_dot=(0.0,),
)


def solve_alone(mechanism: LinkageTables, run: RunRequest) -> Trajectory:
    """Motion as a folder without kousoku makes it."""
    solver: Any = SimpleNamespace(
        name="numpy", mechanism=lambda _: mechanism, scene=lambda _: run, solve=solve
    )
    return Linkage(solver, {"name": "bar"}).solve()


def test_results_are_by_node_and_by_link(four_bar: Any) -> None:
    motion = solve_alone(four_bar.mechanism, RUN)
    rows = solve(four_bar.mechanism, RUN)
    assert (motion.unit, motion.method, motion.alpha.shape) == ("cm", "paper", (9,))
    assert list(motion.positions) == list(motion.velocities) == ["A", "B"]
    np.testing.assert_array_equal(motion.positions["B"], rows.position[:, 1])
    np.testing.assert_array_equal(motion.accelerations["A"], rows.acceleration[:, 0])
    assert list(motion.angles) == ["l1", "l2", "l3"]
    np.testing.assert_array_equal(motion.angles["l3"], rows.angle[:, 2])
    assert motion.residual_max == rows.residual.max() > 0


def test_what_is_not_wanted_is_left_out(four_bar: Any) -> None:
    bare = replace(four_bar.mechanism, outputs=())
    motion = solve_alone(bare, RUN)
    assert list(motion.positions) == ["A", "B"]
    assert motion.velocities == motion.accelerations == motion.angles == {}


def test_where_it_stops_is_said(four_bar: Any) -> None:
    message = (
        "smaller than rounding allows: phi, psi, held by l2, l3, at alpha = .* larger residual"
    )
    with pytest.raises(MotionError, match=message):
        solve_alone(four_bar.mechanism, replace(RUN, method=0, limit=1e-18))
