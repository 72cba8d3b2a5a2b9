"""The composite body of several that do not move against each other, in 50 digits, rounded once."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.recording.design import start_of
from kousoku.model import precise
from kousoku.model.digits import CONTEXT
from kousoku.model.errors import SceneError
from kousoku.model.frames import not_negative, to_vector
from kousoku.model.mass import principal, steiner
from kousoku.model.precise import IDENTITY, ZERO, High, Quadruple, Triple
from kousoku.model.traced import Traced
from kousoku.model.varying import fixed

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.model.mechanism import MovingBody, Quaternion, Vector

    Constants = tuple[tuple[str, tuple[float, ...]], ...]

#: Components below this part of what they came from are zeros that rounded positions left.
NOISE = CONTEXT.mpf(2) ** -51


@dataclass(frozen=True, slots=True)
class Seat:
    """Where the principal frame of a body is in the frame of what carries it.

    Parameters
    ----------
    carrier : int
        The body that carries it, or the ground.
    at : (3,) [m]
        Its centre of mass.
    turn : (4,)
        Euler parameters, of any length, that take its components to those of the carrier.
    """

    carrier: int
    at: Triple = ZERO
    turn: Quadruple = IDENTITY

    def point(self, s: Sequence[float]) -> Vector:
        """Return a point of the body in the frame of the carrier."""
        own = precise.triple(s)
        size = precise.length(self.at) + precise.length(own)
        return _vector(precise.add(self.at, precise.rotate(self.turn, own)), size)

    def vector(self, a: Sequence[float]) -> Vector:
        """Return the components in the frame of the carrier of a vector of the body."""
        return _vector(precise.rotate(self.turn, precise.triple(a)))

    def frame(self, axes: Sequence[float]) -> Quaternion:
        """Return Euler parameters that take components of a frame of the body to the carrier."""
        return _turn(precise.compose(self.turn, _quadruple(axes)))


def seen_from_carriers(
    constants: Constants, i: Seat, j: Seat, *, turning: bool = False
) -> Constants:
    """Return points and vectors in the frames of what carries their bodies.

    Parameters
    ----------
    constants : tuple of (str, tuple of float)
        ``s_i_b`` and ``s_j_b`` are points, what else ends in ``_i_b`` and ``_j_b`` vectors.
    i, j : Seat
        Of bodies i and j.
    turning : bool
        Whether all but points are vectors of body j.
    """

    def seen(name: str, values: tuple[float, ...]) -> tuple[float, ...]:
        if name in {"s_i_b", "s_j_b"}:
            return (i if name == "s_i_b" else j).point(values)
        if name.endswith("_i_b"):
            return i.vector(values)
        return j.vector(values) if turning or name.endswith("_j_b") else values

    return tuple((name, seen(name, values)) for name, values in constants)


def on_ground(body: MovingBody, ground: int) -> Seat:
    """Return the seat of a body that stands still."""
    r, p, _, _ = start_of(body)
    return Seat(ground, r, p)


def joined(
    bodies: Sequence[MovingBody], carrier: int, normal: int | None
) -> tuple[MovingBody, list[Seat]]:
    """Return the body that some bodies are together, and where each is in it.

    Parameters
    ----------
    bodies : sequence of MovingBody
        At their places; how they lie to each other is taken from there.
    carrier : int
        The place that the body will have.
    normal : int, optional
        The axis across a plane that all bodies are held in. Products of inertia with it do not
        count there, and the frame keeps it.

    Returns
    -------
    MovingBody
        With the name of the first, at its position and velocity.
    list of Seat
        Where the principal frame of each body is.
    """
    first = bodies[0]
    starts = [start_of(one) for one in bodies]
    r, p, speed, spin = starts[0]
    places = [precise.rotate_back(p, precise.subtract(own[0], r)) for own in starts]
    turns = [precise.compose(precise.conjugate(p), own[1]) for own in starts]
    mass, center, moments, axes = _mass_of(bodies, places, turns, normal)
    velocity = precise.rotate(p, precise.cross(spin, center))
    rounded = to_vector(moments)
    body = replace(
        first,
        mass=precise.double(mass),
        inertia=not_negative(rounded),
        r=fixed(_vector(precise.add(r, precise.rotate(p, center)), precise.length(r))),
        p=fixed(_turn(precise.compose(p, precise.conjugate(axes)))),
        v=fixed(_vector(precise.add(speed, velocity), precise.length(velocity))),
        omega_b=fixed(_vector(precise.rotate(axes, spin))),
    )
    seats = [
        Seat(
            carrier,
            precise.rotate(axes, precise.subtract(place, center)),
            precise.compose(axes, turn),
        )
        for place, turn in zip(places, turns, strict=True)
    ]
    own = seats[0]
    return replace(body, origin_b=own.point(first.origin_b), axes_b=own.frame(first.axes_b)), seats


def _mass_of(
    bodies: Sequence[MovingBody],
    places: Sequence[Triple],
    turns: Sequence[Quadruple],
    normal: int | None,
) -> tuple[High, Triple, Triple, Quadruple]:
    """Return mass, centre, principal moments, and the turn to their axes; frame of the first."""
    masses = [precise.number(one.mass) for one in bodies]
    mass = sum(masses, precise.number(0.0))
    if not mass:
        return mass, ZERO, ZERO, IDENTITY
    center = ZERO
    for own, place in zip(masses, places, strict=True):
        center = precise.add(center, precise.scale(own / mass, place))
    total = [[precise.number(0.0)] * 3 for _ in range(3)]
    for one, own, place, turn in zip(bodies, masses, places, turns, strict=True):
        moved = steiner(own, precise.subtract(place, center))
        axes = [precise.rotate(turn, precise.triple(row)) for row in AXES]
        for i in range(3):
            for j in range(3):
                turned = sum(precise.number(one.inertia[k]) * axes[k][i] * axes[k][j] for k in ALL)
                total[i][j] += turned + moved[i][j]
    try:
        moments, axes_of = principal(_without_noise(total, normal))
    except SceneError as error:
        key = f"bodies.{bodies[0].name}"
        raise SceneError(error.problems[0].problem, key=key) from None
    return mass, center, moments, axes_of


def _without_noise(tensor: Sequence[Sequence[High]], normal: int | None) -> list[list[High]]:
    """Return a tensor without products of inertia that do not count."""
    limit = NOISE * max(tensor[k][k] for k in ALL)
    return [
        [
            precise.number(0.0)
            if i != j and (normal in {i, j} or _is_noise(tensor[i][j], limit))
            else tensor[i][j]
            for j in ALL
        ]
        for i in ALL
    ]


def _is_noise(value: High, limit: High) -> bool:
    return not isinstance(value, Traced) and bool(abs(value) <= limit)


ALL = range(3)
AXES = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def _quadruple(p: Sequence[float]) -> Quadruple:
    w, x, y, z = map(precise.number, p)
    return w, x, y, z


def _vector(values: Triple, size: High = 0) -> Vector:
    x, y, z = precise.rounded(values, size, NOISE)
    return x, y, z


def _turn(p: Quadruple) -> Quaternion:
    size = precise.length(p)
    w, x, y, z = precise.rounded([component / size for component in p], 1, NOISE)
    return w, x, y, z
