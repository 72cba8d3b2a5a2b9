"""Screws, gears, racks, constant velocity joints: which coordinates, with which factors."""

from __future__ import annotations

from math import cos, pi, sin
from typing import TYPE_CHECKING, Any

import pytest

from kousoku.codegen.kernel_json import load_frozen
from kousoku.model.errors import SceneError
from kousoku.model.lowering.system import system_of
from kousoku.model.mechanics.constraints import COMBINATION
from kousoku.model.operations.arithmetic import FLOAT
from kousoku.model.operations.interpret import evaluate
from kousoku.model.reading.read import scene_from_dict
from tests.random_geometry import orientation_of

if TYPE_CHECKING:
    from kousoku.model.mechanics.multibody import Instance, System

Tree = dict[str, Any]
ZERO, X, Z = [0, 0, 0], [1, 0, 0], [0, 0, 1]


def two_bodies(**joints: Tree) -> Tree:
    """Two bodies that are turned and displaced, in centimetres."""
    bodies = {
        "a": {"position": [0, 0, 2], "orientation": {"axis": Z, "angle": 0.5}, "mass": 1},
        "b": {"position": [3, 0, 0], "orientation": {"axis": X, "angle": 1.25}, "mass": 1},
    }
    return {"name": "two", "unit": "cm", "bodies": bodies, "joints": joints}


def on_ground(kind: str, body: str, **keys: Any) -> Tree:
    """Joint with the ground whose coordinates count from the frame of the body."""
    axis, zero = (X, Z) if body == "b" else (Z, X)
    given = {"points": [ZERO, ZERO], "axes": [axis, axis], "zero": [zero, zero]}
    return {"type": kind, "bodies": ["ground", body], **given, **keys}


def coupling(tree: Tree) -> tuple[System, Instance]:
    """System of a tree and its last combination."""
    system = system_of(scene_from_dict(tree))
    return system, next(c for c in reversed(system.constraints) if c.kind == COMBINATION)


def terms(system: System, row: Instance) -> dict[str, float]:
    """Factor of each coordinate by its name."""
    return {system.coordinates[term.coordinate].name: term.factor for term in row.terms}


@pytest.mark.parametrize("pitch", [0.8, -0.8])
def test_a_screw_advances_by_its_pitch_in_one_turn(pitch: float) -> None:
    system, row = coupling(two_bodies(thread=on_ground("helical", "a", pitch=pitch)))
    factors = terms(system, row)
    assert factors["thread.displacement"] == 1
    assert factors["thread.angle"] * 2 * pi == pytest.approx(-0.01 * pitch, rel=1e-15)
    assert row.offset == pytest.approx(-(0.02 - 0.01 * pitch * 0.5 / (2 * pi)), rel=1e-14)
    assert (row.unit, row.bodies, len(system.constraints)) == ("m", (-1, 0), 3)


def test_a_gear_keeps_the_second_angle_at_a_ratio_of_the_first() -> None:
    joints = {"one": on_ground("revolute", "a"), "two": on_ground("revolute", "b")}
    joints["one"]["points"] = [[0, 0, 2], ZERO]
    gear = {"type": "gear", "joints": ["one", "two"], "ratio": -3}
    system, row = coupling(two_bodies(mesh=gear, **joints))
    assert terms(system, row) == {"two.angle": 1, "one.angle": 3}
    assert row.offset == pytest.approx(-(1.25 + 3 * 0.5), rel=1e-15)
    assert (row.joint, row.unit, row.bodies, row.law) == ("mesh", "rad", (-1, 1, 0), "")


def test_a_gear_uses_the_coordinate_that_the_scene_names() -> None:
    joints = {"one": on_ground("revolute", "a"), "two": on_ground("revolute", "b")}
    gear = {"type": "gear", "joints": ["one", "two"], "ratio": 2}
    tree = two_bodies(mesh=gear, **joints)
    tree["coordinates"] = {"turn": {"joint": "two", "near": 7}}
    system, row = coupling(tree)
    assert terms(system, row) == {"turn": 1, "one.angle": -2}
    assert row.offset == pytest.approx(-(1.25 + 2 * pi - 2 * 0.5), rel=1e-15)


