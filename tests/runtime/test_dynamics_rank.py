"""Rows that are kept and nearly redundant with other parameters: no run goes on with them."""

from __future__ import annotations

import math
import subprocess
import sys
import tomllib
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import kousoku as ks
from kousoku.codegen.dynamics.generate import generate_dynamics
from kousoku.codegen.dynamics.redundancy import varying_rank
from kousoku.model.errors import SceneError, SolveError
from kousoku.model.reading.read import scene_from_toml
from kousoku.runtime.dynamics import load_dynamics
from kousoku.runtime.dynamics_targets import Memory
from kousoku.runtime.integrate.settings import Status

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from kousoku.runtime.dynamics import DynamicsSolver
    from kousoku.runtime.integrate.motion import Motion

pytestmark = pytest.mark.usefixtures("compiler", "numpy_solver")


def cylinder(end: str) -> str:
    return f"cylinders = [{{ mass = 1, radius = 0.05, ends = [[0, 0, 0], {end}] }}]"


def hinge(name: str, bodies: str, at: str, axis: str) -> str:
    return f'{name} = {{ type = "hinge", bodies = {bodies}, at = {at}, axis = {axis} }}\n'


#: A four-bar whose last axis leans by e [rad]: nothing moves, unless that is within the tolerance.
FOUR_BAR = f"""
name = "four_bar"
unit = "m"
gravity = [1, -9.81, 0]
parameters = {{ e = 3e-3 }}
[bodies]
crank = {{ position = [0, 0, 0], {cylinder("[0.3, 0.9, 0]")} }}
coupler = {{ position = [0.3, 0.9, 0], {cylinder("[1.4, 0.3, 0]")} }}
rocker = {{ position = [2, 0, 0], {cylinder("[-0.3, 1.2, 0]")} }}
[joints]
{hinge("A", '["ground", "crank"]', "[0, 0, 0]", "[0, 0, 1]")}
{hinge("B", '["crank", "coupler"]', "[0.3, 0.9, 0]", "[0, 0, 1]")}
{hinge("C", '["coupler", "rocker"]', "[1.7, 1.2, 0]", "[0, 0, 1]")}
{hinge("D", '["ground", "rocker"]', "[2, 0, 0]", '["e", 0, 1]')}
"""
#: A door, its upper hinge aside and leaning by e.
DOOR = """
name = "door"
unit = "m"
gravity = [0, -9.81, 0]
parameters = { e = 5e-3 }
[bodies]
d = { position = [0, 0, 0], boxes = [{ mass = 5, size = [1, 0.1, 2], at = [0.5, 0, 0.5] }] }
[joints]
h = { type = "revolute", bodies = ["ground", "d"], at = [0, 0, 0], axis = [0, 0, 1] }
g = { type = "revolute", bodies = ["ground", "d"], at = ["e", 0, 1], axis = [0, "e", 1] }
"""
#: Two gears between the same wheels: nothing turns, unless their ratios are equal.
GEARS = """
name = "gears"
unit = "m"
parameters = { r = 2.1 }
[bodies]
a = { position = [0, 0, 0], mass = 1, inertia = { xx = 1, yy = 1, zz = 1 } }
b = { position = [1, 0, 0], mass = 1, inertia = { xx = 1, yy = 1, zz = 1 } }
[joints]
p = { type = "revolute", bodies = ["ground", "a"], at = [0, 0, 0], axis = [0, 0, 1] }
q = { type = "revolute", bodies = ["ground", "b"], at = [1, 0, 0], axis = [0, 0, 1] }
g = { type = "gear", joints = ["p", "q"], ratio = 2.0 }
h = { type = "gear", joints = ["p", "q"], ratio = "r" }
"""
#: A scene, values with which its rows are nearly redundant, joints one of which is named, and
#: values with which they are independent.
SCENES = {
    "four_bar": (FOUR_BAR, [1e-8, 1e-5, 3e-4, 2e-3], "ABCD", [2.1e-3, 5e-2]),
    "door": (DOOR, [1e-8, 1e-5, 2e-4, 1e-3], "gh", [1.2e-3, 4e-3, 0.1]),
    "gears": (GEARS, [2 + 1e-8, 2 + 1e-5, 2.002], "gh", [2.004, 2.5, -2.0]),
}


