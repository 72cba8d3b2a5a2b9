"""One body on each joint moves as independent models of the ADAMS cases of Project Chrono do.

Definitions: ``data/testing/joints`` of projectchrono/chrono, commit 7689fbc0. One body of 1 kg with
principal moments 0.04, 0.1, 0.1 kg m², gravity 9.80665 m/s² along −z, from rest. The positions here
come from minimal coordinates and multi-precision Taylor series, not from ADAMS, whose own printed
digits agree with them to 5e-6 m (revolute) … 6e-4 m (universal, at 5 s).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.codegen.dynamics.generate import generate_dynamics
from kousoku.model.read import scene_from_dict
from kousoku.runtime.dynamics import load_dynamics

if TYPE_CHECKING:
    from pathlib import Path

    from kousoku.runtime.toolchain import Toolchain

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


CASES: dict[str, tuple[list[float], Tree, Tree, list[list[float]]]] = {
    "revolute": (
        [2, 0, 0],
        {"type": "revolute", "at": [0, 0, 0], "axis": [0, 1, 0]},
        {"orientation": {"axis": [1, 0, 0], "angle": -QUARTER}, "inertia": LONG_X},
        shared(1, 0),
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


@pytest.mark.parametrize("name", CASES)
def test_a_body_on_a_joint_moves_as_minimal_coordinates_do(
    compiler: Toolchain, tmp_path: Path, name: str
) -> None:
    position, joint, body, expected = CASES[name]
    scene = scene_from_dict(
        {
            "name": name,
            "unit": "m",
            "gravity": [0, 0, -9.80665],
            "bodies": {"body": {"position": position, "mass": 1, **body}},
            "joints": {"joint": {"bodies": ["ground", "body"], **joint}},
        }
    )
    for file, text in generate_dynamics(scene).items():
        (tmp_path / file).write_text(text, encoding="utf-8", newline="\n")
    motion = load_dynamics(tmp_path).simulate(5.0, samples=6, tolerance=1e-12)
    assert motion.target == "c"
    assert motion.position["body"][[1, 5]] == pytest.approx(np.array(expected), abs=1e-10)
