"""What acts on the bodies of a scene: each as the virtual work that it does."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from tests.stress.independent.joints import LEAVES
from tests.stress.independent.numbers import (
    array,
    back,
    cross,
    dot,
    minus,
    norm,
    turned,
    unit,
    value_of,
)

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from tests.stress.independent.joints import Joints, Poses, Tree
    from tests.stress.independent.numbers import Jet, Number, Vector


@dataclass(frozen=True)
class Place:
    """The state that forces depend on.

    Parameters
    ----------
    t : number [s]
        Time.
    poses : mapping of str to Pose
        Positions, with their derivatives along δr and δθ′ of all bodies, and along the motion.
    near : mapping
        What angles are near, by joint and sort.
    columns : mapping of str to slice
        Where δr and δθ′ of each body stand.
    names : mapping of str to number
        Time, coordinates and their rates, as formulas name them.
    """

    t: Number
    poses: Poses
    near: Mapping[tuple[str, str], Number]
    columns: Mapping[str, slice]
    names: Mapping[str, Number]


@dataclass
class Load:
    """What forces amount to.

    Parameters
    ----------
    f : (n,) array
        Generalised forces, by δr in frame O and δθ′ in the body frame.
    potential : number [J]
        Potential energy.
    powers : dict of str to number [W]
        Power of what has no potential.
    """

    f: Any
    potential: Number = 0
    powers: dict[str, Number] = field(default_factory=dict)

    def along(self, u: Number, force: Number) -> Number:
        """Add a force along a coordinate, and return its power."""
        if not hasattr(u, "first"):  # between points of the ground
            return 0
        self.f = self.f + u.first[: len(self.f)] * force
        return u.first[-2] * force

    def works(self, name: str, power: Number) -> None:
        """Add power of what has no potential."""
        self.powers[name] = self.powers.get(name, 0) + power


class Forces:
    """The forces of a scene.

    Parameters
    ----------
    joints : Joints
        Its coordinates.
    """

    def __init__(self, joints: Joints) -> None:
        self.joints, self.read = joints, joints.read
        self.forces: Tree = joints.tree.get("forces", {})

    def act(self, load: Load, at: Place) -> None:
        """Add all forces but gravity."""
        for name, force in self.forces.items():
            match force["type"]:
                case "force" | "torque" as kind:
                    self._act(load, at, name, force, kind)
                case "spring_damper":
                    self._spring(load, at, name, force)
                case "rotational_spring_damper":
                    self._against_angle(load, at, name, force)
                case "friction":
                    joint = force["joint"]
                    every = LEAVES[self.joints.type_of(joint)]
                    for sort in [force["of"]] if "of" in force else every:
                        u = self.joints.leaf((joint, sort), at.poses)
                        damping = self.read.number(force["damping"])
                        load.works(name, load.along(u, -damping * u.first[-2]))
                case "along":
                    u = self.joints.measure(force)(at.poses)
                    load.works(name, load.along(u, self.read.number(force["force"], at.names)))
                case "bushing":
                    self._bushing(load, at, name, force)
                case kind:
                    raise ValueError(f"forces.{name}: no force is called {kind}")

    def _act(self, load: Load, at: Place, name: str, force: Tree, kind: str) -> None:
        body = at.poses[force["body"]]
        A = [[value_of(x) for x in row] for row in body.A]
        key = kind if kind in force else f"{kind}_b"
        given = self.read.vector(force[key], at.names)
        in_o = given if key == kind else turned(A, given)
        has_potential = key == "force" and not any(isinstance(x, str) for x in force[key])
        if kind == "force":
            place = body.place(self.read.vector(force.get("point", [0, 0, 0])))
            power = sum(load.along(x, component) for x, component in zip(place, in_o, strict=True))
            if has_potential:
                load.potential -= dot([value_of(x) for x in place], in_o)
        else:
            columns = at.columns[force["body"]]
            moment = array(back(A, in_o))
            load.f[columns.start + 3 : columns.stop] += moment
            power = dot(moment, self._omega(at, force["body"]))
        if not has_potential:
            load.works(name, power)

    @staticmethod
    def _omega(at: Place, body: str) -> Vector:
        """Angular velocity ω′, from Ȧ = A ω̃′."""
        A = at.poses[body].A
        rates = [[x.first[-2] for x in row] for row in A]
        columns = [[value_of(A[k][m]) for k in range(3)] for m in range(3)]
        turning = [
            [dot(columns[m], [rates[k][n] for k in range(3)]) for n in range(3)] for m in range(3)
        ]
        return [turning[2][1], turning[0][2], turning[1][0]]

    def _spring(self, load: Load, at: Place, name: str, force: Tree) -> None:
        i, j = force["bodies"]
        s, u = (self.read.vector(point) for point in force["points"])

        def d(poses: Poses) -> Sequence[Number]:
            return minus(poses[j].place(u), poses[i].place(s))

        between = d(at.poses)
        if not any(value_of(x) for x in between):
            return
        free = force.get("free_length")
        free = norm(d(self.joints.written)) if free is None else self.read.number(free)
        self._linear(load, at, (name, force, "tension"), norm(between), free)

    def _against_angle(self, load: Load, at: Place, name: str, force: Tree) -> None:
        one = force if "coordinate" in force else {"of": "angle", **force}
        free = force.get("free_angle")
        if free is None:
            free = self.joints.counted(one, self.joints.written, {})
        else:
            free = self.read.number(free)
        u = self.joints.counted(one, at.poses, at.near)
        self._linear(load, at, (name, force, "moment"), u, free)

    def _linear(
        self, load: Load, at: Place, given: tuple[str, Tree, str], u: Jet, free: Number
    ) -> None:
        """Add a spring and damper, or the formula of one, against what is beyond its free value."""
        name, force, key = given
        x, v = u.value - free, u.first[-2]
        if key in force:
            tension = self.read.number(force[key], {"t": at.t, "x": x, "v": v})
            load.works(name, load.along(u, -tension))
            return
        stiffness = self.read.number(force.get("stiffness", 0.0))
        load.along(u, -stiffness * x)
        load.potential += stiffness * x * x / 2
        if "damping" in force:
            load.works(name, load.along(u, -self.read.number(force["damping"]) * v))

    def _bushing(self, load: Load, at: Place, name: str, force: Tree) -> None:
        for stiffness, damping, u in self._directions(at, force):
            load.along(u, -stiffness * u.value)
            load.potential += stiffness * u.value * u.value / 2
            if "damping" in force:
                load.works(name, load.along(u, -damping * u.first[-2]))

    def _directions(self, at: Place, force: Tree) -> Iterator[tuple[Number, Number, Jet]]:
        """Stiffness, damping, and displacement or sine of a turn, of all six directions."""
        i, j = force["bodies"]
        written = self.joints.written
        if "points" in force:
            points: list[Vector] = [self.read.vector(one) for one in force["points"]]
        else:
            middle = self.read.vector(force["at"])
            points = [written[body].point(middle) for body in (i, j)]
        first, near = (self.read.vector(a) for a in force.get("axes", ([1, 0, 0], [0, 1, 0])))
        x = unit(first)
        z = unit(cross(x, near))
        axes = [x, cross(z, x), z]
        in_i, in_j = ([back(written[body].A, a) for a in axes] for body in (i, j))
        d = minus(at.poses[j].place(points[1]), at.poses[i].place(points[0]))
        e_i = [turned(at.poses[i].A, a) for a in in_i]
        e_j = [turned(at.poses[j].A, a) for a in in_j]
        displacements = [dot(a, d) for a in e_i]
        # A turn of j by θ about k takes its axis k + 1 to cos θ of that of i, and sin θ of k + 2.
        sines = [dot(e_i[k - 1], e_j[k - 2]) for k in range(3)]
        six = [self.read.vector(force.get(key, [0.0] * 6)) for key in ("stiffness", "damping")]
        for stiffness, damping, u in zip(*six, [*displacements, *sines], strict=True):
            if hasattr(u, "first"):
                yield stiffness, damping, u
