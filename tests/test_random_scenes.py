"""The random scenes have everything that a scene file may hold, and kousoku takes or refuses it."""

from __future__ import annotations

import re
from functools import cache
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kousoku.model.elements.forces import FORCES
from kousoku.model.elements.joint import ANGLE
from kousoku.model.elements.joints import NAMES
from kousoku.model.errors import SceneError
from kousoku.model.lowering.system import system_of
from kousoku.model.reading.read import scene_from_dict
from kousoku.model.records.orientation import FORMS
from kousoku.model.records.scene import Scene
from kousoku.model.records.spatial import SOLIDS
from tests.random_draft import LAWS, LOADS, UNITS
from tests.random_scenes import COUNT, WANTED, numbered_scenes, random_scene
from tests.rare_scenes import RARE

if TYPE_CHECKING:
    import random
    from collections.abc import Iterator


@cache
def trees() -> list[dict[str, Any]]:
    return numbered_scenes()


def elements(table: str) -> Iterator[dict[str, Any]]:
    return (element for tree in trees() for element in tree.get(table, {}).values())


def keys(table: str) -> set[str]:
    return {key for element in elements(table) for key in element}


def formulas(value: Any, path: tuple[str, ...]) -> Iterator[str]:
    """Keys under which formulas of parameters stand, without the names of elements."""
    if isinstance(value, dict):
        for key, part in value.items():
            yield from formulas(part, (*path, key))
    elif isinstance(value, list):
        for part in value:
            yield from formulas(part, path)
    elif isinstance(value, str) and re.search(r"\bp\d", value):
        yield ".".join((path[0], *path[2:]))


def test_every_joint_is_there_by_all_of_its_names() -> None:
    assert {joint["type"] for joint in elements("joints")} == set(NAMES)


def test_every_key_of_a_joint_is_there() -> None:
    wanted = "at axis points axes second_axis zero length pitch ratio radius coordinates factors"
    assert keys("joints") == {"type", "bodies", "joints", *wanted.split()}


@pytest.mark.parametrize("kind", FORCES)
def test_every_key_of_every_force_is_there(kind: str) -> None:
    forces = [force for force in elements("forces") if force["type"] == kind]
    assert {key for force in forces for key in force} == {"type", *FORCES[kind].all_keys}


@pytest.mark.parametrize(
    ("table", "templates"), [("forces", LOADS), ("drivers", LAWS)], ids=["loads", "laws"]
)
def test_every_formula_of_motion_is_there(table: str, templates: tuple[str, ...]) -> None:
    text = str([*elements(table)])
    for template in templates:
        parts = (re.escape(part) for part in re.split(r"\{[pu]\}", template))
        assert re.search(r"\w+".join(parts), text), template


def test_every_sort_of_driver_and_input_is_there() -> None:
    assert keys("drivers") == {"coordinate", "joint", "of", "value", "body", "point", "path"}
    assert keys("inputs") == {"joint", "turns", "to", "rate", "acceleration", "from"}
    assert any("p" in str(driver.get("value")) for driver in elements("drivers"))
    assert keys("coordinates") == {
        "joint",
        "of",
        "bodies",
        "points",
        "body",
        "along",
        "point",
        "near",
        "hold",
    }
    every = {ANGLE, "second_angle", "displacement", "second_displacement"}
    assert {one["of"] for one in elements("coordinates") if "of" in one} == every
    assert "displacement" in {one.get("of") for one in elements("drivers")}
    for table in ("forces", "events"):  # a distance, of more than one coordinate
        assert re.search(r"x\^2 \+ y\^2", str([*elements(table)])), table


def test_every_form_of_mass_and_start_is_there() -> None:
    wanted = {"mass", "center", "inertia", "point", "velocity", "angular_velocity", "hold"}
    assert keys("bodies") >= {*wanted, *SOLIDS, "angular_velocity_b", "orientation"}
    assert any("about" in body.get("inertia", {}) for body in elements("bodies"))
    assert any(not {"mass", *SOLIDS} & body.keys() for body in elements("bodies"))


def test_every_form_of_orientation_is_there() -> None:
    given = [body["orientation"] for body in elements("bodies") if "orientation" in body]
    assert {form for one in given for form in FORMS if form in one} == set(FORMS)
    assert {one.get("order") for one in given} == {None, "wxyz", "xyzw"}
    assert {one.get("about") for one in given} == {None, "body", "fixed"}


def test_every_unit_and_all_combinations_of_outputs_are_there() -> None:
    assert {tree["unit"] for tree in trees()} == set(UNITS)
    found = {tuple(one for one in tree["outputs"] if one != "velocities") for tree in trees()}
    assert found == set(WANTED)


def test_formulas_of_parameters_stand_where_numbers_do() -> None:
    found = {key for tree in trees() for key in formulas(tree, ())}
    wanted = """
        bodies.mass bodies.center bodies.inertia.xx bodies.boxes.mass bodies.boxes.size
        bodies.cylinders.radius bodies.spheres.radius
        joints.at joints.points joints.axis joints.length joints.pitch joints.ratio joints.radius
        joints.factors coordinates.points drivers.value drivers.path gravity
        forces.point forces.points forces.at forces.stiffness forces.damping forces.free_length
        forces.free_angle
    """
    assert set(wanted.split()) <= found


def test_the_same_number_gives_the_same_scene_and_others_give_others() -> None:
    assert trees() == numbered_scenes()
    assert all(one != other for one, other in pairwise(trees()))


@pytest.mark.parametrize("number", range(COUNT + len(RARE)))
def test_every_numbered_scene_is_accepted(number: int) -> None:
    system_of(scene_from_dict(trees()[number]))


@settings(max_examples=20, deadline=None)
@given(st.randoms(use_true_random=False))
def test_any_scene_is_read_or_refused(draw: random.Random) -> None:
    tree = random_scene(draw)
    try:
        scene = scene_from_dict(tree)
        assert isinstance(scene, Scene)
        system_of(scene)
    except SceneError as error:
        assert "axes that parameters turn" in str(error)
