"""Masses, lengths, points and axes that are arguments of a solver: equal to numbers folded in."""

from __future__ import annotations

import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec
import numpy as np
import pytest

from kousoku.codegen.dynamics.assembly.assemble import assemble
from kousoku.model.errors import SolveError
from kousoku.model.expressions.design_numbers import read_formulas, with_numbers
from kousoku.model.lowering.system import system_of
from kousoku.model.reading.read import scene_from_toml
from kousoku.model.records.problems import Problems
from kousoku.runtime.dynamics import load_dynamics
from kousoku.runtime.dynamics_targets import Memory
from kousoku.runtime.integrate import row_switch
from kousoku.runtime.integrate.scene_tables import Work
from kousoku.runtime.integrate.settings import Status
from tests.runtime.test_dynamics_row_switch import BAD, END, write_without
from tests.runtime.test_dynamics_row_switch import SCENE as BRICARD

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.model.records.scene import Scene

FOLDER = Path(__file__).parents[1] / "scenes" / "design"
SCENES = {path.stem: path.read_text(encoding="utf-8") for path in sorted(FOLDER.glob("*.toml"))}
BELL, DRIVEN, FOUR_BAR, LOOP, PENDULUM, TOP = (
    SCENES[name] for name in ("bell", "driven", "four_bar", "loop", "pendulum", "top")
)
OUTPUTS = ("positions", "velocities", "accelerations", "reactions", "energies")
#: Regions with which a solver is compared; further ones where both solve for the same rows.
REGIONS = ("v_dot", "reactions", "energies", "q_dot")
OF_ROWS = ("lam", "C", "dq")


def drawn(scene: Scene, seed: int) -> dict[str, float]:
    """Other values of the parameters, a tenth away."""
    random = np.random.default_rng(seed)
    return {
        name: value * (1 + random.uniform(-0.1, 0.1)) for name, value in scene.parameters.items()
    }


def folded(scene: Scene, values: dict[str, float]) -> Scene:
    """Scene with the numbers that some parameters make in place of its formulas."""
    other = msgspec.structs.replace(scene, parameters=values, name=f"{scene.name}_folded")
    return with_numbers(read_formulas(other, Problems()))


@pytest.fixture
def load(bodies_folder: Callable[..., Path]) -> Callable[..., Any]:
    def loaded(scene: Scene, target: Any = "c") -> Any:
        return load_dynamics(bodies_folder(scene, OUTPUTS), target=target)

    return loaded


@pytest.mark.parametrize("name", SCENES)
def test_a_number_that_is_given_is_as_good_as_one_that_is_folded_in(
    load: Callable[..., Any], name: str
) -> None:
    scene = scene_from_toml(SCENES[name])
    solver = load(scene, "numpy")
    given = drawn(scene, 1)
    wanted = load(folded(scene, given), "numpy")
    state = wanted.evaluate(0.25)
    found = solver.evaluate(0.25, wanted.q, wanted.v, given)
    for region in (*REGIONS, *(OF_ROWS if solver.rows == wanted.rows else ())):
        size = 1e-3 if region in {"C", "dq"} else np.abs(state[region]).max()
        np.testing.assert_allclose(
            found[region], state[region], rtol=0, atol=1e-12 * size, err_msg=region
        )


@pytest.mark.usefixtures("numpy_solver")
def test_joined_bodies_take_the_masses_of_the_run(bodies_folder: Callable[..., Path]) -> None:
    scene, outputs = scene_from_toml(SCENES["joined"]), ("accelerations", "energies")
    given = drawn(scene, 5)
    solver, wanted = (
        load_dynamics(bodies_folder(one, outputs), target="numpy")
        for one in (scene, folded(scene, given))
    )
    assert (len(solver.bodies), len(solver.q)) == (4, 15)  # two bodies move, and a work
    found, state = solver.evaluate(0.0, parameters=given), wanted.evaluate(0.0)
    for region in ("v_dot", "energies", "momenta"):
        size = np.abs(state[region]).max()
        np.testing.assert_allclose(found[region], state[region], rtol=0, atol=1e-13 * size)
    a = solver.simulate(1e-3, samples=2, parameters=given).position
    b = wanted.simulate(1e-3, samples=2).position
    for body in b:
        np.testing.assert_allclose(a[body], b[body], rtol=0, atol=1e-13)


