"""Stills of a mechanism, and pictures that move by themselves, as SVG: made without a browser.

What :mod:`kousoku.view.page` draws on a canvas is drawn here as paths: the same shapes, light and
camera, without shadows, arrows of forces and what only a screen can do. The same picture gives the
same bytes.
"""

from __future__ import annotations

import html
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from kousoku.view.meshes import coarse, mesh_of
from kousoku.view.shapes import LIGHT, METAL, rotation, vertices_of

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from kousoku.model.numbers.real import Array
    from kousoku.view.picture import Picture
    from kousoku.view.shapes import MeshPart

SHADES = 12
"""Steps from the dark to the light side of a colour."""
LAMP = np.array([-0.4, 0.75, 0.65]) / np.linalg.norm([-0.4, 0.75, 0.65])
"""Direction toward the light: right, up, toward the viewer."""
VIEWING_DISTANCE = 4.5
"""Distance of the viewer from the middle, in radii of the scene."""
SIZE = (640, 420)
"""Width and height of a picture, in the pixels of a page."""
LARGEST_PICTURE = 460_000
"""Bytes of a picture that moves; it has as many frames as fit."""
FRAMES = 15.0
"""Frames in a second of a picture that moves, at most."""
COARSE = 8
"""Sides of a cylinder in a picture that moves, which has half as many pieces, too."""
CORNER, PIECES = 0.12, 4
"""Angle [rad] by which a path of many points may turn at one, unless it has so many between two."""
FEW_POINTS, LONGEST_PATH = 240, 4000
"""A path of no more points is drawn as it is; of a longer motion the path begins with these."""
STRIP = 400.0
"""Height below a picture for the directions x, y and z."""
STYLE = (
    ".e{fill:none;stroke:#2b3140;stroke-width:8;stroke-linecap:round;opacity:.7}"
    ".g{fill:none;stroke:#8a94a6;stroke-width:7;opacity:.35}"
    ".x{fill:none;stroke:#b02020;stroke-width:11;opacity:.85}"
    ".p{fill:none;stroke-width:16;opacity:.55;stroke-linejoin:round}"
    "text{font:130px system-ui,sans-serif;fill:#3c4555}"
    ".s{stroke:#6b7280;stroke-linecap:round}"
    "@media(prefers-color-scheme:dark){text{fill:#c3cad6}.x{stroke:#ff7a70}}"
)


@dataclass(frozen=True, slots=True)
class Stroke:
    """A line in the picture.

    Parameters
    ----------
    points : (n, 2)
        Its points.
    look : {"axis", "path", "strut", "grid"}
        What it is.
    color : int
        Place in :data:`kousoku.view.shapes.LIGHT`.
    width : float
        Of a strut, its thickness, in the units of the picture.
    depth : float
        How near it is.
    """

    points: Array
    look: str
    color: int = METAL
    width: float = 0.0
    depth: float = -np.inf


@dataclass(frozen=True, slots=True)
class Face:
    """A face in the picture.

    Parameters
    ----------
    points : (n, 2)
        Its corners.
    color, shade : int
        Place in :data:`kousoku.view.shapes.LIGHT`, and from 0, dark, to :data:`SHADES` - 1.
    edges : int
        Which of its sides are drawn.
    depth : float
        How near it is.
    """

    points: Array
    color: int
    shade: int
    edges: int
    depth: float