def test_a_gear_of_four_bodies_connects_them_all() -> None:
    pair = {"type": "revolute", "at": ZERO, "axis": Z}
    tree = two_bodies(
        one={**pair, "bodies": ["a", "b"]},
        two={**pair, "bodies": ["c", "d"]},
        mesh={"type": "gear", "joints": ["one", "two"], "ratio": 1},
    )
    for name in "cd":
        tree["bodies"][name] = {"position": ZERO, "mass": 1}
    _, row = coupling(tree)
    assert (row.i, row.j, row.others) == (2, 3, (0, 1))


def test_gears_on_a_carrier_connect_three_bodies() -> None:
    pair = {"type": "revolute", "at": ZERO, "axis": Z}
    tree = two_bodies(
        sun={**pair, "bodies": ["a", "b"]},
        planet={**pair, "bodies": ["a", "c"]},
        mesh={"type": "gear", "joints": ["sun", "planet"], "ratio": -2},
    )
    tree["bodies"]["c"] = {"position": ZERO, "mass": 1}
    _, row = coupling(tree)
    assert row.bodies == (0, 2, 1)


def test_a_rack_goes_by_the_radius_times_the_angle_of_the_pinion() -> None:
    joints = {"pinion": on_ground("revolute", "b"), "rack": on_ground("prismatic", "a")}
    tree = two_bodies(mesh={"type": "rack", "joints": ["pinion", "rack"], "radius": 6}, **joints)
    system, row = coupling(tree)
    assert terms(system, row) == {"rack.displacement": 1, "pinion.angle": -0.06}
    assert row.offset == pytest.approx(-(0.02 - 0.06 * 1.25), rel=1e-14)
    assert (row.unit, row.bodies) == ("m", (-1, 0, 1))


def test_a_linear_coupling_adds_lengths_in_the_unit_of_the_scene_and_angles_in_rad() -> None:
    """2 · 2 cm + 3 · 1.25 rad = 7.75 cm stays what it is; each part in metres."""
    joints = {"pinion": on_ground("revolute", "b"), "rack": on_ground("prismatic", "a")}
    sums = {"type": "coupler", "coordinates": ["turn", "way"], "factors": [3, 2]}
    tree = two_bodies(sums=sums, **joints)
    tree["coordinates"] = {"turn": {"joint": "pinion"}, "way": {"joint": "rack"}}
    system, row = coupling(tree)
    assert terms(system, row) == {"turn": 0.03, "way": 2}
    assert row.offset == pytest.approx(-0.0775, rel=1e-14)
    assert row.unit == "m"
    sums.update(coordinates=["turn"], factors=[3])
    system, row = coupling(tree)
    assert (terms(system, row), row.unit) == ({"turn": 3}, "rad")


@pytest.mark.parametrize("size", [1e-12, 1e-6, 1e7])
def test_a_linear_coupling_has_rows_of_the_size_of_others_whatever_its_factors(size: float) -> None:
    joints = {"pinion": on_ground("revolute", "b"), "rack": on_ground("prismatic", "a")}
    sums = {"type": "coupler", "coordinates": ["way", "turn"], "factors": [2 * size, 3 * size]}
    tree = two_bodies(sums=sums, **joints)
    tree["coordinates"] = {"turn": {"joint": "pinion"}, "way": {"joint": "rack"}}
    system, row = coupling(tree)
    found = terms(system, row)
    assert 1 <= found["way"] < 2
    assert found["turn"] / found["way"] == pytest.approx(0.015, rel=1e-15)
    assert found["way"] == pytest.approx(row.scale * 2 * size, rel=1e-15)