@pytest.mark.usefixtures("compiler")
@pytest.mark.parametrize("text", [PENDULUM, FOUR_BAR, LOOP, TOP, DRIVEN])
def test_a_motion_with_parameters_is_that_of_the_numbers(
    load: Callable[..., Any], text: str
) -> None:
    scene = scene_from_toml(text)
    given = drawn(scene, 3)
    wanted = load(folded(scene, given))
    there = replace(load(scene).at(given), q=wanted.q, v=wanted.v)
    how: dict[str, Any] = {"samples": 11, "tolerance": 1e-11}
    found, expected = there.simulate(1.0, parameters=given, **how), wanted.simulate(1.0, **how)
    size = wanted.length / wanted.unit
    for body, position in expected.position.items():
        np.testing.assert_allclose(found.position[body], position, rtol=0, atol=1e-9 * size)
    size = max(np.abs(force).max() for force in expected.force.values())
    for joint, force in expected.force.items():
        np.testing.assert_allclose(found.force[joint], force, rtol=0, atol=1e-8 * size)
    energy = expected.energy["total"]
    size = max(np.abs(part).max() for part in expected.energy.values())
    np.testing.assert_allclose(found.energy["total"], energy, rtol=0, atol=1e-9 * size)


TWIN = """
name = "twin"
unit = "m"
[parameters]
I = 0.2
z = 0.0
[bodies]
b = { position = [0, 0, 0], mass = 1, angular_velocity = [0.1, 0.2, 1.0], \
inertia = { xx = "I", yy = "I", zz = 0.3, xy = "z" } }
"""


@pytest.mark.usefixtures("compiler")
@pytest.mark.parametrize("z", [0.0, 0.05, -0.05])
def test_moments_that_are_equal_may_be_formulas(load: Callable[..., Any], z: float) -> None:
    scene = scene_from_toml(TWIN)
    how: dict[str, Any] = {"samples": 3, "tolerance": 1e-11}
    found = load(scene).simulate(1.0, parameters={"z": z}, **how)
    wanted = load(folded(scene, {"I": 0.2, "z": z})).simulate(1.0, **how)
    for table in ("orientation", "angular_velocity"):
        a, b = getattr(found, table)["b"], getattr(wanted, table)["b"]
        np.testing.assert_allclose(a, b, rtol=0, atol=1e-10)


def test_a_folder_alone_says_what_moments_it_wants(bodies_folder: Callable[..., Path]) -> None:
    folder = bodies_folder(scene_from_toml(TWIN))
    script = f"""
import sys
sys.modules["kousoku"] = None
sys.path.insert(0, {str(folder.parent)!r})
from twin import simulate
simulate(0.1, samples=2, parameters={{"I": 0.16}})
try:
    simulate(0.1, samples=2, parameters={{"I": 0.14}})
except ValueError as error:
    assert "no moment is larger than the two others together" in str(error), error
else:
    raise AssertionError
"""
    subprocess.run([sys.executable, "-c", script], check=True, timeout=120)


