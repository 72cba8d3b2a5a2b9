"""Motions that drivers determine: position by position, on one branch, with the reactions."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np
import pytest
from msgspec.structs import replace

import kousoku
from kousoku.model.errors import MotionError, SolveError
from kousoku.model.reading.families import n_four_bar
from kousoku.model.reading.read import scene_from_toml
from kousoku.model.reading.write import to_toml
from kousoku.runtime.dynamics import load_dynamics
from kousoku.runtime.integrate.motion import Motion
from kousoku.runtime.integrate.settings import Status
from kousoku.runtime.messages import shortly

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.model.numbers.real import Array
    from kousoku.model.records.scene import Scene
    from kousoku.runtime.dynamics import DynamicsSolver

    Load = Callable[..., DynamicsSolver]

SCENES = Path(__file__).parents[2] / "scenes"
OUTPUTS = ("accelerations", "reactions", "energies")
CRANK, COUPLER, ROCKER, GROUND = 1.0, 3.0, 2.5, 3.0
RATE = 6.0


def pin(crank: Array, rocker: float) -> Array:
    """Point where coupler and rocker meet, above the line from the crank's pin to the ground's."""
    start = CRANK * np.stack([np.cos(crank), np.sin(crank)], axis=-1)
    way = np.array([GROUND, 0.0]) - start
    length = np.hypot(way[..., 0], way[..., 1])
    along = (COUPLER**2 - rocker**2 + length**2) / (2 * length)
    across = np.sqrt(COUPLER**2 - along**2)
    normal = np.stack([-way[..., 1], way[..., 0]], axis=-1)
    end: Array = start + (along / length)[..., None] * way + (across / length)[..., None] * normal
    return end


def four_bar(rocker: float = ROCKER, joint: str = "a", law: str = "rate*t") -> Scene:
    """Four-bar whose crank begins at one radian; the angle of its joint is zero there."""
    start = np.array([math.cos(1.0), math.sin(1.0)])
    meet = pin(np.array(1.0), rocker)
    turns = [math.atan2(*(meet - end)[::-1]) for end in (start, np.array([GROUND, 0.0]))]
    bodies = ""
    for name, at, angle, length in (
        ("crank", (0.0, 0.0), 1.0, CRANK),
        ("coupler", start, turns[0], COUPLER),
        ("rocker", (GROUND, 0.0), turns[1], rocker),
    ):
        box = f"{{ mass = {length}, size = [{length}, 0.1, 0.1], at = [{length / 2}, 0, 0] }}"
        bodies += f"[bodies.{name}]\nposition = [{float(at[0])!r}, {float(at[1])!r}, 0]\n"
        bodies += f"orientation = {{ axis = [0, 0, 1], angle = {angle!r} }}\nboxes = [{box}]\n"
    joints = ""
    for name, pair, points in (
        ("a", '"ground", "crank"', "[0, 0, 0], [0, 0, 0]"),
        ("b", '"crank", "coupler"', f"[{CRANK}, 0, 0], [0, 0, 0]"),
        ("c", '"coupler", "rocker"', f"[{COUPLER}, 0, 0], [{rocker}, 0, 0]"),
        ("d", '"ground", "rocker"', f"[{GROUND}, 0, 0], [0, 0, 0]"),
    ):
        joints += f'{name} = {{ type = "revolute", bodies = [{pair}], points = [{points}], '
        joints += "axes = [[0, 0, 1], [0, 0, 1]] }\n"
    known = {"rate": RATE, "phase": 0}
    parameters = "".join(f"{name} = {known[name]}\n" for name in known if name in law)
    return scene_from_toml(
        'name = "bars"\nunit = "m"\ngravity = [0, -9.81, 0]\n'
        f"[parameters]\n{parameters}{bodies}"
        f'[joints]\n{joints}[drivers]\nmotor = {{ joint = "{joint}", value = "{law}" }}\n'
    )


@pytest.fixture
def load(load: Load) -> Load:
    return lambda scene: load(scene, *OUTPUTS)


def end_of(motion: Motion, body: str, length: float) -> Array:
    """Place of the end of a bar."""
    e0, e3 = motion.orientation[body][:, 0], motion.orientation[body][:, 3]
    turned = np.stack([e0**2 - e3**2, 2 * e0 * e3], axis=1)
    end: Array = motion.position[body][:, :2] + length * turned
    return end


@pytest.mark.parametrize("samples", [5, 61])
def test_positions_are_those_of_the_closed_form_however_far_apart(load: Load, samples: int) -> None:
    end = math.tau / RATE * 2
    motion = load(four_bar()).simulate(end, samples=samples, tolerance=0.01)  # of the work alone
    wanted = pin(1.0 + RATE * motion.time, ROCKER)
    np.testing.assert_allclose(end_of(motion, "rocker", ROCKER), wanted, rtol=0, atol=1e-13)
    np.testing.assert_allclose(end_of(motion, "coupler", COUPLER), wanted, rtol=0, atol=1e-13)
    ledger = motion.ledger
    assert ledger.method == "kinematics"
    assert (ledger.steps > samples - 1) == (ledger.rejected > 0) == (samples == 5)
    assert 2 * ledger.steps < ledger.corrections <= ledger.factorisations
    assert 0.0 < ledger.drift < 0.5
    assert "kinematics, driven" in str(ledger)


def test_velocities_and_accelerations_are_derivatives_of_the_positions(load: Load) -> None:
    motion = load(four_bar()).simulate(times=np.linspace(0.2, 0.3, 1001))
    h = motion.time[1] - motion.time[0]
    for low, high in (("position", "velocity"), ("velocity", "acceleration")):
        values = getattr(motion, low)["coupler"]
        slopes = (values[:-4] - 8 * values[1:-3] + 8 * values[3:-1] - values[4:]) / (12 * h)
        np.testing.assert_allclose(
            slopes, getattr(motion, high)["coupler"][2:-2], rtol=0, atol=1e-7
        )


def test_power_of_the_driver_is_what_its_reactions_and_the_energies_say(load: Load) -> None:
    motion = load(four_bar()).simulate(1.0, samples=501)
    assert motion.ledger.energy_error == pytest.approx(
        0.0, abs=1e-6 * np.ptp(motion.energy["total"])
    )
    change = motion.energy["total"] - motion.energy["total"][0]
    np.testing.assert_allclose(motion.work["motor"], change, rtol=0, atol=1e-4)
    power = RATE * motion.torque["motor"][:, 2]
    work = np.cumsum((power[1:] + power[:-1]) / 2) * motion.time[1]
    np.testing.assert_allclose(np.abs(work), np.abs(change[1:]), rtol=0, atol=0.02)


def test_runge_kutta_gives_the_same_motion(load: Load) -> None:
    solver = load(four_bar())
    times = np.linspace(0.0, 1.0, 11)
    wanted = solver.simulate(times=times).columns()
    for options in ({"method": "dop853"}, {"method": "dopri5", "step": 0.01}):
        motion = solver.simulate(times=times, tolerance=1e-10, **options)
        for name, values in motion.columns().items():
            if name.startswith(("energy", "work")):
                continue
            scale = max(1.0, np.abs(wanted[name]).max())
            np.testing.assert_allclose(
                values, wanted[name], rtol=0, atol=1e-10 * scale, err_msg=name
            )
    assert motion.ledger.energy_error is not None
    assert motion.ledger.energy_error < 1e-6


def test_a_dead_centre_stops_the_motion_and_keeps_what_was_before(load: Load) -> None:
    with pytest.raises(MotionError, match=r"no step can .* dead centre.*drivers\.motor") as stop:
        load(four_bar(joint="d", law="t")).simulate(3.0, samples=301)
    motion = stop.value.result
    assert isinstance(motion, Motion)
    pin = end_of(motion, "coupler", COUPLER)[-1]  # the crank points the other way
    assert np.hypot(*pin) == pytest.approx(COUPLER - CRANK, abs=0.02)
    assert 50 < len(motion) < 301


@pytest.mark.parametrize("samples", [61, 101])
def test_change_points_of_a_parallelogram_are_passed_on_its_branch(
    load: Load, samples: int
) -> None:
    motion = load(four_bar(rocker=CRANK)).simulate(math.tau / RATE * 2, samples=samples)
    crank = end_of(motion, "crank", CRANK)
    rocker = end_of(motion, "rocker", CRANK) - [GROUND, 0.0]
    np.testing.assert_allclose(rocker, crank, rtol=0, atol=1e-12)
    assert motion.ledger.growth < 1e-2


def test_rows_exactly_at_a_change_point_are_told_by_those_around_it(load: Load) -> None:
    at = (math.pi - 1.0) / RATE
    times = [0.0, at - 0.01, at - 1e-9, at, at + 1e-6, at + 0.01, at + math.pi / RATE, 1.0]
    motion = load(four_bar(rocker=CRANK)).simulate(times=times)
    rocker = end_of(motion, "rocker", CRANK) - [GROUND, 0.0]
    np.testing.assert_allclose(rocker, end_of(motion, "crank", CRANK), rtol=0, atol=1e-11)
    np.testing.assert_allclose(motion.angular_velocity["rocker"][:, 2], RATE, rtol=0, atol=1e-6)
    np.testing.assert_allclose(motion.angular_acceleration["rocker"], 0, rtol=0, atol=1e-2)
    is_unknown = np.isnan(motion.force["c"]).any(axis=1)
    assert is_unknown.tolist() == [False, False, True, True, True, False, True, False]
    ledger = motion.ledger
    assert (ledger.passed, ledger.passed_time) == (4, times[6])
    assert "4 rows where rows of the constraints are dependent" in str(ledger)


def test_rows_are_told_where_several_loops_lie_flat_at_once(load: Load) -> None:
    """Two pivots vanish together there, so that others are no numbers."""
    text = to_toml(n_four_bar(3)) + '\n[drivers]\nm = { joint = "ground_0", value = "-2*pi*t" }\n'
    motion = load(scene_from_toml(text)).simulate(times=[0.0, 0.25, 0.5, 0.75, 1.0])
    turns = math.tau * motion.time
    for k in range(3):
        place = np.stack([k + np.sin(turns), np.cos(turns)], axis=1)
        got = motion.position[f"coupler_{k}"][:, :2]
        np.testing.assert_allclose(got, place, rtol=0, atol=1e-11)
    assert motion.ledger.passed == 2


def test_branches_that_nearly_meet_are_not_exchanged_by_few_positions(load: Load) -> None:
    rocker = CRANK + 1e-3
    motion = load(four_bar(rocker=rocker)).simulate(math.tau / RATE * 3, samples=11)
    wanted = pin(1.0 + RATE * motion.time, rocker)
    np.testing.assert_allclose(end_of(motion, "rocker", rocker), wanted, rtol=0, atol=1e-11)


@pytest.mark.parametrize("gap", [1e-4, 1e-6])
@pytest.mark.parametrize("samples", [2, 6, 11])
def test_steps_do_not_leap_onto_the_branch_beside_a_singular_configuration(
    backend: str, bodies_folder: Callable[..., Path], gap: float, samples: int
) -> None:
    """Without masses no works keep steps short: pivots alone tell that another branch is near."""
    rocker, target = CRANK + gap, cast("Any", backend)
    scene = four_bar(rocker=rocker)
    scene = replace(scene, bodies={name: replace(x, boxes=()) for name, x in scene.bodies.items()})
    solver = load_dynamics(bodies_folder(scene, ("accelerations",)), target=target)
    motion = solver.simulate(math.tau / RATE * 3, samples=samples)
    wanted = pin(1.0 + RATE * motion.time, rocker)
    np.testing.assert_allclose(end_of(motion, "rocker", rocker), wanted, rtol=0, atol=1e-11)
    assert motion.ledger.steps < 300


@pytest.mark.parametrize("method", ["kinematics", "dop853", "dopri5"])
@pytest.mark.parametrize("gap", [0.0, 1e-15, 1e-12, 1e-10, 1e-8, 1e-4])
def test_no_other_branch_is_followed_without_a_word(load: Load, gap: float, method: Any) -> None:
    rocker = CRANK + gap
    times = [0.0, 0.77 * math.tau / RATE]
    motion = load(four_bar(rocker=rocker)).simulate(times=times, method=method, tolerance=1e-6)
    wanted = pin(1.0 + RATE * motion.time, rocker)
    is_there = np.abs(end_of(motion, "rocker", rocker) - wanted).max() < 1e-3
    ledger = motion.ledger
    assert is_there or ledger.branch_points > 0 or (ledger.meetings > 0 and gap < 1e-14)
    assert gap < 1e-6 or ledger.branch_points + ledger.meetings == 0
    assert not (ledger.trust.is_trusted and ledger.branch_points > 0)
    assert ledger.trust.is_trusted or gap > 0.0
    for time, said in (
        (ledger.branch_point_time, "branch not known beyond t = {}"),
        (ledger.meeting_time, "branches meet at t = {}"),
    ):
        if time is not None:
            assert -0.01 < time - (math.pi - 1.0) / RATE < 0.2
            assert said.format(shortly(time, 6)) in str(ledger.trust)
    assert ("may be that of another branch" in str(ledger)) == (ledger.branch_points > 0)
    assert ("went straight on there" in str(ledger)) == (ledger.meetings > 0)


@pytest.mark.parametrize("gap", [5e-13, 2e-12, 1e-10])
def test_driven_motions_go_on_where_rounding_blurs_positions(load: Load, gap: float) -> None:
    """Beside another branch it leaves 1e-9 of a position and more, whatever the steps."""
    solver = load(four_bar(rocker=CRANK + gap))
    motion = solver.simulate(2.3 * math.tau / RATE, samples=51, tolerance=1e-8)
    wanted = pin(1.0 + RATE * motion.time, CRANK + gap)
    np.testing.assert_allclose(end_of(motion, "rocker", CRANK + gap), wanted, rtol=0, atol=1e-6)
    assert not motion.ledger.trust.is_trusted  # works are not known so well


@pytest.mark.parametrize("gap", [1e-4, 2e-4, 4e-4])
@pytest.mark.parametrize("samples", [3, 11])
def test_works_in_sharp_bends_are_as_exact_as_the_tolerance(
    load: Load, gap: float, samples: int
) -> None:
    """Powers are narrow there, beside the nodes of a rule, and its own error told too little."""
    solver = load(four_bar(rocker=CRANK + gap))
    motion = solver.simulate(2.3 * math.tau / RATE, samples=samples, tolerance=1e-9)
    trust = motion.ledger.trust
    assert trust.is_trusted, trust
    assert trust.energy_error is not None
    assert trust.energy_moved is not None
    assert trust.energy_error < 0.5 * trust.limit * trust.energy_moved
    assert motion.ledger.derivatives < 2500


@pytest.mark.parametrize("method", ["dop853", "dopri5"])
@pytest.mark.parametrize("gap", [1e-10, 1e-8, 1e-6])
@pytest.mark.parametrize("tolerance", [1e-3, 1e-6])
def test_steps_of_driven_motions_keep_to_their_branch(
    load: Load, gap: float, method: Any, tolerance: float
) -> None:
    times = [0.0, 0.77 * math.tau / RATE]
    solver = load(four_bar(rocker=CRANK + gap))
    motion = solver.simulate(times=times, method=method, tolerance=tolerance)
    wanted = pin(1.0 + RATE * motion.time, CRANK + gap)
    np.testing.assert_allclose(end_of(motion, "rocker", CRANK + gap), wanted, rtol=0, atol=1e-9)


@pytest.mark.parametrize(
    ("gap", "method", "tolerance", "turns"),
    [
        *((3e-11, "kinematics", 1e-6, 0.77), (1e-9, "kinematics", 1e-3, 0.4)),
        *((1e-7, "kinematics", 3e-4, 3.6), (1e-5, "kinematics", 1e-3, 1.3)),
        *((1e-9, "dopri5", 1e-4, 2.3), (1e-6, "dopri5", 3e-4, 2.3)),
    ],
)
def test_motions_at_loose_tolerances_are_on_their_branch_or_not_trusted(
    load: Load, gap: float, method: Any, tolerance: float, turns: float
) -> None:
    """The smallest pivot is another one but near where branches meet, and tells it too late."""
    times = [0.0, turns * math.tau / RATE]
    solver = load(four_bar(rocker=CRANK + gap))
    motion = solver.simulate(times=times, method=method, tolerance=tolerance)
    wanted = pin(1.0 + RATE * motion.time, CRANK + gap)
    is_there = np.abs(end_of(motion, "rocker", CRANK + gap) - wanted).max() < 1e-9
    assert is_there or not motion.ledger.trust.is_trusted
    assert is_there or gap < 1e-8


@pytest.mark.parametrize("method", ["kinematics", "dop853", "dopri5"])
def test_branches_that_meet_are_told_and_leave_the_motion_trusted(load: Load, method: Any) -> None:
    motion = load(four_bar(rocker=CRANK)).simulate(math.tau / RATE, method=method, samples=61)
    rocker = end_of(motion, "rocker", CRANK) - [GROUND, 0.0]
    np.testing.assert_allclose(rocker, end_of(motion, "crank", CRANK), rtol=0, atol=1e-9)
    ledger = motion.ledger
    assert (ledger.meetings, ledger.branch_points) == (2, 0)
    assert ledger.trust.is_trusted
    assert ledger.as_data()["meetings"] == 2
    assert ledger.trust.as_data()["meeting_time"] == ledger.meeting_time
    assert ledger.meeting_time is not None
    assert f"branches meet at t = {shortly(ledger.meeting_time, 6)} s" in repr(motion)


@pytest.mark.compiles
@pytest.mark.parametrize(
    ("scene", "end", "method", "few"),
    [
        *(("loop", 2.0, "dop853", 89), ("loop", 2.0, "dopri5", 44)),
        *(("engine", 0.2, "dop853", 668), ("engine", 0.2, "dopri5", 368)),
        *(("constant_velocity", 2.0, "dop853", 152), ("constant_velocity", 2.0, "dopri5", 104)),
    ],
)
def test_steps_far_from_other_branches_are_nearly_as_long_as_errors_allow(
    scene: str, end: float, method: Any, few: int
) -> None:
    """Few evaluations were enough where nothing looked at branches."""
    mechanism = kousoku.load(SCENES / f"{scene}.toml")
    run = mechanism.simulate(end, samples=8, method=method, tolerance=1e-4)
    assert run.ledger.derivatives <= 1.2 * few


def test_where_branches_are_not_told_apart_it_is_not_trusted_from_the_first_on(load: Load) -> None:
    solver = load(four_bar(rocker=CRANK + 1e-11))
    times = [0.0, 2.3 * math.tau / RATE]
    motion = solver.simulate(times=times, method="dop853", tolerance=1e-3)
    assert motion.ledger.branch_points > 1
    assert not motion.ledger.trust.is_trusted
    assert motion.ledger.branch_point_time == pytest.approx((math.pi - 1.0) / RATE, abs=0.01)


@pytest.mark.parametrize("phase", [0.1, -3.0, 10.0, 50.0])
def test_drivers_that_begin_elsewhere_lead_the_bodies_there_on_their_branch(
    load: Load, phase: float
) -> None:
    """Newton's method alone finds the other branch from −3 and 10 rad, and none from 50 rad."""
    solver = load(four_bar(law="rate*t + phase"))
    motion = solver.simulate(0.5, samples=6, parameters={"phase": phase})
    wanted = pin(1.0 + phase + RATE * motion.time, ROCKER)
    np.testing.assert_allclose(end_of(motion, "rocker", ROCKER), wanted, rtol=0, atol=1e-12)


