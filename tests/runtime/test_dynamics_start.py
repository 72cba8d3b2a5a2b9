"""Velocities at the start with other parameters: those of the file that has these values."""

from __future__ import annotations

import pickle
import subprocess
import sys
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.codegen.dynamics.explanation.explain import explain
from kousoku.codegen.dynamics.generate import generate_dynamics
from kousoku.model.errors import SceneError, SolveError
from kousoku.model.reading.read import scene_from_toml
from kousoku.runtime.dynamics import load_dynamics
from kousoku.runtime.integrate import assembled_start
from tests.start_with_parameters import folded, missed

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from pathlib import Path

pytestmark = pytest.mark.usefixtures("numpy_solver")

BODY = "inertia = { xx = 0.2, yy = 0.3, zz = 0.25 }\n"
TWO = f"""
name = "two"
unit = "m"
[parameters]
L = 1.0
m = 1.0
[bodies.a]
position = [0, 0, 0]
angular_velocity = [0, 0, 3]
mass = "m"
center = ["0.3*L", 0, 0]
{BODY}
[bodies.b]
position = [1, 0, 0]
velocity = [0, 1, 0]
angular_velocity = [0, 0, -2]
mass = 1
center = ["0.2*L", 0.1, 0]
{BODY}
[joints.k]
type = "spherical"
bodies = ["a", "b"]
points = [["L", 0, 0], [0, 0, 0]]
"""
IN_SPACE = (
    TWO.replace('name = "two"', 'name = "in_space"')
    .replace('["0.3*L", 0, 0]', '["0.3*L", 0.1, -0.2]')
    .replace('["0.2*L", 0.1, 0]', '[0.1, "0.2*L", 0.3]')
    .replace("angular_velocity = [0, 0, 3]", "angular_velocity = [2, -1, 3]")
    .replace("angular_velocity = [0, 0, -2]", "angular_velocity_b = [1, 4, -2]")
)
SLENDER = (
    IN_SPACE.replace('name = "in_space"', 'name = "slender"')
    .replace("xx = 0.2, yy = 0.3, zz = 0.25", "xx = 1e-4, yy = 0.3, zz = 0.3")
    .replace("spherical", "universal")
    .replace("[0, 0, 0]]\n", "[0, 0, 0]]\naxes = [[1, 0, 0], [0, 1, 0]]\n")
)
DRIVEN = """
name = "driven"
unit = "mm"
[parameters]
rate = 2.0
phase = 0.0
L = 1000
[bodies.crank]
position = [0, 0, 0]
mass = 1
center = [300, 100, 0]
inertia = { xx = 2e5, yy = 3e5, zz = 2.5e5 }
[bodies.bob]
position = [1000, 0, 0]
orientation = { axis = [1, 2, 3], angle = 0.5 }
velocity = [0, 300, 200]
angular_velocity_b = [1, 2, 3]
mass = 2
center = [0, 100, "0.2*L"]
inertia = { xx = 2e5, yy = 3e5, zz = 2.5e5 }
[joints.hinge]
type = "revolute"
bodies = ["ground", "crank"]
at = [0, 0, 0]
axis = [0, 0, 1]
[joints.pin]
type = "spherical"
bodies = ["crank", "bob"]
points = [["L", 0, 0], [0, 0, 0]]
[drivers]
motor = { joint = "hinge", value = "phase + rate*t" }
"""
FLAT = (
    TWO.replace('name = "two"', 'name = "flat"')
    .replace('"spherical"', '"revolute"\naxes = [[0, 0, 1], [0, 0, 1]]')
    .replace('["0.2*L", 0.1, 0]', '[0.1, "0.2*L", 0]')
)
SKEW = f"""
name = "skew"
unit = "m"
[parameters]
m = 1.0
[bodies.a]
position = [0.5, 0, 0]
orientation = {{ axis = [1, 2, 3], angle = 0.75 }}
mass = 1
center = [0.2, 0.1, 0]
angular_velocity_b = [1.5, -2, 3]
{BODY}
[bodies.b]
position = [3, 0, 0]
mass = "m"
velocity = [1, 0, 0]
{BODY}
[bodies.c]
position = [4, 0, 0]
mass = 2
{BODY}
[joints.hinge]
type = "cylindrical"
bodies = ["ground", "a"]
at = [0, 0, 0]
axis = [0, 1, 0]
[joints.k]
type = "spherical"
bodies = ["b", "c"]
at = [3, 1, 0]
"""
HELD_PLACE = (
    IN_SPACE.replace('name = "in_space"', 'name = "held_place"')
    .replace('["L", 0, 0]', "[1.0, 0, 0]")
    .replace("[bodies.b]\n", '[bodies.b]\nhold = ["x", "orientation"]\n')
)
WELD = f"""
[bodies.c]
position = [1, 1, 0]
orientation = {{ axis = [1, -2, 1], angle = 0.75 }}
velocity = [1, 0, -1]
angular_velocity = [0, 1, 2]
mass = 2
center = [0.1, 0.2, 0]
{BODY}
[joints.weld]
type = "fixed"
bodies = ["b", "c"]
at = [1, 1, 0]
"""
WELDED = IN_SPACE.replace('name = "in_space"', 'name = "welded"').replace('"0.2*L"', "0.2") + WELD
WELDED_FLAT = FLAT.replace('name = "flat"', 'name = "welded_flat"') + WELD.replace(
    "[1, -2, 1]", "[0, 0, 1]"
).replace("mass = 2", 'mass = "2*m"')
HELD = f"""
name = "held"
unit = "m"
[parameters]
p = 1.5
[bodies.a]
position = [0, 0, 0]
mass = 1
{BODY}
[bodies.b]
position = [1, 0, 0]
velocity = [0, 1, 0]
hold = [KEPT]
mass = MASS
{BODY}
[joints.k]
type = "revolute"
bodies = ["a", "b"]
at = [1, 0, 0]
axis = [0, 0, 1]
[drivers]
motor = {{ joint = "k", value = "LAW" }}
[forces.pull]
type = "force"
body = "a"
force = ["p", 0, 0]
"""
#: A linkage of Bricard, as in `scenes/bricard.toml`: corners of a cube, edges, axes.
CORNERS = ((1.05, 0.02, 0), (1, 1, 0), (1, 1, 1), (0, 1, 1), (0, 0, 1))
EDGES = ((0, 1, 0), (0, 0, 1), (-1, 0, 0), (0, -1, 0), (0, 0, -1))
AXES = ("[0, 0, 1]", "[1, 0, 0]", "[0, 1, 0]")
CUBE = 'name = "cube"\nunit = "m"\n[parameters]\nm = 1.0\n' + "".join(
    f"""
[bodies.rod_{k}]
position = {[*corner]}
cylinders = [{{ mass = {'"m"' if k == 0 else 1}, radius = 0.05, ends = [[0, 0, 0], {[*edge]}] }}]
angular_velocity_b = [1, 2, {k}]
[joints.head_{k}]
type = "revolute"
bodies = ["rod_{k}", "{f"rod_{k + 1}" if k < 4 else "ground"}"]
points = [{[*edge]}, [0, 0, 0]]
axes = [{AXES[(k + 1) % 3]}, {AXES[(k + 1) % 3]}]
"""
    for k, (corner, edge) in enumerate(zip(CORNERS, EDGES, strict=True))
)
CUBE += """
[joints.foot]
type = "revolute"
bodies = ["ground", "rod_0"]
points = [[1, 0, 0], [0, 0, 0]]
axes = [[0, 0, 1], [0, 0, 1]]
"""
SCENES = {
    "in space": (IN_SPACE, {"L": 1.4, "m": 3.0}),
    "flat": (FLAT, {"L": 1.4, "m": 3.0}),
    "slender": (SLENDER, {"L": 1.2}),
    "driven": (DRIVEN, {"L": 1200, "phase": 0.3, "rate": 5.0}),
    "rate": (DRIVEN, {"rate": -3.0}),
    "phase": (DRIVEN.replace('"L", 0', "1000, 0").replace('"0.2*L"', "200"), {"phase": 0.5}),
    "welded": (WELDED, {"L": 1.3, "m": 2.0}),
    "welded, flat": (WELDED_FLAT, {"L": 1.3, "m": 2.0}),
    "masses": (IN_SPACE, {"m": 4.0}),
    "masses, moved": (IN_SPACE.replace("[1, 0, 0]", "[1.5, 0.5, 0]"), {"m": 4.0}),
    "held place": (HELD_PLACE, {"m": 4.0, "L": 1.2}),
    "skew": (SKEW, {"m": 3.0}),
    "over-constrained": (CUBE, {"m": 5.0}),
}
NOW = [0.0]
POINT = '{ body = "bob", point = [0, 0, 300], along = [1, 0, 0] }'


