"""The evaluator shares nothing with kousoku, and knows what closed forms say."""

from __future__ import annotations

import ast
import math
import random
import tomllib
from pathlib import Path
from typing import TYPE_CHECKING, Any

import mpmath
import numpy as np
import pytest

import kousoku as ks
from tests.random_scenes import random_scene
from tests.stress.comparing import Comparison, nodes
from tests.stress.extremes import four_bar, stiff
from tests.stress.independent.evaluator import Evaluator
from tests.stress.independent.formulas import Reader
from tests.stress.independent.numbers import Jet, atan2
from tests.stress.planar import State, solution
from tests.stress.scenes import quick_to_compile

if TYPE_CHECKING:
    from kousoku.runtime.toolchain import Toolchain
    from tests.stress.planar import Scene

    Tree = dict[str, Any]

#: What they look at is no part of kousoku.
pytestmark = pytest.mark.release

FOLDER = Path(__file__).parent / "independent"
SCENES = Path(__file__).parents[2] / "scenes"
#: Every third scene: ``make stress`` compares random ones.
COMMITTED = [
    path for folder in (SCENES, SCENES / "adams") for path in sorted(folder.glob("*.toml"))
][::3]
STILL = [0.0] * 3


def body(**more: Any) -> Tree:
    return {"position": [0, 0, 0], "mass": 2.0, "inertia": {"xx": 1, "yy": 2, "zz": 3}, **more}


def scene(joints: Tree, /, **more: Any) -> Tree:
    return {"name": "one", "unit": "m", "bodies": {"b": body()}, "joints": joints, **more}


def at(r: list[float], p: list[float], v: list[float], omega: list[float]) -> tuple[Any, ...]:
    return (r, p, v, omega)


def test_it_imports_nothing_of_kousoku() -> None:
    for path in FOLDER.glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            for name in names:
                root = name.split(".")[0]
                assert root != "kousoku"
                assert root != "tests" or name.startswith("tests.stress.independent"), name


def test_a_free_body_turns_by_the_equations_of_euler() -> None:
    found = Evaluator(scene({})).evaluate(0, {"b": at(STILL, [1, 0, 0, 0], STILL, [1, 2, 3])})
    wanted = [(2 - 3) * 2 * 3 / 1, (3 - 1) * 3 * 1 / 2, (1 - 2) * 1 * 2 / 3]
    assert found.solution.v_dot == pytest.approx([0, 0, 0, *wanted], rel=1e-14)
    assert found.kinetic == pytest.approx((1 + 2 * 4 + 3 * 9) / 2)


@pytest.mark.parametrize("real", [float, mpmath.mpf])
def test_a_pendulum_falls_as_its_formula_says(real: Any) -> None:
    """φ̈ = −m g l sin φ / I about the pin, and the pin carries what the path of the centre asks."""
    joints = {
        "pin": {"type": "hinge", "bodies": ["ground", "b"], "at": [0, 0, 0], "axis": [0, 1, 0]}
    }
    tree = scene(joints, gravity=[0, 0, -9.81])
    tree["bodies"]["b"]["center"] = [0, 0, -0.5]
    angle, rate = 0.7, 1.3
    p = [math.cos(angle / 2), 0, math.sin(angle / 2), 0]
    with mpmath.workdps(30):
        evaluator = Evaluator(tree, real=real)
        found = evaluator.evaluate(0, evaluator.state_of([*STILL, *p], [*STILL, 0, rate, 0]))
        turn = 2 * mpmath.asin(real(p[2]) / mpmath.sqrt(real(p[0]) ** 2 + real(p[2]) ** 2))
        moment = mpmath.mpf(2) + 2 * mpmath.mpf("0.25")
        wanted = -2 * real(9.81) * 0.5 * mpmath.sin(turn) / moment
        assert abs(found.solution.v_dot[4] - wanted) < (1e-14 if real is float else 1e-28)
    assert float(found.potential) == pytest.approx(-9.81 * math.cos(angle))