class Camera:
    """Camera of a picture: all that moves fits into it.

    Parameters
    ----------
    picture : Picture
        What is seen.
    size : (float, float)
        Width and height of the picture.
    margin : float
        What is left free on all sides.
    strip : float
        What is left free below for the directions of frame O.
    """

    def __init__(
        self, picture: Picture, size: tuple[float, float], margin: float, strip: float = STRIP
    ) -> None:
        azimuth, elevation = picture.view()
        east, north, up = picture.directions()
        level = np.sin(azimuth) * east - np.cos(azimuth) * north
        toward = np.cos(elevation) * level + np.sin(elevation) * up
        right = np.cos(azimuth) * east + np.sin(azimuth) * north
        self.axes = np.array([right, np.cross(toward, right), toward])
        points = _reached(picture)
        self.low, self.high = points.min(axis=0), points.max(axis=0)
        self.middle = (self.low + self.high) / 2
        self.radius = float(np.linalg.norm(points - self.middle, axis=1).max()) or 1.0
        self._distance = np.inf if picture.normal is not None else VIEWING_DISTANCE * self.radius
        self._scale, self._center = 1.0, np.zeros(2)
        self._size = np.array([size[0], size[1] - strip])
        flat, _ = self.seen(points)
        flat = (flat - self._size / 2) * [1.0, -1.0]
        least, most = flat.min(axis=0), flat.max(axis=0)
        span = np.maximum(most - least, 1e-9 * self.radius)
        self._scale = float(((self._size - 2 * margin) / span).min())
        self._center = (least + most) / 2

    def seen(self, points: Array) -> tuple[Array, Array]:
        """Points of frame O in the picture, and their depths, larger nearer to the viewer."""
        x, y, z = np.moveaxis((points - self.middle) @ self.axes.T, -1, 0)
        magnification = self._magnification(z)
        flat = np.stack([magnification * x, magnification * y], axis=-1) - self._center
        return self._size / 2 + self._scale * flat * [1.0, -1.0], z

    def _magnification(self, z: Array) -> Array:
        if np.isinf(self._distance):
            return np.ones_like(z)
        factor: Array = self._distance / np.maximum(self._distance - z, 0.05 * self._distance)
        return factor

    @property
    def scale(self) -> float:
        """Units of the picture in a unit of the scene, in the middle of the view."""
        return self._scale


def _reached(picture: Picture) -> Array:
    """Corners of boxes around the bodies over the whole motion, (n, 3) in frame O."""
    clouds = []
    rows = np.unique(np.linspace(0, len(picture.time) - 1, 60).round().astype(int))
    for k, shape in enumerate(picture.shapes.bodies):
        if not shape.parts:
            corners = np.zeros((1, 3))
        else:
            corners = np.concatenate([vertices_of(part) for part in shape.parts])
            low, high = corners.min(axis=0), corners.max(axis=0)
            corners = low + (high - low) * np.array(list(np.ndindex(2, 2, 2)))
        if k == 0:
            clouds.append(corners if shape.parts else np.zeros((0, 3)))
            continue
        for row in rows:
            clouds.append(
                corners @ rotation(picture.turn[row, k - 1]).T + picture.position[row, k - 1]
            )
    points = np.concatenate(clouds)
    return points if len(points) else np.zeros((1, 3))


def placed(picture: Picture, row: int, body: int, points: Array) -> Array:
    """Points of a body in frame O, at a row of the motion."""
    if body == 0:
        return points
    turn = rotation(picture.turn[row, body - 1])
    moved: Array = points @ turn.T + picture.position[row, body - 1]
    return moved


def drawn(picture: Picture, row: int, camera: Camera, sides: int = 0) -> list[Face | Stroke]:
    """Shapes that are seen at a row of the motion, the furthest first.

    Parameters
    ----------
    picture : Picture
        The motion.
    row : int
        Which of its rows.
    camera : Camera
        From where.
    sides : int
        Faces around cylinders; as in a page unless given.
    """
    items: list[Face | Stroke] = []
    for body, shape in enumerate(picture.shapes.bodies):
        for part in shape.parts:
            points = placed(picture, row, body, vertices_of(part, sides))
            items += _faces(part, points, camera, sides)
    items += _lines(picture, row, camera)
    return sorted(items, key=lambda item: item.depth)


def _faces(part: MeshPart, points: Array, camera: Camera, sides: int) -> Iterator[Face]:
    """Faces of a part that are seen; its vertices are in frame O."""
    mesh = mesh_of(coarse(part.mesh, sides))
    flat, near = camera.seen(points)
    for corners, edges, tone in zip(mesh.faces, mesh.edges, mesh.tones, strict=True):
        indices = list(corners)
        ring = flat[indices]
        (ax, ay), (bx, by) = ring[1] - ring[0], ring[2] - ring[0]
        if ax * by - ay * bx >= 0.0:
            continue
        vertices = points[indices]
        normal = np.cross(vertices, np.roll(vertices, -1, axis=0)).sum(axis=0)
        size = float(np.linalg.norm(normal)) or 1.0
        light = float(LAMP @ camera.axes @ normal) / size
        bright = min(1.0, max(0.0, 0.12 + 0.88 * light - 0.22 * tone))
        shade = round((SHADES - 1) * bright)
        yield Face(ring, part.color, shade, edges, float(near[indices].mean()))


