"""What is refused of forces, and what becomes of them in a system."""

from __future__ import annotations

from typing import Any

import pytest

from kousoku.model.builder import SceneBuilder
from kousoku.model.errors import SceneError
from kousoku.model.mechanism import GROUND_INDEX
from kousoku.model.read import scene_from_dict, scene_from_toml
from kousoku.model.system import system_of
from kousoku.model.write import to_toml

Tree = dict[str, Any]

SPRING: Tree = {
    "type": "spring_damper",
    "bodies": ["ground", "bar"],
    "points": [[0, 0, 0], [30, 0, 0]],
    "stiffness": 40,
}


def scene(**force: Any) -> Tree:
    """Return a bar and a point in mm under one force."""
    turned = {"axis": [0, 0, 1], "angle": 1.5707963267948966}
    bar = {"position": [0, 100, 0], "orientation": turned, "mass": 2, "center": [10, 0, 0]}
    inertia = {"xx": 300, "yy": 500, "zz": 600}
    dot = {"position": [50, 0, 0], "point": True, "mass": 1}
    return {
        "name": "loaded",
        "unit": "mm",
        "parameters": {"c": 3},
        "bodies": {"bar": bar | {"inertia": inertia}, "dot": dot},
        "forces": {"f": force},
    }


@pytest.mark.parametrize(
    ("force", "key", "says"),
    [
        ({"type": "spring"}, "type", "unknown force 'spring'"),
        ({"type": "rotational_spring_damper", "stiffness": 1}, "joint", "the angle that it acts"),
        ({"type": "force", "force": [1, 0, 0]}, "body", "is missing"),
        ({"type": "force", "body": "ground", "force": [1, 0, 0]}, "body", "unknown body 'ground'"),
        ({"type": "force", "body": "bar"}, "force", "or in the body frame as 'force_b'"),
        (
            {"type": "force", "body": "bar", "force": [1, 0, 0], "force_b": [1, 0, 0]},
            "force_b",
            "wanted one of them",
        ),
        ({"type": "torque", "body": "bar", "force": [1, 0, 0]}, "force", "a torque has none"),
        ({"type": "torque", "body": "dot", "torque": [1, 0, 0]}, "body", "a point does not turn"),
        ({"type": "force", "body": "dot", "force_b": [1, 0, 0]}, "force_b", "no axes of its own"),
        (
            {"type": "force", "body": "dot", "force": [1, 0, 0], "point": [1, 0, 0]},
            "point",
            "its only point",
        ),
        ({**SPRING, "bodies": ["bar", "bar"]}, "bodies", "to itself"),
        ({**SPRING, "bodies": ["bar", "baz"]}, "bodies[1]", "did you mean 'bar'"),
        ({**SPRING, "bodies": ["bar", "dot"]}, "points[1]", "its only point"),
        ({"type": "spring_damper", "bodies": ["ground", "bar"]}, "points", "is missing"),
        ({k: x for k, x in SPRING.items() if k != "stiffness"}, "stiffness", "a damping or both"),
        ({**SPRING, "tension": "x"}, "tension", "wanted one of them"),
        (
            {**{k: x for k, x in SPRING.items() if k != "stiffness"}, "tension": "40*y"},
            "tension",
            "column 4: unknown name 'y'",
        ),
        ({**SPRING, "free_length": -1}, "free_length", "wanted none that is negative"),
        ({**SPRING, "stiffness": "2*q"}, "stiffness", "column 3: unknown name 'q'"),
        ({**SPRING, "damping": "c*t"}, "damping", "column 3: unknown name 't'"),
        ({**SPRING, "free_length": "2*"}, "free_length", "the formula ends"),
        (
            {"type": "force", "body": "bar", "force": [1, "sin(t", 0]},
            "force[1]",
            "column 6: the formula ends before the '('",
        ),
        ({"type": "torque", "body": "bar", "torque_b": ["1", "x", 0]}, "torque_b[1]", "name 'x'"),
        ({"type": "force", "body": "bar", "force": [1, True, 0]}, "force[1]", "or a formula is"),
    ],
)
def test_a_force_that_cannot_act_is_refused(force: Tree, key: str, says: str) -> None:
    with pytest.raises(SceneError) as caught:
        scene_from_dict(scene(**force))
    assert caught.value.key == f"forces.f.{key}"
    assert says in caught.value.problem


