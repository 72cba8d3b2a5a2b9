"""The verdict on a run in C is that of Python, for runs that are right, and wrong in every way."""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING, Any, cast, get_type_hints

import numpy as np
import pytest
from msgspec.structs import replace

import kousoku
from kousoku.codegen.dynamics.assembly.assemble import assemble
from kousoku.codegen.dynamics.composition.compose import compose
from kousoku.codegen.dynamics.emission.emit import emit_dynamics
from kousoku.codegen.dynamics.generate import LEDGER_OUTPUTS
from kousoku.codegen.generate import write_tree
from kousoku.model.errors import MotionError
from kousoku.model.lowering.system import system_of
from kousoku.model.reading.families import n_four_bar
from kousoku.model.reading.read import read_scene, scene_from_toml
from kousoku.model.reading.write import to_toml
from kousoku.runtime.dynamics import load_dynamics
from kousoku.runtime.integrate.settings import Doubt, Settings, Status
from kousoku.runtime.integrate.trust import CheckedRows, RunVerdict, judge
from tests.analysed import all_rows, without
from tests.runtime.test_dynamics_branches import turned_by_a_torque
from tests.runtime.test_dynamics_closure import CRANKS
from tests.runtime.test_dynamics_driven import four_bar
from tests.runtime.test_dynamics_works import pulsing
from tests.runtime.test_trust import CART, SCENES, cart

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

    from kousoku.runtime.dynamics import DynamicsSolver
    from kousoku.runtime.run import Run

pytestmark = pytest.mark.usefixtures("compiler")

BODIES = sorted(
    path.stem for path in SCENES.glob("*.toml") if "[bodies" in path.read_text(encoding="utf-8")
)
TYPES: dict[type, Any] = {float: ctypes.c_double, int: ctypes.c_int}
#: Numbers of a state that the verdict looks at.
SEEN = (
    *("energy_error", "energy_moved", "work_error", "energy", "potential", "steps", "drift"),
    *("row_drift", "not_finite", "branch_points", "fallbacks", "unresolved", "impulse", "fastest"),
)


def record(of: Any) -> Any:
    """Record of Python as ``solver.h`` declares it."""
    declared = [(name, TYPES[kind]) for name, kind in get_type_hints(of).items()]
    return type(of.__name__, (ctypes.Structure,), {"_fields_": declared})


def in_c(solver: DynamicsSolver, settings: Settings, state: Any) -> tuple[int, RunVerdict]:
    """Code that C returns, and its verdict."""
    target: Any = solver.target
    verdict = record(RunVerdict)()
    given = ctypes.byref(record(Settings)(*settings)), state.ctypes, ctypes.byref(verdict)
    code = target._function("trust")(given[0], given[1].data_as(ctypes.c_void_p), given[2])
    return code, RunVerdict(*(getattr(verdict, name) for name in RunVerdict._fields))


def in_python(solver: DynamicsSolver, settings: Settings, state: Any) -> RunVerdict:
    return judge(
        {name: field.view(state) for name, field in solver.state.items()},
        CheckedRows(solver.rows, solver.left_out, solver.satisfied),
        solver.layout,
        settings,
        has_masses=solver.has_masses,
        is_driven=solver.is_driven,
    )


def same(solver: DynamicsSolver, settings: Settings, state: Any) -> Doubt:
    """Doubts that C and Python have of a state, with the same bits."""
    code, found = in_c(solver, settings, state)
    wanted = in_python(solver, settings, state)
    assert code == found.doubts == wanted.doubts
    np.testing.assert_array_equal(np.array(found), np.array(wanted))
    return Doubt(code)


def doubts_of(run: Run) -> Doubt:
    """Doubts that both have of a run when it is done, which are those of its ledger."""
    try:
        trust = run.finish().ledger.trust
    except MotionError as error:
        trust = error.result.ledger.trust
    doubts = same(run.solver, run.options.settings(), run.state)
    assert trust.is_trusted == (not doubts)
    advice = [one for one in trust.problems if one.startswith("try ")]
    assert len(trust.problems) - len(advice) == int(doubts).bit_count()
    return doubts


@pytest.mark.parametrize("name", BODIES)
def test_committed_scenes_are_trusted(name: str) -> None:
    solver = cast("DynamicsSolver", kousoku.load(SCENES / f"{name}.toml", target="c").solver)
    methods: list[Any] = ["dopri5", *["kinematics"] * solver.is_driven]
    for method in methods:
        run = solver.begin(np.linspace(0.0, 0.5, 6), method=method, tolerance=1e-8)
        assert doubts_of(run) == Doubt(0)


