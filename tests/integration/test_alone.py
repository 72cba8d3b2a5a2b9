"""A generated folder copied out of the project: it runs with NumPy and nothing else."""

from __future__ import annotations

import importlib
import json
import shutil
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import kousoku.generated
from kousoku.codegen.dynamics.generate import generate_dynamics
from kousoku.codegen.generate import generate_kind, write_tree
from kousoku.generated import lever_crank
from kousoku.model.reading.read import read_scene, scene_from_toml
from kousoku.runtime import load
from kousoku.runtime.dynamics import load_dynamics

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.model.records.scene import Scene

ROOT = Path(__file__).parents[2]
GENERATED = Path(kousoku.generated.__path__[0])

REFUSE = """
import json, sys
class Refuse:
    def find_spec(self, name, path=None, target=None):
        lacking = {"kousoku", "sympy", "mpmath", "jinja2", "msgspec", "pandas", "pyarrow"}
        if name.split(".")[0] in lacking:
            raise ModuleNotFoundError(name, name=name)
sys.meta_path.insert(0, Refuse())
sys.path.insert(0, sys.argv[1])
"""


def run(code: str, folder: Path, refuse: str = REFUSE) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", refuse + code, str(folder)],
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.usefixtures("compiler")
@pytest.mark.parametrize("method", ["newton", "paper"])
def test_copied_folder_solves_with_numpy_alone(tmp_path: Path, method: str) -> None:
    shutil.copytree(GENERATED / "lever_crank", tmp_path / "my_crank")
    got = run(
        "import my_crank\n"
        f"motion = my_crank.solve(method={method!r}, divisions=12)\n"
        "print(json.dumps([motion.positions['O3'].tolist(), motion.alpha.tolist(), motion.method,"
        " motion.iterations.tolist(), motion.unit]))",
        tmp_path,
    )
    assert got.returncode == 0, got.stderr
    positions, alpha, name, iterations, unit = json.loads(got.stdout)
    wanted = lever_crank.solve(method=method, divisions=12)
    assert (name, unit) == (method, "cm")
    np.testing.assert_allclose(positions, wanted.positions["O3"], rtol=0, atol=4e-13)
    np.testing.assert_array_equal(alpha, wanted.alpha)
    np.testing.assert_array_equal(iterations, wanted.iterations)


#: Calls that are refused, or that stop.
REFUSED = (
    "solve(method='euler')",
    "solve(divsions=3)",
    "solve(divisions=0)",
    "solve(divisions='many')",
    "solve(limit=-1)",
    "solve(limit=1e-30)",
    "solve(parameters={'l1': 3})",
    "simulate()",
    "simulate(-1)",
    "simulate('2')",
    "simulate(1, times=[0, 1])",
    "simulate(times=[1, 0.5])",
    "simulate(1, samples=0)",
    "simulate(1, initial={'alpha': '30 deg'})",
    "simulate(1)['O9.x']",
    "simulate(1).node('O9')",
    "simulate(1).body('coupler')",
    "simulate(1).save('x.txt')",
)


@pytest.mark.usefixtures("compiler")
def test_copied_folder_of_a_linkage_refuses_with_the_words_of_kousoku(tmp_path: Path) -> None:
    shutil.copytree(GENERATED / "lever_crank", tmp_path / "my_crank")
    code = (
        f"import my_crank\ncalls = ({', '.join(f'lambda: my_crank.{call}' for call in REFUSED)})\n"
        "for call in calls:\n"
        "    try: print('nothing', call())\n"
        "    except Exception as error:\n"
        "        result = getattr(error, 'result', None)\n"
        "        print(error, '' if result is None else len(result))\n"
    )
    alone = run(code, tmp_path)
    beside = run(code, tmp_path, refuse="import sys\nsys.path.insert(0, sys.argv[1])\n")
    assert alone.stdout == beside.stdout, alone.stderr
    lines = alone.stdout.splitlines()
    assert len(lines) == len(REFUSED) and all("lever_crank: " in line for line in lines[:-1])


