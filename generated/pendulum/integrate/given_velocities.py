"""Velocities at the start where parameters of a run place bodies elsewhere than the scene does.

They are those that the scene gives, at the places and with the masses of the run: what assembly
made of them with the parameters of the scene fits there only.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from .body_tables import BACK, composed, crossed, rotated, solver_state, taken, written_state

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    import numpy.typing as npt

    from .body_tables import BodyPlaces
    from .initial import Evaluate
    from .motion import Layout

    Array = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class GivenVelocity:
    """The velocity of a body at the start, as the scene gives it.

    Parameters
    ----------
    velocity : (3,) [unit of the scene per s]
        Of the origin of its frame, frame O.
    spin : (3,) [rad/s]
        Angular velocity.
    is_in_o : bool
        Whether its components are in frame O, not in the frame of the body.
    weight : (11,) or (0,)
        Of a body that others are fixed to: mass [kg], principal moments [kg m²], and of its own
        principal frame ``origin_b`` [m] and ``axes_b``, as of :class:`.body_tables.BodyPlaces`.
        An index of the design stands in place of a number that depends on parameters.
    """

    velocity: tuple[float, ...]
    spin: tuple[float, ...]
    is_in_o: bool
    weight: tuple[int | float, ...]

    @classmethod
    def from_data(cls, data: Mapping[str, Any]) -> GivenVelocity:
        """Return what ``motion.json`` says of a body."""
        velocity, spin, weight = (tuple(data[name]) for name in ("velocity", "spin", "weight"))
        return cls(velocity, spin, data["is_in_o"], weight)

    def spin_b(self, turn: Array) -> Array:
        """Return the angular velocity in the frame of a body that Euler parameters turn."""
        spin = np.array(self.spin)
        return rotated(turn * BACK, spin) if self.is_in_o else spin


def given_start(layout: Layout, evaluate: Evaluate, y: Array) -> tuple[Array, Array]:
    """Return q and v where bodies are placed and have the velocities that the scene gives.

    The velocity of the origin of each body is as written, and so is its angular velocity, in the
    frame that it is given in. Bodies that are fixed to each other add up their momenta. All are
    projected onto the constraints once: to do it again takes away what is rounded.

    Parameters
    ----------
    layout : Layout
        What stands where, with the parameters of the run.
    evaluate : callable
        What :func:`.initial.evaluated` returns, with these parameters.
    y : array
        Where bodies are placed: q, then some v.
    """
    count = layout.sizes["q"]
    q, v = y[:count].copy(), y[count:].copy()
    written: list[Array] = []
    shared: dict[tuple[int | float, ...], list[tuple[BodyPlaces, GivenVelocity]]] = {}
    for body, given in zip(layout.bodies, layout.given, strict=True):
        written.append(np.array(given.velocity))
        if body.p:
            written.append(given.spin_b(composed(taken(body.p, q), np.array(body.axes_b))))
        if given.weight:
            shared.setdefault((*body.v, *body.omega_b), []).append((body, given))
    places, _ = written_state(layout.bodies, q, v, layout.unit)
    _, v = solver_state(layout.bodies, places, np.concatenate(written), layout.unit, (q, v))
    for members in shared.values():
        _share(members, layout.unit, q, v)
    return q, v + evaluate(q, v)["dv"]


def _share(
    members: Sequence[tuple[BodyPlaces, GivenVelocity]], unit: float, q: Array, v: Array
) -> None:
    """Write the velocity of bodies that are fixed to each other, from the sum of their momenta.

    That is the nearest to those that they have apart, weighed with masses and moments. All is
    about their common centre of mass, in their common principal frame.
    """
    carrier = members[0][0]
    turn = taken(carrier.p, q)
    mass, momentum, spin, moments = 0.0, np.zeros(3), np.zeros(3), np.zeros(3)
    for body, given in members:
        own, inertia = given.weight[0], np.array(given.weight[1:4])
        frame, origin = np.array(body.axes_b), np.array(body.origin_b)
        axes = composed(frame, np.array(given.weight[7:]) * BACK)
        center = origin - rotated(axes, np.array(given.weight[4:7]))
        omega = rotated(frame, given.spin_b(composed(turn, frame)))
        velocity = rotated(turn * BACK, unit * np.array(given.velocity))
        impulse = own * (velocity + crossed(omega, center - origin))
        mass, momentum = mass + own, momentum + impulse
        spin += crossed(center, impulse) + rotated(axes, inertia * rotated(axes * BACK, omega))
        moments += own * (center @ center - center**2) + rotated(axes, np.eye(3)) ** 2 @ inertia
    velocity = rotated(turn, momentum) / (mass or 1.0)
    omega = np.divide(spin, moments, out=np.zeros(3), where=moments > 0.0)
    for places, values in ((carrier.v, velocity), (carrier.omega_b, omega)):
        for place, value in zip(places, values.tolist(), strict=True):
            if isinstance(place, int):
                v[place] = value
