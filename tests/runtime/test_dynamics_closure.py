"""Parameters with which rows that were left out do not follow from the others are refused."""

from __future__ import annotations

import math
import re
import subprocess
import sys
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.model.errors import AssemblyError, MotionError, SceneError, SolveError
from kousoku.model.reading.read import scene_from_toml
from kousoku.runtime.dynamics import load_dynamics
from kousoku.runtime.dynamics_targets import Memory
from kousoku.runtime.integrate.settings import Status

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from pathlib import Path

    from kousoku.model.records.scene import Scene
    from kousoku.runtime.dynamics import DynamicsSolver

pytestmark = pytest.mark.usefixtures("compiler", "numpy_solver")


def cylinder(end: str) -> str:
    return f"cylinders = [{{mass=1, radius=0.05, ends=[[0,0,0],{end}]}}]"


def hinge(name: str, bodies: str, points: str, axes: str = "[[0,0,1],[0,0,1]]") -> str:
    return f'[joints.{name}]\ntype="revolute"\nbodies={bodies}\npoints={points}\naxes={axes}\n'


#: A parallelogram with a third crank: rows of three cranks depend on each other.
CRANKS = f"""
name = "cranks"
unit = "m"
gravity = [0, -9.81, 0]
parameters = {{ h = 0.0, p = 0.5, L = 1.0, ax = 0.0 }}
[bodies]
c1 = {{ position = [0,0,0], angular_velocity = [0,0,1], {cylinder("[0,1,0]")} }}
c2 = {{ position = [1,0,0], {cylinder("[0,1,0]")} }}
cp = {{ position = [0,1,0], {cylinder("[1,0,0]")} }}
c3 = {{ position = [0.5,1,0], {cylinder("[0,-1,0]")} }}
{hinge("a1", '["ground","c1"]', "[[0,0,0],[0,0,0]]", '[["ax",0,1],["ax",0,1]]')}
{hinge("b1", '["c1","cp"]', "[[0,1,0],[0,0,0]]")}
{hinge("a2", '["ground","c2"]', "[[1,0,0],[0,0,0]]")}
{hinge("b2", '["c2","cp"]', '[[0,"L",0],[1,0,0]]')}
{hinge("a3", '["ground","c3"]', '[["p","h",0],[0,"h-1",0]]')}
{hinge("b3", '["c3","cp"]', '[[0,0,0],["p",0,0]]')}
"""
#: With these a file is refused, or stands still.
REFUSED = [{"L": 1.1}, {"L": 1.001}, {"h": 0.3}, {"h": -0.5}, {"ax": 0.1}, {"p": 0.4, "h": -0.5}]
#: With these it opens by less than the closure tolerance, 1e-4 m, and by more than rounding.
WITHIN = [{"L": 1.00002}, {"h": 5e-5}]
#: A door, its upper hinge aside by e: it misses e m per radian.
DOOR = """
name = "door"
unit = "m"
gravity = [0, -9.81, 0]
parameters = { e = 0.0 }
[bodies]
d = { position = [0, 0, 0], boxes = [{ mass = 5, size = [1, 0.1, 2], at = [0.5, 0, 0.5] }] }
[joints]
h = { type = "revolute", bodies = ["ground", "d"], at = [0, 0, 0], axis = [0, 0, 1] }
[joints.g]
type = "revolute"
bodies = ["ground", "d"]
points = [["e", 0, 1], ["e", 0, 1]]
axis = [0, 0, 1]
"""


#: The same door, its upper hinge leaning by e [rad]: it misses that wherever the door is.
LEANING = DOOR.replace(
    'points = [["e", 0, 1], ["e", 0, 1]]\naxis = [0, 0, 1]',
    """points = [[0, 0, 1], [0, 0, 1]]
axes = [["e", 0, 1], [0, 0, 1]]""",
)


