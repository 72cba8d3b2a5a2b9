"""Runs refine accelerations where the pivots tell that many digits were lost, and there alone."""

from __future__ import annotations

import math
import random
import re
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np
import pytest

from kousoku.codegen.dynamics.assembly.assemble import assemble
from kousoku.codegen.dynamics.choose import cheaper
from kousoku.codegen.dynamics.composition.compose import compose
from kousoku.codegen.dynamics.generate import LEDGER_OUTPUTS
from kousoku.codegen.dynamics.recording.inline import inline
from kousoku.codegen.dynamics.recording.interpreter import ProgramInterpreter
from kousoku.model.errors import MotionError
from kousoku.model.lowering.system import system_of
from kousoku.model.numbers.digits import HIGH
from kousoku.model.reading.families import chain, n_four_bar
from kousoku.model.reading.read import scene_from_dict, scene_from_toml
from kousoku.model.reading.write import to_toml
from kousoku.runtime.dynamics import load_dynamics
from kousoku.runtime.integrate.body_tables import written_state
from kousoku.runtime.integrate.motion import Motion
from kousoku.state_matrices import evaluate
from tests.analysed import independent
from tests.stress import extremes

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.model.records.scene import Scene
    from kousoku.runtime.dynamics import DynamicsSolver
    from kousoku.runtime.run import Run

SCENES = Path(__file__).parents[2] / "scenes"
OUTPUTS = ("accelerations", "reactions")
TARGETS: tuple[Any, Any] = ("c", "numpy")
#: Its cranks come to the line of the ground points, where the rank drops, within half a second.
SCENE = n_four_bar(2, rate=-7.0)
END = 0.5
#: The angular acceleration of the cranks is −PULL cos θ [rad/s²].
PULL = 9.81 * 3.5 / 3
#: A driver brings cranks from half a radian to nearly that line.
AT_START = (math.cos(0.5), math.sin(0.5))
DRIVER = '[drivers]\nmotor = { joint = "ground_0", value = "-0.497*t" }\n'
#: How far above the line the ends of the cranks are looked at [m].
HEIGHTS = np.array([1.5e-4, 1.4e-4, 1.3e-4, 1.2e-4, 1.1e-4])
#: So near that rounding of positions changes accelerations by more than a hundredth; also below it.
NEARER = np.array([2e-5, 1e-5, 5e-6, -3e-6, -1e-5])


@pytest.fixture
def solver(backend: str, bodies_folder: Callable[..., Path]) -> DynamicsSolver:
    target: Any = backend
    return load_dynamics(bodies_folder(SCENE, OUTPUTS), target=target)


def passed(solver: DynamicsSolver, heights: Any = HEIGHTS, tolerance: float = 1e-10) -> Run:
    """Run that has rows shortly before the line, and goes on behind it."""
    motion = solver.simulate(END, samples=1001, tolerance=tolerance)
    y, rate = motion.position["coupler_0"][:, 1], motion.velocity["coupler_0"][:, 1]
    at = int(np.argmax(y < heights[0]))
    times = motion.time[at] + (heights - y[at]) / rate[at]
    run = solver.begin([0.0, *times, END], tolerance=tolerance)
    run.finish()
    return run


def rate_at(height: Any) -> Any:
    """Angular velocity of the cranks, which starts at a height of 1 m."""
    return -np.sqrt(49 + 2 * PULL * (1 - height))


def time_of_the_line() -> float:
    """Time at which the cranks come to the line: ∫ dθ / |ω| over a quarter of a turn."""
    x, weights = np.polynomial.legendre.leggauss(40)
    return float(-math.pi / 4 * np.sum(weights / rate_at(np.cos(math.pi / 4 * (x + 1)))))


def in_fifty_digits(q: Any, v: Any, scene: Scene = SCENE) -> dict[str, Any]:
    system, wanted = assemble(system_of(scene, OUTPUTS)), (*LEDGER_OUTPUTS, *OUTPUTS)
    found = independent(system)
    program = cheaper(found, wanted, compose(found, wanted))
    work = ProgramInterpreter(program, HIGH)
    for name, values in (("q", q), ("v", v)):
        work[name] = [HIGH.number(Fraction(x)) for x in values.tolist()]
    work.run("geometry", "acceleration", "reaction")
    return {name: np.array([float(x) for x in work[name]]) for name in ("v_dot", "reactions")}