def test_run_in_pieces_gives_the_bits_of_a_run_in_one(load: Load) -> None:
    solver = load(four_bar())
    times = np.linspace(0.0, 3.0, 7)
    whole = solver.begin(times)
    wanted = whole.finish().columns()
    run = solver.begin(times)
    calls = [run.advance(1, 1)]
    while calls[-1] in (Status.BUFFER_FULL, Status.PAUSED):
        run = solver.resume(run.save())
        run._memory.work[:] = np.nan
        calls.append(run.advance(1, 1))
    assert len(calls) > 10
    np.testing.assert_array_equal(run.state, whole.state)
    for name, values in run.motion().columns().items():
        np.testing.assert_array_equal(values, wanted[name])


def test_steps_fit_the_work_only_where_somebody_is_told_of_it(
    backend: str, bodies_folder: Callable[..., Path]
) -> None:
    target: Any = backend
    told = load_dynamics(bodies_folder(four_bar(), OUTPUTS), target=target)
    untold = load_dynamics(bodies_folder(four_bar(), ("accelerations",)), target=target)
    bodies = {name: replace(body, boxes=()) for name, body in four_bar().bodies.items()}
    scene = replace(four_bar(), bodies=bodies)
    massless = load_dynamics(bodies_folder(scene, ("accelerations",)), target=target)
    times = np.linspace(0.0, 1.0, 3)
    pairs = [(one, checks) for one in (told, untold, massless) for checks in (True, False)]
    ledgers = [one.simulate(times=times, checks=checks).ledger for one, checks in pairs]
    few = ledgers[3].derivatives
    assert few < 60
    assert [one.derivatives > 3 * few for one in ledgers] == [True, True, True, False, False, False]
    assert [bool(one.works) for one in ledgers] == [True, False, True, False, False, False]


