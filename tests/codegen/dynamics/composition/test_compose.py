"""Programs of whole systems against dense equations that NumPy solves."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.codegen.dynamics.composition.compose import compose
from kousoku.codegen.dynamics.recording.interpreter import ProgramInterpreter
from kousoku.codegen.dynamics.recording.program import levels, reads, writes
from kousoku.model.errors import SceneError
from tests.analysed import all_rows, without
from tests.workspaces import by_body, put

if TYPE_CHECKING:
    from types import SimpleNamespace

    from kousoku.codegen.dynamics.recording.program import Program
    from kousoku.model.mechanics.multibody import System


def check_accelerations(system: System, state: dict[str, Any], dense: Any) -> Program:
    """Compare accelerations, multipliers and residuals with the dense ones."""
    program = compose(all_rows(system), ["reactions"])
    workspace = ProgramInterpreter(program)
    put(workspace, state)
    workspace.run("geometry", "acceleration")
    wanted, lam, residuals = dense(system, state)
    scale = np.abs(wanted).max() + np.abs(lam).max()
    np.testing.assert_allclose(by_body(workspace, "v_dot"), wanted, rtol=0, atol=1e-10 * scale)
    starts = np.cumsum(
        [0] + [{"po": 3, "p1": 2, "p2": 2}.get(x.kind[:2], 1) for x in system.constraints]
    )
    rows = [starts[row.instance] + row.row for row in program.rows]
    np.testing.assert_allclose(workspace["lam"], lam[rows], rtol=0, atol=1e-10 * scale)
    np.testing.assert_allclose(workspace["C"], residuals[rows], rtol=0, atol=1e-13)
    return program


@pytest.mark.parametrize(
    ("name", "size"),
    [("chain", 2), ("chain", 10), ("star", 3), ("star", 7)],
)
def test_accelerations_of_a_tree_are_those_of_the_dense_equations(
    mechanisms: SimpleNamespace, rng: np.random.Generator, name: str, size: int
) -> None:
    system = getattr(mechanisms, name)(size)
    for _ in range(3):
        check_accelerations(system, mechanisms.random_state(system, rng), mechanisms.dense)


@pytest.mark.parametrize("name", ["heavy_top", "point_on_rod", "mixed"])
def test_accelerations_with_other_kinds_are_those_of_the_dense_equations(
    mechanisms: SimpleNamespace, rng: np.random.Generator, name: str
) -> None:
    system = getattr(mechanisms, name)()
    for _ in range(3):
        check_accelerations(system, mechanisms.random_state(system, rng), mechanisms.dense)


@pytest.mark.parametrize("count", [1, 3])
def test_accelerations_of_closed_loops_are_those_of_the_dense_equations(
    mechanisms: SimpleNamespace, count: int
) -> None:
    for angle, rate in ((1.2, 0.7), (2.5, -3.0), (-0.8, 0.0)):
        state = mechanisms.four_bars_state(count, angle, rate)
        program = check_accelerations(mechanisms.four_bars(count), state, mechanisms.dense)
        assert program.is_planar


def test_position_corrections_assemble_a_chain_from_anywhere(
    mechanisms: SimpleNamespace, rng: np.random.Generator
) -> None:
    system = mechanisms.chain(4)
    workspace = ProgramInterpreter(compose(all_rows(system)))
    put(workspace, mechanisms.random_state(system, rng))
    for _ in range(40):
        workspace.run("geometry", "position", "move")
        workspace["q"] = workspace["q_moved"]
    assert max(map(abs, workspace["C"])) < 1e-14
    assert max(map(abs, workspace["dq"])) < 1e-13


def test_velocity_correction_ends_on_velocities_that_the_joints_allow(
    mechanisms: SimpleNamespace, rng: np.random.Generator
) -> None:
    system = mechanisms.chain(4)
    workspace = ProgramInterpreter(compose(all_rows(system)))
    put(workspace, mechanisms.random_state(system, rng))
    workspace.run("geometry", "velocity")
    first = np.array(workspace["dv"])
    workspace["v"] = [a + b for a, b in zip(workspace["v"], workspace["dv"], strict=True)]
    workspace.run("velocity")
    assert np.abs(first).max() > 0.1
    assert np.abs(workspace["dv"]).max() < 1e-13


def test_energy_is_kept_by_the_accelerations(
    mechanisms: SimpleNamespace, rng: np.random.Generator
) -> None:
    system = mechanisms.chain(5)
    workspace = ProgramInterpreter(compose(all_rows(system), ["energies"]))
    workspace["v"] = list(rng.normal(size=len(workspace["v"])))
    workspace.run("geometry", "velocity")
    workspace["v"] = [a + b for a, b in zip(workspace["v"], workspace["dv"], strict=True)]
    workspace.run("acceleration")
    step, energies = 1e-5, []
    q, v = np.array(workspace["q"]), np.array(workspace["v"])
    for sign in (-1, 1):
        workspace["q"] = list(q + sign * step * np.array(workspace["q_dot"]))
        workspace["v"] = list(v + sign * step * np.array(workspace["v_dot"]))
        workspace.run("energy")
        energies.append(np.array(workspace["energies"]))
    rates = (energies[1] - energies[0]) / (2 * step)
    assert abs(rates[0]) > 1.0
    assert abs(rates.sum()) < 1e-6 * abs(rates[0])


def test_pivots_tell_how_near_rows_are_to_dependence(mechanisms: SimpleNamespace) -> None:
    workspace = ProgramInterpreter(compose(all_rows(mechanisms.four_bars(1))))
    largest = []
    for angle in (1.2, 0.1, 0.001):
        put(workspace, mechanisms.four_bars_state(1, angle, 0.0))
        workspace.run("geometry")
        assert min(workspace["pivots"]) > 0
        largest.append(max(workspace["pivots"]))
    assert largest[0] < 10 < largest[1] < 1e4 < largest[2]


def test_only_some_rows_are_kept_where_that_is_asked_for(
    mechanisms: SimpleNamespace, rng: np.random.Generator
) -> None:
    system = mechanisms.chain(2)
    found = all_rows(system)
    left_out = {(2, 1), *((3, row) for row in range(3))}
    rows = [row for row in found.outline.rows if (row.instance, row.row) in left_out]
    program = compose(without(found, rows))
    kept = [(row.instance, row.row) for row in program.rows]
    assert kept == [(0, 0), (0, 1), (0, 2), (1, 0), (1, 1), (2, 0), (2, 2)]
    workspace = ProgramInterpreter(program)
    put(workspace, mechanisms.random_state(system, rng))
    workspace.run("geometry", "acceleration")
    assert np.isfinite(workspace["v_dot"]).all()


def test_a_long_chain_needs_no_more_kernels_than_one_of_twenty_and_a_short_one_less(
    mechanisms: SimpleNamespace,
) -> None:
    short, small, large = (compose(all_rows(mechanisms.chain(n))) for n in (10, 20, 200))
    assert len(large.kernels) == len(small.kernels)
    assert len(short.kernels) < 0.8 * len(small.kernels)
    assert large.size < 10.5 * small.size


def test_tasks_of_one_level_do_not_read_what_others_of_it_write(
    mechanisms: SimpleNamespace,
) -> None:
    program = compose(all_rows(mechanisms.four_bars(3)))
    for segment in program.segments:
        found = levels(program, segment)
        assert sorted(k for level in found for k in level) == list(range(len(segment.tasks)))
        written: set[int] = set()
        later = {
            slot
            for task in segment.tasks
            for base, length in writes(program, task)
            for slot in range(base, base + length)
        }
        for level in found:
            tasks = [segment.tasks[k] for k in level]
            for task in tasks:
                for base, length in reads(program, task):
                    slots = set(range(base, base + length))
                    assert not slots & (later - written)
            for task in tasks:
                for base, length in writes(program, task):
                    written |= set(range(base, base + length))


def test_a_body_that_can_turn_about_an_axis_without_inertia_is_refused(
    mechanisms: SimpleNamespace,
) -> None:
    system = mechanisms.chain(2)
    thin = replace(system.bodies[0], inertia=(0.0, 0.1, 0.1))
    with pytest.raises(SceneError, match=r"bodies\.b0\.inertia: has a principal moment of 0"):
        compose(all_rows(replace(system, bodies=(thin, system.bodies[1]))))


def test_a_body_with_hopelessly_many_joints_is_refused_at_once(mechanisms: SimpleNamespace) -> None:
    with pytest.raises(SceneError, match=r"bodies\.hub: has 65 joints; at most 64"):
        compose(all_rows(mechanisms.star(65)))