@pytest.mark.usefixtures("compiler")
def test_frames_stay_where_they_start_when_parameters_turn_principal_axes(
    load: Callable[..., Any],
) -> None:
    scene = scene_from_toml(BELL)
    given = {"a": 0.7, "b": 0.9, "m": 1.2}  # the longer arm is the other one: axes change places
    wanted, solver = load(folded(scene, given)), load(scene)
    how: dict[str, Any] = {"samples": 6, "tolerance": 1e-11}
    found, expected = solver.simulate(0.5, parameters=given, **how), wanted.simulate(0.5, **how)
    assert np.abs(solver.at(given).q - wanted.q).max() > 0.1
    for table in ("position", "orientation", "velocity", "angular_velocity", "acceleration"):
        a, b = getattr(found, table)["bell"], getattr(expected, table)["bell"]
        if table == "orientation":
            a = a * np.sign((a * b).sum(axis=1))[:, None]
        np.testing.assert_allclose(a, b, rtol=0, atol=1e-9 * max(1.0, np.abs(b).max()))
    np.testing.assert_allclose(found.torque["cross"], expected.torque["cross"], rtol=0, atol=1e-8)
    again = solver.at(given).simulate(0.5, **how)
    assert again.ledger.parameters == found.ledger.parameters
    np.testing.assert_array_equal(again.told.rows, found.told.rows)


@pytest.mark.usefixtures("compiler", "shipped_flags")
@pytest.mark.usefixtures("numpy_solver")
@pytest.mark.parametrize("name", ["four_bar", "coupled"])
def test_c_and_numpy_make_the_same_bits_of_parameters(load: Callable[..., Any], name: str) -> None:
    scene = scene_from_toml(SCENES[name])
    given = drawn(scene, 4)
    rows = [
        load(scene, target).begin([0.0, 0.02], parameters=given, tolerance=1e-6)
        for target in ("c", "numpy")
    ]
    for run in rows:
        run.finish()
    a, b = (run.save().rows for run in rows)
    if name == "coupled":  # angles: libraries differ in the last digit
        np.testing.assert_allclose(a, b, rtol=0, atol=1e-9 * np.abs(b).max())
    else:
        np.testing.assert_array_equal(a, b)


@pytest.mark.usefixtures("compiler")
def test_far_parameters_are_reached_on_the_branch_of_the_scene(load: Callable[..., Any]) -> None:
    scene = scene_from_toml(FOUR_BAR)
    given = {"a": 0.6, "b": 4.4, "c": 3.6, "g": 4.2, "rho": 3.0}
    motion = load(scene).simulate(1e-6, samples=2, parameters=given)
    pins = motion.position
    ends = {
        body: pins[body][0] + length * _first_axis(motion.orientation[body][0])
        for body, length in (("crank", 0.6), ("coupler", 4.4), ("rocker", 3.6))
    }
    np.testing.assert_allclose(ends["crank"], pins["coupler"][0], atol=1e-12)
    np.testing.assert_allclose(ends["coupler"], ends["rocker"], atol=1e-12)
    np.testing.assert_allclose(pins["rocker"][0], [4.2, 0.0, 0.0], atol=1e-12)
    assert ends["rocker"][1] > 1.0  # the coupler is above the frame, as in the scene


def _first_axis(e: Any) -> Any:
    w, x, y, z = e
    return np.array([w * w + x * x - y * y - z * z, 2 * (x * y + w * z), 2 * (x * z - w * y)])


@pytest.mark.usefixtures("compiler", "numpy_solver")
@pytest.mark.parametrize("target", ["c", "numpy"])
def test_lengths_that_do_not_close_are_told_with_the_parameters(
    load: Callable[..., Any], target: str
) -> None:
    solver = load(scene_from_toml(FOUR_BAR), target)
    says = r"with a = 9, b = 3, .*no way of closed joints leads"
    with pytest.raises(SolveError, match=says) as caught:
        solver.simulate(1.0, parameters={"a": 9.0})
    # where the others are stretched, b + c + g, the crank is too long by what both of its ends miss
    gaps = dict(re.findall(r"joints\.(\w+) by (\S+) m", str(caught.value)))
    assert sum(map(float, gaps.values())) == pytest.approx(9.0 - (3.0 + 2.5 + 3.2), rel=1e-3), gaps


