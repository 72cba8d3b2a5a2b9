"""Forces, torques and springs of whole systems against vector algebra and dense equations."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.codegen.dynamics.composition.compose import compose
from kousoku.codegen.dynamics.generate import generate_dynamics
from kousoku.codegen.dynamics.recording.interpreter import ProgramInterpreter
from kousoku.model.elements.load import Load
from kousoku.model.elements.spring_damper import PointSpring
from kousoku.model.errors import SceneError
from kousoku.model.expressions.parser import LONGEST_FORMULA
from kousoku.model.mechanics.multibody import GROUND_INDEX
from kousoku.model.reading.read import scene_from_toml
from tests.analysed import all_rows
from tests.random_geometry import orientation_of
from tests.workspaces import by_body, put

if TYPE_CHECKING:
    from types import SimpleNamespace

    from kousoku.model.mechanics.multibody import ForceElement, System

S_I, S_J, LOAD = (0.3, -0.2, 0.4), (-0.1, 0.5, 0.2), (1.5, -2.5, 0.7)
LAW = (("stiffness", (70.0,)), ("damping", (6.0,)), ("free_length", (0.8,)))


LONG = """
name = "lengthy"
unit = "m"
[bodies.bob]
position = [2, 0, 0]
mass = 1
point = true
[forces.pull]
type = "force"
body = "bob"
force = ["{}", 0, 0]
"""


def test_formula_of_the_longest_that_is_read_is_generated() -> None:
    """Its names get other ones on the way, and it more characters."""
    formula = "t" + "+t" * 998
    assert len(formula) == 1997 < LONGEST_FORMULA
    assert "solver.c" in generate_dynamics(scene_from_toml(LONG.format(formula)))
    with pytest.raises(SceneError, match=f"has 2001 characters; wanted at most {LONGEST_FORMULA}"):
        scene_from_toml(LONG.format("t" + "+t" * 1000))


def spring(name: str, i: int, j: int) -> ForceElement:
    return PointSpring(name, i, j, (("s_i_b", S_I), ("s_j_b", S_J), *LAW))


def force(kind: str, j: int) -> ForceElement:
    constants = (("s_j_b", S_J), ("force", LOAD))
    return Load(kind, kind, GROUND_INDEX, j, constants)


def torque(kind: str, j: int) -> ForceElement:
    return Load(kind, kind, GROUND_INDEX, j, (("torque", LOAD),))


def end_of(state: dict[str, Any], index: int, point: Any) -> tuple[Any, Any, Any]:
    """Place and velocity of a point, and A."""
    if index == GROUND_INDEX:
        return np.array(point), np.zeros(3), np.eye(3)
    a = orientation_of(state["p"][index])
    turning = a @ np.cross(state["omega_b"][index], point)
    return state["r"][index] + a @ point, state["v"][index] + turning, a


def loads_of(system: System, state: dict[str, Any]) -> Any:
    """Force in frame O and torque in the body frame on each body."""
    loads = np.zeros((len(system.bodies) + 1, 6))  # the ground stands last
    for one in system.forces:
        given = {name: np.array(values) for name, values in one.constants}
        _, _, a = end_of(state, one.j, S_J)
        if one.kind == "spring_damper":
            (x_i, v_i, a_i), (x_j, v_j, _) = (
                end_of(state, index, given[f"s_{end}_b"])
                for end, index in (("i", one.i), ("j", one.j))
            )
            length = np.linalg.norm(x_j - x_i)
            along = (x_j - x_i) / length
            tension = 70.0 * (length - 0.8) + 6.0 * along @ (v_j - v_i)
            loads[one.i, :3] += tension * along
            loads[one.i, 3:] += np.cross(S_I, a_i.T @ along) * tension
            loads[one.j, :3] -= tension * along
            loads[one.j, 3:] -= np.cross(S_J, a.T @ along) * tension
        elif one.kind == "force":
            loads[one.j, :3] += LOAD
            loads[one.j, 3:] += np.cross(S_J, a.T @ LOAD)
        elif one.kind == "force_b":
            loads[one.j, :3] += a @ LOAD
            loads[one.j, 3:] += np.cross(S_J, LOAD)
        else:
            loads[one.j, 3:] += a.T @ LOAD if one.kind == "torque" else np.array(LOAD)
    return loads[:-1]


def own_law(i: int) -> ForceElement:
    """Formula of the same spring in units of half a metre: it is homogeneous."""
    constants = (("s_i_b", S_I), ("s_j_b", S_J), ("unit", (0.5,)), ("free_length", (0.8,)))
    return PointSpring("own", i, 0, constants, law="70*x + 6*v")


ELEMENTS = {
    "spring with a law of its own": (own_law(2),),
    "spring to the ground": (spring("s", GROUND_INDEX, 1),),
    "spring from the ground's side j": (spring("s", 1, GROUND_INDEX),),
    "spring between bodies": (spring("s", 2, 0),),
    "force": (force("force", 1),),
    "force that turns with the body": (force("force_b", 1),),
    "torque": (torque("torque", 2),),
    "torque that turns with the body": (torque("torque_b", 0),),
    "all on one body": (
        *(spring(f"s{k}", 0, 1) for k in range(5)),
        force("force", 1),
        force("force_b", 1),
        torque("torque", 1),
        torque("torque_b", 1),
    ),
}


@pytest.mark.parametrize("name", ELEMENTS)
def test_accelerations_under_forces_are_those_of_the_dense_equations(
    mechanisms: SimpleNamespace, rng: np.random.Generator, name: str
) -> None:
    system = replace(mechanisms.chain(3), forces=ELEMENTS[name])
    without = mechanisms.chain(3)
    for _ in range(3):
        state = mechanisms.random_state(system, rng)
        workspace = ProgramInterpreter(compose(all_rows(system)))
        put(workspace, state)
        workspace.run("geometry", "acceleration")
        wanted, _, _ = mechanisms.dense(system, state, loads_of(system, state))
        free, _, _ = mechanisms.dense(without, state)
        assert np.abs(wanted - free).max() > 0.1
        found = by_body(workspace, "v_dot")
        np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-11 * np.abs(wanted).max())


def test_energy_of_springs_and_forces_changes_as_their_work_says(
    mechanisms: SimpleNamespace, rng: np.random.Generator
) -> None:
    free = (("stiffness", (70.0,)), ("damping", (0.0,)), ("free_length", (0.8,)))
    elastic = replace(spring("s", 0, 2), constants=(("s_i_b", S_I), ("s_j_b", S_J), *free))
    system = replace(mechanisms.chain(3), forces=(elastic, force("force", 1)))
    assert not any(one.is_nonconservative for one in system.forces)
    workspace = ProgramInterpreter(compose(all_rows(system), ["energies"]))
    workspace["v"] = list(rng.normal(size=len(workspace["v"])))
    workspace.run("geometry", "velocity")
    workspace["v"] = [a + b for a, b in zip(workspace["v"], workspace["dv"], strict=True)]
    workspace.run("acceleration")
    q, v = np.array(workspace["q"]), np.array(workspace["v"])
    q_dot, v_dot = np.array(workspace["q_dot"]), np.array(workspace["v_dot"])
    energies = []
    for step in (-1e-5, 1e-5):
        workspace["q"], workspace["v"] = list(q + step * q_dot), list(v + step * v_dot)
        workspace.run("energy")
        energies.append(np.array(workspace["energies"]))
    rates = (energies[1] - energies[0]) / 2e-5
    assert abs(rates[0]) > 1.0
    assert abs(rates.sum()) < 1e-6 * abs(rates[0])


@pytest.mark.parametrize(
    "element",
    [
        spring("damped", GROUND_INDEX, 0),
        own_law(GROUND_INDEX),
        force("force_b", 0),
        torque("torque", 0),
        torque("torque_b", 0),
    ],
    ids=lambda one: one.name,
)
def test_work_that_no_potential_holds_is_known(element: ForceElement) -> None:
    assert element.is_nonconservative


def in_plane(height: float) -> ForceElement:
    ends = (("s_i_b", (0.0, 0.5, 0.0)), ("s_j_b", (0.1, 0.0, height)))
    return PointSpring("s", GROUND_INDEX, 0, (*ends, *LAW))


def test_a_force_out_of_the_plane_makes_a_free_body_leave_it(mechanisms: SimpleNamespace) -> None:
    free = replace(mechanisms.planar_pendulum(1), constraints=())
    assert compose(all_rows(replace(free, forces=(in_plane(0.0),)))).is_planar
    assert not compose(all_rows(replace(free, forces=(in_plane(0.3),)))).is_planar
    assert not compose(all_rows(replace(free, forces=(torque("torque", 0),)))).is_planar
    assert not compose(all_rows(replace(free, forces=(force("force", 0),)))).is_planar
    about_z = Load("motor", "torque", GROUND_INDEX, 0, (("torque", (0.0, 0.0, 2.0)),))
    assert compose(all_rows(replace(free, forces=(about_z,)))).is_planar


@pytest.mark.parametrize("plane", [0, 1, 2])
def test_joints_that_hold_a_plane_hold_it_against_forces(
    mechanisms: SimpleNamespace, plane: int
) -> None:
    def turn(values: Any) -> Any:
        return tuple(np.roll(values, -plane).tolist())

    system = mechanisms.planar_pendulum(2)
    elements = (in_plane(0.3), force("force", 1), torque("torque", 0))
    bodies = tuple(
        replace(one, r=turn(one.r), inertia=turn(one.inertia), p=(one.p[0], *turn(one.p[1:])))
        for one in system.bodies
    )
    constraints = tuple(
        replace(
            one,
            kind=one.kind.replace("p1_z", f"p1_{'zyx'[plane]}"),
            constants=tuple((name, turn(values)) for name, values in one.constants),
        )
        for one in system.constraints
    )
    forces = tuple(
        replace(
            one,
            constants=tuple(
                (name, turn(values) if len(values) == 3 else values)
                for name, values in one.constants
            ),
        )
        for one in elements
    )
    gravity = turn(system.gravity)
    turned = replace(system, bodies=bodies, constraints=constraints, forces=forces, gravity=gravity)
    found = []
    for may_be_planar in (True, False):
        program = compose(all_rows(turned, may_be_planar=may_be_planar))
        assert program.is_planar == may_be_planar
        workspace = ProgramInterpreter(program)
        workspace.run("geometry", "acceleration")
        found.append(by_body(workspace, "v_dot"))
    np.testing.assert_allclose(found[0], found[1], rtol=0, atol=1e-11 * np.abs(found[1]).max())