def test_no_step_is_longer_than_it_may_be(load: Load) -> None:
    solver = load(four_bar())
    ledger = solver.simulate(times=[0.0, 1.0], largest_step=0.01, tolerance=0.01).ledger
    assert ledger.steps == 100
    assert ledger.rejected == 0


def test_methods_name_where_they_do_not_belong(load: Load) -> None:
    with pytest.raises(SolveError, match=r"step 0\.1: the method 'kinematics' goes from one time"):
        load(four_bar()).simulate(1.0, step=0.1)
    with pytest.raises(SolveError, match="wanted one of dopri5, dop853, kinematics"):
        load(four_bar()).simulate(1.0, method="euler")


def drawn(law: str, joint: str = '"inline"') -> Scene:
    """Point on a rail, or in a plane, whose distance from a point of it is driven."""
    return scene_from_toml(
        'name = "drawn"\nunit = "m"\n[parameters]\nleast = 0.0\n'
        "[bodies.slider]\nposition = [1, 0, 0]\npoint = true\nmass = 1\n[joints]\n"
        f'rail = {{ type = {joint}, bodies = ["ground", "slider"], at = [0, 0, 0],'
        f" axis = {[1, 0, 0] if 'line' in joint else [0, 0, 1]} }}\n[coordinates]\n"
        'far = { bodies = ["ground", "slider"], points = [[0, 0, 0], [0, 0, 0]] }\n'
        f'[drivers]\nwinch = {{ coordinate = "far", value = "{law}" }}\n'
    )


