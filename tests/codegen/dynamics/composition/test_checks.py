"""Forces of joints, and what is left of the constraints, against other ways to find them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.codegen.dynamics.composition.compose import compose
from kousoku.codegen.dynamics.recording.interpreter import ProgramInterpreter
from tests.analysed import all_rows
from tests.workspaces import put

if TYPE_CHECKING:
    from types import SimpleNamespace


def turned(mechanisms: SimpleNamespace, rng: np.random.Generator, name: str) -> ProgramInterpreter:
    """Mechanism anywhere in space, with any velocities."""
    system = getattr(mechanisms, name)()
    workspace = ProgramInterpreter(
        compose(all_rows(system, may_be_planar=False), ["reactions", "checks"])
    )
    put(workspace, mechanisms.random_state(system, rng))
    return workspace


def moving(mechanisms: SimpleNamespace, rng: np.random.Generator, name: str) -> ProgramInterpreter:
    """Mechanism with velocities that its joints allow, and its accelerations."""
    workspace = turned(mechanisms, rng, name)
    workspace.run("geometry", "velocity")
    workspace["v"] = [a + b for a, b in zip(workspace["v"], workspace["dv"], strict=True)]
    workspace.run("velocity", "acceleration")
    return workspace


def test_force_of_the_only_joint_is_what_gravity_does_not_explain(
    mechanisms: SimpleNamespace, rng: np.random.Generator
) -> None:
    system = mechanisms.heavy_top()
    workspace = moving(mechanisms, rng, "heavy_top")
    workspace.run("reaction")
    mass, omega = system.bodies[0].mass, np.array(workspace["v"][3:])
    moments = np.array(system.bodies[0].inertia)
    force = mass * (np.array(workspace["v_dot"][:3]) - system.gravity)
    torque = moments * workspace["v_dot"][3:] + np.cross(omega, moments * omega)
    np.testing.assert_allclose(workspace["reactions"], [*force, *torque], atol=1e-12)
    assert np.abs(force).max() > 1.0


@pytest.mark.parametrize("name", ["heavy_top", "point_on_rod", "mixed"])
def test_solved_motion_leaves_nothing_of_the_constraints(
    mechanisms: SimpleNamespace, rng: np.random.Generator, name: str
) -> None:
    workspace = moving(mechanisms, rng, name)
    workspace.run("check")
    for region in ("C_dot", "C_ddot"):
        assert np.abs(workspace[region]).max() < 1e-12


def test_what_is_left_is_the_time_derivative_of_the_residuals(
    mechanisms: SimpleNamespace, rng: np.random.Generator
) -> None:
    workspace = turned(mechanisms, rng, "mixed")
    workspace.run("geometry", "acceleration")
    workspace["v_dot"] = list(rng.normal(size=len(workspace["v_dot"])))
    workspace.run("check")
    q, v, step = np.array(workspace["q"]), np.array(workspace["v"]), 1e-5
    q_dot, v_dot = np.array(workspace["q_dot"]), np.array(workspace["v_dot"])
    found = {name: np.array(workspace[name]) for name in ("C_dot", "C_ddot")}
    values: dict[str, list[Any]] = {"C": [], "C_dot": []}
    for sign in (-1, 1):
        workspace["q"] = list(q + sign * step * q_dot)
        workspace["v"] = list(v + sign * step * v_dot)
        workspace.run("geometry", "check")
        for name, rows in values.items():
            rows.append(np.array(workspace[name]))
    for name, derivative in (("C", "C_dot"), ("C_dot", "C_ddot")):
        before, after = values[name]
        np.testing.assert_allclose(found[derivative], (after - before) / (2 * step), atol=1e-7)
        assert np.abs(found[derivative]).max() > 0.1
