"""The coordinates that a system needs, collected while it is made."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.model.elements.joints import JOINTS, NAMES, sort_of
from kousoku.model.mechanics.constraints import COORDINATES, is_length
from kousoku.model.mechanics.frames import joint_points
from kousoku.model.mechanics.measures import PreciseMeasure, place_measure
from kousoku.model.mechanics.multibody import RelativeCoordinate
from kousoku.model.numbers import precise
from kousoku.model.numbers.digits import CONTEXT
from kousoku.model.numbers.traced import at_scene

if TYPE_CHECKING:
    from collections.abc import Mapping

    from kousoku.model.mechanics.frames import BodyFrame
    from kousoku.model.numbers.precise import High
    from kousoku.model.records.scene import Scene
    from kousoku.model.records.spatial import Coordinate, Joint


def joint_measure(joint: Joint, sort: str, frames: Mapping[str, BodyFrame]) -> PreciseMeasure:
    """Measure that a joint leaves free: an angle or a displacement."""
    ends = frames[joint.ends[0]], frames[joint.ends[1]]
    return JOINTS[NAMES[joint.type]].measure(joint, sort, ends)


class CoordinateList:
    """The coordinates that are needed so far; a coordinate is added when it is first asked for.

    Parameters
    ----------
    scene : Scene
        A checked scene.
    frames : mapping of str to BodyFrame
        Of all bodies and the ground.
    unit : number [m]
        The unit of the scene.

    Attributes
    ----------
    scene, frames, unit
        As given.
    """

    def __init__(self, scene: Scene, frames: Mapping[str, BodyFrame], unit: High) -> None:
        self.scene, self.frames, self.unit = scene, frames, unit
        self._indices: dict[str, int] = {}
        self._records: list[RelativeCoordinate] = []
        self._values: list[High] = []
        self._turned: set[int] = set()
        self._starts: dict[tuple[str, str], High] = {}
        self._named: dict[tuple[str, str], str] = {}
        for name, coordinate in scene.coordinates.items():
            if coordinate.joint is not None:
                sort = sort_of(scene.joints[coordinate.joint].type, coordinate.of)
                self._named.setdefault((coordinate.joint, sort), name)

    @property
    def records(self) -> tuple[RelativeCoordinate, ...]:
        """Coordinates that were asked for, in the order of asking."""
        return tuple(self._records)

    def record(self, index: int) -> RelativeCoordinate:
        """Coordinate at an index."""
        return self._records[index]

    def value(self, index: int) -> High:
        """Coordinate at the positions as they are written, in SI units, turns counted."""
        return self._values[index]

    def ends(self, index: int) -> tuple[int, int]:
        """Bodies of a coordinate, in the order of the joint that leaves it free."""
        record = self._records[index]
        return (record.j, record.i) if index in self._turned else (record.i, record.j)

    def unit_of(self, index: int) -> tuple[str, High]:
        """Unit, ``rad`` or ``m``, and the factor that takes a value of the scene to it."""
        kind = self._records[index].kind
        return ("m", self.unit) if is_length(kind) else ("rad", CONTEXT.mpf(1))

    def index_of(self, name: str) -> int:
        """Index of a coordinate of the scene."""
        if name in self._indices:
            return self._indices[name]
        coordinate = self.scene.coordinates[name]
        near: High | None = None if coordinate.near is None else precise.number(coordinate.near)
        if near is None and coordinate.joint is not None:
            joint = self.scene.joints[coordinate.joint]
            near = self._starts.get((coordinate.joint, sort_of(joint.type, coordinate.of)))
        return self.add(name, self._measure(coordinate), near)

    def of_joint(self, joint: str, of: str | None = None) -> int:
        """Index of the coordinate that a joint leaves free: that of the scene, if it has one.

        Parameters
        ----------
        joint : str
            The joint.
        of : {"angle", "second_angle", "displacement", "second_displacement"}, optional
            Which of them, where it leaves more than one free.
        """
        record = self.scene.joints[joint]
        sort = sort_of(record.type, of)
        if (joint, sort) in self._named:
            return self.index_of(self._named[joint, sort])
        measure = joint_measure(record, sort, self.frames)
        return self.add(f"{joint}.{sort}", measure, self._starts.get((joint, sort)))

    def starts_at(self, joint: str, sort: str, angle: float) -> None:
        """Note the approximate angle of a joint at the start, so that its turns are known."""
        self._starts[joint, sort] = precise.number(angle)

    def add(self, name: str, measure: PreciseMeasure, near: High | None = None) -> int:
        """Index of a coordinate, which is added unless one of its name is known.

        Parameters
        ----------
        name : str
            Its name.
        measure : PreciseMeasure
            How it is measured.
        near : number [rad], optional
            Of an angle, a value within half a turn of the one at the start.
        """
        if name in self._indices:
            return self._indices[name]
        index = self._indices[name] = len(self._records)
        value, start = measure.value(), CONTEXT.mpf(0)
        if COORDINATES[measure.kind].counts_turns:
            start = value if near is None else near
            turns = CONTEXT.nint(at_scene(start - value) / (2 * CONTEXT.pi))
            value += 2 * CONTEXT.pi * turns
        i, j = (end.index for end in measure.ends)
        constants = measure.constants(self.unit)
        self._records.append(
            RelativeCoordinate(name, measure.kind, i, j, constants, float(at_scene(start)))
        )
        self._values.append(value * self.unit_of(index)[1])
        if measure.is_turned:
            self._turned.add(index)
        return index

    def _measure(self, coordinate: Coordinate) -> PreciseMeasure:
        if coordinate.joint is not None:
            joint = self.scene.joints[coordinate.joint]
            return joint_measure(joint, sort_of(joint.type, coordinate.of), self.frames)
        if coordinate.bodies is not None:
            assert coordinate.points is not None
            i, j = (self.frames[body] for body in coordinate.bodies)
            start, end = map(precise.triple, coordinate.points)
            return PreciseMeasure("length", (i, j), points=(start, end))
        assert coordinate.body is not None
        assert coordinate.along is not None
        point = precise.triple(coordinate.point or (0.0, 0.0, 0.0))
        return place_measure(self.frames[coordinate.body], point, precise.triple(coordinate.along))

    def length(self) -> float:
        """Length of the scene that compares radians with metres, whatever its units [m].

        The largest distance, along an axis, of a point of a joint from the centre of mass of a
        body; where there is none, that of a body from the origin.
        """
        arms: list[float] = []
        for joint in self.scene.joints.values():
            kind = JOINTS.get(NAMES.get(joint.type, ""))
            if kind is None or not kind.has_point:
                continue
            ends = self.frames[joint.ends[0]], self.frames[joint.ends[1]]
            for end, point in zip(ends, joint_points(joint, ends), strict=True):
                arms += end.point(point, self.unit) if end.index >= 0 else ()
            if joint.length is not None:
                arms.append(float(self.unit * at_scene(precise.number(joint.length))))
        if any(arms):
            return max(map(abs, arms))
        frames = self.frames.values()
        positions = (self.unit * at_scene(x) for frame in frames for x in frame.position)
        return float(max(map(abs, positions))) or 1.0
