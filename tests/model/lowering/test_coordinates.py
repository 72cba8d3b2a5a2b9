"""The angle, displacement, distance or place that a coordinate is, with the sign that is said."""

from __future__ import annotations

from math import cos, pi, sin, sqrt
from pathlib import Path
from typing import Any

import msgspec
import pytest

from kousoku.codegen.kernel_json import load_frozen
from kousoku.model.elements.joint import SECOND_ANGLE
from kousoku.model.errors import SceneError
from kousoku.model.lowering.held import without_held
from kousoku.model.lowering.system import system_of
from kousoku.model.mechanics.multibody import GROUND_INDEX, RelativeCoordinate, System
from kousoku.model.operations.arithmetic import FLOAT
from kousoku.model.operations.interpret import evaluate
from kousoku.model.reading.read import read_scene, scene_from_dict
from kousoku.model.records.spatial import Coordinate, Driver
from kousoku.model.validation.validate import check

Tree = dict[str, Any]
ZERO = [0, 0, 0]


def value(system: System, coordinate: RelativeCoordinate) -> float:
    """Value of a coordinate at the start, as the shipped kernel gives it."""
    kernel = next(k for k in load_frozen(coordinate.kind).kernels if k.name == "constraint")
    inputs: dict[str, tuple[float, ...]] = dict(coordinate.constants)
    for letter, index in (("i", coordinate.i), ("j", coordinate.j)):
        on_ground = index == GROUND_INDEX
        inputs[f"r_{letter}"] = (0.0, 0.0, 0.0) if on_ground else system.bodies[index].r
        inputs[f"p_{letter}"] = (1.0, 0.0, 0.0, 0.0) if on_ground else system.bodies[index].p
    return evaluate(kernel, inputs, FLOAT)["C"][0]


def arm(angle: float, **tables: Any) -> Tree:
    """Body that is turned about z, in millimetres, on a cylindrical joint."""
    joint = {"type": "cylindrical", "bodies": ["ground", "arm"], "points": [[0, 0, 5], ZERO]}
    axes = {"axes": [[0, 0, 2], [0, 0, 1]], "zero": [[3, 0, 1], [0, 1, 0]]}
    body = {
        "position": [0, 0, 12],
        "orientation": {"axis": [0, 0, 1], "angle": angle},
        "mass": 2,
        "center": [10, 0, 0],
        "inertia": {"xx": 3, "yy": 2, "zz": 4, "xy": 0.5},
    }
    tree = {"name": "arm", "unit": "mm", "outputs": ["coordinates"]}
    return {**tree, "bodies": {"arm": body}, "joints": {"axle": {**joint, **axes}}, **tables}


def test_an_angle_is_counted_from_zero_to_zero_counter_clockwise_about_the_axis() -> None:
    tree = arm(0.25, coordinates={"turn": {"joint": "axle", "of": "angle"}})
    system = system_of(scene_from_dict(tree))
    (turn,) = system.coordinates
    assert (turn.name, turn.kind, turn.counts_turns) == ("turn", "angle", True)
    assert turn.near == pytest.approx(0.25 + pi / 2, abs=1e-15)
    assert value(system, turn) == pytest.approx(0.25 + pi / 2, abs=1e-15)
    assert system.shown == (0,)


def test_without_zero_an_angle_is_zero_as_the_orientations_are_written() -> None:
    tree = arm(0.25, coordinates={"turn": {"joint": "axle", "of": "angle"}})
    del tree["joints"]["axle"]["zero"]
    system = system_of(scene_from_dict(tree))
    assert system.coordinates[0].near == 0
    assert value(system, system.coordinates[0]) == pytest.approx(0, abs=1e-16)


@pytest.mark.parametrize("off", [0.0, 1e-16, 3e-9, 1e-5])
def test_axes_that_point_against_each_other_have_the_same_zero(off: float) -> None:
    """The normal of both axes, about which one is turned into the other, is that of rounding."""
    tree = arm(0.25, coordinates={"turn": {"joint": "axle", "of": "angle"}})
    del tree["joints"]["axle"]["zero"]
    tree["joints"]["axle"]["axes"] = [[0, 0, 2], [off, -2 * off, -1]]
    system = system_of(scene_from_dict(tree))
    assert value(system, system.coordinates[0]) == pytest.approx(0, abs=2 * off)


