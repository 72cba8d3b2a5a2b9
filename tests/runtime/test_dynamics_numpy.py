"""The solver in NumPy gives what the compiled one gives, and refuses what it refuses."""

from __future__ import annotations

import json
import os
import pickle
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.model.errors import MotionError, NoCompilerError, SolveError, TargetError
from kousoku.model.reading.builder import SceneBuilder
from kousoku.model.reading.families import chain, n_four_bar
from kousoku.model.reading.read import read_scene
from kousoku.runtime import notice
from kousoku.runtime.dynamics import load_dynamics
from kousoku.runtime.dynamics_targets import Memory, open_target
from kousoku.runtime.integrate.settings import Status
from kousoku.runtime.sources import Sources

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.model.records.scene import Scene
    from kousoku.runtime.dynamics import DynamicsSolver
    from kousoku.runtime.toolchain import Toolchain

    Folder = Callable[[str], Path]

SCENES = Path(__file__).parents[2] / "scenes"
ALL = ("accelerations", "reactions", "energies")
TARGETS: tuple[Any, Any] = ("c", "numpy")


def bob() -> Scene:
    """Point that a rod holds."""
    builder = SceneBuilder("bob", unit="m").gravity(0, -9.81, 0)
    builder.body("bob", position=(1, 0, 0), mass=1, point=True)
    builder.joint("rod", type="rod", bodies=("ground", "bob"), points=((0, 0, 0), (0, 0, 0)))
    return builder.build()


def cranks() -> Scene:
    """Two cranks that a rod couples: a single row holds them."""
    builder = SceneBuilder("cranks", unit="m").gravity(3, -9.81, 0)
    for name, x in (("a", 0.0), ("b", 2.0)):
        builder.body(name, position=(x, 1, 0), mass=1, inertia={"xx": 0.1, "yy": 0.1, "zz": 0.1})
        bodies, at, axis = ("ground", name), (x, 0, 0), (0, 0, 1)
        builder.joint(f"hinge_{name}", type="revolute", bodies=bodies, at=at, axis=axis)
    builder.joint("rod", type="rod", bodies=("a", "b"), points=((0, 0, 0), (0, -0.5, 0)))
    return builder.build()


MAKERS: dict[str, Callable[[], Scene]] = {
    "pendulum": lambda: read_scene(SCENES / "pendulum.toml"),
    "four_bar": lambda: n_four_bar(1),
    "heavy_top": lambda: read_scene(SCENES / "heavy_top.toml"),
    "chain": lambda: chain(5),
    "long_chain": lambda: chain(20),
    "free_body": lambda: read_scene(SCENES / "free_body.toml"),
    "bob": bob,
    "cranks": cranks,
}


@pytest.fixture
def folder(bodies_folder: Callable[..., Path]) -> Folder:
    """Folder of a scene of :data:`MAKERS` with all outputs."""
    return lambda name: bodies_folder(MAKERS[name](), ALL)


@pytest.fixture
def in_numpy(folder: Folder) -> Callable[[str], DynamicsSolver]:
    return lambda name: load_dynamics(folder(name), target="numpy")


