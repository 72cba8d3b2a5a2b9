"""Mechanisms as peers take them: links that hang on each other by hinges and slides, and loops.

One description serves MuJoCo, Pinocchio, Exudyn, and the equations in joint coordinates that SciPy,
heyoka and CasADi get. At zero coordinates all frames are parallel to frame O.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from tests.benchmarks.kit import required
from tests.benchmarks.peers.equations import StateEquations, lagrange

if TYPE_CHECKING:
    from kousoku.model.numbers.real import Array

Vector = tuple[float, float, float]
JointType = Literal["x", "y", "z", "slide x", "slide y", "slide z"]
#: The ground as a link.
GROUND = -1


@dataclass(frozen=True, slots=True)
class TreeLink:
    """A rigid body on the link before it.

    Parameters
    ----------
    joint : str
        The axis of its hinge, or of its slide.
    parent : int
        The link before it, :data:`GROUND` for none.
    at : (3,) [m]
        The joint in the frame of the parent; the frame of the link has its origin there.
    mass : float [kg]
        Its mass.
    center : (3,) [m]
        Its centre of mass.
    inertia : (3,) [kg m²]
        Its moments about the centre of mass, about the axes of its frame.
    """

    joint: JointType
    parent: int
    at: Vector
    mass: float
    center: Vector
    inertia: Vector

    @property
    def axis(self) -> int:
        """0, 1 or 2."""
        return "xyz".index(self.joint[-1])

    @property
    def is_slide(self) -> bool:
        """Whether it slides."""
        return self.joint.startswith("slide")


Point = tuple[int, Vector]
"""A link, and a point in its frame."""


@dataclass(frozen=True, slots=True)
class LoopClosure:
    """Two points that stay together, in some directions of frame O."""

    a: Point
    b: Point
    rows: str = "xyz"


@dataclass(frozen=True, slots=True)
class Spring:
    """A spring with a damper between two points."""

    a: Point
    b: Point
    stiffness: float
    free_length: float
    damping: float = 0.0


@dataclass(frozen=True, slots=True)
class Tree:
    """A mechanism.

    Parameters
    ----------
    links : tuple of TreeLink
        Parents before children.
    q, v : tuple of float
        Where it starts.
    gravity : (3,) [m/s²]
        Gravity.
    observed : tuple of Point
        The points whose positions are judged.
    axes : str
        The directions in which they are judged.
    loops, springs : tuple
        What else acts.
    torques : dict
        Constant torques or forces of joints, by link.
    """

    links: tuple[TreeLink, ...]
    q: tuple[float, ...]
    v: tuple[float, ...]
    gravity: Vector
    observed: tuple[Point, ...]
    axes: str = "xyz"
    loops: tuple[LoopClosure, ...] = ()
    springs: tuple[Spring, ...] = ()
    torques: dict[int, float] = field(default_factory=dict)

    @property
    def start(self) -> Array:
        """Q and v at time 0."""
        return np.array([*self.q, *self.v])

    def children(self, parent: int) -> list[int]:
        """Links on a link."""
        return [k for k, link in enumerate(self.links) if link.parent == parent]


class Kinematics:
    """Places and velocities of a tree's links over CasADi's symbols."""

    def __init__(self, tree: Tree, q: Any, v: Any) -> None:
        self.tree, self.q, self.v = tree, q, v
        self.turned: list[Any] = []
        self.origins: list[Any] = []
        self.omegas: list[Any] = []
        ca = required("casadi")
        for k, link in enumerate(tree.links):
            turned, origin, omega = ca.SX.eye(3), ca.SX(3, 1), ca.SX(3, 1)
            if link.parent != GROUND:
                above = link.parent
                turned, origin = self.turned[above], self.origins[above]
                omega = self.omegas[above]
            origin = origin + ca.mtimes(turned, ca.SX(link.at))
            axis = turned[:, link.axis]
            if link.is_slide:
                origin = origin + axis * q[k]
            else:
                turned = ca.mtimes(turned, rotation(link.axis, q[k]))
                omega = omega + axis * v[k]
            self.turned.append(turned)
            self.origins.append(origin)
            self.omegas.append(omega)

    def point(self, point: Point) -> Any:
        """Position of a point."""
        ca = required("casadi")
        link, place = point
        if link == GROUND:
            return ca.SX(place)
        return self.origins[link] + ca.mtimes(self.turned[link], ca.SX(place))

    def kinetic(self) -> Any:
        """Kinetic energy."""
        ca = required("casadi")
        total = ca.SX(0)
        for k, link in enumerate(self.tree.links):
            velocity = ca.jtimes(self.point((k, link.center)), self.q, self.v)
            omega = ca.mtimes(self.turned[k].T, self.omegas[k])
            moments = ca.SX(link.inertia)
            total += link.mass / 2 * ca.sumsqr(velocity) + ca.dot(moments, omega * omega) / 2
        return total

    def weight(self) -> Any:
        """Potential energy of gravity."""
        ca = required("casadi")
        gravity = ca.SX(self.tree.gravity)
        places = enumerate(self.tree.links)
        return -sum(link.mass * ca.dot(gravity, self.point((k, link.center))) for k, link in places)

    def length(self, spring: Spring) -> Any:
        """Length of a spring."""
        ca = required("casadi")
        return ca.sqrt(ca.sumsqr(self.point(spring.b) - self.point(spring.a)))

    def closed(self) -> Any:
        """Residuals that loops keep at zero; None without loops."""
        ca = required("casadi")
        rows = [
            (self.point(loop.a) - self.point(loop.b))["xyz".index(row)]
            for loop in self.tree.loops
            for row in loop.rows
        ]
        return ca.vertcat(*rows) if rows else None

    def observed(self) -> Any:
        """Positions that are judged."""
        ca = required("casadi")
        places = ["xyz".index(axis) for axis in self.tree.axes]
        return ca.vertcat(*(self.point(point)[places] for point in self.tree.observed))

    def damping(self) -> Any:
        """Generalised forces of dampers."""
        ca = required("casadi")
        total = ca.SX(len(self.tree.links), 1)
        for spring in self.tree.springs:
            if spring.damping:
                slope = ca.gradient(self.length(spring), self.q)
                total -= spring.damping * slope * ca.dot(slope, self.v)
        return total

    def stretched(self) -> Any:
        """Potential energy of springs."""
        total = required("casadi").SX(0)
        for spring in self.tree.springs:
            total += spring.stiffness / 2 * (self.length(spring) - spring.free_length) ** 2
        return total


def rotation(axis: int, angle: Any) -> Any:
    """Matrix of a turn about an axis of the frame."""
    ca = required("casadi")
    j, k = (axis + 1) % 3, (axis + 2) % 3
    found = ca.SX(3, 3)
    c, s = ca.cos(angle), ca.sin(angle)
    found[axis, axis], found[j, j], found[k, k], found[j, k], found[k, j] = 1, c, c, -s, s
    return found


def symbols(tree: Tree) -> Kinematics:
    """Tree over new symbols."""
    ca = required("casadi")
    count = len(tree.links)
    return Kinematics(tree, ca.SX.sym("q", count), ca.SX.sym("v", count))


def is_damped(tree: Tree) -> bool:
    """Whether its energy changes."""
    return any(spring.damping for spring in tree.springs)


def equations(tree: Tree) -> StateEquations:
    """Lagrange's equations in joint coordinates, of index 1 where there are loops."""
    made = symbols(tree)
    torques = sum(torque * made.q[k] for k, torque in tree.torques.items())
    found = lagrange(
        made.q,
        made.v,
        tree.start,
        kinetic=made.kinetic(),
        potential=made.weight() + made.stretched() - torques,
        observed=made.observed(),
        constraints=made.closed(),
        forces=made.damping(),
    )
    return replace(found, energy=None) if is_damped(tree) else found