@pytest.mark.parametrize("given", [True, False])
def test_the_angles_of_a_universal_joint_are_those_of_its_cross(given: bool) -> None:
    """The body is turned about the arm of the ground, x, and then about its own arm, y."""
    joint = {"type": "cardan", "bodies": ["ground", "arm"], "points": [ZERO, ZERO]}
    joint |= {"axes": [[1, 0, 0], [0, 1, 0]]} | ({"zero": [[0, 1, 0], [1, 0, 0]]} if given else {})
    angles = {"one": {"joint": "axle", "of": "angle"}, "two": {"joint": "axle", "of": SECOND_ANGLE}}
    tree = arm(0, coordinates=angles, joints={"axle": joint})
    turns = {"angles": [0.5, -0.75, 0], "sequence": "xyz", "about": "body"}
    tree["bodies"]["arm"] |= {"position": ZERO, "orientation": turns}
    system = system_of(scene_from_dict(tree))
    wanted = [0.5, -0.75] if given else [0, 0]
    got = [value(system, coordinate) for coordinate in system.coordinates]
    assert got == pytest.approx(wanted, abs=1e-15)
    assert [one.near for one in system.coordinates] == pytest.approx(wanted, abs=1e-15)
    assert [one.j for one in system.coordinates] == [0, GROUND_INDEX]


def test_a_displacement_is_that_of_the_point_of_j_along_the_axis_in_metres() -> None:
    tree = arm(0.25, coordinates={"rise": {"joint": "axle", "of": "displacement"}})
    system = system_of(scene_from_dict(tree))
    assert value(system, system.coordinates[0]) == pytest.approx(0.007, rel=1e-14)


def test_a_distance_and_a_place_are_those_of_the_points() -> None:
    coordinates = {
        "span": {"bodies": ["ground", "arm"], "points": [[0, 0, 12], [3, 4, 12]]},
        "place": {"body": "arm", "point": [2, 0, 0], "along": [5, 5, 0]},
    }
    system = system_of(scene_from_dict(arm(0.25, coordinates=coordinates)))
    span, place = system.coordinates
    assert (span.kind, place.kind) == ("length", "n2")
    assert value(system, span) == pytest.approx(0.013, rel=1e-14)
    assert value(system, place) == pytest.approx((0.002 * (cos(0.25) + sin(0.25))) / sqrt(2))


def test_a_coordinate_that_nothing_needs_is_left_out() -> None:
    tree = arm(0, coordinates={"turn": {"joint": "axle", "of": "angle"}}, outputs=["energies"])
    system = system_of(scene_from_dict(tree))
    assert (system.coordinates, system.shown) == ((), ())
    assert system_of(scene_from_dict(tree), ["coordinates"]).shown == (0,)


def test_near_says_which_turn_an_angle_is_in() -> None:
    """A gear with such an angle keeps the relation of the values with their turns."""
    tree = arm(0, coordinates={"turn": {"joint": "axle", "of": "angle", "near": 12}})
    tree["joints"]["rack"] = {"type": "linear", "coordinates": ["turn"], "factors": [1]}
    system = system_of(scene_from_dict(tree))
    assert system.coordinates[0].near == 12
    assert system.constraints[-1].offset == pytest.approx(-(pi / 2 + 4 * pi), rel=1e-15)


def test_a_held_coordinate_is_kept_as_it_is_written_or_near_what_is_said() -> None:
    coordinates = {
        "rise": {"joint": "axle", "of": "displacement", "hold": True},
        "turn": {"joint": "axle", "of": "angle", "hold": True, "near": 1.5},
    }
    system = system_of(scene_from_dict(arm(0, coordinates=coordinates, outputs=[])))
    rise, turn = system.held
    assert (rise.joint, rise.unit, rise.law) == ("coordinates.rise.hold", "m", "")
    assert rise.offset == pytest.approx(-0.007)
    assert (turn.offset, turn.unit) == (-1.5, "rad")
    assert [system.coordinates[one.terms[0].coordinate].name for one in system.held] == [
        "rise",
        "turn",
    ]


