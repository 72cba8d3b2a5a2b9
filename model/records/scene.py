"""The scene: a mechanism as its user describes it, in a file or in Python."""

# Annotations are evaluated: msgspec reads the types of a scene file from them.
from collections.abc import Mapping
from functools import partial
from math import atan2, hypot
from types import MappingProxyType
from typing import Literal, Self

import msgspec

from kousoku.model.records.design import CLOSURE_TOLERANCE, NumberOrAngle
from kousoku.model.records.loads import Force
from kousoku.model.records.own_kind import OwnKind
from kousoku.model.records.planar import Input, Link, Method, Node, Rigid, Slider
from kousoku.model.records.spatial import Body, Components, Coordinate, Driver, Event, Joint
from kousoku.model.records.units import Unit
from kousoku.model.text import counted

Output = Literal[
    "positions",
    "velocities",
    "accelerations",
    "angles",
    "coordinates",
    "reactions",
    "energies",
]

TABLES = (
    "nodes",
    "links",
    "rigid",
    "sliders",
    "bodies",
    "joints",
    "parameters",
    "coordinates",
    "drivers",
    "forces",
    "events",
    "inputs",
)
"""The tables of named elements; a name stands in one of them only."""


class Scene(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A mechanism and the motion that is asked for.

    Elements are kept by name in the order in which they were written. All lengths are in the unit
    of the scene, all angles in radians, counter-clockwise from +x. A scene that came from
    :func:`kousoku.model.reading.read.read_scene` or from the builder has passed
    :func:`kousoku.model.validation.validate.check`: names resolve, numbers are finite, and there
    are as many inputs as the linkage has degrees of freedom.

    Parameters
    ----------
    name : str
        An identifier; names the package that is generated.
    unit : str
        Length unit in which the scene is written and in which results are given.
    title : str
        One line for people.
    nodes, links, rigid, sliders : mapping of str to element
        The planar linkage.
    bodies, joints : mapping of str to element
        The spatial mechanism.
    parameters : mapping of str to float
        Numbers that formulas of a spatial mechanism may use, and that a run may change.
    coordinates : mapping of str to Coordinate
        Numbers with a name that say where bodies are; of a spatial mechanism only.
    drivers : mapping of str to Driver
        Coordinates and points as functions of time; of a spatial mechanism only.
    forces : mapping of str to Force
        Forces, torques and springs beside gravity; of a spatial mechanism only.
    events : mapping of str to Event
        Formulas that pass zero where something is recorded or counted, or a run ends; of a spatial
        mechanism only.
    gravity : (3,) [unit of the scene per s²]
        Acceleration of free fall, in frame O; of a spatial mechanism only. Components may be
        formulas of parameters.
    inputs : mapping of str to Input
        Prescribed motions; they all take their division k at the same time.
    duration : float [s], optional
        How long the mechanism moves unless a run says so.
    closure_tolerance : float [lengths of the scene, rad]
        Rows of joints that others imply but for less are redundant, of a spatial mechanism; above
        ten times that they are independent.
    divisions : int
        Steps from the first to the last value of the inputs: rows 0 … divisions are computed.
    outputs : tuple of str
        What is wanted beside positions: ``velocities``, ``accelerations``, the ``angles`` of links,
        and of a spatial mechanism the ``coordinates``, the ``reactions`` of joints and the
        ``energies``.
    method : Method
        How positions are found.
    kinds : mapping of str to OwnKind
        Kinds of one's own that are types of its joints; :func:`kousoku.load` takes them.
    """

    name: str
    unit: Unit
    title: str = ""
    nodes: Mapping[str, Node] = {}
    links: Mapping[str, Link] = {}
    rigid: Mapping[str, Rigid] = {}
    sliders: Mapping[str, Slider] = {}
    bodies: Mapping[str, Body] = {}
    joints: Mapping[str, Joint] = {}
    parameters: Mapping[str, NumberOrAngle] = {}
    coordinates: Mapping[str, Coordinate] = {}
    drivers: Mapping[str, Driver] = {}
    forces: Mapping[str, Force] = {}
    events: Mapping[str, Event] = {}
    gravity: Components = (0.0, 0.0, 0.0)
    inputs: Mapping[str, Input] = {}
    duration: float | None = None
    closure_tolerance: float = CLOSURE_TOLERANCE
    divisions: int = 60
    outputs: tuple[Output, ...] = ("positions", "velocities", "accelerations")
    method: Method = Method()
    kinds: Mapping[str, OwnKind] = {}

    def __post_init__(self) -> None:
        for table in TABLES:
            frozen = MappingProxyType(dict(getattr(self, table)))
            msgspec.structs.force_setattr(self, table, frozen)

    def __repr__(self) -> str:
        of_linkages = ("nodes", "links", "sliders", "inputs")
        tables = ("bodies", "joints", "drivers", "forces", "events", *of_linkages)
        counts = {table: len(getattr(self, table)) for table in tables}
        nouns = {table: table[:-1] for table in tables} | {"bodies": "body"}
        shown = [counted(count, nouns[table], table) for table, count in counts.items() if count]
        return f"<Scene {self.name}: {', '.join(shown) or 'nothing in it'}>"

    def __reduce__(self) -> tuple[partial[Self], tuple[()]]:
        """Pickle of a scene: tables as dictionaries."""
        values = {name: getattr(self, name) for name in self.__struct_fields__}
        return partial(type(self), **values | {name: dict(values[name]) for name in TABLES}), ()

    @property
    def is_spatial(self) -> bool:
        """Whether the scene is of bodies, in a plane or not; else it is of nodes and links."""
        return bool(self.bodies or self.joints)

    def length(self, link: str) -> float:
        """Design length of a link [unit of the scene], |r₂ − r₁| of its nodes unless given."""
        length = self.links[link].length
        if length is not None:
            return length
        first, second = (self.nodes[node].at for node in self.links[link].nodes)
        return hypot(second[0] - first[0], second[1] - first[1])

    def rigid_angle(self, connection: str, link: str) -> float:
        """Angle [rad] from the first link of a rigid connection to `link`, in the plane.

        Both links are seen from the shared node; the angle is counter-clockwise, and is taken from
        the positions of the nodes unless the connection gives it.
        """
        rigid = self.rigid[connection]
        if rigid.angle is not None and link == rigid.links[1]:
            return rigid.angle
        return self._direction(link, rigid.at) - self._direction(rigid.links[0], rigid.at)

    def _direction(self, link: str, node: str) -> float:
        origin, end = self.nodes[node].at, self.nodes[self.links[link].other(node)].at
        return atan2(end[1] - origin[1], end[0] - origin[0])

    def is_ground(self, link: str) -> bool:
        """Whether both ends of a link are fixed: it is part of the frame and never moves."""
        return all(self.nodes[node].fixed for node in self.links[link].nodes)

    @property
    def largest_length(self) -> float:
        """Largest length L of the links [unit of the scene]; accuracies are relative to it."""
        return max((self.length(link) for link in self.links), default=0.0)

    @property
    def largest_coordinate(self) -> float:
        """Largest coordinate of the frame [unit of the scene]: fixed nodes, points of sliders."""
        points = [node.at for node in self.nodes.values() if node.fixed]
        points += [slider.through for slider in self.sliders.values()]
        return max((abs(component) for point in points for component in point), default=0.0)

    @property
    def default_residual(self) -> float:
        """Limit of the residual when none is given [unit of the scene]: 8·2⁻⁵² times the length L.

        Far from the origin it is the last digit of the largest coordinate, where that is coarser.
        """
        return 2.0**-52 * max(8 * self.largest_length, self.largest_coordinate)

    @property
    def residual_limit(self) -> float:
        """Limit of the residual that the scene asks for [unit of the scene]."""
        residual = self.method.residual
        return self.default_residual if residual is None else residual