def locomotive(turn: float, rise: float = 0.0) -> str:
    """Scene of three cranks on a rod that start turned by so much; the third is e longer.

    Its pin on the rod is higher by a part of that: by all of it, upright cranks fit.
    """
    y, z = -0.5 * math.sin(turn), 0.5 * math.cos(turn)
    cranks = "".join(
        f"[bodies.c{k}]\nposition = [0, {at}, 0]\nangular_velocity = [3, 0, 0]\n"
        f"orientation = {{ axis = [1, 0, 0], angle = {turn} }}\n{cylinder('[0, 0, 0.5]')}\n"
        for k, at in ((1, 0.0), (2, 2.0), (3, 1.0))
    )
    x = "[[1,0,0],[1,0,0]]"
    hinges = "".join(
        hinge(f"a{k}", f'["ground","c{k}"]', f"[[0,{at},0],[0,0,0]]", x)
        + hinge(f"b{k}", f'["c{k}","rod"]', f"[[0,0,{long}],[0,{at},{up}]]", x)
        for k, at, long, up in (
            (1, 0, 0.5, 0),
            (2, 2, 0.5, 0),
            (3, 1, '"0.5 + e"', f'"{rise}*e"'),
        )
    )
    return f"""
name = "locomotive"
unit = "m"
gravity = [0, 0, 9.81]
parameters = {{ e = 0.0 }}
{cranks}
[bodies.rod]
position = [0, {y!r}, {z!r}]
velocity = [0, {-3 * z!r}, {3 * y!r}]
{cylinder("[0, 2, 0]")}
{hinges}
[coordinates]
turn = {{ joint = "a1" }}
"""


#: What turns it to and fro.
MOTOR = '[drivers]\nmotor = { coordinate = "turn", value = "0.3 + 0.8*sin(t)" }\n'


def given(text: str, e: float) -> Any:
    """Scene with another value of its parameter."""
    return scene_from_toml(text.replace("e = 0.0", f"e = {e!r}"))


@pytest.mark.parametrize(
    ("turn", "rise", "target"),
    [(0.0, 1.0, "c"), (0.3, 0.0, "c"), (1.0, 0.0, "c"), (0.3, 0.0, "numpy")],
)
def test_cranks_of_nearly_one_length_move_as_those_of_one(
    bodies_folder: Callable[..., Path], target: Any, turn: float, rise: float
) -> None:
    text, outputs = locomotive(turn, rise), ("positions", "coordinates")
    solver = load_dynamics(bodies_folder(scene_from_toml(text), outputs), target=target)
    exact = solver.simulate(2, samples=201)
    for e in (1e-8, 1e-6, 1e-5):
        other = load_dynamics(bodies_folder(given(text, e), outputs), target=target)
        for run in (
            other.simulate(2, samples=201),
            solver.simulate(2, samples=201, parameters={"e": e}),
        ):
            assert run["turn"] == pytest.approx(exact["turn"], abs=20 * e)
            ledger = run.ledger
            assert ledger.trust.is_trusted, ledger.trust
            assert e / 30 < ledger.trust.missed < 20 * e
            assert "redundant rows miss" in str(ledger.trust) or e < 1e-7
            assert not ledger.released


@pytest.mark.parametrize("target", ["c", "numpy"])
def test_cranks_that_hold_each_other_say_so_though_they_start_with_a_velocity(
    bodies_folder: Callable[..., Path], target: Any
) -> None:
    scene = scene_from_toml(CRANKS.replace("h = 0.0", "h = 0.03"))
    solver = load_dynamics(bodies_folder(scene, ("positions",)), target=target)
    with pytest.raises((SolveError, MotionError), match="nothing can move: joints hold all bodies"):
        solver.simulate(0.1, samples=2)


def moves(solver: Callable[[], DynamicsSolver], **options: Any) -> bool:
    """Whether bodies move; what does not is refused, or told."""
    try:
        run = solver().simulate(0.3, samples=4, **options)
    except (SceneError, AssemblyError, SolveError, MotionError):
        return False
    still = any("nothing can move" in note for note in run.notes)
    assert still == (np.ptp(run["z"]) < 1e-6)
    return not still