@pytest.mark.parametrize(
    "law",
    ["(1 - t)^2 + least", "0.5 + 0.5*cos(pi*t) + least", "1 - t + least", "1.1 - 0.1*exp(3*t)"],
)
@pytest.mark.parametrize("samples", [2, 4, 5, 21])
def test_points_whose_distance_is_driven_to_zero_stop_there(
    load: Load, law: str, samples: int
) -> None:
    """They parted on one side or the other, by the rows that were asked for, without a word."""
    scene = drawn(law if "least" in law else f"{law} + least")
    with pytest.raises(MotionError, match=r"winch prescribes a distance of 0") as stop:
        load(scene).simulate(2.0, samples=samples)
    assert "nothing tells in which direction they part" in str(stop.value)
    wanted = math.log(11.0) / 3.0 if "exp" in law else 1.0
    reached = float(str(stop.value).split("t = ")[1].split(" s")[0])
    assert reached == pytest.approx(wanted, abs=1e-4)


@pytest.mark.parametrize("law", ["(1 - t)^2 + least", "0.5 + 0.5*cos(pi*t) + least"])
def test_points_whose_distance_stays_positive_part_where_they_came(load: Load, law: str) -> None:
    solver = load(drawn(law))
    for samples in (2, 4, 5, 21):
        motion = solver.simulate(2.0, samples=samples, parameters={"least": 1e-6})
        assert motion.position["slider"][-1, 0] == pytest.approx(1.0, abs=1e-5)
        assert motion.ledger.trust


