"""Scenes in the other coordinate planes are as planar as those in the xy-plane."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.codegen.dynamics.composition.compose import compose
from kousoku.codegen.dynamics.recording.interpreter import ProgramInterpreter
from kousoku.codegen.dynamics.simplification.axis_permutation import (
    can_permute,
    permuted,
    permuted_row,
)
from kousoku.codegen.dynamics.simplification.planarity import is_planar
from tests.analysed import all_rows, without
from tests.workspaces import by_body, put

if TYPE_CHECKING:
    from types import SimpleNamespace

SHIFTS = (0, 1, 2)


def turned_state(state: dict[str, Any], shift: int) -> dict[str, Any]:
    order = [(k + shift) % 3 for k in range(3)]
    found = {name: state[name][:, order] for name in ("r", "v", "omega_b")}
    return found | {"p": np.hstack([state["p"][:, :1], state["p"][:, 1:][:, order]])}


@pytest.mark.parametrize("shift", SHIFTS)
def test_a_turned_system_has_the_same_equations(
    mechanisms: SimpleNamespace, rng: np.random.Generator, shift: int
) -> None:
    system = mechanisms.mixed()
    other = permuted(system, shift)
    state = mechanisms.random_state(system, rng)
    wanted, lam, residual = mechanisms.dense(system, state)
    found, other_lam, other_residual = mechanisms.dense(other, turned_state(state, shift))
    order = [(k + shift) % 3 for k in range(3)]
    np.testing.assert_allclose(found[:, :3], wanted[:, order], rtol=0, atol=1e-9)
    np.testing.assert_allclose(found[:, 3:], wanted[:, [3 + k for k in order]], rtol=0, atol=1e-9)
    counts = {"point": 3, "p1": 2, "p2": 2}
    place = 0
    for instance in system.constraints:
        count = counts.get(instance.kind.partition("_")[0], 1)
        rows = [place + permuted_row(instance.kind, row, shift) for row in range(count)]
        np.testing.assert_allclose(other_lam[rows], lam[place : place + count], rtol=1e-7)
        np.testing.assert_allclose(other_residual[rows], residual[place : place + count])
        place += count


@pytest.mark.parametrize("shift", SHIFTS)
def test_closed_loops_in_any_coordinate_plane_are_planar(
    mechanisms: SimpleNamespace, shift: int
) -> None:
    system = permuted(mechanisms.four_bars(2), shift)
    state = turned_state(mechanisms.four_bars_state(2, 1.1, 2.0), shift)
    program = compose(all_rows(system), ["reactions"])
    assert program.is_planar
    workspace = ProgramInterpreter(program)
    put(workspace, state)
    workspace.run("geometry", "acceleration")
    wanted, lam, _ = mechanisms.dense(system, state)
    np.testing.assert_allclose(by_body(workspace, "v_dot"), wanted, rtol=0, atol=1e-9)
    first = np.cumsum([0] + [3 if x.kind == "point" else 2 for x in system.constraints])
    rows = [first[row.instance] + row.row for row in program.rows]
    np.testing.assert_allclose(workspace["lam"], lam[rows], rtol=0, atol=1e-9)


def test_kept_rows_are_those_of_the_scene(mechanisms: SimpleNamespace) -> None:
    found = all_rows(permuted(mechanisms.planar_pendulum(1), 1))
    assert found.outline.rows == compose(found).rows
    assert [(row.instance, row.row) for row in found.outline.rows] == [(0, 2), (0, 0)]
    kept = compose(without(found, found.outline.rows[1:]))
    assert [(row.instance, row.row) for row in kept.rows] == [(0, 2)]


def test_a_chain_at_rest_in_another_plane_is_not_taken_for_planar(
    mechanisms: SimpleNamespace,
) -> None:
    system = mechanisms.chain(2)
    assert is_planar(permuted(system, 2))
    assert not compose(all_rows(system)).is_planar


def test_a_kind_whose_components_are_not_known_is_not_turned(mechanisms: SimpleNamespace) -> None:
    system = mechanisms.planar_pendulum(1)
    assert can_permute(system)
    other = replace(system.constraints[0], kind="norm")
    assert not can_permute(replace(system, constraints=(other,)))