@pytest.mark.parametrize("name", ["n1", "p2"])
def test_copied_kind_evaluates_with_numpy_alone(tmp_path: Path, name: str) -> None:
    write_tree(tmp_path / "mine", generate_kind(name, GENERATED / "kinds"))
    kernel = {"n1": "constraint", "p2": "constraint_y"}[name]
    wanted = load(GENERATED / "kinds" / name, target="numpy")[kernel]
    points = [
        np.linspace(0.1, 1.7, 5 * q.size).reshape(5, *q.shape) for q in wanted.manifest.inputs
    ]
    got = run(
        "import mine\n"
        f"points = json.loads({json.dumps([x.tolist() for x in points])!r})\n"
        f"print(json.dumps([[x.tolist() for x in mine.{kernel}(*points)],"
        f" [x.tolist() for x in mine.{kernel}(*[x[3] for x in points], outputs=['C'])]]))",
        tmp_path,
    )
    assert got.returncode == 0, got.stderr
    batch, (single,) = json.loads(got.stdout)
    for array, right in zip(batch, wanted(*points), strict=True):
        assert array == right.tolist()
    assert single == batch[0][3]


def test_copied_folder_says_where_it_stops(
    tmp_path: Path, folder_of: Callable[[Scene], Path]
) -> None:
    scene = read_scene(ROOT / "tests" / "scenes" / "second_loop_stops.toml")
    shutil.copytree(folder_of(scene), tmp_path / "stops")
    got = run("import stops\nstops.solve()", tmp_path)
    assert got.returncode == 1
    assert "StoppedError: second_loop_stops: inputs.alpha: a dead centre" in got.stderr
    assert "on the way: D, held by" in got.stderr


@pytest.mark.usefixtures("compiler")
def test_generated_solver_imports_by_its_name() -> None:
    motion = lever_crank.solve()
    assert motion.name == "lever_crank"
    assert motion.positions["O3"].shape == (61, 2)
    with pytest.raises(ValueError, match="read-only"):
        motion.positions["O3"][0, 0] = 1.0


@pytest.mark.usefixtures("compiler")
def test_generated_solver_leaves_sympy_alone() -> None:
    code = "import sys\nfrom kousoku.generated import lever_crank\nlever_crank.solve()\n"
    code += "print(sorted(m for m in ('sympy', 'mpmath', 'jinja2') if m in sys.modules))"
    got = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert got.stdout.strip() == "[]"


def test_generating_a_scene_leaves_sympy_alone() -> None:
    code = (
        "import sys\nfrom kousoku.model.reading.read import read_scene\n"
        "from kousoku.codegen.linkage.generate import generate_linkage\n"
        f"generate_linkage(read_scene({str(ROOT / 'scenes' / 'five_bar.toml')!r}))\n"
        "print('sympy' in sys.modules)"
    )
    got = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert got.stdout.strip() == "False"


@pytest.mark.usefixtures("compiler")
def test_threads_may_be_the_first_to_use_a_solver() -> None:
    code = (
        "import sys, threading\nfrom concurrent.futures import ThreadPoolExecutor\n"
        "from pathlib import Path\nfrom kousoku.runtime.linkage import load_linkage\n"
        "sys.setswitchinterval(1e-6)\nbarrier = threading.Barrier(8)\n"
        "def first_use(k):\n    barrier.wait()\n"
        f"    solver = load_linkage({str(GENERATED / 'lever_crank')!r}, target='numpy')\n"
        "    return solver.solve(divisions=3).positions['O3'].tolist()\n"
        "with ThreadPoolExecutor(8) as pool:\n    got = list(pool.map(first_use, range(8)))\n"
        "print(all(one == got[0] for one in got))"
    )
    got = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert got.stdout.strip() == "True", got.stderr


def test_copied_folder_gives_nothing_that_is_not_wanted(
    tmp_path: Path, folder_of: Callable[[Scene], Path]
) -> None:
    text = (ROOT / "scenes" / "piston_crank.toml").read_text(encoding="utf-8")
    scene = scene_from_toml('outputs = ["angles"]\n' + text)
    shutil.copytree(folder_of(scene), tmp_path / "turning")
    got = run(
        "import turning\nmotion = turning.solve()\n"
        "print(len(motion.positions), motion.velocities, *motion.angles)",
        tmp_path,
    )
    assert got.stdout.split() == ["3", "{}", "l1", "l2"], got.stderr


