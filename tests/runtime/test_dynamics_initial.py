"""Initial values at run time: coordinates that are led, bodies that are placed, and refusals."""

from __future__ import annotations

import copy
import pickle
import tomllib
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.model.errors import SolveError
from kousoku.model.reading.read import scene_from_dict
from kousoku.runtime.dynamics import load_dynamics
from kousoku.runtime.integrate import initial_coordinates as leading
from kousoku.runtime.integrate.euler_parameters import rotated

if TYPE_CHECKING:
    from collections.abc import Callable

SCENES = Path(__file__).parents[2] / "scenes"
WANTED = ("velocities", "coordinates")
ROD = "cylinders = [{ mass = 1, radius = 0.1, ends = [[0, 0, 0], [0, -1, 0]] }]"
TRIPLE = f"""
name = "triple"
unit = "m"
gravity = [0, -9.81, 0]
[bodies]
one = {{ position = [0, 0, 0], {ROD} }}
two = {{ position = [0, -1, 0], {ROD} }}
three = {{ position = [0, -2, 0], {ROD} }}
[joints]
a = {{ type = "revolute", bodies = ["ground", "one"], at = [0, 0, 0], axis = [0, 0, 1] }}
b = {{ type = "ball", bodies = ["one", "two"], at = [0, -1, 0] }}
c = {{ type = "ball", bodies = ["two", "three"], at = [0, -2, 0] }}
[coordinates]
swing = {{ joint = "a" }}
"""


def tree_of(name: str, **changes: Any) -> dict[str, Any]:
    tree = tomllib.loads((SCENES / f"{name}.toml").read_text(encoding="utf-8"))
    return {key: value for key, value in (tree | changes).items() if value is not None}


def free_gears() -> dict[str, Any]:
    return tree_of("gear_train", drivers=None, parameters=None)


def cranks() -> dict[str, Any]:
    coordinates = {"first": {"joint": "ground_0"}, "last": {"joint": "ground_2"}}
    return tree_of("n_four_bar", coordinates=coordinates)


pytestmark = pytest.mark.usefixtures("compiler", "numpy_solver")


@pytest.fixture
def load(bodies_folder: Callable[..., Path]) -> Any:
    def loaded(tree: dict[str, Any], target: Any = "c", wanted: tuple[str, ...] = WANTED) -> Any:
        return load_dynamics(bodies_folder(scene_from_dict(tree), wanted), target=target)

    return loaded


def start(solver: Any, **options: Any) -> Any:
    return solver.simulate(times=[0.0], **options)


def written(motion: Any, row: int) -> dict[str, Any]:
    """Row as the bodies of the scene are written."""
    tables = ((motion.position, motion.orientation), (motion.velocity, motion.angular_velocity))
    return {
        name: np.concatenate(
            [
                table[body][row]
                for body in motion.position
                for table in (moves, turns)
                if body in table
            ]
        )
        for name, (moves, turns) in zip(("q0", "v0"), tables, strict=True)
    }


@pytest.mark.parametrize(
    ("tree", "initial"),
    [
        (tree_of("loop_free"), {"crank_angle": 0.5}),
        (tree_of("loop_free"), {"crank_angle": -2.5, "rocking_dot": 1.0}),
        (cranks(), {"first": -2.0, "last_dot": 3.0}),
        (free_gears(), {"wheel_angle": 40.0, "rack_place_dot": 5.0}),
        (tree_of("falling_nut"), {"turned": -30.0, "height_dot": 0.1}),
        (
            tree_of("bricard", coordinates={"a_angle": {"joint": "a"}}),
            {"a_angle": -3.0, "a_angle_dot": 1.0},
        ),
        (tree_of("pendulum", coordinates={"swing": {"joint": "hinge"}}), {"swing": 30.0}),
        (tomllib.loads(TRIPLE), {"swing": 3.0, "swing_dot": -2.0}),
    ],
    ids=lambda value: value.get("name", "-"),
)
def test_coordinates_start_where_they_are_told_to_with_both_targets(
    load: Any, tree: dict[str, Any], initial: dict[str, float]
) -> None:
    runs = [load(tree, target).begin([0.0, 0.1], initial=initial) for target in ("c", "numpy")]
    for run in runs:
        motion = run.finish()
        for name, wanted in initial.items():
            own = name.removesuffix("_dot")
            table = motion.coordinate if own == name else motion.coordinate_rate
            assert table[own][0] == pytest.approx(wanted, rel=1e-12, abs=1e-12)
        solver = run.solver
        count = len(solver.q)
        at = solver.evaluate(0.0, *np.split(run._rows[0, 1 : 1 + count + len(solver.v)], [count]))
        assert np.abs(np.concatenate([at["C"], at["C_left_out"]])).max() < 1e-13
        assert np.abs(at["C_dot"]).max() < 1e-12 * max(1.0, np.abs(solver.v).max(), 40.0)
    first, second = (run._rows[0] for run in runs)
    assert np.abs(first - second).max() < 1e-12