@pytest.mark.usefixtures("compiler")
def test_the_origin_of_a_body_stays_while_its_centre_of_mass_moves(
    load: Callable[..., Any],
) -> None:
    solver = load(scene_from_toml(PENDULUM))
    q, _ = solver.at({"L": 80.0}).q, solver.q
    assert 0.75 in solver.q
    assert 0.4 in q
    motion = solver.simulate(0.1, samples=2, parameters={"L": 80.0})
    np.testing.assert_allclose(motion.position["bar"], np.zeros((2, 3)), rtol=0, atol=1e-13)


@pytest.mark.usefixtures("compiler")
@pytest.mark.parametrize(
    ("given", "wanted"),
    [
        ({"m": -1.0}, r"bodies\.bar\.mass is -1; wanted a positive number"),
        ({"m": 0.0}, r"bodies\.bar\.mass is 0; wanted a positive number"),
        ({"L": 0.0}, r"bodies\.bar\.inertia is 0; wanted"),
        ({"L": 1e300}, r"no finite value"),
    ],
)
@pytest.mark.parametrize("target", ["c", "numpy"])
def test_impossible_numbers_are_refused_by_name(
    load: Callable[..., Any], target: str, given: dict[str, float], wanted: str
) -> None:
    solver = load(scene_from_toml(PENDULUM), target)
    with pytest.raises(SolveError, match=wanted):
        solver.simulate(1.0, parameters=given)
    with pytest.raises(SolveError, match=wanted):
        solver.evaluate(0.0, parameters=given)
    values = np.array([*({"m": 2.0, "L": 150.0} | given).values()])
    memory = Memory(np.zeros(solver.target.state_size), np.zeros(solver.target.work_size))
    start = solver.target.starter(0.0, solver.q, solver.v, values, memory)
    assert start() == Status.BAD_ARGUMENT
    evaluated = solver.target.evaluate(0.0, solver.q, solver.v, values, memory.work)
    assert evaluated == Status.BAD_ARGUMENT


@pytest.mark.usefixtures("compiler")
def test_rows_that_depend_on_others_in_the_scene_only_are_not_lost(
    load: Callable[..., Any],
) -> None:
    text = re.sub(r"\[joints.hinge\].*", "", PENDULUM, flags=re.S)
    for name, height in (("low", '"20*m"'), ("high", "100")):
        text += f"""
[joints.{name}]
type = "revolute"
bodies = ["ground", "bar"]
points = [[0, {height}, 0], [0, {40 if name == "low" else 100}, 0]]
axes = [[0, 1, 0], [0, 1, 0]]
"""
    solver = load(scene_from_toml(text.replace('name = "pendulum"', 'name = "door"')))
    solver.simulate(0.1, samples=2, parameters={"L": 100.0})
    with pytest.raises(
        SolveError, match=r"with m = 2.5, L = 150: joints stay open, or come open .*: joints\."
    ):
        solver.simulate(0.1, samples=2, parameters={"m": 2.5})


@pytest.mark.usefixtures("compiler")
def test_parameters_need_no_algebra_and_no_compiler(bodies_folder: Callable[..., Path]) -> None:
    folder = bodies_folder(scene_from_toml(PENDULUM), OUTPUTS)
    load_dynamics(folder)  # compiles
    script = f"""
import os, sys
os.environ["KOUSOKU_CC"] = "none"
sys.path.insert(0, {str(folder.parent)!r})
from pendulum import simulate
a = simulate(0.2, samples=3, parameters={{"L": 80.0, "m": 3.0}})
b = simulate(0.2, samples=3)
assert abs(a.position["bar"]).max() < 1e-12 and abs(b.position["bar"]).max() < 1e-12
assert a.orientation["bar"][-1][2] > b.orientation["bar"][-1][2]
assert not {{"sympy", "jinja2", "mpmath"}} & set(sys.modules)
"""
    subprocess.run([sys.executable, "-c", script], check=True, timeout=120)