@pytest.mark.parametrize(
    ("text", "within", "beyond", "target"),
    [
        (LEANING, [1e-9, 5e-5, 9.9e-5], [1.01e-4, 2e-4, 5e-4, 2e-3], "c"),
        (LEANING, [9.9e-5], [1.01e-4], "numpy"),
        (DOOR, [1e-9, 5e-5, 9e-5], [1.5e-4, 2e-4, 5e-4, 2e-3, 0.1], "c"),
        (locomotive(0.0, 1.0), [1e-7, 1e-5, 3e-5], [3e-4, 2e-3, 0.1], "c"),
        (locomotive(0.3), [1e-7, 1e-5, 5e-5], [3e-4, 2e-3, 0.1], "c"),
        (locomotive(0.3), [5e-5], [3e-4], "numpy"),
        (locomotive(1.0), [1e-7, 1e-5, 5e-5], [3e-4, 2e-3, 0.1], "c"),
    ],
)
def test_file_and_parameters_decide_alike_which_rows_are_redundant(
    bodies_folder: Callable[..., Path],
    target: Any,
    text: str,
    within: list[float],
    beyond: list[float],
) -> None:
    if "[coordinates]" not in text:
        text += '[coordinates]\nturn = { joint = "h" }\n'
    text = text.replace("gravity = [0, -9.81, 0]", "gravity = [1, -9.81, 0]")
    text = text.replace("turn = {", "z = {")
    outputs = ("positions", "coordinates")

    def loaded(scene: Scene) -> DynamicsSolver:
        return load_dynamics(bodies_folder(scene, outputs), target=target)

    scene = scene_from_toml(text)
    for e in (*within, *beyond):
        of_file = moves(partial(loaded, given(text, e)))
        assert of_file == moves(partial(loaded, scene), parameters={"e": e}) == (e in within), e


@pytest.fixture
def folder(bodies_folder: Callable[..., Path]) -> Path:
    return bodies_folder(scene_from_toml(CRANKS), ("positions",))


@pytest.mark.parametrize("target", ["c", "numpy"])
def test_joints_that_come_open_with_parameters_are_refused_at_the_start(
    folder: Path, target: Any
) -> None:
    solver = load_dynamics(folder, target=target)
    for given in REFUSED:
        with pytest.raises(SolveError, match=r"stay open, or come open .*: joints\.\w+ by "):
            solver.simulate(0.1, samples=2, parameters=given)
        values = np.array([*(dict(solver.parameters) | given).values()])
        memory = Memory(np.zeros(solver.target.state_size), np.zeros(solver.target.work_size))
        there = solver.at(given)
        start = solver.target.starter(0.0, there.q, there.v, values, memory)
        assert start() == Status.NOT_CLOSED
    moved = solver.simulate(0.1, samples=2, parameters={"p": 0.7})
    assert moved.ledger.worst("position")[0] < 1e-13
    assert not moved.ledger.missed


@pytest.mark.parametrize("target", ["c", "numpy"])
def test_joints_that_slowly_come_open_are_refused_as_by_the_file(
    bodies_folder: Callable[..., Path], target: Any
) -> None:
    solver = load_dynamics(bodies_folder(scene_from_toml(DOOR), ("positions",)), target=target)
    assert solver.simulate(2, samples=3, parameters={"e": 5e-5}).ledger.trust.is_trusted
    for given in (2e-4, 5e-4):  # the closure tolerance is 1e-4, and 1e-3 is independent
        with pytest.raises(SolveError, match=r"for each length or radian .*: joints\.[gh] by "):
            solver.simulate(2, samples=3, parameters={"e": given})
        with pytest.raises(SceneError, match=r"joints\.g: holds beyond joints\.h no more than"):
            bodies_folder(scene_from_toml(DOOR.replace("e = 0.0", f"e = {given}")), ("positions",))


@pytest.mark.parametrize("target", ["c", "numpy"])
def test_joints_that_open_within_the_closure_tolerance_are_told(folder: Path, target: Any) -> None:
    solver = load_dynamics(folder, target=target)
    for given in WITHIN:
        ledger = solver.simulate(0.1, samples=2, parameters=given).ledger
        metres, _ = ledger.missed["a3"]
        assert 1e-9 < metres < 1e-4
        assert ledger.trust.missed >= metres
        assert "redundant rows miss" in str(ledger.trust)
        assert ledger.trust.is_trusted and not ledger.released


@pytest.mark.parametrize(
    ("text", "end"),
    [(DOOR, 2.5), (locomotive(0.3), 4.0), (locomotive(0.3) + MOTOR, 4.0)],
    ids=["door", "locomotive", "driven locomotive"],
)
def test_what_redundant_rows_miss_at_ends_of_steps_is_told(
    bodies_folder: Callable[..., Path], text: str, end: float
) -> None:
    """However few rows are written, with the same bits in both targets."""
    folder = bodies_folder(given(text, 2e-5), ())
    told = {
        (target, samples): load_dynamics(folder, target=target)
        .simulate(end, samples=samples)
        .ledger.trust.missed
        for target in ("c", "numpy")
        for samples in (2, 301)
    }
    assert 1e-6 < told["c", 301] < 1e-4
    assert told["c", 2] == pytest.approx(told["c", 301], rel=0.1)
    assert all(told["c", samples] == told["numpy", samples] for samples in (2, 301))


