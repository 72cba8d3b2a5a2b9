"""Pinocchio: its accelerations in joint coordinates, integrated by SciPy's DOP853."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from tests.benchmarks.kit import required
from tests.benchmarks.peers.scipy import solved
from tests.benchmarks.problems.tree import GROUND, placed, pulled

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.model.numbers.real import Array
    from tests.benchmarks.problems.tree import Tree, TreeLink

#: Of loops: how exact the proximal iterations are, their damping, and how many at most.
PROXIMAL = (1e-14, 1e-10, 20)
#: The same where rows in space depend on each other: less damping loses the motion.
REDUNDANT = (1e-14, 1e-4, 200)


def model_of(tree: Tree) -> tuple[Any, list[int]]:
    """Pinocchio's model and the joints of links."""
    pin = required("pinocchio")
    model = pin.Model()
    model.gravity.linear = np.array(tree.gravity)
    joints: list[int] = []
    for k, link in enumerate(tree.links):
        parent = 0 if link.parent == GROUND else joints[link.parent]
        joints.append(model.addJoint(parent, _joint(pin, link), _at(pin, link.at), f"joint_{k}"))
        inertia = pin.Inertia(link.mass, np.array(link.center), np.diag(link.inertia))
        model.appendBodyToJoint(joints[-1], inertia, pin.SE3.Identity())
    return model, joints


def _joint(pin: Any, link: TreeLink) -> Any:
    letter = "P" if link.is_slide else "R"
    return getattr(pin, f"JointModel{letter}{'XYZ'[link.axis]}")()


def _at(pin: Any, place: Any) -> Any:
    return pin.SE3(np.eye(3), np.array(place, dtype=np.float64))


def rate_of(tree: Tree, *, is_redundant: bool = False) -> Callable[[float, Array], Array]:
    """Rate ẋ of x = (q, v): links by the articulated-body algorithm, loops by its constraints."""
    pin = required("pinocchio")
    model, joints = model_of(tree)
    data, count = model.createData(), len(tree.links)
    # A model numbers joints depth first.
    place = np.array([model.idx_vs[joint] for joint in joints])
    torque = np.zeros(count)
    torque[place] = [tree.torques.get(k, 0.0) for k in range(count)]
    constraints, constraint_data = [], []
    for loop in tree.loops:
        ends = [
            (0 if point[0] == GROUND else joints[point[0]], _at(pin, point[1]))
            for point in (loop.a, loop.b)
        ]
        frame = pin.ReferenceFrame.LOCAL
        kind = pin.ContactType.CONTACT_3D
        constraints.append(pin.RigidConstraintModel(kind, model, *ends[0], *ends[1], frame))
    models, datas = pin.StdVec_RigidConstraintModel(), pin.StdVec_RigidConstraintData()
    models.extend(constraints)
    constraint_data = [one.createData() for one in constraints]
    datas.extend(constraint_data)
    settings = pin.ProximalSettings(*(REDUNDANT if is_redundant else PROXIMAL))
    if constraints:
        pin.initConstraintDynamics(model, data, models, datas)
    q, v = np.zeros(count), np.zeros(count)
    found = np.zeros(2 * count)

    def rate(_t: float, x: Array) -> Array:
        q[place], v[place] = x[:count], x[count:]
        forces = torque
        if tree.springs:
            forces = torque.copy()
            forces[place] += pulled(tree, x[:count], x[count:])
        if constraints:
            change = pin.constraintDynamics(model, data, q, v, forces, models, datas, settings)
        else:
            change = pin.aba(model, data, q, v, forces)
        found[:count], found[count:] = x[count:], change[place]
        return found.copy()

    return rate


def runs(
    tree: Tree, tolerance: float, times: Array, *, is_redundant: bool = False
) -> tuple[Callable[[], object], Callable[[], Array]]:
    """Functions that run to the end, and that give the observed positions at all times."""
    run, states = solved(rate_of(tree, is_redundant=is_redundant), tree.start, tolerance, times)
    count = len(tree.links)
    return run, lambda: np.array([placed(tree, x[:count]) for x in states()])