@pytest.mark.usefixtures("shipped_flags")
@pytest.mark.usefixtures("numpy_solver")
@pytest.mark.parametrize(
    ("name", "end", "tolerance"),
    [
        ("pendulum", 2.0, 1e-12),
        ("four_bar", 1.0, 1e-8),
        ("heavy_top", 1.0, 1e-10),
        ("chain", 1.0, 1e-4),
        ("long_chain", 0.02, 1e-6),
        ("free_body", 1.0, 1e-10),
        ("bob", 1.0, 1e-10),
    ],
)
def test_rows_are_those_of_c(
    compiler: Toolchain, folder: Folder, name: str, end: float, tolerance: float
) -> None:
    motions = [
        load_dynamics(folder(name), target=target).simulate(end, samples=21, tolerance=tolerance)
        for target in ("c", "numpy")
    ]
    assert [motion.target for motion in motions] == ["c", "numpy"]
    one, other = (motion.columns() for motion in motions)
    assert [*one] == [*other]
    for key, values in one.items():
        scale = max(1.0, np.abs(values).max())
        np.testing.assert_allclose(other[key], values, rtol=0, atol=1e-10 * scale, err_msg=key)
    assert max(np.abs(one[key]).max() for key in one if ".v" in key or ".omega" in key) > 1e-2
    ledgers = [motion.ledger for motion in motions]
    assert ledgers[0].steps == ledgers[1].steps
    assert ledgers[0].rejected == ledgers[1].rejected
    assert ledgers[0].factorisations == ledgers[1].factorisations
    on_ground = {"free_body", "pendulum", "heavy_top"}  # nothing holds them, or the ground alone
    assert (ledgers[0].factorisations > 0) == (name not in on_ground)
    assert ledgers[0].energy_error == pytest.approx(ledgers[1].energy_error, abs=1e-12)
    for joint, violation in ledgers[0].violations.items():
        np.testing.assert_allclose(violation.metres, ledgers[1].violations[joint].metres, atol=1e-9)
    assert ledgers[1].worst("acceleration")[0] > 0.0 or not ledgers[0].violations


@pytest.mark.usefixtures("compiler", "numpy_solver")
def test_the_pivot_of_a_single_row_is_compared_with_those_before(folder: Folder) -> None:
    runs = [
        load_dynamics(folder("cranks"), target=target).begin([0.0, 1.0], tolerance=1e-6)
        for target in TARGETS
    ]
    assert all(run.finish().ledger.growth < 0.9 for run in runs)
    first, second = (run.save().state for run in runs)
    assert np.array_equal(first, second)


@pytest.mark.usefixtures("compiler", "numpy_solver", "shipped_flags")
def test_pivots_are_those_of_the_state_whatever_the_workspace_holds(
    bodies_folder: Callable[..., Path],
) -> None:
    scene, found = read_scene(SCENES / "piston_crank_bodies.toml"), []
    for target in TARGETS:
        solver = load_dynamics(bodies_folder(scene, ALL), target=target)
        run = solver.begin([0.0, 0.3], tolerance=1e-6)
        first = solver.state["least_pivot_ratio"].view(run.state).item()
        pivots = np.zeros(len(solver.rows))
        assert solver.target.pivots(run._memory, pivots) == Status.GOOD
        assert pivots.min() > 1.0
        assert first == pytest.approx(pivots.min() / pivots.max(), rel=1e-12)
        run.finish()
        for work in (run._memory.work, np.zeros_like(run._memory.work)):
            pivots = np.zeros(len(solver.rows))
            assert solver.target.pivots(Memory(run.state, work), pivots) == Status.GOOD
            found.append(pivots)
    for pivots in found[1:]:
        np.testing.assert_array_equal(pivots, found[0])


@pytest.mark.usefixtures("numpy_solver")
def test_run_in_small_calls_gives_the_same_bits(
    in_numpy: Callable[[str], DynamicsSolver],
) -> None:
    solver = in_numpy("chain")
    times = np.array([0.0, 0.01, 0.02, 0.03, 0.3])
    whole = solver.begin(times).finish()
    parts = solver.begin(times)
    reasons = {parts.advance(2, 2)}
    while reasons & {Status.BUFFER_FULL, Status.PAUSED} and parts.written < len(times):
        parts = solver.resume(parts.save())
        reasons.add(parts.advance(2, 2))
    assert reasons >= {Status.BUFFER_FULL, Status.PAUSED}
    for key, values in whole.columns().items():
        np.testing.assert_array_equal(parts.motion().columns()[key], values, err_msg=key)


