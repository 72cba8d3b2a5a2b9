"""Joints that let bodies slide, and joints that join several: motions known in closed form."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.codegen.dynamics.generate import generate_dynamics
from kousoku.codegen.generate import write_tree
from kousoku.model.reading.read import scene_from_dict
from kousoku.runtime.dynamics import load_dynamics
from tests.random_geometry import orientation_of

if TYPE_CHECKING:
    from pathlib import Path

    from kousoku.runtime.integrate.motion import Motion

Tree = dict[str, Any]

pytestmark = pytest.mark.usefixtures("compiler")

GRAVITY = np.array([0, 0, -9.81])
AXIS = np.array([2, -1, 2]) / 3
BOX = {"mass": 3, "size": [1, 2, 4], "at": [0.5, 0, 0]}
TILTED = {"quaternion": [3, 1, -2, 1], "order": "wxyz"}


def motion(folder: Path, bodies: Tree, joints: Tree) -> Motion:
    """Motion of a scene up to 2 s, in rows of 1 s."""
    tree = {"name": "s", "unit": "m", "gravity": GRAVITY.tolist(), "bodies": bodies}
    write_tree(folder, generate_dynamics(scene_from_dict(tree | {"joints": joints})))
    return load_dynamics(folder).simulate(2.0, samples=3, tolerance=1e-12)


ALONG, ACROSS = "along", "across"


@pytest.mark.parametrize(
    ("kind", "way"),
    [
        ("prismatic", ALONG),
        ("cylindrical", ALONG),
        ("inline", ALONG),
        ("planar", ACROSS),
        ("inplane", ACROSS),
        ("parallel_axes", None),
        ("perpendicular", None),
    ],
)
def test_a_body_slides_down_as_a_mass_does(tmp_path: Path, kind: str, way: str | None) -> None:
    """X = x₀ + g′ t²/2, with g′ the part of gravity that the joint leaves."""
    position = [1, 2, 3]
    joint: Tree = {"type": kind, "bodies": ["ground", "box"], "axis": AXIS.tolist()}
    if way:
        joint["at"] = position
    if kind == "perpendicular":
        joint["second_axis"] = [1, 2, 0]
    box = {"position": position, "orientation": TILTED, "boxes": [BOX | {"at": [0, 0, 0]}]}
    along = (GRAVITY @ AXIS) * AXIS
    left = {ALONG: along, ACROSS: GRAVITY - along, None: GRAVITY}[way]
    run = motion(tmp_path, {"box": box}, {"joint": joint})
    assert run.position["box"][2] == pytest.approx(position + 2 * left, abs=1e-11)
    assert run.velocity["box"][2] == pytest.approx(2 * left, abs=1e-11)


def pendulum(parts: int) -> tuple[Tree, Tree]:
    """Box on a tilted hinge, in one piece or in two that are welded together."""
    joint = {"type": "hinge", "bodies": ["ground", "a"], "at": [0, 0, 0], "axis": [1, 0, 1]}
    frame = {"position": [0, 0, 0], "orientation": TILTED, "angular_velocity": [0.5, 0, 0.5]}
    halves = [{"mass": 1.5, "size": [1, 2, 2], "at": [0.5, 0, z]} for z in (-1, 1)]
    if parts == 1:
        return {"a": {**frame, "boxes": halves}}, {"hinge": joint}
    bodies = {name: {**frame, "boxes": [half]} for name, half in zip("ab", halves, strict=True)}
    weld = {"type": "weld", "bodies": ["a", "b"], "at": [0, 3, 0]}
    return bodies, {"hinge": joint, "weld": weld}


def test_two_bodies_that_are_welded_move_as_one(tmp_path: Path) -> None:
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
    one = motion(tmp_path / "one", *pendulum(1))
    two = motion(tmp_path / "two", *pendulum(2))
    for body in ("a", "b"):
        assert two.orientation[body] == pytest.approx(one.orientation["a"], abs=1e-10)
        assert two.angular_velocity[body] == pytest.approx(one.angular_velocity["a"], abs=1e-9)
    turned = one.orientation["a"][2] @ one.orientation["a"][0]
    assert abs(turned) < 0.9, "the box has turned"


def test_a_point_slides_on_a_line_that_turns_with_its_body(tmp_path: Path) -> None:
    """A bead on a wire that turns about z with ω: x″ = ω² x, so that x = cosh ωt; no force in it.

    The wire is heavy and turns freely; m x² + J has the momentum of the start.
    """
    wire = {
        "position": [0, 0, 0],
        "angular_velocity": [0, 0, 2],
        "mass": 1,
        "inertia": {"xx": 1e9, "yy": 1e9, "zz": 1e9},
    }
    bead = {"position": [1, 0, 0], "velocity": [0, 2, 0], "point": True, "mass": 1e-6}
    joints = {
        "axle": {"type": "hinge", "bodies": ["ground", "wire"], "at": [0, 0, 0], "axis": [0, 0, 1]},
        "slide": {"type": "inline", "bodies": ["wire", "bead"], "at": [1, 0, 0], "axis": [1, 0, 0]},
    }
    run = motion(tmp_path, {"wire": wire, "bead": bead}, joints)
    distance = np.hypot(*run.position["bead"][:, :2].T)
    assert distance == pytest.approx(np.cosh(2 * run.time), rel=1e-9)
    assert run.position["bead"][:, 2] == pytest.approx(0, abs=1e-12)


FIRST, SECOND = np.array([1, 2, 0]) / 5**0.5, np.cross(AXIS, [1, 2, 0]) / 5**0.5
START = np.array([1.0, 2.0, 3.0])


def in_plane(folder: Path, **tables: Tree) -> Motion:
    """Motion of a box in a tilted plane, with its two displacements x and y."""
    joint: Tree = {"type": "planar", "bodies": ["ground", "box"], "axis": AXIS.tolist()}
    zero = orientation_of((3, 1, -2, 1)).T @ FIRST
    joint |= {"points": [START.tolist(), [0, 0, 0]], "zero": [FIRST.tolist(), zero.tolist()]}
    position = START + 0.5 * FIRST + 0.25 * SECOND
    box = {"orientation": TILTED, "boxes": [BOX | {"at": [0, 0, 0]}]}
    of = {"x": "displacement", "y": "second_displacement", "turn": "angle"}
    tree = {
        **{"name": "s", "unit": "m", "outputs": ["coordinates", "energies"], **tables},
        "bodies": {"box": {"position": position.tolist(), **box}},
        "joints": {"joint": joint},
        "coordinates": {name: {"joint": "joint", "of": sort} for name, sort in of.items()},
    }
    write_tree(folder, generate_dynamics(scene_from_dict(tree)))
    return load_dynamics(folder).simulate(2.0, samples=5, tolerance=1e-12)


def test_forces_along_displacements_in_a_plane_make_two_oscillations(tmp_path: Path) -> None:
    along = {"a": ("x", "-12*x"), "b": ("y", "-27*(y - 1)")}
    forces = {
        name: {"type": "along", "coordinate": on, "force": force}
        for name, (on, force) in along.items()
    }
    run = in_plane(tmp_path, forces=forces)
    x, y = 0.5 * np.cos(2 * run.time), 1 - 0.75 * np.cos(3 * run.time)
    np.testing.assert_allclose(run.coordinate["x"], x, rtol=0, atol=1e-11)
    np.testing.assert_allclose(run.coordinate["y"], y, rtol=0, atol=1e-11)
    way = START + x[:, None] * FIRST + y[:, None] * SECOND
    np.testing.assert_allclose(run.position["box"], way, rtol=0, atol=1e-11)
    assert run.ledger.energy_error == pytest.approx(0, abs=1e-10)


def test_displacements_and_the_angle_in_a_plane_can_be_driven(tmp_path: Path) -> None:
    laws = {"x": "0.5 + t^2", "y": "0.25*cos(t)", "turn": "3*t"}
    drivers = {f"of_{name}": {"coordinate": name, "value": law} for name, law in laws.items()}
    run = in_plane(tmp_path, drivers=drivers)
    assert run.ledger.method == "kinematics"
    t = run.time[:, None]
    way = START + (0.5 + t**2) * FIRST + 0.25 * np.cos(t) * SECOND
    np.testing.assert_allclose(run.position["box"], way, rtol=0, atol=1e-13)
    np.testing.assert_allclose(run.coordinate["turn"], 3 * run.time, rtol=0, atol=1e-13)
    accelerations = run.coordinate_acceleration
    np.testing.assert_allclose(run.coordinate_rate["x"], 2 * run.time, rtol=0, atol=1e-12)
    assert not accelerations
