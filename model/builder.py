"""Scenes from Python: the same tables as in a file, built by calls and checked the same way."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Self

from kousoku.model.errors import SceneError
from kousoku.model.read import scene_from_dict

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from kousoku.model.scene import Scene
    from kousoku.model.spatial import Value

    Coordinates = Sequence[float] | NDArray[Any]


class SceneBuilder:
    """Build a scene step by step; nothing is checked but names given twice, until :meth:`build`.

    Parameters
    ----------
    name : str
        An identifier; names the package that is generated.
    unit : str
        Length unit of all that follows.
    title : str
        One line for people.
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
        self, name: str, *, unit: str, title: str = "", divisions: int | None = None
    ) -> None:
        self._tree: dict[str, Any] = _plain(
            {"name": name, "title": title, "unit": unit, "divisions": divisions}
        )

    def node(self, name: str, *, at: Coordinates, fixed: bool = False) -> Self:
        """Add a node, see :class:`kousoku.model.planar.Node`."""
        return self._add("nodes", name, at=at, fixed=fixed)

    def link(self, name: str, first: str, second: str, *, length: float | None = None) -> Self:
        """Add a link, see :class:`kousoku.model.planar.Link`."""
        return self._add("links", name, nodes=(first, second), length=length)

    def rigid(
        self, name: str, *, at: str, links: Sequence[str], angle: Value | None = None
    ) -> Self:
        """Connect links rigidly at a node, see :class:`kousoku.model.planar.Rigid`."""
        return self._add("rigid", name, at=at, links=links, angle=angle)

    def slider(self, name: str, *, node: str, through: Coordinates, direction: Coordinates) -> Self:
        """Let a node slide on a line, see :class:`kousoku.model.planar.Slider`."""
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
        """Prescribe a motion, see :class:`kousoku.model.planar.Input`."""
        target = {"link": link, "about": about, "slider": slider, "joint": joint}
        way = {"from": start, "to": to, "turns": turns}
        return self._add("inputs", name, **target, **way, rate=rate, acceleration=acceleration)

    def body(self, name: str, **keys: Any) -> Self:
        """Add a body with the keys of :class:`kousoku.model.spatial.Body`, tables as dicts."""
        return self._add("bodies", name, **keys)

    def joint(self, name: str, **keys: Any) -> Self:
        """Add a joint with the keys of :class:`kousoku.model.spatial.Joint`."""
        return self._add("joints", name, **keys)

    def coordinate(self, name: str, **keys: Any) -> Self:
        """Name a coordinate with the keys of :class:`kousoku.model.spatial.Coordinate`."""
        return self._add("coordinates", name, **keys)

    def driver(self, name: str, **keys: Any) -> Self:
        """Drive a coordinate or a point with the keys of :class:`kousoku.model.spatial.Driver`."""
        return self._add("drivers", name, **keys)

    def parameter(self, name: str, value: Value) -> Self:
        """Name a number that formulas may use."""
        return self._put("parameters", name, value)

    def force(self, name: str, **keys: Any) -> Self:
        """Add a force, torque or spring with the keys of :class:`kousoku.model.loads.Force`."""
        return self._add("forces", name, **keys)

    def gravity(self, x: float | str, y: float | str, z: float | str) -> Self:
        """Set the acceleration of free fall, in frame O, in the unit of the scene per s².

        Components may be formulas of parameters.
        """
        self._tree["gravity"] = _plain([x, y, z])
        return self

    def outputs(self, *names: str) -> Self:
        """Say what is wanted beside positions, instead of the default."""
        self._tree["outputs"] = names
        return self

    def method(self, **keys: Any) -> Self:
        """Set the keys of :class:`kousoku.model.planar.Method`."""
        self._tree["method"] = _plain(keys)
        return self

    def build(self) -> Scene:
        """Return the checked scene.

        Raises
        ------
        SceneError
            As for a file, without the name of one.
        """
        return scene_from_dict(self._tree)

    def _add(self, table: str, name: str, **keys: Any) -> Self:
        return self._put(table, name, keys)

    def _put(self, table: str, name: str, value: Any) -> Self:
        elements = self._tree.setdefault(table, {})
        if name in elements:
            raise SceneError(f"the name {name!r} is given twice", key=f"{table}.{name}")
        elements[name] = _plain(value)
        return self


def _plain(value: Any) -> Any:
    """Turn NumPy numbers and arrays into Python's, and leave out keys that are None."""
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items() if item is not None}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return value.tolist() if hasattr(value, "tolist") else value
