"""The page that shows a motion: its data as JSON, its script and style as they stand beside this.

The page draws on a canvas with two dimensions: faces are sorted by their distance from the viewer
and filled one after the other. That is some two hundred lines which work in every browser, in a
frame of a notebook, on a telephone and without a graphics card; WebGL would draw more faces than
mechanisms have, allows few pictures on one page, and a library for it is twenty times as large as
the page. What the sorting asks for is done once: long solids are cut into pieces
(:mod:`kousoku.view.meshes`).
"""

from __future__ import annotations

import base64
import hashlib
import html
import json
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from kousoku.model.records.units import METRES
from kousoku.model.text import counted
from kousoku.view.meshes import mesh_of
from kousoku.view.shapes import DARK, LIGHT

if TYPE_CHECKING:
    from collections.abc import Iterable

    from kousoku.model.numbers.real import Array
    from kousoku.view.picture import Picture

FOLDER = Path(__file__).parent
LARGEST_INTEGER = 32767
"""The largest 16-bit integer: a motion is kept in parts of it."""
FEW = 12
"""Bodies whose names and axes are drawn from the start, and forces that are named by who asks."""
FEW_FORCES = 4
"""Forces that are drawn from the start when nobody names them."""


def page_of(picture: Picture) -> str:
    """Page of a picture: HTML that needs nothing beside itself."""
    script = "\n" + (FOLDER / "page.js").read_text(encoding="utf-8")
    style = (FOLDER / "page.css").read_text(encoding="utf-8")
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    values = {
        "POLICY": (
            f"default-src 'none'; script-src 'sha256-{digest}';"
            " style-src 'unsafe-inline'; img-src data:"
        ),
        "TITLE": html.escape(picture.title),
        "VERDICT": html.escape(picture.verdict),
        "STYLE": style,
        "SCENE": safe_json(data_of(picture)),
        "SCRIPT": script,
    }
    text = (FOLDER / "page.html").read_text(encoding="utf-8")
    pieces = text.split("{{")
    slots = (piece.split("}}", 1) for piece in pieces[1:])
    return pieces[0] + "".join(values[name] + after for name, after in slots)


def safe_json(data: Any) -> str:
    """JSON that may stand in a script element: no name in it can end that element."""
    text = json.dumps(data, separators=(",", ":"), ensure_ascii=False, allow_nan=False)
    for character in "<>&\u2028\u2029":
        text = text.replace(character, f"\\u{ord(character):04x}")
    return text


def data_of(picture: Picture) -> dict[str, Any]:
    """Data that the page draws, ready for JSON."""
    shapes = picture.shapes
    small = 1e-5 * shapes.size
    names = {part.mesh for body in shapes.bodies for part in body.parts}
    loaded = [k for k, mark in enumerate(shapes.joints) if mark.name in picture.force]
    motion, origin, quantum = _motion(picture)
    forces, force = _forces(picture, [shapes.joints[k].name for k in loaded])
    start = float(picture.time[0])
    steps = len(picture.time) - 1
    step = float(picture.time[-1] - start) / steps if steps else 0.0
    return {
        "name": picture.name,
        "unit": picture.unit,
        "flat": picture.normal is not None,
        "view": [round(angle, 4) for angle in picture.view()],
        "directions": [_rounded(axis, 1e-6) for axis in picture.directions()],
        "light": LIGHT,
        "dark": DARK,
        "meshes": {name: _mesh(name) for name in sorted(names)},
        "bodies": [
            {
                "name": body.name,
                "color": body.color,
                "at": _rounded(body.at, small),
                "parts": [
                    [part.mesh, part.color, _rounded(part.matrix.ravel(), small)]
                    for part in body.parts
                ],
            }
            for body in shapes.bodies
        ],
        "joints": [
            {"name": mark.name, "body": mark.j, "s": _rounded(mark.s_j, small)}
            for mark in shapes.joints
        ],
        "axes": [
            [axis.body, _rounded(axis.s, small), _rounded(axis.half, small)] for axis in shapes.axes
        ],
        "struts": [
            {
                "kind": strut.kind,
                "i": strut.i,
                "j": strut.j,
                "a": _rounded(strut.a, small),
                "b": _rounded(strut.b, small),
                "color": 1,
                "width": _number(strut.width, small),
            }
            for strut in shapes.struts
        ],
        "paths": [
            {
                "name": path.name,
                "body": path.body,
                "s": _rounded(path.s, small),
                "color": shapes.bodies[path.body].color,
            }
            for path in picture.paths
        ],
        "loads": [
            {
                "name": shapes.joints[k].name,
                "body": shapes.joints[k].j,
                "s": _rounded(shapes.joints[k].s_j, small),
            }
            for k in loaded
        ],
        "force": force,
        "forcesShown": 0 < len(loaded) <= (FEW if picture.is_chosen else FEW_FORCES),
        "names": len(shapes.bodies) <= FEW,
        "time": [start, step, steps + 1],
        "speed": picture.speed,
        "origin": origin,
        "quantum": quantum,
        "motion": motion,
        "forces": forces,
    }


def _number(value: float, least: float) -> float | int:
    """Number without the digits below the decimal place of the least that counts."""
    digits = max(0, -int(np.floor(np.log10(least)))) if least > 0.0 else 0
    rounded = round(float(value), digits) + 0.0
    return int(rounded) if rounded == int(rounded) else rounded