@pytest.mark.usefixtures("numpy_solver")
def test_run_goes_on_with_the_same_bits_after_an_interrupt_inside_of_a_step(
    in_numpy: Callable[[str], DynamicsSolver], monkeypatch: pytest.MonkeyPatch
) -> None:
    solver = in_numpy("heavy_top")
    times = np.linspace(0.0, 0.5, 11)
    whole = solver.begin(times).finish()
    run = solver.begin(times)
    run.advance(max_steps=2)
    target: Any = solver.target
    workspace = sys.modules[type(target.solver.scene).__module__].Workspace
    compute, calls = workspace.run, []

    def interrupted(self: Any, segment: str) -> None:
        calls.append(segment)
        if calls.count("acceleration") == 20:
            raise KeyboardInterrupt
        compute(self, segment)

    with monkeypatch.context() as patch:
        patch.setattr(workspace, "run", interrupted)
        with pytest.raises(KeyboardInterrupt):
            run.advance(max_steps=50)
    assert run.steps == 2
    motion = run.finish()
    for key, values in whole.columns().items():
        np.testing.assert_array_equal(motion.columns()[key], values, err_msg=key)


@pytest.mark.usefixtures("numpy_solver")
@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_start_that_is_no_number_is_refused_as_in_c(
    compiler: Toolchain, folder: Folder, bad: float
) -> None:
    messages = set()
    for target in ("c", "numpy"):
        solver = load_dynamics(folder("pendulum"), target=target)
        solver.v[0] = bad
        with pytest.raises(SolveError, match="not finite") as refused:
            solver.simulate(1.0)
        messages.add(str(refused.value))
    assert len(messages) == 1


@pytest.mark.usefixtures("numpy_solver")
def test_start_that_cannot_be_assembled_is_refused_as_in_c(
    compiler: Toolchain, folder: Folder
) -> None:
    messages = set()
    for target in ("c", "numpy"):
        solver = load_dynamics(folder("bob"), target=target)
        solver.q[:] = 0.0
        with pytest.raises(SolveError, match="cannot be brought onto the constraints") as refused:
            solver.simulate(1.0)
        messages.add(str(refused.value))
    assert len(messages) == 1


@pytest.mark.usefixtures("numpy_solver")
def test_motion_that_needs_too_many_steps_stops_as_in_c(
    compiler: Toolchain, folder: Folder
) -> None:
    messages = set()
    for target in ("c", "numpy"):
        solver = load_dynamics(folder("pendulum"), target=target)
        with pytest.raises(MotionError, match="10 steps are made") as stopped:
            solver.simulate(10.0, most_steps=10)
        messages.add(str(stopped.value))
    assert len(messages) == 1


def test_state_of_another_solver_is_refused(in_numpy: Callable[[str], DynamicsSolver]) -> None:
    solver = in_numpy("pendulum")
    saved = solver.begin([0.0, 1.0]).save()
    saved.state[0] += 2.0
    with pytest.raises(SolveError, match="belongs to another solver"):
        solver.resume(saved.sealed())


