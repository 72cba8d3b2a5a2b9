"""What assembly changed: told, so that no start is moved without a word."""

from __future__ import annotations

from dataclasses import dataclass
from math import degrees
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.assembly.least import Metric
from kousoku.codegen.dynamics.assembly.pose import normalised
from kousoku.model import precise
from kousoku.model.varying import fixed_system

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.model.mechanism import MovingBody, System
    from kousoku.model.precise import Quadruple, Triple

TOLD = 1e-2
"""Notes leave out what is below this part of a scene's length or speed: "near" means that."""

KNOWN = 1e-6
"""The ledger leaves out what is below this part of them: digits that a scene leaves out."""

SHOWN = 4
"""Bodies that are named."""


@dataclass(frozen=True, slots=True)
class Change:
    """What assembly changed of a body.

    Parameters
    ----------
    body : str
        Its name.
    moved, turned : float [m], float [rad]
        Its frame.
    velocity, angular_velocity : float [m/s], float [rad/s]
        Where the scene gives one: joints and drivers say what the others have.
    parts : tuple of float
        The same four, relative to the scene's length, one radian, and the body's speed.
    """

    body: str
    moved: float
    turned: float
    velocity: float
    angular_velocity: float
    parts: tuple[float, ...]

    def note(self, metres: float, unit: str) -> str:
        """Return the line on it, in a unit of so many metres; empty of what is near."""
        texts = (
            f"moved by {self.moved / metres:.3g} {unit}",
            f"turned by {degrees(self.turned):.3g} deg",
            f"velocity by {self.velocity / metres:.3g} {unit}/s",
            f"angular velocity by {self.angular_velocity:.3g} rad/s",
        )
        told = [text for text, part in zip(texts, self.parts, strict=True) if part > TOLD]
        return f"assembly changed bodies.{self.body}: {', '.join(told)}" if told else ""

    def as_data(self) -> list[object]:
        """Return it ready for JSON."""
        return [self.body, self.moved, self.turned, self.velocity, self.angular_velocity]


def changes_of_assembly(given: System, placed: System) -> list[Change]:
    """Return what assembly changed, the body that changed most first.

    Parameters
    ----------
    given, placed : System
        Before and after.
    """
    given, placed = fixed_system(given), fixed_system(placed)
    size = Metric(given).size
    pairs = zip(given.bodies, placed.bodies, strict=True)
    found = [_change(before, after, size) for before, after in pairs]
    return sorted((one for one in found if max(one.parts) > KNOWN), key=lambda x: -max(x.parts))


def notes_of_assembly(changes: Sequence[Change], metres: float, unit: str) -> tuple[str, ...]:
    """Return notes on bodies that are not near where the scene has them, in its unit of length."""
    notes = [note for one in changes if (note := one.note(metres, unit))]
    if len(notes) > SHOWN:
        notes[SHOWN:] = [f"assembly changed {len(notes) - SHOWN} more bodies, by less"]
    return tuple(notes)


def _change(before: MovingBody, after: MovingBody, size: float) -> Change:
    """Return what of a body was changed."""
    shift = _length(precise.subtract(_origin(after), _origin(before)))
    turn = precise.compose(normalised(after.p), precise.conjugate(normalised(before.p)))
    angle = 2 * float(precise.atan2(precise.length(turn[1:]), abs(turn[0])))
    v, omega = _velocity(before), precise.triple(before.omega_b)
    spin, speed = _length(omega), _length(v)
    fastest = speed + spin * size
    change = _length(precise.subtract(_velocity(after), v)) if speed else 0.0
    turned = precise.triple(after.omega_b)
    if before.spins_in_o:
        omega, turned = (
            precise.rotate(_p(one), x) for one, x in ((before, omega), (after, turned))
        )
    spun = _length(precise.subtract(turned, omega)) if spin else 0.0
    rates = (change / fastest, spun * size / fastest) if fastest else (0.0, 0.0)
    return Change(before.name, shift, angle, change, spun, (shift / size, angle, *rates))


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
