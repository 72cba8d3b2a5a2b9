"""A spatial scene becomes numbered bodies in their principal frames, and instances of kinds."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import msgspec
import pytest

from kousoku.codegen.kernel_json import load_frozen
from kousoku.model.elements.joints import JOINTS, NAMES
from kousoku.model.errors import SceneError
from kousoku.model.expressions.parser import parse_expression
from kousoku.model.expressions.values import value_of
from kousoku.model.lowering.parametric import fixed_system
from kousoku.model.lowering.system import system_of
from kousoku.model.mechanics.constraints import COMBINATION, CONSTRAINTS
from kousoku.model.mechanics.multibody import (
    GROUND_INDEX,
    Instance,
    RelativeCoordinate,
    System,
    Term,
)
from kousoku.model.operations.arithmetic import FLOAT
from kousoku.model.operations.interpret import evaluate
from kousoku.model.reading.families import chain, n_four_bar
from kousoku.model.reading.read import read_scene, scene_from_dict

ROOT = Path(__file__).parents[3]
Tree = dict[str, Any]
OF_BODIES = [name for name, joint in NAMES.items() if joint in JOINTS]


def scene(name: str) -> Any:
    """Committed scene without its inputs."""
    return msgspec.structs.replace(read_scene(ROOT / "scenes" / f"{name}.toml"), inputs={})


def violations(system: System) -> list[float]:
    """Residuals C of all instances at the start."""
    return [c for instance in system.constraints for c in violation(system, instance)]


def violation(system: System, instance: Instance) -> tuple[float, ...]:
    """Residuals C of one instance at the start."""
    if instance.kind == COMBINATION:
        pairs = ((system.coordinates[term.coordinate], term.factor) for term in instance.terms)
        return (sum(factor * value(system, of) for of, factor in pairs) + instance.offset,)
    return evaluated(system, instance)


def value(system: System, coordinate: RelativeCoordinate) -> float:
    """Value of a coordinate at the start; an angle as its kernel gives it."""
    return evaluated(system, coordinate)[0]


def evaluated(system: System, instance: Instance | RelativeCoordinate) -> tuple[float, ...]:
    """Values of the kernel of an instance or coordinate at the start."""
    kernel = next(k for k in load_frozen(instance.kind).kernels if k.name == "constraint")
    inputs: dict[str, tuple[float, ...]] = dict(instance.constants)
    for letter, index in (("i", instance.i), ("j", instance.j)):
        on_ground = index == GROUND_INDEX
        inputs[f"r_{letter}"] = (0.0, 0.0, 0.0) if on_ground else system.bodies[index].r
        inputs[f"p_{letter}"] = (1.0, 0.0, 0.0, 0.0) if on_ground else system.bodies[index].p
    return evaluate(kernel, inputs, FLOAT)["C"]


def turned_pair(kind: str) -> Tree:
    """Two bodies that are turned anyhow, and a joint in frame O between them."""
    entry = JOINTS[NAMES[kind]]
    joint: Tree = {"type": kind, "bodies": ["a", "b"]}
    if NAMES[kind] == "rod":
        joint["points"] = [[1, 0, 0], [0, 0.5, 0]]
    elif entry.has_point:
        joint["at"] = [0.5, -0.25, 2]
    if entry.axes:
        joint["axis"] = [1, 2, -2]
    if entry.axes == 2:
        joint["second_axis"] = [2, 1, 2]
    if "pitch" in entry.keys:
        joint["pitch"] = 0.5
    bodies = {
        "a": {
            "position": [1, 2, 3],
            "orientation": {"quaternion": [1, 2, -1, 3], "order": "wxyz"},
            "boxes": [
                {
                    "mass": 2,
                    "size": [1, 2, 3],
                    "at": [0.25, 0, 0.5],
                    "orientation": {"rotation_vector": [0.1, -0.2, 0.3]},
                }
            ],
        },
        "b": {
            "position": [-1, 0, 0.5],
            "orientation": {"rotation_vector": [0.5, -1, 2]},
            "mass": 3,
            "center": [0.125, 0.5, -1],
            "inertia": {"xx": 2, "yy": 3, "zz": 4, "xy": 0.25, "zx": -0.125},
        },
    }
    return {"name": "pair", "unit": "m", "bodies": bodies, "joints": {"joint": joint}}


@pytest.mark.parametrize("kind", OF_BODIES)
def test_a_joint_in_frame_o_holds_at_the_positions_of_the_scene(kind: str) -> None:
    system = system_of(scene_from_dict(turned_pair(kind)))
    assert system.constraints
    assert max(map(abs, violations(system))) < 4e-15


@pytest.mark.parametrize("kind", JOINTS)
def test_a_joint_is_composed_as_the_table_says(kind: str) -> None:
    system = system_of(scene_from_dict(turned_pair(kind)))
    kinds = [
        instance.kind if instance.kind == COMBINATION else instance.kind.partition("_")[0]
        for instance in system.constraints
    ]
    assert kinds == [part.kind for part in JOINTS[kind].parts]
    assert (
        sum(CONSTRAINTS[name].rows for name in kinds)
        == JOINTS[kind].rows
        == len(violations(system))
    )
    kept = [instance for instance in system.constraints if instance.kind != COMBINATION]
    found: list[Instance | RelativeCoordinate] = [*kept, *system.coordinates]
    for instance in found:
        kernel = next(k for k in load_frozen(instance.kind).kernels if k.name == "constraint")
        moving = {"r_i", "p_i", "r_j", "p_j"}
        assert {q.name for q in kernel.inputs} - moving == dict(instance.constants).keys()


@pytest.mark.parametrize(
    ("kind", "rows"),
    [
        ("fixed", 6),
        ("revolute", 5),
        ("prismatic", 5),
        ("cylindrical", 4),
        ("universal", 4),
        ("spherical", 3),
        ("planar", 3),
        ("point_on_line", 2),
        ("parallel_axes", 2),
        ("point_on_plane", 1),
        ("perpendicular_axes", 1),
        ("rod", 1),
        ("screw", 5),
        ("constant_velocity", 4),
    ],
)
def test_a_joint_takes_away_the_freedoms_that_it_should(kind: str, rows: int) -> None:
    assert JOINTS[kind].rows == rows


def test_points_and_axes_of_the_bodies_are_the_same_joint_as_in_frame_o() -> None:
    """The frame of a is A = [[0, −1, 0], [1, 0, 0], [0, 0, 1]] at (1, 2, 3)."""
    tree = turned_pair("universal")
    tree["bodies"]["a"]["orientation"] = {"quaternion": [1, 0, 0, 1], "order": "wxyz"}
    tree["bodies"]["b"]["orientation"] = {"quaternion": [0, 1, 0, 0], "order": "wxyz"}
    once = system_of(scene_from_dict(tree))
    tree["joints"]["joint"] = {
        "type": "universal",
        "bodies": ["a", "b"],
        "points": [[-2.25, 0.5, -1], [1.5, 0.25, -1.5]],
        "axes": [[2, -1, -2], [2, -1, -2]],
    }
    assert system_of(scene_from_dict(tree)).constraints == once.constraints


def test_the_frame_of_a_body_stands_in_its_centre_along_its_principal_axes() -> None:
    tree = turned_pair("spherical")
    tree["bodies"]["b"] |= {"velocity": [1, 0, 0], "angular_velocity": [0, 0, 2]}
    tree["bodies"]["b"]["orientation"] = {"quaternion": [0, 0, 0, 1], "order": "wxyz"}
    body = system_of(scene_from_dict(tree)).bodies[1]
    assert body.r == (-1.125, -0.5, -0.5)
    assert body.v == (2, -0.25, 0)
    assert sum(body.inertia) == pytest.approx(9, rel=1e-15)
    assert sum(x * x for x in body.omega_b) == pytest.approx(4, rel=1e-15)
    back = [sum(a * b for a, b in zip(body.p, row, strict=True)) for row in _left(body.axes_b)]
    assert back == pytest.approx([0, 0, 0, 1], abs=1e-15)


def _left(q: tuple[float, ...]) -> list[tuple[float, ...]]:
    """Matrix of p ↦ p ∘ q."""
    w, x, y, z = q
    return [(w, -x, -y, -z), (x, w, z, -y), (y, -z, w, x), (z, y, -x, w)]


def test_lengths_become_metres() -> None:
    tree = turned_pair("rod")
    metres = system_of(scene_from_dict(tree))
    tree["unit"] = "mm"
    millimetres = system_of(scene_from_dict(tree | {"gravity": [0, 0, -9810]}))
    assert millimetres.gravity == (0, 0, -9.81)
    assert millimetres.unit == 0.001
    for one, other in zip(metres.bodies, millimetres.bodies, strict=True):
        assert other.r == pytest.approx([x / 1e3 for x in one.r], rel=4e-16)
        assert other.inertia == pytest.approx([x / 1e6 for x in one.inertia], rel=4e-16)
        assert other.p == one.p
    (long,), (short,) = (dict(s.constraints[0].constants)["length"] for s in (metres, millimetres))
    assert short == pytest.approx(long / 1e3, rel=4e-16)


def test_a_rod_has_the_length_that_is_given_else_that_of_the_positions() -> None:
    tree = turned_pair("rod")
    tree["joints"]["joint"]["length"] = 7
    assert dict(system_of(scene_from_dict(tree)).constraints[0].constants)["length"] == (7,)
    tree["joints"]["joint"] = {"type": "rod", "bodies": ["a", "ground"]}
    tree["joints"]["joint"]["points"] = [[0, 0, 0], [1, 2, 3]]
    with pytest.raises(SceneError, match=r"joints\.joint\.length: is missing, and its two points"):
        system_of(scene_from_dict(tree))


def test_zeros_of_a_scene_stay_zeros() -> None:
    """Points and axes along axes of the body fold away if no last digit is left in them."""
    for system in (system_of(chain(3)), system_of(n_four_bar(2))):
        for instance in system.constraints:
            for name, values in instance.constants:
                assert sorted(map(abs, values))[:2] == [0, 0], (instance, name)


def test_a_pendulum_is_the_point_on_a_rod() -> None:
    system = system_of(scene("pendulum_on_a_rod"))
    (mass,), (bar,) = system.bodies, system.constraints
    assert (mass.is_point, mass.mass, mass.inertia) == (True, 1, (0, 0, 0))
    assert (bar.kind, bar.i, bar.j) == ("distance", GROUND_INDEX, 0)


def test_the_mass_of_the_pendulum_hangs_at_its_reduced_length() -> None:
    """(J + m s²)/(m s) = 1 m: the body's own origin moves as the mass of A01 does."""
    (rod,) = system_of(scene("pendulum")).bodies
    arm = abs(rod.r[0])
    assert (rod.inertia[2] + rod.mass * arm**2) / (rod.mass * arm) == 1
    assert rod.r[0] + rod.origin_b[0] == -1


