"""What a scene of bodies gives without effect is refused, all of it at once."""

from __future__ import annotations

import copy
from typing import Any

import pytest

from kousoku.model.errors import SceneError
from kousoku.model.lowering.system import system_of
from kousoku.model.reading.builder import SceneBuilder
from kousoku.model.reading.read import scene_from_dict, scene_from_toml
from kousoku.model.validation.validate import check

Tree = dict[str, Any]

ZERO = [0, 0, 0]
BAR: Tree = {
    "name": "bar",
    "unit": "m",
    "bodies": {"bar": {"position": ZERO, "mass": 1}},
    "joints": {"a": {"type": "hinge", "bodies": ["ground", "bar"], "at": ZERO, "axis": [0, 0, 1]}},
    "coordinates": {"turn": {"joint": "a"}},
}
SPRING: Tree = {
    "type": "spring_damper",
    "bodies": ["ground", "bar"],
    "points": [ZERO, [0, 1, 0]],
    "damping": 3,
}
TURN: Tree = {"type": "rotational_spring_damper", "coordinate": "turn", "damping": 3}
LAW: Tree = {"damping": None, "tension": "5*v"}


def changed(**tables: Any) -> Tree:
    """Scene with other tables; of a table that is None nothing is left."""
    tree = copy.deepcopy(BAR) | tables
    return {name: table for name, table in tree.items() if table is not None}


def force(given: Tree, **keys: Any) -> Tree:
    """Scene with a force."""
    own = {name: value for name, value in (given | keys).items() if value is not None}
    return changed(forces={"f": own})


def problems_of(tree: Tree) -> list[tuple[str, str]]:
    """Keys and reasons of the problems of a scene."""
    with pytest.raises(SceneError) as caught:
        scene_from_dict(tree)
    return [(one.key, one.problem) for one in caught.value.problems]


@pytest.mark.parametrize(
    ("tree", "key", "says"),
    [
        (changed(divisions=90), "divisions", "there are none"),
        (changed(divisions=60), "divisions", "there are none"),
        (changed(outputs=["coordinates"], coordinates=None), "outputs[0]", "no coordinates"),
        (
            changed(outputs=["energies", "reactions"], joints=None, coordinates=None),
            "outputs[1]",
            "no joints and no drivers",
        ),
        (changed(method={}), "method", "belongs to a planar linkage"),
        (
            changed(bodies={"bar": {"position": ZERO, "mass": 1, "hold": ["x", "y", "x"]}}),
            "bodies.bar.hold[2]",
            "'x' stands there twice",
        ),
        (force(SPRING) | {"bodies": {"bar": {"position": ZERO}}}, "forces", "no body has a mass"),
        (force(SPRING, free_length=2), "forces.f.free_length", "it has no stiffness"),
        (force(SPRING, **LAW, free_length=2), "forces.f.free_length", "tension does not depend"),
        (force(TURN, free_angle=2), "forces.f.free_angle", "it has no stiffness"),
        (force(TURN, of="angle"), "forces.f.of", "the coordinate says which angle"),
    ],
)
def test_what_has_no_effect_is_refused(tree: Tree, key: str, says: str) -> None:
    ((found, problem),) = problems_of(tree)
    assert found == key
    assert says in problem


@pytest.mark.parametrize(
    "tree",
    [
        changed(divisions=90, inputs={"alpha": {"joint": "a"}}),
        changed(outputs=["coordinates", "reactions"]),
        changed(parameters={"k": 3}, gravity=[0, 0, "-k"]),
        changed(parameters={"k": 3}, drivers={"d": {"joint": "a", "value": "k*t"}}),
        changed(
            bodies={"bar": {"position": ZERO, "rods": [{"mass": 1, "ends": [ZERO, [1, 0, 0]]}]}}
        )
        | {"gravity": [0, 0, -9.81]},
        force(SPRING, stiffness=3, free_length=2),
        force(SPRING, damping=None, tension="5*v + x", free_length=2),
        changed(bodies={"bar": {"position": ZERO}}, gravity=[0, 0, -9.81]),
        changed(parameters={"k": 3}),
        changed(nodes={}, links={}, inputs={}),
    ],
)
def test_what_has_an_effect_or_is_empty_is_not(tree: Tree) -> None:
    scene_from_dict(tree)


def test_reactions_of_drivers_need_no_joint() -> None:
    driver = {"body": "bar", "path": ["t", "0", "0"]}
    tree = changed(outputs=["reactions"], joints=None, coordinates=None, drivers={"d": driver})
    scene_from_dict(tree)


def test_what_may_need_a_part_that_is_wrong_is_not_refused() -> None:
    hinge = BAR["joints"]["a"]
    tree = changed(
        outputs=["coordinates", "reactions"],
        joints={"a": hinge | {"type": "hing"}},
        divisions=5,
        inputs={"alpha": {"joint": "a", "spede": 3}},
    )
    assert [key for key, _ in problems_of(tree)] == ["inputs.alpha.spede", "joints.a.type"]


def test_all_that_has_no_effect_is_reported_at_once_with_its_line() -> None:
    text = """\
name = "bar"
unit = "m"
divisions = 60
outputs = ["coordinates"]
[bodies.bar]
position = [0, 0, 0]
mass = 1
hold = ["x", "x"]
"""
    with pytest.raises(SceneError) as caught:
        scene_from_toml(text)
    found = [(one.line, one.key) for one in caught.value.problems]
    assert found == [(3, "divisions"), (4, "outputs[0]"), (8, "bodies.bar.hold[1]")]


def test_the_builder_writes_divisions_where_they_are_given() -> None:
    def bar(**keys: Any) -> SceneBuilder:
        return SceneBuilder("bar", unit="m", **keys).body("bar", position=ZERO, mass=1)

    scene = bar().build()
    assert scene.divisions == 60
    check(scene)
    with pytest.raises(SceneError, match="divisions: divides the way of inputs"):
        bar(divisions=60).build()


def test_an_output_that_there_is_not_is_refused_with_the_nearest() -> None:
    says = r"outputs\[1\]: unknown output 'reaction'; did you mean 'reactions'\?"
    with pytest.raises(SceneError, match=says):
        system_of(scene_from_dict(BAR), ["energies", "reaction"])


def test_parameters_that_stand_in_no_formula_are_no_arguments_of_the_solver() -> None:
    drivers = {"d": {"joint": "a", "value": "k*t + turn_dot2"}}
    tree = changed(parameters={"m": 1, "k": 2, "turn": 4, "turn_dot2": 3}, drivers=drivers)
    del tree["coordinates"]
    system = system_of(scene_from_dict(tree))
    assert system.parameters == (("k", 2.0), ("turn_dot2", 3.0))
    system = system_of(scene_from_dict(tree | {"gravity": ["-m", 0, 0], "drivers": {}}))
    assert system.parameters == (("m", 1.0),)
