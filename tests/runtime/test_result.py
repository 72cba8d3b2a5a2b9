"""Results: columns and tables by name, units, what is refused, files; what travels and restarts."""

from __future__ import annotations

import copy
import multiprocessing
import pickle
import shutil
from concurrent.futures import ProcessPoolExecutor
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.codegen.dynamics.generate import generate_dynamics
from kousoku.codegen.generate import write_tree
from kousoku.generated import lever_crank
from kousoku.model.errors import MotionError, SolveError
from kousoku.model.reading.read import scene_from_toml
from kousoku.runtime.dynamics import load_dynamics
from kousoku.runtime.integrate import body_tables as tables_of_bodies
from kousoku.runtime.integrate import motion as motions
from kousoku.runtime.integrate.body_tables import body_tables
from kousoku.runtime.linkage import load_linkage

if TYPE_CHECKING:
    from pathlib import Path

    from kousoku.runtime.dynamics import DynamicsSolver

pytestmark = pytest.mark.usefixtures("compiler")

ARM = """
name = "arm"
unit = "mm"
gravity = [0, -9810, 0]
[parameters]
speed = 2
[bodies]
bob = { position = [500, 0, 0], mass = 0.5, point = true }
[bodies.bar]
position = [0, 0, 0]
cylinders = [{ mass = 1, ends = [[0, 0, 0], [500, 0, 0]], radius = 9 }]
[joints.pin]
type = "revolute"
bodies = ["ground", "bar"]
points = [[0, 0, 0], [0, 0, 0]]
axes = [[0, 0, 1], [0, 0, 1]]
[joints.end]
type = "ball"
bodies = ["bar", "bob"]
at = [500, 0, 0]
[coordinates]
swing = { joint = "pin" }
[drivers]
motor = { joint = "pin", value = "speed*t" }
"""
ALL = ("accelerations", "reactions", "energies", "coordinates")


def solver_in(folder: Path, outputs: tuple[str, ...] = ALL) -> DynamicsSolver:
    write_tree(folder / "arm", generate_dynamics(scene_from_toml(ARM), outputs))
    return load_dynamics(folder / "arm")


@pytest.fixture(scope="module")
def solver(tmp_path_factory: pytest.TempPathFactory, compiler: object) -> DynamicsSolver:
    return solver_in(tmp_path_factory.mktemp("result"))


@pytest.fixture(scope="module")
def bare(tmp_path_factory: pytest.TempPathFactory, compiler: object) -> Any:
    return solver_in(tmp_path_factory.mktemp("bare"), ()).simulate(0.5, samples=3)


def test_a_column_a_table_and_a_part_are_the_same_numbers(solver: DynamicsSolver) -> None:
    run = solver.simulate(1.0, samples=11)
    assert run["swing"][-1] == pytest.approx(2.0, abs=1e-9)
    tip = 500 * np.cos(run["swing"])
    np.testing.assert_allclose(run["bob.x"], tip, atol=1e-6)
    np.testing.assert_array_equal(run.body("bob").position, run.position["bob"])
    np.testing.assert_array_equal(run.columns()["pin.fx"], run.joint("pin").force[:, 0])
    # The motor holds bar and bob against gravity alone: it turns them evenly.
    torque = run.driver("motor").torque[:, 2] + run.joint("pin").torque[:, 2]
    weight = 9810 * (1 * 250 + 0.5 * 500) * np.cos(run["swing"])
    np.testing.assert_allclose(torque, weight, rtol=1e-7, atol=1e-3)


def test_units_are_told_of_every_column(solver: DynamicsSolver) -> None:
    run = solver.simulate(0.1, samples=2)
    assert list(run.units) == list(run.columns()) == list(run)
    names = ("time", "bar.vx", "bar.e0", "pin.fx", "pin.mx", "energy.total", "swing", "swing_dot")
    units = ("s", "mm/s", "-", "kg mm/s²", "kg mm²/s²", "kg mm²/s²", "rad", "rad/s")
    assert [run.units[name] for name in names] == [*units]


def test_the_last_state_alone_makes_no_tables(
    solver: DynamicsSolver, monkeypatch: pytest.MonkeyPatch
) -> None:
    rows: list[int] = []

    def counted(bodies: Any, q: Any, *more: Any) -> Any:
        rows.append(len(q))
        return body_tables(bodies, q, *more)

    monkeypatch.setattr("kousoku.runtime.run.EventLog", None)
    monkeypatch.setattr("kousoku.runtime.run.ledger_of", None)
    monkeypatch.setattr(motions, "body_tables", counted)
    monkeypatch.setattr(tables_of_bodies, "body_tables", counted)
    run = solver.simulate(1.0)
    t, q, v = run.state(-1)
    assert (t, q.shape, v.shape, rows) == (1.0, (3 + 7,), (3 + 6,), [1])
    np.testing.assert_array_equal(q[3:6], run.position["bar"][-1])
    np.testing.assert_array_equal(v[6:], run.angular_velocity["bar"][-1])
    with pytest.raises(IndexError, match="arm: no row 1001: there are 1001"):
        run.state(1001)


@pytest.mark.parametrize(
    ("ask", "message"),
    [
        (lambda run: run["bra.x"], "arm: no column 'bra.x': .* did you mean 'bar.x'"),
        (lambda run: run.body("bra"), "arm: no body 'bra': there are bob, bar; did you mean 'bar'"),
        (lambda run: run.node("O3"), "arm: no node 'O3'"),
        (lambda run: run.joint("motor"), "arm: no joint 'motor': there are pin, end"),
        (lambda run: run["pin.fx"], 'arm: no force of joints: generated without "reactions"; load'),
        (lambda run: run.joint("pin").force, 'no force of joints: generated without "reactions"'),
        (lambda run: run.driver("motor").torque, 'no torque of joints: generated without "rea'),
        (lambda run: run["bar.ax"], 'arm: no acceleration of bodies: generated without "accel'),
        (lambda run: run["energy.total"], 'arm: no energ.*: generated without "energies"'),
        (lambda run: run["swing"], 'generated without "coordinates"'),
        (lambda run: run.swing, "Motion has no attribute 'swing'$"),
    ],
)
def test_what_is_not_there_is_refused_in_one_line(bare: Any, ask: Any, message: str) -> None:
    with pytest.raises((KeyError, AttributeError), match=message) as found:
        ask(bare)
    assert "\n" not in str(found.value)


