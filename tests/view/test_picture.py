"""The shapes of mechanisms, and where they are kept to be at equal times."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from msgspec import structs

from kousoku.model.elements.joints import JOINTS
from kousoku.model.errors import SolveError
from kousoku.model.reading.read import read_scene
from kousoku.view.joint_shapes import JOINT_PICTURES
from kousoku.view.meshes import mesh_of
from kousoku.view.picture import picture_at_rest, picture_of
from kousoku.view.shapes import rotation, vertices_of
from kousoku.view.stills import placed
from tests.view.runs import RATE, arm, lever_crank, turning

if TYPE_CHECKING:
    from kousoku.view.shapes import BodyShape

SCENES = Path(__file__).parents[2] / "scenes"
OF_BODIES = [p for p in sorted(SCENES.glob("*.toml")) if "[bodies" in p.read_text("utf-8")]
LINKAGES = [p for p in sorted(SCENES.glob("*.toml")) if "[nodes" in p.read_text("utf-8")]


def reach(shape: BodyShape) -> tuple[list[float], list[float]]:
    points = np.concatenate([vertices_of(part) for part in shape.parts])
    return points.min(axis=0).tolist(), points.max(axis=0).tolist()


def test_every_joint_has_a_picture_and_a_sign() -> None:
    assert JOINT_PICTURES.keys() == JOINTS.keys()


@pytest.mark.parametrize(
    "name",
    ["box 1 1 1", "box 3 1 2", "cylinder 4", "cylinder 2 8", "disc", "ball", "pedestal"],
)
def test_meshes_are_closed_and_their_faces_look_outward(name: str) -> None:
    mesh = mesh_of(name)
    vertices = np.array(mesh.vertices)
    volume = 0.0
    for face in mesh.faces:
        for b, c in pairwise(face):
            volume += np.linalg.det(vertices[[face[0], b, c]]) / 6
    assert volume > 0.5
    assert len(mesh.edges) == len(mesh.tones) == len(mesh.faces)
    if name != "pedestal":  # two solids that touch
        sides = [s for f in mesh.faces for s in zip(f, f[1:] + f[:1], strict=True)]
        assert len(set(sides)) == len(sides)
        assert {(b, a) for a, b in sides} == set(sides)


@pytest.mark.parametrize("path", OF_BODIES, ids=lambda path: path.stem)
def test_both_points_of_a_joint_are_at_one_place(path: Path) -> None:
    scene = read_scene(path)
    picture = picture_at_rest(scene)
    shapes = picture.shapes
    for mark in shapes.joints:
        if scene.joints[mark.name].at is not None:
            first = placed(picture, 0, mark.i, mark.s_i)
            second = placed(picture, 0, mark.j, mark.s_j)
            assert np.abs(second - first).max() < 1e-12 * (1 + shapes.size)
    assert all(shape.parts for shape in shapes.bodies[1:])


@pytest.mark.parametrize("path", LINKAGES, ids=lambda path: path.stem)
def test_links_end_at_their_nodes(path: Path) -> None:
    scene = read_scene(path)
    picture = picture_at_rest(scene)
    for k, shape in enumerate(picture.shapes.bodies):
        if shape.name not in scene.links:
            continue
        first, second = (np.array(scene.nodes[n].at) for n in scene.links[shape.name].nodes)
        length = float(np.linalg.norm(second - first))
        ends = placed(picture, 0, k, np.array([[0.0, 0.0, 0.0], [length, 0.0, 0.0]]))
        assert np.allclose(ends[:, :2], [first, second], atol=1e-12 * length)


def test_a_body_with_moments_only_looks_like_what_has_them() -> None:
    """The uniform rod of 1.5 m whose moments the scene of the pendulum gives."""
    (_, rod) = picture_at_rest(read_scene(SCENES / "pendulum.toml")).shapes.bodies
    low, high = reach(rod)
    assert low[0] == pytest.approx(-0.5, abs=2e-3)
    assert high[0] == pytest.approx(1.0, abs=2e-3)
    assert high[1] == pytest.approx(np.sqrt(0.002), rel=0.05)
    (_, top) = picture_at_rest(read_scene(SCENES / "heavy_top.toml")).shapes.bodies
    assert reach(top)[1][0] == pytest.approx(0.25, rel=1e-3)  # a disc, ½ m r² = 0.46875 kg m²


def test_sizes_that_are_formulas_are_those_of_the_run() -> None:
    for given, radius in ((None, 0.03), ({"thick": 0.05}, 0.05)):
        picture = picture_of(turning(), arm(), parameters=given)
        part = picture.shapes.bodies[1].parts[0]
        assert np.linalg.norm(part.matrix[:, 0]) == pytest.approx(radius)
    picture = picture_of(turning(parameters={"thick": 0.04}), arm())
    assert np.linalg.norm(picture.shapes.bodies[1].parts[0].matrix[:, 0]) == pytest.approx(0.04)


def test_upward_is_against_gravity_which_may_be_a_formula() -> None:
    scene = structs.replace(arm(), gravity=("20*thick", 0.0, 0.0))
    assert picture_of(turning(), scene).shapes.up.tolist() == [-1.0, 0.0, 0.0]
    still = structs.replace(arm(), gravity=(0.0, 0.0, 0.0))
    assert picture_at_rest(still).shapes.up.tolist() == [0.0, 1.0, 0.0]


def test_rows_that_lie_far_apart_are_kept_at_equal_times() -> None:
    picture = picture_of(turning(rows=5), arm(), fps=50.0)
    assert np.allclose(np.diff(picture.time), picture.time[1])
    assert picture.time[1] <= 1 / 50.0
    angle = RATE * picture.time
    wanted = np.stack([np.cos(angle / 2), 0 * angle, 0 * angle, np.sin(angle / 2)], axis=1)
    assert np.abs(picture.turn[:, 0] - wanted).max() < 1e-12


def test_places_between_rows_follow_velocities() -> None:
    time = np.array([0.0, 0.3, 1.0])
    cubic = np.stack([time**3, time - time**2, 0 * time], axis=1)
    rates = np.stack([3 * time**2, 1 - 2 * time, 0 * time], axis=1)
    run = turning(rows=3, time=time, position={"bar": cubic}, velocity={"bar": rates})
    picture = picture_of(run, arm())
    assert np.abs(picture.position[:, 0, 0] - picture.time**3).max() < 1e-14


def test_a_body_turns_little_from_frame_to_frame_however_fast_it_is() -> None:
    time = np.linspace(0.0, 2.0, 2001)
    angle = 150.0 * time
    turn = np.stack([np.cos(angle / 2), 0 * angle, 0 * angle, np.sin(angle / 2)], axis=1)
    spin = np.tile([0.0, 0.0, 150.0], (2001, 1))
    still = np.zeros((2001, 3))
    run = turning(
        time=time,
        position={"bar": still},
        velocity={"bar": still},
        orientation={"bar": turn},
        angular_velocity={"bar": spin},
        force={},
    )
    picture = picture_of(run, arm())
    cosine = np.abs((picture.turn[1:] * picture.turn[:-1]).sum(axis=-1))
    assert 2 * np.arccos(cosine.min()) < 0.41
    assert picture.speed == 0.1


@pytest.mark.parametrize(
    ("name", "normal"),
    [
        ("lever_crank", [0, 0, 1]),
        ("n_four_bar", [0, 0, 1]),
        ("gear_train", [0, 0, 1]),
        ("loop", None),
        ("bricard", None),
        ("heavy_top", None),
    ],
)
def test_a_planar_mechanism_is_seen_from_the_front(name: str, normal: list[int] | None) -> None:
    found = picture_at_rest(read_scene(SCENES / f"{name}.toml")).normal
    assert (None if found is None else found.tolist()) == normal


def test_a_planar_motion_is_seen_with_its_right_on_the_right() -> None:
    east, north, up = picture_of(turning(), arm()).directions()
    assert (east.tolist(), north.tolist(), up.tolist()) == ([1, 0, 0], [0, 0, -1], [0, 1, 0])


def test_a_linkage_moves_as_its_nodes_do() -> None:
    picture = picture_of(*lever_crank())
    assert picture.time[-1] == pytest.approx(2 * np.pi)
    assert [path.name for path in picture.paths] == ["O2", "O3"]
    tip = np.array([30.0, 0.0, 0.0])
    seen = np.array([placed(picture, k, 1, tip)[:2] for k in range(len(picture.time))])
    wanted = 30.0 * np.stack([np.cos(picture.time), np.sin(picture.time)], axis=1)
    assert np.abs(seen - wanted).max() < 1e-6


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"paths_of": ["bra"]}, "arm: no body or joint 'bra': there are bar, hinge; did you mean"),
        ({"paths_of": [("bar", (1, 2))]}, "no point of bar; wanted (x, y, z)"),
        ({"forces": ["hing"]}, "arm: no joint 'hing': there are hinge; did you mean 'hinge'?"),
        ({"speed": 0.0}, "wanted a positive number"),
        ({"fps": float("nan")}, "wanted a positive number"),
        ({"speed": "slow"}, "arm: speed 'slow'; wanted a number"),
        ({"parameters": [2]}, "arm: parameters [2]; wanted a mapping of names to numbers"),
        ({"parameters": {"thin": 2}}, "arm: no parameter 'thin'"),
        ({"start": 1.0, "end": 0.5}, "start=1.0 is not before end=0.5"),
    ],
)
def test_what_there_is_not_is_refused_in_one_line(options: dict[str, Any], message: str) -> None:
    with pytest.raises(SolveError) as refused:
        picture_of(turning(), arm(), **options)
    assert message in str(refused.value)
    assert "\n" not in str(refused.value)


def test_forces_that_were_not_computed_are_named() -> None:
    with pytest.raises(SolveError, match='no force of joints: generated without "reactions"'):
        picture_of(turning(force={}), arm(), forces=["hinge"])


def test_rotation_is_that_of_euler_parameters() -> None:
    half = np.sqrt(0.5)
    assert np.allclose(rotation(np.array([half, 0, 0, half])) @ [1, 0, 0], [0, 1, 0])
