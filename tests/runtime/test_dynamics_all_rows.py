"""Several rows left out of a driven scene at once, against dense least squares in NumPy.

Three parallel cranks of one length stand beside each other, in three planes, and carry a coupler.
One of them is driven. Seven of their 31 rows depend on the others: two in the plane would do for
two cranks, and every further joint holds out of the plane what is held already. The rows that are
kept here are independent at the start, and lose rank where the cranks have turned by 1.1 rad.
"""

from __future__ import annotations

import math
import random
import sys
from importlib import import_module
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np
import pytest

import kousoku
from kousoku.codegen.dynamics.assembly.assemble import assemble
from kousoku.codegen.dynamics.composition.compose import compose
from kousoku.codegen.dynamics.emission.context_numbers import inverse_mass_table
from kousoku.codegen.dynamics.emission.emit import emit_dynamics
from kousoku.codegen.dynamics.generate import LEDGER_OUTPUTS, generate_dynamics
from kousoku.codegen.dynamics.recording.inline import inline
from kousoku.codegen.dynamics.recording.interpreter import ProgramInterpreter
from kousoku.codegen.dynamics.redundancy import redundant_rows
from kousoku.codegen.generate import write_tree
from kousoku.model.lowering.system import system_of
from kousoku.model.reading.read import read_scene, scene_from_toml
from kousoku.runtime.dynamics import load_dynamics
from kousoku.runtime.dynamics_targets import Memory
from kousoku.runtime.integrate import row_switch
from kousoku.runtime.integrate.scene_tables import Work
from kousoku.runtime.integrate.settings import Status
from tests.analysed import all_rows, independent, without
from tests.random_scenes import random_scene

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.codegen.dynamics.recording.program import Program
    from kousoku.model.mechanics.multibody import System
    from kousoku.model.numbers.real import Array
    from kousoku.model.records.scene import Scene

SCENES = Path(__file__).parents[2] / "scenes"
OUTPUTS = ("accelerations", "reactions", "energies")
START, RATE, END = 1.0, 1.5, 1.0
COUNT, APART = 3, 0.2
#: How far the cranks have turned where the rows below fail.
FAILS = 1.0996
#: What is left out on purpose: the joint, its kind, and the row.
BAD = {
    ("ground_0", "p1_z", 0),
    ("ground_1", "p1_z", 0),
    ("pin_0", "point", 1),
    ("pin_0", "p1_z", 0),
    ("pin_1", "point", 2),
    ("pin_1", "p1_z", 0),
    ("pin_2", "p1_z", 1),
}


def bar(shape: str, length: float) -> str:
    """Body: a box, or a rod without thickness."""
    if shape == "rods":
        return f"rods = [{{ mass = 1, ends = [[0, 0, 0], [{length}, 0, 0]] }}]"
    return f"boxes = [{{ mass = 1, size = [{length}, 0.1, 0.05], at = [{length / 2}, 0, 0] }}]"


def scene_of(shape: str = "boxes") -> Scene:
    x, y = math.cos(START), math.sin(START)
    turned = f"orientation = {{ axis = [0, 0, 1], angle = {START} }}"
    text = 'name = "cranks"\nunit = "m"\ngravity = [0, -9.81, 0]\n[parameters]\n'
    text += f"rate = {RATE}\nphase = 0\n"
    for k in range(COUNT):
        text += f"[bodies.crank_{k}]\nposition = [{k}, 0, {APART * k}]\n{turned}\n"
        text += bar(shape, 1.0) + "\n"
    text += f"[bodies.coupler]\nposition = [{x!r}, {y!r}, 0]\n{bar(shape, COUNT - 1.0)}\n[joints]\n"
    for k in range(COUNT):
        for name, pair, at in (
            (f"ground_{k}", f'"ground", "crank_{k}"', (k, 0.0)),
            (f"pin_{k}", f'"crank_{k}", "coupler"', (k + x, y)),
        ):
            text += f'{name} = {{ type = "revolute", bodies = [{pair}], axis = [0, 0, 1], '
            text += f"at = [{at[0]!r}, {at[1]!r}, {APART * k!r}] }}\n"
    text += '[drivers]\nmotor = { joint = "ground_0", value = "phase + rate*t" }\n'
    return scene_from_toml(text)