def written_there(led: Any) -> dict[str, Any]:
    """Linkage of loop_free, written where a motion starts."""
    tree = tree_of("loop_free")
    place = {name: values[0] for name, values in led.position.items()}
    turn = {name: values[0] for name, values in led.orientation.items()}
    for name, origin in place.items():
        tree["bodies"][name] |= {
            "position": origin.tolist(),
            "orientation": {"quaternion": turn[name].tolist(), "order": "wxyz"},
            "velocity": led.velocity[name][0].tolist(),
            "angular_velocity_b": led.angular_velocity[name][0].tolist(),
        }
    tree["joints"]["b"]["at"] = place["coupler"].tolist()
    end = place["rocker"] + rotated(turn["rocker"], np.array([0.0, 2.0, 0.0]))
    axis = rotated(turn["coupler"], np.array([1.0, -3.0, 0.0]))
    tree["joints"]["c"] |= {"at": end.tolist(), "axis": axis.tolist()}
    return tree


def test_a_linkage_moves_as_one_that_is_written_there(load: Any) -> None:
    initial = {"crank_angle": 0.5, "crank_angle_dot": 2.0}
    led = load(tree_of("loop_free")).simulate(0.5, samples=6, initial=initial)
    there = load(written_there(led)).simulate(0.5, samples=6)
    for name, places in there.position.items():
        np.testing.assert_allclose(places, led.position[name], rtol=0.0, atol=1e-8)
        np.testing.assert_allclose(there.velocity[name][0], led.velocity[name][0], atol=1e-13)


def test_angles_in_degrees_and_what_is_not_given(load: Any) -> None:
    solver = load(cranks())
    motion = start(solver, initial={"first": "-30 deg"})
    assert motion.coordinate["first"][0] == pytest.approx(-np.pi / 6.0, abs=1e-15)
    assert motion.coordinate_rate["first"][0] == pytest.approx(-1.0, abs=1e-12)
    moved = start(solver, initial={"last_dot": "90 deg"})
    assert moved.coordinate["last"][0] == 0.0
    assert moved.coordinate_rate["first"][0] == pytest.approx(np.pi / 2.0, abs=1e-12)


def test_a_parallelogram_stays_one_beyond_the_place_where_it_lies_flat(load: Any) -> None:
    solver = load(cranks())
    for angle in (-2.0, -3.0, -np.pi, 2.5, -7.0):
        motion = start(solver, initial={"first": angle})
        assert motion.coordinate["last"][0] == pytest.approx(angle, abs=1e-12)
        assert motion.coordinate_rate["last"][0] == pytest.approx(-1.0, abs=1e-10)
    with pytest.raises(SolveError, match=r"first comes from 0 to -1\.57079\d* of -1\.57079633"):
        start(solver, initial={"first": -np.pi / 2.0})


