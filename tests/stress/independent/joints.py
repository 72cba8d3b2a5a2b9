"""Joints, coordinates, couplings and drivers of a scene as conditions of its positions."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from tests.stress.independent.numbers import (
    across,
    any_across,
    atan2,
    back,
    cross,
    dot,
    least_turn,
    minus,
    norm,
    turned,
    unit,
    value_of,
)
from tests.stress.independent.solids import GROUND, Pose, orientation_of

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping

    from tests.stress.independent.formulas import Reader
    from tests.stress.independent.numbers import Number, Vector

    Tree = dict[str, Any]
    Poses = Mapping[str, Pose]
    Measure = Callable[[Poses], Number]

ANGLE, SECOND = "angle", "second_angle"
DISPLACEMENT, BESIDE = "displacement", "second_displacement"

LEAVES = {
    "revolute": (ANGLE,),
    "prismatic": (DISPLACEMENT,),
    "cylindrical": (ANGLE, DISPLACEMENT),
    "screw": (ANGLE, DISPLACEMENT),
    "universal": (ANGLE, SECOND),
    "planar": (ANGLE, DISPLACEMENT, BESIDE),
    "point_on_line": (DISPLACEMENT,),
    "parallel_axes": (ANGLE,),
}
"""What joints leave free that is one number."""

PARTS = {
    "fixed": ("point", "parallel axes", "no turn"),
    "revolute": ("point", "parallel axes"),
    "prismatic": ("parallel axes", "on line", "no turn"),
    "cylindrical": ("parallel axes", "on line"),
    "spherical": ("point",),
    "universal": ("point", "square axes"),
    "planar": ("parallel axes", "on plane"),
    "rod": ("distance",),
    "point_on_line": ("on line",),
    "point_on_plane": ("on plane",),
    "parallel_axes": ("parallel axes",),
    "perpendicular_axes": ("square axes",),
    "screw": ("parallel axes", "on line", "thread"),
    "constant_velocity": ("point", "equally fast"),
}
"""What joints keep."""

ALIASES = {
    "fixed": "weld rigid",
    "revolute": "hinge pin",
    "prismatic": "slider translational",
    "spherical": "ball",
    "universal": "hooke cardan Hooke Cardan",
    "rod": "distance spherical_spherical",
    "point_on_line": "inline",
    "point_on_plane": "inplane",
    "parallel_axes": "parallel",
    "perpendicular_axes": "perpendicular",
    "screw": "helical",
    "constant_velocity": "cv homokinetic rzeppa convel",
    "gear": "gears",
    "rack_and_pinion": "rack rackpin",
    "linear": "coupler",
}
TYPES = {alias: name for name, aliases in ALIASES.items() for alias in aliases.split()}
"""The types of joints by their other names."""


def name_of(joint: Tree) -> str:
    """Type of a joint by its first name."""
    given: str = joint["type"]
    return TYPES.get(given, given)


@dataclass(frozen=True, slots=True)
class Ends:
    """A joint between two bodies: what is fixed in each of them.

    Parameters
    ----------
    bodies : (str, str)
        Body i and body j.
    points : ((3,), (3,))
        Its point in each of the two frames.
    axes : ((3,), (3,))
        Its axis in each, of norm one.
    zero : ((3,), (3,))
        The direction across the axis in each from which angles are counted, of norm one.
    """

    bodies: tuple[str, str]
    points: tuple[Vector, Vector]
    axes: tuple[Vector, Vector]
    zero: tuple[Vector, Vector]

    def between(self, poses: Poses) -> Vector:
        """Vector d, from the point of i to that of j."""
        start, end = (poses[b].place(s) for b, s in zip(self.bodies, self.points, strict=True))
        return minus(end, start)

    def frame(self, poses: Poses, k: int) -> tuple[Vector, Vector, Vector]:
        """Zero direction, third and axis of a body, in frame O."""
        A = poses[self.bodies[k]].A
        x, z = turned(A, self.zero[k]), turned(A, self.axes[k])
        return x, cross(z, x), z


class Joints:
    """The joints and coordinates of a scene.

    Parameters
    ----------
    tree : dict
        The scene, as tomllib reads it.
    read : Reader
        What reads its numbers.
    """

    def __init__(self, tree: Tree, read: Reader) -> None:
        self.tree, self.read = tree, read
        self.written: dict[str, Pose] = {"ground": GROUND}
        for name, body in tree.get("bodies", {}).items():
            A = orientation_of(read, body.get("orientation"))
            self.written[name] = Pose(read.vector(body["position"]), A)
        self.joints: Tree = tree.get("joints", {})
        self.named: Tree = tree.get("coordinates", {})
        self.ends = {name: self._ends(one) for name, one in self.joints.items() if "bodies" in one}
        self.starts = {key: near for key, near in self._starts() if near is not None}
        self.offsets = {
            name: -self.combined(one, self.written, {})
            for name, one in self.joints.items()
            if self.type_of(name) in ("screw", "gear", "rack_and_pinion", "linear")
        }

    def type_of(self, joint: str) -> str:
        """Type of a joint by its first name."""
        return name_of(self.joints[joint])

    def laws(self) -> Iterator[tuple[str, Tree, list[Any]]]:
        """Name, driven coordinate and formulas of time, of all drivers and inputs."""
        for name, one in self.tree.get("drivers", {}).items():
            yield name, one, one["path"] if "path" in one else [one["value"]]
        for name, one in self.tree.get("inputs", {}).items():
            start, rate, more = (
                self.read.number(one.get(key, left_out))
                for key, left_out in (("from", 0.0), ("rate", 1.0), ("acceleration", 0.0))
            )
            yield name, one, [lambda t, a=start, b=rate, c=more: a + b * t + c / 2 * (t * t)]

    def law(self, given: Any, t: Number) -> Number:
        """Formula of time, that of an input among them."""
        return given(t) if callable(given) else self.read.number(given, {"t": t})

    def key_of(self, one: Tree) -> tuple[str, str] | None:
        """Joint and sort of what a coordinate, a driver or a force refers to."""
        if "coordinate" in one:
            return self.key_of(self.named[one["coordinate"]])
        if "joint" not in one:
            return None
        return one["joint"], one.get("of", LEAVES[self.type_of(one["joint"])][0])

    def _starts(self) -> Iterator[tuple[tuple[str, str], Number | None]]:
        """Values that angles are near at the start: those of drivers, then those of coordinates."""
        for _, one, laws in self.laws():
            if (key := self.key_of(one)) is not None and key[1] in (ANGLE, SECOND):
                yield key, self.law(laws[0], self.read.real(0))
        for one in self.named.values():
            if "near" in one and (key := self.key_of(one)) is not None:
                yield key, self.read.number(one["near"])

    def _ends(self, one: Tree) -> Ends:
        read, name = self.read, name_of(one)
        i, j = bodies = one["bodies"][0], one["bodies"][1]
        poses = self.written[i], self.written[j]
        if "points" in one:
            points: list[Vector] = [read.vector(point) for point in one["points"]]
        else:
            at = read.vector(one.get("at", [0, 0, 0]))
            is_point = [self.tree["bodies"].get(body, {}).get("point", False) for body in bodies]
            points = [
                [0, 0, 0] if alone else pose.point(at)
                for pose, alone in zip(poses, is_point, strict=True)
            ]
        if "axes" in one:
            axes = [unit(read.vector(axis)) for axis in one["axes"]]
        else:
            first = read.vector(one.get("axis", [0, 0, 1]))
            second = read.vector(one["second_axis"]) if "second_axis" in one else first
            axes = [unit(back(A.A, axis)) for A, axis in zip(poses, (first, second), strict=True)]
        if "zero" in one:
            zero = [across(a, read.vector(x)) for a, x in zip(axes, one["zero"], strict=True)]
        else:
            zero = self._as_written(name, poses, axes)
        return Ends(bodies, (points[0], points[1]), (axes[0], axes[1]), (zero[0], zero[1]))

    @staticmethod
    def _as_written(name: str, poses: tuple[Pose, Pose], axes: list[Vector]) -> list[Vector]:
        """Zero directions such that what a joint counts or keeps is zero as written."""
        a, b = (turned(pose.A, axis) for pose, axis in zip(poses, axes, strict=True))
        if name == "universal":
            return [
                back(pose.A, across(own, other))
                for pose, own, other in zip(poses, (a, b), (b, a), strict=True)
            ]
        x = any_across(a)
        y = turned(least_turn(a, b), x)
        return [back(pose.A, one) for pose, one in zip(poses, (x, y), strict=True)]

    def measure(self, one: Tree) -> Measure:
        """Coordinate as a function of positions; angles within half a turn of zero."""
        if (key := self.key_of(one)) is not None:
            return lambda poses: self.leaf(key, poses)
        if "coordinate" in one:
            return self.measure(self.named[one["coordinate"]])
        if "bodies" in one:
            i, j = one["bodies"]
            s, u = (self.read.vector(point) for point in one["points"])
            return lambda poses: norm(minus(poses[j].place(u), poses[i].place(s)))
        point = self.read.vector(one.get("point", [0, 0, 0]))
        along = unit(self.read.vector(one["along"]))
        return lambda poses: dot(along, poses[one["body"]].place(point))

    def leaf(self, key: tuple[str, str], poses: Poses) -> Number:
        """Value of a coordinate that a joint leaves free."""
        joint, sort = key
        ends, kind = self.ends[joint], self.type_of(joint)
        (x, y, z), (u, v, w) = ends.frame(poses, 0), ends.frame(poses, 1)
        if kind == "universal":
            if sort == ANGLE:  # of the arm of j about that of i
                return atan2(dot(y, w), dot(x, w))
            return -atan2(dot(v, z), dot(u, z))
        if sort == ANGLE:
            return atan2(dot(y, u), dot(x, u))
        along = z if kind != "planar" else x if sort == DISPLACEMENT else y
        return dot(along, ends.between(poses))

    def counted(self, one: Tree, poses: Poses, near: Mapping[tuple[str, str], Number]) -> Number:
        """Coordinate with its turns: within half a turn of what it was near before."""
        value = self.measure(one)(poses)
        key = self.key_of(one)
        if key is None or key[1] not in (ANGLE, SECOND):
            return value
        if key in near or key in self.starts:
            wanted = near.get(key, self.starts.get(key))
        else:
            wanted = self.leaf(key, self.written)
        turns = math.floor(float((wanted - value_of(value)) / (2 * self.read.pi)) + 0.5)
        return value + 2 * self.read.pi * turns

    def combined(self, one: Tree, poses: Poses, near: Mapping[tuple[str, str], Number]) -> Number:
        """Combination of coordinates that a screw or a coupling keeps."""

        def counted(joint: str, sort: str) -> Number:
            return self.counted({"joint": joint, "of": sort}, poses, near)

        read = self.read
        match name_of(one):
            case "screw":
                name = next(name for name, joint in self.joints.items() if joint is one)
                turn = read.number(one["pitch"]) / (2 * read.pi)
                return counted(name, DISPLACEMENT) - counted(name, ANGLE) * turn
            case "gear":
                first, second = one["joints"]
                return counted(second, ANGLE) - counted(first, ANGLE) * read.number(one["ratio"])
            case "rack_and_pinion":
                first, second = one["joints"]
                radius = read.number(one["radius"])
                return counted(second, DISPLACEMENT) - counted(first, ANGLE) * radius
            case _:
                pairs = zip(one["coordinates"], read.vector(one["factors"]), strict=True)
                parts = (self.counted(self.named[u], poses, near) * f for u, f in pairs)
                return sum(parts)

    def rows(
        self, t: Number, poses: Poses, near: Mapping[tuple[str, str], Number]
    ) -> Iterator[tuple[str, Number]]:
        """Joint or driver, and what is zero, of all conditions."""
        for name in self.joints:
            yield from ((name, row) for row in self._rows_of(name, poses, near))
        for name, one, laws in self.laws():
            if "path" in one:
                point = self.read.vector(one.get("point", [0, 0, 0]))
                place = poses[one["body"]].place(point)
                yield from ((name, x - self.law(y, t)) for x, y in zip(place, laws, strict=True))
            else:
                law = self.law(laws[0], t)
                key = self.key_of(one)
                known = {**near} if key is None else {**near, key: value_of(law)}
                yield name, self.counted(one, poses, known) - law

    def _rows_of(
        self, name: str, poses: Poses, near: Mapping[tuple[str, str], Number]
    ) -> Iterator[Number]:
        kind = self.type_of(name)
        if name not in self.ends:
            yield self.combined(self.joints[name], poses, near) + self.offsets[name]
            return
        ends = self.ends[name]
        d = ends.between(poses)
        (x, y, z), (u, v, w) = ends.frame(poses, 0), ends.frame(poses, 1)
        parts: dict[str, Callable[[], Vector]] = {
            "point": lambda: d,
            "parallel axes": lambda: (dot(x, w), dot(y, w)),
            "on line": lambda: (dot(x, d), dot(y, d)),
            "on plane": lambda: (dot(z, d),),
            "no turn": lambda: (dot(x, v),),
            "square axes": lambda: (dot(z, w),),
            "equally fast": lambda: (dot(x, v) - dot(y, u),),
            "distance": lambda: (norm(d) - self._length(name),),
            "thread": lambda: (self.combined(self.joints[name], poses, near) + self.offsets[name],),
        }
        for part in PARTS[kind]:
            yield from parts[part]()

    def _length(self, name: str) -> Number:
        if (length := self.joints[name].get("length")) is not None:
            return self.read.number(length)
        return norm(self.ends[name].between(self.written))