@pytest.mark.parametrize("size", [1e-9, 1.0, 1e9])
def test_a_linear_coupling_is_the_same_row_in_any_unit_of_length(size: float) -> None:
    """A factor of an angle is a length, and is large or small beside those of the scene."""
    arm = [[0, 0, 0], [0, 3 * size, 0]]
    pinion = {"type": "revolute", "bodies": ["ground", "b"], "points": arm, "axis": Z}
    sums = {"type": "coupler", "coordinates": ["turn", "way"], "factors": [2 * size, 0.25]}
    tree = two_bodies(sums=sums, pinion=pinion, rack=on_ground("prismatic", "a"))
    tree["coordinates"] = {"turn": {"joint": "pinion"}, "way": {"joint": "rack"}}
    system, row = coupling(tree)
    assert row.scale == 1.0
    assert terms(system, row) == pytest.approx({"turn": 0.02 * size, "way": 0.25})


@pytest.mark.parametrize("bend", [0.0, 0.4, 2.0, 3.0])
def test_a_constant_velocity_joint_holds_at_any_bend_and_turns_about_the_line_between(
    bend: float,
) -> None:
    """The row is zero as it is written, and its torque on j lies along the sum of both shafts.

    That sum is zero where the shafts are folded back on each other: 2 cos (bend / 2).
    """
    shaft = [cos(bend), 0.6 * sin(bend), 0.8 * sin(bend)]
    joint = {"type": "cv", "bodies": ["a", "b"], "at": ZERO, "axis": X, "second_axis": shaft}
    system, row = coupling(two_bodies(cv=joint))
    assert (row.offset, row.unit) == (0, "rad")
    assert terms(system, row) == {"cv.xy": 1, "cv.yx": -1}
    kernel = next(k for k in load_frozen("n1").kernels if k.name == "constraint")
    state = {"p_i": system.bodies[0].p, "p_j": system.bodies[1].p}
    found = [evaluate(kernel, {**state, **dict(c.constants)}, FLOAT) for c in system.coordinates]
    assert found[0]["C"][0] - found[1]["C"][0] == pytest.approx(0, abs=2e-15)
    torque_b = [x - y for x, y in zip(*(one["C_q"][9:] for one in found), strict=True)]
    torque = orientation_of(system.bodies[1].p) @ torque_b
    both = [1 + shaft[0], shaft[1], shaft[2]]
    assert torque == pytest.approx([-x for x in both], abs=4e-15)


def test_shafts_that_are_folded_back_are_refused() -> None:
    joint = {"type": "cv", "bodies": ["a", "b"], "at": ZERO, "axis": X, "second_axis": [-1, 0, 0]}
    with pytest.raises(SceneError, match="point against each other") as caught:
        system_of(scene_from_dict(two_bodies(cv=joint)))
    assert caught.value.key == "joints.cv.axes"


def test_zero_says_which_turn_a_fixed_joint_keeps() -> None:
    """Across the axis x: −y of the ground stays parallel to z of the body."""
    joint = {"type": "fixed", "bodies": ["ground", "b"], "points": [[3, 0, 0], ZERO]}
    joint |= {"axes": [X, X], "zero": [[0, -1, 0], [5, 0, 1]]}
    system = system_of(scene_from_dict(two_bodies(weld=joint)))
    row = dict(system.constraints[-1].constants)
    assert row["a_i_b"] == (0, -1, 0)
    assert row["a_j_b"] == (0, -1, 0)


@pytest.mark.parametrize("kind", ["fixed", "slider", "cv"])
def test_directions_that_would_stay_antiparallel_are_refused(kind: str) -> None:
    """The body is turned about x by 1.25: its z axis is 1.25 + pi / 2 from y, and not from −y."""
    joint = {"type": kind, "bodies": ["ground", "b"], "points": [[3, 0, 0], ZERO], "axes": [X, X]}
    near, far = [[0, 1, 0], Z], [[0, -1, 0], Z]
    tree = two_bodies(joint={**joint, "zero": far})
    assert system_of(scene_from_dict(tree)).constraints
    with pytest.raises(SceneError, match="more than a quarter turn apart") as caught:
        system_of(scene_from_dict(two_bodies(joint={**joint, "zero": near})))
    assert caught.value.key == "joints.joint.zero"


