"""Assembly of a linkage: numbered coordinates, link elements between them, known and unknown parts.

This is section 2 of Yamada and Tatsumi (1981): each link has the coordinates x1 y1 β1 x2 y2 β2 of
its ends (1), links share the coordinates of the nodes they meet at, rotations too where the
connection is rigid (17), and the coordinates part into unknown and known ones (18), (19).
"""

from __future__ import annotations

import enum
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING

from kousoku.codegen.linkage.rotations import direction, merge_rotations
from kousoku.model.numbers.directions import HALF_TURN, unit_vector
from kousoku.model.validation.validate import require_planar

if TYPE_CHECKING:
    from kousoku.codegen.linkage.rotations import NodeRotation
    from kousoku.model.records.scene import Scene


class Role(enum.Enum):
    """The parts of (18) and (19); constants are apart from prescribed coordinates."""

    FIXED = "fixed"
    INPUT = "input"
    UNKNOWN = "unknown"


@dataclass(frozen=True, slots=True)
class LinkageCoordinate:
    """One number of the vector x.

    Parameters
    ----------
    name : str
        ``O2.x``, ``l1@O2`` for the rotation of l1 at O2, or the name of a slider or an input.
    unit : str
        Unit of the scene, or ``rad``.
    role : Role
        Fixed, prescribed or unknown.
    start : Fraction
        Its value where it is fixed, else near its value at division 0.
    scale : Fraction [unit of the scene]
        Displacement by a change of 1: 1 for a length, the length of the link for a rotation.
    """

    name: str
    unit: str
    role: Role
    start: Fraction
    scale: Fraction


@dataclass(frozen=True, slots=True)
class Affine:
    """One of the six numbers of a link's ends: offset + factor · coordinate."""

    coordinate: int
    factor: Fraction = Fraction(1)
    offset: Fraction = Fraction(0)


@dataclass(frozen=True, slots=True)
class LinkElement:
    """Link with its coordinates in the assembly; Yamada and Tatsumi (1981).

    Parameters
    ----------
    name : str
        The link.
    nodes : (str, str)
        Its first and second node; where a rotation is shared or prescribed at one end only, that
        end comes first.
    length : Fraction [unit of the scene]
        Design length l0, (8).
    ends : (6,) of Affine [unit of the scene, rad]
        x1 y1 β1 x2 y2 β2, frame O, (1).
    rows : tuple of int
        Indices of those of ε1, ε2, ε3, (5) to (7), that must vanish; all but those that a link of
        the frame fulfils by itself.
    """

    name: str
    nodes: tuple[str, str]
    length: Fraction
    ends: tuple[Affine, Affine, Affine, Affine, Affine, Affine]
    rows: tuple[int, ...] = (0, 1, 2)


@dataclass(frozen=True, slots=True)
class Assembly:
    """Linkage whose links share coordinates, as in the assembly of finite elements.

    Its position is computed later, by the assembly of a run (``runtime/kinematics/assembly``).

    Parameters
    ----------
    scene : Scene
        Scene of the linkage.
    coordinates : tuple of LinkageCoordinate
        Node positions in the order of the nodes, then sliders, then rotations.
    nodes : tuple of (str, Affine, Affine)
        Name, x and y of each node, in the order of the scene.
    elements : tuple of LinkElement
        The links, in the order of the scene.
    inputs : tuple of int
        The prescribed coordinates, in the order of the scene's inputs.
    notes : tuple of str
        Notes on merged and dropped coordinates and links, one sentence each.
    """

    scene: Scene
    coordinates: tuple[LinkageCoordinate, ...]
    nodes: tuple[tuple[str, Affine, Affine], ...]
    elements: tuple[LinkElement, ...]
    inputs: tuple[int, ...]
    notes: tuple[str, ...]


def assemble(scene: Scene) -> Assembly:
    """Assembly of a scene.

    Raises
    ------
    SceneError
        The scene has bodies.
    """
    require_planar(scene)
    return _Assembler(scene).assembly()


