"""Forces of joints that are not unique are the least ones: NumPy finds the same from all rows."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.codegen.dynamics.assembly.assemble import assemble
from kousoku.codegen.dynamics.choose import with_reactions
from kousoku.codegen.dynamics.composition import least_norm
from kousoku.codegen.dynamics.composition.compose import compose
from kousoku.codegen.dynamics.composition.least_norm import merged
from kousoku.codegen.dynamics.operations.characteristic_length import characteristic_length
from kousoku.codegen.dynamics.recording.interpreter import ProgramInterpreter
from kousoku.codegen.kernel_json import load_frozen
from kousoku.model.errors import SceneError
from kousoku.model.lowering.system import system_of
from kousoku.model.mechanics.multibody import GROUND_INDEX
from kousoku.model.operations.arithmetic import FLOAT
from kousoku.model.operations.interpret import evaluate
from kousoku.model.reading.read import read_scene, scene_from_dict
from tests.analysed import independent
from tests.random_geometry import orientation_of

if TYPE_CHECKING:
    from types import SimpleNamespace

    from kousoku.codegen.dynamics.recording.program import Program
    from kousoku.model.mechanics.multibody import Instance, System

SCENES = Path(__file__).parents[4] / "scenes"
OUTPUTS = ("reactions", "checks")


def least(system: System) -> Program:
    """Program of a system without the rows that depend on others."""
    found = independent(system, may_be_planar=False)
    assert found.left_out
    return compose(found, OUTPUTS)


def moved(program: Program, rng: np.random.Generator, size: float) -> ProgramInterpreter:
    """Workspace with a state of the mechanism near its start, with all computed."""
    work = ProgramInterpreter(program)
    work["q"] = [
        x + size * e for x, e in zip(work["q"], rng.normal(size=len(work["q"])), strict=True)
    ]
    for _ in range(30):
        work.run("geometry", "position", "move")
        work["q"] = work["q_moved"]
    work["v"] = list(rng.normal(size=len(work["v"])))
    work.run("geometry", "velocity")
    work["v"] = [a + b for a, b in zip(work["v"], work["dv"], strict=True)]
    work.run("acceleration", "reaction", "check")
    return work


def state_of(work: ProgramInterpreter) -> dict[str, Any]:
    """Positions and velocities of all bodies in space."""
    return {
        name: np.array(
            [[work.values[x.slot] for x in getattr(one, name)] for one in work.program.bodies]
        )
        for name in ("r", "p", "v", "omega_b")
    }


def jacobian_of(one: Instance, state: dict[str, Any]) -> Any:
    """Jacobian C_q (n, 12) of an instance from its kind as it is shipped."""
    inputs = {name: list(values) for name, values in one.constants}
    for end, body in (("i", one.i), ("j", one.j)):
        is_ground = body == GROUND_INDEX
        inputs[f"r_{end}"] = [0.0] * 3 if is_ground else list(state["r"][body])
        inputs[f"p_{end}"] = [1.0, 0.0, 0.0, 0.0] if is_ground else list(state["p"][body])
    kernels = load_frozen(one.kind).kernels
    kernel = next(kernel for kernel in kernels if kernel.name == "constraint")
    return np.reshape(evaluate(kernel, inputs, FLOAT)["C_q"], (-1, 12))


def wanted(
    system: System, state: dict[str, Any], mechanisms: SimpleNamespace, length: float
) -> dict[str, Any]:
    """Force and torque (6,) of each joint on its body, at its point, in frame O."""
    n = 6 * len(system.bodies)
    v_dot, _, _ = mechanisms.dense(system, state)
    rows, wrenches, names = [], [], list(dict.fromkeys(x.joint for x in system.constraints))
    for one in system.constraints:
        jacobian = jacobian_of(one, state)
        block = np.zeros((len(jacobian), n + 6))
        block[:, 6 * one.i if one.i >= 0 else n :][:, :6] += jacobian[:, :6]
        block[:, 6 * one.j if one.j >= 0 else n :][:, :6] += jacobian[:, 6:]
        rows.append(block[:, :n])
        end, point = end_of(system, one.joint, state)
        own = block[:, 6 * end : 6 * end + 6]
        torque = own[:, 3:] @ orientation_of(state["p"][end]).T
        torque += np.cross(state["r"][end] - point, own[:, :3])
        wrench = np.zeros((len(names), 6, len(jacobian)))
        wrench[names.index(one.joint)] = -np.hstack([own[:, :3], torque]).T
        wrenches.append(wrench)
    c = np.vstack(rows)
    loads = np.zeros((len(system.bodies), 6))
    for k, body in enumerate(system.bodies):
        inertia, omega = np.array(body.inertia), state["omega_b"][k]
        loads[k, :3] = body.mass * (np.array(system.gravity) - v_dot[k, :3])
        loads[k, 3:] = -inertia * v_dot[k, 3:] - np.cross(omega, inertia * omega)
    particular = np.linalg.lstsq(c.T, loads.ravel(), rcond=1e-10)[0]
    assert np.abs(c.T @ particular - loads.ravel()).max() < 1e-9
    _, sizes, vectors = np.linalg.svd(c.T)
    null = vectors[int((sizes > 1e-9 * sizes[0]).sum()) :].T
    every = np.concatenate(wrenches, axis=2)
    weights = np.tile([1.0] * 3 + [1 / length] * 3, len(names))
    flat = every.reshape(-1, every.shape[2])
    z = np.linalg.lstsq(
        weights[:, None] * (flat @ null), -weights * (flat @ particular), rcond=None
    )[0]
    found = (flat @ (particular + null @ z)).reshape(-1, 6)
    return dict(zip(names, found, strict=True))


def found(system: System, work: ProgramInterpreter, state: dict[str, Any]) -> dict[str, Any]:
    """Force and torque of each joint from the region, as ``wanted`` does."""
    result, values = {}, np.array(work["reactions"]).reshape(-1, 6)
    names = list(dict.fromkeys(x.joint for x in system.constraints))
    for name, own in zip(names, values, strict=True):
        one, point = end_of(system, name, state)
        torque = orientation_of(state["p"][one]) @ own[3:] + np.cross(
            state["r"][one] - point, own[:3]
        )
        result[name] = np.hstack([own[:3], torque])
    return result


def end_of(system: System, joint: str, state: dict[str, Any]) -> tuple[int, Any]:
    """Body that the forces of a joint act on, and the joint's point in frame O."""
    own = [one for one in system.constraints if one.joint == joint]
    point = np.array(next(v for one in own for name, v in one.constants if name == "s_j_b"))
    i, j = own[0].i, own[0].j
    if j == GROUND_INDEX:
        return i, point
    return j, state["r"][j] + orientation_of(state["p"][j]) @ point


