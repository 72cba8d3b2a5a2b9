"""What is refused of forces, and what becomes of them in a system."""

from __future__ import annotations

from typing import Any

import pytest

from kousoku.model.errors import SceneError
from kousoku.model.lowering.system import system_of
from kousoku.model.mechanics.multibody import GROUND_INDEX
from kousoku.model.reading.builder import SceneBuilder
from kousoku.model.reading.read import scene_from_dict, scene_from_toml
from kousoku.model.reading.write import to_toml

Tree = dict[str, Any]

SPRING: Tree = {
    "type": "spring_damper",
    "bodies": ["ground", "bar"],
    "points": [[0, 0, 0], [30, 0, 0]],
    "stiffness": 40,
}


PLACE: Tree = {"at": [0, 100, 0], "axis": [0, 0, 1]}
TURN: Tree = {"type": "rotational_spring_damper", "joint": "hinge", "stiffness": 40}
BUSHING: Tree = {
    "type": "bushing",
    "bodies": ["ground", "bar"],
    "at": [0, 100, 0],
    "stiffness": [1, 2, 3, 4, "c", 0],
}


def scene(**force: Any) -> Tree:
    """Bar and a point in mm under one force."""
    turned = {"axis": [0, 0, 1], "angle": 1.5707963267948966}
    bar = {"position": [0, 100, 0], "orientation": turned, "mass": 2, "center": [10, 0, 0]}
    inertia = {"xx": 300, "yy": 500, "zz": 600}
    dot = {"position": [50, 0, 0], "point": True, "mass": 1}
    return {
        "name": "loaded",
        "unit": "mm",
        "parameters": {"c": 3},
        "gravity": [0, 0, "-c"],
        "joints": {
            "hinge": {"type": "hinge", "bodies": ["ground", "bar"], **PLACE},
            "tube": {"type": "cylindrical", "bodies": ["ground", "bar"], **PLACE},
            "cross": {
                **{"type": "universal", "bodies": ["ground", "bar"], "at": [0, 0, 0]},
                **{"axis": [1, 0, 0], "second_axis": [0, 1, 0]},
            },
            "ball": {"type": "ball", "bodies": ["bar", "dot"], "at": [50, 0, 0]},
        },
        "coordinates": {
            "angle": {"joint": "hinge", "near": 6.3},
            "gap": {"bodies": ["ground", "dot"], "points": [[0, 0, 0], [0, 0, 0]]},
        },
        "bodies": {"bar": bar | {"inertia": inertia}, "dot": dot},
        "forces": {"f": {name: value for name, value in force.items() if value is not None}},
    }