def travel(run: Motion, solver: DynamicsSolver) -> float:
    """Longest way that a coordinate came."""
    return float(np.ptp(run.rows[:, 1 : 1 + len(solver.q)], axis=0).max())


@pytest.mark.parametrize("target", ["c", "numpy"])
@pytest.mark.parametrize("name", SCENES)
def test_parameters_with_which_kept_rows_are_nearly_redundant_are_refused(
    bodies_folder: Callable[..., Path], name: str, target: Any
) -> None:
    text, near, joints, clear = SCENES[name]
    key = "r" if name == "gears" else "e"
    solver = load_dynamics(bodies_folder(scene_from_toml(text), ("positions",)), target=target)
    for value in near:
        told = rf"beyond all others they hold .* of joints\.[{joints}].* generate it again"
        with pytest.raises(SolveError, match=told):
            solver.simulate(0.3, samples=4, parameters={key: value})
        memory = Memory(np.zeros(solver.target.state_size), np.zeros(solver.target.work_size))
        there = solver.at({key: value})
        start = solver.target.starter(0.0, there.q, there.v, np.array([value]), memory)
        assert start() == Status.DEPENDENT
    for value in clear:
        run = solver.simulate(0.3, samples=4, parameters={key: value})
        assert travel(run, solver) < 1e-9


@pytest.mark.parametrize("name", SCENES)
def test_both_targets_find_the_same_bits(bodies_folder: Callable[..., Path], name: str) -> None:
    text, near, _, _ = SCENES[name]
    folder = bodies_folder(scene_from_toml(text), ("positions",))
    found = []
    for target in ("c", "numpy"):
        solver: Any = load_dynamics(folder, target=target)
        base, size = solver.places["C"]
        for value in near:
            memory = Memory(np.zeros(solver.target.state_size), np.zeros(solver.target.work_size))
            there = solver.at({solver.parameters[0][0]: value})
            start = solver.target.starter(0.0, there.q, there.v, np.array([value]), memory)
            assert start() == Status.DEPENDENT
            found.append((memory.work[base : base + size].tolist(), memory.state.tolist()))
    assert found[: len(near)] == found[len(near) :]


def test_file_with_such_a_value_moves_or_is_refused(bodies_folder: Callable[..., Path]) -> None:
    moved = scene_from_toml(FOUR_BAR.replace("e = 3e-3", "e = 1e-5"))
    solver = load_dynamics(bodies_folder(moved, ("positions",)))
    assert travel(solver.simulate(0.3, samples=4), solver) > 1e-2
    with pytest.raises(SceneError, match="independent above"):
        bodies_folder(scene_from_toml(FOUR_BAR.replace("e = 3e-3", "e = 3e-4")), ("positions",))


def test_the_folder_alone_refuses_them_too(bodies_folder: Callable[..., Path]) -> None:
    folder = bodies_folder(scene_from_toml(FOUR_BAR), ("positions",))
    script = f"""
import sys
sys.modules["kousoku"] = None
sys.path.insert(0, {str(folder.parent)!r})
from four_bar import simulate
for e in (1e-8, 1e-5, 2e-3):
    try:
        simulate(0.1, samples=2, parameters={{"e": e}})
    except ArithmeticError as error:
        assert "beyond all others they hold" in str(error), error
    else:
        raise AssertionError(e)
simulate(0.1, samples=2, parameters={{"e": 2.1e-3}})
"""
    subprocess.run([sys.executable, "-c", script], check=True, timeout=120)


