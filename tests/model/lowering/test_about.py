"""What is told of a scene beside numbers: joints far from their bodies, forces that jump."""

from __future__ import annotations

from typing import Any

import pytest

from kousoku.model.lowering.about import About, scene_notes
from kousoku.model.lowering.root_functions import root_functions_of
from kousoku.model.lowering.system import system_of
from kousoku.model.reading.read import scene_from_dict

HINGE = {"type": "revolute", "axis": [0, 0, 1]}


def bar(x: float, y: float = 0.0, **solids: Any) -> dict[str, Any]:
    rods = [{"mass": 1, "ends": [[0, 0, 0], [1, 0, 0]]}]
    return {"position": [x, y, 0], **(solids or {"rods": rods})}


def pair(at: list[float], *, points: Any = None, **solids: Any) -> dict[str, Any]:
    where = {"points": points} if points else {"at": at}
    joints = {"a": {**HINGE, "bodies": ["one", "other"], **where}}
    bodies = {"one": bar(0), "other": bar(1, **solids)}
    return {"name": "s", "unit": "m", "bodies": bodies, "joints": joints}


@pytest.mark.parametrize("at", [[1, 0, 0], [1.3, 0.2, 0], [0.2, 0, 0]])
def test_a_joint_near_one_of_its_bodies_is_not_told(at: list[float]) -> None:
    assert [*scene_notes(scene_from_dict(pair(at)))] == []


def test_a_joint_that_is_far_from_both_bodies_is_told_with_its_distance() -> None:
    (note,) = scene_notes(scene_from_dict(pair([1, 3, 0])))
    assert note == "joints.a lies 3 m from all that one and other are made of"


@pytest.mark.parametrize(
    ("solids", "far"),
    [
        ({"cylinders": [{"mass": 1, "radius": 0.5, "ends": [[0, 0, 0], [1, 0, 0]]}]}, 2.5),
        ({"boxes": [{"mass": 1, "size": [1, 1, 1]}]}, 2.5),
        ({"spheres": [{"mass": 1, "radius": 0.75}]}, 2.25),
        ({"mass_points": [{"mass": 1, "at": [0, k, 0]} for k in (-1, 1)]}, 2.0),
    ],
)
def test_each_solid_reaches_as_far_as_it_does(solids: dict[str, Any], far: float) -> None:
    tree = pair([1, 3, 0], points=[[0, 9, 0], [0, 3, 0]], **solids)
    (note,) = scene_notes(scene_from_dict(tree))
    assert f"lies {far:g} m from" in note


def test_a_box_is_seen_in_its_own_axes() -> None:
    box = {"mass": 1, "size": [6, 1, 1]}
    turned = {**box, "orientation": {"axis": [0, 0, 1], "angle": "90 deg"}}
    points = [[0, 9, 0], [0, 3.5, 0]]
    assert [*scene_notes(scene_from_dict(pair([], points=points, boxes=[turned])))] == []
    assert not [*scene_notes(scene_from_dict(pair([], points=points, boxes=[box])))]  # 3 of 6.2 m


def test_a_ball_on_a_rod_without_mass_is_no_mistake_and_a_bar_beside_its_hinge_is() -> None:
    ball = bar(0, -1, spheres=[{"mass": 1, "radius": 0.1}])
    tree = {"name": "s", "unit": "m", "bodies": {"b": ball}}
    tree["joints"] = {"a": {**HINGE, "bodies": ["ground", "b"], "at": [0, 0, 0]}}
    assert [*scene_notes(scene_from_dict(tree))] == []
    tree["bodies"] = {"b": bar(0, -1)}
    assert [*scene_notes(scene_from_dict(tree))] == ["joints.a lies 1 m from all that b is made of"]


def test_a_force_that_jumps_and_the_duration_are_told() -> None:
    tree = pair([1, 0, 0])
    tree["coordinates"] = {"s": {"joint": "a"}}
    laws = {
        "rub": "-3*sign(s_dot)",
        "smooth": "-3*s_dot/sqrt(s_dot^2 + 1e-6)",
        "written": "-3*s_dot/sqrt(s_dot^2)",
    }
    tree["forces"] = {
        name: {"type": "along", "coordinate": "s", "force": law} for name, law in laws.items()
    }
    scene = scene_from_dict(tree | {"duration": 2})
    assert About.of(scene, ["more"]) == About(("more",), 2.0, ("forces.rub", "forces.written"))


@pytest.mark.parametrize(
    ("force", "is_told"),
    [
        ("1e-9*tan(s)", True),
        ("-tan(s_dot + p)*s", True),
        ("tan(t)", True),
        ("tan(p)*s", False),
        ("tan(1.5*sin(s))", False),
        ("tan(1.6*sin(s))", True),
        ("sin(s)/(2 + cos(s))", False),
        ("1e-9/(s^2 - 2*s + 1)", True),
        ("s/sqrt(s^2 + 1e-6)", False),
        ("1/(s^2 + s_dot^2 + 1)", False),
        ("s/p", False),
    ],
)
def test_a_force_that_may_be_infinite_is_looked_at(force: str, *, is_told: bool) -> None:
    tree = pair([1, 0, 0])
    tree |= {"coordinates": {"s": {"joint": "a"}}, "parameters": {"p": 0.1}}
    tree["forces"] = {"spring": {"type": "along", "coordinate": "s", "force": force}}
    functions = root_functions_of(system_of(scene_from_dict(tree), ()))
    assert functions.pole_forces == ("forces.spring",) * is_told
    assert len(functions.infinite) == is_told