def _lines(picture: Picture, row: int, camera: Camera) -> Iterator[Stroke]:
    for axis in picture.shapes.axes:
        fractions = np.array([-1.0, -0.55, -0.47, -0.39, -0.31, 0.31, 0.39, 0.47, 0.55, 1.0])
        ends = placed(picture, row, axis.body, axis.s + fractions[:, None] * axis.half)
        flat, near = camera.seen(ends)
        for k in range(0, len(fractions), 2):
            yield Stroke(flat[k : k + 2], "axis", depth=float(near[k : k + 2].mean()))
    for strut in picture.shapes.struts:
        ends = np.array(
            [
                placed(picture, row, strut.i, strut.a),
                placed(picture, row, strut.j, strut.b),
            ]
        )
        if strut.kind == "spring":
            points = _zigzag(ends, camera.axes[2], 2.2 * strut.width)
        else:
            points = ends[0] + np.linspace(0.0, 1.0, 9)[:, None] * (ends[1] - ends[0])
        flat, near = camera.seen(points)
        width = max(strut.width * camera.scale, 1.0) if strut.kind == "rod" else 14.0
        for k in range(len(points) - 1):
            depth = float(near[k : k + 2].mean())
            yield Stroke(flat[k : k + 2], "strut", METAL, width, depth)


def _zigzag(ends: Array, toward: Array, wide: float) -> Array:
    along = ends[1] - ends[0]
    across = np.cross(along, toward)
    across *= wide / (np.linalg.norm(across) or 1.0)
    points = [ends[0], ends[0] + 0.12 * along]
    points += [
        ends[0] + (0.12 + 0.76 * (k + 0.5) / 12) * along + (1 - 2 * (k % 2)) * across
        for k in range(12)
    ]
    return np.array([*points, ends[0] + 0.88 * along, ends[1]])


def paths_seen(picture: Picture, camera: Camera) -> list[Stroke]:
    """Paths of the chosen points."""
    rows, strokes = range(min(len(picture.time), LONGEST_PATH)), []
    for path in picture.paths:
        points = np.array([placed(picture, row, path.body, path.s) for row in rows])
        color = picture.shapes.bodies[path.body].color
        points = curve(points) if len(points) > FEW_POINTS else points
        strokes.append(Stroke(camera.seen(points)[0], "path", color))
    return strokes


def curve(points: Array) -> Array:
    """Curve through three points or more, of as many pieces as its corners ask for."""
    chords = np.diff(points, axis=0)
    length = np.linalg.norm(chords, axis=1)
    cosine = (chords[1:] * chords[:-1]).sum(axis=1)
    products = np.maximum(length[1:] * length[:-1], 1e-300)
    bend = np.zeros(len(points))
    bend[1:-1] = np.arccos(np.clip(cosine / products, -1.0, 1.0))
    tangent = np.zeros_like(points)
    tangent[1:-1] = 0.5 * (points[2:] - points[:-2])
    tangent[[0, -1]] = 1.5 * chords[[0, -1]] - 0.5 * chords[[1, -2]]
    curves, last, turn, skipped = [points[:1]], len(points) - 1, 0.0, 0
    for k in range(1, last + 1):
        pieces = int(np.clip(np.ceil(max(bend[k - 1], bend[k]) / CORNER), 1, PIECES))
        turn, skipped = turn + bend[k], skipped + 1
        if pieces == 1 and turn < CORNER / 2 and skipped < len(points) / FEW_POINTS and k < last:
            continue
        turn, skipped = 0.0, 0
        s = np.arange(1, pieces + 1)[:, np.newaxis] / pieces
        curves.append(
            (1 + 2 * s) * (1 - s) ** 2 * points[k - 1]
            + s * (1 - s) ** 2 * tangent[k - 1]
            + s**2 * (3 - 2 * s) * points[k]
            - s**2 * (1 - s) * tangent[k]
        )
    return np.concatenate(curves)