@pytest.fixture(scope="module")
def top(tmp_path_factory: pytest.TempPathFactory) -> Path:
    scene = read_scene(ROOT / "scenes" / "heavy_top.toml")
    folder = tmp_path_factory.mktemp("alone") / "my_top"
    write_tree(folder, generate_dynamics(scene, ["accelerations", "energies"]))
    return folder


@pytest.mark.usefixtures("numpy_solver")
def test_copied_folder_of_bodies_moves_with_numpy_alone(top: Path) -> None:
    got = run(
        "import my_top\n"
        "motion = my_top.simulate(0.01, samples=3, tolerance=1e-10)\n"
        "print(json.dumps([motion.method, motion.time.tolist(), motion.position['top'].tolist(),"
        " motion.angular_velocity['top'].tolist(), motion.acceleration['top'].tolist(),"
        " motion.orientation['top'].tolist(), motion.energy['kinetic'].tolist()]))",
        top.parent,
    )
    assert got.returncode == 0, got.stderr
    method, time, *tables, energies = json.loads(got.stdout)
    wanted = load_dynamics(top, target="numpy").simulate(0.01, samples=3, tolerance=1e-10)
    assert (method, time) == ("dop853", [0.0, 0.005, 0.01])
    names = ("position", "angular_velocity", "acceleration", "orientation")
    for name, table in zip(names, tables, strict=True):
        np.testing.assert_array_equal(table, getattr(wanted, name)["top"])
    np.testing.assert_array_equal(energies, wanted.energy["kinetic"])


@pytest.mark.usefixtures("numpy_solver")
def test_copied_folder_of_bodies_starts_where_it_is_told_to(tmp_path: Path) -> None:
    scene = read_scene(ROOT / "scenes" / "loop_free.toml")
    write_tree(tmp_path / "my_loop", generate_dynamics(scene, ["coordinates"]))
    got = run(
        "import my_loop, numpy as np\n"
        "initial = {'crank_angle': 0.5, 'crank_angle_dot': 2.0}\n"
        "first = my_loop.simulate(times=[0.0], initial=initial)\n"
        "names = list(first.position)\n"
        "q0 = [x for k in names for x in (*first.position[k][0], *first.orientation[k][0])]\n"
        "v0 = [x for k in names for x in (*first.velocity[k][0], *first.angular_velocity[k][0])]\n"
        "second = my_loop.simulate(times=[0.0], q0=q0, v0=v0)\n"
        "names = ['crank_angle', 'crank_angle_dot', 'rocking', 'rocking_dot']\n"
        "found = [[one[name][0] for name in names] for one in (first, second)]\n"
        "print(json.dumps(found))\n"
        "my_loop.simulate(1.0, initial={'crank': 1.0})",
        tmp_path,
    )
    assert "no coordinate 'crank': there are crank_angle, crank_angle_dot, rocking" in got.stderr
    first, second = json.loads(got.stdout)
    solver = load_dynamics(tmp_path / "my_loop", target="numpy")
    initial = {"crank_angle": 0.5, "crank_angle_dot": 2.0}
    wanted = solver.simulate(times=[0.0], initial=initial)
    assert first == [
        table[name][0]
        for name in ("crank_angle", "rocking")
        for table in (wanted.coordinate, wanted.coordinate_rate)
    ]
    np.testing.assert_allclose(second, first, rtol=1e-12)


def test_copied_folder_of_bodies_says_what_is_not_possible(top: Path) -> None:
    got = run("import my_top\nmy_top.simulate(1.0, most_steps=2)", top.parent)
    assert "StoppedError: heavy_top: most_steps are made, at t = " in got.stderr
    got = run(
        "import my_top\n"
        "try: my_top.simulate(times=[0, 1e-6, 1.0], most_steps=2)\n"
        "except ArithmeticError as error: print(error.result['time'].tolist())",
        top.parent,
    )
    assert json.loads(got.stdout) == [0.0, 1e-6], got.stderr
    got = run("import my_top\nmy_top.simulate(1.0, method='euler')", top.parent)
    assert "ValueError: heavy_top: no method 'euler': there are dopri5, dop853" in got.stderr