def test_what_is_only_held_is_gone_when_the_scene_moves() -> None:
    coordinates = {
        "rise": {"joint": "axle", "of": "displacement", "hold": True},
        "turn": {"joint": "axle", "of": "angle", "hold": True},
    }
    tree = arm(0, coordinates=coordinates, outputs=[])
    tree["drivers"] = {"motor": {"joint": "axle", "of": "angle", "value": "t"}}
    del coordinates["turn"]["hold"]
    system = system_of(scene_from_dict(tree))
    assert [one.name for one in system.coordinates] == ["turn", "rise"]
    moving = without_held(system)
    assert [one.name for one in moving.coordinates] == ["turn"]
    assert (moving.held, moving.held_rates, moving.only_held) == ((), (), 0)
    assert moving.constraints == system.constraints


@pytest.mark.parametrize(
    ("table", "name", "says"),
    [
        ("parameters", "t", "is the time in formulas"),
        ("coordinates", "t", "is the time in formulas"),
        ("parameters", "pi", "is a number in formulas"),
        ("parameters", "deg", "is the unit of 1/180 of pi in formulas"),
        ("coordinates", "deg", "is the unit of 1/180 of pi in formulas"),
        ("coordinates", "min", "is a function in formulas"),
        ("parameters", "sign", "is a function in formulas"),
        ("parameters", "x", "is what the tension of a spring may depend on"),
        ("parameters", "turn_dot", "is the rate of coordinates.turn"),
        ("coordinates", "turn_dot", "is the rate of coordinates.turn"),
        ("parameters", "turn", "is also in parameters"),
        ("parameters", "axle", "is also in joints"),
    ],
)
def test_a_name_has_one_meaning_in_formulas(table: str, name: str, says: str) -> None:
    tree = arm(0, coordinates={"turn": {"joint": "axle", "of": "angle"}}, parameters={})
    tree[table][name] = 3 if table == "parameters" else {"joint": "axle", "of": "displacement"}
    with pytest.raises(SceneError, match=says):
        scene_from_dict(tree)


@pytest.mark.parametrize(
    ("given", "key", "says"),
    [
        ({}, "", "wanted one of joint, bodies and body, got none of them"),
        ({"joint": "axle"}, ".of", "is missing; axle is a cylindrical joint"),
        ({"joint": "axle", "of": "second_angle"}, ".of", "has no second_angle"),
        ({"joint": "axle", "of": "angle", "along": [0, 0, 1]}, ".along", "does not belong to"),
        ({"joint": "tip"}, ".joint", "leaves free no angle or displacement"),
        ({"joint": "axel"}, ".joint", "did you mean 'axle'?"),
        ({"body": "arm"}, ".along", "is missing; wanted a direction"),
        ({"body": "arm", "along": [0, 0, 0]}, ".along", "has zero length"),
        ({"body": "ground", "along": [0, 0, 1]}, ".body", "unknown body 'ground'"),
        ({"body": "bob", "point": [1, 0, 0], "along": [0, 0, 1]}, ".point", "its only point"),
        ({"body": "bob", "along": [0, 0, 1], "near": 2}, ".near", "belongs to an angle"),
        ({"bodies": ["arm", "bob"]}, ".points", "is missing; wanted a point in each"),
        ({"bodies": ["arm", "arm"], "points": [ZERO, ZERO]}, ".bodies", "to itself"),
        ({"bodies": ["arm", "bo"], "points": [ZERO, ZERO]}, ".bodies[1]", "did you mean 'bob'?"),
        ({"bodies": ["arm", "bob"], "points": [ZERO, [1, 0, 0]]}, ".points[1]", "is a point"),
    ],
)
def test_a_coordinate_that_cannot_be_is_refused(given: Tree, key: str, says: str) -> None:
    tree = arm(0, coordinates={"one": given})
    tree["bodies"]["bob"] = {"position": ZERO, "point": True, "mass": 1}
    tree["joints"]["tip"] = {"type": "ball", "bodies": ["arm", "bob"], "at": ZERO}
    with pytest.raises(SceneError) as caught:
        scene_from_dict(tree)
    assert caught.value.key == f"coordinates.one{key}"
    assert says in caught.value.problem
    assert len(caught.value.problems) == 1