def uneven_chain(heavy: float, light: float) -> str:
    """Chain of three boxes, of which the second is light."""
    bodies = "".join(
        f"b{k} = {{ position = [{k}, 0, 0], mass = {m}, center = [0.5, 0.05, 0.02],"
        f" inertia = {{ xx = {0.01 * m}, yy = {0.09 * m}, zz = {0.095 * m} }},"
        f" angular_velocity = [0.3, {0.5 - 0.4 * k}, -0.2] }}\n"
        for k, m in enumerate((heavy, light, heavy))
    )
    return f"""
        name = "uneven"
        unit = "m"
        gravity = [0.5, -0.3, -9.81]
        [bodies]
        {bodies}
        [joints]
        j0 = {{ type = "revolute", bodies = ["ground", "b0"], at = [0, 0, 0], axis = [0, 1, 0.2] }}
        j1 = {{ type = "revolute", bodies = ["b0", "b1"], at = [1, 0, 0], axis = [0.1, 0.3, 1] }}
        j2 = {{ type = "spherical", bodies = ["b1", "b2"], at = [2, 0, 0] }}
    """


def worst(found: Any, wanted: Any) -> float:
    """Largest error, relative to the largest number."""
    return float(np.abs(found - wanted).max() / np.abs(wanted).max())


def test_rows_near_a_position_of_lower_rank_have_the_accelerations_of_fifty_digits(
    solver: DynamicsSolver,
) -> None:
    run = passed(solver)
    nq, nv = len(solver.q), len(solver.v)
    lost = {"v_dot": 0.0, "reactions": 0.0}
    left = dict(lost)
    for row in run.save().rows[1:-1]:
        _, q, v, v_dot, reactions = np.split(row, np.cumsum([1, nq, nv, nv]))
        exact, once = in_fifty_digits(q, v), solver.evaluate(0.0, q, v)
        for name, found in (("v_dot", v_dot), ("reactions", reactions)):
            lost[name] = max(lost[name], worst(once[name], exact[name]))
            left[name] = max(left[name], worst(found, exact[name]))
    for name, limit in (("v_dot", 5e-12), ("reactions", 3e-10)):
        assert left[name] < limit
        assert lost[name] > 5 * left[name]
    ledger = run.motion().ledger
    assert len(HEIGHTS) <= ledger.refinements < ledger.derivatives / 20
    assert f"{ledger.refinements} accelerations refined" in str(ledger)
    assert max(ledger.worst("acceleration")) < 1e-12


def test_rows_that_small_errors_of_positions_decide_about_are_told_by_the_polynomial(
    solver: DynamicsSolver,
) -> None:
    """All cranks move like one pendulum; no factors tell it so near to the line.

    With this tolerance no stage lands beside the line, which would lose digits of the polynomial.
    """
    run = passed(solver, NEARER, tolerance=4e-11)
    motion = run.motion()
    rows = slice(1, 1 + len(NEARER))
    x, y = motion.position["coupler_0"][rows, :2].T
    assert np.all(np.abs(y) < 3e-5) and y[0] > 0.0 > y[-1]
    for crank in ("crank_0", "crank_1", "crank_2"):
        rate = motion.angular_velocity[crank][rows, 2]
        np.testing.assert_allclose(rate, rate_at(y), rtol=0, atol=1e-9)
        found = motion.angular_acceleration[crank][rows, 2]
        np.testing.assert_allclose(found, -PULL * x, rtol=0, atol=1e-7)
    ledger = motion.ledger
    assert (ledger.passed, ledger.passed_time) == (len(NEARER), motion.time[len(NEARER)])
    assert max(ledger.worst("position")) < 1e-10
    assert max(ledger.worst("velocity")) < 1e-10
    for force in motion.force.values():
        assert np.isnan(force[rows, :2]).all()
        assert np.isfinite(force[[0, -1]]).all()


@pytest.mark.parametrize("method", ["dopri5", "dop853"])
def test_a_run_may_end_where_the_rank_drops(solver: DynamicsSolver, method: str) -> None:
    end = time_of_the_line()
    motion = solver.simulate(times=[0.0, end], tolerance=1e-9, method=method)
    np.testing.assert_allclose(motion.position["coupler_0"][-1, :2], [1, 0], rtol=0, atol=1e-9)
    alpha = motion.angular_acceleration["crank_0"][-1, 2]
    assert alpha == pytest.approx(-PULL, abs=1e-3)
    assert (motion.ledger.passed, motion.ledger.passed_time) == (1, end)


