"""A mechanism as a scene, and as equations: by recursion, or of all bodies in a plane."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from kousoku.model.reading.builder import SceneBuilder
from tests.benchmarks.kit import required
from tests.benchmarks.peers.equations import StateEquations, index_1
from tests.benchmarks.problems.tree import (
    GROUND,
    Kinematics,
    Tree,
    frames,
    is_damped,
    point_at,
    rotation,
    slopes,
)
from tests.benchmarks.rotations import rotated

if TYPE_CHECKING:
    from kousoku.model.reading.keys import InertiaKeys
    from kousoku.model.records.scene import Scene
    from tests.benchmarks.problems.tree import Point, Vector


def scene_of(name: str, tree: Tree) -> Scene:
    """Scene: one body a link, with the velocities that its joints' rates give."""
    where = frames(tree, np.array(tree.q))
    rates = np.array(tree.v)
    builder = SceneBuilder(name, unit="m").gravity(*tree.gravity)
    names = [f"link_{k}" for k in range(len(tree.links))]

    def named(link: int) -> str:
        return "ground" if link == GROUND else names[link]

    for k, link in enumerate(tree.links):
        omega, above = np.zeros(3), k
        while above != GROUND:
            one = tree.links[above]
            if not one.is_slide:
                omega = omega + where[1][above][:, one.axis] * rates[above]
            above = one.parent
        builder.body(
            names[k],
            position=where[0][k].tolist(),
            orientation={"matrix": where[1][k].tolist()},
            velocity=(rates @ slopes(tree, (k, (0.0, 0.0, 0.0)), where)).tolist(),
            angular_velocity=omega.tolist(),
            mass=link.mass,
            center=link.center,
            inertia=inertia_of(link.inertia),
        )
        builder.joint(
            f"joint_{k}",
            type="prismatic" if link.is_slide else "revolute",
            bodies=(named(link.parent), names[k]),
            at=point_at((link.parent, link.at), where).tolist(),
            axis=where[1][k][:, link.axis].tolist(),
        )
    for k, loop in enumerate(tree.loops):
        is_flat = loop.rows == "xy"
        builder.joint(
            f"loop_{k}",
            type="revolute" if is_flat else "spherical",
            bodies=(named(loop.a[0]), named(loop.b[0])),
            at=point_at(loop.a, where).tolist(),
            axis=(0, 0, 1) if is_flat else None,
        )
    for k, spring in enumerate(tree.springs):
        builder.force(
            f"spring_{k}",
            type="spring_damper",
            bodies=(named(spring.a[0]), named(spring.b[0])),
            points=(spring.a[1], spring.b[1]),
            stiffness=spring.stiffness,
            damping=spring.damping,
            free_length=spring.free_length,
        )
    for k, torque in tree.torques.items():
        turn = np.eye(3)[tree.links[k].axis] * torque
        builder.force(f"torque_{k}", type="torque", body=names[k], torque=turn.tolist())
    return builder.build()


def inertia_of(moments: Vector) -> InertiaKeys:
    """Moments as a scene has them."""
    return {"xx": moments[0], "yy": moments[1], "zz": moments[2]}


def observed_of(tree: Tree, names: list[str] | None = None) -> Any:
    """Function that takes the positions that are judged from a result of kousoku."""
    places = ["xyz".index(axis) for axis in tree.axes]

    def of(result: Any) -> Any:
        found = []
        for link, place in tree.observed:
            body = f"link_{link}" if names is None else names[link]
            arm = np.tile(place, (len(result), 1))
            turned = rotated(result.orientation[body], arm) if any(place) else arm
            found.append((result.position[body] + turned)[:, places])
        return np.hstack(found)

    return of