@pytest.mark.usefixtures("compiler")
def test_folder_of_bodies_imports_by_its_name(top: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(top.parent)
    motion = importlib.import_module("my_top").simulate(0.01, samples=2)
    assert motion.name == "heavy_top"
    assert motion.ledger.steps > 0


@pytest.mark.usefixtures("numpy_solver")
def test_copied_folder_of_bodies_is_a_package(tmp_path: Path) -> None:
    scene = read_scene(ROOT / "scenes" / "loop_free.toml")
    write_tree(tmp_path / "loop", generate_dynamics(scene, ["reactions", "coordinates"]))
    how: dict[str, Any] = {"parameters": {"mass": 2.0}}
    how["initial"] = {"crank_angle": 0.5, "crank_angle_dot": 0.0}
    got = run(
        f"import loop\nrun = loop.simulate(0.02, samples=3, **{how!r})\n"
        f"begun = loop.begin([0, 0.01, 0.02], **{how!r})\n"
        "begun.advance(1)\nother = begun.finish()\n"
        "run.save(sys.argv[1] + '/run.csv')\nrun.save(sys.argv[1] + '/run.npz')\n"
        "print(json.dumps([run['crank_angle'].tolist(), run.joint('a').force.tolist(),"
        " run.body('coupler').position.tolist(), other['crank_angle'].tolist()]))\n"
        "t, q, v = run.state(0)\nprint(loop.simulate(1e-9, q0=q, v0=v)['crank_angle'][0])\n"
        "for ask in (run.plot, run.animate, lambda: run.save('x.parquet'), lambda: run.ledger):\n"
        "    try: ask()\n"
        "    except (ModuleNotFoundError, KeyError) as error: print(error)\n",
        tmp_path,
    )
    assert got.returncode == 0, got.stderr
    numbers, start, *lines = got.stdout.splitlines()
    wanted = load_dynamics(tmp_path / "loop", target="numpy").simulate(0.02, samples=3, **how)
    angle, force, place, other = map(np.array, json.loads(numbers))
    assert angle[0] == pytest.approx(0.5, abs=1e-12) and float(start) == pytest.approx(0.5)
    np.testing.assert_array_equal(angle, wanted["crank_angle"])
    np.testing.assert_array_equal(other, angle)
    np.testing.assert_array_equal(force, wanted.joint("a").force)
    np.testing.assert_array_equal(place, wanted.body("coupler").position)
    with np.load(tmp_path / "run.npz") as data:
        np.testing.assert_array_equal(data["crank_angle"], angle)
    assert (tmp_path / "run.csv").read_text().startswith("time,crank.x,")
    install = "pip install 'kousoku["
    assert [install in line for line in lines] == [True, False, True, False]
    assert lines[0] == "loop_free: needs kousoku: pip install 'kousoku[plot]'"
    assert lines[1].startswith("loop_free: only runs of what kousoku.load gave have solids")
    assert "install kousoku" in lines[-1]


@pytest.fixture(scope="module")
def free_loop(tmp_path_factory: pytest.TempPathFactory) -> Path:
    scene = read_scene(ROOT / "scenes" / "loop_free.toml")
    folder = tmp_path_factory.mktemp("alone") / "my_loop"
    write_tree(folder, generate_dynamics(scene, ["coordinates"]))
    return folder


@pytest.mark.usefixtures("numpy_solver")
def test_copied_folder_takes_degrees_and_gives_the_verdict(free_loop: Path) -> None:
    got = run(
        "before = set(globals())\nfrom my_loop import *\n"
        "print(sorted(set(globals()) - before - {'before'}))\n"
        "run = simulate(0.05, samples=6, initial={'crank_angle': '30 deg'})\n"
        "print(repr(run).splitlines()[0])\nprint(run['crank_angle'][0])\n"
        "import pickle\nprint(pickle.loads(pickle.dumps(run)).verdict)\n"
        "print(simulate(times=[0], parameters={'mass': '2'}).parameters['mass'])\n"
        "wrong = simulate(2, samples=3, step=0.5)\nprint(repr(wrong).splitlines()[0])",
        free_loop.parent,
    )
    assert got.returncode == 0, got.stderr
    names, verdict, angle, again, mass, wrong = got.stdout.splitlines()
    assert names == "['begin', 'simulate']" and mass == "2.0"
    assert float(angle) == pytest.approx(np.pi / 6, abs=1e-12)
    solver = load_dynamics(free_loop, target="numpy")
    wanted = solver.simulate(0.05, samples=6, initial={"crank_angle": "30 deg"})
    assert verdict == again == wanted.verdict
    assert wrong == solver.simulate(2, samples=3, step=0.5).verdict
    assert wrong.startswith("not trusted: ")


@pytest.mark.usefixtures("numpy_solver")
def test_a_run_of_a_copied_folder_shows_itself_as_one_of_kousoku(free_loop: Path) -> None:
    got = run(
        "import my_loop\nrun = my_loop.begin([0, 0.01])\nprint(run)\nrun.finish()\nprint(run)",
        free_loop.parent,
    )
    assert got.returncode == 0, got.stderr
    going = load_dynamics(free_loop, target="numpy").begin([0, 0.01])
    shown = [repr(going), going.finish() and repr(going)]
    assert got.stdout.splitlines() == shown
    assert shown[0] == "<Run of loop_free: at 0 s, 0 steps, 0 of 2 rows>"


def test_copied_folder_refuses_with_the_words_of_kousoku(free_loop: Path) -> None:
    calls = {
        "simulate(-1)": "ValueError: my_loop: end -1; wanted one above 0, in seconds",
        "simulate(1, samples=1)": "ValueError: my_loop: samples 1; wanted 2 to",
        "simulate(times=[1, 0.5])": "ValueError: my_loop: times must ascend from 0 or later",
        "simulate(1, tolerence=1)": "TypeError: my_loop: no option 'tolerence': there are end,"
        " times, samples, tolerance, method",
        "begin([0], checked=1)": "TypeError: my_loop: no option 'checked': there are times, tol",
        "simulate(1, tolerance=0)": "ValueError: my_loop: tolerance 0; wanted one from 1e-15, bel",
        "simulate(1, parameters={'mass': 'a'})": "ValueError: my_loop: parameter mass is 'a',",
        "simulate(1, initial={'crank_angle': float('nan')})": "ValueError: my_loop: initial"
        " crank_angle is nan; wanted a finite number, or an angle such as '30 deg'",
        "simulate(1e-9, samples=2)['crank']": "MissingError: my_loop: no column 'crank': those of",
        "simulate(1e-9, samples=2).save('no/x.csv')": "ValueError: no/x.csv: there is no folder no",
    }
    got = run(
        "import my_loop\n"
        f"for call in {[*calls]!r}:\n"
        "    try: eval('my_loop.' + call)\n"
        "    except Exception as error: print(f'{type(error).__name__}: {error}')\n",
        free_loop.parent,
    )
    assert got.returncode == 0, got.stderr
    for line, wanted in zip(got.stdout.splitlines(), calls.values(), strict=True):
        assert line.startswith(wanted.replace("my_loop", "loop_free"))


LANDS = """
name = "lands"
unit = "m"
gravity = [0, 0, -10]
outputs = []
parameters = { ground_at = 0.0 }
[bodies]
ball = { point = true, position = [0, 0, 1], velocity = [0, 0, 3], mass = 1 }
[coordinates]
z = { body = "ball", along = [0, 0, 1] }
[events]
top = { when = "z_dot" }
half = { when = "z - 1.2", action = "count" }
ground = { when = "z - ground_at", direction = "falling", action = "stop" }
"""


@pytest.mark.usefixtures("numpy_solver")
def test_events_of_a_copied_folder_are_those_of_kousoku(tmp_path: Path) -> None:
    scene = scene_from_toml(LANDS)
    write_tree(tmp_path / "lands", generate_dynamics(scene, ()))
    code = """
import lands
going = lands.begin([0.1 * k for k in range(20)], parameters={"ground_at": -1.0})
while going.advance(2) == 2:
    pass
motion, whole = going.motion(), lands.simulate(5.0, samples=51, parameters={"ground_at": -1.0})
print(json.dumps([motion.told.rows.tolist(), motion.rows.tolist(), motion.stopped_by,
    motion.events["half"].count, motion.notes, whole.told.rows.tolist()]))
"""
    got = run(code, tmp_path)
    assert got.returncode == 0, got.stderr
    events, rows, stopped_by, count, notes, whole = json.loads(got.stdout)
    solver = load_dynamics(tmp_path / "lands", target="numpy")
    wanted = solver.begin([0.1 * k for k in range(20)], parameters={"ground_at": -1.0}).finish()
    np.testing.assert_array_equal(events, wanted.told.rows)
    np.testing.assert_array_equal(rows, wanted.rows)
    assert (stopped_by, count, tuple(notes)) == ("ground", 2, wanted.notes)
    assert [row[0] for row in whole] == [0.0, 2.0]
    assert wanted.events["ground"].time == pytest.approx([1.0], abs=1e-14)
    assert wanted.events["top"].time == pytest.approx([0.3], abs=1e-14)


@pytest.mark.usefixtures("numpy_solver")
def test_copied_folder_of_bodies_says_where_an_event_has_no_value(tmp_path: Path) -> None:
    text = (ROOT / "scenes" / "bouncing_ball.toml").read_text(encoding="utf-8")
    for name, when in (("starts", "log(z - 50)"), ("stops", "sqrt(z)")):
        scene = scene_from_toml(f'{text}[events.lost]\nwhen = "{when}"\n')
        write_tree(tmp_path / name, generate_dynamics(scene))
        got = run(f"import {name}\n{name}.simulate(2.0, samples=2)", tmp_path)
        assert f"events.lost: {when} has no finite value " in got.stderr
        assert ("StoppedError" in got.stderr) == (name == "stops")


@pytest.mark.usefixtures("numpy_solver")
def test_copied_folder_of_bodies_says_which_driver_bends(tmp_path: Path) -> None:
    scene = scene_from_toml(
        'name = "bent"\nunit = "m"\n[bodies]\nshaft = { position = [0, 0, 0] }\n[joints]\n'
        'axle = { type = "revolute", bodies = ["ground", "shaft"], at = [0, 0, 0], axis = [0, 0, 1]'
        ' }\n[coordinates]\nturn = { joint = "axle" }\n[drivers]\nmotor = { coordinate = "turn",'
        ' value = "sqrt((t - 0.5)^2 + 1e-30)" }\n'
    )
    write_tree(tmp_path / "bent", generate_dynamics(scene))
    got = run("import bent\nbent.simulate(2.0, samples=2)", tmp_path)
    assert "StoppedError: bent: no step can be taken: the law of drivers.motor bends" in got.stderr
    assert "at t = 0.5 s" in got.stderr


@pytest.mark.usefixtures("numpy_solver")
def test_copied_folder_of_bodies_says_which_driver_brings_points_together(tmp_path: Path) -> None:
    scene = scene_from_toml(
        'name = "drawn"\nunit = "m"\n[bodies.slider]\nposition = [1, 0, 0]\npoint = true\n'
        "mass = 1\n"
        '[joints.rail]\ntype = "inline"\nbodies = ["ground", "slider"]\nat = [0, 0, 0]\n'
        "axis = [1, 0, 0]\n[coordinates]\n"
        'far = { bodies = ["ground", "slider"], points = [[0, 0, 0], [0, 0, 0]] }\n'
        '[drivers]\nwinch = { coordinate = "far", value = "(1 - t)^2" }\n'
    )
    write_tree(tmp_path / "drawn", generate_dynamics(scene))
    got = run("import drawn\ndrawn.simulate(2.0, samples=2)", tmp_path)
    assert "StoppedError: drawn: no step can be taken: drivers.winch prescribes" in got.stderr