@pytest.mark.parametrize("late", [-1e-7, -1e-10, 1e-15, 1e-12, 1e-8, 1e-7])
@pytest.mark.parametrize("method", ["dopri5", "dop853"])
def test_no_stage_of_a_step_need_lie_where_the_rank_drops(
    solver: DynamicsSolver, method: str, late: float
) -> None:
    """Steps of a tenth of the way have one there: the end, or one that the polynomial wants."""
    end = time_of_the_line() * (1 + late)
    for parts in (3, 7, 10, 20):
        motion = solver.simulate(
            times=[0.0, end], tolerance=1.35e-6, method=method, largest_step=end / parts
        )
        rate = motion.angular_velocity["crank_0"][-1, 2]
        assert rate == pytest.approx(rate_at(0.0), abs=1e-4)
        assert (motion.ledger.passed, motion.ledger.passed_time) == (1, end)


@pytest.mark.parametrize(("method", "place"), [("dopri5", 0.3), ("dopri5", 1.0), ("dop853", 0.1)])
def test_steps_of_a_fixed_length_pass_where_a_stage_lies_at_the_line(
    solver: DynamicsSolver, method: str, place: float
) -> None:
    """The last of them is 0.1 of a step behind its begin, where the polynomial wants it."""
    line = time_of_the_line()
    step = line / (19 + place)
    for times in ([0.0, line], [0.0, 2 * line], np.linspace(0.0, 2 * line, 301)):
        motion = solver.simulate(times=times, method=method, step=step)
        height = motion.position["coupler_0"][-1, 1]
        for crank in ("crank_0", "crank_1", "crank_2"):
            rate = motion.angular_velocity[crank][-1, 2]
            assert rate == pytest.approx(rate_at(height), abs=1e-6)
        assert motion.ledger.avoided < 5
        assert motion.ledger.steps <= math.ceil(times[-1] / step) + 2
    assert motion.ledger.avoided > 0


@pytest.mark.usefixtures("compiler", "numpy_solver", "shipped_flags")
@pytest.mark.parametrize(("method", "place"), [("dopri5", 1.0), ("dop853", 0.1)])
def test_both_targets_pass_the_line_with_the_same_steps_of_a_fixed_length(
    bodies_folder: Callable[..., Path], method: str, place: float
) -> None:
    line = time_of_the_line()
    step = line / (3 + place)
    one, other = (
        load_dynamics(bodies_folder(SCENE, OUTPUTS), target=target).begin(
            [0.0, line], method=method, step=step
        )
        for target in TARGETS
    )
    assert one.finish().ledger.avoided > 0
    other.finish()
    np.testing.assert_array_equal(one.state, other.state)


@pytest.mark.usefixtures("compiler", "numpy_solver", "shipped_flags")
def test_both_targets_try_shorter_steps_where_no_stage_has_the_usual_pivots(
    bodies_folder: Callable[..., Path],
) -> None:
    """A stage that cannot be made says nothing of the pivots that are usual from here on."""
    scene = scene_from_toml((SCENES / "piston_crank_bodies.toml").read_text(encoding="utf-8"))
    found = []
    for target in TARGETS:
        solver = load_dynamics(bodies_folder(scene, OUTPUTS), target=target)
        run = solver.begin([0.0, 40.0], method="dop853", step=3.0)
        solver.state["largest_pivot_ratio"].view(run.state)[...] = 1e9
        run.advance(1)
        assert solver.state["avoided"].view(run.state) > 0
        found.append(run.state)
    np.testing.assert_array_equal(found[0], found[1])


@pytest.mark.parametrize("times", [[0.0, 3.0], [0.0, 4.0], [0.0, 1.0, 3.0]])
def test_steps_of_a_fixed_length_that_are_too_long_stop_where_no_rows_are_dependent(
    backend: str, bodies_folder: Callable[..., Path], times: list[float]
) -> None:
    """Of a tenth less they would end on the constraints, and far from the motion."""
    text = (SCENES / "piston_crank_bodies.toml").read_text(encoding="utf-8")
    target: Any = backend
    solver = load_dynamics(bodies_folder(scene_from_toml(text), OUTPUTS), target=target)
    with pytest.raises(MotionError, match=r"at t = 0 s: the constraints cannot be met") as stop:
        solver.simulate(times=times, method="dop853", step=3.0)
    assert isinstance(stop.value.result, Motion)
    assert stop.value.result.ledger.avoided == 0


