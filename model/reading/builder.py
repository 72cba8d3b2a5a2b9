"""Scenes from Python: the same tables as in a file, built by calls and checked the same way."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Self

from kousoku.model.errors import SceneError
from kousoku.model.reading.decode import decode
from kousoku.model.reading.of_sympy import is_of_sympy, plain_of
from kousoku.model.reading.read import scene_from_dict
from kousoku.model.records.dotted_keys import join
from kousoku.model.records.loads import Force
from kousoku.model.records.planar import Input, Link, Method, Node, Rigid, Slider
from kousoku.model.records.spatial import Body, Coordinate, Driver, Event, Joint

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from typing import Unpack

    import msgspec

    from kousoku.model.reading.keys import (
        BodyKeys,
        CoordinateKeys,
        DriverKeys,
        EventKeys,
        ForceKeys,
        JointKeys,
        MethodKeys,
        Numbers,
        Value,
    )
    from kousoku.model.records.own_kind import OwnKind
    from kousoku.model.records.scene import Output, Scene
    from kousoku.model.records.units import Unit

RECORDS: MappingProxyType[str, type[msgspec.Struct]] = MappingProxyType(
    {
        **{"nodes": Node, "links": Link, "rigid": Rigid, "sliders": Slider, "inputs": Input},
        **{"bodies": Body, "joints": Joint, "coordinates": Coordinate, "drivers": Driver},
        **{"forces": Force, "events": Event},
    }
)
"""Records of the elements of each table."""


class SceneBuilder:
    """Build a scene step by step.

    Each call takes the keys of an element, as a file has them, and refuses those that the element
    does not have, and values of another type. What relates elements to each other is checked by
    :meth:`build`. Expressions of SymPy stand for formulas, arrays of NumPy for lists.

    Parameters
    ----------
    name : str
        An identifier; names the package that is generated.
    unit : str
        Length unit of all that follows.
    title : str
        One line for people.
    duration : float [s], optional
        How long the mechanism moves unless a run says so.
    closure_tolerance : float, optional
        Rows of joints that others imply but for less, in lengths of the scene and rad, are
        redundant; 1e-4 when left out.
    divisions : int, optional
        Steps from the first to the last value of the inputs; 60 when left out.

    Examples
    --------
    >>> lever = (
    ...     SceneBuilder("lever", unit="cm")
    ...     .node("O1", at=(0, 0), fixed=True)
    ...     .node("O2", at=(30, 0))
    ...     .node("O3", at=(45, 58))
    ...     .node("O4", at=(100, 0), fixed=True)
    ...     .link("l1", "O1", "O2", length=30)
    ...     .link("l2", "O2", "O3", length=60)
    ...     .link("l3", "O3", "O4", length=80)
    ...     .input("alpha", link="l1", about="O1")
    ...     .build()
    ... )
    >>> lever.length("l3")
    80.0
    """

    def __init__(
        self,
        name: str,
        *,
        unit: Unit,
        title: str = "",
        duration: float | None = None,
        closure_tolerance: float | None = None,
        divisions: int | None = None,
    ) -> None:
        self._tree: dict[str, Any] = _plain(
            {
                "name": name,
                "title": title,
                "unit": unit,
                "duration": duration,
                "closure_tolerance": closure_tolerance,
                "divisions": divisions,
            }
        )

    def __repr__(self) -> str:
        tables = [table for table in self._tree if table in RECORDS]
        counts = [f"{len(self._tree[table])} in {table}" for table in tables]
        return f"<SceneBuilder {self._tree['name']}: {', '.join(counts) or 'nothing in it'}>"

    def node(self, name: str, *, at: Numbers, fixed: bool = False) -> Self:
        """Add a node at (2,) [unit of the scene]: :class:`kousoku.model.records.planar.Node`."""
        return self._add("nodes", name, at=at, fixed=fixed)

    def link(self, name: str, first: str, second: str, *, length: float | None = None) -> Self:
        """Add a link, see :class:`kousoku.model.records.planar.Link`."""
        return self._add("links", name, nodes=(first, second), length=length)

    def rigid(
        self, name: str, *, at: str, links: Sequence[str], angle: Value | None = None
    ) -> Self:
        """Connect links rigidly at a node, see :class:`kousoku.model.records.planar.Rigid`."""
        return self._add("rigid", name, at=at, links=links, angle=angle)

    def slider(self, name: str, *, node: str, through: Numbers, direction: Numbers) -> Self:
        """Let a node slide on a line, see :class:`kousoku.model.records.planar.Slider`."""
        return self._add("sliders", name, node=node, through=through, direction=direction)

    def input(
        self,
        name: str,
        *,
        link: str | None = None,
        about: str | None = None,
        slider: str | None = None,
        joint: str | None = None,
        start: Value = 0.0,
        to: Value | None = None,
        turns: float | None = None,
        rate: Value = 1.0,
        acceleration: Value = 0.0,
    ) -> Self:
        """Prescribe a motion, see :class:`kousoku.model.records.planar.Input`."""
        target = {"link": link, "about": about, "slider": slider, "joint": joint}
        values = {"from": start, "to": to, "turns": turns}
        return self._add("inputs", name, **target, **values, rate=rate, acceleration=acceleration)

    def body(self, name: str, **keys: Unpack[BodyKeys]) -> Self:
        """Add a body, see :class:`kousoku.model.records.spatial.Body`; its tables are dicts."""
        return self._add("bodies", name, **keys)

    def joint(self, name: str, **keys: Unpack[JointKeys]) -> Self:
        """Add a joint, see :class:`kousoku.model.records.spatial.Joint`."""
        return self._add("joints", name, **keys)

    def coordinate(self, name: str, **keys: Unpack[CoordinateKeys]) -> Self:
        """Name a coordinate, see :class:`kousoku.model.records.spatial.Coordinate`."""
        return self._add("coordinates", name, **keys)

    def driver(self, name: str, **keys: Unpack[DriverKeys]) -> Self:
        """Drive a coordinate or a point, see :class:`kousoku.model.records.spatial.Driver`."""
        return self._add("drivers", name, **keys)

    def parameter(self, name: str, value: Value) -> Self:
        """Name a number that formulas may use."""
        return self._put("parameters", name, value)

    def force(self, name: str, **keys: Unpack[ForceKeys]) -> Self:
        """Add a force, torque or spring, see :class:`kousoku.model.records.loads.Force`."""
        return self._add("forces", name, **keys)

    def event(self, name: str, **keys: Unpack[EventKeys]) -> Self:
        """Add an event, a zero of a formula, see :class:`kousoku.model.records.spatial.Event`."""
        return self._add("events", name, **keys)

    def gravity(self, x: Value, y: Value, z: Value) -> Self:
        """Set the acceleration of free fall, in frame O, in the unit of the scene per s².

        Components may be formulas of parameters.
        """
        self._tree["gravity"] = _plain([x, y, z])
        return self

    def outputs(self, *names: Output) -> Self:
        """Set the outputs beside positions, instead of the default."""
        self._tree["outputs"] = names
        return self

    def method(self, **keys: Unpack[MethodKeys]) -> Self:
        """Set the keys of :class:`kousoku.model.records.planar.Method`."""
        self._tree["method"] = _plain(keys)
        decode(self._tree["method"], Method, key="method")
        return self

    def build(self, *, kinds: Mapping[str, OwnKind] | None = None) -> Scene:
        """Checked scene.

        Parameters
        ----------
        kinds : mapping of str to OwnKind, optional
            Kinds of one's own that joints may be of, such as those of another scene;
            :func:`kousoku.load` gives those that it got.

        Raises
        ------
        SceneError
            As for a file, without the name of one.
        """
        return scene_from_dict(self._tree, kinds=kinds)

    def _add(self, table: str, name: str, **keys: Any) -> Self:
        return self._put(table, name, keys)

    def _put(self, table: str, name: str, value: Any) -> Self:
        elements = self._tree.setdefault(table, {})
        if name in elements:
            raise SceneError(f"the name {name!r} is given twice", key=join(table, name))
        plain = _plain(value)
        if table in RECORDS:
            decode(plain, RECORDS[table], key=join(table, name))
        elements[name] = plain
        return self


def _plain(value: Any) -> Any:
    """Turn NumPy's and SymPy's values into Python's, and leave out keys that are None."""
    if is_of_sympy(value):
        try:
            return plain_of(value)
        except ValueError as error:
            raise SceneError(str(error)) from None
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items() if item is not None}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return value.tolist() if hasattr(value, "tolist") else value