def test_the_folder_alone_refuses_them_too(folder: Path) -> None:
    script = f"""
import sys
sys.modules["kousoku"] = None
sys.path.insert(0, {str(folder.parent)!r})
from cranks import simulate
for given in {REFUSED!r}:
    try:
        simulate(0.1, samples=2, parameters=given)
    except ArithmeticError as error:
        assert "come open" in str(error), error
    else:
        raise AssertionError(given)
for given in {[{"p": 0.7}, *WITHIN]!r}:
    simulate(0.1, samples=2, parameters=given)
"""
    subprocess.run([sys.executable, "-c", script], check=True, timeout=120)


@pytest.mark.parametrize("target", ["c", "numpy"])
def test_to_look_beside_the_start_leaves_no_trace(folder: Path, target: Any) -> None:
    solver = load_dynamics(folder, target=target)
    found = [
        solver.simulate(0.3, samples=4, parameters=given) for given in ({}, {"p": 0.5 + 1e-15})
    ]
    # rounding makes some corrections more or less; a look takes more
    for name, apart in (("steps", 0), ("derivatives", 0), ("factorisations", 4)):
        counts = [getattr(one.ledger, name) for one in found]
        assert abs(counts[0] - counts[1]) <= apart


#: A bar on a hinge: its start fits the scene, and with other parameters its place does not.
ARM = """
name = "arm"
unit = "m"
parameters = { L = 1.0 }
[bodies.b]
position = [1, 0, 0]
velocity = [0, 2, 0]
angular_velocity = [0, 0, 2]
mass = 1
inertia = { xx = 0.2, yy = 0.2, zz = 0.25 }
[joints.h]
type = "revolute"
bodies = ["ground", "b"]
points = [[0, 0, 0], ["-L", 0, 0]]
axes = [[0, 0, 1], [0, 0, 1]]
[coordinates]
turn = { joint = "h" }
"""


@pytest.mark.parametrize("target", ["c", "numpy"])
def test_velocities_at_the_start_are_those_of_a_file_with_the_parameters(
    bodies_folder: Callable[..., Path], target: Any
) -> None:
    def rate(text: str, given: Mapping[str, float]) -> float:
        scene = scene_from_toml(text)
        solver = load_dynamics(bodies_folder(scene, ("positions", "coordinates")), target=target)
        return float(solver.simulate(0.1, samples=2, parameters=given)["turn_dot"][0])

    for length in (2.0, 0.0, -3.0, 1.01, 40.0):
        text = ARM.replace("L = 1.0", f"L = {length!r}").replace('"arm"', '"other"')
        wanted = (2.0 * length + 0.25 * 2.0) / (length**2 + 0.25)
        assert rate(ARM, {"L": length}) == pytest.approx(rate(text, {}), rel=1e-14)
        assert rate(text, {}) == pytest.approx(wanted, rel=1e-14)


@pytest.mark.parametrize("target", ["c", "numpy"])
def test_moments_that_no_body_has_are_refused(
    bodies_folder: Callable[..., Path], target: Any
) -> None:
    text = """
name = "tri"
unit = "m"
parameters = { zz = 0.25 }
[bodies.b]
position = [0, 0, 0]
mass = 1
angular_velocity = [1, 0.1, 2]
inertia = { xx = 0.3, yy = 0.2, zz = "zz" }
"""
    solver = load_dynamics(bodies_folder(scene_from_toml(text), ("positions",)), target=target)
    solver.simulate(0.1, samples=2, parameters={"zz": 0.5})  # as of a plate
    for zz, left in ((5.0, "-4.5"), (0.05, "-0.05"), (0.6, "-0.1")):
        with pytest.raises(SolveError, match=rf"bodies\.b\.inertia, the sum .* is {left}; wanted"):
            solver.simulate(0.1, samples=2, parameters={"zz": zz})
        memory = Memory(np.zeros(solver.target.state_size), np.zeros(solver.target.work_size))
        start = solver.target.starter(0.0, solver.q, solver.v, np.array([zz]), memory)
        assert start() == Status.BAD_ARGUMENT