@pytest.mark.parametrize("name", SCENES)
def test_a_run_begins_as_the_file_with_its_parameters(load: Any, name: str) -> None:
    text, given = SCENES[name]
    scene = scene_from_toml(text)
    solver = load(scene)
    elsewhere, faster = missed(scene, given, solver.begin(NOW, parameters=given).finish())
    assert elsewhere < 1e-14
    assert faster < 1e-14
    _, other = missed(scene, given, solver.begin(NOW).finish())
    assert other > 0.01  # with the parameters of the scene it is another start


@pytest.mark.parametrize("name", SCENES)
def test_what_a_run_changes_of_the_start_is_told_as_the_file_tells_it(load: Any, name: str) -> None:
    text, given = SCENES[name]
    scene = scene_from_toml(text)
    solver, file = load(scene), load(folded(scene, given))
    motion = solver.begin(NOW, parameters=given).finish()
    wanted = {body: pytest.approx(one, rel=1e-6, abs=1e-9) for body, one in file.moved.items()}
    assert dict(motion.ledger.moved) == wanted
    assert _changed(motion.notes) == _changed(file.layout.notes)
    for strict in (solver.begin, solver.at(given).begin):
        if file.moved:
            with pytest.raises(SolveError, match=r"assembly changed the start .* strict refuses"):
                strict(NOW, parameters=given, strict=True).finish()
        else:
            strict(NOW, parameters=given, strict=True).finish()
    assert any(one for one in (file.moved, solver.moved))