def sinc() -> Run:
    return cart("sin(t - 0.5)/(t - 0.5)", target="c").begin(np.linspace(0.0, 1.0, 101))


def root() -> Run:
    return cart("((t + 1)^0.3 - 1.53^0.3)/(t - 0.53)", target="c").begin([0.0, 1.0])


def place() -> Run:
    return cart("abs(t - 0.53)^(-0.6)", target="c").begin([0.0, 1.0], method="dopri5")


def coarse() -> Run:
    return cart("-3*x", target="c").begin(np.linspace(0.0, 20.0, 21), step=1.0)


def rotor() -> Run:
    body = {**CART["bodies"]["cart"], "velocity": [0, 0, 0], "angular_velocity": [0, 0, 314]}
    hinge = {**CART["joints"]["rail"], "type": "revolute", "axis": [0, 0, 1]}
    changes = {"bodies": {"cart": body}, "joints": {"rail": hinge}, "outputs": ["coordinates"]}
    return kousoku.load({**CART, **changes}, target="c").begin([0.0, 0.5, 1.0], step=0.02)


def rod() -> Run:
    mechanism = kousoku.load(SCENES / "pendulum_on_a_rod.toml", target="c")
    return mechanism.begin(np.linspace(0.0, 2.0, 101), step=0.5)


@pytest.mark.parametrize(
    ("make", "doubt"),
    [
        (sinc, Doubt.NOT_FINITE),
        (root, Doubt.NARROW),
        (place, Doubt.IMPULSE),
        (coarse, Doubt.ENERGY),
        (rotor, Doubt.DRIFT),
        (rod, Doubt.ROW_DRIFT),
    ],
)
def test_runs_that_are_wrong_are_not_trusted(make: Callable[[], Run], doubt: Doubt) -> None:
    assert doubt in doubts_of(make())


@pytest.mark.parametrize("way", [{"tolerance": 1e-3}, {"step": 0.02}])
def test_leap_near_another_branch_is_doubted(bodies_folder: Any, way: dict[str, float]) -> None:
    gap = 1e-11 if "tolerance" in way else 1e-6
    solver = load_dynamics(bodies_folder(turned_by_a_torque(gap), ()), target="c")
    run = solver.begin(np.linspace(0.0, 1.0, 11), method="dopri5", **way)
    assert Doubt.BRANCH_POINTS in doubts_of(run)


@pytest.mark.usefixtures("numpy_solver")
def test_works_that_steps_did_not_see_are_doubted(monkeypatch: pytest.MonkeyPatch) -> None:
    mechanism = pulsing(monkeypatch)  # bounds of formulas, which would tell, are off in NumPy
    run = mechanism.begin(np.linspace(0.0, 8.0, 81))
    solver: Any = mechanism.solver
    solver.state["steps"].view(run.state)[...] = 1.0  # its first steps are not tried
    run.finish()
    compiled = load_dynamics(solver.target.sources.place(), target="c")
    assert same(compiled, run.options.settings(), run.state) == Doubt.WORKS


@pytest.mark.usefixtures("numpy_solver", "shipped_flags")
def test_a_row_without_a_value_hides_nothing_of_the_others(bodies_folder: Any) -> None:
    """Both targets keep the largest residuals; C forgot those before a NaN of accelerations."""
    load = 'type = "torque", body = "crank", torque = [0, 0, "sin(t - 0.5)/(t - 0.5)"]'
    free = to_toml(replace(four_bar(), drivers={}, parameters={}, gravity=(0, -9.81, 0)))
    scene = scene_from_toml(f"{free}\n[forces]\nm = {{ {load} }}\n")
    folder, found = bodies_folder(scene, ("accelerations",)), []
    for target in ("c", "numpy"):
        solver = load_dynamics(folder, target=cast("Any", target))
        run = solver.begin(np.linspace(0.0, 1.0, 11))
        assert "first at t = 0.5 s" in run.finish().ledger.trust.why
        found.append(solver.state["violations"].view(run.state).copy())
    assert np.isfinite(found[0]).all()
    np.testing.assert_array_equal(found[0], found[1])


def loosened(folder: Path) -> DynamicsSolver:
    """Pendulum whose hinge does not hold its point along x."""
    system = assemble(system_of(read_scene(SCENES / "pendulum.toml")))
    whole = all_rows(system)
    kinds = [one.kind for one in system.constraints]
    rows = [x for x in whole.outline.rows if (kinds[x.instance], x.row) == ("point", 0)]
    write_tree(folder, emit_dynamics(compose(without(whole, rows), LEDGER_OUTPUTS), system))
    return load_dynamics(folder, target="c")