class _Assembler:
    """Assembler of one linkage, with lists that grow."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.coordinates: list[LinkageCoordinate] = []
        self.notes: list[str] = []
        self.prescribed: dict[str, int] = {}
        self.nodes: dict[str, tuple[Affine, Affine]] = {}
        self.ends: dict[tuple[str, str], Affine] = {}
        self.active: set[tuple[str, str]] = set()

    def assembly(self) -> Assembly:
        sliding = {slider.node: name for name, slider in self.scene.sliders.items()}
        for name in self.scene.nodes:
            self.nodes[name] = self._slider(sliding[name]) if name in sliding else self._node(name)
        for rotation in merge_rotations(self.scene, self.notes):
            self._rotation(rotation)
        elements = [self._element(link) for link in self.scene.links]
        return Assembly(
            scene=self.scene,
            coordinates=tuple(self.coordinates),
            nodes=tuple((name, x, y) for name, (x, y) in self.nodes.items()),
            elements=tuple(element for element in elements if element.rows),
            inputs=tuple(self.prescribed[name] for name in self.scene.inputs),
            notes=tuple(self.notes),
        )

    def _add(self, name: str, role: Role, start: Fraction, length: Fraction | None = None) -> int:
        unit, scale = (self.scene.unit, Fraction(1)) if length is None else ("rad", length)
        self.coordinates.append(LinkageCoordinate(name, unit, role, start, scale))
        return len(self.coordinates) - 1

    def _node(self, name: str) -> tuple[Affine, Affine]:
        node = self.scene.nodes[name]
        role = Role.FIXED if node.fixed else Role.UNKNOWN
        x, y = (
            self._add(f"{name}.{axis}", role, Fraction(at))
            for axis, at in zip("xy", node.at, strict=True)
        )
        return Affine(x), Affine(y)

    def _slider(self, name: str) -> tuple[Affine, Affine]:
        """Coordinates of a node on its line: node = through + s · direction."""
        slider = self.scene.sliders[name]
        through = tuple(map(Fraction, slider.through))
        at = map(Fraction, self.scene.nodes[slider.node].at)
        axis = unit_vector(*map(Fraction, slider.direction))
        start = sum((a - t) * d for a, t, d in zip(at, through, axis, strict=True)) or Fraction(0)
        keys = [key for key, item in self.scene.inputs.items() if item.slider == name]
        for key in keys:
            start = Fraction(self.scene.inputs[key].start)
            self.prescribed[key] = len(self.coordinates)
        s = self._add(name, Role.INPUT if keys else Role.UNKNOWN, start)
        self.notes.append(f"{slider.node}.x and {slider.node}.y merged: slider {name}")
        x, y = (Affine(s, d, t) for d, t in zip(axis, through, strict=True))
        return x, y

    def _rotation(self, rotation: NodeRotation) -> None:
        """Add a rotation, and the headings of its links from the node."""
        first, node = rotation.links[0], rotation.node
        start, name, role = direction(self.scene, first, node), f"{first}@{node}", Role.UNKNOWN
        if rotation.input:
            start = Fraction(self.scene.inputs[rotation.input].start)
            name, role = rotation.input, Role.INPUT
            self.prescribed[rotation.input] = len(self.coordinates)
        number = self._add(name, role, start, Fraction(self.scene.length(first)))
        for link, angle in zip(rotation.links, rotation.angles, strict=True):
            self.ends[link, node] = Affine(number, offset=angle)
            if rotation.input or len(rotation.links) > 1:
                self.active.add((link, node))

    def _element(self, name: str) -> LinkElement:
        link = self.scene.links[name]
        first, second = link.nodes
        if (name, second) in self.active and (name, first) not in self.active:
            first, second = second, first
        rows: tuple[int, ...] = (0, 1, 2)
        if self.scene.is_ground(name):
            ends = ((1, first), (2, second))
            rows = tuple(row for row, node in ends if (name, node) in self.active)
            if not rows:
                self.notes.append(f"{name} dropped: both of its nodes are fixed")
        heading = self.ends.get((name, second), Affine(0))
        beta2 = Affine(heading.coordinate, heading.factor, heading.offset - HALF_TURN)
        (x1, y1), (x2, y2) = self.nodes[first], self.nodes[second]
        coordinates = (x1, y1, self.ends.get((name, first), Affine(0)), x2, y2, beta2)
        length = Fraction(self.scene.length(name))
        return LinkElement(name, (first, second), length, coordinates, rows)