def door(hinges: int, axis: tuple[float, float, float] = (0.0, 0.0, 1.0)) -> System:
    """Door of 2 m on hinges along one axis, at equal distances."""
    tree = {
        "name": "door",
        "unit": "m",
        "gravity": [0, 0, -9.81],
        "bodies": {
            "door": {"position": [0.5, 0, 0], "boxes": [{"mass": 24, "size": [1, 0.05, 2]}]}
        },
        "joints": {
            f"hinge_{k}": {
                "type": "revolute",
                "bodies": ["ground", "door"],
                "at": [float(z * x) for x in axis],
                "axis": list(axis),
            }
            for k, z in enumerate(np.linspace(-0.8, 0.8, hinges))
        },
    }
    return assemble(system_of(scene_from_dict(tree)))


def leaning_four_bar() -> System:
    """Four-bar of revolute joints in a plane that leans: three rows depend on others."""
    along, up = np.array([0.6, 0.0, 0.8]), np.array([0.48, 0.8, -0.36])
    corners = [x * along + y * up for x, y in ((0, 0), (0.3, 1), (2.3, 1.6), (2, 0))]
    ends = {"crank": (0, 1), "coupler": (1, 2), "rocker": (3, 2)}
    joints = (
        ("ground", "crank"),
        ("crank", "coupler"),
        ("coupler", "rocker"),
        ("rocker", "ground"),
    )
    bodies = {
        name: {
            "position": corners[a].tolist(),
            "cylinders": [
                {
                    "mass": 1.5,
                    "radius": 0.05,
                    "ends": [[0, 0, 0], (corners[b] - corners[a]).tolist()],
                }
            ],
        }
        for name, (a, b) in ends.items()
    }
    axis = np.cross(along, up).tolist()
    tree = {
        "name": "four_bar",
        "unit": "m",
        "gravity": [0, 0, -9.81],
        "bodies": bodies,
        "joints": {
            name: {"type": "revolute", "bodies": list(pair), "at": at.tolist(), "axis": axis}
            for name, pair, at in zip("abcd", joints, corners, strict=True)
        },
    }
    return assemble(system_of(scene_from_dict(tree)))