def grid_seen(picture: Picture, camera: Camera) -> tuple[list[Stroke], float]:
    """Floor, or the plane behind a planar mechanism, and the distance of its lines."""
    east, north, up = picture.directions()
    is_flat = picture.normal is not None
    normal, along = (-north, up) if is_flat else (up, north)
    corners = camera.low + (camera.high - camera.low) * np.array(list(np.ndindex(2, 2, 2)))
    height = float((corners @ normal).min())
    rough = camera.radius / 4
    power = 10.0 ** np.floor(np.log10(rough))
    size = float(power * max(step for step in (1, 2, 5) if step <= rough / power * (1 + 1e-9)))
    reach = size * np.ceil(1.15 * camera.radius / size)
    u, v = (size * np.round(camera.middle @ axis / size) for axis in (east, along))
    strokes = []
    for d in np.arange(-reach, reach + size / 2, size):
        for ends in (((d, -reach), (d, reach)), ((-reach, d), (reach, d))):
            points = [(u + a) * east + (v + b) * along + height * normal for a, b in ends]
            strokes.append(Stroke(camera.seen(np.array(points))[0], "grid"))
    return strokes, size


def color_of(color: int, shade: int) -> str:
    """Shade of a colour as ``#rrggbb``."""
    light = 0.52 + 0.6 * shade / (SHADES - 1)
    channels = [int(LIGHT[color][k : k + 2], 16) for k in (1, 3, 5)]
    mixed = [x * light if light <= 1 else 255 - (255 - x) * (2 - light) for x in channels]
    return "#" + "".join(f"{round(x):02x}" for x in mixed)


# ---- SVG ----------------------------------------------------------------------------------------


def still_svg(picture: Picture, time: float | None = None, size: tuple[int, int] = SIZE) -> str:
    """Moment of a picture as SVG.

    Parameters
    ----------
    picture : Picture
        The motion.
    time : float, optional [s]
        The moment; the start unless given.
    size : (int, int)
        Width and height, in the pixels of a page.
    """
    row = 0 if time is None else int(np.abs(picture.time - time).argmin())
    camera = _camera(picture, size)
    return _document(picture, camera, size, *_frame(drawn(picture, row, camera)))


def moving_svg(picture: Picture, largest: int = LARGEST_PICTURE) -> str:
    """Picture that moves by itself, and again from the start, as SVG.

    Parameters
    ----------
    picture : Picture
        The motion.
    largest : int
        Bytes at most; it has as few frames as that needs.
    """
    camera = _camera(picture, SIZE)
    duration = float(picture.time[-1] - picture.time[0]) / picture.speed
    if duration <= 0.0:
        return still_svg(picture)
    few = np.unique(np.linspace(0, len(picture.time) - 1, 8).astype(int))
    bytes_each = max(len(_frame(drawn(picture, row, camera, COARSE))[0]) for row in few) + 60
    frames = int(min(duration * FRAMES, (largest - 12_000) / bytes_each, len(picture.time)))
    rows = np.linspace(0, len(picture.time) - 1, max(frames, 2) + 1)[:-1].round().astype(int)
    step = duration / len(rows)
    groups, shades = [], set()
    for k, row in enumerate(rows):
        body, classes = _frame(drawn(picture, int(row), camera, COARSE))
        shades |= classes
        delay = f"{k * step - duration:.3f}" if k else "0"
        groups.append(
            f'<g class="f{" n" if k else ""}" style="animation-delay:{delay}s">{body}</g>'
        )
    share = 100.0 / len(rows)
    style = (
        f".f{{animation:f {duration:.3f}s step-end infinite}}.n{{visibility:hidden}}"
        f"@keyframes f{{0%{{visibility:visible}}{share:.4f}%{{visibility:hidden}}}}"
        "@media(prefers-reduced-motion:reduce){.f{animation:none}}"
    )
    return _document(picture, camera, SIZE, "\n".join(groups), shades, style=style)


def _camera(picture: Picture, size: tuple[int, int]) -> Camera:
    """Camera whose picture has ten units in a pixel: whole numbers place all well."""
    return Camera(picture, (10.0 * size[0], 10.0 * size[1]), 340.0)