@pytest.mark.parametrize(
    "one",
    [four_bar((1.0, 3.0, 2.0, 3.0), 1.0, 0.5), stiff(random.Random(2))],
    ids=["loop", "stiff"],
)
def test_equations_of_the_plane_say_the_same_in_60_digits(one: Scene) -> None:
    states = {
        name: State(bar.at, bar.angle, (0.25, -0.5), bar.omega) for name, bar in one.bars.items()
    }
    wanted = solution(one, states)
    with mpmath.workdps(60):
        poses = {}
        for name, state in states.items():
            half, spin = mpmath.mpf(state.angle) / 2, mpmath.mpf(state.omega)
            p = [mpmath.cos(half), 0, 0, mpmath.sin(half)]
            poses[name] = ([*state.r, 0], p, [*state.v, 0], [0, 0, spin])
        found = Evaluator(one.tree, real=mpmath.mpf).evaluate(0, poses)
        got = {}
        for name, own in found.columns.items():
            x, y, *_, got[f"{name}.alpha"] = found.solution.v_dot[own]
            got |= {f"{name}.ax": x, f"{name}.ay": y}
        for name, hinge in one.hinges.items():
            own = found.columns[hinge.j]
            got[f"{name}.fx"], got[f"{name}.fy"], *_ = found.pushes(name)[0][own]
        off = {name: abs(mpmath.mpf(x) - got[name]) for name, x in wanted.numbers().items()}
        size = max(abs(x) for x in got.values())
    assert off.keys() == got.keys()
    assert max(off.values()) < 1e-40 * size


def test_a_nut_on_a_thread_falls_with_the_inertia_of_its_turn() -> None:
    joint = {
        "type": "screw",
        "bodies": ["ground", "b"],
        "at": [0, 0, 0],
        "axis": [0, 0, 1],
        "pitch": 2,
    }
    found = Evaluator(scene({"thread": joint}, gravity=[0, 0, -9.81])).evaluate(
        0, {"b": at(STILL, [1, 0, 0, 0], STILL, STILL)}
    )
    lead = 2 / (2 * math.pi)
    fall = -9.81 * 2 / (2 + 3 / lead**2)
    assert found.solution.v_dot[[2, 5]] == pytest.approx([fall, fall / lead], rel=1e-13)
    pushes, left_open = found.pushes("thread")
    assert not np.abs(left_open).max(initial=0.0) > 1e-12
    assert pushes[2] == pytest.approx(2 * (fall + 9.81), rel=1e-13)


def test_a_door_on_two_hinges_carries_its_weight_as_nobody_knows() -> None:
    hinge = {"type": "revolute", "bodies": ["ground", "b"], "axis": [0, 0, 1]}
    joints = {"low": {**hinge, "at": [0, 0, 0]}, "high": {**hinge, "at": [0, 0, 1]}}
    found = Evaluator(scene(joints, gravity=[1, 0, -9.81])).evaluate(
        0, {"b": at(STILL, [1, 0, 0, 0], STILL, STILL)}
    )
    assert found.solution.v_dot == pytest.approx([0] * 6, abs=1e-14)
    assert found.solution.free.shape == (10, 5)
    both = sum(found.pushes(name)[0] for name in joints)
    assert both[:3] == pytest.approx([-2, 0, 2 * 9.81], rel=1e-12)


@pytest.mark.parametrize(
    ("text", "value"),
    [("-2^2", -4), ("2^-1", 0.5), ("30 deg", math.pi / 6), ("min(3, 1, 2)*x", 4), ("-(3 - x)", 1)],
)
def test_formulas_mean_what_the_grammar_says(text: str, value: float) -> None:
    assert Reader().number(text, {"x": 4.0}) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize("text", ["__import__('os')", "x.real", "(lambda: 1)()", "x[0]", "'a'*3"])
def test_a_formula_runs_no_code(text: str) -> None:
    with pytest.raises(ValueError, match="no part of a formula"):
        Reader().number(text, {"x": 4.0})


