"""Linkages whose joints hold more than once move as they should, and no row comes open."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.codegen.dynamics.assembly.assemble import assemble
from kousoku.codegen.dynamics.assembly.residuals import Residuals
from kousoku.model.lowering.system import system_of
from kousoku.model.numbers import precise
from kousoku.model.reading.read import read_scene, scene_from_dict

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.model.records.scene import Scene
    from kousoku.runtime.integrate.motion import Motion

SCENES = Path(__file__).parents[2] / "scenes"
TURN = (1, 0.3, 0.2, -0.5)
CORNERS = ((0, 0, 0), (0.3, 1, 0), (2.3, 1.6, 0), (2, 0, 0))
RODS = {"crank": (0, 1), "coupler": (1, 2), "rocker": (3, 2)}
JOINTS = {"a": ("ground", "crank"), "b": ("crank", "coupler"), "c": ("coupler", "rocker")}


def four_bar(turn: Any = (1, 0, 0, 0), **types: str) -> Scene:
    """Four-bar that falls, turned as a whole; its joints are revolute unless given."""

    def seen(a: Any) -> list[float]:
        by = tuple(map(precise.number, turn))
        w, x, y, z = by
        return [float(value) for value in precise.rotate((w, x, y, z), precise.triple(a))]

    tree: dict[str, Any] = {"name": "four_bar", "unit": "m", "gravity": seen((0, -9.81, 0))}
    tree["bodies"] = {
        name: {
            "position": seen(CORNERS[a]),
            "cylinders": [
                {
                    "mass": 1.5,
                    "radius": 0.05,
                    "ends": [[0, 0, 0], seen(np.subtract(CORNERS[b], CORNERS[a]))],
                }
            ],
        }
        for name, (a, b) in RODS.items()
    }
    ends = JOINTS | {"d": ("rocker", "ground")}
    tree["joints"] = {
        name: {"type": types.get(name, "revolute"), "bodies": list(bodies), "at": seen(at)}
        for (name, bodies), at in zip(ends.items(), CORNERS, strict=True)
    }
    for joint in tree["joints"].values():
        if joint["type"] != "spherical":
            joint["axis"] = seen((0, 0, 1))
    return scene_from_dict(tree)


def largest_residual(scene: Scene, motion: Motion) -> float:
    """Largest residual of the rows of all joints, also of those left out."""
    system = assemble(system_of(scene))
    rows = Residuals(system.constraints, system.bodies)
    columns = motion.columns()
    worst = 0.0
    for k in range(len(motion)):
        r, p = [], []
        for body in system.bodies:
            at = [precise.number(columns[f"{body.name}.{c}"][k]) for c in "xyz"]
            e = [precise.number(columns[f"{body.name}.e{n}"][k]) for n in range(4)]
            turned = precise.compose((e[0], e[1], e[2], e[3]), inverse(body.axes_b))
            center = precise.rotate(turned, precise.triple(-x for x in body.origin_b))
            r.append([float(x + y) for x, y in zip(at, center, strict=True)])
            p.append([float(x) for x in turned])
        ground = ([0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0])
        c, _ = rows.doubles(np.array([*r, ground[0]]), np.array([*p, ground[1]]))
        worst = max(worst, float(np.abs(c).max()))
    return worst


def inverse(axes: Any) -> Any:
    w, x, y, z = map(precise.number, axes)
    return precise.conjugate((w, x, y, z))


def test_a_turned_four_bar_moves_as_the_one_in_the_plane(mover: Callable[..., Any]) -> None:
    flat = mover(four_bar()).simulate(1.0, samples=11, tolerance=1e-12)
    scene = four_bar(TURN)
    turned = mover(scene).simulate(1.0, samples=11, tolerance=1e-12)

    w, x, y, z = map(precise.number, TURN)
    a, b = flat.columns(), turned.columns()
    for body in RODS:
        for k in range(11):
            here = [float(a[f"{body}.{c}"][k]) for c in "xyz"]
            there = precise.rotate((w, x, y, z), precise.triple(here))
            found = [b[f"{body}.{c}"][k] for c in "xyz"]
            assert found == pytest.approx([float(value) for value in there], abs=1e-9)
    assert abs(a["crank.y"][-1] - a["crank.y"][0]) + abs(a["rocker.e3"][-1]) > 0.1
    assert largest_residual(scene, turned) < 1e-11


def test_the_linkage_of_bricard_keeps_its_energy_and_closes_all_rows(
    mover: Callable[..., Any],
) -> None:
    scene = read_scene(SCENES / "bricard.toml")
    motion = mover(scene).simulate(1.0, samples=21, tolerance=1e-12)

    assert abs(motion.ledger.energy_error) < 1e-9
    assert largest_residual(scene, motion) < 1e-11
    assert abs(motion.columns()["rod_3.y"][-1] - 1) > 0.1


def door(*heights: float) -> Scene:
    """Door of 24 kg on hinges along the z axis."""
    tree: dict[str, Any] = {"name": "door", "unit": "m", "gravity": [0, 0, -9.81]}
    box = {"mass": 24, "size": [1, 0.05, 2]}
    tree["bodies"] = {"door": {"position": [0.5, 0, 0], "boxes": [box]}}
    tree["joints"] = {
        f"hinge_{k}": {
            "type": "revolute",
            "bodies": ["ground", "door"],
            "at": [0, 0, height],
            "axis": [0, 0, 1],
        }
        for k, height in enumerate(heights)
    }
    return scene_from_dict(tree)


def test_hinges_of_a_door_share_its_weight_and_say_that_this_is_not_unique(
    mover: Callable[..., Any],
) -> None:
    motion = mover(door(-0.8, 0, 0.8), ("reactions",)).simulate(0.1, samples=2)

    assert motion.not_unique == ("hinge_0", "hinge_1", "hinge_2")
    assert motion.note().startswith(
        "not unique: fx, fy, fz, mx, my of joints.hinge_0, joints.hinge_1"
    )
    # the ground's points are 1.6 m apart, the longest arm of one in a body is 0.8 m
    length = 1.6
    assert motion.reaction_length == pytest.approx(length)
    forces = np.array([motion.force[f"hinge_{k}"][0] for k in range(3)])
    torques = np.array([motion.torque[f"hinge_{k}"][0] for k in range(3)])
    assert forces[:, 2] == pytest.approx([8 * 9.81] * 3, rel=1e-12)
    # least squares with a torque m of each hinge and forces ±f at the outer two: 3 m + 1.6 f = M
    # and 3 m²/ℓ² + 2 f² is least for f = 0.8 m/ℓ²
    m = -12 * 9.81 / (3 + 1.6 * 0.8 / length**2)
    assert torques[:, 1] == pytest.approx([m] * 3, rel=1e-12)
    assert forces[2, 0] == pytest.approx(0.8 * m / length**2, rel=1e-12)
    assert forces[:, 0].sum() == pytest.approx(0.0, abs=1e-10)


@pytest.mark.parametrize(
    ("types", "away", "one", "two"),
    [
        ("revolute revolute", (0, 0, 1), "fx fy fz mx my", "fx fy fz mx my"),
        ("revolute cylindrical", (0, 0, 1), "fx fy mx my", "fx fy mx my"),
        ("revolute spherical", (0, 0, 1), "fx fy fz mx my", "fx fy fz"),
        ("spherical spherical", (0, 0, 1), "fz", "fz"),
        ("spherical spherical", (0, 0.6, 0.8), "fy fz", "fy fz"),
    ],
)
def test_only_components_that_two_joints_can_pull_against_each_other_are_not_unique(
    mover: Callable[..., Any], types: str, away: Any, one: str, two: str
) -> None:
    tree: dict[str, Any] = {"name": "leaf", "unit": "m", "gravity": [1, 2, -9.81]}
    tree["bodies"] = {"leaf": {"position": [0, 0, 0]}}
    tree["bodies"]["leaf"]["boxes"] = [{"mass": 8, "size": [1, 0.1, 2], "at": [0.5, 0, 0]}]
    tree["joints"] = {
        name: {"type": kind, "bodies": ["ground", "leaf"], "at": at}
        | ({} if kind == "spherical" else {"axis": away})
        for name, kind, at in zip(("one", "two"), types.split(), ((0, 0, 0), away), strict=True)
    }
    motion = mover(scene_from_dict(tree), ("reactions",)).simulate(0.1, samples=2)

    assert motion.undetermined == {"one": tuple(one.split()), "two": tuple(two.split())}
    assert f"not unique: {', '.join(motion.undetermined['one'])} of joints.one" in motion.note()


def test_forces_in_the_plane_are_unique_in_a_four_bar_and_its_joints_are_named_apart(
    mover: Callable[..., Any],
) -> None:
    flat = mover(four_bar(), ("reactions",)).simulate(0.5, samples=6, tolerance=1e-11)
    turned = mover(four_bar(TURN), ("reactions",)).simulate(0.5, samples=6, tolerance=1e-11)

    assert (flat.not_unique, turned.not_unique) == ((), ("a", "b", "c", "d"))
    assert flat.notes == (
        "not unique: of force and torque of joints.a, joints.b, joints.c, joints.d only what leads"
        " out of the plane; what acts in the plane is unique",
    )
    assert turned.notes == (turned.note(),)
    w, x, y, z = map(precise.number, TURN)
    for joint in flat.force:
        for here, there in zip(flat.force[joint], turned.force[joint], strict=True):
            seen = precise.rotate((w, x, y, z), precise.triple(here))
            assert list(there) == pytest.approx([float(value) for value in seen], abs=1e-7)


def test_loop_that_is_held_once_has_unique_forces_in_the_plane_and_in_space(
    mover: Callable[..., Any],
) -> None:
    types = {"b": "spherical", "c": "cylindrical"}
    flat = mover(four_bar(**types), ("reactions",)).simulate(0.1, samples=2)
    turned = mover(four_bar(TURN, **types), ("reactions",)).simulate(0.1, samples=2)

    assert flat.not_unique == turned.not_unique == ()
    sizes = [np.linalg.norm(motion.force["b"][-1]) for motion in (flat, turned)]
    assert sizes[0] == pytest.approx(sizes[1], rel=1e-7)


def test_gears_that_do_the_same_share_their_torque(mover: Callable[..., Any]) -> None:
    wheels = {"large": (0.0, 0.3, 2), "small": (0.5, 0.2, 1)}
    tree: dict[str, Any] = {"name": "gears", "unit": "m"}
    tree["bodies"] = {
        name: {
            "position": [x, 0, 0],
            "cylinders": [{"mass": mass, "radius": r, "ends": [[0, 0, -0.05], [0, 0, 0.05]]}],
        }
        for name, (x, r, mass) in wheels.items()
    }
    tree["joints"] = {
        f"axle_{name}": {
            "type": "revolute",
            "bodies": ["ground", name],
            "at": [x, 0, 0],
            "axis": [0, 0, 1],
        }
        for name, (x, _, _) in wheels.items()
    }
    for name in ("upper", "lower"):
        pair = ["axle_large", "axle_small"]
        tree["joints"][name] = {"type": "gear", "joints": pair, "ratio": -1.5}
    tree["forces"] = {"motor": {"type": "torque", "body": "large", "torque": [0, 0, 3.0]}}
    motion = mover(scene_from_dict(tree), ("reactions",)).simulate(0.1, samples=2)

    assert motion.not_unique == ("upper", "lower")
    # 0.09 kg m² of the large wheel and 1.5² of 0.02 kg m² are turned by 3 N m: 22.2 rad/s²
    torque = 0.5 * (0.09 * 3.0 / 0.135 - 3.0)
    for name in ("upper", "lower"):
        assert motion.torque[f"{name}.large"][0] == pytest.approx([0, 0, torque], rel=1e-12)
        assert motion.torque[f"{name}.small"][0] == pytest.approx([0, 0, torque / 1.5], rel=1e-12)


def test_forces_of_joints_in_no_loop_are_unique(mover: Callable[..., Any]) -> None:
    motion = mover("heavy_top", ("reactions",)).simulate(0.1, samples=2)

    assert motion.not_unique == ()
    assert motion.note() == ""