def _document(
    picture: Picture,
    camera: Camera,
    size: tuple[int, int],
    body: str,
    shades: set[tuple[int, int]],
    *,
    style: str = "",
) -> str:
    grid, step = grid_seen(picture, camera)
    fills = "".join(
        f".{_class(color, shade)}{{fill:{color_of(color, shade)};stroke:{color_of(color, shade)}}}"
        for color, shade in sorted(shades)
    )
    lines = f'<path class="g" d="{"".join(_line(stroke.points) for stroke in grid)}"/>'
    for path in paths_seen(picture, camera):
        color = color_of(path.color, 8)
        lines += f'<path class="p" style="stroke:{color}" d="{_line(path.points)}"/>'
    note = f"grid {step:.3g} [{picture.unit}]"
    texts = f'<text x="820" y="{10 * size[1] - 150}">{note}</text>{_directions(camera, size)}'
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{size[0]}" height="{size[1]}"'
        f' viewBox="0 0 {10 * size[0]} {10 * size[1]}" role="img">'
        f"<title>{html.escape(picture.title)}</title>"
        f"<style>{STYLE}path{{stroke-width:5;stroke-linejoin:round}}{fills}"
        f".o{{stroke:#2b3140;stroke-width:7}}{style}</style>\n"
        f"{lines}\n{body}\n{texts}</svg>\n"
    )


def _directions(camera: Camera, size: tuple[int, int]) -> str:
    """Directions of frame O, at the lower left."""
    x, y = 400.0, 10.0 * size[1] - 380.0
    elements = []
    for k, ink in enumerate(("#d0453b", "#3d9a50", "#4a7fe0")):
        dx, dy = 280 * camera.axes[0, k], -280 * camera.axes[1, k]
        if np.hypot(dx, dy) < 30.0:
            continue
        style = f'style="fill:none;stroke:{ink};stroke-width:20"'
        elements.append(f'<path {style} d="M{x:.0f} {y:.0f}l{dx:.0f} {dy:.0f}"/>')
        at = f'x="{x + 1.35 * dx:.0f}" y="{y + 1.35 * dy + 40:.0f}"'
        elements.append(f'<text {at} style="fill:{ink};text-anchor:middle">{"xyz"[k]}</text>')
    return "".join(elements)


def _class(color: int, shade: int) -> str:
    return f"{'abcdefghijklmnop'[color]}{shade}"


def _frame(items: Sequence[Face | Stroke]) -> tuple[str, set[tuple[int, int]]]:
    """Paths that are drawn, and the shades in them; neighbours alike are one path."""
    runs: list[tuple[str, list[str]]] = []
    shades = set()

    def add(look: str, path: str) -> None:
        if runs and runs[-1][0] == look:
            runs[-1][1].append(path)
        else:
            runs.append((look, [path]))

    for item in items:
        if isinstance(item, Stroke):
            look = 'class="x"'
            if item.look == "strut":
                look = f'class="s" style="stroke-width:{item.width:.0f}"'
            add(look, _line(item.points))
            continue
        shades.add((item.color, item.shade))
        is_outlined = item.edges == (1 << len(item.points)) - 1
        look = f"{_class(item.color, item.shade)}{' o' if is_outlined else ''}"
        add(f'class="{look}"', _line(item.points) + "z")
        if item.edges and not is_outlined:
            add('class="e"', _edges(item))
    return "".join(f'<path {look} d="{"".join(paths)}"/>' for look, paths in runs), shades


def _edges(face: Face) -> str:
    """Sides of a face that are drawn."""
    count = len(face.points)
    lines = []
    for k in range(count):
        if face.edges >> k & 1:
            lines.append(_line(face.points[[k, (k + 1) % count]]))
    return "".join(lines)


def _line(points: Array) -> str:
    """Line of a path, in whole numbers from point to point."""
    rounded = np.rint(points).astype(int)
    steps = np.diff(rounded, axis=0).tolist()
    x, y = rounded[0].tolist()
    moves = "".join(_pair(dx, dy) for dx, dy in steps)
    return f"M{x} {y}l{moves.lstrip()}"


def _pair(x: int, y: int) -> str:
    return f"{'' if x < 0 else ' '}{x}{'' if y < 0 else ' '}{y}"