def test_what_a_coordinate_needs_is_reported_once() -> None:
    """A joint that is wrong breaks its coordinate and the gear; a formula is wrong by itself."""
    tree = arm(0, coordinates={"turn": {"joint": "axle", "of": "angle"}})
    tree["joints"]["axle"]["type"] = "cylindrica"
    tree["joints"]["mesh"] = {"type": "gear", "joints": ["axle", "axle"], "ratio": 0}
    tree["drivers"] = {"motor": {"coordinate": "turn", "value": "abs(t)"}}
    tree["forces"] = {"drag": {"type": "friction", "joint": "axle", "damping": 1}}
    with pytest.raises(SceneError) as caught:
        scene_from_dict(tree)
    keys = [one.key for one in caught.value.problems]
    assert keys == ["joints.axle.type", "drivers.motor.value"]


@pytest.mark.parametrize("table", ["parameters", "coordinates", "drivers"])
def test_a_linkage_has_no_tables_of_bodies(table: str) -> None:
    lever = read_scene(Path(__file__).parents[3] / "scenes" / "lever_crank.toml")
    given = {
        "parameters": {"k": 1.0},
        "coordinates": {"c": Coordinate()},
        "drivers": {"d": Driver()},
    }
    with pytest.raises(SceneError, match=f"{table}: belong to bodies"):
        check(msgspec.structs.replace(lever, **{table: given[table]}))


def test_a_joint_that_is_no_coupling_has_bodies() -> None:
    tree = arm(0)
    del tree["joints"]["axle"]["bodies"]
    with pytest.raises(SceneError, match=r"joints\.axle\.bodies: is missing"):
        scene_from_dict(tree)


PLANE: Tree = {"type": "planar", "bodies": ["table", "puck"], "points": [[1, 2, 3], [0, 0, 4]]}
ACROSS: Tree = {"axes": [[0, 0, 1], [1, 0, 0]], "zero": [[3, 4, 0], [0, 1, 0]]}


def puck(joint: Tree, **tables: Any) -> Tree:
    """Body whose point is at (2, 1) in a plane of another one, turned by 0.5 rad."""
    name = {"name": "puck", "unit": "mm", "outputs": ["coordinates"]}
    sines = cos(0.5), sin(0.5)
    x, y = (0.6, 0.8), (-0.8, 0.6)
    place = [1 + 2 * x[0] + y[0], 2 + 2 * x[1] + y[1], 3]
    turned = [sines[0] * x[k] + sines[1] * y[k] for k in (0, 1)]
    # Columns: the axis of the puck, its zero direction, and what is across both.
    matrix: list[list[float]] = [[0, turned[0], -turned[1]], [0, turned[1], turned[0]], [1, 0, 0]]
    offset = [4 * matrix[k][2] for k in range(3)]
    position = [a - b for a, b in zip(place, offset, strict=True)]
    solid: Tree = {"mass": 1, "inertia": {"xx": 2, "yy": 3, "zz": 4, "xy": 0.5}}
    bodies = {
        "table": {"position": ZERO, **solid},
        "puck": {"position": position, "orientation": {"matrix": matrix}, **solid},
    }
    return {**name, "bodies": bodies, "joints": {"plane": PLANE | joint}, **tables}


OF = {
    "turn": {"joint": "plane", "of": "angle"},
    "x": {"joint": "plane", "of": "displacement"},
    "y": {"joint": "plane", "of": "second_displacement"},
}


@pytest.mark.parametrize("joint", [ACROSS, {"axis": [0, 0, 1], "zero": ACROSS["zero"]}])
def test_displacements_in_a_plane_are_along_zero_and_beside_it(joint: Tree) -> None:
    system = system_of(scene_from_dict(puck(joint, coordinates=OF)))
    assert [one.kind for one in system.coordinates] == ["angle", "n2", "n2"]
    values = [value(system, one) for one in system.coordinates]
    assert values == pytest.approx([0.5, 2e-3, 1e-3], abs=1e-15)