@pytest.mark.parametrize("tolerance", [1e-8, 1e-9])
def test_steps_do_not_creep_where_the_rank_drops_for_long(
    backend: str, bodies_folder: Callable[..., Path], tolerance: float
) -> None:
    """Cranks swing up from below and come over the line with 1e-3 rad/s alone."""
    scene = n_four_bar(2, turned=(0.0, -1.0), rate=math.sqrt(2 * PULL + 1e-6))
    target: Any = backend
    motion = load_dynamics(bodies_folder(scene, OUTPUTS), target=target).simulate(
        times=[0.0, 1.0], tolerance=tolerance, method="dopri5", most_steps=120
    )
    assert motion.ledger.growth < 2e-8
    fallen = -motion.position["coupler_0"][-1, 1]
    assert fallen > 0.8
    for crank in ("crank_0", "crank_1", "crank_2"):
        rate = motion.angular_velocity[crank][-1, 2]
        assert abs(rate) == pytest.approx(math.sqrt(1e-6 + 2 * PULL * fallen), abs=20 * tolerance)


def test_a_last_step_that_fails_elsewhere_is_a_rejected_one(
    backend: str, bodies_folder: Callable[..., Path]
) -> None:
    """A driver that starts suddenly leads too far for the step that would reach the end."""
    driver = DRIVER.replace("-0.497*t", "0.3*t^20")
    scene = scene_from_toml(f"{to_toml(n_four_bar(1, rate=0.0))}\n{driver}")
    target: Any = backend
    ledger = (
        load_dynamics(bodies_folder(scene, OUTPUTS), target=target)
        .simulate(times=[0.0, 1.0], tolerance=1e-3, method="dopri5")
        .ledger
    )
    assert ledger.growth > 0.2
    assert ledger.rejected > 0
    assert ledger.avoided == 0


def test_power_of_a_driver_is_refined_with_the_accelerations(
    backend: str, bodies_folder: Callable[..., Path]
) -> None:
    scene = scene_from_toml(f"{to_toml(n_four_bar(1, turned=AT_START))}\n{DRIVER}")
    target: Any = backend
    run = load_dynamics(bodies_folder(scene, OUTPUTS), target=target).begin([0.0, 1.0])
    assert run.finish().ledger.refinements > 0
    system, wanted = assemble(system_of(scene, OUTPUTS)), (*LEDGER_OUTPUTS, *OUTPUTS)
    found = independent(system)
    program = cheaper(found, wanted, compose(found, wanted))
    work = ProgramInterpreter(inline(program))
    y, f = (run.solver.state[name].view(run.state) for name in ("y", "f"))
    count = len(work["q"])
    rates = f[:count]
    work["t"], work["q"], work["v"] = [1.0], y[:count].tolist(), y[count:].tolist()
    work.run("geometry", "acceleration", "refinement")
    *others, power = work["q_dot"]
    assert work["more_power"][0] != 0.0
    assert rates.tolist() == [*others, power + work["more_power"][0]]


@pytest.mark.usefixtures("numpy_solver", "shipped_flags")
def test_both_targets_refine_the_same_accelerations_to_the_same_bits(
    compiler: object, bodies_folder: Callable[..., Path]
) -> None:
    one, other = (
        passed(load_dynamics(bodies_folder(SCENE, OUTPUTS), target=target)) for target in TARGETS
    )
    assert one.motion().ledger.refinements > 0
    np.testing.assert_array_equal(one.state, other.state)
    np.testing.assert_array_equal(one.save().rows, other.save().rows)


@pytest.mark.parametrize("masses", [(1.0, 1e-12), (1e5, 1e-5)])
def test_a_light_body_between_heavy_ones_costs_no_digits(
    backend: str, bodies_folder: Callable[..., Path], masses: tuple[float, float]
) -> None:
    scene, target = scene_from_toml(uneven_chain(*masses)), cast("Any", backend)
    solver = load_dynamics(bodies_folder(scene, OUTPUTS), target=target)
    run = solver.begin(np.linspace(0.0, 0.2, 3))
    ledger = run.finish().ledger
    assert ledger.steps < 20
    assert ledger.trust.is_trusted
    assert max(ledger.worst("velocity")) < 1e-12
    assert max(ledger.worst("acceleration")) < 1e-12
    nq, nv = len(solver.q), len(solver.v)
    for row in run.save().rows:
        _, q, v, v_dot, reactions = np.split(row, np.cumsum([1, nq, nv, nv]))
        exact = in_fifty_digits(q, v, scene)
        assert worst(v_dot, exact["v_dot"]) < 1e-13
        assert worst(reactions, exact["reactions"]) < 1e-12