@pytest.fixture(scope="module")
def system() -> System:
    return assemble(system_of(scene_of(), OUTPUTS))


@pytest.fixture(scope="module")
def good(system: System) -> Program:
    return compose(independent(system, may_be_planar=False), (*LEDGER_OUTPUTS, *OUTPUTS))


@pytest.fixture(scope="module")
def bad(system: System) -> Program:
    whole = all_rows(system, may_be_planar=False)
    rows = [
        row
        for row in whole.outline.rows
        if (row.joint, system.constraints[row.instance].kind, row.row) in BAD
    ]
    joints = [one.joint for one in system.constraints if not one.is_driver]
    found = compose(without(whole, rows, joints), (*LEDGER_OUTPUTS, *OUTPUTS))
    assert len(found.left_out) == len(BAD)
    return found


@pytest.fixture(scope="module")
def folders(
    system: System, good: Program, bad: Program, tmp_path_factory: pytest.TempPathFactory
) -> dict[str, Path]:
    found = {}
    for name, program in (("good", good), ("bad", bad)):
        found[name] = tmp_path_factory.mktemp(name) / system.name
        write_tree(found[name], emit_dynamics(inline(program), system, OUTPUTS))
    return found


def dense(program: Program, system: System, row: Array, phase: float = 0.0) -> tuple[Array, float]:
    """Accelerations, and the multiplier of the driver, by least squares with all rows."""
    work, n = ProgramInterpreter(program), len(program.rows)
    work["parameters"] = [RATE, phase]
    parts = np.split(row, np.cumsum([1, len(work["q"]), len(work["v"])]))
    for name, values in zip(("t", "q", "v"), parts, strict=False):
        work[name] = values.tolist()
    work.run("geometry", "acceleration")
    v_dot, lam = np.array(work["v_dot"]), np.array(work["lam"])
    rows = np.zeros((n + len(program.left_out), len(v_dot)))
    work["v"], work["v_dot"] = [0.0] * len(v_dot), [0.0] * len(v_dot)
    work.run("check")
    rest = np.array(work["C_dot"])
    for k in range(len(v_dot)):
        work["v"] = np.eye(len(v_dot))[k].tolist()
        work.run("check")
        rows[:, k] = np.array(work["C_dot"]) - rest
    work["v"] = parts[2].tolist()
    work.run("check")
    gamma, inverse = -np.array(work["C_ddot"]), np.array(inverse_mass_table(program, system))
    free = v_dot + inverse * (rows[:n].T @ lam)
    root = np.sqrt(inverse)
    change = np.linalg.lstsq(rows * root, gamma - rows @ free, rcond=1e-10)[0]
    forces = np.linalg.lstsq((rows * root).T, -change, rcond=1e-10)[0]
    motor = [k for k, one in enumerate(program.rows) if one.joint == "motor"]
    return free + root * change, float(forces[motor[0]])


@pytest.mark.parametrize("method", ["kinematics", "dopri5"])
def test_motion_and_forces_are_those_of_a_good_choice_and_of_least_squares(
    folders: dict[str, Path], system: System, good: Program, backend: str, method: str
) -> None:
    times, target = np.linspace(0.0, END, 6), cast("Any", backend)
    runs = {
        name: load_dynamics(folder, target=target).begin(times, tolerance=1e-10, method=method)
        for name, folder in folders.items()
    }
    one, other = (runs[name].finish() for name in ("good", "bad"))
    assert other.ledger.fallbacks > one.ledger.fallbacks
    for name in ("acceleration", "force", "torque"):
        for key, values in getattr(one, name).items():
            np.testing.assert_allclose(getattr(other, name)[key], values, rtol=0, atol=1e-8)
    assert np.abs(one.force["pin_1"]).max() > 1.0
    np.testing.assert_allclose(other.work["motor"], one.work["motor"], rtol=0, atol=1e-8)
    for row, torque in zip(runs["bad"].save().rows, other.torque["motor"], strict=True):
        v_dot, lam = dense(good, system, row)
        first = 1 + len(runs["bad"].solver.q) + len(v_dot)
        np.testing.assert_allclose(row[first : first + len(v_dot)], v_dot, rtol=0, atol=1e-8)
        assert abs(torque[2]) == pytest.approx(abs(lam), abs=1e-8)
    assert np.abs(other.torque["motor"]).max() > 10.0


