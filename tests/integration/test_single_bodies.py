"""One body on each joint moves as independent models of the ADAMS cases of Project Chrono do.

Definitions: ``data/testing/joints`` of projectchrono/chrono, commit 7689fbc0. One body of 1 kg with
principal moments 0.04, 0.1, 0.1 kg m², gravity 9.80665 m/s² along −z, from rest. The positions here
come from minimal coordinates and multi-precision Taylor series, not from ADAMS, whose own printed
digits agree with them to 5e-6 m (revolute) … 6e-4 m (universal, at 5 s); all that it prints is
compared to that accuracy, too.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.model.reading.read import read_scene
from kousoku.runtime.integrate.euler_parameters import rotated

from .conftest import SCENES

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.runtime.dynamics import DynamicsSolver
    from kousoku.runtime.integrate.motion import Motion

PENDULUM = ([-0.8923814855285858, -1.78987577342278], [-1.999683868883533, -0.03555874754523177])
"""Horizontal displacement and height at 1 s and 5 s of the motion that several cases share."""


def shared(x: int, y: int, along: tuple[float, float, float] = (0, 0, 0)) -> list[list[float]]:
    """Positions of the shared motion, in the direction (x, y) from a point."""
    return [[along[0] + x * way, along[1] + y * way, along[2] + height] for way, height in PENDULUM]


TIMES = (0.5, 1.0, 2.0, 3.0, 4.0, 5.0)
"""Those of the samples."""


CASES: dict[str, list[list[float]]] = {
    "revolute_case01": shared(1, 0),
    "revolute_case02": [
        [1.04210380696584, 3.41390015019431, 1.58609984980569],
        [1.20996050740757, 3.406399051714903, 1.593600948285097],
    ],
    "rotspring_case01": [
        [1.994920937469912, 0, -0.1424445620027903],
        [1.990439127056057, 0, -0.1953255781620075],
    ],
    "spherical_case01": shared(1, 0),
    "spherical_case02": shared(1, 0, (1, 2, 3)),
    "cylindrical_case03": [
        [1.04210380696584, 0.9622376501943097, -0.8655626501943097],
        [1.20996050740757, -57.8851634482851, -59.6979615517149],
    ],
    "prismatic_case02": [[3, -0.4516625, 0.5483375], [3, -59.2915625, -58.2915625]],
    "universal_case01": shared(0, 1),
    "universal_case02": shared(-1, 0),
    "universal_case03": [
        [-0.636249221384, -0.614080891001, -1.793904007353],
        [-1.434954697074, -1.392578011645, -0.040391816351],
    ],
    "distance_case01": [
        [0, -0.9565450384356574, -1.756422952891509],
        [0, -1.999998068489731, -0.002779575029759057],
    ],
    "distance_case02": [
        [0.2110285222767695, 2.771399413791198, -0.1183645030086532],
        [0.3652449136008087, 2.664921637033289, -0.7909667973929461],
    ],
    "distance_case03": [
        [0, 1.588487779411067, -3.67010774355174],
        [0, 3.955759379861008, -0.3015865267167031],
    ],
}
"""Positions at 1 s and 5 s, by the name of the case: that of its file in ``scenes/adams``."""

SPRING = "rotspring_case01"

LOOSE = ("spherical_case01", "universal_case01", "universal_case02", "universal_case03")
"""Those that ADAMS integrated with an error of 7e-4 m after 4 s."""

LIMITS = {"Pos": 5e-5, "Vel": 5e-5, "Avel": 2e-4, "Quat": 1e-5, "Rforce": 6e-4, "Rtorque": 6e-4}
LOOSE_LIMITS = {
    **{"Pos": 7e-4, "Vel": 2.5e-3, "Avel": 1.5e-3, "Quat": 3e-4, "Rforce": 1e-2, "Rtorque": 2e-4},
}
"""How far what ADAMS prints is from these motions: lengths in m, forces in N."""


def solver_of(mover: Callable[..., DynamicsSolver], case: str) -> DynamicsSolver:
    """Solver of a case, for the outputs that its scene wants; each is generated once."""
    scene = read_scene(SCENES / "adams" / f"{case}.toml")
    return mover(scene, outputs=scene.outputs)


@pytest.fixture
def motion(mover: Callable[..., DynamicsSolver], request: pytest.FixtureRequest) -> Motion:
    """Motion of a case at the times of the samples."""
    return solver_of(mover, request.param).simulate(times=[0.0, *TIMES], tolerance=1e-12)


cases = pytest.mark.parametrize(
    ("motion", "case"), [(name, name) for name in CASES], indirect=["motion"]
)


@cases
def test_a_body_on_a_joint_moves_as_minimal_coordinates_do(motion: Motion, case: str) -> None:
    expected = np.array(CASES[case])
    assert motion.position["body"][[2, 6]] == pytest.approx(expected, abs=1e-10)


def as_adams_prints(motion: Motion, row: int, case: str) -> dict[str, Any]:
    """Row as ADAMS prints it: global components, forces on the ground by the body.

    The point of a torque is that of the ground, and the torque of a spring is part of it.
    """
    p, force = motion.orientation["body"][row], motion.force["joint"][row]
    torque = motion.torque["joint"][row]
    if case.startswith(("cylindrical", "prismatic")):
        moved = motion.position["body"][row] - turned_point(motion, row)
        torque = torque + np.cross(moved, force)
    if case == SPRING:
        angle, rate = (table["angle"][row] for table in (motion.coordinate, motion.coordinate_rate))
        torque = torque - (200 * angle + 10 * rate) * np.array([0, 1, 0])
    return {
        "Pos": motion.position["body"][row],
        "Vel": motion.velocity["body"][row],
        "Avel": rotated(p, motion.angular_velocity["body"][row]),
        "Quat": p,
        "Rforce": -force,
        "Rtorque": -torque,
    }


def turned_point(motion: Motion, row: int) -> Any:
    """Place of the body if it had turned only, about the joint at (1, 2, 3)."""
    arm = motion.position["body"][0] - np.array([1, 2, 3])
    back = motion.orientation["body"][0] * [1, -1, -1, -1]
    own = rotated(back, arm)
    return np.array([1, 2, 3]) + rotated(motion.orientation["body"][row], own)


@cases
def test_a_body_on_a_joint_moves_as_adams_prints_it(
    motion: Motion, case: str, adams_samples: dict[str, Any]
) -> None:
    for row, time in enumerate(TIMES, 1):
        sample = adams_samples[case][f"{time:g}"]
        found = as_adams_prints(motion, row, case)
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
    mover: Callable[..., DynamicsSolver], adams_samples: dict[str, Any]
) -> None:
    motion = solver_of(mover, SPRING).simulate(times=[0.0, 0.5], tolerance=1e-12)
    assert np.abs(motion.torque["joint"]).max() < 1e-12
    printed = adams_samples[SPRING]["0.5"]["Rtorque"]
    angle, rate = (table["angle"][1] for table in (motion.coordinate, motion.coordinate_rate))
    assert printed[1] == pytest.approx(200 * angle + 10 * rate, abs=1e-3)
    assert printed[1] > 29.0