def test_derivatives_are_those_of_differences() -> None:
    def f(x: Any) -> Any:
        return atan2(x * x - 1, 2 / x) ** 3

    x, h = 1.2, 1e-4
    found = f(Jet(x, np.array([1.0]), np.array([0.0])))
    assert found.first[0] == pytest.approx((f(x + h) - f(x - h)) / (2 * h), rel=1e-6)
    assert 2 * found.second[0] == pytest.approx((f(x + h) - 2 * f(x) + f(x - h)) / h**2, rel=1e-4)


@pytest.mark.parametrize("path", COMMITTED, ids=lambda path: path.stem)
def test_committed_scenes_agree_with_it(path: Path, compiler: Toolchain) -> None:
    tree = tomllib.loads(path.read_text(encoding="utf-8"))
    if "bodies" not in tree:
        return
    mechanism = ks.load(path, target="c")
    run: Any = mechanism.simulate(0.5, samples=21, tolerance=1e-10)
    tree.setdefault("outputs", ["accelerations"])
    measured = [*Comparison(tree, mechanism).rows(run)]
    assert measured
    assert not [one for one in measured if not one[1] <= one[2]]


def test_works_of_a_root_of_rounding_are_rounding() -> None:
    """The angle that a force is the root of stays zero, and each evaluation rounds it anew."""
    tree = random_scene(random.Random("1 16 0"))
    with quick_to_compile():
        mechanism = ks.load(tree, target="c")
        run: Any = mechanism.simulate(times=nodes(0.25), tolerance=1e-9)
        measured = [*Comparison(tree, mechanism).works(run)]
    assert measured
    assert not [one for one in measured if not one[1] <= one[2]]


def test_forces_of_a_root_of_rounding_are_rounding() -> None:
    """The angle is zero at the start, and the body that is pushed is nearly at rest."""
    tree = random_scene(random.Random("1 79 2"))
    with quick_to_compile():
        mechanism = ks.load(tree, target="c")
        run: Any = mechanism.simulate(0.01, samples=2, tolerance=1e-9)
        measured = [*Comparison(tree, mechanism).rows(run)]
    assert measured
    assert not [one for one in measured if not one[1] <= one[2]]


def test_what_is_too_ill_conditioned_to_compare_is_counted() -> None:
    """Of a chain of 1e-12 kg and 1 kg that is led: what leads it has a work."""
    box = "boxes = [{ mass = %s, size = [1, 0.1, 0.1] }]"
    text = f"""
name = "uneven_chain"
unit = "m"
gravity = [0, -9.81, 0]
outputs = ["accelerations"]
[bodies]
upper = {{ position = [0.5, 0, 0], {box % "1e-12"} }}
lower = {{ position = [1.5, 0, 0], {box % "UNEVEN"} }}
[joints]
top = {{ type = "revolute", bodies = ["ground", "upper"], at = [0, 0, 0], axis = [0, 0, 1] }}
middle = {{ type = "revolute", bodies = ["upper", "lower"], at = [1, 0, 0], axis = [0, 0, 1] }}
[coordinates]
turn = {{ joint = "top" }}
[drivers]
motor = {{ coordinate = "turn", value = "t" }}
"""
    counts = []
    for mass in ("1e-12", "1"):
        tree = tomllib.loads(text.replace("UNEVEN", mass))
        with quick_to_compile():
            mechanism = ks.load(tree, target="c")
            run: Any = mechanism.simulate(times=nodes(0.01))
        comparison = Comparison(tree, mechanism)
        measured = {name for name, *_ in [*comparison.rows(run), *comparison.works(run)]}
        has = {"accelerations (relative)", "works (relative)"} & measured
        counts.append((dict(comparison.counts), len(has)))
    unclear = {
        "accelerations too ill conditioned to compare": 2,
        "motions whose works are too ill conditioned to compare": 1,
    }
    assert counts == [({"accelerations compared": 2}, 2), (unclear, 0)]
