"""Closed forms of slider-cranks and four-bars, to compare a solver with.

Both are a crank, and a second link (a *dyad*) whose end moves on a line or on a circle. Positions
are intersections, velocities and accelerations two linear equations; all with 50 digits.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from kousoku.model.linkage.input_motion import input_values
from kousoku.model.numbers.digits import CONTEXT

if TYPE_CHECKING:
    from collections.abc import Mapping

    from kousoku.model.numbers.real import Array
    from kousoku.model.records.planar import Input, Slider
    from kousoku.model.records.scene import Scene


@dataclass(frozen=True, slots=True)
class NodeMotion:
    """The motion of all nodes that move.

    Parameters
    ----------
    positions, velocities, accelerations : mapping of str to (n, 2) array
        By the node's name, in the unit of the scene and seconds, in frame O.
    """

    positions: Mapping[str, Array]
    velocities: Mapping[str, Array]
    accelerations: Mapping[str, Array]


@dataclass(frozen=True, slots=True)
class _Dyad:
    """A crank O1-O2 with a link O2-O3, where O3 is on a slider's line or on a link O4-O3."""

    drive: Input
    center: str
    pin: str
    end: str
    pivot: str = ""
    slider: Slider | None = None


def closed_form(scene: Scene, divisions: int, rows: int) -> NodeMotion | None:
    """Exact motion of a slider-crank or a four-bar, None of any other linkage.

    Parameters
    ----------
    scene : Scene
        A checked planar scene.
    divisions : int
        Steps over the whole input.
    rows : int
        Divisions 0 … rows − 1 are computed.

    References
    ----------
    Yamada and Tatsumi 1981, (30)-(32), are the slider-crank whose line passes through O1.
    """
    dyad = _recognise(scene)
    if dyad is None:
        return None
    crank, rod = (_length(scene, dyad.pin, other) for other in (dyad.center, dyad.end))
    alphas: dict[float, int] = {}  # the turns repeat their angles, bit for bit
    indices = [
        alphas.setdefault(alpha, len(alphas))
        for alpha in input_values(dyad.drive, divisions, range(rows)).tolist()
    ]
    motions = []
    side = 0
    for alpha in alphas:
        arm = crank * CONTEXT.expj(CONTEXT.mpf(alpha))
        rate, rate_dot = CONTEXT.mpf(dyad.drive.rate), CONTEXT.mpf(dyad.drive.acceleration)
        pin = (_at(scene, dyad.center) + arm, 1j * rate * arm, (1j * rate_dot - rate**2) * arm)
        ends = _intersections(scene, dyad, pin[0], rod)
        if not side:
            drawn = _at(scene, dyad.end)
            side = 1 if abs(ends[0] - drawn) <= abs(ends[1] - drawn) else -1
        end = ends[0] if side > 0 else ends[1]
        motions.append((pin, (end, *_derivatives(scene, dyad, pin, end))))
    tables: list[dict[str, Array]] = [
        {
            node: np.array([[float(m[n][d].real), float(m[n][d].imag)] for m in motions])[indices]
            for n, node in enumerate((dyad.pin, dyad.end))
        }
        for d in range(3)
    ]
    return NodeMotion(*tables)


def errors_of(scene: Scene, motion: Any) -> dict[str, float] | None:
    """Largest distances from the closed form, None where there is none."""
    exact = closed_form(scene, motion.divisions, len(motion))
    if exact is None:
        return None
    pairs: dict[str, tuple[Mapping[str, np.ndarray], Mapping[str, np.ndarray]]] = {
        "position": (motion.positions, exact.positions),
        "velocity": (motion.velocities, exact.velocities),
        "acceleration": (motion.accelerations, exact.accelerations),
    }
    return {
        name: max(float(np.hypot(*(computed[node] - expected[node]).T).max()) for node in expected)
        for name, (computed, expected) in pairs.items()
        if computed
    }