def test_what_assembly_changed_is_in_the_ledger_and_strict_refuses_it(
    bodies_folder: Callable[..., Path],
) -> None:
    text = ARM.replace("position = [1, 0, 0]", "position = [1, 0.001, 0]")
    found = [
        load_dynamics(bodies_folder(scene_from_toml(one), ("positions",))) for one in (ARM, text)
    ]
    assert not found[0].simulate(0.1, samples=2, strict=True).ledger.moved
    ledger = found[1].simulate(0.1, samples=2).ledger
    moved = ledger.moved["b"]
    assert 1e-5 < moved.moved + moved.turned < 3e-3
    assert "assembly changed bodies.b: " in str(ledger)
    assert ledger.as_data()["moved"] == {"b": moved._asdict()}
    with pytest.raises(SolveError, match=r"assembly changed .*: bodies\.b by .*; strict refuses"):
        found[1].simulate(0.1, samples=2, strict=True)


#: A carriage, or a wheel, whose driver jumps where 10 t is π.
JUMP = """
name = "jump"
unit = "m"
[bodies.b]
position = [0, 0, 0]
mass = 1
inertia = { xx = 0.1, yy = 0.1, zz = 0.1 }
[joints.g]
type = "KIND"
bodies = ["ground", "b"]
at = [0, 0, 0]
axis = [0, 0, 1]
[coordinates]
x = { joint = "g" }
[drivers]
d = { coordinate = "x", value = "LAW" }
"""
SAW = "atan2(sin(10*t), cos(10*t))"


@pytest.mark.parametrize("target", ["c", "numpy"])
@pytest.mark.parametrize(
    ("kind", "law"),
    [
        ("prismatic", SAW),
        ("revolute", f"0.1*{SAW}"),
        ("prismatic", f"0.01*{SAW} + 5*t"),
    ],
)
def test_a_driver_that_jumps_stops_the_motion_there(
    bodies_folder: Callable[..., Path], target: Any, kind: str, law: str
) -> None:
    text = JUMP.replace("KIND", kind)
    smooth = scene_from_toml(text.replace("LAW", "sin(10*t) + 0.3*t"))
    scene = scene_from_toml(text.replace("LAW", law))
    assert (
        len(load_dynamics(bodies_folder(smooth, ()), target=target).simulate(1.0, samples=5)) == 5
    )
    solver = load_dynamics(bodies_folder(scene, ()), target=target)
    for samples in (2, 11, 40):
        with pytest.raises(MotionError, match=r"at t = 0\.31415926\d* s: .*drivers\.d"):
            solver.simulate(1.0, samples=samples)


#: Three gears on parallel shafts, each with the others.
GEARS = """
name = "gears"
unit = "m"
parameters = { i = 1.0 }
[bodies]
a = { position = [0, 0, 0], spheres = [{ mass = 1, radius = 0.2 }] }
b = { position = [1, 0, 0], spheres = [{ mass = 1, radius = 0.2 }] }
c = { position = [2, 0, 0], spheres = [{ mass = 1, radius = 0.2 }] }
[joints]
ja = { type = "hinge", bodies = ["ground", "a"], at = [0, 0, 0], axis = [0, 0, 1] }
jb = { type = "hinge", bodies = ["ground", "b"], at = [1, 0, 0], axis = [0, 0, 1] }
jc = { type = "hinge", bodies = ["ground", "c"], at = [2, 0, 0], axis = [0, 0, 1] }
g1 = { type = "gear", joints = ["ja", "jb"], ratio = -1 }
g2 = { type = "gear", joints = ["jb", "jc"], ratio = -1 }
g3 = { type = "gear", joints = ["jc", "ja"], ratio = "i" }
"""


@pytest.mark.parametrize("ratio", [-1.0, 1.001, 1.5])
def test_gears_that_parameters_lock_are_named_with_their_loop(
    bodies_folder: Callable[..., Path], ratio: float
) -> None:
    """A hinge was told to be open, by metres: whichever row was left over of all."""
    solver = load_dynamics(bodies_folder(scene_from_toml(GEARS), ("positions",)))
    with pytest.raises(SolveError) as caught:
        solver.simulate(1.0, samples=2, parameters={"i": ratio})
    told = re.search(r"joints\.(g\d) by (\S+) rad in the loop of (.*); only", str(caught.value))
    assert told is not None, caught.value
    assert sorted(told[3].split(", ")) == ["joints.g1", "joints.g2", "joints.g3"]
    # what is left of g1, or of another gear, while the two others turn all three
    turns = math.sqrt(sum(x * x for x in (1.0, 1.0, ratio)))
    assert 0.3 < float(told[2]) / (abs(ratio - 1.0) / turns) < 1.1