@pytest.mark.usefixtures("numpy_solver")
def test_rows_that_take_over_are_weighed_with_the_masses_of_the_run(
    compiler: object, tmp_path: Path
) -> None:
    text = BRICARD.read_text(encoding="utf-8").replace("mass = 1,", 'mass = "m",', 1)
    systems = [
        assemble(system_of(scene_from_toml(f"{text}\n[parameters]\nm = {m}\n"))) for m in (0.4, 1.5)
    ]
    folders = [
        write_without(BAD, system, _made(tmp_path / str(k))) for k, system in enumerate(systems)
    ]
    how: dict[str, Any] = {"samples": 41, "tolerance": 1e-10}
    solver = load_dynamics(folders[0], target="c")
    found = solver.simulate(END, parameters={"m": 1.5}, **how)
    wanted = load_dynamics(folders[1], target="c").simulate(END, **how)
    assert found.ledger.fallbacks > 0
    assert found.ledger.energy_error == pytest.approx(0.0, abs=2e-8)
    for body, position in wanted.position.items():
        np.testing.assert_allclose(found.position[body], position, rtol=0, atol=1e-8)
    one, other = (
        load_dynamics(folders[0], target=target).begin([0.0, 1.0], parameters={"m": 1.5})
        for target in ("c", "numpy")
    )
    for run in (one, other):
        run.finish()
    np.testing.assert_array_equal(one.state, other.state)
    target: Any
    of_file: Any
    target, of_file = (load_dynamics(folder, target="numpy").target for folder in folders)
    slots = np.zeros(target.work_size)
    work = Work(target.solver.scene, slots)
    target.evaluate(0.0, solver.q, solver.v, np.array([1.5]), slots)
    assert 0 in work.scene.mass_places  # the first number of the design is a mass, too
    weighed = row_switch.inverse_masses(work)
    np.testing.assert_allclose(weighed, of_file.solver.scene.inverse_masses, rtol=1e-15, atol=0)


def _made(folder: Path) -> Path:
    folder.mkdir()
    return folder


#: A body that hangs on a ball joint: two rods, and a mass off their axes.
RODS = """
name = "rods"
unit = "m"
gravity = [0, 0, -9.81]
parameters = { c = 0.6, s = 0.8, m = 1.0, p = 0.5 }
[bodies.b]
position = [0, 0, 0]
orientation = { axis = [1, 2, 3], angle = 0.7 }
velocity = [0.1, 0.2, 0.3]
angular_velocity = [1, 2, -3]
rods = [
    { mass = 1, ends = [[-1, 0, 0], [1, 0, 0]] },
    { mass = "m", ends = [["-c", "-s", 0], ["c", "s", 0]] },
]
mass_points = [{ mass = 0.3, at = ["p", "-p/2", 0] }]
[joints.j]
type = "ball"
bodies = ["ground", "b"]
points = [[0, 0, 0], [0.2, "s", 0.1]]
"""


@pytest.mark.parametrize(
    "values",
    [
        {"c": 0.0, "s": 1.0, "m": 1.0, "p": 0.0},  # equal moments
        {"c": 0.0, "s": 1.2, "m": 1.0, "p": 0.5},  # the larger is the smaller one
        {"c": -0.8, "s": -0.6, "m": 3.0, "p": -1.0},
    ],
)
def test_principal_axes_go_through_equal_moments(
    load: Callable[..., Any], backend: str, values: dict[str, float]
) -> None:
    """The inertia was no number where moments are equal, and behind that no way led there."""
    scene = scene_from_toml(RODS)
    motion = load(scene, backend).simulate(1.0, samples=3, parameters=values, tolerance=1e-11)
    wanted = load(folded(scene, values), backend).simulate(1.0, samples=3, tolerance=1e-11)
    for name in ("position", "orientation", "velocity", "angular_velocity"):
        found, other = (getattr(one, name)["b"] for one in (motion, wanted))
        np.testing.assert_allclose(found, other, rtol=0, atol=1e-9, err_msg=name)
