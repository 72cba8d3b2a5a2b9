"""What joints with the ground leave of the momenta: looked at with the accelerations of each."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from kousoku.codegen.dynamics.assembly.assemble import assemble
from kousoku.codegen.dynamics.composition.compose import compose
from kousoku.codegen.dynamics.recording.interpreter import ProgramInterpreter
from kousoku.codegen.dynamics.simplification.conserved_momenta import conserved_momenta
from kousoku.model.elements.joints import JOINTS
from kousoku.model.lowering.system import system_of
from kousoku.model.mechanics.multibody import GROUND_INDEX, Instance, System
from kousoku.model.reading.read import scene_from_dict
from tests.analysed import all_rows

TILTED = {"quaternion": [3, 1, -2, 1], "order": "wxyz"}
AT, AXIS, OTHER = [0.3, -0.2, 0.5], [2, -1, 2], [1, 2, 0]

#: Joints whose two points are apart.
APART = ("rod", "prismatic", "cylindrical", "planar", "point_on_line", "point_on_plane", "screw")

#: Linear and angular directions that are free, and whether the latter are about a fixed point:
#: where the ground is body i, and where it is body j.
WANTED = {
    "fixed": ((0, 0, False), (0, 0, False)),
    "revolute": ((0, 1, True), (0, 1, True)),
    "prismatic": ((1, 0, False), (1, 0, False)),
    "cylindrical": ((1, 1, True), (1, 1, True)),
    "spherical": ((0, 3, True), (0, 3, True)),
    "universal": ((0, 1, True), (0, 1, True)),
    "planar": ((2, 1, False), (2, 1, False)),
    "rod": ((0, 3, True), (0, 3, True)),
    "point_on_line": ((1, 1, True), (0, 3, True)),
    "point_on_plane": ((2, 1, False), (0, 3, True)),
    "parallel_axes": ((3, 1, False), (3, 1, False)),
    "perpendicular_axes": ((3, 1, False), (3, 1, False)),
    "screw": ((0, 0, False), (0, 0, False)),
    "constant_velocity": ((0, 0, False), (0, 0, False)),
}


def held(kind: str, *, ground_first: bool) -> System:
    """Two bodies on a ball, of which one is joined with the ground; both move."""
    ends = ["ground", "b"] if ground_first else ["b", "ground"]
    joint: dict[str, Any] = {"type": kind, "bodies": ends}
    if JOINTS[kind].has_point:
        joint["at"] = AT
    if kind in APART:
        place = [joint.pop("at"), [0.7, 0.1, -0.2]]
        joint["points"] = place if ground_first else place[::-1]
    if JOINTS[kind].axes:
        joint["axis"] = AXIS
    if JOINTS[kind].axes == 2:
        joint["second_axis"] = AXIS if kind == "constant_velocity" else OTHER
    if kind == "screw":
        joint["pitch"] = 0.4
    start = {"angular_velocity": [1, -2, 3], "velocity": [0.5, 0.7, -0.4], "orientation": TILTED}
    inertia = {"xx": 0.2, "yy": 0.3, "zz": 0.25, "xy": 0.05}
    solid = {"mass": 1.3, "center": [0.1, 0.3, -0.2], "inertia": inertia, **start}
    tree = {
        **{"name": "held", "unit": "m"},
        "bodies": {"b": {"position": [0, 0, 0], **solid}, "c": {"position": [1, 0, 0], **solid}},
        "joints": {"k": joint, "ball": {"type": "ball", "bodies": ["b", "c"], "at": [1, 1, 0]}},
    }
    return assemble(system_of(scene_from_dict(tree)))


def rates_of_momentum(system: System, about: Any) -> Any:
    """Rates ṗ and L̇ of momentum from the accelerations, about a point or the centre of mass."""
    workspace = ProgramInterpreter(
        compose(all_rows(system, may_be_planar=False), ["checks", "energies"])
    )
    workspace.run("geometry", "velocity", "acceleration")
    v_dot = np.array(workspace["v_dot"]).reshape(-1, 6)
    mass = np.array([body.mass for body in system.bodies])
    r, v = (np.array([getattr(body, name) for body in system.bodies]) for name in ("r", "v"))
    accelerations = v_dot[:, :3]
    if about is None:
        about = mass @ r / mass.sum()
        accelerations = accelerations - mass @ accelerations / mass.sum()
    moment = np.zeros(3)
    for k, body in enumerate(system.bodies):
        e0, e = body.p[0], np.array(body.p[1:])
        skew = np.cross(np.eye(3), e)
        turn = np.eye(3) + 2 * e0 * skew + 2 * skew @ skew
        omega, inertia = np.array(body.omega_b), np.array(body.inertia)
        moment += turn @ (inertia * v_dot[k, 3:] + np.cross(omega, inertia * omega))
        moment += mass[k] * np.cross(r[k] - about, accelerations[k])
    assert np.abs(v).max() > 0.1
    return mass @ v_dot[:, :3], moment


@pytest.mark.parametrize("ground_first", [True, False])
@pytest.mark.parametrize("kind", JOINTS)
def test_what_a_joint_with_the_ground_leaves_does_not_change(kind: str, ground_first: bool) -> None:
    system = held(kind, ground_first=ground_first)
    linear, angular, is_fixed = WANTED[kind][0 if ground_first else 1]
    found = conserved_momenta(system, is_planar=False)
    if not linear + angular:
        assert found == ()
        return
    (kept,) = found
    assert (len(kept.linear), len(kept.angular)) == (linear, angular)
    assert (kept.about is not None) == is_fixed
    force, moment = rates_of_momentum(system, kept.about)
    assert [force @ one for one in kept.linear] == pytest.approx([0.0] * linear, abs=1e-12)
    assert [moment @ one for one in kept.angular] == pytest.approx([0.0] * angular, abs=1e-12)
    assert np.linalg.norm(moment) > 1e-2 or angular == 3
    assert np.linalg.norm(force) > 1e-2 or linear == 3


@pytest.mark.parametrize(
    ("kind", "across", "along"),
    [
        ("planar", (1, 1, False), (2, 1, False)),
        ("cylindrical", (1, 0, False), (0, 1, True)),
        ("spherical", (0, 1, True), (0, 1, True)),
        ("revolute", None, (0, 1, True)),
        ("prismatic", (1, 0, False), None),
    ],
)
def test_gravity_counts_about_a_point_of_the_ground_and_not_about_the_centre_of_mass(
    kind: str, across: object, along: object
) -> None:
    """Gravity across the axis (2, -1, 2) of the joint, and along it."""
    system = held(kind, ground_first=True)
    for gravity, wanted in (((3.0, 6.0, 0.0), across), ((-2.0, 1.0, -2.0), along)):
        found = conserved_momenta(replace(system, gravity=gravity), is_planar=False)
        counts = [(len(x.linear), len(x.angular), x.about is not None) for x in found]
        assert counts == ([] if wanted is None else [wanted])


def test_two_points_of_the_ground_leave_the_axis_through_both() -> None:
    system = held("spherical", ground_first=True)
    rod = Instance("rod", "distance", GROUND_INDEX, 1, (("s_i_b", (0.3, -0.2, 2.0)),))
    tied = replace(system, constraints=(*system.constraints, rod))
    (kept,) = conserved_momenta(tied, is_planar=False)
    assert kept.about == pytest.approx(AT)
    assert kept.angular == ((0.0, 0.0, 1.0),)
    beside = replace(rod, constants=(("s_i_b", (0.0, 0.0, 2.0)),))
    third = replace(system, constraints=(*tied.constraints, beside))
    assert conserved_momenta(third, is_planar=False) == ()


def test_parts_that_only_the_ground_connects_are_told_apart() -> None:
    """A point on a ball beside a body in a plane: each keeps its own."""
    solid = {"mass": 1, "inertia": {"xx": 1, "yy": 1, "zz": 1}}
    bodies = {
        "a": {"position": AT, "mass": 1, "point": True},
        "b": {"position": [0, 0, 0], **solid},
    }
    joints = {
        "rod": {"type": "rod", "bodies": ["ground", "a"], "points": [[0, 0, 0], [0, 0, 0]]},
        "plane": {"type": "planar", "bodies": ["ground", "b"], "at": [0, 0, 0], "axis": [0, 0, 1]},
    }
    tree = {"name": "s", "unit": "m", "bodies": bodies, "joints": joints, "gravity": [0, 0, -9]}
    found = conserved_momenta(system_of(scene_from_dict(tree)), is_planar=False)
    assert [(one.bodies, len(one.linear), one.angular) for one in found] == [
        ((0,), 0, ((0.0, 0.0, -1.0),)),
        ((1,), 2, ((0.0, 0.0, 1.0),)),
    ]


def test_an_axis_of_the_ground_that_parameters_change_counts_as_any() -> None:
    joint = {"type": "prismatic", "bodies": ["ground", "b"], "at": AT, "axis": [1, "k", 0]}
    body = {"position": [0, 0, 0], "mass": 1, "inertia": {"xx": 1, "yy": 1, "zz": 1}}
    tree = {"name": "s", "unit": "m", "bodies": {"b": body}, "joints": {"a": joint}}
    tree["parameters"] = {"k": 0.5}
    assert conserved_momenta(system_of(scene_from_dict(tree)), is_planar=False) == ()
