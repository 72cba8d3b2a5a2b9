"""Meshes of which the picture of a mechanism is made: boxes, cylinders, balls, pedestals.

A mesh stands in units of its own, between -1 and 1; a body places it by a matrix. Long ones are cut
along their length, since the painter's algorithm sorts faces by their middles.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from itertools import pairwise

import numpy as np

Vertex = tuple[float, float, float]

SIDES = 16
"""Faces around a cylinder."""

TONE = 1.0
"""How much darker the dark sectors of a disc are; without them nobody sees that it turns."""


@dataclass(frozen=True, slots=True)
class Mesh:
    """A closed surface.

    Parameters
    ----------
    vertices : tuple of (3,)
        Corners, in the units of the mesh.
    faces : tuple of tuple of int
        Corners of each face, counter-clockwise seen from outside.
    edges : tuple of int
        Which sides of each face are drawn: bit k is the side from corner k to the next one.
    tones : tuple of float
        Which faces are darker.
    """

    vertices: tuple[Vertex, ...]
    faces: tuple[tuple[int, ...], ...]
    edges: tuple[int, ...]
    tones: tuple[float, ...]


@cache
def mesh_of(name: str) -> Mesh:
    """Mesh by its name: ``box 3 1 1``, ``cylinder 4``, ``disc``, ``ball``, ``pedestal``.

    The numbers say into how many pieces it is cut; a cylinder may have a second one, its sides.
    """
    kind, *numbers = name.split()
    cuts = [int(number) for number in numbers]
    match kind:
        case "box":
            return _box(cuts[0], cuts[1], cuts[2])
        case "cylinder":
            return _cylinder(cuts[0], cuts[1] if cuts[1:] else SIDES)
        case "disc":
            return _disc()
        case "ball":
            return _ball()
        case _:
            return _pedestal()


def box_name(x: int, y: int, z: int) -> str:
    """Name of a box, by its pieces along three edges."""
    return f"box {x} {y} {z}"


def cylinder_name(pieces: int) -> str:
    """Name of a cylinder along z, by its pieces."""
    return f"cylinder {pieces}"


def coarse(name: str, sides: int) -> str:
    """Name of a cylinder with other sides and half its pieces; other names are kept."""
    kind, *cuts = name.split()
    return f"{kind} {-(-int(cuts[0]) // 2)} {sides}" if sides and kind == "cylinder" else name


class _Draft:
    """A mesh while it is made; equal vertices are one."""

    def __init__(self) -> None:
        self._indices: dict[Vertex, int] = {}
        self._faces: list[tuple[int, ...]] = []
        self._edges: list[int] = []
        self._tones: list[float] = []

    def add(self, corners: list[Vertex], edges: int = 0, tone: float = 0.0) -> None:
        rounded = [(round(x, 4) + 0.0, round(y, 4) + 0.0, round(z, 4) + 0.0) for x, y, z in corners]
        self._faces.append(tuple(self._indices.setdefault(v, len(self._indices)) for v in rounded))
        self._edges.append(edges)
        self._tones.append(tone)

    def mesh(self) -> Mesh:
        return Mesh(
            tuple(self._indices), tuple(self._faces), tuple(self._edges), tuple(self._tones)
        )


def _box(*cuts: int) -> Mesh:
    draft = _Draft()
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for side in (-1.0, 1.0):
            for a, b in np.ndindex(cuts[u], cuts[v]):
                low = (2.0 * a / cuts[u] - 1.0, 2.0 * b / cuts[v] - 1.0)
                high = (2.0 * (a + 1) / cuts[u] - 1.0, 2.0 * (b + 1) / cuts[v] - 1.0)
                ring = [low, (high[0], low[1]), high, (low[0], high[1])]
                sides = [b == 0, a == cuts[u] - 1, b == cuts[v] - 1, a == 0]
                if side < 0:
                    ring, sides = ring[::-1], [sides[k] for k in (2, 1, 0, 3)]
                corners = []
                for first, second in ring:
                    corner = [0.0, 0.0, 0.0]
                    corner[axis], corner[u], corner[v] = side, first, second
                    corners.append((corner[0], corner[1], corner[2]))
                draft.add(corners, sum(1 << k for k, is_drawn in enumerate(sides) if is_drawn))
    return draft.mesh()


def _ring(z: float, radius: float, sides: int) -> list[Vertex]:
    angles = (2.0 * np.pi * np.arange(sides) / sides).tolist()
    return [(float(radius * np.cos(a)), float(radius * np.sin(a)), z) for a in angles]


def _cylinder(pieces: int, sides: int) -> Mesh:
    draft = _Draft()
    _add_mantle(draft, pieces, sides)
    for z in (-1.0, 1.0):
        draft.add(_ring(z, 1.0, sides)[:: int(z)], (1 << sides) - 1)
    return draft.mesh()


def _disc() -> Mesh:
    draft = _Draft()
    sides = 2 * SIDES
    quarter = sides // 4
    _add_mantle(draft, 1, sides)
    for z in (-1.0, 1.0):
        ring = _ring(z, 1.0, sides)[:: int(z)]
        for k in range(4):
            sector = [ring[(k * quarter + n) % sides] for n in range(quarter + 1)]
            draft.add([*sector, (0.0, 0.0, z)], (1 << quarter) - 1, TONE if k % 2 else 0.0)
    return draft.mesh()


def _add_mantle(draft: _Draft, pieces: int, sides: int) -> None:
    for piece in range(pieces):
        low, high = (_ring(2.0 * k / pieces - 1.0, 1.0, sides) for k in (piece, piece + 1))
        for k in range(sides):
            after = (k + 1) % sides
            draft.add([low[k], low[after], high[after], high[k]])


def _ball() -> Mesh:
    draft = _Draft()
    rings = 8
    heights = [-np.pi / 2 + np.pi * k / rings for k in range(rings + 1)]
    circles = [_ring(float(np.sin(h)), float(np.cos(h)), 14) for h in heights]
    for below, above in pairwise(circles):
        for k in range(14):
            after = (k + 1) % 14
            corners = [below[k], below[after], above[after], above[k]]
            if below is circles[0]:
                corners = corners[1:]
            elif above is circles[-1]:
                corners = corners[:3]
            draft.add(corners)
    return draft.mesh()


def _pedestal() -> Mesh:
    """Sign of the ground: a wedge along z with its tip at the origin, on a plate."""
    draft = _Draft()
    tip, foot = (0.25, 0.0), (0.8, -1.0)
    outline = [(-tip[0], tip[1]), (-foot[0], foot[1]), (foot[0], foot[1]), (tip[0], tip[1])]
    _extrude(draft, outline, 0.6)
    plate = [(-1.0, -1.0), (-1.0, -1.25), (1.0, -1.25), (1.0, -1.0)]
    _extrude(draft, plate, 0.9)
    return draft.mesh()


def _extrude(draft: _Draft, outline: list[tuple[float, float]], half: float) -> None:
    """Add a prism along z over a polygon that runs counter-clockwise."""
    near = [(x, y, half) for x, y in outline]
    far = [(x, y, -half) for x, y in outline]
    everything = (1 << len(outline)) - 1
    draft.add(near, everything)
    draft.add(far[::-1], everything)
    for k in range(len(outline)):
        after = (k + 1) % len(outline)
        draft.add([near[k], far[k], far[after], near[after]], 15)