def test_joint_that_comes_open_where_a_row_was_left_out_is_doubted(tmp_path: Path) -> None:
    solver = loosened(tmp_path / "pendulum")
    assert Doubt.OPEN in doubts_of(solver.begin(np.linspace(0.0, 0.5, 6)))
    assert Doubt.OPEN not in doubts_of(solver.begin(np.linspace(0.0, 0.5, 6), checks=False))


def states(run: Run, count: int) -> Iterator[Any]:
    """States of a run in which what the verdict looks at is anything, NaN among it."""
    rng, fields = np.random.default_rng(13), run.solver.state
    for _ in range(count):
        state = run.state.copy()
        for name in SEEN:
            if rng.random() < 0.4:
                fields[name].view(state)[...] = some(rng)
        worst = fields["violations"].view(state)
        worst[0, :] = [some(rng) if rng.random() < 0.3 else x for x in worst[0]]
        yield state


def some(rng: np.random.Generator) -> float:
    """Number of any size, or one that is none."""
    special = (0.0, np.nan, np.inf, 1.0)
    return float(rng.choice(special)) if rng.random() < 0.1 else 10.0 ** rng.uniform(-24, 6)


def solvers(bodies_folder: Callable[..., Path], folder: Path) -> dict[str, DynamicsSolver]:
    """Scenes that differ in what the verdict depends on.

    Rows that are solved for, that are left out, and that coordinates fulfil; drivers that move
    masses, and that move what has none; joints that leave nothing free.
    """
    weightless = kousoku.load(
        {
            "name": "wiper",
            "unit": "m",
            "bodies": {"arm": {"position": [0, 0, 0]}},
            "joints": {
                "pivot": {
                    "type": "revolute",
                    "bodies": ["ground", "arm"],
                    "at": [0, 0, 0],
                    "axis": [0, 0, 1],
                }
            },
            "drivers": {"motor": {"joint": "pivot", "value": "0.3*sin(2*t)"}},
            "outputs": [],
        },
        target="c",
    )
    scenes = {
        "cart": read_scene(SCENES / "pendulum.toml"),
        "free": read_scene(SCENES / "free_body.toml"),
        "loops": n_four_bar(2),
        "redundant": scene_from_toml(CRANKS),
        "driven": four_bar(),
        "rod": read_scene(SCENES / "pendulum_on_a_rod.toml"),
    }
    found = {
        name: load_dynamics(bodies_folder(scene, ()), target="c") for name, scene in scenes.items()
    }
    without = cast("DynamicsSolver", weightless.solver)
    return found | {"loose": loosened(folder), "weightless": without}


def test_any_state_is_judged_with_the_same_bits(
    bodies_folder: Callable[..., Path], tmp_path: Path
) -> None:
    found = solvers(bodies_folder, tmp_path / "pendulum")
    assert any(one.left_out for one in found.values())
    assert any(one.satisfied for one in found.values())
    assert {(one.is_driven, one.has_masses) for one in found.values()} == {
        (False, True),
        (True, True),
        (True, False),
    }
    every = Doubt(0)
    for solver in found.values():
        for method in ("dop853", *["kinematics"] * solver.is_driven):
            ways: list[Any] = [{"tolerance": 1e-6}, {"tolerance": 1e-12}, {"checks": False}]
            if method == "dop853":
                ways.append({"tolerance": 1e-6, "step": 0.01})
            for options in ways:
                run = solver.begin([0.0, 0.05], method=cast("Any", method), **options)
                run.advance()
                settings = run.options.settings()
                for state in states(run, 200):
                    every |= same(solver, settings, state)
    assert every == ~Doubt(0)


def test_no_verdict_is_given_of_a_state_of_another_solver_or_method() -> None:
    run = cart("-3*x", target="c").begin([0.0, 1.0])
    run.finish()
    settings = run.options.settings()
    assert in_c(run.solver, settings, run.state)[0] == Status.GOOD
    for other in ({"method": 0}, {"tolerance": -1.0}, {"fixed_step": np.nan}):
        assert in_c(run.solver, settings._replace(**other), run.state)[0] == Status.BAD_ARGUMENT
    nothing = np.zeros_like(run.state)
    assert in_c(run.solver, settings, nothing)[0] == Status.WRONG_STATE
