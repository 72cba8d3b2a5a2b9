"""The draft of a random scene: bodies are placed first, and joints written from where they are.

So loops close by construction. All choices are drawn from one ``random.Random``, the simplest for
the smallest draws, so that Hypothesis can drive and shrink a scene. A scene that has a number takes
its first choice from each table by that number, so that fifty scenes together have all of them.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, TypeVar

from kousoku.model.elements.joints import JOINTS, NAMES, free_coordinates_of
from tests.random_bodies import MASSES, ORIENTATIONS, STARTS
from tests.random_geometry import DIRECTIONS, Pose, across

if TYPE_CHECKING:
    import random
    from collections.abc import Callable, Sequence

    from tests.random_geometry import Vector

Tree = dict[str, Any]
T = TypeVar("T")

KINDS = ("tree", "mechanism", "tree", "mechanism", "driven")
"""What scenes are in turn: any joints, closed loops, motions that drivers determine."""

UNITS = {"m": 1.0, "mm": 1e3, "cm": 100.0, "dm": 10.0, "in": 40.0, "ft": 3.0, "um": 1e6, "km": 1e-3}
"""Units of length, and about how many of them a metre has."""

PLACES = (0.0, 0.25, -0.25, 0.5, -0.5, 0.75, -0.75, 1.0, -1.0)
FORMULAS: dict[str, Callable[[float], float]] = {
    "{}": lambda value: value,
    "2*{}": lambda value: value / 2,
    "{}/4": lambda value: 4 * value,
    "{} - 1": lambda value: value + 1,
    "-(3 - {})": lambda value: value + 3,
}
"""Formulas of one parameter, and the parameter that gives a value."""

LOADS = (
    *("2", "sin(3*t)", "{p}*exp(-t)", "-0.2*{u}_dot", "1 - {u}", "min(1, abs({u}_dot))*cos(t)"),
    *("atan2({u}, 2) + max(t, 0.1)^2", "-{p}*sign({u}_dot)*sqrt(abs({u}))"),
)
"""Formulas of what may depend on the motion."""

LAWS = ("0.3*sin(2*t)", "0.2*t", "{p}*t", "0.1*(1 - cos(3*t))", "0.4*atan({p}*t)", "0.1*t^2 + 0.05")
"""Formulas of what is driven, beside its value at the start."""


class Draft:
    """A scene that is being made.

    Parameters
    ----------
    draw : random.Random
        What chooses.
    number : int, optional
        Which of the scenes it is that have everything together; any scene when left out.
    """

    def __init__(self, draw: random.Random, number: int | None = None) -> None:
        self.draw = draw
        self.turn: int | None = None
        if number is not None:
            rounds, place = divmod(number, len(KINDS))
            same = [k for k, kind in enumerate(KINDS) if kind == KINDS[place]]
            self.turn = rounds * len(same) + same.index(place)
        self.kind: str = draw.choice(KINDS) if number is None else KINDS[number % len(KINDS)]
        self.calls: dict[str, int] = {}
        unit = self.pick("unit", [*UNITS])
        self.metre: float = UNITS[unit]
        self.tree: Tree = {"name": f"random_{number or 0}", "unit": unit}
        self.poses = {"ground": Pose()}
        self.points: list[str] = []
        self.is_parametric: bool = self.pick("parametric", (False, True))
        self.is_written_off: bool = self.pick("written off", (False, False, False, True))
        self.may_be_massless = False

    def pick(self, table: str, options: Sequence[T], each: int = 1, every: int = 1) -> T:
        """Option of some: by the number of the scene first, and then drawn.

        Parameters
        ----------
        table : str
            What the options are of.
        options : sequence
            The simplest first.
        each : int
            How often a scene takes its turn.
        every : int
            How many scenes of its kind lie from turn to turn.
        """
        call = self.calls[table] = self.calls.get(table, -1) + 1
        if self.turn is None or call >= each:
            return options[self.draw.randrange(len(options))]
        return options[(self.turn // every * each + call) % len(options)]

    def number(self, low: float, high: float) -> float:
        """Number of 17 ones, the simplest is the lowest."""
        return low + self.draw.randrange(17) * (high - low) / 16

    def vector(self, size: float = 1.0) -> Vector:
        """Vector, the simplest is zero."""
        x, y, z = (size * self.draw.choice(PLACES) for _ in range(3))
        return (x, y, z)

    def length(self, low: float, high: float) -> float:
        """Length in the unit of the scene of so many metres."""
        return self.metre * self.number(low, high)

    def place(self) -> Vector:
        """Point within a metre of frame O."""
        return self.vector(self.metre)

    def parameter(self, value: float) -> str:
        """Name of a new parameter."""
        parameters = self.table("parameters")
        name = f"p{len(parameters)}"
        parameters[name] = value
        return name

    def design(self, value: float) -> float | str:
        """Number, or in some scenes a formula of a parameter."""
        if not self.is_parametric or self.draw.randrange(3) < 2:
            return value
        return self.formula(value)

    def formula(self, value: float) -> str:
        """Formula of a parameter with this value."""
        text = self.pick("formula", [*FORMULAS])
        return text.format(self.parameter(FORMULAS[text](value)))

    def designs(self, values: Vector) -> list[float | str]:
        """Vector whose components may be formulas."""
        return [self.design(value) for value in values]

    def table(self, name: str) -> Tree:
        """Table of the scene."""
        made: Tree = self.tree.setdefault(name, {})
        return made

    def add(self, table: str, entry: Tree) -> str:
        """Add an element, and return its name."""
        elements = self.table(table)
        name = f"{table.rstrip('s')}_{len(elements)}".replace("bodie_", "body_")
        elements[name] = entry
        return name

    def body(self, r: Vector, *, form: str = "", is_point: bool = False) -> str:
        """Add a body, and return its name; its mass and its orientation are in any form."""
        entry: Tree = {"position": list(r)}
        A = Pose().A
        if is_point:
            entry |= {"point": True, "mass": self.design(self.number(0.5, 2))}
        else:
            orientation, A = ORIENTATIONS[form or self.pick("orientation", [*ORIENTATIONS])](self)
            entry |= {"orientation": orientation} if orientation else {}
            form = self.pick("mass", [*MASSES])
            entry |= {} if self.may_be_massless else MASSES[form](self)
            entry |= self.pick("start", STARTS)(self)
        name = self.add("bodies", entry)
        self.poses[name] = Pose(r, A)
        if is_point:
            self.points.append(name)
        return name

    def rigid(self) -> str:
        """Body that turns; there is one at least."""
        bodies = [name for name in self.poses if name not in ("ground", *self.points)]
        return self.draw.choice(bodies) if bodies else self.body(self.place())

    def join(self, name: str, i: str, j: str, at: Vector, axis: Vector = (0, 0, 1)) -> str:
        """Add a joint where its bodies are, and return its name.

        Parameters
        ----------
        name : str
            A type of joint, or an alias of one.
        i, j : str
            Its bodies.
        at, axis : (3,)
            Its point and its axis in frame O; for a rod the point of body i.
        """
        kind, ends = JOINTS[NAMES[name]], (self.poses[i], self.poses[j])
        entry: Tree = {"type": name, "bodies": [i, j]}
        in_bodies = self.is_written_off or self.pick("frames", (False, True))
        if NAMES[name] == "rod":
            entry |= self._rod(ends, at, is_point=j in self.points)
        elif kind.has_point and in_bodies:
            own = [self.designs(ends[0].point(at)), list(ends[1].point(at))]
            entry["points"] = [[0, 0, 0] if j in self.points and k else own[k] for k in range(2)]
        elif kind.has_point:
            entry["at"] = self.designs(at)
        entry |= self._axes(NAMES[name], ends, axis, in_bodies=in_bodies)
        if kind.keys:
            entry["pitch"] = self.design(self.length(0.1, -0.4) or self.metre)
        return self.add("joints", entry)

    def _rod(self, ends: tuple[Pose, Pose], at: Vector, *, is_point: bool) -> Tree:
        """Points of a rod, and its length or none; no rod is as short as a point."""
        far = ends[1].place((0, 0, 0) if is_point else self.vector(self.metre / 4))
        length = math.dist(far, at)
        if length < 0.01 * self.metre:
            at, length = (at[0] + self.metre, at[1], at[2]), 0.0
        points = {"points": [list(ends[0].point(at)), list(ends[1].point(far))]}
        has_length = length and self.draw.randrange(2)
        return points | ({"length": self.design(length)} if has_length else {})

    def _axes(self, name: str, ends: tuple[Pose, Pose], axis: Vector, *, in_bodies: bool) -> Tree:
        """Axes of a joint, and its directions across them, where it has some."""
        kind, is_cv = JOINTS[name], name == "constant_velocity"
        has_zero = kind.has_zero and not is_cv
        has_zero = has_zero and (kind.counts_along_zero or self.pick("zero", (False, True)))
        if not (kind.axes or has_zero):
            return {}
        second = across(axis) if kind.axes == 2 and not is_cv else axis
        zero = (second, axis) if kind.axes == 2 else (across(axis), across(axis))
        if in_bodies:
            axes: Tree = {"axes": [list(ends[0].vector(axis)), list(ends[1].vector(second))]}
        else:
            is_free = self.kind == "tree" and kind.axes == 1 and not has_zero
            axes = {"axis": self.designs(axis) if is_free else list(axis)}
            axes |= {"second_axis": list(second)} if kind.axes == 2 else {}
        if has_zero:
            axes["zero"] = [list(end.vector(a)) for end, a in zip(ends, zero, strict=True)]
        return axes

    def free(self, sorts: tuple[str, ...]) -> tuple[str, str]:
        """Joint that leaves a coordinate free, and which; a new one if there is none."""
        joints = self.table("joints").items()
        found = [
            (name, sort)
            for name, joint in joints
            for sort in free_coordinates_of(joint["type"])
            if sort in sorts and (sort != "displacement" or self._counts(joint))
        ]
        if found:
            return self.draw.choice(found)
        kind = "revolute" if "angle" in sorts else "prismatic"
        return self.hang(kind), free_coordinates_of(kind)[0]

    @staticmethod
    def _counts(joint: Tree) -> bool:
        """Whether a joint says along which direction its displacement counts."""
        return "zero" in joint or "second_displacement" not in free_coordinates_of(joint["type"])

    def hang(self, kind: str) -> str:
        """Add a body on the ground, and return its joint."""
        at = self.place()
        body = self.body((at[0] + self.metre / 2, at[1], at[2] - self.metre / 4))
        return self.join(kind, "ground", body, at, self.draw.choice(DIRECTIONS))

    def type_of(self, joint: str) -> str:
        """Type of a joint, as it is written."""
        return str(self.table("joints")[joint]["type"])

    def leaf(self, joint: str, of: str) -> Tree:
        """Keys that mean what a joint leaves free."""
        return {"joint": joint} | (
            {"of": of} if len(free_coordinates_of(self.type_of(joint))) > 1 else {}
        )

    def coordinate(self, sorts: tuple[str, ...] = ("angle", "displacement")) -> str:
        """Add a coordinate of a joint, or find it, and return its name."""
        joint, of = self.free(sorts)
        for name, given in self.table("coordinates").items():
            if (given.get("joint"), given.get("of", of)) == (joint, of):
                return str(name)
        return self.add("coordinates", self.leaf(joint, of))

    def load(self, size: float) -> str:
        """Formula of a force or torque of so many units, about."""
        text = self.pick("load", LOADS, each=2)
        u = self.coordinate(("angle", "second_angle")) if "{u}" in text else ""
        p = self.parameter(0.5) if "{p}" in text else ""
        return f"{size:g}*({text.format(u=u, p=p)})"

    def law(self, start: float, size: float = 1.0) -> str:
        """Formula of a driver that starts near a value."""
        text = self.pick("law", LAWS)
        return f"{start!r} + {size:g}*({text.format(p=self.parameter(1.5) if 'p' in text else '')})"

    def write_off(self) -> None:
        """Write bodies a little off in some scenes, so that assembly has to bring them together."""
        for body in self.table("bodies").values() if self.is_written_off else ():
            body["position"] = [x + 0.01 * self.metre for x in body["position"][:1]] + body[
                "position"
            ][1:]