def frames(tree: Tree, q: Array) -> tuple[Array, Array]:
    """Origins (links, 3) and matrices (links, 3, 3) of all frames."""
    count = len(tree.links)
    origins, turned = np.zeros((count, 3)), np.zeros((count, 3, 3))
    for k, link in enumerate(tree.links):
        is_ground = link.parent == GROUND
        above = np.eye(3) if is_ground else turned[link.parent]
        origins[k] = above @ link.at + (0.0 if is_ground else origins[link.parent])
        turned[k] = above
        if link.is_slide:
            origins[k] += above[:, link.axis] * q[k]
        else:
            i, j = (link.axis + 1) % 3, (link.axis + 2) % 3
            c, s = np.cos(q[k]), np.sin(q[k])
            turned[k][:, i], turned[k][:, j] = (
                c * above[:, i] + s * above[:, j],
                c * above[:, j] - s * above[:, i],
            )
    return origins, turned


def point_at(point: Point, where: tuple[Array, Array]) -> Array:
    """Position of a point, by all frames."""
    link, place = point
    if link == GROUND:
        return np.array(place)
    found: Array = where[0][link] + where[1][link] @ place
    return found


def placed(tree: Tree, q: Array) -> Array:
    """Positions that are judged, of joint coordinates."""
    where = frames(tree, q)
    axes = ["xyz".index(axis) for axis in tree.axes]
    return np.concatenate([point_at(point, where)[axes] for point in tree.observed])


def slopes(tree: Tree, point: Point, where: tuple[Array, Array]) -> Array:
    """Velocities of a point by unit rates of all joints, (links, 3)."""
    found = np.zeros((len(tree.links), 3))
    place, k = point_at(point, where), point[0]
    while k != GROUND:
        link = tree.links[k]
        axis = where[1][k][:, link.axis]
        found[k] = axis if link.is_slide else np.cross(axis, place - where[0][k])
        k = link.parent
    return found


def pulled(tree: Tree, q: Array, v: Array) -> Array:
    """Generalised forces of springs and dampers."""
    where, total = frames(tree, q), np.zeros(len(tree.links))
    for spring in tree.springs:
        apart = point_at(spring.b, where) - point_at(spring.a, where)
        length = float(np.sqrt(apart @ apart))
        slope = slopes(tree, spring.b, where) - slopes(tree, spring.a, where)
        stretch = slope @ (apart / length)
        force = spring.stiffness * (length - spring.free_length) + spring.damping * (stretch @ v)
        total -= force * stretch
    return total