def flat_later(angle: float) -> tuple[str, dict[str, Any]]:
    """Scene that is a parallelogram with d = 2, and its start at an angle as q0 and v0."""
    place = [1.0, *[0.0] * 3]
    turned = [math.cos(angle / 2), 0.0, 0.0, math.sin(angle / 2)]
    tip = [math.cos(angle), math.sin(angle), 0.0]
    turn = "{ axis = [0, 0, 1], angle = 1 }"
    text = f"""
name = "flat"
unit = "m"
gravity = [0, -9.81, 0]
parameters = {{ d = 2.5 }}
[bodies]
a = {{ position = [0, 0, 0], orientation = {turn}, {cylinder("[1, 0, 0]")} }}
b = {{ position = [0.54, 0.84, 0], {cylinder("[2, 0, 0]")} }}
c = {{ position = [2, 0, 0], orientation = {turn}, {cylinder("[1, 0, 0]")} }}
[joints]
{planar("A", '["ground", "a"]', "[[0, 0, 0], [0, 0, 0]]")}
{planar("B", '["a", "b"]', "[[1, 0, 0], [0, 0, 0]]")}
{planar("C", '["b", "c"]', "[[2, 0, 0], [1, 0, 0]]")}
{planar("D", '["ground", "c"]', '[["d", 0, 0], [0, 0, 0]]')}
"""
    q0 = [*[0.0] * 3, *turned, *tip, *place, 2.0, 0.0, 0.0, *turned]
    turning = [*[0.0] * 5, 1.0]
    return text, {"q0": q0, "v0": [*turning, -tip[1], tip[0], *[0.0] * 4, *turning]}


def planar(name: str, bodies: str, points: str) -> str:
    axes = "[[0, 0, 1], [0, 0, 1]]"
    return (
        f'{name} = {{ type = "revolute", bodies = {bodies}, points = {points}, axes = {axes} }}\n'
    )


@pytest.mark.parametrize("target", ["c", "numpy"])
@pytest.mark.parametrize("angle", [1e-2, 1e-4, -1e-4])
def test_run_may_start_at_a_singular_configuration(
    bodies_folder: Callable[..., Path], angle: float, target: Any
) -> None:
    text, started = flat_later(angle)
    solver = load_dynamics(bodies_folder(scene_from_toml(text), ("positions",)), target=target)
    run: Any = solver.simulate(0.1, samples=4, parameters={"d": 2.0}, **started)
    assert run.ledger.trust.is_trusted
    assert travel(run, solver) > 0.02


def test_file_and_parameters_decide_alike(bodies_folder: Callable[..., Path]) -> None:
    for name, values in (
        ("four_bar", [1.01e-4, 1.5e-3, 2.03e-3, 2.08e-3, 3.1e-3]),
        ("door", [1.1e-3, 1.13e-3, 6e-3]),
        ("gears", [2.0022, 2.0023, 2.2]),
    ):
        text = SCENES[name][0]
        solver: Any = load_dynamics(bodies_folder(scene_from_toml(text), ("positions",)))
        ((key, of_scene),) = solver.parameters
        for value in values:
            of_file = text.replace(f"{key} = {given(of_scene, text, key)}", f"{key} = {value!r}")
            try:
                there: Any = load_dynamics(bodies_folder(scene_from_toml(of_file), ("positions",)))
                holds = any("nothing can move" in note for note in there.layout.notes)
            except SceneError:
                holds = False
            try:
                solver.simulate(0.01, samples=2, parameters={key: value})
                runs = True
            except SolveError:
                runs = False
            assert runs == holds, (name, value)


def given(value: float, text: str, key: str) -> str:
    """Value of a parameter as a text writes it."""
    found = text.partition(f"{{ {key} = ")[2].partition(" }")[0]
    assert float(found) == value
    return found


def test_rows_that_are_too_many_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = scene_from_toml(FOUR_BAR)
    assert "HAS_RANK" in generate_dynamics(scene, ("positions",))["solver.c"]
    monkeypatch.setattr(varying_rank, "MOST_ROWS_AT_ONCE", 5)
    tree = generate_dynamics(scene, ("positions",))
    assert "HAS_RANK" not in tree["solver.c"] and "integrate/rank.h" not in tree
    assert "which no run looks at: they are 20, more than 5" in tree["motion.json"]


def test_accelerations_with_such_parameters_are_told() -> None:
    mechanism = ks.load(tomllib.loads(FOUR_BAR))
    start: Any = mechanism.simulate(times=[0.0])
    _, q, v = start.state(0)
    with pytest.warns(UserWarning, match=r"beyond all others they hold .* of joints\.[ABCD] "):
        found = mechanism.evaluate(0.0, q, v, {"e": 1e-5})
    assert found.notes
    assert mechanism.evaluate(0.0, q, v).notes == ()