def test_what_a_run_changes_is_told_where_it_goes_on_and_not_of_a_place_that_is_given(
    load: Any,
) -> None:
    text, given = SCENES["masses, moved"]
    solver = load(scene_from_toml(text))
    run = solver.begin(NOW, parameters=given)
    wanted = solver.begin(NOW, parameters=given).finish()
    assert wanted.ledger.moved
    for again in (pickle.loads(pickle.dumps(run)), solver.resume(run.save())):
        assert again.state.tobytes() == run.state.tobytes()
        assert again.motion().notes == wanted.notes
        assert again.motion().ledger.moved == wanted.ledger.moved
    run.restart(given, q0=wanted.state(0)[1])
    assert not run.motion().ledger.moved


def _changed(notes: Sequence[str]) -> list[str]:
    return [note for note in notes if note.startswith("assembly changed")]


def test_bodies_that_are_fixed_to_each_other_are_one_here(load: Any) -> None:
    a, b, c = load(scene_from_toml(WELDED)).bodies
    assert a.r != b.r == c.r


def test_a_motion_with_parameters_is_that_of_the_file_with_them(load: Any) -> None:
    scene, given = scene_from_toml(TWO), {"L": 1.7}
    solver = load(scene)
    how: dict[str, Any] = {"times": [0.0, 0.1], "tolerance": 1e-11}
    wanted = load(folded(scene, given)).simulate(**how)
    again = solver.begin(how["times"], tolerance=1e-11).restart(given)
    ways = [solver.simulate(parameters=given, **how), solver.at(given).simulate(**how)]
    for motion in (*ways, again.finish(), pickle.loads(pickle.dumps(again)).restart().finish()):
        for table in ("position", "orientation", "velocity", "angular_velocity"):
            for body, values in getattr(wanted, table).items():
                found = getattr(motion, table)[body]
                np.testing.assert_allclose(found, values, rtol=0, atol=1e-13)
    assert np.abs(wanted.angular_velocity["b"][0] - [0, 0, -2]).max() > 0.1
    assert wanted.position["b"][0, 1] < -0.01  # it was turned, too


def test_velocities_that_a_caller_gives_stay(load: Any) -> None:
    solver, given = load(scene_from_toml(TWO)), {"L": 1.7}
    run = solver.begin(NOW).restart(given, v0=np.zeros(12))
    assert not run.finish().angular_velocity["a"].any()
    there = solver.begin(NOW, parameters=given).finish()
    q = there.state(0)[1] + np.tile([1.0, *np.zeros(6)], 2)
    moved = solver.begin(NOW).restart(given, q0=q).finish()
    np.testing.assert_allclose(moved.position["b"], there.position["b"] + [1, 0, 0], atol=1e-14)
    np.testing.assert_allclose(moved.velocity["b"], there.velocity["b"], atol=1e-14)
    rest = np.zeros(12)
    assert not solver.simulate(times=NOW, parameters=given, v0=rest).velocity["b"].any()


def test_a_solver_with_parameters_takes_others(load: Any) -> None:
    scene = scene_from_toml(IN_SPACE)
    solver, given = load(scene), {"L": 1.4, "m": 3.0}
    wanted = solver.begin(NOW, parameters=given).finish()
    there = solver.at({"L": 0.8, "m": 3.0})
    for one in (
        there.begin(NOW, parameters={"L": 1.4}).finish(),
        there.at({"L": 1.4}).begin(NOW).finish(),
        there.begin(NOW).restart({"L": 1.4}).finish(),
    ):
        np.testing.assert_array_equal(one.rows, wanted.rows)
        np.testing.assert_array_equal(one.position["b"], wanted.position["b"])
        assert one.parameters == given
    back = there.begin(NOW, parameters=dict(solver.parameters)).finish()
    np.testing.assert_array_equal(back.rows, solver.begin(NOW).finish().rows)
    found = there.evaluate(parameters={"L": 1.4})
    for region, values in solver.evaluate(parameters=given).items():
        np.testing.assert_array_equal(found[region], values, err_msg=region)