def _recognise(scene: Scene) -> _Dyad | None:
    """Dyad that a scene is, None if it is another linkage."""
    fixed = {name for name, node in scene.nodes.items() if node.fixed}
    links = {
        name: link.nodes for name, link in scene.links.items() if not fixed.issuperset(link.nodes)
    }
    inputs = list(scene.inputs.values())
    if len(inputs) != 1 or inputs[0].link not in links or scene.rigid:
        return None
    drive = inputs[0]
    center = drive.about or ""
    ends = links.pop(drive.link or "")
    pin = ends[1] if ends[0] == center else ends[0]
    if center not in fixed or pin in fixed:
        return None
    rods = [name for name, nodes in links.items() if pin in nodes]
    if len(rods) != 1:
        return None
    rod = links.pop(rods[0])
    end = rod[1] if rod[0] == pin else rod[0]
    sliders = list(scene.sliders.values())
    if not links and len(sliders) == 1 and sliders[0].node == end:
        return _Dyad(drive, center, pin, end, slider=sliders[0])
    if len(links) == 1 and not sliders:
        (levers,) = links.values()
        pivot = levers[1] if levers[0] == end else levers[0]
        if end in levers and end not in fixed and pivot in fixed:
            return _Dyad(drive, center, pin, end, pivot=pivot)
    return None


def _at(scene: Scene, node: str) -> Any:
    """Position as a complex number, x + i y."""
    return CONTEXT.mpc(*scene.nodes[node].at)


def _length(scene: Scene, first: str, second: str) -> Any:
    link = next(
        name for name, record in scene.links.items() if set(record.nodes) == {first, second}
    )
    return CONTEXT.mpf(scene.length(link))


def _line(slider: Slider) -> tuple[Any, Any]:
    """Point of a line, and its direction with length 1."""
    direction = CONTEXT.mpc(*slider.direction)
    return CONTEXT.mpc(*slider.through), direction / abs(direction)


def _intersections(scene: Scene, dyad: _Dyad, pin: Any, rod: Any) -> tuple[Any, Any]:
    """Intersections: two places where the end of the rod can be."""
    if dyad.slider is not None:
        point, along = _line(dyad.slider)
        local = (pin - point) / along
        half = CONTEXT.sqrt(rod**2 - local.imag**2)
        return point + along * (local.real + half), point + along * (local.real - half)
    lever = _length(scene, dyad.end, dyad.pivot)
    offset = _at(scene, dyad.pivot) - pin
    foot = (rod**2 - lever**2 + abs(offset) ** 2) / (2 * abs(offset))
    height = CONTEXT.sqrt(rod**2 - foot**2)
    unit = offset / abs(offset)
    return pin + unit * (foot + 1j * height), pin + unit * (foot - 1j * height)


def _derivatives(scene: Scene, dyad: _Dyad, pin: tuple[Any, Any, Any], end: Any) -> tuple[Any, Any]:
    """Velocity and acceleration of the end: the rod keeps its length, the end its path."""
    rod = end - pin[0]
    if dyad.slider is not None:
        normal, bends = 1j * _line(dyad.slider)[1], 0
    else:
        normal, bends = end - _at(scene, dyad.pivot), 1
    velocity = _solve(rod, normal, _dot(rod, pin[1]), CONTEXT.mpf(0))
    turning = _dot(rod, pin[2]) - abs(velocity - pin[1]) ** 2
    return velocity, _solve(rod, normal, turning, -bends * abs(velocity) ** 2)


def _dot(a: Any, b: Any) -> Any:
    return a.real * b.real + a.imag * b.imag


def _solve(a: Any, b: Any, p: Any, q: Any) -> Any:
    """Vector x with a · x = p and b · x = q."""
    determinant = a.real * b.imag - a.imag * b.real
    return CONTEXT.mpc(p * b.imag - q * a.imag, q * a.real - p * b.real) / determinant