def _rounded(values: Iterable[float], least: float) -> list[float | int]:
    return [_number(value, least) for value in values]


def _mesh(name: str) -> dict[str, Any]:
    """Vertices, faces, and edges and tone of those faces that have some."""
    mesh = mesh_of(name)
    pairs = enumerate(zip(mesh.edges, mesh.tones, strict=True))
    return {
        "v": [_number(x, 1e-3) for vertex in mesh.vertices for x in vertex],
        "f": mesh.faces,
        "e": {k: [e, _number(tone, 1e-2)] for k, (e, tone) in pairs if e or tone},
    }


def _motion(picture: Picture) -> tuple[str, list[float], float]:
    """Places and turns of all frames in 16 bits, and the origin of the places."""
    position = picture.position
    if not position.size:
        return "", [0.0, 0.0, 0.0], 0.0
    low, high = position.min(axis=(0, 1)), position.max(axis=(0, 1))
    origin = (low + high) / 2
    quantum = float((high - low).max() / 2 / LARGEST_INTEGER)
    levels = np.rint((position - origin) / quantum) if quantum > 0.0 else 0.0 * position
    turn = np.rint(
        LARGEST_INTEGER * picture.turn / np.linalg.norm(picture.turn, axis=-1, keepdims=True)
    )
    return _packed(np.concatenate([levels, turn], axis=-1)), [*map(float, origin)], quantum


def _forces(picture: Picture, joints: list[str]) -> tuple[str, dict[str, Any]]:
    """Forces of all frames in 16 bits, and how long and large they are.

    An arrow as long as a quarter of the mechanism is a force that nineteen of twenty do not exceed.
    """
    values = np.zeros((len(picture.time), 0, 3))
    if joints:
        values = np.stack([picture.force[joint] for joint in joints], axis=1)
    largest = float(np.abs(values).max(initial=0.0))
    sizes = np.linalg.norm(values, axis=-1)
    usual = float(np.quantile(sizes, 0.95)) if sizes.size else 0.0
    metres = float(METRES[picture.unit])
    quantum = largest / LARGEST_INTEGER
    levels = np.rint(values / quantum) if quantum > 0.0 else 0.0 * values
    return _packed(levels), {
        "quantum": quantum * metres,
        "length": 0.25 * picture.shapes.size / (usual or largest or 1.0) / metres,
        "largest": 1.2 * (usual or largest) * metres,
        "unit": "N",
    }


def _packed(values: Array) -> str:
    return base64.b64encode(values.astype("<i2").tobytes()).decode()


class Animation:
    """A page that shows a motion; the last line of a notebook's cell shows it there.

    Parameters
    ----------
    picture : Picture
        What it shows.
    """

    def __init__(self, picture: Picture) -> None:
        self._picture = picture
        self._page: str | None = None

    @property
    def html(self) -> str:
        """The page."""
        if self._page is None:
            self._page = page_of(self._picture)
        return self._page

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the page to a file ``*.html``, or a picture that moves by itself to ``*.svg``.

        Raises
        ------
        SolveError
            The suffix is another one, the folder is missing, or the file cannot be written.
        """
        from kousoku.model.errors import SolveError
        from kousoku.model.files.cache import write_atomically
        from kousoku.runtime.messages import require_folder

        file = Path(path)
        match file.suffix:
            case ".html":
                text = self.html
            case ".svg":
                from kousoku.view.stills import moving_svg

                text = moving_svg(self._picture)
            case _:
                raise SolveError(f"{file}: wanted a file *.html or *.svg")
        require_folder(file)
        try:
            write_atomically(file, text.encode())
        except (OSError, ValueError) as error:  # a null character
            reason = getattr(error, "strerror", None) or error
            raise SolveError(f"{str(file)!r}: cannot be written: {reason}") from error
        return file

    def still(self, time: float | None = None) -> str:
        """Picture of one moment as SVG, made without a browser.

        Parameters
        ----------
        time : float, optional [s]
            The moment; the start unless given.

        Raises
        ------
        SolveError
            It is no number, or none of the part of the run that is shown.
        """
        from kousoku.view.picture import require_moment
        from kousoku.view.stills import still_svg

        if time is not None:
            require_moment(self._picture, time)
        return still_svg(self._picture, time)

    def __repr__(self) -> str:
        picture = self._picture
        return (
            f"<Animation of {picture.name!r}: {picture.time[0]:g} to {picture.time[-1]:g} s,"
            f" {counted(len(picture.shapes.bodies) - 1, 'body', 'bodies')}>"
        )

    def _repr_html_(self) -> str | None:
        """Page in a frame, for a notebook; nothing where only stills are wanted."""
        if os.environ.get("KOUSOKU_STILLS"):
            return None
        return (
            f'<iframe srcdoc="{html.escape(self.html)}" sandbox="allow-scripts"'
            ' style="width:100%;height:480px;border:1px solid #8884;border-radius:6px"'
            f' title="{html.escape(self._picture.title)}"></iframe>'
        )

    def _repr_svg_(self) -> str | None:
        """Still, for notebooks whose outputs are kept: ``KOUSOKU_STILLS=1``."""
        return self.still() if os.environ.get("KOUSOKU_STILLS") else None