@pytest.mark.usefixtures("compiler", "numpy_solver")
def test_run_that_begins_where_rows_fail_takes_all_from_the_start(
    folders: dict[str, Path], system: System, good: Program
) -> None:
    targets: tuple[Any, Any] = ("c", "numpy")
    solvers = [load_dynamics(folders["bad"], target=target) for target in targets]
    how: dict[str, Any] = {"tolerance": 1e-10, "parameters": {"phase": FAILS}}
    one, other = (solver.begin([0.0, 0.01], **how) for solver in solvers)
    assert one.finish().ledger.fallbacks > 0
    for row in one.save().rows:
        v_dot, _ = dense(good, system, row, phase=FAILS)
        first = 1 + len(solvers[0].q) + len(v_dot)
        np.testing.assert_allclose(row[first : first + len(v_dot)], v_dot, rtol=0, atol=1e-10)
    other.finish()
    np.testing.assert_array_equal(one.state, other.state)


@pytest.mark.usefixtures("compiler", "numpy_solver")
def test_what_is_usual_is_said_by_all_rows_where_those_kept_fail_at_the_start(
    folders: dict[str, Path],
) -> None:
    targets: tuple[Any, Any] = ("c", "numpy")
    solvers = [load_dynamics(folders["bad"], target=target) for target in targets]
    run = solvers[0].begin([0.0], parameters={"phase": FAILS})
    run.finish()
    _, q, v = np.split(run.save().rows[0], np.cumsum([1, len(solvers[0].q)]))
    v, found = v[: len(solvers[0].v)], []
    for solver in solvers:
        target: Any = solver.target
        memory = Memory(np.zeros(target.state_size), np.zeros(target.work_size))
        parameters = np.array([RATE, 0.0])
        assert target.starter(FAILS / RATE, q, v, parameters, memory)() == Status.GOOD
        assert solver.state["fallbacks"].view(memory.state) > 0
        found.append(memory.state)
    np.testing.assert_array_equal(found[0], found[1])


def test_driver_is_solved_for_however_heavy_what_it_moves(folders: dict[str, Path]) -> None:
    """Rounding leaves more of rows that depend on others than a heavy body has for a pivot."""
    solver = load_dynamics(folders["bad"], target="numpy")
    target: Any = solver.target
    scene, slots = target.solver.scene, np.zeros(target.work_size)
    target.evaluate(0.0, solver.q, solver.v, scene.parameters, slots)
    work = Work(scene, slots)
    assert work.row_switch is not None
    row_switch.write_jacobian(work.row_switch, work)
    ((motor, _),) = scene.drivers
    work.row_switch.rows[motor] *= 1e-9
    assert 0.0 < row_switch.factorise_rows(work.row_switch, work, 0.0) < 1e-17
    assert motor in work.row_switch.order[: scene.nc]