@pytest.mark.parametrize("where", ["coordinates", "drivers", "forces", "gear"])
def test_a_displacement_in_a_plane_wants_a_direction(where: str) -> None:
    tree = puck({"axes": ACROSS["axes"]})
    slide = {"type": "prismatic", "bodies": ["ground", "table"], "at": ZERO, "axis": [1, 0, 0]}
    wheel = {"type": "hinge", "bodies": ["table", "puck"], "at": ZERO, "axis": [0, 0, 1]}
    rack = {"type": "rack", "joints": ["wheel", "plane"], "radius": 3}
    added: Tree = {
        "coordinates": {"x": OF["x"]},
        "drivers": {"d": {**OF["y"], "value": "t"}},
        "forces": {"f": {"type": "friction", **OF["x"], "damping": 3}},
        "joints": tree["joints"] | {"slide": slide, "wheel": wheel, "rack": rack},
    }
    key = "joints" if where == "gear" else where
    with pytest.raises(SceneError, match="wanted the direction across the axis") as caught:
        scene_from_dict(tree | {"outputs": []} | {key: added[key]})
    assert [one.key for one in caught.value.problems] == ["joints.plane.zero"]


def test_which_freedom_of_a_plane_is_meant_must_be_said() -> None:
    says = "leaves 3 free: wanted 'angle', 'displacement' or 'second_displacement'"
    with pytest.raises(SceneError, match=says):
        scene_from_dict(puck(ACROSS, coordinates={"c": {"joint": "plane"}}))
    joints = puck(ACROSS)["joints"] | {"slide": {**PLANE, **ACROSS, "bodies": ["ground", "puck"]}}
    with pytest.raises(SceneError, match="leaves free angle, displacement and second_displacement"):
        scene_from_dict(puck(ACROSS, joints=joints, inputs={"i": {"joint": "slide"}}))


@pytest.mark.parametrize("of", ["displacement", "second_displacement"])
def test_displacements_in_a_plane_are_no_angles(of: str) -> None:
    spring = {"type": "rotational_spring_damper", "stiffness": 3}
    place = {"joint": "plane", "of": of}
    for tables, says in (
        ({"forces": {"f": spring | place}}, r"forces\.f\.of: is no angle"),
        (
            {"coordinates": {"x": place}, "forces": {"f": spring | {"coordinate": "x"}}},
            r"forces\.f\.coordinate: x is no angle",
        ),
        ({"coordinates": {"x": place | {"near": 0}}}, r"coordinates\.x\.near: belongs to an angle"),
    ):
        with pytest.raises(SceneError, match=says):
            scene_from_dict(puck(ACROSS, **{"outputs": [], **tables}))


def test_friction_in_a_plane_is_in_all_of_its_freedoms_without_a_direction() -> None:
    friction = {"type": "friction", "joint": "plane", "damping": 3}
    tree = puck({"axes": ACROSS["axes"]}, forces={"f": friction}, outputs=[])
    system = system_of(scene_from_dict(tree))
    assert [one.coordinate for one in system.forces] == [0, 1, 2]
    dampings = [dict(one.constants)["damping"][0] for one in system.forces]
    assert dampings == pytest.approx([3e-6, 3, 3])


def test_zero_directions_along_an_axis_in_frame_o_are_refused() -> None:
    tree = puck({"axis": [0, 0, 1], "zero": [[1, 0, 0], [5, 0, 0]]}, outputs=[])
    scene = scene_from_dict(tree)
    with pytest.raises(SceneError, match=r"joints\.plane\.zero\[1\]: is parallel to the axis"):
        system_of(scene)


def test_zero_beside_an_axis_is_as_beside_the_same_axes() -> None:
    tree = arm(0.25, coordinates={"turn": {"joint": "axle", "of": "angle"}})
    known = system_of(scene_from_dict(tree))
    tree["joints"]["axle"] |= {"axis": [0, 0, 3]}
    del tree["joints"]["axle"]["axes"]
    assert system_of(scene_from_dict(tree)) == known