@pytest.mark.parametrize(
    ("force", "key", "says"),
    [
        ({"type": "spring"}, "type", "unknown force 'spring'"),
        ({**TURN, "joint": None}, "joint", "the angle that it acts"),
        ({**TURN, "coordinate": "angle"}, "joint", "wanted one of them"),
        ({**TURN, "joint": "cross"}, "of", "is missing"),
        ({**TURN, "of": "displacement"}, "of", "is no angle"),
        ({**TURN, "of": "second_angle"}, "of", "no second_angle"),
        ({**TURN, "joint": "ball"}, "joint", "leaves free no angle"),
        ({**TURN, "joint": "hing"}, "joint", "did you mean 'hinge'"),
        ({**TURN, "joint": None, "coordinate": "gap"}, "coordinate", "gap is no angle"),
        ({**TURN, "joint": None, "coordinate": "angel"}, "coordinate", "did you mean 'angle'"),
        ({**TURN, "stiffness": None}, "stiffness", "or a moment"),
        ({**TURN, "moment": "x"}, "moment", "wanted one of them"),
        ({**TURN, "stiffness": None, "moment": "x*u"}, "moment", "unknown name 'u'"),
        ({**TURN, "free_angle": "t"}, "free_angle", "unknown name 't'"),
        ({**TURN, "stiffness": [1] * 6}, "stiffness", "wanted one number"),
        ({"type": "along", "force": 1}, "coordinate", "is missing"),
        ({"type": "along", "coordinate": "gap"}, "force", "one number or formula"),
        ({"type": "along", "coordinate": "gap", "force": [1, 0, 0]}, "force", "has components"),
        ({"type": "along", "coordinate": "gap", "force": "gap_rate"}, "force", "'gap_dot'"),
        ({"type": "friction", "damping": 1}, "joint", "is missing"),
        ({"type": "friction", "joint": "hinge"}, "damping", "is missing"),
        ({"type": "friction", "joint": "ball", "damping": 1}, "joint", "leaves free no angle"),
        (
            {"type": "friction", "joint": "hinge", "damping": 1, "of": "displacement"},
            "of",
            "no displacement",
        ),
        ({**BUSHING, "at": None}, "points", "or once in frame O"),
        ({**BUSHING, "points": [[0, 0, 0], [0, 0, 0]]}, "points", "is given too"),
        ({**BUSHING, "stiffness": 1}, "stiffness", "wanted six"),
        ({**BUSHING, "stiffness": [1, 2]}, "stiffness", "a list of 6 numbers or formulas"),
        ({**BUSHING, "stiffness": None}, "stiffness", "six dampings or both"),
        ({**BUSHING, "bodies": ["ground", "dot"]}, "bodies[1]", "does not turn"),
        ({**BUSHING, "axes": [[0, 1, 0], [0, 2, 0]]}, "axes", "are parallel"),
        ({"type": "force", "body": "bar", "force": 3}, "force", "wanted three components"),
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
    assert not spring.is_nonconservative


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


@pytest.mark.parametrize("formula", ["log(0)", "1/t", "sqrt(-c)", "asin(2 + t)", "exp(exp(9))"])
def test_a_force_without_a_value_at_the_start_is_refused(formula: str) -> None:
    with pytest.raises(SceneError) as caught:
        scene_from_dict(scene(type="force", body="bar", force=[0, formula, 0]))
    assert caught.value.key == "forces.f.force[1]"
    assert "has no finite value at t = 0" in caught.value.problem


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
    assert force.is_nonconservative


def test_a_spring_of_parameters_keeps_its_potential() -> None:
    given = {**SPRING, "stiffness": "2*c", "free_length": "c"}
    (spring,) = system_of(scene_from_dict(scene(**given))).forces
    constants = dict(spring.constants)
    assert constants["stiffness"] == (1.0,)
    assert constants["free_length"] == pytest.approx((1e-3,), abs=1e-18)
    assert spring.formulas == (("stiffness", "2*c"), ("free_length", "c"))
    assert not spring.is_nonconservative


def test_a_rotational_spring_is_free_at_the_angle_as_it_is_written_with_its_turns() -> None:
    system = system_of(scene_from_dict(scene(**{**TURN, "damping": "2*c"})))
    (spring,) = system.forces
    (angle,) = system.coordinates
    assert (spring.kind, angle.name, spring.coordinate) == ("coordinate_spring", "angle", 0)
    given = dict(spring.constants)
    assert given["stiffness"] == pytest.approx((40e-6,), rel=1e-15)
    assert given["damping"] == pytest.approx((1e-6,), rel=1e-15)
    assert given["free"] == pytest.approx((6.283185307179586,), rel=1e-15)
    assert spring.formulas == (("damping", "2*c"),)
    assert spring.has_potential
    assert spring.is_nonconservative


def test_a_rotational_spring_takes_the_angle_that_is_meant() -> None:
    for of in ("angle", "second_angle"):
        system = system_of(scene_from_dict(scene(**{**TURN, "joint": "cross", "of": of})))
        assert [one.name for one in system.coordinates] == [f"cross.{of}"]
    (angle,) = system_of(scene_from_dict(scene(**{**TURN, "joint": "tube"}))).coordinates
    assert angle.kind == "angle"


def test_friction_is_in_each_freedom_of_its_joint_in_its_unit() -> None:
    system = system_of(scene_from_dict(scene(type="friction", joint="tube", damping=5)))
    kinds = [system.coordinates[one.coordinate].kind for one in system.forces]
    assert kinds == ["angle", "n2"]
    dampings = [dict(one.constants)["damping"][0] for one in system.forces]
    assert dampings == pytest.approx([5e-6, 5.0], rel=1e-15)


def test_a_bushing_is_a_spring_along_and_about_each_direction_that_it_holds() -> None:
    system = system_of(scene_from_dict(scene(**BUSHING)))
    assert [one.name for one in system.forces] == ["f"] * 5
    places = [system.coordinates[one.coordinate] for one in system.forces]
    names = ["f.x", "f.y", "f.z", "f.about_x", "f.about_y"]
    assert [one.name for one in places] == names
    assert [one.kind for one in places] == ["n2", "n2", "n2", "n1", "n1"]
    given = [dict(one.constants)["stiffness"][0] for one in system.forces]
    assert given == pytest.approx([1, 2, 3, 4e-6, 1e-6], rel=1e-15)


def test_formulas_bring_the_coordinates_that_they_name() -> None:
    push = {"type": "force", "body": "dot", "force": ["c*gap_dot", 0, "0*angle"]}
    system = system_of(scene_from_dict(scene(**push)))
    assert [one.name for one in system.coordinates] == ["gap", "angle"]
    assert system_of(scene_from_dict(scene(**SPRING))).coordinates == ()


def test_gravity_may_be_a_formula_of_parameters() -> None:
    tree = scene(**SPRING)
    system = system_of(scene_from_dict(tree | {"gravity": [1000, "c*2", 0]}))
    assert system.gravity == (1.0, 0.0, 0.0)
    assert system.gravity_law == ("", "c*2", "")
    assert [system.has_gravity(k) for k in range(3)] == [True, True, False]
    with pytest.raises(SceneError) as caught:
        scene_from_dict(tree | {"gravity": ["t", 0, "c +"]})
    assert [one.key for one in caught.value.problems] == ["gravity[0]", "gravity[2]"]


def test_the_builder_writes_forces_that_read_back_the_same() -> None:
    built = (
        SceneBuilder("pushed", unit="m")
        .body("bar", position=(0, 0, 0), mass=1, inertia={"xx": 1, "yy": 1, "zz": 1})
        .force("push", type="force", body="bar", force=(1, 0, 0))
        .force("hold", **{**SPRING, "damping": 0.5})
        .build()
    )
    assert scene_from_toml(to_toml(built)).forces == built.forces