def flat(tree: Tree) -> StateEquations:
    """Equations of all bodies of a plane mechanism: x, y and the angle of each centre.

    Every joint holds its bodies by multipliers; the whole is of index 1.
    """
    ca = required("casadi")
    count = len(tree.links)
    q, v = ca.SX.sym("q", 3 * count), ca.SX.sym("v", 3 * count)
    where = frames(tree, np.array(tree.q))
    rates = np.array(tree.v)

    def turn(k: int) -> Any:
        c, s = ca.cos(q[3 * k + 2]), ca.sin(q[3 * k + 2])
        return ca.vertcat(ca.horzcat(c, -s), ca.horzcat(s, c))

    def at(point: Point) -> Any:
        link, place = point
        if link == GROUND:
            return ca.SX(place[:2])
        arm = np.array(place[:2]) - np.array(tree.links[link].center[:2])
        return q[3 * link : 3 * link + 2] + ca.mtimes(turn(link), ca.SX(arm))

    rows, start, speed, mass, pull = [], [], [], [], []
    held = []
    gravity = np.array(tree.gravity)
    for k, link in enumerate(tree.links):
        apart = at((k, (0.0, 0.0, 0.0))) - at((link.parent, link.at))
        if link.is_slide:
            along = np.eye(3)[link.axis][:2]
            across = np.array([-along[1], along[0]])
            matrix = ca.SX.eye(2) if link.parent == GROUND else turn(link.parent)
            rows.append(ca.dot(ca.mtimes(matrix, ca.SX(across)), apart))
            above = 0 if link.parent == GROUND else q[3 * link.parent + 2]
            rows.append(q[3 * k + 2] - above)
        else:
            held.append(slice(2 * k, 2 * k + 2))
            rows.append(apart)
        centre = (k, link.center)
        start += [*point_at(centre, where)[:2], _turned(tree, k)]
        speed += [*(rates @ slopes(tree, centre, where))[:2], _turned(tree, k, rate=True)]
        mass += [link.mass, link.mass, link.inertia[2]]
        pull += [*(link.mass * gravity[:2]), 0.0]
    rows += [at(loop.a) - at(loop.b) for loop in tree.loops]
    held += [slice(2 * (count + k), 2 * (count + k) + 2) for k in range(len(tree.loops))]
    forces = ca.SX(pull)
    for k, torque in tree.torques.items():
        forces[3 * k + 2] += torque
    energy = ca.dot(ca.SX(mass), v * v) / 2 - ca.dot(ca.SX(pull), q)
    for k, torque in tree.torques.items():
        energy -= torque * q[3 * k + 2]
    for spring in tree.springs:
        length = ca.sqrt(ca.sumsqr(at(spring.b) - at(spring.a)))
        slope = ca.gradient(length, q)
        stretch = length - spring.free_length
        forces -= slope * (spring.stiffness * stretch + spring.damping * ca.dot(slope, v))
        energy += spring.stiffness / 2 * stretch**2
    places = ["xy".index(axis) for axis in tree.axes]
    return index_1(
        q,
        v,
        np.array([*start, *speed]),
        mass=ca.diag(ca.SX(mass)),
        forces=forces,
        constraints=ca.vertcat(*rows),
        observed=ca.vertcat(*(at(point)[places] for point in tree.observed)),
        energy=None if is_damped(tree) else energy,
        held=held,
    )


def _turned(tree: Tree, k: int, *, rate: bool = False) -> float:
    """Angle of a link of a plane mechanism at the start, or its rate."""
    total = 0.0
    while k != GROUND:
        link = tree.links[k]
        total += 0.0 if link.is_slide else (tree.v if rate else tree.q)[k]
        k = link.parent
    return total