def check(system: System, mechanisms: SimpleNamespace, rng: np.random.Generator) -> None:
    program, length = least(system), characteristic_length(system)
    for _ in range(3):
        work = moved(program, rng, 0.1)
        state = state_of(work)
        expected = wanted(system, state, mechanisms, length)
        got = found(system, work, state)
        size = max(np.abs(x).max() for x in expected.values())
        assert size > 1.0
        for name, values in expected.items():
            np.testing.assert_allclose(got[name], values, rtol=0, atol=1e-9 * size, err_msg=name)


@pytest.mark.parametrize("axis", [(0.0, 0.0, 1.0), (0.48, 0.6, 0.64)])
@pytest.mark.parametrize("hinges", [2, 3])
def test_forces_of_the_hinges_of_a_door_are_the_least_ones(
    mechanisms: SimpleNamespace, rng: np.random.Generator, hinges: int, axis: Any
) -> None:
    check(door(hinges, axis), mechanisms, rng)


def test_hinges_of_a_door_at_rest_share_its_weight_equally(mechanisms: SimpleNamespace) -> None:
    system = door(2)
    work = ProgramInterpreter(least(system))
    work.run("geometry", "acceleration", "reaction")
    forces = found(system, work, state_of(work))

    upper, lower = forces["hinge_1"], forces["hinge_0"]
    assert upper[2] == pytest.approx(12 * 9.81, rel=1e-12)
    assert lower[2] == pytest.approx(12 * 9.81, rel=1e-12)
    assert upper[0] == pytest.approx(-lower[0], rel=1e-12)
    assert abs(upper[0]) > 10
    # moments about the middle of the hinges: forces at an arm of 0.8 m, and what hinges take
    assert 0.8 * (upper[0] - lower[0]) + upper[4] + lower[4] == pytest.approx(-12 * 9.81, rel=1e-12)


def test_forces_in_the_linkage_of_bricard_are_the_least_ones(
    mechanisms: SimpleNamespace, rng: np.random.Generator
) -> None:
    check(assemble(system_of(read_scene(SCENES / "bricard.toml"))), mechanisms, rng)


def test_forces_of_a_four_bar_in_a_plane_that_leans_are_the_least_ones(
    mechanisms: SimpleNamespace, rng: np.random.Generator
) -> None:
    check(leaning_four_bar(), mechanisms, rng)


def test_more_rows_than_can_be_shared_out_are_refused_by_name(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(least_norm, "MOST_SHARED_ROWS", 4)
    with pytest.raises(
        SceneError, match=r"not unique at joints\.hinge_0, joints\.hinge_1.* 5 rows"
    ):
        least(door(2))


def test_scene_in_a_plane_keeps_to_it_where_too_many_rows_hold_it_there(
    mechanisms: SimpleNamespace, monkeypatch: pytest.MonkeyPatch
) -> None:
    system = replace(mechanisms.four_bars(1), gravity=(0.0, -9.0, 3.0))
    found = independent(system)
    joints = tuple(dict.fromkeys(one.joint for one in system.constraints))

    _, in_space = with_reactions(found, OUTPUTS)
    assert not in_space.is_planar
    assert (in_space.not_unique, in_space.unique_in_plane) == ((), joints)
    monkeypatch.setattr(least_norm, "MOST_SHARED_ROWS", 2)
    _, in_plane = with_reactions(found, OUTPUTS)
    assert in_plane.is_planar
    assert (in_plane.not_unique, in_plane.unique_in_plane) == ((), joints)


def test_merged_sets_have_no_joint_in_common() -> None:
    assert merged([("a", "b"), ("c",), ("d", "e"), ("e", "b")]) == [
        frozenset("abde"),
        frozenset("c"),
    ]