@pytest.mark.usefixtures("numpy_solver")
def test_without_a_compiler_numpy_is_taken_after_one_line(
    folder: Folder, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setenv("KOUSOKU_CC", "none")
    monkeypatch.setattr(notice, "_said", set())
    motion = load_dynamics(folder("pendulum")).simulate(0.1, samples=3)
    assert motion.target == "numpy"
    load_dynamics(folder("chain"))
    why = "KOUSOKU_CC=none switches the C compiler off"
    assert caplog.messages == [
        f"kousoku uses the NumPy solver: {why}",
        f"kousoku uses the NumPy solver, which takes 100 to 200 times as long: {why}",
    ]
    with pytest.raises(NoCompilerError, match="KOUSOKU_CC=none"):
        load_dynamics(folder("pendulum"), target="c")


@pytest.mark.usefixtures("numpy_solver", "compiler")
def test_a_solver_that_travels_computes_where_there_is_no_compiler(
    folder: Folder, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    solver = load_dynamics(folder("pendulum"), target="c")
    wanted, sent = solver.simulate(0.1, samples=3), pickle.dumps(solver)
    monkeypatch.setenv("KOUSOKU_CC", "none")
    monkeypatch.setattr(notice, "_said", set())
    motion = pickle.loads(sent).simulate(0.1, samples=3)
    assert motion.target == "numpy" and "uses the NumPy solver" in caplog.text
    np.testing.assert_array_equal(motion.rows, wanted.rows)


def test_numpy_that_is_asked_for_says_so_only_where_it_is_slow(
    in_numpy: Callable[[str], DynamicsSolver],
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
) -> None:
    monkeypatch.setattr(notice, "_said", set())
    in_numpy("pendulum")
    assert not caplog.messages
    in_numpy("chain")
    assert ["100 to 200 times as long" in message for message in caplog.messages] == [True]


def test_folder_without_a_target_is_refused_or_the_other_is_taken(
    compiler: Toolchain, folder: Folder, monkeypatch: pytest.MonkeyPatch
) -> None:
    where = folder("pendulum")
    both = Sources.read(where)
    only_c, only_numpy = (
        replace(both, files={name: text for name, text in both.files.items() if name != left_out})
        for left_out in ("solver.py", "solver.c")
    )
    with pytest.raises(TargetError, match=r"without NumPy: solver\.py is not listed"):
        open_target(only_c, "numpy")
    with pytest.raises(TargetError, match=r"without C: solver\.c is not listed"):
        open_target(only_numpy, "c")
    assert open_target(only_numpy, "auto").name == "numpy"
    assert open_target(both, "auto").name == "c"
    other: Any = "fortran"
    with pytest.raises(TargetError, match="fortran"):
        open_target(both, other)
    monkeypatch.setenv("KOUSOKU_CC", "none")
    with pytest.raises(NoCompilerError):
        open_target(only_c, "auto")


@pytest.mark.usefixtures("numpy_solver")
@pytest.mark.parametrize("target", ["auto", "numpy"])
def test_command_line_simulates_without_a_compiler(target: str) -> None:
    options = ["--end", "0.5", "--json", "--target", target]
    done = subprocess.run(
        [sys.executable, "-m", "kousoku", "simulate", SCENES / "pendulum.toml", *options],
        capture_output=True,
        text=True,
        env={**os.environ, "KOUSOKU_CC": "none"},
        check=True,
    )
    assert json.loads(done.stdout)["target"] == "numpy"
    lines = done.stderr.splitlines()
    assert ["NumPy solver: KOUSOKU_CC=none" in line for line in lines] == [True] * (
        target == "auto"
    )


@pytest.mark.usefixtures("numpy_solver")
def test_solver_in_python_runs_alone_with_numpy(folder: Folder) -> None:
    code = (
        "import sys, json, numpy as np\n"
        "from pendulum.solver import SOLVER, SCENE\n"
        "from pendulum.integrate.settings import Settings, Status\n"
        "data = json.load(open('pendulum/motion.json'))\n"
        "state, work = np.zeros(SCENE.state_size), np.zeros(SCENE.work_size)\n"
        "q, v = np.array(data['q']), np.array(data['v'])\n"
        "assert SOLVER.start(0.0, q, v, None, state, work) == Status.GOOD\n"
        "rows = np.zeros((3, SCENE.row_size))\n"
        "settings = Settings(1e-9, 1e300, 0.0, True, 1)\n"
        "times = np.array([0.0, 0.5, 1.0])\n"
        "assert SOLVER.run(settings, times, 10**6, state, work, rows) == (Status.GOOD, 3)\n"
        "assert not {'kousoku', 'sympy', 'jinja2'} & set(sys.modules)\n"
        "print(json.dumps(rows[-1, 1:1 + SCENE.nq].tolist()))"
    )
    where = folder("pendulum")
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=where.parent, capture_output=True, text=True, check=True
    )
    run = load_dynamics(where, target="numpy").begin([0.0, 0.5, 1.0], method="dop853")
    assert run.advance(10**6) == Status.GOOD
    wanted = run.save().rows[-1, 1 : 1 + len(run.solver.q)].tolist()
    assert done.stdout.strip() == str(wanted)