def recursive(tree: Tree) -> StateEquations:
    """Featherstone's articulated-body algorithm of a mechanism without loops.

    Motions are (turning, shifting at the joint), forces (moment about it, force), in each link.
    """
    ca = required("casadi")
    count = len(tree.links)
    has_energy = count <= SMALL and not is_damped(tree)
    made = Kinematics(tree, ca.SX.sym("q", count), ca.SX.sym("v", count))
    q, v = made.q, made.v
    pulls = -_gradient(made)
    ups: list[Any] = []
    motions: list[Any] = []
    biases, inertias, pushes = [], [], []
    for k, link in enumerate(tree.links):
        axis = link.axis + 3 * link.is_slide
        turn = ca.SX.eye(3) if link.is_slide else _turn(link.axis, q[k])
        arm = ca.SX(link.at)
        if link.is_slide:
            arm = arm + ca.SX(np.eye(3)[link.axis]) * q[k]
        ups.append(_blocks(turn, ca.SX(3, 3), -ca.mtimes(turn, ca.skew(arm)), turn))
        joint = ca.SX(6, 1)
        joint[axis] = v[k]
        above = ca.SX(6, 1) if link.parent == GROUND else motions[link.parent]
        motions.append(ca.mtimes(ups[k], above) + joint)
        w, u = ca.skew(motions[k][:3]), ca.skew(motions[k][3:])
        biases.append(ca.mtimes(_blocks(w, ca.SX(3, 3), u, w), joint))
        c = ca.skew(ca.SX(link.center)) * link.mass
        moments = ca.diag(ca.SX(link.inertia)) - ca.mtimes(c, c) / (link.mass or 1)
        inertias.append(ca.sparsify(_blocks(moments, c, -c, link.mass * ca.SX.eye(3))))
        swept = _blocks(w, u, ca.SX(3, 3), w)
        pushes.append(ca.mtimes(swept, ca.mtimes(inertias[k], motions[k])))
    columns: list[Any] = [None] * count
    pivots, rights = columns[:], columns[:]
    for k in reversed(range(count)):
        link = tree.links[k]
        axis = link.axis + 3 * link.is_slide
        columns[k], pivots[k] = inertias[k][:, axis], inertias[k][axis, axis]
        rights[k] = pulls[k] - pushes[k][axis]
        if link.parent != GROUND:
            left = inertias[k] - ca.mtimes(columns[k], columns[k].T) / pivots[k]
            push = pushes[k] + ca.mtimes(left, biases[k]) + columns[k] * rights[k] / pivots[k]
            up = ups[k]
            inertias[link.parent] += ca.mtimes(up.T, ca.mtimes(left, up))
            pushes[link.parent] += ca.mtimes(up.T, push)
    changes: list[Any] = []
    moved: list[Any] = []
    ground = ca.SX([0, 0, 0, *(-x for x in tree.gravity)])
    for k, link in enumerate(tree.links):
        axis = link.axis + 3 * link.is_slide
        above = ground if link.parent == GROUND else moved[link.parent]
        motion = ca.mtimes(ups[k], above) + biases[k]
        change = (rights[k] - ca.dot(columns[k], motion)) / pivots[k]
        joint = ca.SX(6, 1)
        joint[axis] = change
        moved.append(motion + joint)
        changes.append(change)
    return StateEquations(
        ca.vertcat(q, v),
        tree.start,
        made.observed(),
        rate=ca.vertcat(v, *changes),
        energy=made.kinetic() + made.weight() + made.stretched() if has_energy else None,
    )


#: Chains that are longer are judged by positions alone: their energies take long to write.
SMALL = 12


def _gradient(made: Kinematics) -> Any:
    """Forces of springs, dampers and torques of joints, with the sign of a gradient."""
    ca = required("casadi")
    tree = made.tree
    total = ca.SX(len(tree.links), 1)
    if tree.springs:
        total += ca.gradient(made.stretched(), made.q) - made.damping()
    for k, torque in tree.torques.items():
        total[k] -= torque
    return total


def _turn(axis: int, angle: Any) -> Any:
    """Matrix that takes components in the parent to those in the link."""
    return rotation(axis, angle).T


def _blocks(a: Any, b: Any, c: Any, d: Any) -> Any:
    ca = required("casadi")
    return ca.sparsify(ca.vertcat(ca.horzcat(a, b), ca.horzcat(c, d)))
