"""Scenes that stay in a plane are found, and those that only look so are not."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.codegen.dynamics.composition.compose import compose
from kousoku.codegen.dynamics.recording.interpreter import ProgramInterpreter
from kousoku.codegen.dynamics.simplification.planarity import is_planar
from tests.analysed import all_rows

if TYPE_CHECKING:
    from types import SimpleNamespace

    from kousoku.codegen.dynamics.recording.program import Program
    from kousoku.model.mechanics.multibody import System


def changed(system: System, **fields: Any) -> System:
    """System whose first body is another."""
    return replace(system, bodies=(replace(system.bodies[0], **fields), *system.bodies[1:]))


def test_loops_of_revolute_joints_along_z_are_planar(mechanisms: SimpleNamespace) -> None:
    program = compose(all_rows(mechanisms.four_bars(2)))
    assert program.is_planar
    assert program.region("q").size == 4 * 5
    assert program.region("v").size == 3 * 5
    assert len(program.rows) == 2 * (3 + 4)
    assert all(place.slot == -1 for body in program.bodies for place in body.p[1:3])


@pytest.mark.parametrize(
    "fields",
    [
        {"p": (0.8, 0.6, 0.0, 0.0)},
        {"v": (0.0, 0.0, 0.1)},
        {"omega_b": (0.1, 0.0, 0.0)},
        {"r": (0.0, 0.5, 0.2)},
    ],
)
def test_a_body_that_starts_out_of_the_plane_makes_a_scene_spatial(
    mechanisms: SimpleNamespace, fields: dict[str, Any]
) -> None:
    system = mechanisms.four_bars(1)
    assert is_planar(system)
    assert not is_planar(changed(system, **fields))


def test_a_joint_about_another_axis_makes_a_scene_spatial(mechanisms: SimpleNamespace) -> None:
    assert not is_planar(mechanisms.chain(2))


def test_a_free_body_under_gravity_out_of_the_plane_is_spatial(mechanisms: SimpleNamespace) -> None:
    system = mechanisms.planar_pendulum(1)
    free = replace(system, constraints=())
    assert is_planar(free)
    assert not is_planar(replace(free, gravity=(0.0, 0.0, -9.81)))


def test_joints_that_hold_a_body_in_the_plane_bear_gravity_along_z(
    mechanisms: SimpleNamespace,
) -> None:
    assert is_planar(replace(mechanisms.planar_pendulum(2), gravity=(1.0, -9.81, 3.0)))


def test_a_ball_beside_the_plane_of_the_masses_is_planar_only_where_the_body_is_held(
    mechanisms: SimpleNamespace,
) -> None:
    beside = [(0.0, 0.0, 0.25), (-0.5, 0.0, 0.25)]
    ball = mechanisms.point("j", -1, 0, *beside)
    axis = mechanisms.parallel("j", -1, 0, (0.0, 0.0, 1.0))
    system = mechanisms.planar_pendulum(1)
    assert is_planar(replace(system, constraints=(ball, axis)))
    assert not is_planar(replace(system, constraints=(ball,)))


@pytest.mark.parametrize("offset", [0.0, 0.3])
def test_the_planar_program_moves_as_the_spatial_one_does(
    mechanisms: SimpleNamespace, offset: float
) -> None:
    system = mechanisms.planar_pendulum(3, offset)
    found = []
    for may_be_planar in (True, False):
        program = compose(all_rows(system, may_be_planar=may_be_planar), ["reactions", "energies"])
        assert program.is_planar == may_be_planar
        workspace = ProgramInterpreter(program)
        for k, body in enumerate(program.bodies):
            workspace.values[body.omega_b[2].slot] = 0.5 + k
            workspace.values[body.r[0].slot] += 0.01 * k
        workspace.run("geometry", "position", "move", "velocity", "acceleration", "energy")
        found.append(np.hstack([motion(program, workspace), workspace["energies"]]))
    assert np.abs(found[0]).max() > 1.0
    np.testing.assert_allclose(found[0], found[1], rtol=0, atol=1e-11)


def motion(program: Program, workspace: ProgramInterpreter) -> Any:
    """Corrections and accelerations of x, y and θ_z of all bodies."""
    v = program.region("v").base
    slots = [
        body_place.slot - v
        for body in program.bodies
        for body_place in (*body.v[:2], body.omega_b[2])
    ]
    return np.hstack([[workspace[name][k] for k in slots] for name in ("dq", "dv", "v_dot")])
