"""One body on each joint moves as independent models of the ADAMS cases of Project Chrono do.

Definitions: ``data/testing/joints`` of projectchrono/chrono, commit 7689fbc0. One body of 1 kg with
principal moments 0.04, 0.1, 0.1 kg m², gravity 9.80665 m/s² along −z, from rest. The positions here
come from minimal coordinates and multi-precision Taylor series, not from ADAMS, whose own printed
digits agree with them to 5e-6 m (revolute) … 6e-4 m (universal, at 5 s); all that it prints is
compared to that accuracy, too.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.model.read import scene_from_dict
from kousoku.runtime.motion import rotated

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.model.scene import Scene
    from kousoku.runtime.dynamics import DynamicsSolver
    from kousoku.runtime.motion import Motion

Tree = dict[str, Any]

LONG_X = {"xx": 0.04, "yy": 0.1, "zz": 0.1}
LONG_Z = {"xx": 0.1, "yy": 0.1, "zz": 0.04}
QUARTER = math.pi / 2
ROOT = math.sqrt(0.5)
#: The joint frame of the second cases, turned by −45° about x: its z axis is (0, 1, 1)/√2.
TURNED = {"rotation_vector": [-math.pi / 4, 0, 0]}
ALONG = {"at": [1, 2, 3], "axis": [0, 1, 1]}

PENDULUM = ([-0.8923814855285858, -1.78987577342278], [-1.999683868883533, -0.03555874754523177])
"""Horizontal displacement and height at 1 s and 5 s of the motion that several cases share."""


def shared(x: int, y: int, along: tuple[float, float, float] = (0, 0, 0)) -> list[list[float]]:
    """Return positions of the shared motion, in the direction (x, y) from a point."""
    return [[along[0] + x * way, along[1] + y * way, along[2] + height] for way, height in PENDULUM]


TIMES = (0.5, 1.0, 2.0, 3.0, 4.0, 5.0)
"""Those of the samples."""


CASES: dict[str, tuple[list[float], Tree, Tree, list[list[float]]]] = {
    "revolute": (
        [2, 0, 0],
        {"type": "revolute", "at": [0, 0, 0], "axis": [0, 1, 0]},
        {"orientation": {"axis": [1, 0, 0], "angle": -QUARTER}, "inertia": LONG_X},
        shared(1, 0),
    ),
    "revolute_with_a_spring": (
        [2, 0, 0],
        {"type": "revolute", "at": [0, 0, 0], "axis": [0, 1, 0]},
        {"orientation": {"axis": [1, 0, 0], "angle": -QUARTER}, "inertia": LONG_X},
        [
            [1.994920937469912, 0, -0.1424445620027903],
            [1.990439127056057, 0, -0.1953255781620075],
        ],
    ),
    "revolute_turned": (
        [3, 2, 3],
        {"type": "hinge", **ALONG},
        {"orientation": TURNED, "inertia": LONG_X},
        [
            [1.04210380696584, 3.41390015019431, 1.58609984980569],
            [1.20996050740757, 3.406399051714903, 1.593600948285097],
        ],
    ),
    "spherical": (
        [2, 0, 0],
        {"type": "spherical", "at": [0, 0, 0]},
        {"inertia": LONG_X},
        shared(1, 0),
    ),
    "spherical_turned": (
        [3, 2, 3],
        {"type": "ball", "at": [1, 2, 3]},
        {"orientation": TURNED, "inertia": LONG_X},
        shared(1, 0, (1, 2, 3)),
    ),
    "cylindrical": (
        [3, 2, 3],
        {"type": "cylindrical", **ALONG},
        {"orientation": TURNED, "inertia": LONG_X},
        [
            [1.04210380696584, 0.9622376501943097, -0.8655626501943097],
            [1.20996050740757, -57.8851634482851, -59.6979615517149],
        ],
    ),
    "prismatic": (
        [3, 2, 3],
        {"type": "prismatic", **ALONG},
        {"orientation": TURNED, "inertia": LONG_X},
        [[3, -0.4516625, 0.5483375], [3, -59.2915625, -58.2915625]],
    ),
    "universal_about_x": (
        [0, 2, 0],
        {"type": "universal", "at": [0, 0, 0], "axis": [1, 0, 0], "second_axis": [0, 0, 1]},
        {"orientation": {"axis": [1, 0, 0], "angle": QUARTER}, "inertia": LONG_Z},
        shared(0, 1),
    ),
    "universal_about_y": (
        [-2, 0, 0],
        {"type": "hooke", "at": [0, 0, 0], "axis": [0, 0, -1], "second_axis": [0, 1, 0]},
        {"orientation": {"axis": [0, 1, 0], "angle": QUARTER}, "inertia": LONG_Z},
        shared(-1, 0),
    ),
    "universal_about_two_axes": (
        [2 * ROOT, 2 * ROOT, 0],
        {
            "type": "cardan",
            "at": [0, 0, 0],
            "axis": [0.5, -0.5, ROOT],
            "second_axis": [-0.5, 0.5, ROOT],
        },
        {"orientation": {"axis": [1, -1, 0], "angle": QUARTER}, "inertia": LONG_Z},
        [
            [-0.636249221384, -0.614080891001, -1.793904007353],
            [-1.434954697074, -1.392578011645, -0.040391816351],
        ],
    ),
    "rod_to_the_centre": (
        [0, 2, 0],
        {"type": "rod", "points": [[0, 0, 0], [0, 0, 0]]},
        {"inertia": LONG_X},
        [
            [0, -0.9565450384356574, -1.756422952891509],
            [0, -1.999998068489731, -0.002779575029759057],
        ],
    ),
    "rod_to_the_side": (
        [-1, 4, 3],
        {"type": "distance", "points": [[1, 2, 3], [2, 0, 0]], "length": 2},
        {"inertia": LONG_X},
        [
            [0.2110285222767695, 2.771399413791198, -0.1183645030086532],
            [0.3652449136008087, 2.664921637033289, -0.7909667973929461],
        ],
    ),
    "rod_to_an_end": (
        [0, 4, 0],
        {"type": "rod", "points": [[0, 0, 0], [2, 0, 0]]},
        {"orientation": {"axis": [0, 0, 1], "angle": -QUARTER}, "inertia": LONG_X},
        [
            [0, 1.588487779411067, -3.67010774355174],
            [0, 3.955759379861008, -0.3015865267167031],
        ],
    ),
}


SPRINGS = {
    "revolute_with_a_spring": {
        "type": "rotational_spring_damper",
        "joint": "joint",
        "stiffness": 200,
        "damping": 10,
    }
}
"""What acts on a joint, by the name of the case."""

SAMPLES = {
    "revolute": "revolute_case01",
    "revolute_turned": "revolute_case02",
    "revolute_with_a_spring": "rotspring_case01",
    "spherical": "spherical_case01",
    "spherical_turned": "spherical_case02",
    "cylindrical": "cylindrical_case03",
    "prismatic": "prismatic_case02",
    "universal_about_x": "universal_case01",
    "universal_about_y": "universal_case02",
    "universal_about_two_axes": "universal_case03",
    "rod_to_the_centre": "distance_case01",
    "rod_to_the_side": "distance_case02",
    "rod_to_an_end": "distance_case03",
}
"""Names of the cases in ``adams_samples.json``."""

LOOSE = ("spherical_case01", "universal_case01", "universal_case02", "universal_case03")
"""Those that ADAMS integrated with an error of 7e-4 m after 4 s."""

LIMITS = {"Pos": 5e-5, "Vel": 5e-5, "Avel": 2e-4, "Quat": 1e-5, "Rforce": 6e-4, "Rtorque": 6e-4}
LOOSE_LIMITS = {
    **{"Pos": 7e-4, "Vel": 2.5e-3, "Avel": 1.5e-3, "Quat": 3e-4, "Rforce": 1e-2, "Rtorque": 2e-4},
}
"""How far what ADAMS prints is from these motions: lengths in m, forces in N."""


def scene_of(name: str) -> Scene:
    """Return the scene of a case."""
    position, joint, body, _ = CASES[name]
    return scene_from_dict(
        {
            "name": name,
            "unit": "m",
            "gravity": [0, 0, -9.80665],
            "bodies": {"body": {"position": position, "mass": 1, **body}},
            "joints": {"joint": {"bodies": ["ground", "body"], **joint}},
            "forces": {"spring": SPRINGS[name]} if name in SPRINGS else {},
            "coordinates": {"angle": {"joint": "joint"}} if name in SPRINGS else {},
        }
    )


@pytest.fixture
def motion(mover: Callable[..., DynamicsSolver], request: pytest.FixtureRequest) -> Motion:
    """Return the motion of a case at the times of the samples; each is generated once."""
    outputs = ("reactions", "coordinates") if request.param in SPRINGS else ("reactions",)
    solver = mover(scene_of(request.param), outputs=outputs)
    assert solver.target.name == "c"
    return solver.simulate(times=[0.0, *TIMES], tolerance=1e-12)


@pytest.mark.parametrize(("motion", "name"), [(name, name) for name in CASES], indirect=["motion"])
def test_a_body_on_a_joint_moves_as_minimal_coordinates_do(motion: Motion, name: str) -> None:
    expected = np.array(CASES[name][-1])
    assert motion.position["body"][[2, 6]] == pytest.approx(expected, abs=1e-10)


def as_adams_prints(motion: Motion, row: int, name: str) -> Tree:
    """Return a row as ADAMS prints it: global components, forces on the ground by the body.

    The point of a torque is that of the ground, and the torque of a spring is part of it.
    """
    p, force = motion.orientation["body"][row], motion.force["joint"][row]
    torque = motion.torque["joint"][row]
    _, joint, _, _ = CASES[name]
    if joint["type"] in {"cylindrical", "prismatic"}:
        moved = motion.position["body"][row] - turned_point(motion, row)
        torque = torque + np.cross(moved, force)
    if name in SPRINGS:
        angle, rate = (table["angle"][row] for table in (motion.coordinate, motion.coordinate_rate))
        torque = torque - (200 * angle + 10 * rate) * np.array([0, 1, 0])
    return {
        "Pos": motion.position["body"][row],
        "Vel": motion.velocity["body"][row],
        "Avel": rotated(p[None], motion.angular_velocity["body"][[row]])[0],
        "Quat": p,
        "Rforce": -force,
        "Rtorque": -torque,
    }


def turned_point(motion: Motion, row: int) -> Any:
    """Return where the body would be if it had turned only, about the joint at (1, 2, 3)."""
    arm = motion.position["body"][0] - np.array([1, 2, 3])
    back = motion.orientation["body"][[0]] * [1, -1, -1, -1]
    own = rotated(back, arm[None])
    return np.array([1, 2, 3]) + rotated(motion.orientation["body"][[row]], own)[0]


@pytest.mark.parametrize(
    ("motion", "name"), [(name, name) for name in SAMPLES], indirect=["motion"]
)
def test_a_body_on_a_joint_moves_as_adams_prints_it(
    motion: Motion, name: str, adams_samples: Tree
) -> None:
    case = SAMPLES[name]
    for row, time in enumerate(TIMES, 1):
        sample = adams_samples[case][f"{time:g}"]
        found = as_adams_prints(motion, row, name)
        limits = LOOSE_LIMITS if case in LOOSE and time > 0.5 else LIMITS
        for key, limit in limits.items():
            own, printed = found[key], np.array(sample[key])
            if key == "Quat" and own @ printed < 0:  # p and −p are one orientation
                own = -own
            size = max(1.0, np.abs(printed).max() / 10) if key.startswith("R") else 1.0
            if key == "Rtorque":  # the error of the force, at the distance of the body
                size = max(size, np.linalg.norm(sample["Pos"]))
            assert np.abs(own - printed).max() < limit * size, (time, key, own, printed)


def test_reactions_of_a_hinge_do_not_hold_the_torque_of_its_spring(
    mover: Callable[..., DynamicsSolver], adams_samples: Tree
) -> None:
    solver = mover(scene_of("revolute_with_a_spring"), outputs=("reactions", "coordinates"))
    motion = solver.simulate(times=[0.0, 0.5], tolerance=1e-12)
    assert np.abs(motion.torque["joint"]).max() < 1e-12
    printed = adams_samples["rotspring_case01"]["0.5"]["Rtorque"]
    angle, rate = (table["angle"][1] for table in (motion.coordinate, motion.coordinate_rate))
    assert printed[1] == pytest.approx(200 * angle + 10 * rate, abs=1e-3)
    assert printed[1] > 29.0
