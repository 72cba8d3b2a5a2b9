"""What assembly changed: told, so that no start is moved without a word."""

from __future__ import annotations

from math import degrees
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.assembly.least import Metric
from kousoku.codegen.dynamics.assembly.pose import normalised
from kousoku.model import precise
from kousoku.model.varying import fixed_system

if TYPE_CHECKING:
    from kousoku.model.mechanism import MovingBody, System
    from kousoku.model.precise import Quadruple, Triple

TOLD = 1e-2
"""Changes below this part of a scene's length or speed are what "near" means."""

SHOWN = 4
"""Bodies that are named."""


def moved_by_assembly(given: System, placed: System, unit: str) -> tuple[str, ...]:
    """Return notes on the bodies that assembly moved, and on velocities that it changed.

    Parameters
    ----------
    given, placed : System
        Before and after.
    unit : str
        The unit of lengths of the scene.

    Returns
    -------
    tuple of str
        One for each body, the one that moved furthest first. A velocity counts where the scene
        gives one: joints and drivers say what the others have.
    """
    given, placed = fixed_system(given), fixed_system(placed)
    size = Metric(given).size
    told: list[tuple[float, str]] = []
    for before, after in zip(given.bodies, placed.bodies, strict=True):
        parts = [*_places(before, after, size, given.unit, unit)]
        parts += _speeds(before, after, size, given.unit, unit)
        if parts:
            text = f"assembly changed bodies.{before.name}: {', '.join(text for _, text in parts)}"
            told.append((max(much for much, _ in parts), text))
    told.sort(key=lambda one: -one[0])
    notes = [text for _, text in told[:SHOWN]]
    if len(told) > SHOWN:
        notes.append(f"assembly changed {len(told) - SHOWN} more bodies, by less")
    return tuple(notes)


def _places(
    before: MovingBody, after: MovingBody, size: float, metres: float, unit: str
) -> list[tuple[float, str]]:
    """Return how far a body was moved and turned, in its own measure and as text."""
    shift = _length(precise.subtract(_origin(after), _origin(before)))
    turn = precise.compose(normalised(after.p), precise.conjugate(normalised(before.p)))
    angle = 2 * float(precise.atan2(precise.length(turn[1:]), abs(turn[0])))
    texts = []
    if shift > TOLD * size:
        texts.append((shift / size, f"moved by {shift / metres:.3g} {unit}"))
    if angle > TOLD:
        texts.append((angle, f"turned by {degrees(angle):.3g} deg"))
    return texts


def _speeds(
    before: MovingBody, after: MovingBody, size: float, metres: float, unit: str
) -> list[tuple[float, str]]:
    """Return how much the velocities that a scene gives for a body were changed."""
    spin = _length(precise.triple(before.omega_b))
    v, omega = _velocity(before), precise.triple(before.omega_b)
    fastest = _length(v) + spin * size
    if not fastest:
        return []
    change = _length(precise.subtract(_velocity(after), v))
    turned = precise.triple(after.omega_b)
    if before.spins_in_o:
        omega, turned = (
            precise.rotate(_p(one), x) for one, x in ((before, omega), (after, turned))
        )
    spun = _length(precise.subtract(turned, omega))
    texts = []
    if change > TOLD * fastest and _length(v):
        texts.append((change / fastest, f"velocity by {change / metres:.3g} {unit}/s"))
    if spun * size > TOLD * fastest and spin:
        texts.append((spun * size / fastest, f"angular velocity by {spun:.3g} rad/s"))
    return texts


def _p(body: MovingBody) -> Quadruple:
    return normalised(body.p)


def _origin(body: MovingBody) -> Triple:
    """Return the origin of the user's frame of a body, frame O."""
    arm = precise.rotate(_p(body), precise.triple(body.origin_b))
    return precise.add(precise.triple(body.r), arm)


def _velocity(body: MovingBody) -> Triple:
    """Return its velocity."""
    turning = precise.cross(precise.triple(body.omega_b), precise.triple(body.origin_b))
    return precise.add(precise.triple(body.v), precise.rotate(_p(body), turning))


def _length(a: Triple) -> float:
    return float(precise.length(a))
