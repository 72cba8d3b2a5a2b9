"""Forces along coordinates, and formulas, against dense equations and the kinds as shipped."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.codegen.dynamics.composition.auxiliary import WORK
from kousoku.codegen.dynamics.composition.compose import compose
from kousoku.codegen.dynamics.recording.interpreter import ProgramInterpreter
from kousoku.codegen.dynamics.simplification.axis_permutation import permuted
from kousoku.model.elements.along import CoordinateForce
from kousoku.model.elements.coordinate_spring import CoordinateSpring
from kousoku.model.elements.load import Load
from kousoku.model.mechanics.multibody import GROUND_INDEX, MovingBody, RelativeCoordinate, System
from tests.analysed import all_rows
from tests.codegen.dynamics.operations.test_coordinates import KINDS, X, Y, Z
from tests.workspaces import by_body, put

if TYPE_CHECKING:
    from collections.abc import Sequence
    from types import SimpleNamespace

OF_COORDINATES = {"along": CoordinateForce, "coordinate_spring": CoordinateSpring}
LINEAR = (("stiffness", (70.0,)), ("damping", (6.0,)), ("free", (0.4,)))
UNIT, TIME, GAIN = 0.5, 0.7, 3.0


def acting(system: System, measure: str, *ends: int, **force: Any) -> System:
    """System with one coordinate, one parameter and one force."""
    near = 4.0 * math.pi if measure == "angle" else 0.0
    i, j = ends
    one = RelativeCoordinate("u", measure, i, j, KINDS[measure], near)
    given: dict[str, Any] = {"name": "f", "i": i, "j": j, "coordinate": 0} | force
    kind = given["kind"]
    if kind in OF_COORDINATES:
        del given["kind"]
    element = OF_COORDINATES.get(kind, Load)(**given)
    forces, parameters = (element,), (("gain", GAIN),)
    return replace(system, coordinates=(one,), forces=forces, parameters=parameters, unit=UNIT)


def measured(
    mechanisms: SimpleNamespace, system: System, state: dict[str, Any]
) -> tuple[float, float, Any]:
    """Value and rate of the coordinate, and its Jacobian (n, 6)."""
    (one,) = system.coordinates
    inputs: dict[str, Any] = dict(one.constants)
    for end, index in (("i", one.i), ("j", one.j)):
        inputs |= mechanisms.ends(state, end, index)
    found = mechanisms.frozen_kernel(one.kind, "constraint", **inputs)
    slopes = np.zeros((len(system.bodies) + 1, 6))
    for index, part in zip((one.i, one.j), np.split(found["C_q"], 2), strict=True):
        slopes[index] += part
    motion = np.hstack([state["v"], state["omega_b"]])
    value = float(found["C"][0])
    if one.counts_turns:
        value += math.tau * round((one.near - value) / math.tau)
    return value, float(np.sum(slopes[:-1] * motion)), slopes[:-1]


def put_all(workspace: ProgramInterpreter, system: System, state: dict[str, Any]) -> None:
    """Write a state, the time and the parameters."""
    put(workspace, state)
    workspace["t"] = [TIME]
    workspace["parameters"] = [value for _, value in system.parameters]


def power(workspace: ProgramInterpreter) -> float:
    (place,) = (k for k, one in enumerate(workspace.program.auxiliary) if one.kind == WORK)
    count = len(workspace.program.auxiliary)
    return float(workspace["q_dot"][len(workspace["q_dot"]) - count + place])


def compared(
    mechanisms: SimpleNamespace, system: System, rng: np.random.Generator, law: Any
) -> None:
    """Compare accelerations and power with those of τ = law(u, u̇) and its part that works."""
    workspace = ProgramInterpreter(compose(all_rows(system)))
    for _ in range(3):
        state = mechanisms.random_state(system, rng)
        value, rate, slopes = measured(mechanisms, system, state)
        tau, working = law(value, rate)
        put_all(workspace, system, state)
        workspace.run("geometry", "acceleration")
        wanted, _, _ = mechanisms.dense(system, state, slopes * tau)
        free, _, _ = mechanisms.dense(system, state)
        assert np.abs(wanted - free).max() > 0.1
        size = np.abs(wanted).max()
        np.testing.assert_allclose(by_body(workspace, "v_dot"), wanted, rtol=0, atol=1e-11 * size)
        if working is not None:
            assert power(workspace) == pytest.approx(working * rate, rel=1e-11)


ENDS = [(GROUND_INDEX, 1), (0, 2), (2, 1)]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("ends", ENDS, ids=str)
def test_a_spring_against_a_coordinate_is_that_of_the_dense_equations(
    mechanisms: SimpleNamespace, rng: np.random.Generator, kind: str, ends: Sequence[int]
) -> None:
    chain = mechanisms.chain(3)
    system = acting(chain, kind, *ends, kind="coordinate_spring", constants=LINEAR)
    compared(mechanisms, system, rng, lambda u, v: (-70 * (u - 0.4) - 6 * v, -6 * v))


@pytest.mark.parametrize("kind", KINDS)
def test_a_law_of_its_own_is_that_of_the_dense_equations(
    mechanisms: SimpleNamespace, rng: np.random.Generator, kind: str
) -> None:
    constants = (("moment", (2.0,)), ("free", (0.4,)))
    force = {"constants": constants, "law": "gain*x^3 + 5*v*t"}
    system = acting(mechanisms.chain(3), kind, 0, 2, kind="coordinate_spring", **force)

    def law(u: float, v: float) -> tuple[float, float]:
        tau = -2.0 * (GAIN * (u - 0.4) ** 3 + 5 * v * TIME)
        return tau, tau

    compared(mechanisms, system, rng, law)


@pytest.mark.parametrize("kind", KINDS)
def test_a_force_along_a_coordinate_depends_on_it_and_its_rate_in_the_unit_of_the_scene(
    mechanisms: SimpleNamespace, rng: np.random.Generator, kind: str
) -> None:
    force = {"constants": (("force", (0.25,)),), "formulas": (("force", "gain*u - 2*u_dot + t"),)}
    system = acting(mechanisms.chain(3), kind, 0, 2, kind="along", **force)
    unit = UNIT if kind in {"n2", "length"} else 1.0

    def law(u: float, v: float) -> tuple[float, float]:
        tau = 0.25 * (GAIN * u / unit - 2 * v / unit + TIME)
        return tau, tau

    compared(mechanisms, system, rng, law)


def test_formulas_that_differ_in_names_only_are_one_kernel(mechanisms: SimpleNamespace) -> None:
    chain = mechanisms.chain(3)
    angle = (("a_i_b", X), ("b_i_b", Z), ("a_j_b", X))
    places = tuple(RelativeCoordinate(f"u{k}", "angle", k - 1, k, angle) for k in range(3))
    forces = tuple(
        CoordinateForce(
            *(f"f{k}", k - 1, k, (("force", (2.0,)),)),
            formulas=(("force", f"1e1*sin(u{k}) - u{k}_dot"),),
            coordinate=k,
        )
        for k in range(3)
    )
    program = compose(all_rows(replace(chain, coordinates=places, forces=forces)))
    assert [kernel.title for kernel in program.kernels].count("formula") == 1


def test_components_that_are_formulas_add_up_with_those_that_are_numbers(
    mechanisms: SimpleNamespace, rng: np.random.Generator
) -> None:
    vectors = (("torque", (0.5, 0.0, -1.0)), ("torque_x", X), ("torque_y", (0.0, 0.6, 0.8)))
    formulas = (("torque_x", "gain*u"), ("torque_y", "sin(t)*u_dot"))
    given = {"constants": vectors, "formulas": formulas, "i": GROUND_INDEX, "coordinate": -1}
    system = acting(mechanisms.chain(3), "n1", 0, 2, kind="torque_b", **given)
    workspace = ProgramInterpreter(compose(all_rows(system)))
    state = mechanisms.random_state(system, rng)
    u, u_dot, _ = measured(mechanisms, system, state)
    torque = np.array([0.5, 0.0, -1.0]) + GAIN * u * np.array(X)
    torque += math.sin(TIME) * u_dot * np.array([0.0, 0.6, 0.8])
    loads = np.zeros((3, 6))
    loads[2, 3:] = torque
    put_all(workspace, system, state)
    workspace.run("geometry", "acceleration")
    wanted, _, _ = mechanisms.dense(system, state, loads)
    size = np.abs(wanted).max()
    np.testing.assert_allclose(by_body(workspace, "v_dot"), wanted, rtol=0, atol=1e-11 * size)
    assert power(workspace) == pytest.approx(torque @ state["omega_b"][2], rel=1e-12)


@pytest.mark.parametrize("kind", KINDS)
def test_energy_of_a_spring_against_a_coordinate_is_half_k_times_its_square(
    mechanisms: SimpleNamespace, rng: np.random.Generator, kind: str
) -> None:
    chain = mechanisms.chain(3)
    system = acting(chain, kind, 0, 2, kind="coordinate_spring", constants=LINEAR)
    found = []
    state = mechanisms.random_state(system, rng)
    for one in (system, replace(system, forces=())):
        workspace = ProgramInterpreter(compose(all_rows(one), ["energies"]))
        put_all(workspace, one, state)
        workspace.run("energy")
        found.append(workspace["energies"][1])
    value, _, _ = measured(mechanisms, system, state)
    assert found[0] - found[1] == pytest.approx(35.0 * (value - 0.4) ** 2, rel=1e-10)


def level(kind: str, constants: Any, free: float = 0.4) -> System:
    """Body in the xy-plane with a spring against a coordinate to the ground."""
    turn, still = (1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    mass = {"mass": 1.3, "inertia": (0.2, 0.3, 0.25), "is_point": False}
    place = {"r": (1.0, 0.0, 0.0), "p": turn, "v": still, "omega_b": still}
    given: dict[str, Any] = mass | place | {"origin_b": still, "axes_b": turn}
    body = MovingBody(name="b", **given)
    law = (*LINEAR[:2], ("free", (free,)))
    one = RelativeCoordinate("u", kind, GROUND_INDEX, 0, constants)
    force = CoordinateSpring("f", GROUND_INDEX, 0, law, coordinate=0)
    gravity = (0.0, -9.81, 0.0)
    return System("one", 1.0, (body,), (), gravity, coordinates=(one,), forces=(force,))


ZERO = (0.0, 0.0, 0.0)
PLANES: dict[str, tuple[bool, System]] = {
    "an angle about the normal": (True, level("angle", KINDS["angle"])),
    "an angle about an axis of the plane": (
        False,
        level("angle", (("a_i_b", Y), ("b_i_b", Z), ("a_j_b", Y))),
    ),
    "a displacement in the plane": (
        True,
        level("n2", (("a_i_b", X), ("s_i_b", ZERO), ("s_j_b", (0.1, 0.2, 0.0)))),
    ),
    "a displacement of a point above the plane": (
        False,
        level("n2", (("a_i_b", X), ("s_i_b", ZERO), ("s_j_b", (0.1, 0.2, 0.3)))),
    ),
    "a displacement across the plane": (
        False,
        level("n2", (("a_i_b", Z), ("s_i_b", ZERO), ("s_j_b", ZERO))),
    ),
    "a displacement across the plane without force": (
        True,
        level("n2", (("a_i_b", Z), ("s_i_b", ZERO), ("s_j_b", ZERO)), 0.0),
    ),
    "a turn out of the plane without force": (
        True,
        level("n1", (("a_i_b", Z), ("a_j_b", Y)), 0.0),
    ),
    "a turn out of the plane": (False, level("n1", (("a_i_b", Z), ("a_j_b", Y)))),
    "a turn in the plane": (True, level("n1", (("a_i_b", X), ("a_j_b", Y)))),
    "a turn about an oblique axis": (
        False,
        level("n1", (("a_i_b", (0.6, 0.0, 0.8)), ("a_j_b", Y)), 0.0),
    ),
    "a length in the plane": (True, level("length", (("s_i_b", ZERO), ("s_j_b", ZERO)))),
    "a length out of the plane": (
        False,
        level("length", (("s_i_b", (0.0, 0.0, 0.1)), ("s_j_b", ZERO))),
    ),
}


@pytest.mark.parametrize("name", PLANES)
def test_a_scene_is_planar_where_forces_along_coordinates_leave_it_in_its_plane(name: str) -> None:
    stays, system = PLANES[name]
    assert compose(all_rows(system)).is_planar == stays
    workspace = ProgramInterpreter(compose(all_rows(system, may_be_planar=False)))
    workspace["v"] = [0.3, -0.4, 0.0, 0.0, 0.0, 0.7]
    workspace.run("geometry", "acceleration")
    out = [abs(workspace["v_dot"][k]) for k in (2, 3, 4)]
    assert (max(out) < 1e-12) == stays


@pytest.mark.parametrize("shift", [0, 1, 2])
def test_forces_along_coordinates_are_the_same_in_a_plane_and_in_space(
    mechanisms: SimpleNamespace, shift: int
) -> None:
    pendulum = mechanisms.planar_pendulum(2)
    ends = (("s_i_b", (0.1, 2.0, 0.0)), ("s_j_b", (0.2, 0.1, 0.3)))
    coordinates = (
        RelativeCoordinate("u", "angle", 0, 1, KINDS["angle"], 2 * math.tau),
        RelativeCoordinate("gap", "length", GROUND_INDEX, 1, ends),
        RelativeCoordinate("h", "n2", GROUND_INDEX, 0, (("a_i_b", Z), *ends)),
    )
    spring = CoordinateSpring("s", 0, 1, LINEAR, coordinate=0)
    vectors = (("torque", (0.0, 0.0, 0.0)), ("torque_x", X), ("torque_z", Z))
    motor = Load(
        *("m", "torque", GROUND_INDEX, 1, vectors),
        formulas=(("torque_x", "u_dot"), ("torque_z", "gap - u_dot*t")),
    )
    push = CoordinateForce("p", GROUND_INDEX, 1, (("force", (3.0,)),), coordinate=1)
    lift = CoordinateForce("l", GROUND_INDEX, 0, (("force", (2.0,)),), coordinate=2)
    forces = (spring, motor, push, lift)
    system = permuted(replace(pendulum, coordinates=coordinates, forces=forces), shift)
    found = []
    for may_be_planar in (True, False):
        workspace = ProgramInterpreter(compose(all_rows(system, may_be_planar=may_be_planar)))
        assert workspace.program.is_planar == may_be_planar
        workspace["t"] = [TIME]
        normal = (2 - shift) % 3
        for body, rate in zip(workspace.program.bodies, (0.7, -1.1), strict=True):
            workspace.values[body.omega_b[normal].slot] = rate
        workspace.run("geometry", "velocity")
        moved = zip(workspace["v"], workspace["dv"], strict=True)
        workspace["v"] = [a + b for a, b in moved]
        workspace.run("acceleration")
        found.append(by_body(workspace, "v_dot"))
    assert np.abs(found[0]).max() > 1.0
    np.testing.assert_allclose(found[0], found[1], rtol=0, atol=1e-10 * np.abs(found[1]).max())