@pytest.mark.parametrize(("light", "lost"), [(1.0, False), (1e-12, True)])
def test_digits_that_accelerations_of_a_state_lose_are_told(
    bodies_folder: Callable[..., Path], light: float, lost: bool
) -> None:
    scene = scene_from_toml(uneven_chain(1.0, light))
    solver = load_dynamics(bodies_folder(scene, OUTPUTS), target="numpy")
    q, v = written_state(solver.bodies, solver.q, solver.v, solver.unit)
    found = evaluate(scene, solver, 0.0, q, v)
    told = "uneven: at this state digits of accelerations are lost: constraints ask for others"
    assert [note.startswith(told) for note in found.notes] == [True] * lost


def test_a_chain_that_rests_before_a_force_begins_is_refined_too(
    backend: str, bodies_folder: Callable[..., Path]
) -> None:
    text = re.sub(r"angular_velocity = \[.*?\]", "velocity = [0, 0, 0]", uneven_chain(1.0, 1e-12))
    text = text.replace("gravity = [0.5, -0.3, -9.81]", "gravity = [0, 0, 0]")
    late = '[forces]\nlate = { type = "force", body = "b2", force = ["9*t", "-7*t", "8*t"] }\n'
    solver = load_dynamics(
        bodies_folder(scene_from_toml(text + late), OUTPUTS), target=cast("Any", backend)
    )
    ledger = solver.begin([0.0, 0.1, 0.2]).finish().ledger
    assert ledger.refinements > 50
    assert max(ledger.worst("acceleration")) < 1e-14


@pytest.mark.usefixtures("compiler", "numpy_solver", "shipped_flags")
def test_both_targets_refine_between_uneven_masses_to_the_same_bits(
    bodies_folder: Callable[..., Path],
) -> None:
    folder = bodies_folder(scene_from_toml(uneven_chain(1.0, 1e-12)), OUTPUTS)
    one, other = (load_dynamics(folder, target=target).begin([0.0, 0.1]) for target in TARGETS)
    assert one.finish().ledger.refinements == other.finish().ledger.refinements > 50
    np.testing.assert_array_equal(one.state, other.state)


def test_chains_have_no_refinement(bodies_folder: Callable[..., Path]) -> None:
    folder = bodies_folder(chain(3), OUTPUTS)
    for name in ("solver.c", "solver.py"):
        assert "refinement" not in (folder / name).read_text(encoding="utf-8").lower()


def chain_of(case: str) -> Scene:
    """Three bars that hang on each other, as the stress suite asks of them."""
    draw = random.Random(f"mass ratios to 1e12 in a chain, {case}")
    return scene_from_dict(extremes.chain(draw).tree)


@pytest.mark.parametrize("case", ["1 35 1", "1 51 1"])
def test_digits_that_a_chain_loses_on_its_way_are_found(
    backend: str, bodies_folder: Callable[..., Path], case: str
) -> None:
    """It starts with few of them lost: of masses 1e-6, 1 and 1e6 kg, and 1, 1e6 and 1e6 kg."""
    scene = chain_of(case)
    solver = load_dynamics(bodies_folder(scene, OUTPUTS), target=cast("Any", backend))
    run = solver.begin(np.linspace(0.0, 1.0, 5))
    ledger = run.finish().ledger
    assert 0.9 * ledger.derivatives < ledger.refinements
    nq, nv = len(solver.q), len(solver.v)
    for row in run.save().rows[1:]:
        _, q, v, v_dot, reactions = np.split(row, np.cumsum([1, nq, nv, nv]))
        exact = in_fifty_digits(q, v, scene)
        assert worst(v_dot, exact["v_dot"]) < 1e-14
        assert worst(reactions, exact["reactions"]) < 1e-14


@pytest.mark.usefixtures("compiler", "numpy_solver", "shipped_flags")
def test_both_targets_find_them_with_the_same_bits(bodies_folder: Callable[..., Path]) -> None:
    folder = bodies_folder(chain_of("1 51 1"), ())
    one, other = (load_dynamics(folder, target=target).begin([0.0, 1.0]) for target in TARGETS)
    assert one.finish().ledger.refinements == other.finish().ledger.refinements > 700
    np.testing.assert_array_equal(one.state, other.state)