def test_a_linkage_is_asked_by_nodes() -> None:
    run = lever_crank.solve(divisions=4)
    np.testing.assert_array_equal(run["O3.vx"], run.node("O3").velocity[:, 0])
    assert (run.units["O3.vx"], run["time"][0]) == ("cm/s", 0.0)
    with pytest.raises(KeyError, match="lever_crank: no body 'crank'"):
        run.body("crank")
    with pytest.raises(KeyError, match='no angles: generated without "angles"'):
        run.angles["l1"]


def test_a_result_is_shown_in_few_lines(solver: DynamicsSolver) -> None:
    for run in (solver.simulate(0.1), lever_crank.solve()):
        assert len(repr(run).splitlines()) <= 10
        assert len(run._repr_html_()) < 1000
    assert "drivers: motor" in repr(solver.simulate(0.1))


def test_tables_of_pandas_have_columns_and_units(solver: DynamicsSolver, tmp_path: Path) -> None:
    pandas = pytest.importorskip("pandas")
    run = solver.simulate(0.1, samples=3)
    frame = run.to_pandas()
    assert list(frame) == list(run) and frame.attrs["units"]["bar.x"] == "mm"
    pytest.importorskip("pyarrow")
    run.save(tmp_path / "run.parquet")
    np.testing.assert_array_equal(
        pandas.read_parquet(tmp_path / "run.parquet")["bar.x"], run["bar.x"]
    )


def speeds(solver: DynamicsSolver, speed: float) -> Any:
    return solver.simulate(0.5, samples=3, parameters={"speed": speed})


def stops(solver: DynamicsSolver) -> Any:
    return solver.simulate(0.5, most_steps=1)


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda x: pickle.loads(pickle.dumps(x))])
def test_everything_travels(solver: DynamicsSolver, copied: Any) -> None:
    run = solver.begin([0.0, 0.2, 0.4], parameters={"speed": 3})
    run.advance(1, 2)
    found = copied((solver, run, run.motion(), run.motion().ledger))
    other, later, half, ledger = found
    assert ledger == run.motion().ledger and half.ledger.steps == ledger.steps
    whole = run.finish()
    for one in (later.finish(), other.simulate(times=[0, 0.2, 0.4], parameters={"speed": 3})):
        for name, values in whole.columns().items():
            np.testing.assert_array_equal(one[name], values)
    linkage = load_linkage(lever_crank.__path__[0])
    np.testing.assert_array_equal(copied(linkage).solve()["O3.x"], copied(linkage.solve())["O3.x"])


def test_a_pool_of_processes_moves_a_scene(solver: DynamicsSolver) -> None:
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as pool:
        for speed in (1.0, 2.0):
            found = pool.submit(speeds, solver, speed).result()
            np.testing.assert_array_equal(found["bob.y"], speeds(solver, speed)["bob.y"])
        with pytest.raises(MotionError, match="most_steps allows more") as stop:
            pool.submit(stops, solver).result()
        assert isinstance(stop.value.result, motions.Motion)
        assert not stop.value.result.is_complete


def test_a_solver_travels_with_its_sources(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    solver = solver_in(tmp_path)
    data, wanted = pickle.dumps(solver), solver.simulate(0.2, samples=2)["bob.x"]
    shutil.rmtree(tmp_path / "arm")
    monkeypatch.setenv("KOUSOKU_CACHE", str(tmp_path / "cache"))
    for _ in range(2):  # written to the cache, found there
        np.testing.assert_array_equal(pickle.loads(data).simulate(0.2, samples=2)["bob.x"], wanted)
    assert len(list((tmp_path / "cache" / "sources").rglob("solver.c"))) == 1


def test_a_run_starts_over_in_its_memory(solver: DynamicsSolver) -> None:
    times = np.linspace(0.0, 0.5, 4)
    run = solver.begin(times)
    first = run.finish()
    before = first["bob.x"].copy()
    second = run.restart({"speed": 3}).finish()
    third = run.restart({"speed": 2}).finish()
    np.testing.assert_array_equal(first["bob.x"], before)
    np.testing.assert_array_equal(third["bob.x"], before)
    wanted = solver.simulate(times=times, parameters={"speed": 3})
    np.testing.assert_array_equal(second["bob.x"], wanted["bob.x"])
    assert second.ledger.parameters["speed"] == 3 and first.ledger.parameters["speed"] == 2
    assert third.ledger.steps == first.ledger.steps
    with pytest.raises(SolveError, match=r"q0 has the shape \(1,\); wanted"):
        run.restart(q0=[0.0])


def test_a_run_says_how_far_it_is_and_a_result_its_parameters(solver: DynamicsSolver) -> None:
    run = solver.begin([0.0, 0.2, 0.4], parameters={"speed": 3})
    assert repr(run) == "<Run of arm: at 0 s, 0 steps, 0 of 3 rows>"
    assert repr(run.finish() and run).endswith("3 of 3 rows>")
    assert dict(run.motion().parameters) == {"speed": 3.0}
    with pytest.raises(TypeError, match=r"arm: row 1\.5; wanted a whole number"):
        motion: Any = run.motion()
        motion.state(1.5)