def test_free_points_whose_distance_is_driven_to_zero_stop_there(load: Load) -> None:
    solver = load(drawn("sqrt((1 - t)^2 + 0.01) - 0.1 + least", '"inplane"'))
    for samples in (2, 7, 101):
        with pytest.raises(MotionError, match=r"winch prescribes a distance of 0"):
            solver.simulate(2.0, samples=samples)


#: What leads the other end of the coupling, by (1 - t)^2 less than a metre from where it starts.
LEADING = {
    "directly": (
        '[drivers]\nmotor = { coordinate = "x", value = "size*(1 - (1 - t)^2)" }\n',
        "motor with joints.tie",
    ),
    "by a rack": (
        "[bodies.pinion]\nposition = [0, 2, 0]\nmass = 1\ninertia = { xx = 1, yy = 1, zz = 1 }\n"
        "[joints.axle]\n"
        'type = "revolute"\nbodies = ["ground", "pinion"]\nat = [0, 2, 0]\naxis = [0, 0, 1]\n'
        '[joints.mesh]\ntype = "rack_and_pinion"\njoints = ["axle", "slide"]\nradius = 0.3\n'
        '[coordinates.turn]\njoint = "axle"\n'
        '[drivers]\nmotor = { coordinate = "turn", value = "size*(2*t - t^2)/0.3" }\n',
        "motor with joints.tie and joints.mesh",
    ),
    "by two": (
        "[bodies.third]\nposition = [0, 2, 0]\npoint = true\nmass = 1\n[joints.guide]\n"
        'type = "point_on_line"\nbodies = ["ground", "third"]\nat = [0, 2, 0]\naxis = [1, 0, 0]\n'
        '[joints.second]\ntype = "linear"\ncoordinates = ["x", "z"]\nfactors = [2, "size"]\n'
        '[coordinates.z]\nbody = "third"\nalong = [1, 0, 0]\n'
        '[drivers]\nmotor = { coordinate = "z", value = "-2*(2*t - t^2)" }\n',
        "motor with joints.tie and joints.second",
    ),
    "by a point": (
        "[bodies.third]\nposition = [0, 2, 0]\npoint = true\nmass = 1\n"
        '[joints.second]\ntype = "linear"\ncoordinates = ["z", "x"]\nfactors = [-0.1, 0.1]\n'
        '[coordinates.z]\nbody = "third"\nalong = [1, 0, 0]\n'
        '[drivers]\nmotor = { body = "third", path = ["size*(2*t - t^2)", "2", "t"] }\n',
        "motor with joints.tie and joints.second",
    ),
}