def test_the_heavy_top_starts_with_the_velocity_of_its_definition() -> None:
    """V = (4.61538, 0, 0) m/s of the centre of mass: Brüls, Cardona and Arnold 2012."""
    (top,) = system_of(scene("heavy_top")).bodies
    assert top.v == (4.61538, 0, 0)
    assert top.r == (0, 1, 0)


def test_the_committed_four_bar_is_the_first_of_its_family() -> None:
    committed, built = scene("n_four_bar"), n_four_bar(2)
    assert system_of(committed).bodies == system_of(built).bodies
    assert system_of(committed).constraints == system_of(built).constraints


def test_every_committed_spatial_scene_is_a_system() -> None:
    scenes = [read_scene(path) for path in sorted((ROOT / "scenes").glob("*.toml"))]
    for spatial in (found for found in scenes if found.is_spatial):
        system = fixed_system(system_of(msgspec.structs.replace(spatial, inputs={})))
        assert max(map(abs, violations(system)), default=0) < 1e-15, spatial.name


def test_an_input_is_a_driver() -> None:
    """α = from + rate t + ½ acceleration t² of the angle of joint a."""
    spatial = read_scene(ROOT / "scenes" / "spatial_four_bar.toml")
    system = system_of(spatial)
    driver = system.constraints[-1]
    (angle,) = system.coordinates
    assert driver.kind == COMBINATION
    assert (driver.joint, driver.unit, driver.terms) == ("alpha", "rad", (Term(0, 1.0),))
    assert (angle.name, angle.kind, angle.near) == ("a.angle", "angle", 0)
    law = parse_expression(driver.law, ("t",))
    assert float(value_of(law, {"t": 2.5})) == 2.5