def test_bodies_that_are_left_free_do_not_turn_however_many_steps_lead_there(
    load: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    solver = load(tomllib.loads(TRIPLE))
    found = [start(solver, initial={"swing": 2.0})]
    monkeypatch.setattr(leading, "LONGEST_CONTINUATION_STEP", 0.05)
    found.append(start(solver, initial={"swing": 2.0}))
    end = np.array([np.sin(2.0), -np.cos(2.0), 0.0])
    for motion in found:
        np.testing.assert_allclose(motion.position["two"][0], end, rtol=0.0, atol=1e-14)
        below = end - [0.0, 1.0, 0.0]
        np.testing.assert_allclose(motion.position["three"][0], below, rtol=0.0, atol=1e-14)


def test_many_steps_lead_where_few_do(load: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    solver = load(tree_of("loop_free"))
    options = {"initial": {"crank_angle": 7.0, "rocking_dot": 0.5}, "parameters": {"mass": 2.0}}
    few = start(solver, **options)
    monkeypatch.setattr(leading, "LONGEST_CONTINUATION_STEP", 0.02)
    many = start(solver, **options)
    for name, place in few.position.items():
        np.testing.assert_allclose(place, many.position[name], rtol=0.0, atol=1e-13)
        np.testing.assert_allclose(few.velocity[name], many.velocity[name], rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("target", ["c", "numpy"])
@pytest.mark.parametrize(
    "tree",
    [tree_of("loop_free"), free_gears(), tree_of("pendulum_on_a_rod"), tomllib.loads(TRIPLE)],
    ids=lambda tree: tree["name"],
)
def test_a_run_starts_where_another_one_was(load: Any, target: str, tree: Any) -> None:
    wanted = WANTED if "coordinates" in tree else ()
    solver = load(tree, target, wanted)
    initial = {"wheel_angle": 12.0} if "wheel" in tree["bodies"] else None
    before = solver.simulate(times=[0.0, 0.1, 0.2], initial=initial)
    after = solver.simulate(times=[0.0, 0.1], **written(before, 1))
    for name, place in after.position.items():
        np.testing.assert_allclose(place, before.position[name][1:], rtol=0.0, atol=1e-8)
        np.testing.assert_allclose(place[0], before.position[name][1], rtol=1e-13, atol=1e-13)
    for name, values in after.coordinate.items():
        turns = (values[0] - before.coordinate[name][1]) / (2.0 * np.pi)
        assert abs(turns - round(turns)) < 1e-12 or "place" in name


@pytest.mark.parametrize("target", ["c", "numpy"])
@pytest.mark.parametrize("way", [copy.deepcopy, lambda state: pickle.loads(pickle.dumps(state))])
def test_a_state_brings_its_turns_and_parameters_along(load: Any, target: str, way: Any) -> None:
    coil = {"coil": {"type": "along", "coordinate": "swing", "force": "-k*swing"}}
    swings = {"coordinates": {"swing": {"joint": "hinge"}}, "parameters": {"k": 1.0}}
    solver = load(tree_of("pendulum", forces=coil, **swings), target)
    whole = solver.simulate(times=[0.0, 0.2, 0.4], parameters={"k": 3.0}, initial={"swing": 15.0})
    _, q, v = way(whole.state(1))
    for run in (solver.begin([0.0, 0.2], q0=q, v0=v), solver.begin([0.0, 0.2]).restart(q0=q, v0=v)):
        rest = run.finish()
        assert dict(rest.parameters) == {"k": 3.0}
        np.testing.assert_allclose(rest["swing"], whole["swing"][1:], rtol=0, atol=1e-8)
    assert dict(start(solver, q0=q, v0=v, parameters={"k": 2.0}).parameters) == {"k": 2.0}
    alone = start(solver, q0=np.array(q), v0=v)
    assert dict(alone.parameters) == {"k": 1.0} and abs(alone["swing"][0]) < 2 * np.pi


@pytest.mark.parametrize("unit", ["m", "mm"])
def test_a_run_starts_over_where_bodies_are_as_written(load: Any, unit: str) -> None:
    box = {"mass": 1, "size": [1, 0.1, 0.2], "at": [0.5, 0, 0]}
    moving = {
        "position": [0, 0, 0],
        "angular_velocity": [1, 2, 0.5],
        "velocity": [0, 0, 1],
        "boxes": [box],
    }
    solver = load({"name": "box", "unit": unit, "bodies": {"b": moving}})
    q0, v0 = [0.0, 2.0, 0.0, 1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 1.0, 2.0, 3.0]
    wanted = solver.simulate(times=[0.0, 0.1], q0=q0, v0=v0)
    again = solver.begin([0.0, 0.1]).restart(q0=q0, v0=v0)
    np.testing.assert_array_equal(again.finish().rows, wanted.rows)
    np.testing.assert_array_equal(again.restart().finish().rows, wanted.rows)


def test_a_run_with_initial_values_resumes_with_the_same_bits(load: Any) -> None:
    solver = load(tree_of("loop_free"))
    options: Any = {"initial": {"crank_angle": "20 deg", "crank_angle_dot": 1}}
    whole = solver.simulate(0.5, samples=11, **options)
    run = solver.begin(np.linspace(0.0, 0.5, 11), **options)
    run.advance(3, 2)
    rest = solver.resume(pickle.loads(pickle.dumps(run.save()))).finish()
    np.testing.assert_array_equal(whole.coordinate["rocking"], rest.coordinate["rocking"])
    assert run.options.initial.values == (
        ("crank_angle", 20.0 * np.pi / 180.0),
        ("crank_angle_dot", 1.0),
    )


def test_without_initial_values_a_start_is_what_it_was(load: Any) -> None:
    solver = load(tree_of("loop_free"))
    given: tuple[dict[str, Any], ...] = ({}, {"initial": {}})
    states = [solver.begin([0.0], **options).state for options in given]
    np.testing.assert_array_equal(*states)


@pytest.mark.parametrize(
    ("tree", "options", "message"),
    [
        (
            "loop_free",
            {"initial": {"crank": 1}},
            r"no coordinate 'crank'.*did you mean 'crank_angle",
        ),
        (
            "loop_free",
            {"initial": {"rocking": "x"}},
            r"rocking is 'x'; wanted a finite number, or an",
        ),
        ("loop_free", {"initial": {"rocking": np.nan}}, r"rocking is nan; wanted a finite number"),
        ("loop_free", {"initial": [1.0]}, r"initial \[1.0\]; wanted a mapping of coordinates"),
        ("falling_nut", {"initial": {"height": "1 deg"}}, r"height is '1 deg'; wanted a finite"),
        ("loop_free", {"initial": {}, "q0": [1.0]}, r"give either initial, or q0 and v0"),
        ("loop_free", {"q0": [1.0]}, r"q0 has the shape \(1,\); wanted 21 numbers: of each"),
        ("loop_free", {"q0": [np.nan] * 21}, r"q0\[0\] is nan; wanted a finite number"),
        ("loop_free", {"v0": "fast"}, r"v0 'fast'; wanted a row of numbers"),
        (
            "loop_free",
            {"initial": {"rocking": 0.3}},
            r"rocking is 0\.3, but stays at 0: the start is a dead centre of rocking, its rate is 0"
            r" there, however crank_angle moves,.* give crank_angle instead",
        ),
        (
            "loop_free",
            {"initial": {"rocking_dot": 1.0}},
            r"rocking_dot is 1\.0, wanted 0: this place is a dead centre of rocking",
        ),
        (
            "loop_free",
            {"initial": {"crank_angle": 0.5, "rocking": 0.3}},
            r"rocking is 0.3, wanted 0.0410639548: it follows from the rest$",
        ),
        (
            "gear_train",
            {"initial": {"pinion_angle": 0.1, "rack_place_dot": 1.0}},
            r"pinion_angle is 0.1, wanted 0: drivers.motor says so at t = 0",
        ),
        (
            "gear_train",
            {"initial": {"pinion_angle_dot": 1.0}},
            r"pinion_angle_dot is 1.0, wanted 6.28318531: drivers.motor says so",
        ),
    ],
)
def test_what_cannot_be_is_refused_by_name(
    load: Any, tree: str, options: dict[str, Any], message: str
) -> None:
    for target in ("c", "numpy"):
        with pytest.raises(SolveError, match=message):
            start(load(tree_of(tree), target), **options)


def test_coordinates_that_were_not_generated_say_what_adds_them(load: Any) -> None:
    solver = load(tree_of("loop_free"), wanted=("velocities",))
    with pytest.raises(
        SolveError, match=r'generated without "coordinates"; load\(\.\.\., outputs='
    ):
        start(solver, initial={"crank_angle": 1.0})


def test_a_rocker_that_cannot_go_so_far_says_how_far_it_came(load: Any) -> None:
    crank = load(tree_of("loop_free"))
    begun = start(crank, initial={"crank_angle": 1.0})

    def swung(angle: float) -> float:
        return float(start(crank, initial={"crank_angle": angle}).coordinate["rocking"][0])

    about = max(np.linspace(2.0, 4.5, 26), key=swung)
    furthest = max(map(swung, np.linspace(about - 0.1, about + 0.1, 17)))
    furthest -= begun.coordinate["rocking"][0]
    rocker = load(written_there(begun))
    with pytest.raises(SolveError, match=r"rocking comes from 0 to [\d.]+ of 2 ") as caught:
        start(rocker, initial={"rocking": 2.0})
    reached = float(str(caught.value).split(" to ")[1].split()[0])
    assert reached == pytest.approx(furthest, abs=1e-4)
    motion = start(rocker, initial={"rocking": 0.9 * furthest})
    assert motion.coordinate["rocking"][0] == pytest.approx(0.9 * furthest, abs=1e-13)


def test_placed_bodies_are_refused_with_all_that_is_wrong(load: Any) -> None:
    solver = load(tree_of("loop_free"))
    given = written(start(solver), 0)
    q0 = given["q0"].copy()
    q0[7] += 0.1
    with pytest.raises(SolveError, match=r"b is open by 0\.1 m; c is open by 0\.1 m"):
        start(solver, q0=q0)
    with pytest.raises(SolveError, match=r"a is open by 0\.3 m/s"):
        start(solver, v0=given["v0"] + np.eye(len(given["v0"]))[0] * 0.3)
    q0[3] = 2.0
    with pytest.raises(SolveError, match="Euler parameters of body crank have not the norm 1"):
        start(solver, q0=q0)
    near = given["q0"].copy()
    near[7] += 1e-9
    np.testing.assert_allclose(start(solver, q0=near).position["coupler"][0], [0, 1, 0], atol=2e-9)


def test_placed_bodies_stay_in_the_plane_and_on_drivers(load: Any) -> None:
    planar = load(tree_of("pendulum"), wanted=())
    q0 = written(start(planar), 0)["q0"]
    q0[2] = 0.1
    with pytest.raises(SolveError, match=r"body rod by 0\.133.*proven to keep it in a plane"):
        start(planar, q0=q0)
    driven = load(tree_of("gear_train"))
    q0 = written(driven.simulate(times=[0.0, 0.05]), 1)["q0"]
    with pytest.raises(SolveError, match=r"drivers\.motor is open by 0\.314 rad"):
        start(driven, q0=q0)