def test_rates_that_a_run_gives_come_after(load: Any) -> None:
    text = f"{DRIVEN}\n[coordinates]\nx = {POINT}\n"
    scene = scene_from_toml(text)
    given, initial = {"rate": -3.0}, {"x_dot": 50.0}
    how: dict[str, Any] = {"times": NOW, "initial": initial}
    found = load(scene, "coordinates").simulate(parameters=given, **how)
    wanted = load(folded(scene, given), "coordinates").simulate(**how)
    np.testing.assert_allclose(found.rows, wanted.rows, rtol=0, atol=1e-12)
    assert found.coordinate_rate["x"][0] == pytest.approx(50)


def test_a_place_that_is_not_found_is_told(load: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    solver, given = load(scene_from_toml(TWO)), {"L": 1.7}
    wanted = solver.begin(NOW, parameters=given).finish()
    assert assembled_start.NOT_NEAREST not in wanted.layout.notes
    monkeypatch.setattr(assembled_start, "MOST_PROJECTION_STEPS", 3)
    run = solver.begin(NOW, parameters=given)
    found = run.finish()
    assert assembled_start.NOT_NEAREST in found.layout.notes
    assert np.abs(found.position["b"] - wanted.position["b"]).max() > 1e-3
    monkeypatch.undo()
    assert assembled_start.NOT_NEAREST not in run.restart(given).finish().layout.notes


@pytest.mark.usefixtures("compiler", "shipped_flags")
@pytest.mark.parametrize("name", ["in space", "welded", "flat"])
def test_c_and_numpy_begin_with_the_same_bits(
    bodies_folder: Callable[..., Path], name: str
) -> None:
    text, given = SCENES[name]
    folder = bodies_folder(scene_from_toml(text))
    a, b = (
        load_dynamics(folder, target=target).begin(NOW, parameters=given)
        for target in ("c", "numpy")
    )
    np.testing.assert_array_equal(a.state, b.state)


def test_a_folder_alone_begins_the_same(bodies_folder: Callable[..., Path]) -> None:
    text, given = SCENES["welded"]
    folder = bodies_folder(scene_from_toml(text))
    run = load_dynamics(folder, target="numpy").begin(NOW, parameters=given)
    script = f"""
import sys
sys.modules["kousoku"] = None
sys.path.insert(0, {str(folder.parent)!r})
from welded import begin
print(begin([0.0], parameters={given!r}).state.tobytes().hex())
"""
    done = subprocess.run(
        [sys.executable, "-c", script], check=True, timeout=120, capture_output=True, text=True
    )
    assert done.stdout.strip() == run.state.tobytes().hex()


@pytest.mark.parametrize(
    "text",
    [
        HELD.replace("KEPT", "").replace("LAW", "t").replace("MASS", "2"),
        DRIVEN[: DRIVEN.index("[bodies.bob]")].replace("L = 1000\n", "")
        + DRIVEN[DRIVEN.index("[joints.hinge]") : DRIVEN.index("[joints.pin]")]
        + DRIVEN[DRIVEN.index("[drivers]") :],
    ],
    ids=["nothing depends", "driven"],
)
def test_scenes_whose_start_depends_on_nothing_else_carry_nothing(text: str) -> None:
    files = generate_dynamics(scene_from_toml(text))
    assert '"given"' not in files["motion.json"]


@pytest.mark.parametrize(
    ("kept", "law", "mass", "says"),
    [
        ("velocity", "p + t", "2", "drivers.motor begins elsewhere"),
        ("velocity", "p*t", "2", "drivers.motor begins at another rate"),
        ("velocity", "t", '"p"', "masses share otherwise"),
        ("orientation", "0.1*p + t", "2", "drivers.motor begins elsewhere"),
        ("orientation", "p*t", '"p"', ""),
        ("velocity", "t + p*t^2", "2", ""),
        ("moved", "t", '"p"', "masses share otherwise what positions"),
    ],
)
def test_what_parameters_change_is_not_held(kept: str, law: str, mass: str, says: str) -> None:
    text = HELD.replace("KEPT", f'"{kept}"').replace("LAW", law).replace("MASS", mass)
    if kept == "moved":
        text = text.replace('"moved"', '"orientation"').replace('t" }', '0.1 + t" }')
    if not says:
        generate_dynamics(scene_from_toml(text))
        return
    for asked in (generate_dynamics, explain):
        with pytest.raises(SceneError, match=rf"bodies\.b\.hold: .* with others {says}"):
            asked(scene_from_toml(text))