@pytest.mark.parametrize(
    ("change", "key", "says"),
    [
        ({"zero": None, "axes": [X, X]}, ".axes", "a fixed joint has no axis"),
        ({"axes": None, "zero": [Z, Z]}, ".axes", "is missing; a fixed joint wants"),
        ({"type": "ball", "axes": None, "zero": [Z, Z]}, ".zero", "has no angle"),
        (
            {"type": "perpendicular", "points": None, "axes": [X, Z], "zero": [Z, X]},
            ".zero",
            "has no angle",
        ),
        ({"axes": None, "axis": X, "zero": [Z, [0, 0, 0]]}, ".zero[1]", "has zero length"),
        ({"type": "screw", "axes": [X, X]}, ".pitch", "is missing"),
        ({"axes": None, "ratio": 3}, ".ratio", "has none; leave it out"),
    ],
)
def test_keys_that_do_not_belong_to_a_joint_are_refused(change: Tree, key: str, says: str) -> None:
    joint = {"type": "fixed", "bodies": ["ground", "b"], "points": [ZERO, ZERO], **change}
    given = {name: value for name, value in joint.items() if value is not None}
    with pytest.raises(SceneError, match=says) as caught:
        scene_from_dict(two_bodies(joint=given))
    assert caught.value.key == f"joints.joint{key}"


@pytest.mark.parametrize(
    ("given", "key", "says"),
    [
        ({"type": "gear", "joints": ["one", "two"], "ratio": 2, "at": ZERO}, ".at", "couples what"),
        ({"type": "gear", "ratio": 2}, ".joints", "is missing; a gear wants the names"),
        ({"type": "gear", "joints": ["one", "too"], "ratio": 2}, ".joints[1]", "mean 'two'"),
        ({"type": "rack", "joints": ["one", "two"], "radius": 0}, ".joints[1]", "no displacement"),
        ({"type": "linear", "coordinates": [], "factors": []}, ".coordinates", "is empty"),
        ({"type": "linear", "coordinates": ["u"], "factors": [1]}, ".coordinates[0]", "unknown"),
        ({"type": "linear", "coordinates": ["t1"], "factors": [0]}, ".factors[0]", "is zero"),
        ({"type": "linear", "coordinates": ["t1"] * 2, "factors": [1, 2]}, "[1]", "twice"),
        ({"type": "linear", "coordinates": ["t1"], "factors": [1], "ratio": 2}, ".ratio", "none"),
    ],
)
def test_a_coupling_that_cannot_be_is_refused(given: Tree, key: str, says: str) -> None:
    joints = {"one": on_ground("revolute", "a"), "two": on_ground("revolute", "b")}
    tree = two_bodies(mesh=given, **joints)
    tree["coordinates"] = {"t1": {"joint": "one"}}
    with pytest.raises(SceneError, match=says) as caught:
        scene_from_dict(tree)
    assert caught.value.key.startswith("joints.mesh")
    assert caught.value.key.endswith(key)


def test_a_coupling_of_too_many_bodies_is_refused() -> None:
    joints = {f"j{k}": {"type": "revolute", "at": ZERO, "axis": Z} for k in range(3)}
    tree = two_bodies(**joints)
    for k, joint in enumerate(joints.values()):
        for name in (f"m{k}", f"n{k}"):
            tree["bodies"][name] = {"position": ZERO, "mass": 1}
        joint["bodies"] = [f"m{k}", f"n{k}"]
    tree["coordinates"] = {f"c{k}": {"joint": f"j{k}"} for k in range(3)}
    tree["joints"]["sum"] = {
        "type": "linear",
        "coordinates": ["c0", "c1", "c2"],
        "factors": [1] * 3,
    }
    with pytest.raises(SceneError, match="connects 6 moving bodies; at most 4"):
        scene_from_dict(tree)