def tied(leading: str, more: str = "") -> Scene:
    """Point on a rail, whose distance from a point of it is coupled with a rack beside it."""
    return scene_from_toml(
        'name = "tied"\nunit = "m"\n[parameters]\nsize = 1.0\n'
        "[bodies.slider]\nposition = [1, 0, 0]\npoint = true\nmass = 1\n"
        "[bodies.rack]\nposition = [0, 1, 0]\nmass = 1\n"
        "inertia = { xx = 1, yy = 1, zz = 1 }\n[joints]\n"
        'rail = { type = "inline", bodies = ["ground", "slider"], at = [0, 0, 0],'
        " axis = [1, 0, 0] }\n"
        'slide = { type = "prismatic", bodies = ["ground", "rack"], at = [0, 1, 0],'
        " axis = [1, 0, 0] }\n"
        'tie = { type = "linear", coordinates = ["far", "x"], factors = [3, 3] }\n[coordinates]\n'
        'far = { bodies = ["ground", "slider"], points = [[0, 0, 0], [0, 0, 0]] }\n'
        f'x = {{ joint = "slide" }}\n{leading}{more}'
    )


@pytest.mark.parametrize("leading", LEADING)
def test_points_whose_distance_is_coupled_with_what_is_driven_stop_where_they_meet(
    load: Load, leading: str
) -> None:
    """They parted on one side or the other, by the rows that were asked for, without a word."""
    text, named = LEADING[leading]
    solver = load(tied(text))
    for samples in (2, 3, 11):
        with pytest.raises(MotionError) as stop:
            solver.simulate(2.0, samples=samples)
        assert f"drivers.{named} prescribes a distance of 0" in str(stop.value)
        reached = float(str(stop.value).split("t = ")[1].split(" s")[0])
        assert reached == pytest.approx(1.0, abs=1e-4)
    short = solver.simulate(2.0, samples=3, parameters={"size": 0.9})
    assert short.position["slider"][:, 0] == pytest.approx([1.0, 0.1, 1.0], abs=1e-8)
    assert short.ledger.trust
    with pytest.raises(MotionError, match="prescribes a distance of 0") as stop:
        solver.simulate(2.0, samples=3, parameters={"size": 1.1})
    reached = float(str(stop.value).split("t = ")[1].split(" s")[0])
    assert reached == pytest.approx(1.0 - math.sqrt(1.0 - 1.0 / 1.1), abs=1e-4)


def test_what_counts_as_no_distance_follows_parameters(load: Load) -> None:
    """It was a part of what the distance is with the parameters of the scene."""
    solver = load(drawn("(1 + 1e3*least)*(1 - t)"))
    for least in (0.0, 1.0, -1e-3 * (1.0 - 1e-8)):
        with pytest.raises(MotionError, match="winch prescribes a distance of 0") as stop:
            solver.simulate(2.0, samples=2, parameters={"least": least})
        reached = float(str(stop.value).split("t = ")[1].split(" s")[0])
        assert reached == pytest.approx(1.0, abs=1e-8)