@pytest.mark.usefixtures("numpy_solver")
def test_all_rows_are_not_tried_again_where_they_did_not_help(
    bodies_folder: Callable[..., Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where the cranks lie along the ground all rows are as weak as those that are kept."""
    solver = load_dynamics(bodies_folder(scene_of(), ()), target="numpy")
    target: Any = solver.target
    integrate = sys.modules[type(target.solver).__module__.removesuffix(".scene_solver")]
    module = import_module(".row_switch", integrate.__name__)
    users = [
        import_module(f".{name}", integrate.__name__) for name in ("stepper", "rows", "kinematics")
    ]
    tried: list[float] = []  # ratios of rows kept where all rows did not help, 0 where forgotten
    are_better, factorise = module.are_all_rows_better, module.factorise_rows
    made: list[float] = []

    def made_of(*given: Any) -> float:
        made.append(factorise(*given))
        return made[-1]

    def noted(ratio: float, *given: Any) -> bool:
        before = len(made)
        helps = bool(are_better(ratio, *given))
        if len(made) > before:
            tried.append(0.0 if helps else ratio)
        return helps

    monkeypatch.setattr(module, "factorise_rows", made_of)
    monkeypatch.setattr(module, "are_all_rows_better", noted)
    forget = module.forget_trials

    def forgot(work: Any) -> None:
        tried.append(0.0)
        forget(work)

    for user in users:
        monkeypatch.setattr(user, "forget_trials", forgot)
    motion = solver.simulate(2.0, samples=3, tolerance=1e-6, parameters={"rate": -1.0})
    assert motion.ledger.growth < 1e-3
    pairs = [(a, b) for a, b in pairwise(tried) if a > 0.0 and b > 0.0]
    assert len([ratio for ratio in tried if ratio > 0.0]) > 5
    assert all(max(pair) >= module.HELPS * min(pair) for pair in pairs)


@pytest.mark.usefixtures("shipped_flags")
@pytest.mark.usefixtures("numpy_solver")
def test_both_targets_give_the_same_bits(compiler: object, folders: dict[str, Path]) -> None:
    one, other = (
        load_dynamics(folders["bad"], target=target).begin(np.linspace(0.0, END, 21))
        for target in ("c", "numpy")
    )
    assert one.finish().ledger.fallbacks > 0
    other.finish()
    np.testing.assert_array_equal(one.state, other.state)
    np.testing.assert_array_equal(one.save().rows, other.save().rows)


@pytest.mark.usefixtures("numpy_solver")
def test_thin_bodies_have_the_thickness_with_all_rows_that_they_have_with_those_kept(
    bodies_folder: Callable[..., Path],
) -> None:
    """In the plane they need none; their forces lead out of it, and are computed in space."""
    solver = load_dynamics(bodies_folder(scene_of("rods"), OUTPUTS), target="numpy")
    motion = solver.simulate(END, samples=3, tolerance=1e-10)
    assert (len(solver.rows), len(solver.left_out)) == (24, 7)
    assert motion.ledger.fallbacks > 0
    assert motion.ledger.growth > 1e-4


@pytest.mark.usefixtures("compiler", "numpy_solver")
@pytest.mark.parametrize("name", ["bricard", "oldham_coupling"])
def test_loops_share_out_forces_as_the_code_of_a_scene_does(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    scene = read_scene(SCENES / f"{name}.toml")
    found = {}
    for how, most in (("in_code", 2000), ("in_loops", 0)):
        monkeypatch.setattr(redundant_rows, "MOST_UNROLLED", most)
        tree = generate_dynamics(scene, ("reactions", "accelerations"))
        assert ("#define SHARES_OUT 1" in tree["solver.c"]) == (not most)
        assert ("static void reaction(" in tree["solver.c"]) == bool(most)
        write_tree(tmp_path / how, tree)
        solvers = [load_dynamics(tmp_path / how, target=target) for target in ("c", "numpy")]
        one, other = (solver.simulate(0.1, samples=3, tolerance=1e-5).rows for solver in solvers)
        np.testing.assert_array_equal(one, other)
        one, other = (solver.evaluate()["reactions"] for solver in solvers)
        np.testing.assert_array_equal(one, other)
        found[how] = solvers[0].simulate(0.1, samples=3, tolerance=1e-5).rows, one
    for one, other in zip(found["in_code"], found["in_loops"], strict=True):
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-11 * np.abs(one).max())


def test_code_shares_out_what_is_little_and_loops_what_is_much() -> None:
    assert not redundant_rows.shares_out(29, 1)
    assert redundant_rows.shares_out(150, 39)
    assert not redundant_rows.shares_out(190, 39), "loops are over 200 rows at most"


@pytest.mark.compiles
@pytest.mark.usefixtures("numpy_solver")
@pytest.mark.parametrize("target", ["numpy", "c"])
def test_rates_of_drivers_are_checked_where_all_rows_are_solved_for(target: Any) -> None:
    # three cranks in line, one driven at 1 rad/s: one of the numbers that are equal to a pivot
    scene = random_scene(random.Random("1 21 7"))
    run = kousoku.load(scene, target=target).simulate(0.25, samples=3, method="kinematics")
    assert run.ledger.fallbacks > 0
    assert max(run.ledger.worst("velocity")) < 1e-9