def test_a_linkage_of_nodes_and_links_has_no_forces(lever: Tree) -> None:
    with pytest.raises(SceneError, match="forces: belong to bodies"):
        scene_from_dict(lever | {"forces": {"f": SPRING}})


def test_a_spring_is_given_in_metres_and_principal_frames() -> None:
    (spring,) = system_of(scene_from_dict(scene(**SPRING))).forces
    given = dict(spring.constants)
    assert (spring.kind, spring.i, spring.j) == ("spring_damper", GROUND_INDEX, 0)
    assert given["s_j_b"] == pytest.approx((0.02, 0, 0), abs=1e-15)
    assert given["stiffness"] == (40.0,)
    assert given["damping"] == (0.0,)
    assert given["free_length"] == pytest.approx((0.13,), abs=1e-15)
    assert not spring.works


def test_loads_are_given_in_newtons() -> None:
    push = {"type": "force", "body": "bar", "point": [0, 5, 0], "force": [2000, 0, 0]}
    (force,) = system_of(scene_from_dict(scene(**push))).forces
    given = dict(force.constants)
    assert given["s_j_b"] == pytest.approx((-0.01, 0.005, 0), abs=1e-15)
    assert given["force"] == pytest.approx((2, 0, 0), abs=1e-15)
    (torque,) = system_of(
        scene_from_dict(scene(type="torque", body="bar", torque_b=[0, 0, 3e6]))
    ).forces
    assert (torque.kind, torque.constants) == ("torque_b", (("torque", (0.0, 0.0, 3.0)),))


def test_every_formula_that_is_wrong_is_reported_at_once() -> None:
    with pytest.raises(SceneError) as caught:
        scene_from_dict(scene(type="force", body="bar", force=["2*", 1, "y"]))
    assert [one.key for one in caught.value.problems] == ["forces.f.force[0]", "forces.f.force[2]"]


def test_the_line_of_a_formula_is_named() -> None:
    text = to_toml(scene_from_dict(scene(type="force", body="bar", force=["c", 1, "t"])))
    wrong = text.replace('"t"', '"t*"')
    with pytest.raises(SceneError) as caught:
        scene_from_toml(wrong)
    (problem,) = caught.value.problems
    assert wrong.splitlines()[problem.line - 1].startswith("f = ")


def test_components_that_are_formulas_stand_beside_their_directions() -> None:
    push = {"type": "force", "body": "bar", "force_b": [2000, "c*t", 0]}
    (force,) = system_of(scene_from_dict(scene(**push))).forces
    given = dict(force.constants)
    assert given["force"] == pytest.approx((2, 0, 0), abs=1e-15)
    assert given["force_y"] == pytest.approx((0, 1e-3, 0), abs=1e-15)
    assert force.formulas == (("force_y", "c*t"),)
    assert force.works


def test_a_spring_of_parameters_keeps_its_potential() -> None:
    given = {**SPRING, "stiffness": "2*c", "free_length": "c"}
    (spring,) = system_of(scene_from_dict(scene(**given))).forces
    constants = dict(spring.constants)
    assert constants["stiffness"] == (1.0,)
    assert constants["free_length"] == pytest.approx((1e-3,), abs=1e-18)
    assert spring.formulas == (("stiffness", "2*c"), ("free_length", "c"))
    assert not spring.works


def test_the_builder_writes_forces_that_read_back_the_same() -> None:
    built = (
        SceneBuilder("pushed", unit="m")
        .body("bar", position=(0, 0, 0), mass=1, inertia={"xx": 1, "yy": 1, "zz": 1})
        .force("push", type="force", body="bar", force=(1, 0, 0))
        .force("hold", **{**SPRING, "damping": 0.5})
        .build()
    )
    assert scene_from_toml(to_toml(built)).forces == built.forces