def test_a_linkage_is_no_system_of_bodies() -> None:
    with pytest.raises(SceneError, match="wanted a scene of bodies and joints"):
        system_of(read_scene(ROOT / "scenes" / "lever_crank.toml"))


def test_all_rods_whose_points_coincide_are_named_at_once() -> None:
    rod = {"type": "rod", "bodies": ["ground", "p"], "points": [[0, 0, 0]] * 2}
    body = {"position": [0, 0, 0], "point": True, "mass": 1}
    tree = {"name": "s", "unit": "m", "bodies": {"p": body}, "joints": {"a": rod, "b": rod}}
    with pytest.raises(SceneError) as caught:
        system_of(scene_from_dict(tree))
    assert [one.key for one in caught.value.problems] == ["joints.a.length", "joints.b.length"]


def test_all_zero_directions_along_their_axes_are_named_at_once() -> None:
    joint = {"type": "hinge", "bodies": ["ground", "b"], "at": [0, 0, 0], "axis": [0, 0, 1]}
    body = {"position": [0, 0, 0], "mass": 1, "inertia": {"xx": 1, "yy": 1, "zz": 1}}
    joints = {"a": joint | {"zero": [[0, 0, 1], [0, 0, -2]]}}
    tree = {"name": "s", "unit": "m", "bodies": {"b": body}, "joints": joints}
    with pytest.raises(SceneError) as caught:
        system_of(scene_from_dict(tree))
    assert [one.key for one in caught.value.problems] == ["joints.a.zero[0]", "joints.a.zero[1]"]
